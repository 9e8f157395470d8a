//! Real sheets dropped from a metre (thesis 5.2.3, figures 5.2 to 5.6), with the moduli of their
//! materials.

use std::path::{Path, PathBuf};

use sheetwork::InputError;

use crate::bench::thesis::experiment::{Experiment, rest};
use crate::bench::thesis::measures::{heights, probe, sharpest_bend};
use crate::bench::thesis::{Finding, Row, Verdict, picture};

/// Height of the wedge and of the cube, m.
const TOP: f64 = 0.16;

/// Why a level sheet does not bend in its fall.
const LEVEL: &str = "the shape on the wedge is the one described, but the sheet stays level in its fall: the air model has \
                     the same drag on every element of a level sheet, while the pressure of a real flow falls towards the \
                     edges and bends them up";

/// A drop: bend in the fall, and shape at rest.
struct Fall {
    run: Experiment,
    /// Largest height of the edge over the centre in the air, m; positive when the edges bend up.
    in_air: f64,
    /// Lowest position of the edge below the centre after the impact, m.
    lowest: f64,
}

impl Fall {
    fn new(scene: &str) -> Result<Self, InputError> {
        let mut run = Experiment::new(scene, &[])?;
        let (mut in_air, mut lowest) = (0.0_f64, 0.0_f64);
        for time in [0.59, 0.62, 0.65, 0.8, 1.5, 5.0] {
            run.run_watching(time, |world| {
                let sheet = &world.sheets()[0];
                let rise = probe(sheet, "edge").y - probe(sheet, "centre").y;
                if world.events().is_empty() { in_air = in_air.max(rise) } else { lowest = lowest.min(rise) }
            });
            run.print();
        }
        Ok(Self { run, in_air, lowest })
    }

    /// Height of the edge over the centre at the end, m.
    fn edge(&self) -> f64 {
        let sheet = self.run.sheet();
        0.5 * (probe(sheet, "edge").y + probe(sheet, "corner").y) - probe(sheet, "centre").y
    }

    fn text(&self) -> String {
        let (low, _) = heights(self.run.sheet());
        format!(
            "edges {:.0} mm above the centre in the fall; {}: edges {:.0} mm below the centre (at most {:.0} mm at the \
             impact), lowest node {:.0} mm over the floor, sharpest radius {:.0} mm; {:.2} s CPU for {:.1} s",
            1e3 * self.in_air,
            rest(&self.run),
            -1e3 * self.edge(),
            -1e3 * self.lowest,
            1e3 * low,
            1e3 / sharpest_bend(self.run.sheet()),
            self.run.cpu,
            self.run.world.time()
        )
    }

    fn finish(mut self, holds: bool, reason: &str, caption: &str) -> Finding {
        let text = self.text();
        Finding::new(text, Verdict::of(holds, reason)).with(self.run.strip(caption))
    }
}

/// Real drops that the study shows beside its tests (thesis figures 6.2 to 6.4): test, scene, and
/// what falls.
pub const REFERENCES: [(&str, &str, &str); 3] = [
    ("cube", "drop_styrene_05_cube", "Styrene of 0.5 mm falls on a cube"),
    ("wedge1", "drop_packaging_pvc_wedge", "Packaging PVC falls on a wedge"),
    ("wedge2", "drop_styrene_025_wedge", "Styrene of 0.25 mm falls on a wedge"),
];

/// Draws the real drops of the study as `TEST.png` in `folder`; returns the files.
///
/// # Errors
/// A scene that cannot be loaded, and a file that cannot be written.
pub fn draw_references(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    std::fs::create_dir_all(folder).map_err(|e| InputError::io(folder, &e))?;
    let draw = |(test, scene, caption): &(&str, &str, &str)| {
        let file = folder.join(format!("{test}.png"));
        picture::png(&file, &Fall::new(scene)?.run.strip(caption))?;
        Ok(file)
    };
    REFERENCES.iter().map(draw).collect()
}

pub(crate) const THIN_STYRENE: Row = Row {
    name: "figure-5.2",
    title: "Figure 5.2: styrene of 0.25 mm on a wedge",
    says: "The air bends the sheet in its fall; it gives way freely over the ridge and comes to rest on the wedge.",
    here: "Scene drop_styrene_025_wedge.",
    run: || {
        let fall = Fall::new("drop_styrene_025_wedge")?;
        let holds = fall.in_air > 2e-3 && fall.edge() < -0.1;
        Ok(fall.finish(holds, LEVEL, "Styrene of 0.25 mm on a wedge"))
    },
};

pub(crate) const THICK_STYRENE: Row = Row {
    name: "figure-5.3",
    title: "Figure 5.3: styrene of 0.5 mm on a wedge",
    says: "The thicker sheet resists the air, bends over the ridge in a wider curve, and straightens when it has \
           come to rest.",
    here: "Scene drop_styrene_05_wedge.",
    run: || {
        let (thin, thick) = (Fall::new("drop_styrene_025_wedge")?, Fall::new("drop_styrene_05_wedge")?);
        let wider = sharpest_bend(thick.run.sheet()) < 0.8 * sharpest_bend(thin.run.sheet());
        let straightens = thick.edge() > 0.9 * thick.lowest && thick.edge() > 0.6 * thin.edge();
        let holds =
            thin.in_air > 2e-3 && thick.in_air < 0.5 * thin.in_air && wider && straightens && thick.run.is_sound();
        let reason =
            "the curve is wider and it straightens, but it still rocks at the end, and this air bends neither sheet";
        Ok(thick.finish(holds, reason, "Styrene of 0.5 mm on a wedge"))
    },
};

pub(crate) const PACKAGING: Row = Row {
    name: "figure-5.4",
    title: "Figure 5.4: packaging PVC on a wedge",
    says: "Thin and light: the air bends its edges upwards; it lies over the ridge with little curvature left.",
    here: "Scene drop_packaging_pvc_wedge.",
    run: || {
        let (thick, film) = (Fall::new("drop_styrene_05_wedge")?, Fall::new("drop_packaging_pvc_wedge")?);
        let holds = film.in_air > 5e-3
            && film.in_air > 4.0 * thick.in_air
            && sharpest_bend(film.run.sheet()) > 2.0 * sharpest_bend(thick.run.sheet());
        Ok(film.finish(holds, LEVEL, "Packaging PVC on a wedge"))
    },
};

pub(crate) const SOFT_PVC: Row = Row {
    name: "figure-5.5",
    title: "Figure 5.5: PVC of 0.4 mm on a wedge",
    says: "Denser than styrene and without much bending stiffness: little affected by the air, it drapes freely and \
           does not straighten.",
    here: "Scene drop_soft_pvc_wedge, with plasticised PVC.",
    run: || {
        let fall = Fall::new("drop_soft_pvc_wedge")?;
        // The faces of the wedge are 58° steep: a sheet on them ends on the floor.
        let holds = fall.in_air < 5e-3 && heights(fall.run.sheet()).0 < 5e-3 && fall.edge() < -0.9 * TOP;
        Ok(fall.finish(holds, "it does not drape to the floor", "Soft PVC of 0.4 mm on a wedge"))
    },
};

pub(crate) const CUBE: Row = Row {
    name: "figure-5.6",
    title: "Figure 5.6: styrene of 0.5 mm on a cube",
    says: "It wraps over the cube at the impact; at rest it arches, and only the edges of the top touch it.",
    here: "Scene drop_styrene_05_cube.",
    run: || {
        let fall = Fall::new("drop_styrene_05_cube")?;
        let arch = probe(fall.run.sheet(), "centre").y - TOP;
        let holds = fall.lowest < 1.5 * fall.edge() && arch > 1e-3;
        let mut found = fall.finish(holds, "it does not arch over the top", "Styrene of 0.5 mm on a cube");
        found.measured = format!("arch of {:.1} mm over the top at rest; {}", 1e3 * arch, found.measured);
        Ok(found)
    },
};
