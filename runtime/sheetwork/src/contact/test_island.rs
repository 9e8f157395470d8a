//! Islands small enough to solve by hand: loose nodes, springs between them, static and dynamic
//! bodies, and contacts that the test lists in place of detection.

use glam::{DQuat, DVec3};

use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::collision::narrow_phase::feature_keys::{FeatureKind, feature_key};
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::node_side;
use crate::contact::outer_iteration::{ContactMargins, DetectionMode, StageSolve, solve_explicit, solve_stage};
use crate::contact::solver_body::SolverBody;
use crate::contact::workspace::ContactWorkspace;
use crate::contact::{IslandView, SheetContact};
use crate::mesh::spring_class::SpringClass;
use crate::rigid::{BodyState, MassProperties};
use crate::scene::IntegratorKind;
use crate::scene::sht::{SheetFile, SheetFileNode, SheetFileSpring};
use crate::sheet::{Field, Sheet, from_file, node_contact, stage};

/// A sheet of `side` × `side` nodes of mass `mass` (kg) at 1 m intervals along x, with the springs
/// (nodes, stiffness in N/m, rest length in m).
pub(crate) fn loose_nodes(side: u32, mass: f64, springs: &[(u32, u32, f64, f64)], kind: IntegratorKind) -> Sheet {
    let node = |i| SheetFileNode { position: DVec3::new(f64::from(i), 0.0, 0.0), mass, ..SheetFileNode::default() };
    let spring = |(a, b, stiffness, rest): &(u32, u32, f64, f64)| SheetFileSpring {
        kind: SpringClass::X,
        a: *a,
        b: *b,
        stiffness: *stiffness,
        rest: *rest,
    };
    let count = side * side;
    let file = SheetFile {
        masses: (0..count).map(node).collect(),
        springs: springs.iter().map(spring).collect(),
        corners: [0, side - 1, count - side, count - 1],
        centre: count / 2,
        dimensions: [side, 1, side],
        damping: 0.0,
        structure: "provot2d".into(),
    };
    let mut sheet = from_file(&file).expect("a valid sheet");
    sheet.set_engine(kind, 1e-9);
    sheet
}

/// A dynamic ball of mass `mass` (kg) and radius 0.1 m with its centre at `at` (m).
pub(crate) fn ball(mass: f64, at: DVec3) -> SolverBody {
    let principal = DVec3::splat(0.4 * mass * 0.1 * 0.1);
    let spread = MassProperties { mass, centre: DVec3::ZERO, principal, axes: DQuat::IDENTITY };
    at_rest(BodyState::new(spread, at, DQuat::IDENTITY, DVec3::ZERO, DVec3::ZERO))
}

/// A static body at the origin.
pub(crate) fn fixed_body() -> SolverBody {
    at_rest(BodyState::fixed_at(DVec3::ZERO, DQuat::IDENTITY))
}

/// A body that does not move in the stage.
fn at_rest(state: BodyState) -> SolverBody {
    let mut body = SolverBody::new(state);
    body.begin(state);
    body
}

/// Side of a contact at the point `local` (m) of body number `body`.
pub(crate) fn body_side(body: u32, local: DVec3) -> ContactSide {
    ContactSide::Body { body, local }
}

/// A contact without friction and restitution; `index` distinguishes its key.
pub(crate) fn contact(index: u32, a: ContactSide, b: ContactSide, normal: DVec3) -> ContactConstraint {
    let on = match b {
        ContactSide::Sheet { sheet, point: SheetPoint { nodes, .. } } => {
            feature_key(FeatureKind::Triangle, sheet, nodes[0])
        }
        ContactSide::Body { body, .. } => feature_key(FeatureKind::Face, body, 0),
    };
    let key = [feature_key(FeatureKind::Node, 0, index), on];
    ContactConstraint { a, b, normal, offset: 0.0, key, friction: 0.0, restitution: 0.0, bond: 0.0, compressed: None }
}

/// A contact of node `node` of sheet 0 with the plane of normal `normal` through the origin of the
/// static body 0.
pub(crate) fn on_plane(node: u32, normal: DVec3) -> ContactConstraint {
    contact(node, node_side(0, node), body_side(0, DVec3::ZERO), normal)
}

/// An island with its contact workspace.
pub(crate) struct TestIsland {
    pub sheets: Vec<Sheet>,
    contacts: Vec<SheetContact>,
    pub bodies: Vec<SolverBody>,
    pub workspace: ContactWorkspace,
    pub field: Field,
}

impl TestIsland {
    /// An island of `sheets` and `bodies` in the gravity `gravity` (m/s²).
    pub fn new(sheets: Vec<Sheet>, bodies: Vec<SolverBody>, gravity: DVec3) -> Self {
        Self {
            contacts: sheets.iter().map(|_| SheetContact::default()).collect(),
            sheets,
            bodies,
            workspace: ContactWorkspace::default(),
            field: Field { gravity, ..Field::default() },
        }
    }

    /// Call `work` with the island and its workspace.
    pub fn with<R>(&mut self, work: impl FnOnce(&mut IslandView, &mut ContactWorkspace) -> R) -> R {
        let mut view = IslandView {
            sheets: &mut self.sheets,
            contacts: &mut self.contacts,
            solver_bodies: std::mem::take(&mut self.bodies),
            parallel: false,
            body_penetration: 0.0,
            stacked_bodies: 0,
        };
        let result = work(&mut view, &mut self.workspace);
        self.bodies = std::mem::take(&mut view.solver_bodies);
        result
    }

    /// Begin the first stage of a step of `dt` (s). Bodies without contact end as they are moved
    /// already.
    pub fn begin_stage(&mut self, dt: f64) {
        for sheet in &mut self.sheets {
            stage::begin_step(sheet, self.field, dt);
            stage::prepare_stage(sheet, self.field, 0, dt);
        }
    }

    /// Solve the first stage of a step of `dt` (s) with `contacts`, sorted by key.
    pub fn solve_stage(&mut self, dt: f64, contacts: &[ContactConstraint]) -> StageSolve {
        self.solve_stage_with(dt, |mode, _| if mode == DetectionMode::SheetCrossing { &[] } else { contacts })
    }

    /// Solve the first stage of a step of `dt` (s) with the contacts, sorted by key, that `detect`
    /// returns for a detection mode and margins.
    pub fn solve_stage_with<'c>(
        &mut self,
        dt: f64,
        mut detect: impl FnMut(DetectionMode, ContactMargins) -> &'c [ContactConstraint],
    ) -> StageSolve {
        self.begin_stage(dt);
        let (field, h) = (self.field, self.sheets[0].work.stage.h);
        self.with(|view, workspace| {
            solve_stage(view, workspace, field, h, |_, mode, margins, detected| {
                let contacts = detect(mode, margins);
                assert!(contacts.is_sorted_by_key(|c| c.key));
                detected.clear();
                list(contacts, detected);
            })
        })
    }

    /// Solve the velocities after [`TestIsland::solve_stage`], and finish the stage of the sheets.
    pub fn finish_stage(&mut self, dt: f64) {
        let (field, h) = (self.field, self.sheets[0].work.stage.h);
        self.with(|view, workspace| {
            view.for_each_sheet(|sheet| stage::compute_free_velocity(sheet, field));
            assert!(workspace.solve_velocities(view, h));
            view.each_response(|sheet, response| stage::finish_stage(sheet, field, 0, dt, Some(&response.jump)));
        });
    }

    /// Take a step of `h` (s) of sheets with explicit integrators, whose free motion ends at
    /// `x` + `h` `v`.
    pub fn solve_explicit(&mut self, h: f64, contacts: &[ContactConstraint]) -> bool {
        for sheet in &mut self.sheets {
            node_contact::resize_workspace(sheet);
            node_contact::save_start(sheet);
            let v = sheet.state.v.clone();
            sheet.state.x.add_scaled(h, &v);
            node_contact::begin_contact_stage(sheet, h);
        }
        let touched =
            self.with(|view, workspace| solve_explicit(view, workspace, h, |_, detected| list(contacts, detected)));
        self.with(|view, _| {
            view.each_response(|sheet, response| node_contact::apply_contact(sheet, touched.then_some(&response.jump)))
        });
        touched
    }

    /// Force of the position solve at `contact` on its side a, N; zero if it is open.
    pub fn force(&self, contact: &ContactConstraint) -> DVec3 {
        self.workspace.force_of(&contact.key).unwrap_or_default()
    }

    /// Position of node `i` of sheet 0 at the iterate, m.
    pub fn iterate(&self, i: usize) -> DVec3 {
        self.sheets[0].work.stage.iterate.get(i)
    }
}

/// Write `contacts` to `detected`.
pub(crate) fn list(contacts: &[ContactConstraint], detected: &mut DetectedContacts) {
    detected.contacts.extend_from_slice(contacts);
    detected.colliders.resize(contacts.len(), 0);
    detected.first_attachment = contacts.len();
}
