//! PGS contact solver with a working set, for explicit integrators and as the last fallback of a
//! single sheet.
//!
//! A few contacts are added at a time (`working_set`); PGS sweeps over the Delassus operator find
//! their forces (`pgs`); then the contacts that are still violated join.

use glam::DVec3;

use crate::contact::IslandView;
use crate::contact::contact_cache::CachedForces;
use crate::contact::settings::{ContactSettings, NodeSweepSettings, PgsSettings, WorkingSetSettings};
use crate::contact::solver::delassus::{DelassusOperator, frame_of};
use crate::contact::solver::pgs::PgsStats;
use crate::contact::solver::working_set::WorkingSet;
use crate::contact::workspace::ContactWorkspace;

const SETTINGS: NodeSweepSettings = ContactSettings::DEFAULT.node_sweeps;
const PGS: PgsSettings = ContactSettings::DEFAULT.pgs;
const WORKING_SET: WorkingSetSettings = ContactSettings::DEFAULT.working_set;

/// PGS solver with its working set.
#[derive(Default)]
pub(crate) struct PgsContactSolver {
    pub delassus: DelassusOperator,
    /// Relative position or velocity without contact, of every contact in the problem.
    pub b: Vec<DVec3>,
    working_set: WorkingSet,
    passes: u32,
}

/// Maximum size of the working set of `island`.
fn working_set_capacity(island: &IslandView) -> usize {
    SETTINGS.maximum_contacts
        + SETTINGS.maximum_contacts_per_object * (island.sheets.len() + island.solver_bodies.len())
}

impl PgsContactSolver {
    /// Start with attachments and with contacts that have a cached force and penetrate, or else
    /// with the deepest ones.
    pub fn begin(&mut self, workspace: &ContactWorkspace, island: &mut IslandView, h: f64) {
        self.passes = 0;
        self.delassus.clear(island);
        self.working_set.begin(workspace.detected.contacts.len());
        self.working_set.add_cached(workspace);
        self.activate(workspace, island, h);
        self.add_violated(workspace);
        if self.delassus.problem.is_empty() && self.working_set.new.is_empty() {
            self.working_set.add_deepest(&workspace.gaps.now);
        }
        self.activate(workspace, island, h);
    }

    /// Start with all closed contacts, for the velocity solve.
    pub fn begin_closed(&mut self, workspace: &ContactWorkspace, island: &mut IslandView, h: f64) {
        self.passes = 0;
        self.delassus.clear_for_velocities(island);
        self.working_set.begin(workspace.detected.contacts.len());
        self.working_set.new.extend(
            (0..workspace.detected.contacts.len() as u32)
                .filter(|i| workspace.gaps.now[*i as usize] < SETTINGS.penetration * workspace.half_thickness),
        );
        self.working_set.new.truncate(2 * working_set_capacity(island));
        self.activate(workspace, island, h);
    }

    /// Add contacts that are still violated. Returns false if there are none or a limit is reached.
    pub fn extend(&mut self, workspace: &ContactWorkspace, island: &mut IslandView, h: f64) -> bool {
        self.passes += 1;
        self.add_violated(workspace);
        if self.working_set.new.is_empty()
            || self.passes >= WORKING_SET.maximum_extensions
            || self.delassus.problem.len() >= working_set_capacity(island)
        {
            return false;
        }
        self.activate(workspace, island, h);
        true
    }

    /// Solve the forces for the right-hand side `b`.
    /// The tolerance is in m.
    pub fn sweep(&mut self, tolerance: f64) -> PgsStats {
        self.delassus.problem.solve(&self.b, tolerance, PGS.maximum_sweeps)
    }

    /// Solve the forces for the right-hand side `b` to a tenth of the penetration tolerance.
    /// `half_thickness` is in m.
    pub fn sweep_roughly(&mut self, half_thickness: f64) -> PgsStats {
        self.delassus.problem.solve(&self.b, 0.1 * SETTINGS.penetration * half_thickness, SETTINGS.rough_sweeps)
    }

    /// Active contacts, as indices into the detected contacts, and their forces in world axes, N.
    pub fn forces(&self) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        let all = self.delassus.contacts().enumerate();
        all.map(|(k, i)| (i, self.delassus.frame(k) * self.delassus.problem.force[k]))
    }

    /// Add the new contacts of the working set to the problem.
    fn activate(&mut self, workspace: &ContactWorkspace, island: &mut IslandView, h: f64) {
        for number in &self.working_set.new {
            let i = *number as usize;
            let contact = &workspace.detected.contacts[i];
            let force = workspace.cached_forces(&contact.key).map_or(DVec3::ZERO, |f| f.position);
            self.delassus.problem.push(workspace.law(i), frame_of(contact.normal).transpose() * force);
        }
        self.delassus.add(island, &workspace.detected.contacts, &self.working_set.new, h);
        self.working_set.activate();
    }

    /// Select contacts outside the problem that penetrate by more than the tolerance.
    fn add_violated(&mut self, workspace: &ContactWorkspace) {
        let depth = if workspace.policy.is_explicit { PGS.tolerance } else { SETTINGS.penetration };
        let depth = depth * workspace.half_thickness;
        self.working_set.add_violated(workspace, &workspace.gaps.now, depth, self.delassus.contacts());
    }
}

impl ContactWorkspace {
    /// Solve the positions by PGS: coarsely while the working set grows, then to the tolerance.
    pub(super) fn solve_positions_by_pgs(&mut self, island: &mut IslandView, h: f64) {
        let mut pgs = std::mem::take(&mut self.pgs);
        pgs.begin(self, island, h);
        let tolerance = PGS.tolerance * self.half_thickness;
        let mut rough = true;
        let settled = loop {
            pgs.b.clear();
            for k in 0..pgs.delassus.problem.len() {
                let u = self.relative_position(island, pgs.delassus.contact(k), &pgs.delassus.frame(k));
                pgs.b.push(u);
            }
            // Approximate forces are accurate enough to extend the working set.
            let swept = if rough { pgs.sweep_roughly(self.half_thickness) } else { pgs.sweep(tolerance) };
            self.counters.sweeps += u64::from(swept.sweeps);
            self.work += u64::from(swept.sweeps) * pgs.delassus.problem.len() as u64;
            pgs.delassus.displace(island, &self.detected.contacts, h);
            self.gaps.update(&self.detected.contacts, island);
            if !pgs.extend(self, island, h) {
                if !rough || swept.change <= tolerance {
                    break swept.change <= tolerance;
                }
                rough = false;
            }
        };
        self.counters.unsettled += u64::from(!settled);
        let contacts = &self.detected.contacts;
        self.cache.replace(|old, new| {
            new.extend(pgs.forces().map(|(c, position)| {
                let key = contacts[c].key;
                (key, CachedForces { position, ..old.of(&key).unwrap_or_default() })
            }));
        });
        self.pgs = pgs;
    }

    /// Solve the velocities of the contacts that the PGS position solve left active.
    pub(super) fn solve_velocities_by_pgs(&mut self, island: &mut IslandView, h: f64) {
        let mut pgs = std::mem::take(&mut self.pgs);
        pgs.b.clear();
        for k in 0..pgs.delassus.problem.len() {
            let i = pgs.delassus.contact(k);
            let frame = pgs.delassus.frame(k);
            let u = self.relative_velocity(island, i, &frame);
            let force = self.cached_forces(&self.detected.contacts[i].key).map_or(DVec3::ZERO, |f| f.velocity);
            pgs.delassus.problem.force[k] = if u.is_some() { frame.transpose() * force } else { DVec3::ZERO };
            pgs.b.push(u.map_or(DVec3::new(f64::INFINITY, 0.0, 0.0), |u| u * h));
        }
        let tolerance = PGS.tolerance * self.half_thickness;
        let swept = pgs.sweep(tolerance);
        self.counters.sweeps += u64::from(swept.sweeps);
        self.counters.unsettled += u64::from(swept.change > tolerance);
        pgs.delassus.apply_velocity_jumps(island, &self.detected.contacts, h);
        let contacts = &self.detected.contacts;
        self.impulses.set_stage_forces(pgs.forces().map(|(c, velocity)| (c as u32, velocity)));
        self.cache.replace(|old, new| {
            new.extend(pgs.forces().map(|(c, velocity)| {
                let key = contacts[c].key;
                (key, CachedForces { velocity, ..old.of(&key).unwrap_or_default() })
            }));
        });
        self.pgs = pgs;
    }
}
