//! Where a sheet has opened: cells that were stretched or heated beyond what the material bears.
//!
//! After every step each closed cell is looked at. Its strain is that of its mid-surface: with a and b the mean derivatives of the place
//! along u and v over the cell (from its four masses, per length at rest), the largest principal stretch λ is the root of the larger
//! eigenvalue of [a·a, a·b; a·b, b·b], and the strain λ/(1 + α (T - 20 °C)) - 1. Its temperature is the mean of its masses'. Of several
//! layers the lowest is looked at, with the temperatures of all masses over the cell's corners and its middle.
//!
//! A cell hotter than `melts_at` opens. Of those strained by more than `tears_at` one opens in a step that is the worst of the sheet, and
//! at each end of what is open already the worst of its neighbourhood: neighbours then take up its load, and the next step shows
//! whether they bear it. So a tear begins in one place and runs from there, by a cell a step, and its way does not depend on what other
//! tears do.
//!
//! What opens stops pulling (its stored energy is given up, never more taken up), is no longer touched, drawn, blown at, heated, nor does
//! heat go through it. A mass keeps its mass as long as one of its cells is closed. One with none left is gone: it is held, is not part
//! of the energy, and goes along with the nearest mass that is left, so that it is nowhere by itself.

use glam::DVec3;
use serde::Serialize;

use super::Sheet;
use super::slits::Slit;
use crate::element::flexion_limit::FlexionLimit;
use crate::element::opening::Open;
use crate::heat::REFERENCE;
use crate::kept::{Cut, Keeper, Taken, Taker};
use crate::lattice::Layer;

/// Room (relative) in which strains are alike.
const ALIKE: f64 = 1e-9;

/// The first opening of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Opening {
    /// Where, m.
    pub place_m: [f64; 3],
    /// Strain of the cell, the largest principal one of its mid-surface.
    pub strain: f64,
    /// Its temperature, °C; none of a sheet that nothing heats.
    pub temperature_c: Option<f64>,
    /// Whether it melted; it tore otherwise.
    pub melted: bool,
}

/// What a sheet that can open holds beyond its elements.
pub(crate) struct Tears {
    open: Open,
    /// Of each mass, whether no closed cell is around it.
    gone: Vec<bool>,
    /// Where masses were when they went, m: the potential energy that they have kept. Empty as long as all is closed.
    left_at: Vec<DVec3>,
    /// Masses that are gone and no pin holds, with the mass that each goes along with.
    loose: Vec<(u32, u32)>,
    /// Strain of each cell over its limit, and whether it opens; room.
    over: Vec<f64>,
    opens: Vec<u32>,
    /// Stiffness per unit of every spring of the whole sheet.
    springs: Vec<f64>,
    /// Counts changes of what is open.
    revision: u64,
    /// Energy that opening has taken out of the motion, J.
    released: f64,
    /// Whether a first opening has been told of.
    told: bool,
    /// Whether cells open while it runs.
    runs: bool,
    /// Cells that are open from the start; empty for none.
    slit: Vec<bool>,
}

/// The strain and the temperature of a cell.
struct State {
    strain: f64,
    celsius: Option<f64>,
}

impl Tears {
    /// For `sheet`, all of it closed; `runs`, cells may open while it runs.
    pub fn new(sheet: &Sheet, runs: bool) -> Self {
        let bottom = sheet.layers.first().copied().unwrap_or_default();
        let open = Open::none(bottom.nx as usize, bottom.nz as usize);
        Self {
            over: vec![0.0; open.cells().len()],
            opens: Vec::with_capacity(open.cells().len()),
            open,
            gone: vec![false; sheet.masses()],
            left_at: Vec::new(),
            loose: Vec::new(),
            springs: sheet.stiffness_per_unit.clone(),
            revision: 0,
            released: 0.0,
            told: false,
            runs,
            slit: Vec::new(),
        }
    }
}

impl Tears {
    /// Of each cell, whether it is open.
    pub fn cells(&self) -> &[bool] {
        self.open.cells()
    }

    /// Keeps for a snapshot what does not follow from which cells are open.
    pub fn keep(&self, to: &mut Keeper) {
        to.flag(self.told);
        to.number(self.released);
        to.count(self.loose.len() as u64);
        for (mass, with) in &self.loose {
            to.count(u64::from(*mass));
            to.count(u64::from(*with));
        }
        for (i, place) in self.left_at.iter().enumerate().filter(|(i, _)| self.gone[*i]) {
            to.count(i as u64);
            to.vector(*place);
        }
    }

    /// Takes it back, once the same cells are open.
    pub fn take(&mut self, from: &mut Taker) -> Taken {
        self.told = from.flag()?;
        self.released = from.number()?;
        let masses = self.gone.len();
        self.loose.clear();
        for _ in 0..from.length(2)? {
            self.loose.push((from.index(masses)?, from.index(masses)?));
        }
        for i in 0..self.left_at.len() {
            if self.gone[i] {
                if from.count()? != i as u64 {
                    return Err(Cut);
                }
                self.left_at[i] = from.vector()?;
            }
        }
        Ok(())
    }
}

/// Masses of the corners of cell `c` of the lowest layer: (0, 0), (1, 0), (0, 1), (1, 1).
fn corners(layer: &Layer, c: usize) -> [usize; 4] {
    let across = layer.nx as usize - 1;
    let (i, j) = ((c % across) as u32, (c / across) as u32);
    [layer.at(i, j), layer.at(i + 1, j), layer.at(i, j + 1), layer.at(i + 1, j + 1)].map(|m| m as usize)
}

impl Sheet {
    /// Whether cells of it can open.
    pub fn can_open(&self) -> bool {
        self.tears.is_some()
    }

    /// Of each cell of the lowest layer, side by side along its length and then along its width, whether it is open; none of a sheet
    /// that cannot open.
    pub fn open_cells(&self) -> Option<&[bool]> {
        self.tears.as_ref().map(|t| t.open.cells())
    }

    /// How many cells are open.
    pub fn open_count(&self) -> usize {
        self.tears.as_ref().map_or(0, |t| t.open.count())
    }

    /// Counts the changes of what is open: whoever draws the sheet makes its triangles anew when it has changed.
    pub fn opening_revision(&self) -> u64 {
        self.tears.as_ref().map_or(0, |t| t.revision)
    }

    /// Energy that opening has taken out of the motion so far, J: what was stored in the cells, and what masses had that are gone.
    pub fn energy_released(&self) -> f64 {
        self.tears.as_ref().map_or(0.0, |t| t.released)
    }

    /// Whether mass `i` has no closed cell left.
    pub fn is_gone(&self, i: usize) -> bool {
        self.tears.as_ref().is_some_and(|t| t.gone[i])
    }

    /// Where mass `i` was when it went, m; none of one that is there.
    pub(super) fn left_at(&self, i: usize) -> Option<DVec3> {
        self.tears.as_ref().filter(|t| t.gone[i]).map(|t| t.left_at[i])
    }

    /// What is open, of a sheet that is not whole.
    pub(crate) fn opened(&self) -> Option<&Open> {
        self.tears.as_ref().map(|t| &t.open).filter(|o| !o.is_whole())
    }

    /// Place of mass `i` in cells of the lowest layer, (u, v).
    pub(crate) fn in_cells(&self, i: u32) -> (f64, f64) {
        let (columns, rows) = self.tears.as_ref().map_or((0, 0), |t| t.open.size());
        let (u, v) = self.uv[i as usize];
        (u * columns as f64, v * rows as f64)
    }

    /// The triangles of a layer that are left of `triangles`.
    pub(crate) fn closed_triangles(&self, mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        if let Some(open) = self.opened() {
            triangles.retain(|t| {
                let at = t.map(|m| self.in_cells(m));
                let (u, v) = ((at[0].0 + at[1].0 + at[2].0) / 3.0, (at[0].1 + at[1].1 + at[2].1) / 3.0);
                open.is_closed_at(u, v) && !t.iter().any(|m| self.is_gone(*m as usize))
            });
        }
        triangles
    }

    /// Whether what is closed is nowhere longer than `most` (m): pieces of a torn sheet may part.
    pub(crate) fn holds_together(&self, most: f64) -> bool {
        let (Some(open), Some(layer)) = (self.opened(), self.layers.first()) else { return true };
        let closed = open.cells().iter().enumerate().filter(|c| !c.1);
        let mut sound = (0..self.masses()).all(|i| self.x.get(i).is_finite());
        for (c, _) in closed {
            let [a, b, d, e] = corners(layer, c).map(|m| self.x.get(m));
            sound &= a.distance_squared(e) < most * most && b.distance_squared(d) < most * most;
        }
        sound
    }

    /// Looks whether cells open, after a step; the first opening, the first time that one does.
    pub(crate) fn tear(&mut self) -> Option<Opening> {
        let mut tears = self.tears.take()?;
        tears.opens.clear();
        let worst = if tears.runs { self.look(&mut tears) } else { None };
        if tears.opens.is_empty() {
            self.tears = Some(tears);
            self.carry();
            return None;
        }
        let told = std::mem::replace(&mut tears.told, true);
        let first = (!told).then(|| self.opening(worst.unwrap_or(tears.opens[0] as usize)));
        for k in 0..tears.opens.len() {
            tears.open.set(tears.opens[k] as usize);
        }
        self.tears = Some(tears);
        self.take_openings();
        self.carry();
        first
    }

    /// Finds which cells open; returns that which is worst.
    fn look(&self, tears: &mut Tears) -> Option<usize> {
        let (melts_at, tears_at) = (self.material.melts_at, self.material.tears_at);
        let (mut worst, mut most, mut melted) = (None, 1.0, None);
        for c in 0..tears.over.len() {
            tears.over[c] = 0.0;
            if tears.open.cells()[c] {
                continue;
            }
            let state = self.state_of(c);
            if melts_at.zip(state.celsius).is_some_and(|(limit, t)| t > limit) {
                tears.opens.push(c as u32);
                melted.get_or_insert(c);
                continue;
            }
            // One that is no number is none that tears: the sheet is found unstable.
            let over = tears_at.map_or(0.0, |limit| state.strain / limit);
            tears.over[c] = over;
            if over > most * (1.0 + ALIKE) {
                (worst, most) = (Some(c), over);
            }
        }
        if worst.is_some() {
            for c in 0..tears.over.len() {
                if tears.over[c] > 1.0 && (Some(c) == worst || leads(tears, c)) {
                    tears.opens.push(c as u32);
                }
            }
            tears.opens.sort_unstable();
        }
        worst.or(melted)
    }

    fn state_of(&self, c: usize) -> State {
        let Some(layer) = self.layers.first() else { return State { strain: 0.0, celsius: None } };
        let m = corners(layer, c);
        let celsius = self.temperatures().map(|t| self.cell_temperature(t, m, c));
        let [p, q, r, s] = m.map(|m| self.x.get(m));
        let half = (0.5 * f64::from(layer.nx - 1) / self.extent.0, 0.5 * f64::from(layer.nz - 1) / self.extent.1);
        let (a, b) = ((q - p + s - r) * half.0, (r - p + s - q) * half.1);
        let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
        let square = 0.5 * (aa + bb + ((aa - bb).powi(2) + 4.0 * ab * ab).sqrt());
        let grown = 1.0 + celsius.map_or(0.0, |t| self.material.expansion * (t - REFERENCE));
        State { strain: square.sqrt() / grown - 1.0, celsius }
    }

    /// Mean temperature of the masses of cell `c`, °C, whose corners in the lowest layer are `m`.
    fn cell_temperature(&self, celsius: &[f64], m: [usize; 4], c: usize) -> f64 {
        let (mut sum, mut count) = (m.iter().map(|m| celsius[*m]).sum::<f64>(), 4.0);
        let Some(bottom) = self.layers.first().filter(|_| self.layers.len() > 1) else { return sum / count };
        let across = bottom.nx - 1;
        let (i, j) = (c as u32 % across, c as u32 / across);
        for layer in &self.layers[1..] {
            if layer.nx == bottom.nx {
                let over = [layer.at(i, j), layer.at(i + 1, j), layer.at(i, j + 1), layer.at(i + 1, j + 1)];
                sum += over.iter().map(|m| celsius[*m as usize]).sum::<f64>();
                count += 4.0;
            } else {
                sum += celsius[layer.at(i, j) as usize];
                count += 1.0;
            }
        }
        sum / count
    }

    /// What there is to tell of the opening of cell `c`.
    fn opening(&self, c: usize) -> Opening {
        let state = self.state_of(c);
        let middle = self
            .layers
            .first()
            .map_or(DVec3::ZERO, |layer| corners(layer, c).iter().map(|m| self.x.get(*m)).sum::<DVec3>() / 4.0);
        let melted = self.material.melts_at.zip(state.celsius).is_some_and(|(limit, t)| t > limit);
        Opening { place_m: middle.to_array(), strain: state.strain, temperature_c: state.celsius, melted }
    }

    /// Opens the cells along `slits`, from now on and for good.
    pub(super) fn slit(&mut self, slits: &[Slit]) {
        let cells = self.slit_cells(slits);
        if let Some(tears) = self.tears.as_mut().filter(|_| !slits.is_empty()) {
            tears.slit = cells;
            self.set_open(&[]);
        }
    }

    /// Of each cell, whether it has opened since the start; empty of a sheet that cannot open.
    pub(super) fn torn_cells(&self) -> Vec<bool> {
        let Some(tears) = &self.tears else { return Vec::new() };
        let slit = tears.slit.iter().copied().chain(std::iter::repeat(false));
        tears.open.cells().iter().zip(slit).map(|(open, slit)| *open && !slit).collect()
    }

    /// Opens the cells of `torn` (none of an empty one) and the slits, and no others: to go back to another time.
    pub(crate) fn set_open(&mut self, torn: &[bool]) {
        let Some(tears) = self.tears.as_mut() else { return };
        let of = |list: &[bool], c: usize| list.get(c).copied().unwrap_or(false);
        let cells: Vec<bool> = (0..tears.open.cells().len()).map(|c| of(torn, c) || of(&tears.slit, c)).collect();
        if tears.open.cells() == cells {
            return;
        }
        tears.open.set_all(&cells);
        tears.told = torn.contains(&true);
        self.take_openings();
    }

    /// Lets everything follow what is open now.
    fn take_openings(&mut self) {
        let before = self.energy(DVec3::ZERO).total;
        let Some(mut tears) = self.tears.take() else { return };
        tears.revision += 1;
        tears.left_at.resize(tears.gone.len(), DVec3::ZERO);
        for i in 0..tears.gone.len() {
            let at = self.cells_at(&tears.open, i as u32);
            let was = std::mem::replace(&mut tears.gone[i], tears.open.is_gone(at));
            if tears.gone[i] && !was {
                tears.left_at[i] = self.x.get(i);
            }
        }
        for i in 0..self.springs.len() {
            let (a, b) = (self.springs.a[i], self.springs.b[i]);
            let cut = tears.open.cuts(self.cells_at(&tears.open, a), self.cells_at(&tears.open, b))
                || tears.gone[a as usize]
                || tears.gone[b as usize];
            self.stiffness_per_unit[i] = if cut { 0.0 } else { tears.springs[i] };
        }
        self.elements.iter_mut().for_each(|e| e.open(&tears.open, &tears.gone));
        self.hold_gone(&mut tears);
        let triangles = self.layers.iter().flat_map(Layer::triangles).collect();
        self.tears = Some(tears);
        self.drag.set_triangles(self.closed_triangles(triangles));
        self.open_contact();
        if let Some(heat) = &mut self.heat {
            heat.forget_body();
        }
        self.refresh();
        // The scheme's accelerations are of forces that are no more.
        self.restart_engine();
        self.forget_system();
        let after = self.energy(DVec3::ZERO).total;
        if let Some(tears) = &mut self.tears {
            tears.released += before - after;
        }
    }

    fn cells_at(&self, open: &Open, i: u32) -> (f64, f64) {
        let ((columns, rows), (u, v)) = (open.size(), self.uv[i as usize]);
        (u * columns as f64, v * rows as f64)
    }

    /// Holds masses that are gone, lets go of their glue, and finds what they go along with.
    fn hold_gone(&mut self, tears: &mut Tears) {
        let mut pinned = vec![false; self.masses()];
        self.pins.masses().for_each(|m| pinned[m as usize] = true);
        tears.loose.clear();
        self.pins.set_gone(&tears.gone);
        for i in 0..self.masses() {
            self.inverse_mass[i] = if pinned[i] || tears.gone[i] { 0.0 } else { 1.0 / self.mass[i] };
            if tears.gone[i] && !pinned[i] {
                let here = self.uv[i];
                let apart = |k: &usize| {
                    let (u, v) = self.uv[*k];
                    ((u - here.0) * self.extent.0).hypot((v - here.1) * self.extent.1)
                };
                let left = (0..self.masses()).filter(|k| !tears.gone[*k]);
                let nearest = left.min_by(|a, b| apart(a).total_cmp(&apart(b)));
                tears.loose.push((i as u32, nearest.unwrap_or(i) as u32));
            }
        }
    }

    /// Takes masses that are gone along with others.
    fn carry(&mut self) {
        let Some(tears) = self.tears.as_ref().filter(|t| !t.loose.is_empty()) else { return };
        for (mass, with) in &tears.loose {
            let (mass, with) = (*mass as usize, *with as usize);
            self.x.set(mass, self.x.get(with));
            self.v.set(mass, if mass == with { DVec3::ZERO } else { self.v.get(with) });
        }
    }

    /// Lets contact follow.
    fn open_contact(&mut self) {
        if let Some(mut skin) = self.work.skin.take() {
            skin.open(self);
            self.work.skin = Some(skin);
        }
        if let Some(limit) = self.flexion_limit.as_ref().map(|l| l.limit) {
            self.flexion_limit = Some(FlexionLimit { triples: self.closed_triples(), limit });
        }
        if let (Some(limit), Some(tears)) = (&mut self.thickness_limit, &self.tears) {
            limit.open(&tears.gone);
        }
    }

    /// The flexion triples of which both springs are left.
    pub(super) fn closed_triples(&self) -> Vec<[u32; 3]> {
        let mut triples = self.flexion.clone();
        if let Some(open) = self.opened() {
            triples.retain(|t| {
                let [a, b, c] = t.map(|m| self.in_cells(m));
                !open.cuts(a, b) && !open.cuts(b, c)
            });
        }
        triples
    }
}

/// Whether cell `c` is at the end of what is open, and is the worst of the cells around it.
fn leads(tears: &Tears, c: usize) -> bool {
    let columns = tears.open.size().0;
    let (i, j) = ((c % columns) as i64, (c / columns) as i64);
    let around = (-1..=1).flat_map(|dj| (-1..=1).map(move |di| (di, dj))).filter(|d| *d != (0, 0));
    let mut at_end = false;
    for n in around.filter_map(|(di, dj)| tears.open.number(i + di, j + dj)) {
        at_end |= tears.open.cells()[n];
        let (mine, other) = (tears.over[c], tears.over[n]);
        // Of cells that are strained alike the first.
        if other > mine * (1.0 + ALIKE) || (n < c && other >= mine * (1.0 - ALIKE)) {
            return false;
        }
    }
    at_end
}
