//! Test of a substep before it is accepted: whether a sheet of the island lies within a body,
//! another sheet or itself by more than the accepted fraction of its thickness.
//!
//! Every triangle is tested against every convex collider, and against the triangles of other
//! sheets and of its own sheet that are not neighbours at rest, wherever their boxes meet. The test
//! knows nothing of the contacts that the solver had. Triangles whose nodes are all held do not
//! count, nor does a sheet compressed between colliders that do not reach its mid-surface. A
//! rectangle whose normals are all within 60° of their mean does not meet itself. Lengths in m.

use std::ops::Range;

use glam::DVec3;

use crate::collision::bvh::is_flat;
use crate::collision::collision_surface::CollisionSurface;
use crate::collision::features::ColliderPart;
use crate::collision::overlap::distance;
use crate::collision::overlap::nearness::distance_below;
use crate::collision::overlap::rim::inset_border;
use crate::collision::overlap::sheets::{apart, bounds};
use crate::collision::settings::{DetectionSettings, OverlapSettings};
use crate::contact::IslandView;
use crate::contact::barrier::BarrierCollider;
use crate::contact::solver_body::frame_of_body;
use crate::contact::workspace::ContactWorkspace;
use crate::islands::island_detection::in_world;
use crate::math::{RigidFrame, Vectors};
use crate::sheet::{Interpenetration, Sheet, stage};

const SETTINGS: OverlapSettings = DetectionSettings::DEFAULT.overlap;

/// A triangle of a sheet.
#[derive(Clone, Copy)]
struct PlacedTriangle {
    nodes: [u32; 3],
    corners: [DVec3; 3],
    low: DVec3,
    high: DVec3,
}

/// A sheet as it lies.
#[derive(Clone)]
struct PlacedSurface {
    /// Index in the island.
    index: usize,
    /// Its triangles, by their least x.
    triangles: Range<usize>,
    /// Greatest extent of a triangle along x.
    wide: f64,
    low: DVec3,
    high: DVec3,
    half_thickness: f64,
    is_unfolded: bool,
    /// Whether it passes through other such sheets, which is reported elsewhere.
    crosses: bool,
}

/// Buffers of the test.
#[derive(Default)]
pub(crate) struct OverlapTest {
    triangles: Vec<PlacedTriangle>,
    sheets: Vec<PlacedSurface>,
    /// Positions of the nodes of a sheet with its border moved inward, m.
    inset: Vectors,
    inward: Vec<DVec3>,
}

/// State of the island that is tested.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum TestedState {
    /// At the start of the substep.
    Start,
    /// At its end.
    End,
}

/// The colliders near an island, and where they are.
pub(crate) struct TestedColliders<'a, I> {
    pub colliders: I,
    pub frames: &'a dyn Fn(u32) -> RigidFrame,
}

impl<'a, I: Iterator<Item = BarrierCollider<'a>> + Clone> TestedColliders<'_, I> {
    /// Whether a triangle with a distance of `half` (m) from a collider is met from both sides.
    fn compress(&self, [a, b, c]: &[DVec3; 3], half: f64) -> [bool; 2] {
        let normal = (*b - *a).cross(*c - *a).normalize_or_zero();
        let mut sides = [false; 2];
        self.for_each_part(|part, frame| {
            let local = |by: f64| [*a, *b, *c].map(|p| frame.local_point(p + normal * by));
            let distance = |by: f64| distance_below(part, &local(by), 4.0 * half).unwrap_or(f64::INFINITY);
            let here = distance(0.0);
            if here > 0.0 && here < half {
                sides[usize::from(distance(half) < distance(-half))] = true;
            }
            false
        });
        sides
    }

    /// Call `with` for every part of a collider and its frame until it returns `true`; returns
    /// whether it did.
    fn for_each_part(&self, mut with: impl FnMut(&ColliderPart, &RigidFrame) -> bool) -> bool {
        self.colliders.clone().any(|collider| {
            let frame = in_world(&(self.frames)(collider.body), collider.frame);
            collider.features.solids().iter().any(|(_, part)| with(part, &frame))
        })
    }
}

impl OverlapTest {
    /// Whether a sheet of the island is deeper than accepted in one of the colliders, in another
    /// sheet, if `sheets_meet`, or in itself.
    pub fn finds<'a>(
        &mut self,
        island: &IslandView,
        colliders: &TestedColliders<impl Iterator<Item = BarrierCollider<'a>> + Clone>,
        (state, sheets_meet): (TestedState, bool),
    ) -> bool {
        // A sheet far from everything: its normals suffice.
        if let ([sheet], [contact]) = (&*island.sheets, &*island.contacts)
            && colliders.colliders.clone().next().is_none()
            && contact.surface.as_ref().is_some_and(|surface| is_unfolded(surface, positions(sheet, state)))
        {
            return false;
        }
        self.place(island, state);
        let surfaces = || self.sheets.iter().enumerate();
        surfaces().any(|(_, sheet)| self.meets_collider(sheet, colliders))
            || sheets_meet
                && surfaces().any(|(i, a)| self.sheets[..i].iter().any(|b| self.meets_sheet(a, b, colliders)))
            || (0..self.sheets.len())
                .any(|sheet| !self.sheets[sheet].is_unfolded && self.meets_itself(island, (sheet, state), colliders))
    }

    /// Place the sheets.
    fn place(&mut self, island: &IslandView, state: TestedState) {
        self.triangles.clear();
        self.sheets.clear();
        for (index, sheet) in island.sheets.iter().enumerate() {
            let Some(surface) = &island.contacts[index].surface else { continue };
            let placed = place_surface((index, sheet), surface, positions(sheet, state), &mut self.triangles);
            self.sheets.push(placed);
        }
    }

    fn triangles_of(&self, sheet: &PlacedSurface) -> &[PlacedTriangle] {
        &self.triangles[sheet.triangles.clone()]
    }

    fn meets_collider<'a>(
        &self,
        sheet: &PlacedSurface,
        colliders: &TestedColliders<impl Iterator<Item = BarrierCollider<'a>> + Clone>,
    ) -> bool {
        let half = sheet.half_thickness;
        let accepted = (1.0 - 2.0 * SETTINGS.depth) * half;
        colliders.for_each_part(|part, frame| {
            let around = world_bounds(part.bounds(), frame);
            if apart(around, (sheet.low, sheet.high), accepted) {
                return false;
            }
            self.triangles_of(sheet).iter().any(|t| {
                if apart(around, (t.low, t.high), accepted) {
                    return false;
                }
                let local = t.corners.map(|p| frame.local_point(p));
                let is_compressed = || colliders.compress(&t.corners, half) == [true; 2];
                distance_below(part, &local, accepted).is_some_and(|distance| distance == 0.0 || !is_compressed())
            })
        })
    }

    fn meets_sheet<'a>(
        &self,
        a: &PlacedSurface,
        b: &PlacedSurface,
        colliders: &TestedColliders<impl Iterator<Item = BarrierCollider<'a>> + Clone>,
    ) -> bool {
        let accepted =
            a.half_thickness + b.half_thickness - 2.0 * SETTINGS.depth * a.half_thickness.min(b.half_thickness);
        let is_apart = apart((a.low, a.high), (b.low, b.high), accepted);
        !(is_apart || a.crosses && b.crosses) && self.any_pair(a, b, accepted, colliders, |_, _| false)
    }

    fn meets_itself<'a>(
        &mut self,
        island: &IslandView,
        (placed, state): (usize, TestedState),
        colliders: &TestedColliders<impl Iterator<Item = BarrierCollider<'a>> + Clone>,
    ) -> bool {
        let index = self.sheets[placed].index;
        let Some(surface) = &island.contacts[index].surface else { return false };
        let of = &island.sheets[index];
        self.inset.clone_from(positions(of, state));
        inset_border(surface, &mut self.inset, &mut self.inward, surface.contact_offset());
        let first = self.triangles.len();
        let sheet = place_surface((index, of), surface, &self.inset, &mut self.triangles);
        let thickness = 2.0 * sheet.half_thickness;
        let are_neighbours = |p: &[u32; 3], q: &[u32; 3]| surface.are_neighbours(p, q, thickness);
        let meets = self.any_pair(&sheet, &sheet, (1.0 - SETTINGS.depth) * thickness, colliders, are_neighbours);
        self.triangles.truncate(first);
        meets
    }

    /// Whether two triangles are nearer than `accepted` (m), without those that `skips` names and
    /// those compressed between colliders.
    fn any_pair<'a>(
        &self,
        a: &PlacedSurface,
        b: &PlacedSurface,
        accepted: f64,
        colliders: &TestedColliders<impl Iterator<Item = BarrierCollider<'a>> + Clone>,
        skips: impl Fn(&[u32; 3], &[u32; 3]) -> bool,
    ) -> bool {
        let others = self.triangles_of(b);
        self.triangles_of(a).iter().filter(|t| !apart((t.low, t.high), (b.low, b.high), accepted)).any(|t| {
            let first = others.partition_point(|u| u.low.x < t.low.x - accepted - b.wide);
            let along = others[first..].iter().take_while(|u| u.low.x <= t.high.x + accepted);
            along.filter(|u| !apart((t.low, t.high), (u.low, u.high), accepted)).any(|u| {
                if skips(&t.nodes, &u.nodes) {
                    return false;
                }
                let distance = distance::triangles(&t.corners, &u.corners);
                distance < accepted && {
                    let sides = [t, u].map(|t| colliders.compress(&t.corners, a.half_thickness));
                    distance == 0.0 || !(0..2).all(|side| sides[0][side] || sides[1][side])
                }
            })
        })
    }
}

/// Positions of the nodes of a sheet in a state of the substep, m.
fn positions(sheet: &Sheet, state: TestedState) -> &Vectors {
    match state {
        TestedState::Start => stage::saved_positions(sheet),
        TestedState::End => &sheet.state.x,
    }
}

/// Place the triangles of a sheet at `x` (m).
fn place_surface(
    (index, sheet): (usize, &Sheet),
    surface: &CollisionSurface,
    x: &Vectors,
    triangles: &mut Vec<PlacedTriangle>,
) -> PlacedSurface {
    let first = triangles.len();
    for t in surface.triangles().iter().filter(|t| t.nodes.iter().any(|i| !sheet.is_held(*i as usize))) {
        let corners = t.nodes.map(|i| x.get(i as usize));
        let (low, high) = bounds(corners);
        triangles.push(PlacedTriangle { nodes: t.nodes, corners, low, high });
    }
    let all = &mut triangles[first..];
    all.sort_unstable_by(|a, b| a.low.x.total_cmp(&b.low.x).then(a.nodes.cmp(&b.nodes)));
    PlacedSurface {
        index,
        wide: all.iter().map(|t| t.high.x - t.low.x).fold(0.0, f64::max),
        low: all.iter().map(|t| t.low).fold(DVec3::INFINITY, DVec3::min),
        high: all.iter().map(|t| t.high).fold(DVec3::NEG_INFINITY, DVec3::max),
        is_unfolded: is_unfolded(surface, x),
        half_thickness: surface.contact_offset(),
        crosses: sheet.state.interpenetration != Interpenetration::None,
        triangles: first..triangles.len(),
    }
}

/// Whether a surface with the nodes at `x` (m) is a rectangle with normals near their mean.
fn is_unfolded(surface: &CollisionSurface, x: &Vectors) -> bool {
    surface.is_rectangle() && is_flat(surface, x, SETTINGS.unfolded_cosine * SETTINGS.unfolded_cosine)
}

/// Box around a box of the frame of a body.
fn world_bounds((low, high): (DVec3, DVec3), frame: &RigidFrame) -> (DVec3, DVec3) {
    if !low.is_finite() || !high.is_finite() {
        return (DVec3::NEG_INFINITY, DVec3::INFINITY);
    }
    let (centre, half) = (frame.world(low.midpoint(high)), 0.5 * (high - low));
    let extent = frame.rotation.x_axis.abs() * half.x
        + frame.rotation.y_axis.abs() * half.y
        + frame.rotation.z_axis.abs() * half.z;
    (centre - extent, centre + extent)
}

/// Frames of the island's bodies in a state of the substep.
pub(crate) fn frame_in(state: TestedState, island: &IslandView, workspace: &ContactWorkspace, body: u32) -> RigidFrame {
    let bodies = match state {
        TestedState::Start => &workspace.saved_solver_bodies,
        TestedState::End => &island.solver_bodies,
    };
    bodies.get(body as usize).map_or(RigidFrame::IDENTITY, |b| frame_of_body(&b.start))
}
