//! Adhesive bonds of a sheet: the forces that hold it to other sheets and to bodies.
//!
//! [`crate::contact::adhesion`] decides which contacts become bonds.

use glam::DVec3;

use crate::elements::flexion_limit::solver::LimitContact;
use crate::math::Vectors;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter, state};
use crate::sheet::Sheet;
use crate::units::temperature::REFERENCE;

/// Bonds of a sheet and their forces.
#[derive(Clone, Debug, Default)]
pub(crate) struct AdhesionState {
    /// Bond force on each node in the next step, N.
    pub bond_force: Vectors,
    /// Bond force on each node in the last step, N.
    pub previous_bond_force: Vectors,
    /// Bond forces on dynamic bodies: index in the bodies of the step, force (N), point in the
    /// body's frame (m).
    pub on_bodies: Vec<(u32, DVec3, DVec3)>,
    /// Whether each node has a bond.
    pub bonded: Vec<bool>,
    /// Whether each node had a bond in the last step.
    pub was_bonded: Vec<bool>,
    /// Direction from each node to its first contact.
    pub towards: Vec<DVec3>,
    /// Number of contacts of each node on the side of its first contact and on the other one.
    pub count: Vec<[u32; 2]>,
    /// Applied forces without the bond forces, to restore them after the step.
    pub applied: Vectors,
    /// Number of nodes with a bond.
    pub bonds: usize,
    /// Contacts of single nodes with kinematic and static bodies in the last substep of an explicit
    /// integrator.
    pub node_contacts: Vec<NodeBondContact>,
    /// Those of the substep before.
    pub previous_node_contacts: Vec<NodeBondContact>,
    /// Displacement of each node by its bond force in the last substep of an explicit integrator,
    /// m.
    pub pull: Vectors,
    /// Length of the last substep of an explicit integrator, s; zero with an implicit one.
    pub substep: f64,
    /// Bond force of each node on its two sides in the next step of an explicit integrator, N: of
    /// the contacts with other sheets and with dynamic bodies.
    pub pair_force: Vec<[f64; 2]>,
    /// Number of detected contacts that share each of these forces.
    pub pair_count: Vec<[u32; 2]>,
    /// Sum of the forces of `node_contacts` on each node, N.
    pub node_force: Vectors,
    /// Whether the solver has a closed contact of each node with a body.
    pub is_solved: Vec<bool>,
}

/// Closed contact of a node that the solver does not see.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NodeBondContact {
    pub node: u32,
    /// Unit vector from the node to the body.
    pub towards: DVec3,
    /// Position of the node along `-towards` where the contact closes, m.
    pub level: f64,
    /// Contact force on the node, N; its impulse (N s) within a substep.
    pub force: DVec3,
    /// Friction coefficient.
    pub friction: f64,
}

state!(NodeBondContact { node, towards, level, force, friction });

/// Bond forces of a node on its two sides, N; the first one is that of direction `towards`.
#[derive(Clone, Copy, Debug, Default)]
struct PairBond {
    node: u32,
    towards: DVec3,
    first: f64,
    second: f64,
}

state!(PairBond { node, towards, first, second });

impl NodeBondContact {
    /// Contact of a node that was solved together with the flexion limit, with its impulse.
    pub fn of_limit(contact: &LimitContact) -> Self {
        let force = contact.normal * contact.impulse.0 + contact.impulse.1;
        Self {
            node: contact.nodes[0],
            towards: -contact.normal,
            level: contact.level,
            force,
            friction: contact.friction,
        }
    }
}

impl AdhesionState {
    /// Serialise the bonds.
    pub fn serialise(&self, to: &mut StateWriter) {
        to.vector_list(&self.bond_force);
        to.vector_list(&self.previous_bond_force);
        to.states(&self.on_bodies);
        to.flags(&self.bonded);
        to.flags(&self.was_bonded);
        to.count(self.bonds as u64);
        to.states(&self.node_contacts);
        let pairs = (0_u32..).zip(self.pair_force.iter().zip(&self.towards));
        let bonded = pairs.filter(|(_, (force, _))| **force != [0.0; 2]);
        let pairs: Vec<_> = bonded
            .map(|(node, (f, towards))| PairBond { node, towards: *towards, first: f[0], second: f[1] })
            .collect();
        to.states(&pairs);
    }

    /// Deserialise the bonds of a sheet with `masses` nodes.
    pub fn deserialise(from: &mut StateReader, masses: usize) -> ReadResult<Self> {
        let mut stuck = Self::default();
        from.vector_list(&mut stuck.bond_force, masses)?;
        from.vector_list(&mut stuck.previous_bond_force, masses)?;
        stuck.on_bodies = from.states(49)?;
        from.flags(&mut stuck.bonded)?;
        from.flags(&mut stuck.was_bonded)?;
        stuck.bonds = from.length(0)?;
        stuck.node_contacts = from.states(12)?;
        let pairs: Vec<PairBond> = from.states(4)?;
        if [stuck.bond_force.len(), stuck.previous_bond_force.len(), stuck.bonded.len(), stuck.was_bonded.len()]
            != [masses; 4]
            || stuck.node_contacts.iter().any(|c| c.node as usize >= masses)
            || pairs.iter().any(|pair| pair.node as usize >= masses)
        {
            return Err(CorruptState);
        }
        stuck.resize_workspace(masses);
        for PairBond { node, towards, first, second } in pairs {
            stuck.towards[node as usize] = towards;
            stuck.pair_force[node as usize] = [first, second];
        }
        Ok(stuck)
    }

    /// Size the arrays that are filled anew in every step, for `masses` nodes.
    fn resize_workspace(&mut self, masses: usize) {
        (self.count, self.towards) = (vec![[0; 2]; masses], vec![DVec3::ZERO; masses]);
        (self.applied, self.node_force) = (Vectors::zeros(masses), Vectors::zeros(masses));
        (self.pair_force, self.pair_count) = (vec![[0.0; 2]; masses], vec![[0; 2]; masses]);
        (self.pull, self.is_solved) = (Vectors::zeros(masses), vec![false; masses]);
    }

    /// Begin a new step: the present bonds become those of the last step.
    pub(crate) fn begin(&mut self, masses: usize) {
        if self.bonded.len() != masses {
            let node_contacts = std::mem::take(&mut self.node_contacts);
            let bond_force = Vectors::zeros(masses);
            *self = Self { bond_force, node_contacts, bonded: vec![false; masses], ..Self::default() };
            (self.was_bonded, self.previous_bond_force) = (vec![false; masses], Vectors::zeros(masses));
            self.resize_workspace(masses);
        }
        std::mem::swap(&mut self.bonded, &mut self.was_bonded);
        std::mem::swap(&mut self.bond_force, &mut self.previous_bond_force);
        self.bonded.fill(false);
        self.count.fill([0; 2]);
        self.pair_force.fill([0.0; 2]);
        self.bond_force.clear();
        self.on_bodies.clear();
        self.bonds = 0;
        self.is_solved.fill(false);
        self.node_force.clear();
    }

    /// Count the contacts of single nodes and add up their forces.
    pub(crate) fn count_node_contacts(&mut self) {
        for k in 0..self.node_contacts.len() {
            let NodeBondContact { node, towards, force, .. } = self.node_contacts[k];
            self.node_force.add(node as usize, force);
            if !self.is_solved[node as usize] {
                self.has_contact(node, towards);
            }
        }
    }

    /// Mark node `i` as bonded.
    pub(crate) fn set_bonded(&mut self, i: u32) {
        self.bonds += usize::from(!std::mem::replace(&mut self.bonded[i as usize], true));
    }

    /// Count a contact of node `i` in direction `towards`.
    pub(crate) fn has_contact(&mut self, i: u32, towards: DVec3) {
        let i = i as usize;
        if self.count[i] == [0; 2] {
            self.towards[i] = towards;
        }
        let side = self.side(i as u32, towards);
        self.count[i][side] += 1;
    }

    /// Side of node `i` in direction `towards`: 0 for that of its first contact.
    pub(crate) fn side(&self, i: u32, towards: DVec3) -> usize {
        usize::from(self.towards[i as usize].dot(towards) < 0.0)
    }

    /// Number of contacts of node `i` on the side of direction `towards`.
    pub(crate) fn contacts(&self, i: u32, towards: DVec3) -> u32 {
        self.count[i as usize][self.side(i, towards)]
    }
}

impl Sheet {
    /// Number of nodes of the sheet with a bond.
    pub fn bonds(&self) -> usize {
        self.state.adhesion.as_ref().map_or(0, |s| s.bonds)
    }
}

/// Remove the contacts of single nodes, where an implicit integrator has none.
pub(crate) fn clear_node_contacts(sheet: &mut Sheet) {
    if let Some(stuck) = &mut sheet.state.adhesion {
        stuck.node_contacts.clear();
        stuck.substep = 0.0;
    }
}

/// Add the bond forces to the applied forces.
pub(crate) fn apply_bond_forces(sheet: &mut Sheet) {
    if let Some(stuck) = &mut sheet.state.adhesion {
        stuck.applied.copy_from(&sheet.parameters.applied);
        sheet.parameters.applied.add_scaled(1.0, &stuck.bond_force);
    }
}

/// Restore the applied forces without the bond forces.
pub(crate) fn remove_bond_forces(sheet: &mut Sheet) {
    if let Some(stuck) = &sheet.state.adhesion {
        sheet.parameters.applied.copy_from(&stuck.applied);
    }
}

/// Temperature of node `i`, °C.
pub(crate) fn celsius(sheet: &Sheet, i: u32) -> f64 {
    let of_mass = sheet.temperatures().and_then(|t| t.get(i as usize).copied());
    of_mass.or_else(|| sheet.temperature()).unwrap_or(REFERENCE)
}
