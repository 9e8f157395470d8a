//! Re-meshing (thesis 7.3 c, 7.4 v and vi): masses inserted and removed where a sheet folds.

use glam::DVec3;

use crate::bench::thesis::experiment::Experiment;
use crate::bench::thesis::picture::Strip;
use crate::bench::thesis::{Finding, Row, Verdict};

pub(crate) const FOLD: Row = Row {
    name: "7.4v-remeshing",
    title: "7.3 c, 7.4 v: masses inserted and removed where a sheet folds",
    says: "Recommended for future work: a re-meshing algorithm that inserts or removes masses and springs in areas \
           of much interaction.",
    here: "Scene pressed_fold, with its mesh refined by the angle of the fold; with sheets.0.refine=none; and \
           everywhere as fine, sheets.0.grid=(65,1,13).",
    run: || {
        let fixed = ("sheets.0.refine", "none");
        let mut lines = Vec::new();
        let mut found = Vec::new();
        let mut prints = Vec::new();
        for (name, overrides) in [
            ("unrefined", &[fixed][..]),
            ("refined", &[]),
            ("fine everywhere", &[fixed, ("sheets.0.grid", "(65, 1, 13)")]),
        ] {
            let mut run = Experiment::new("pressed_fold", overrides)?;
            // The boards are closed from 0.6 to 1 s.
            run.run_to(0.95);
            run.print_as(name);
            prints.append(&mut run.strip("").prints);
            let sheet = run.sheet();
            let (energy, nodes) = (sheet.energy(DVec3::ZERO).elastic, sheet.node_count());
            let apex = sheet.state.x.bounds().map_or(f64::NAN, |b| b.1.x);
            lines.push(format!("{name} {nodes} masses, {:.3} mJ, apex at {:.2} mm", 1e3 * energy, 1e3 * apex));
            found.push((energy, apex, nodes));
        }
        let mut run = Experiment::new("pressed_fold", &[])?;
        let mut most = 0;
        run.run_watching(2.0, |world| most = most.max(world.sheets()[0].node_count()));
        let (first, last) = (run.first().node_count(), run.sheet().node_count());
        lines.push(format!("opened again: {first} masses, {most} at most, {last} at the end"));
        let [coarse, refined, fine] = [0, 1, 2].map(|i| found[i]);
        let off = |(energy, ..): (f64, f64, usize)| (energy / fine.0 - 1.0).abs();
        let holds = off(refined) < 0.1 * off(coarse) && 2 * refined.2 < fine.2 && last == first;
        lines.push(format!(
            "elastic energy {:.1} % from that of the fine mesh instead of {:.1} %",
            1e2 * off(refined),
            1e2 * off(coarse)
        ));
        let reason = "the refined mesh is not ten times as close to the fine one";
        let caption = "A pressed fold: unrefined, refined where it bends, and fine everywhere".to_owned();
        Ok(Finding::new(lines.join("; "), Verdict::proposal(holds, reason)).with(Strip { caption, prints }))
    },
};
