//! Interaction by hand: a spring from a point of a sheet to the mouse, and pins of single nodes.

use glam::DVec3;
use sheetwork::InputError;
use sheetwork::scene::{PinSpec, Region};
use sheetwork::sheet::{Sheet, select};

use super::Session;
use super::state::GrabHandle;

/// Force of a grab at a distance of one sheet length, in multiples of the sheet's weight.
const GRAB_STRENGTH: f64 = 30.0;
/// Stability limit of the grab's spring with an explicit integrator: k dt²/m.
const STABILITY_FRACTION: f64 = 0.2;

/// Grab of a sheet in its present state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Point of the sheet, m.
    pub point: DVec3,
    /// Target position, m.
    pub target: DVec3,
    /// Force on the sheet, N.
    pub force: DVec3,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
}

impl Session {
    /// Stiffness (N/m) of a grab of `sheet`: strong enough to move it, and within the stability
    /// limit of the integrator.
    pub fn hand_stiffness(&self, sheet: &Sheet) -> f64 {
        let (low, high) = sheet.state.x.bounds().unwrap_or((DVec3::ZERO, DVec3::ONE));
        let length = (high - low).max_element().max(1e-6);
        let weight = sheet.total_mass() * self.world.gravity().length().max(1.0);
        let wanted = (GRAB_STRENGTH * weight / length).clamp(1e-6, 1e6);
        if self.world.engine().info().implicit {
            return wanted;
        }
        let lightest = (0..sheet.node_count()).map(|i| sheet.node_mass(i)).fold(f64::INFINITY, f64::min);
        wanted.min(STABILITY_FRACTION * lightest / self.world.dt().powi(2)).max(1e-9)
    }

    /// Grab sheet `sheet` at the material point (u, v), each 0 to 1. An error becomes a message.
    /// Returns whether the grab holds.
    pub fn grab(&mut self, sheet: usize, (u, v): (f64, f64)) -> bool {
        self.release();
        if self.playback.is_some() {
            self.fail("a recording cannot be grabbed; open its scene for that");
            return false;
        }
        let Some(stiffness) = self.world.sheets().get(sheet).map(|s| self.hand_stiffness(s)) else { return false };
        let Some(held) = self.world.sheets_mut().get_mut(sheet) else { return false };
        let grabbed = held.grab((u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)), stiffness);
        let grabbed = grabbed.map(|index| GrabHandle { sheet: held.name.clone(), index });
        self.run_state.hand = self.accept(grabbed);
        self.run_state.hand.is_some()
    }

    /// Move the target of the grab, m.
    pub fn pull(&mut self, target: DVec3) {
        let Some(hand) = &self.run_state.hand else { return };
        let held = self.world.sheet_mut(&hand.sheet).is_some_and(|sheet| sheet.pull(hand.index, target).is_ok());
        if !held {
            // Other grabs were released, and the indices changed.
            self.run_state.hand = None;
        }
    }

    /// Release the grab.
    pub fn release(&mut self) {
        if let Some(hand) = self.run_state.hand.take()
            && let Some(sheet) = self.world.sheet_mut(&hand.sheet)
        {
            sheet.release_grab(hand.index);
        }
    }

    /// Present grab, if any.
    pub fn hand(&self) -> Option<Hand> {
        let holding = self.run_state.hand.as_ref()?;
        let sheet = self.world.sheet(&holding.sheet)?;
        let pull = sheet.pulls().get(holding.index)?;
        let (point, target) = (pull.point(&sheet.state.x), pull.target);
        Some(Hand { point, target, force: pull.force(&sheet.state.x), stiffness: pull.stiffness })
    }

    /// Pin node `mass` of sheet `sheet` at its present position, or unpin it; after a reset the pin
    /// is at its initial position. Returns whether the edit was accepted.
    pub fn toggle_pin(&mut self, sheet: usize, mass: u32) -> bool {
        let Some(held) = self.world.sheets().get(sheet) else { return false };
        if mass as usize >= held.node_count() {
            return false;
        }
        let is_held = held.is_held(mass as usize);
        if !is_held {
            return self.edit_sheet(sheet, &format!("pin of node {mass}"), &format!("pin {sheet} {mass}"), |spec| {
                spec.pins.push(PinSpec::fixed(Region::Masses(vec![mass])));
            });
        }
        let Some(pins) = self.accept(self.without_pin(sheet, mass)) else { return false };
        let (label, key) = (format!("unpin of node {mass}"), format!("pin {sheet} {mass}"));
        self.edit_sheet(sheet, &label, &key, |spec| spec.pins = pins)
    }

    /// Pins of sheet `sheet` without node `mass`.
    fn without_pin(&self, sheet: usize, mass: u32) -> Result<Vec<PinSpec>, InputError> {
        let (Some(spec), Some(held)) = (self.scene().sheets.get(sheet), self.world.sheets().get(sheet)) else {
            return Ok(Vec::new());
        };
        let mut pins = Vec::new();
        for pin in &spec.pins {
            let masses = select(&pin.region, held)?;
            if !masses.contains(&mass) {
                pins.push(pin.clone());
                continue;
            }
            let rest: Vec<u32> = masses.into_iter().filter(|m| *m != mass).collect();
            if !rest.is_empty() {
                pins.push(PinSpec { region: Region::Masses(rest), ..pin.clone() });
            }
        }
        Ok(pins)
    }
}
