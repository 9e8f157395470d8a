//! Thin-plate aerodynamics: force and centre of pressure of a stiff plate at rest in a wind, and
//! the glide of a weighted card, against the formulas of Rayleigh and Helmbold.

use glam::DVec3;
use sheetwork::World;
use sheetwork_tests::world_of;

const DENSITY: f64 = 1.2;
const ACROSS: f64 = 1.17;
const ALONG: f64 = 0.02;

/// Normal force coefficient at the incidence `alpha` (rad) and the aspect ratio `ratio`.
fn normal_coefficient(alpha: f64, ratio: f64) -> f64 {
    let slope = std::f64::consts::TAU * ratio / (2.0 + (4.0 + ratio * ratio).sqrt());
    slope * alpha.sin() / (1.0 + (slope / ACROSS - 1.0) * alpha.sin())
}

/// Centre of pressure ahead of the middle, in chords (Rayleigh).
fn pressure_centre(alpha: f64) -> f64 {
    0.75 * alpha.cos() / (4.0 + std::f64::consts::PI * alpha.sin())
}

#[test]
fn a_plate_has_the_normal_force_and_the_centre_of_pressure_of_the_formulas() {
    let (chord, span, speed) = (0.2, 0.3, 7.0);
    for degrees in [2.0_f64, 5.0, 10.0, 20.0, 45.0, 90.0] {
        let alpha = degrees.to_radians();
        // The plate flies along x: the wind comes from there and from below.
        let (wx, wy) = (-speed * alpha.cos(), speed * alpha.sin());
        let mut world = world_of(&format!(
            "(engine: \"backward-euler\", dt: 1e-5, gravity: (0, 0, 0), air: (density: {DENSITY}, wind: ({wx}, {wy}, 0)),
              sheets: [(structure: \"shell\", grid: (21, 1, 21), size: ({chord}, {span}), aerodynamics: Plate,
                  material: (young: 2e11, density: 2000, thickness: 0.001))])"
        ));
        let dt = world.dt();
        world.step();
        let sheet = &world.sheets()[0];
        let force = sheet.momentum() / dt;
        let each =
            (0..sheet.node_count()).map(|i| sheet.state.x.get(i).cross(sheet.state.v.get(i)) * sheet.node_mass(i));
        let moment: DVec3 = each.sum::<DVec3>() / dt;
        let pressure = 0.5 * DENSITY * speed * speed * chord * span;
        let (found, wanted) = (force.y / pressure, normal_coefficient(alpha, span / chord));
        assert!((found / wanted - 1.0).abs() < 0.01, "{degrees}: C_N {found} {wanted}");
        // M_z = x F_y.
        let (found, wanted) = (moment.z / force.y / chord, pressure_centre(alpha));
        assert!((found - wanted).abs() < 0.004, "{degrees}: x_p/c {found} {wanted}");
        let (found, wanted) = (-force.x / pressure, ALONG * alpha.cos().powi(2));
        assert!((found - wanted).abs() < 1e-4, "{degrees}: C_T {found} {wanted}");
    }
}

/// Card of 17 g with a clip at its front edge that puts the centre of weight where the pressure
/// acts at an incidence of 8°.
struct Card {
    world: World,
    /// Lift over drag.
    ratio: f64,
    /// Speed, m/s.
    speed: f64,
}

impl Card {
    const CHORD: f64 = 0.15;
    const SPAN: f64 = 0.25;
    /// Distance of the clip ahead of the middle, m.
    const CLIP: f64 = 0.08;

    /// The card in its steady glide by the formulas.
    fn new(law: &str) -> Self {
        let (chord, span, alpha) = (Self::CHORD, Self::SPAN, 8.0_f64.to_radians());
        let (normal, friction) = (normal_coefficient(alpha, span / chord), ALONG * alpha.cos().powi(2));
        let lift = normal * alpha.cos() - friction * alpha.sin();
        let drag = normal * alpha.sin() + friction * alpha.cos();
        let (mass, centre) = (1500.0 * 3e-4 * chord * span, pressure_centre(alpha) * chord);
        let clip = mass * centre / (Self::CLIP - centre);
        let speed = (2.0 * (mass + clip) * 9.81 / (DENSITY * chord * span * lift.hypot(drag))).sqrt();
        let path = (drag / lift).atan();
        let (vx, vy, pitch) = (speed * path.cos(), -speed * path.sin(), alpha - path);
        let (x, y, degrees) = (Self::CLIP * pitch.cos(), Self::CLIP * pitch.sin(), pitch.to_degrees());
        let world = world_of(&format!(
            "(dt: 0.01, air: (density: {DENSITY}),
              sheets: [(structure: \"shell\", grid: (13, 1, 11), size: ({chord}, {span}), aerodynamics: {law},
                material: (young: 2e11, density: 1500, thickness: 3e-4), placement: (rotation: (0, 0, {degrees})),
                velocity: ({vx}, {vy}, 0), pins: [(region: Rect((0.9, 1), (0, 1)), body: \"clip\")])],
              bodies: [(name: \"clip\", shape: Box((0.004, 0.004, {span})), mass: {clip}, velocity: ({vx}, {vy}, 0),
                placement: (position: ({x}, {y}, 0), rotation: (0, 0, {degrees})))])"
        ));
        Self { world, ratio: lift / drag, speed }
    }

    /// Displacement between the times `from` and `to`, s.
    fn way(&mut self, from: f64, to: f64) -> DVec3 {
        self.world.advance(from);
        let start = self.world.sheets()[0].centre_of_mass();
        self.world.advance(to - from);
        self.world.sheets()[0].centre_of_mass() - start
    }
}

#[test]
fn a_weighted_card_glides_at_the_ratio_and_the_speed_of_the_formulas() {
    let mut card = Card::new("Plate");
    let way = card.way(5.0, 10.0);
    // A flat card has nothing that holds its heading, and turns slowly.
    let (ratio, speed) = (-way.x.hypot(way.z) / way.y, way.length() / 5.0);
    println!("L/D {ratio:.3} (formula {:.3}), speed {speed:.3} m/s (formula {:.3})", card.ratio, card.speed);
    assert!((ratio / card.ratio - 1.0).abs() < 0.05, "lift over drag {ratio} {}", card.ratio);
    assert!((speed / card.speed - 1.0).abs() < 0.05, "speed {speed} {}", card.speed);
    assert!(way.z.abs() < 0.5 * way.x, "{way}");
}

#[test]
fn the_law_of_drag_alone_does_not_glide() {
    let way = Card::new("Drag").way(0.0, 4.0);
    assert!(way.x < -way.y, "{way}");
}
