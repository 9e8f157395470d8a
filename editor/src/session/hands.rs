//! Hands on the scene: a spring from a point of a sheet to the mouse, pins of single masses, bodies and heaters carried elsewhere.

use glam::{DQuat, DVec3};
use sheetwork::InputError;
use sheetwork::scene::{PinSpec, Placement, Region, path_at};
use sheetwork::sheet::{Sheet, select};

use super::Session;
use crate::document::change::shifted;

/// Times its own weight that a sheet is pulled with when the hand is a sheet's length away.
const STRENGTH: f64 = 30.0;
/// Largest part of what an explicit engine can bear that a hand takes: k dt²/m.
const BEARABLE: f64 = 0.2;

/// Something that can be carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// A body of the scene, by number.
    Body(usize),
    /// A heater of the scene, by number.
    Heater(usize),
    /// The nozzle of the heat gun.
    HeatGun,
}

/// What a hand holds.
#[derive(Clone, Debug)]
pub(super) struct Holding {
    sheet: String,
    index: usize,
}

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

    /// Where an item is put in the scene; none where there is no such item.
    pub fn placement_of(&self, item: Item) -> Option<Placement> {
        let scene = self.scene();
        match item {
            Item::Body(i) => scene.bodies.get(i).map(|b| b.placement),
            Item::Heater(i) => scene.heaters.get(i).map(|h| h.placement),
            Item::HeatGun => scene.heat_gun.as_ref().map(|g| Placement { position: g.position, rotation: DVec3::ZERO }),
        }
    }

    /// What an item is called.
    pub fn name_of(&self, item: Item) -> String {
        let or = |name: &str, otherwise: String| if name.is_empty() { otherwise } else { name.to_owned() };
        match item {
            Item::Body(i) => self.scene().bodies.get(i).map_or(String::new(), |b| or(&b.name, format!("body {i}"))),
            Item::Heater(i) => {
                self.scene().heaters.get(i).map_or(String::new(), |h| or(&h.name, format!("heater {i}")))
            }
            Item::HeatGun => "heat gun".to_owned(),
        }
    }

    /// Everything that can be carried.
    pub fn items(&self) -> Vec<Item> {
        let scene = self.scene();
        let bodies = (0..scene.bodies.len()).map(Item::Body);
        let heaters = (0..scene.heaters.len()).map(Item::Heater);
        bodies.chain(heaters).chain(scene.heat_gun.is_some().then_some(Item::HeatGun)).collect()
    }

    /// Where the nozzle of the heat gun is shown, m, and the unit vector that it blows along; none where there is no gun.
    pub fn gun_aim(&self) -> Option<(DVec3, DVec3)> {
        let spec = self.scene().heat_gun.as_ref()?;
        let (offset, rotation) = path_at(&spec.path, self.world.time());
        let turn = Placement { position: DVec3::ZERO, rotation }.quaternion();
        let by = self.carried.filter(|c| c.0 == Item::HeatGun).map_or(DVec3::ZERO, |c| c.1);
        Some((spec.position + offset + by, (turn * spec.direction).normalize_or(DVec3::NEG_Y)))
    }

    /// Shows `item` moved by `by` (m) from where it is put, until [`Session::put_down`]. A body that stands is moved at once where time passes, so
    /// that it pushes what it meets.
    pub fn carry(&mut self, item: Item, by: DVec3) {
        if self.playback.is_some() {
            return;
        }
        self.carried = Some((item, by));
        self.revision += 1;
        let Item::Body(index) = item else { return };
        let Some(spec) = self.scene().bodies.get(index) else { return };
        if self.playing && !spec.is_dynamic() && spec.path.is_empty() {
            let there = shifted(&spec.placement, by);
            let name = self.world.rigid().and_then(|r| r.bodies().get(index)).map(|b| b.name.clone());
            let turn: DQuat = there.quaternion();
            name.iter().for_each(|name| _ = self.world.move_body(name, there.position, turn));
        }
    }

    /// What is carried, and how far, m.
    pub fn carried(&self) -> Option<(Item, DVec3)> {
        self.carried
    }

    /// Puts down what is carried: the scene has it there now. Returns whether anything was.
    pub fn put_down(&mut self) -> bool {
        let Some((item, by)) = self.carried.take() else { return false };
        self.revision += 1;
        let Some(placement) = self.placement_of(item).filter(|_| by != DVec3::ZERO) else { return false };
        self.place(item, shifted(&placement, by))
    }

    /// Puts an item elsewhere, as an edit. Returns whether it was taken.
    pub fn place(&mut self, item: Item, placement: Placement) -> bool {
        let name = self.name_of(item);
        self.edit(&format!("move of {name}"), &format!("place {name}"), |scene| match item {
            Item::Body(i) => scene.bodies.iter_mut().skip(i).take(1).for_each(|b| b.placement = placement),
            Item::Heater(i) => scene.heaters.iter_mut().skip(i).take(1).for_each(|h| h.placement = placement),
            Item::HeatGun => scene.heat_gun.iter_mut().for_each(|g| g.position = placement.position),
        })
    }
}
