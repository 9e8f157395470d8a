//! Hands on a sheet: a spring from a point of it to the mouse, pins of single masses.

use glam::DVec3;
use sheetwork::InputError;
use sheetwork::scene::{PinSpec, Region};
use sheetwork::sheet::{Sheet, select};

use super::Session;
use super::state::Holding;

/// Times its own weight that a sheet is pulled with when the hand is a sheet's length away.
const STRENGTH: f64 = 30.0;
/// Largest part of what an explicit engine can bear that a hand takes: k dt²/m.
const BEARABLE: f64 = 0.2;

/// A hand that pulls, as it is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// The point of the sheet, m.
    pub point: DVec3,
    /// Where it pulls to, m.
    pub target: DVec3,
    /// The force that it feels, N.
    pub force: DVec3,
    /// Its spring, N/m.
    pub stiffness: f64,
}

impl Session {
    /// A spring (N/m) with which a hand pulls at `sheet` so that it follows without being torn along, and that the engine bears.
    pub fn hand_stiffness(&self, sheet: &Sheet) -> f64 {
        let (low, high) = sheet.x.bounds().unwrap_or((DVec3::ZERO, DVec3::ONE));
        let length = (high - low).max_element().max(1e-6);
        let weight = sheet.total_mass() * self.world.gravity().length().max(1.0);
        let wanted = (STRENGTH * weight / length).clamp(1e-6, 1e6);
        if self.world.engine().info().implicit {
            return wanted;
        }
        let lightest = (0..sheet.masses()).map(|i| sheet.mass(i)).fold(f64::INFINITY, f64::min);
        wanted.min(BEARABLE * lightest / self.world.dt().powi(2)).max(1e-9)
    }

    /// Takes hold of sheet `sheet` at the material point (u, v), each 0 to 1. A refusal becomes a message. Returns whether it holds.
    pub fn grab(&mut self, sheet: usize, (u, v): (f64, f64)) -> bool {
        self.release();
        if self.playback.is_some() {
            self.fail("a recording cannot be pulled at; open its scene for that");
            return false;
        }
        let Some(stiffness) = self.world.sheets().get(sheet).map(|s| self.hand_stiffness(s)) else { return false };
        let Some(held) = self.world.sheets_mut().get_mut(sheet) else { return false };
        match held.grab((u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)), stiffness) {
            Ok(index) => {
                self.hand = Some(Holding { sheet: held.name.clone(), index });
                true
            }
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// Pulls what is held towards `target`, m.
    pub fn pull(&mut self, target: DVec3) {
        let Some(hand) = &self.hand else { return };
        let held = self.world.sheet_mut(&hand.sheet).is_some_and(|sheet| sheet.pull(hand.index, target).is_ok());
        if !held {
            // Others let go of theirs, and the numbers moved up.
            self.hand = None;
        }
    }

    /// Lets go.
    pub fn release(&mut self) {
        if let Some(hand) = self.hand.take()
            && let Some(sheet) = self.world.sheet_mut(&hand.sheet)
        {
            sheet.let_go(hand.index);
        }
    }

    /// The hand, while it holds something.
    pub fn hand(&self) -> Option<Hand> {
        let holding = self.hand.as_ref()?;
        let sheet = self.world.sheet(&holding.sheet)?;
        let pull = sheet.pulls().get(holding.index)?;
        let (point, target) = (pull.point(&sheet.x), pull.target);
        Some(Hand { point, target, force: pull.force(&sheet.x), stiffness: pull.stiffness })
    }

    /// Pins mass `mass` of sheet `sheet` where it is, or lets it go; from a reset on it is held where it starts. Returns whether it was taken.
    pub fn toggle_pin(&mut self, sheet: usize, mass: u32) -> bool {
        let Some(held) = self.world.sheets().get(sheet) else { return false };
        if mass as usize >= held.masses() {
            return false;
        }
        let is_held = held.is_held(mass as usize);
        if !is_held {
            return self.edit(&format!("pin of mass {mass}"), &format!("pin {sheet} {mass}"), |scene| {
                if let Some(spec) = scene.sheets.get_mut(sheet) {
                    spec.pins.push(PinSpec::held(Region::Masses(vec![mass])));
                }
            });
        }
        match self.without_pin(sheet, mass) {
            Ok(pins) => self.edit(&format!("unpin of mass {mass}"), &format!("pin {sheet} {mass}"), |scene| {
                if let Some(spec) = scene.sheets.get_mut(sheet) {
                    spec.pins = pins;
                }
            }),
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// The pins of sheet `sheet` with `mass` in none of them.
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
