//! Records of forces of the sheets of an island ([`crate::sheet::forces`]), from the log of its
//! contact impulses.

use glam::DVec3;

use crate::collision::constraint::{ContactSide, SheetPoint};
use crate::contact::impulse_log::LoggedImpulse;
use crate::contact::workspace::ContactWorkspace;
use crate::islands::implicit_step::{IslandSolve, Substep};
use crate::islands::island_detection::DetectionCache;
use crate::islands::island_manager::IslandContext;
use crate::sheet::forces::ImpulseSample;
use crate::sheet::{ForceKind, ForcePartner, Sheet, stage};

impl IslandSolve<'_, '_, '_> {
    /// Record the change of momentum of a substep that a fallback has replaced as numerical, apart
    /// from gravity.
    pub fn record_fallback_impulses(&mut self, substep: &Substep) {
        let log = &mut self.workspace.impulses;
        log.roll_back();
        for (number, sheet) in (0..).zip(self.view.sheets.iter()).filter(|_| log.is_recording) {
            let side = ContactSide::Sheet { sheet: number, point: SheetPoint::default() };
            let before = stage::saved_momentum(sheet) + substep.field.gravity * (sheet.total_mass() * substep.dt);
            let impulse = sheet.momentum() - before;
            let places = [sheet.centre_of_mass(); 2];
            let kind = ForceKind::Numerical;
            log.list.push(LoggedImpulse { kind, sides: [side; 2], impulse, places, normal: DVec3::ZERO });
        }
    }
}

impl IslandContext<'_> {
    /// Add the logged impulses to the records of the sheets, whose indices in the world are `ids`,
    /// and note the partners of bonded nodes.
    pub fn record_impulses(
        &self,
        sheets: &mut [Sheet],
        ids: &[u32],
        workspace: &ContactWorkspace,
        work: &DetectionCache,
    ) {
        if !workspace.impulses.is_recording {
            return;
        }
        for logged in &workspace.impulses.list {
            let signs: &[f64] = if logged.kind == ForceKind::Numerical { &[1.0] } else { &[1.0, -1.0] };
            for (k, sign) in signs.iter().enumerate() {
                let ContactSide::Sheet { sheet, point } = logged.sides[k] else { continue };
                let partner = match logged.kind {
                    ForceKind::Numerical => ForcePartner::None,
                    _ => self.partner_of(&logged.sides[1 - k], sheet, ids, work),
                };
                let velocity = self.relative_velocity(logged, k, sheets, work);
                let Some(forces) = &mut sheets[sheet as usize].work.forces else { continue };
                let impulse = logged.impulse * *sign;
                let sample = ImpulseSample { place: logged.places[k], normal: logged.normal * *sign, velocity };
                forces.add((logged.kind, partner), impulse, &sample);
                point.terms().for_each(|(i, weight)| forces.add_on_node(i, impulse * weight));
            }
        }
        if sheets.iter().any(|sheet| sheet.state.adhesion.is_some()) {
            self.record_bond_partners(sheets, ids, workspace, work);
        }
    }

    /// Velocity of side `k` of an impulse relative to the other side at the start of the step, m/s.
    fn relative_velocity(&self, logged: &LoggedImpulse, k: usize, sheets: &[Sheet], work: &DetectionCache) -> DVec3 {
        let velocity = |side: &ContactSide| match side {
            ContactSide::Sheet { sheet, point } => {
                let forces = sheets[*sheet as usize].work.forces.as_ref();
                forces.map_or(DVec3::ZERO, |forces| forces.velocity_at_start(point.terms()))
            }
            ContactSide::Body { body, .. } => {
                let index = work.bodies().get(*body as usize);
                let body = index.and_then(|index| self.surroundings.bodies.get(*index as usize));
                body.map_or(DVec3::ZERO, |body| body.start.velocity_at(logged.places[k]))
            }
        };
        velocity(&logged.sides[k]) - velocity(&logged.sides[1 - k])
    }

    /// Note the other side of the closed contacts of every node.
    fn record_bond_partners(
        &self,
        sheets: &mut [Sheet],
        ids: &[u32],
        workspace: &ContactWorkspace,
        work: &DetectionCache,
    ) {
        workspace.for_each_closed(|contact, _| {
            for (own, other) in [(&contact.a, &contact.b), (&contact.b, &contact.a)] {
                let ContactSide::Sheet { sheet, point } = own else { continue };
                let partner = self.partner_of(other, *sheet, ids, work);
                let own = &mut sheets[*sheet as usize];
                let n = own.node_count();
                let Some(forces) = &mut own.work.forces else { continue };
                forces.bond_partner.resize(n, ForcePartner::None);
                point.terms().for_each(|(i, _)| forces.bond_partner[i as usize] = partner);
            }
        });
    }

    /// Partner of sheet number `own` of the island at the contact side `other`.
    fn partner_of(&self, other: &ContactSide, own: u32, ids: &[u32], work: &DetectionCache) -> ForcePartner {
        match other {
            ContactSide::Sheet { sheet, .. } if *sheet == own => ForcePartner::Itself,
            ContactSide::Sheet { sheet, .. } => ForcePartner::Sheet(ids[*sheet as usize] as usize),
            ContactSide::Body { body, .. } => {
                let Some(index) = work.bodies().get(*body as usize) else { return ForcePartner::None };
                match self.surroundings.bodies[*index as usize].world_index {
                    Some(body) => ForcePartner::Body(body as usize),
                    None => {
                        let mut colliders = self.surroundings.colliders.iter();
                        let collider = colliders.find(|collider| collider.body == *index);
                        collider.map_or(ForcePartner::None, |collider| ForcePartner::Collider(collider.handle))
                    }
                }
            }
        }
    }
}
