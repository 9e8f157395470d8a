//! Air in wind zones: velocity, density and buoyancy at each node of a sheet, once per step.
//!
//! | part | formula | source |
//! |---|---|---|
//! | gusts | V (1 + A (1 - cos 2πτ/T)/2) | Pratt and Walker, NACA TR 1206, 1954 |
//! | turbulence | Fourier modes | `turbulence` |
//! | vortex | Γ/(2πr) (1 - exp(-r²/c²)) | Lamb-Oseen; Saffman, *Vortex Dynamics*, 1992 |
//! | blast | u = P (1 - s) exp(-s)/(ρ c), s = τ/T | Friedlander, 1946; acoustic wave |
//! | bodies | potential flow and far wake | `wake` |
//! | fluid | f = -ρ V g | Archimedes |
//!
//! A blast is shorter than a step: its velocity in a step is that with the mean of u |u| over the
//! step, which gives the impulse of the drag.

mod settings;
mod turbulence;
mod wake;

use glam::{DQuat, DVec3};
use rapier3d::prelude::{QueryPipeline, Ray};

use crate::rigid::RigidView;
use crate::scene::{BlastSpec, FluidSpec, GustSpec, VortexSpec, WindZone, ZoneVolume};
use crate::sheet::wind::settings::WindSettings;
use crate::sheet::wind::turbulence::{Turbulence, cosine_of_turns};
use crate::sheet::wind::wake::MovingBody;
use crate::sheet::{Field, Sheet, Status};

const SETTINGS: WindSettings = WindSettings::DEFAULT;

/// Air at the nodes of a sheet during a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct NodeAir {
    /// Velocity, m/s.
    pub wind: Vec<DVec3>,
    /// Density, kg/m³.
    pub density: Vec<f64>,
    /// Buoyancy, N; empty without a fluid.
    pub buoyancy: Vec<DVec3>,
    /// Square of the largest speed, m²/s².
    pub largest_squared: f64,
}

impl NodeAir {
    /// Remove the air of all nodes.
    fn clear(&mut self) {
        self.wind.clear();
        self.density.clear();
        self.buoyancy.clear();
        self.largest_squared = 0.0;
    }

    /// Set the air of `nodes` nodes to that of `field`.
    pub fn set_uniform(&mut self, field: &Field, nodes: usize) {
        self.clear();
        self.wind.resize(nodes, field.wind);
        self.density.resize(nodes, field.air_density);
        self.largest_squared = field.wind.length_squared();
    }
}

/// Zone with its precomputed parts.
#[derive(Clone, Debug)]
struct Zone {
    spec: WindZone,
    rotation: DQuat,
    /// Mean velocity in the world, m/s.
    mean: DVec3,
    turbulence: Option<Turbulence>,
}

/// Step for which the air is evaluated.
#[derive(Clone, Copy)]
pub(crate) struct WindStep<'a> {
    pub field: Field,
    /// Start of the step, s.
    pub time: f64,
    /// Duration of the step, s.
    pub dt: f64,
    pub view: Option<&'a RigidView<'a>>,
}

/// Air of a place and a step.
#[derive(Clone, Copy, Debug, Default)]
struct LocalAir {
    velocity: DVec3,
    density: f64,
    /// Density of the displaced fluid, kg/m³.
    displaced: f64,
}

/// Zones of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct WindField {
    zones: Vec<Zone>,
    bodies: Vec<MovingBody>,
}

impl WindField {
    pub fn new(zones: &[WindZone]) -> Self {
        let each = zones.iter().map(|spec| {
            let rotation = spec.placement.quaternion();
            let turbulence = spec.turbulence.as_ref().map(Turbulence::new);
            Zone { spec: spec.clone(), rotation, mean: rotation * spec.velocity, turbulence }
        });
        Self { zones: each.collect(), bodies: Vec::new() }
    }

    /// Read the motion of the bodies, where a zone asks for it.
    pub fn begin_step(&mut self, view: Option<&RigidView>) {
        self.bodies.clear();
        if let Some(view) = view.filter(|_| self.zones.iter().any(|zone| zone.spec.wakes)) {
            MovingBody::collect(view, &mut self.bodies);
        }
    }

    /// Evaluate the air at the nodes of a sheet that is awake, or of every sheet for a step of no
    /// duration. Unsteady wind that bears a tenth of its weight wakes a sleeping one.
    pub fn update_sheet(&self, sheet: &mut Sheet, step: &WindStep) {
        if sheet.state.status == Status::Asleep && step.dt > 0.0 && self.wakes(sheet, step) {
            sheet.wake();
        }
        let mut air = sheet.parameters.drag.take_nodes().unwrap_or_default();
        air.clear();
        if sheet.state.status == Status::Awake || step.dt == 0.0 {
            self.sample(sheet, step, &mut air);
        }
        sheet.parameters.drag.set_nodes(air);
    }

    /// Evaluate the air at the nodes of a sheet.
    fn sample(&self, sheet: &Sheet, step: &WindStep, air: &mut NodeAir) {
        let shelters = self.zones.iter().any(|zone| zone.spec.shelter > 0.0);
        let query = step.view.filter(|_| shelters).map(RigidView::query);
        let has_fluid = self.zones.iter().any(|zone| zone.spec.fluid.is_some());
        let gravity = step.field.gravity / sheet.parameters.material.density;
        for (i, x) in sheet.state.x.iter().enumerate() {
            let local = self.at(x, step, (query.as_ref(), sheet.parameters.material.thickness));
            air.largest_squared = air.largest_squared.max(local.velocity.length_squared());
            air.wind.push(local.velocity);
            air.density.push(local.density);
            if has_fluid {
                air.buoyancy.push(gravity * (-local.displaced * sheet.model.mass[i]));
            }
        }
    }

    /// Whether the air around a sleeping sheet changes enough to move it.
    fn wakes(&self, sheet: &Sheet, step: &WindStep) -> bool {
        let Some(bounds) = sheet.state.x.bounds() else { return false };
        let load = SETTINGS.waking_load * sheet.total_mass() * step.field.gravity.length();
        let area = sheet.model.extent.0 * sheet.model.extent.1;
        let moves = |speed: f64| 0.5 * SETTINGS.air_density * speed * speed * area >= load;
        let reaching = self.zones.iter().filter(|zone| zone.meets(bounds));
        let by_zone = |zone: &Zone| {
            let gusts = zone.spec.gusts.map_or(0.0, |gusts| gusts.amplitude * zone.mean.length());
            let turbulent = zone.spec.turbulence.map_or(0.0, |turbulence| 3.0 * turbulence.intensity);
            let unsteady = gusts + turbulent;
            let bodies = self.bodies.iter().filter(|body| zone.spec.wakes && body.reaches(bounds));
            let pushed = bodies.map(|body| body.velocity.length()).fold(0.0, f64::max);
            let blown = zone.spec.blast.is_some_and(|blast| is_blasting(&blast, zone.origin(), bounds, step));
            blown || (unsteady > 0.0 && moves(unsteady + zone.mean.length())) || (pushed > 0.0 && moves(pushed))
        };
        reaching.into_iter().any(by_zone)
    }

    /// Air at `x` (m); `thickness` (m) of the sheet smooths the surface of a fluid.
    fn at(&self, x: DVec3, step: &WindStep, (query, thickness): (Option<&QueryPipeline>, f64)) -> LocalAir {
        let mut air = LocalAir { velocity: step.field.wind, density: step.field.air_density, displaced: 0.0 };
        for zone in &self.zones {
            let place = zone.rotation.conjugate() * (x - zone.origin());
            let weight = zone.weight(place);
            if weight == 0.0 {
                continue;
            }
            if air.density == 0.0 {
                air.density = SETTINGS.air_density;
            }
            let mut velocity = zone.velocity(x, place, step.time + 0.5 * step.dt);
            if zone.spec.shelter > 0.0 && query.is_some_and(|query| is_sheltered(query, x, velocity, zone.spec.shelter))
            {
                velocity = DVec3::ZERO;
            }
            if let Some(blast) = &zone.spec.blast {
                velocity += blast_velocity(blast, x - zone.origin(), air.density, step);
            }
            if zone.spec.wakes {
                velocity += self.bodies.iter().map(|body| body.induced(x)).sum::<DVec3>();
            }
            air.velocity += velocity * weight;
            if let Some(fluid) = &zone.spec.fluid {
                let part = weight * submerged(fluid, x.y, zone.spec.falloff.max(thickness));
                air.displaced += (fluid.density - air.displaced) * part;
                air.density += (fluid.density - air.density) * part;
            }
        }
        air
    }
}

impl Zone {
    fn origin(&self) -> DVec3 {
        self.spec.placement.position
    }

    /// Distance (m) of the place inside the border, negative outside.
    fn depth(&self, place: DVec3) -> f64 {
        match self.spec.volume {
            ZoneVolume::Everywhere => f64::INFINITY,
            ZoneVolume::Box(edges) => (edges * 0.5 - place.abs()).min_element(),
            ZoneVolume::Ball(radius) => radius - place.length(),
            ZoneVolume::Cylinder(radius, height) => (radius - place.x.hypot(place.z)).min(0.5 * height - place.y.abs()),
        }
    }

    /// Weight of the zone at a place: a smooth step from 0 at the border to 1.
    fn weight(&self, place: DVec3) -> f64 {
        let depth = self.depth(place);
        if depth <= 0.0 || depth >= self.spec.falloff {
            return if depth > 0.0 { 1.0 } else { 0.0 };
        }
        let s = depth / self.spec.falloff;
        s * s * (3.0 - 2.0 * s)
    }

    /// Whether it may meet the box from `low` to `high` (m).
    fn meets(&self, (low, high): (DVec3, DVec3)) -> bool {
        let reach = match self.spec.volume {
            ZoneVolume::Everywhere => return true,
            ZoneVolume::Box(edges) => 0.5 * edges.length(),
            ZoneVolume::Ball(radius) => radius,
            ZoneVolume::Cylinder(radius, height) => radius.hypot(0.5 * height),
        };
        self.origin().clamp(low, high).distance_squared(self.origin()) <= reach * reach
    }

    /// Mean velocity with gusts, turbulence and vortex at `x` (m), `place` in its axes, at `time`
    /// (s), m/s.
    fn velocity(&self, x: DVec3, place: DVec3, time: f64) -> DVec3 {
        let mut velocity = self.mean;
        if let Some(gusts) = &self.spec.gusts {
            velocity *= gust_factor(gusts, time - travel_time(self.mean, x - self.origin()));
        }
        if let Some(turbulence) = &self.turbulence {
            velocity += turbulence.velocity(x - self.mean * time, time);
        }
        if let Some(vortex) = &self.spec.vortex {
            velocity += self.rotation * vortex_velocity(vortex, place);
        }
        velocity
    }
}

/// Time (s) in which the mean velocity (m/s) reaches the place `away` (m).
fn travel_time(mean: DVec3, away: DVec3) -> f64 {
    let squared = mean.length_squared();
    if squared > 0.0 { mean.dot(away) / squared } else { 0.0 }
}

/// Factor of the mean velocity at `time` (s).
fn gust_factor(gusts: &GustSpec, time: f64) -> f64 {
    let since = time.rem_euclid(gusts.period);
    if since >= gusts.duration {
        return 1.0;
    }
    1.0 + 0.5 * gusts.amplitude * (1.0 - cosine_of_turns(since / gusts.duration))
}

/// Velocity at a place in the axes of the vortex, m/s.
fn vortex_velocity(vortex: &VortexSpec, place: DVec3) -> DVec3 {
    let squared = place.x * place.x + place.z * place.z;
    let ratio = squared / (vortex.core * vortex.core);
    // 1 - exp(-q) ≈ q near the axis.
    let inside = if ratio > 1e-9 { -(-ratio).exp_m1() / squared } else { 1.0 / (vortex.core * vortex.core) };
    DVec3::new(place.z, 0.0, -place.x) * (vortex.circulation / std::f64::consts::TAU * inside)
}

/// Radial velocity of a blast at the place `away` (m), with the mean of u |u| over the step, m/s.
fn blast_velocity(blast: &BlastSpec, away: DVec3, density: f64, step: &WindStep) -> DVec3 {
    let distance = away.length();
    let since = (step.time - blast.time - distance / SETTINGS.speed_of_sound) / blast.duration;
    let until = since + step.dt / blast.duration;
    if until <= 0.0 || since >= SETTINGS.blast_end || step.dt <= 0.0 {
        return DVec3::ZERO;
    }
    let peak = blast.overpressure / (density * SETTINGS.speed_of_sound) * (blast.radius / distance.max(blast.radius));
    // Integral of (1 - s)² exp(-2s).
    let integral = |s: f64| -(-2.0 * s).exp() * (0.5 * s * s - 0.5 * s + 0.25);
    let (from, to) = (since.max(0.0), until);
    let outward = integral(to.min(1.0)) - integral(from.min(1.0));
    let inward = integral(to.max(1.0)) - integral(from.max(1.0));
    let mean = (outward - inward) / (until - since);
    away.normalize_or_zero() * (peak * mean.signum() * mean.abs().sqrt())
}

/// Whether a blast passes the box from `low` to `high` (m) during the step.
fn is_blasting(blast: &BlastSpec, origin: DVec3, (low, high): (DVec3, DVec3), step: &WindStep) -> bool {
    let near = origin.clamp(low, high).distance(origin) / SETTINGS.speed_of_sound;
    let far = near + low.distance(high) / SETTINGS.speed_of_sound;
    step.time + step.dt > blast.time + near && step.time < blast.time + far + SETTINGS.blast_end * blast.duration
}

/// Whether a body stands within `distance` (m) upwind of `x` (m).
fn is_sheltered(query: &QueryPipeline, x: DVec3, velocity: DVec3, distance: f64) -> bool {
    let upwind = -velocity.normalize_or_zero();
    if upwind == DVec3::ZERO {
        return false;
    }
    let ray = Ray::new(x.as_vec3(), upwind.as_vec3());
    query.cast_ray(&ray, distance as f32, true).is_some()
}

/// Part of a node at the height `y` (m) that is below the surface, smoothed over `width` (m).
fn submerged(fluid: &FluidSpec, y: f64, width: f64) -> f64 {
    ((fluid.surface - y) / width + 0.5).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(time: f64, dt: f64) -> WindStep<'static> {
        WindStep { field: Field::default(), time, dt, view: None }
    }

    fn at(zone: WindZone, x: DVec3, time: f64) -> LocalAir {
        WindField::new(&[zone]).at(x, &step(time, 0.0), (None, 1e-4))
    }

    #[test]
    fn a_zone_fades_at_its_border_and_turns_with_its_placement() {
        let mut zone = WindZone { velocity: DVec3::X * 4.0, falloff: 0.5, ..WindZone::default() };
        zone.placement.position = DVec3::new(1.0, 0.0, 0.0);
        zone.placement.rotation = DVec3::new(0.0, 0.0, 90.0);
        for volume in [ZoneVolume::Box(DVec3::splat(4.0)), ZoneVolume::Ball(2.0), ZoneVolume::Cylinder(2.0, 4.0)] {
            let zone = WindZone { volume, ..zone.clone() };
            let speed = |x: f64| at(zone.clone(), DVec3::new(x, 0.0, 0.0), 0.0).velocity;
            assert!(speed(1.0).distance(DVec3::Y * 4.0) < 1e-12, "{volume:?}");
            assert!((speed(2.75).y - 2.0).abs() < 1e-12, "{volume:?}: half way through the border");
            assert_eq!(speed(3.01), DVec3::ZERO);
        }
    }

    #[test]
    fn gusts_rise_by_their_amplitude_and_travel_with_the_wind() {
        let gusts = Some(GustSpec { amplitude: 0.5, duration: 2.0, period: 5.0 });
        let zone = WindZone { velocity: DVec3::X * 4.0, gusts, ..WindZone::default() };
        let speed = |x: f64, time: f64| at(zone.clone(), DVec3::X * x, time).velocity.x;
        assert!((speed(0.0, 1.0) - 6.0).abs() < 1e-8 && (speed(0.0, 3.0) - 4.0).abs() < 1e-12);
        assert!((speed(0.0, 6.0) - 6.0).abs() < 1e-8, "the next gust");
        assert!((speed(8.0, 3.0) - 6.0).abs() < 1e-8, "two seconds later, 8 m downwind");
    }

    #[test]
    fn a_vortex_has_its_circulation_outside_the_core_and_turns_rigidly_inside() {
        let vortex = Some(VortexSpec { circulation: 3.0, core: 0.1 });
        let zone = WindZone { vortex, ..WindZone::default() };
        let far = at(zone.clone(), DVec3::new(1.0, 5.0, 0.0), 0.0).velocity;
        assert!(far.distance(DVec3::NEG_Z * (3.0 / std::f64::consts::TAU)) < 1e-12, "{far}");
        let near = at(zone, DVec3::new(1e-4, 0.0, 0.0), 0.0).velocity;
        assert!((near.z * 1e4 + 3.0 / (std::f64::consts::TAU * 0.01)).abs() < 1e-3, "{near}");
    }

    #[test]
    fn the_impulse_of_a_blast_does_not_depend_on_the_step() {
        let blast = BlastSpec { time: 0.1, overpressure: 5000.0, radius: 1.0, duration: 0.004 };
        let impulse = |dt: f64| -> f64 {
            let steps = (0.4 / dt) as usize;
            let each = (0..steps).map(|i| {
                let u = blast_velocity(&blast, DVec3::X * 3.0, 1.2, &step(i as f64 * dt, dt)).x;
                u * u.abs() * dt
            });
            each.sum()
        };
        let peak = 5000.0 / (1.2 * SETTINGS.speed_of_sound) / 3.0;
        // Outward (1 - exp(-2))/4, inward exp(-2)/4 by integration of (1 - s)² exp(-2s).
        let exact = peak * peak * 0.004 * (0.25 - 0.5 * (-2.0_f64).exp());
        for dt in [1e-4, 1e-3, 0.02] {
            assert!((impulse(dt) / exact - 1.0).abs() < 1e-6, "{dt}: {} {exact}", impulse(dt));
        }
    }

    #[test]
    fn a_fluid_ends_at_its_surface() {
        let fluid = Some(FluidSpec { density: 1000.0, surface: 0.2 });
        let zone = WindZone { fluid, ..WindZone::default() };
        let below = at(zone.clone(), DVec3::ZERO, 0.0);
        assert_eq!((below.density, below.displaced), (1000.0, 1000.0));
        assert_eq!(at(zone.clone(), DVec3::Y * 0.3, 0.0).displaced, 0.0);
        assert!((at(zone, DVec3::Y * 0.2, 0.0).displaced - 500.0).abs() < 1e-9);
    }
}
