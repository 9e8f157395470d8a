//! Contact of the drawn surface of a sheet with kinematic and static bodies, for explicit
//! integrators (thesis 7.3 e): without it contact knows the nodes alone, and the surface that is
//! drawn over them sinks into bodies between them.
//!
//! A vertex of the drawn surface is x_s = Σ w_i x_i with fixed weights. After the contact of the
//! nodes, each vertex whose path ends behind a surface with normal n and level d along it becomes
//! a contact, and so does each node that has met a surface. Gauss-Seidel sweeps over all of them
//! change displacements and then velocities of the nodes by impulses p (kg m or N s),
//!
//!   Δx_i = (w_i/m_i) p,   K = Σ w_i²/m_i,
//!   p_n ← max(0, p_n + (d - x_s·n)/K),   |p_t| ≤ μ p_n,
//!
//! where p_t opposes the tangential displacement of the step, or the tangential velocity. A vertex
//! that approaches faster than [`NodeContactSettings::restitution_speed`] rebounds. All others
//! start from their impulses of the last substep, so that a sheet at rest needs few sweeps. Since
//! the impulses at a vertex act on its nodes with its own weights, momentum and angular momentum
//! change as by a force at the vertex.

use glam::DVec3;
use rapier3d::math::Real;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::ColliderHandle;

use crate::contact::node::clearance::Clearance;
use crate::contact::node::detection::reach_of_moving;
use crate::contact::node::response::{NodeContactSurface, NodePath, time_of_impact};
use crate::contact::node::target::{NO_FACE, PathHit, StepTarget};
use crate::contact::settings::{ContactSettings, NodeContactSettings};
use crate::math::Vectors;
use crate::rigid::RigidView;
use crate::scene::ContactSurface;
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter, state};
use crate::sheet::surface::{DrawingSurface, SurfaceSmoothing};
use crate::sheet::{Sheet, node_contact};

const SETTINGS: NodeContactSettings = ContactSettings::DEFAULT.node;

/// Drawn surface of a sheet in contact.
#[derive(Default)]
pub(crate) struct DrawnContact {
    /// Kind of the surface, and number of nodes, for which the weights were computed.
    built_for: (ContactSurface, usize),
    /// First term of each vertex, then of each node, and the end.
    first: Vec<u32>,
    nodes: Vec<u32>,
    weights: Vec<f64>,
    /// Number of vertices.
    vertices: usize,
    /// Positions of the vertices at the start and at the end of the substep, m.
    start: Vectors,
    end: Vectors,
    /// Clearance of the vertices. Results do not depend on it.
    clearance: Clearance,
    contacts: Vec<VertexContact>,
    /// Impulses of the last substep, for positions (kg m) and for velocities (N s).
    impulses: [Vec<PointImpulse>; 2],
    /// Impulses by point while the sweeps begin; zero at all other times.
    first_impulses: Vectors,
    /// Swept values (m or m/s) and inverse masses along the axes (1/kg) of the nodes.
    values: Vec<DVec3>,
    mobility: Vec<DVec3>,
}

/// Impulse at a vertex or node.
#[derive(Clone, Copy, Default)]
struct PointImpulse {
    point: u32,
    impulse: DVec3,
}

state!(PointImpulse { point, impulse });

/// Contact of a vertex, or of a node, with a surface.
#[derive(Clone, Copy)]
struct VertexContact {
    /// Vertex, or the number of vertices plus the node.
    point: usize,
    surface: NodeContactSurface,
    /// Position of the surface along its normal, contact offset included, m.
    level: f64,
    /// Position of the point at the start of the substep, m.
    start: DVec3,
    /// Inverse mass of the point, 1/kg.
    mobility: f64,
    /// Speed of the rebound along the normal, m/s.
    rebound: f64,
    /// Accumulated normal and tangential impulse.
    normal: f64,
    tangential: DVec3,
}

/// Quantity that the sweeps change.
#[derive(Clone, Copy, PartialEq)]
enum SweptQuantity {
    /// Positions in a substep of this length, s.
    Positions(f64),
    Velocities,
}

impl DrawnContact {
    /// Compute the weights if the sheet has a drawn surface in contact and they are missing.
    pub fn prepare(contact: &mut Option<Box<Self>>, sheet: &Sheet) {
        let kind = sheet.model.contact_surface;
        let wanted = (kind, sheet.node_count());
        if kind == ContactSurface::Masses || contact.as_ref().is_some_and(|c| c.built_for == wanted) {
            return;
        }
        let mut built = Self { built_for: wanted, first: vec![0], ..Self::default() };
        let smoothing = match kind {
            ContactSurface::BSpline => SurfaceSmoothing::BSpline,
            _ => SurfaceSmoothing::Interpolating,
        };
        let last = sheet.model.layers.len().saturating_sub(1);
        for layer in [0, last].into_iter().take(last.min(1) + 1) {
            let Some(surface) = DrawingSurface::of_sheet(sheet, layer, SETTINGS.surface_parts, smoothing) else {
                continue;
            };
            for vertex in 0..surface.len() {
                let sum: f64 = surface.terms(vertex).map(|(_, w)| w).sum();
                surface.terms(vertex).for_each(|(i, w)| built.push(i, w / sum));
                built.first.push(built.nodes.len() as u32);
            }
        }
        built.vertices = built.first.len() - 1;
        for i in 0..sheet.node_count() as u32 {
            built.push(i, 1.0);
            built.first.push(built.nodes.len() as u32);
        }
        (built.start, built.end) = (Vectors::zeros(built.vertices), Vectors::zeros(built.vertices));
        built.first_impulses = Vectors::zeros(built.first.len() - 1);
        *contact = Some(Box::new(built));
    }

    fn push(&mut self, node: u32, weight: f64) {
        self.nodes.push(node);
        self.weights.push(weight);
    }

    fn terms(&self, point: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.first[point] as usize..self.first[point + 1] as usize;
        self.nodes[range.clone()].iter().map(|i| *i as usize).zip(self.weights[range].iter().copied())
    }

    fn at(&self, point: usize, values: &Vectors) -> DVec3 {
        self.terms(point).map(|(i, w)| values.get(i) * w).sum()
    }

    /// Find the contacts of vertices in a substep.
    fn detect(
        &mut self,
        sheet: &Sheet,
        view: &RigidView,
        (dt, remaining): (f64, f64),
        touched: &mut dyn FnMut(ColliderHandle),
    ) {
        for vertex in 0..self.vertices {
            let (start, end) = (self.at(vertex, &sheet.work.x_before), self.at(vertex, &sheet.state.x));
            self.start.set(vertex, start);
            self.end.set(vertex, end);
        }
        let offset = node_contact::contact_offset(sheet);
        let margin = (SETTINGS.search_margin * sheet.model.initial_diagonal).max(2.0 * offset);
        let reach = reach_of_moving(view, dt + remaining);
        if !self.clearance.begin(&self.end, |_| true, reach, margin, offset) {
            return;
        }
        let (Some((a, b)), Some((c, d))) = (self.start.bounds(), self.end.bounds()) else { return };
        let around = Aabb::new(a.min(c).as_vec3(), b.max(d).as_vec3()).loosened((reach + margin) as Real);
        for (handle, collider) in view.query_fixed().intersect_aabb_conservative(around) {
            let target = StepTarget::new(handle, collider, view, sheet, dt, remaining);
            let mut meets = false;
            for vertex in 0..self.vertices {
                if self.clearance.nearest[vertex] < 0.0 {
                    continue;
                }
                let (start, end) = (self.start.get(vertex), self.end.get(vertex));
                let (a, b) = (target.start.local_point(start).as_vec3(), target.end.local_point(end).as_vec3());
                match target.test_path(a, b, Real::MAX, &mut { NO_FACE }) {
                    PathHit::Clear(distance) => {
                        let nearest = &mut self.clearance.nearest[vertex];
                        *nearest = nearest.min(distance.into());
                    }
                    PathHit::Surface(surface) => {
                        self.clearance.nearest[vertex] = 0.0;
                        self.add_contact(sheet, vertex, surface, dt);
                        meets = true;
                    }
                }
            }
            if meets {
                touched(handle);
            }
        }
        self.clearance.end(&self.end);
    }

    fn add_contact(&mut self, sheet: &Sheet, point: usize, surface: NodeContactSurface, dt: f64) {
        let mobility: f64 = self.terms(point).map(|(i, w)| w * w * sheet.inverse_mass[i]).sum();
        if mobility <= 0.0 {
            return;
        }
        let offset = node_contact::contact_offset(sheet);
        let [x0, v0] = [&sheet.work.x_before, &sheet.work.v_before].map(|values| self.at(point, values));
        let [x1, v1] = [&sheet.state.x, &sheet.state.v].map(|values| self.at(point, values));
        let path = NodePath { x0, v0, x1, v1, dt, drift: 0.5 };
        // The velocity that forces of this substep give a resting point is no impact.
        let arriving = v0.lerp(v1, time_of_impact(&path, &surface, offset));
        let approach = -(arriving - surface.velocity).dot(surface.normal);
        let is_impact = point < self.vertices && approach > SETTINGS.restitution_speed;
        let rebound = if is_impact { surface.restitution * approach } else { 0.0 };
        let level = surface.point.dot(surface.normal) + offset;
        let (normal, tangential) = (0.0, DVec3::ZERO);
        self.contacts.push(VertexContact { point, surface, level, start: x0, mobility, rebound, normal, tangential });
    }

    /// Sweep until no contact changes by more than the tolerance (m or m/s).
    fn sweep(&mut self, sheet: &mut Sheet, quantity: SweptQuantity, tolerance: f64) {
        let swept = if quantity == SweptQuantity::Velocities { &mut sheet.state.v } else { &mut sheet.state.x };
        self.values.clear();
        self.values.extend(swept.iter());
        let mut contacts = std::mem::take(&mut self.contacts);
        self.begin_impulses(&mut contacts, quantity);
        for _ in 0..SETTINGS.surface_sweeps {
            let mut largest = 0.0_f64;
            for contact in &mut contacts {
                let change = contact.change(self.value(contact.point), quantity);
                if change != DVec3::ZERO {
                    largest = largest.max(change.length() * contact.mobility);
                    self.push_nodes(contact.point, change);
                }
            }
            if largest <= tolerance {
                break;
            }
        }
        let impulses = &mut self.impulses[quantity.index()];
        impulses.clear();
        impulses.extend(
            contacts
                .iter()
                .filter(|c| c.normal > 0.0)
                .map(|c| PointImpulse { point: c.point as u32, impulse: c.surface.normal * c.normal + c.tangential }),
        );
        self.contacts = contacts;
        for (i, value) in self.values.iter().enumerate() {
            swept.set(i, *value);
        }
    }

    /// Start every contact from the impulse of its point in the last substep, and from zero in a
    /// rebound.
    fn begin_impulses(&mut self, contacts: &mut [VertexContact], quantity: SweptQuantity) {
        let last = std::mem::take(&mut self.impulses[quantity.index()]);
        for stored in &last {
            self.first_impulses.add(stored.point as usize, stored.impulse);
        }
        for contact in contacts {
            let first = self.first_impulses.get(contact.point);
            self.first_impulses.set(contact.point, DVec3::ZERO);
            let n = contact.surface.normal;
            contact.normal = if contact.rebound > 0.0 { 0.0 } else { first.dot(n).max(0.0) };
            let most = contact.surface.friction * contact.normal;
            contact.tangential = first.reject_from_normalized(n).clamp_length_max(most);
            self.push_nodes(contact.point, n * contact.normal + contact.tangential);
        }
        for stored in &last {
            self.first_impulses.set(stored.point as usize, DVec3::ZERO);
        }
        self.impulses[quantity.index()] = last;
    }

    fn value(&self, point: usize) -> DVec3 {
        self.terms(point).map(|(i, w)| self.values[i] * w).sum()
    }

    /// Change the nodes of a point by an impulse.
    fn push_nodes(&mut self, point: usize, impulse: DVec3) {
        let range = self.first[point] as usize..self.first[point + 1] as usize;
        for (i, w) in self.nodes[range.clone()].iter().zip(&self.weights[range]) {
            let i = *i as usize;
            self.values[i] += impulse * self.mobility[i] * *w;
        }
    }

    /// Serialise the impulses of the last substep.
    pub fn serialise(drawn: Option<&Self>, to: &mut StateWriter) {
        for quantity in 0..2 {
            to.states(drawn.map_or(&[][..], |drawn| drawn.impulses[quantity].as_slice()));
        }
    }

    /// Deserialise the impulses of the last substep.
    pub fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        self.clearance.clear();
        for quantity in 0..2 {
            self.impulses[quantity] = from.states(9)?;
            if self.impulses[quantity].iter().any(|stored| stored.point as usize >= self.first_impulses.len()) {
                return Err(CorruptState);
            }
        }
        Ok(())
    }
}

impl SweptQuantity {
    fn index(self) -> usize {
        usize::from(self == Self::Velocities)
    }
}

impl VertexContact {
    /// Change the impulse so that the contact, with its point at `value` (m or m/s), obeys
    /// Coulomb's law. Returns the change.
    fn change(&mut self, value: DVec3, quantity: SweptQuantity) -> DVec3 {
        let n = self.surface.normal;
        let (apart, slip) = match quantity {
            SweptQuantity::Positions(dt) => {
                (value.dot(n) - self.level, value - self.start - self.surface.velocity * dt)
            }
            SweptQuantity::Velocities => {
                let relative = value - self.surface.velocity;
                (relative.dot(n) - self.rebound, relative)
            }
        };
        let before = n * self.normal + self.tangential;
        self.normal = (self.normal - apart / self.mobility).max(0.0);
        let sticking = self.tangential - slip.reject_from_normalized(n) / self.mobility;
        self.tangential = sticking.clamp_length_max(self.surface.friction * self.normal);
        n * self.normal + self.tangential - before
    }
}

/// Resolve the contact of the drawn surface of `sheet` in a substep of `dt` (s), after the contact
/// of its nodes with `met`. `remaining` and `touched` are those of
/// [`crate::contact::node::detection::resolve_node_contact`]; `displaced` says whether the sheet
/// was displaced between steps.
pub(crate) fn resolve_drawn_contact(
    sheet: &mut Sheet,
    drawn: &mut DrawnContact,
    met: &[(u32, NodeContactSurface)],
    view: &RigidView,
    ((dt, remaining), displaced): ((f64, f64), bool),
    touched: &mut dyn FnMut(ColliderHandle),
) {
    if displaced || !view.is_world_owned {
        drawn.clearance.clear();
    }
    drawn.contacts.clear();
    drawn.detect(sheet, view, (dt, remaining), touched);
    if drawn.contacts.is_empty() {
        drawn.impulses.iter_mut().for_each(Vec::clear);
        return;
    }
    for (i, surface) in met {
        drawn.add_contact(sheet, drawn.vertices + *i as usize, *surface, dt);
    }
    drawn.mobility.clear();
    let (inverse_mass, pins) = (&sheet.inverse_mass, &sheet.pins);
    drawn.mobility.extend(inverse_mass.iter().enumerate().map(|(i, w)| pins.free_axes(i as u32) * *w));
    let half = node_contact::half_thickness(sheet);
    let tolerance = SETTINGS.surface_tolerance * half;
    drawn.sweep(sheet, SweptQuantity::Positions(dt), tolerance);
    let mut contacts = std::mem::take(&mut drawn.contacts);
    let closed_gap = ContactSettings::DEFAULT.closed_gap_at_end * half;
    contacts.retain(|c| drawn.at(c.point, &sheet.state.x).dot(c.surface.normal) < c.level + closed_gap);
    drawn.contacts = contacts;
    drawn.sweep(sheet, SweptQuantity::Velocities, tolerance / dt);
    for contact in drawn.contacts.iter().filter(|c| c.normal > 0.0) {
        let nearest = drawn.terms(contact.point).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((i, _)) = nearest {
            sheet.state.touching[i] = true;
        }
    }
    sheet.state.counters.contacts += drawn.contacts.len() as u64;
}
