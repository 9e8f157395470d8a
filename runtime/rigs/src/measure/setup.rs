//! Input of the rigs: sheet, integrator and situation, with the defaults of the command line.

use std::path::Path;

use clap::{Args, Command};
use glam::DVec3;

use crate::measure::thermal::Thermal;
use crate::output::parse_counts;
use crate::quantities::{acceleration, angle, density, length, parse_number, pressure, speed, time};
use sheetwork::collision::overlap::half_thickness;
use sheetwork::mesh::outline::OutlineSpec;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    Air, BurgersCreep, ContactDefaults, IntegratorKind, Material, MaterialChoice, PinSpec, Region, Scene, SheetSpec,
    SpringLaw,
};
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, ParameterId as Id, World, check_range};

/// Minimum gravity of rigs in which a sheet falls, lies or slides, m/s². Without gravity the sheet
/// never arrives.
const MINIMUM_GRAVITY: f64 = 0.01;

/// Minimum step, s.
const MINIMUM_STEP: f64 = 1e-7;

/// The sheet and its situation, as given by the flags of `sheetwork measure`. Each rig uses a part
/// of the fields; [`Setup::check`] has their ranges.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Setup {
    /// Structure.
    #[arg(long, default_value = "shell")]
    pub structure: StructureKind,
    /// Nodes along length and width of the bottom layer.
    #[arg(long, default_value = "21x21", value_parser = parse_grid)]
    pub grid: (u32, u32),
    /// Number of layers; default 2, limited to the structure's range.
    #[arg(long)]
    pub layers: Option<u32>,
    /// Time integrator.
    #[arg(long, default_value = "tr-bdf2")]
    pub engine: IntegratorKind,
    /// Rule by which springs get their stiffness from the material.
    #[arg(skip = SpringLaw::Calibrated)]
    pub springs: SpringLaw,
    /// Distance of the layers, m; `None` for half of the node spacing.
    #[arg(skip)]
    pub gap: Option<f64>,
    /// Step, s, or a fraction such as 1/60. Default: 1/60 with an implicit integrator, a stable
    /// step with an explicit one.
    #[arg(long, value_parser = time)]
    pub dt: Option<f64>,
    /// Material: modulus, density, thickness.
    #[arg(skip = default_material())]
    pub material: Material,
    /// Flags that replace elastic constants of `material`.
    #[command(flatten)]
    pub elastic: ElasticFlags,
    /// Length of the sheet, m (default 0.25), or of the bending part (fold, default 0.02).
    #[arg(long, default_value = "0.25", default_value_if("case", "fold", "0.02"))]
    #[arg(hide_default_value = true, value_parser = length)]
    pub length: f64,
    /// Width of the sheet, m.
    #[arg(long, default_value = "0.25", value_parser = length)]
    pub width: f64,
    /// Gravity, m/s².
    #[arg(long, default_value = "9.81", value_parser = acceleration)]
    pub gravity: f64,
    /// Damping ratio of the slowest bending mode; for springs of rigs with bodies, a fraction of
    /// their critical damping.
    #[arg(long, default_value = "0.05", value_parser = parse_number)]
    pub damping_ratio: f64,
    /// Angle of the incline, of the landing sheet, or of the fold, degrees (default 20 for incline,
    /// 30 for edge-landing, 90 for fold).
    #[arg(long, default_value = "20", default_value_ifs([("case", "edge-landing", "30"), ("case", "fold", "90")]))]
    #[arg(hide_default_value = true, value_parser = angle)]
    pub angle: f64,
    /// Friction coefficient (rigs with bodies).
    #[arg(long, default_value = "0.3", value_parser = parse_number)]
    pub friction: f64,
    /// Restitution coefficient (rigs with bodies; default 0.5 for bounce, else 0).
    #[arg(long, default_value = "0", default_value_if("case", "bounce", "0.5"))]
    #[arg(hide_default_value = true, value_parser = parse_number)]
    pub restitution: f64,
    /// Drop height, m (default 0.2 for bounce, 0.05 for drop-box, 1 for edge-landing).
    #[arg(long, default_value = "0.2", default_value_ifs([("case", "drop-box", "0.05"), ("case", "edge-landing", "1")]))]
    #[arg(hide_default_value = true, value_parser = length)]
    pub height: f64,
    /// Initial speed, m/s (slide, impact).
    #[arg(long, default_value = "1", value_parser = speed)]
    pub speed: f64,
    /// Factor on the ball speed of the scene, 0.1 to 3 (card-house).
    #[arg(long, default_value = "1", value_parser = parse_number)]
    pub throw: f64,
    /// Angular velocity, rad/s (spin).
    #[arg(long, default_value = "10", value_parser = parse_number)]
    pub rate: f64,
    /// Boundary condition of the edges: cantilever, clamped, supported or free (frequency).
    #[arg(long, default_value = "cantilever")]
    pub boundary: Boundary,
    /// Number of vibration modes (frequency).
    #[arg(long, default_value = "3")]
    pub modes: u32,
    /// Side of the square, m; default the length (pedestal, supports).
    #[arg(long, value_parser = length)]
    pub side: Option<f64>,
    /// Side of the clamped patch, m (pedestal).
    #[arg(long, default_value = "0.05", value_parser = length)]
    pub patch: f64,
    /// Radius, m (disc).
    #[arg(long, default_value = "0.125", value_parser = length)]
    pub radius: f64,
    /// Diameter of the hole, m (hole).
    #[arg(long, default_value = "0.1", value_parser = length)]
    pub hole: f64,
    /// Side of the box, m (drop-box, weight).
    #[arg(long = "box", default_value = "0.1", value_parser = length)]
    pub box_side: f64,
    /// Number of sheets in the pile (stack).
    #[arg(long, default_value = "5")]
    pub sheets: u32,
    /// Land on a corner in place of an edge (edge-landing).
    #[arg(long)]
    pub corner: bool,
    /// Land with the surface on the ridge of a wedge, with --corner on the tip of a needle
    /// (edge-landing).
    #[arg(long)]
    pub edge_of_body: bool,
    /// Use a sheet with all nodes fixed in place of a plane (incline, slide), or a striking sheet
    /// in place of a ball (impact).
    #[arg(long)]
    pub on_sheet: bool,
    /// Number of halvings of the step, each with a measurement of the rebound (edge-landing).
    #[arg(long, default_value = "0")]
    pub refine: u32,
    /// Threads that step several sheets (stack, card-pack, card-house).
    #[arg(long, default_value = "1")]
    pub threads: u32,
    /// Flags that replace constants of yield and creep of `material`.
    #[command(flatten)]
    pub inelastic: InelasticFlags,
    /// Step from flat to rest in place of the equilibrium solution (cantilever and other
    /// equilibrium rigs).
    #[arg(long)]
    pub dynamic: bool,
    /// Mesh the rectangle with the triangles of sheets with an outline.
    #[arg(long)]
    pub outlined: bool,
    /// Input of the thermal rigs.
    #[command(flatten)]
    pub thermal: Thermal,
}

/// Elastic constants on the command line.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct ElasticFlags {
    /// Young's modulus, Pa (default 3e9).
    #[arg(long, value_parser = pressure)]
    young: Option<f64>,
    /// Poisson's ratio (default 0.35).
    #[arg(long, value_parser = parse_number)]
    poisson: Option<f64>,
    /// Density, kg/m³ (default 1050).
    #[arg(long, value_parser = density)]
    density: Option<f64>,
    /// Thickness, m (default 5e-4).
    #[arg(long, value_parser = length)]
    thickness: Option<f64>,
    /// Material by name or file, for constants without a flag above.
    #[arg(long)]
    material: Option<String>,
    /// Angle from the length of the sheet to the warp of an orthotropic material, degrees; an angle
    /// between the axes needs --outlined.
    #[arg(long, value_parser = angle)]
    direction: Option<f64>,
}

/// Constants of yield and creep on the command line.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct InelasticFlags {
    /// Yield stress, Pa (fold; default 3e7).
    #[arg(long, value_parser = pressure)]
    yield_stress: Option<f64>,
    /// Hardening modulus, Pa (fold; default 0).
    #[arg(long, value_parser = pressure)]
    hardening: Option<f64>,
    /// Relaxation time of the dashpot, s (creep; default 10).
    #[arg(long, value_parser = time)]
    relaxation_time: Option<f64>,
    /// Retardation time, s (creep; default 1).
    #[arg(long, value_parser = time)]
    retardation_time: Option<f64>,
    /// Retarded strain over instantaneous strain (creep; default 0.5).
    #[arg(long, value_parser = parse_number)]
    retarded: Option<f64>,
}

/// Boundary condition of the edges of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// One edge clamped.
    #[default]
    Cantilever,
    /// All edges clamped.
    Clamped,
    /// All edges fixed in position, with free rotation.
    Supported,
    /// All edges free.
    Free,
}

impl Boundary {
    const ALL: [Self; 4] = [Self::Cantilever, Self::Clamped, Self::Supported, Self::Free];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cantilever => "cantilever",
            Self::Clamped => "clamped",
            Self::Supported => "supported",
            Self::Free => "free",
        }
    }
}

impl std::str::FromStr for Boundary {
    type Err = InputError;

    fn from_str(name: &str) -> Result<Self, InputError> {
        Self::ALL
            .into_iter()
            .find(|b| b.name() == name)
            .ok_or_else(|| InputError::unknown_name("boundary", "boundary", name, &Self::ALL.map(Self::name)))
    }
}

impl Default for Setup {
    /// The defaults of the flags, and a restitution of 0.5.
    fn default() -> Self {
        Self { restitution: 0.5, ..flag_defaults() }
    }
}

/// Values of the flags of `T` on an empty command line.
pub(crate) fn flag_defaults<T: Args>() -> T {
    let command = T::augment_args(Command::new("defaults").no_binary_name(true));
    T::from_arg_matches(&command.get_matches_from([""; 0])).unwrap_or_else(|e| e.exit())
}

/// Parses nodes along two sides, as in `21x21`.
fn parse_grid(text: &str) -> Result<(u32, u32), String> {
    parse_counts::<2>(text).map(Into::into)
}

/// Polystyrene, with creep constants of its order.
fn default_material() -> Material {
    Material {
        young: 3e9,
        poisson: 0.35,
        density: 1050.0,
        thickness: 5e-4,
        yield_stress: Some(3e7),
        burgers: Some(DEFAULT_CREEP),
        ..Material::default()
    }
}

const DEFAULT_CREEP: BurgersCreep = BurgersCreep { relaxation_time: 10.0, retardation_time: 1.0, retarded: 0.5 };

impl Setup {
    /// Checks the range of every value.
    ///
    /// # Errors
    /// The first value out of range, named as its flag.
    pub fn check(&self) -> Result<(), InputError> {
        Id::GridLength.check("grid", self.grid.0.into())?;
        Id::GridWidth.check("grid", self.grid.1.into())?;
        let (fewest, most) = self.structure.info().layers;
        check_range("layers", self.layer_count().into(), fewest.into(), most.into(), "layers")?;
        self.dt.map_or(Ok(()), |dt| Id::TimeStep.check("dt", dt))?;
        sheetwork::scene::validate::material("material", &self.material)?;
        check_range("length", self.length, 1e-4, 100.0, "m")?;
        check_range("width", self.width, 1e-4, 100.0, "m")?;
        check_range("gravity", self.gravity, 0.0, 1e3, "m/s²")?;
        Id::DampingRatio.check("damping-ratio", self.damping_ratio)?;
        check_range("angle", self.angle, 0.0, 170.0, "degrees")?;
        Id::Friction.check("friction", self.friction)?;
        Id::Restitution.check("restitution", self.restitution)?;
        check_range("height", self.height, 1e-3, 1e3, "m")?;
        check_range("speed", self.speed, 1e-3, 100.0, "m/s")?;
        check_range("throw", self.throw, 0.1, 3.0, "times the scene's speed")?;
        check_range("rate", self.rate, 1e-3, 1e3, "rad/s")?;
        check_range("modes", self.modes.into(), 1.0, 50.0, "modes")?;
        check_range("patch", self.patch, 1e-5, 100.0, "m")?;
        check_range("radius", self.radius, 1e-4, 100.0, "m")?;
        check_range("hole", self.hole, 1e-5, 100.0, "m")?;
        check_range("box", self.box_side, 1e-3, 100.0, "m")?;
        check_range("sheets", self.sheets.into(), 1.0, 100.0, "sheets")?;
        check_range("threads", self.threads.into(), 1.0, 256.0, "threads")?;
        self.thermal.seconds.map_or(Ok(()), |seconds| check_range("seconds", seconds, 1e-3, 1e9, "s"))?;
        self.thermal.celsius.map_or(Ok(()), |celsius| Id::Temperature.check("celsius", celsius))?;
        check_range("refine", self.refine.into(), 0.0, 6.0, "halvings")?;
        self.thermal.check()?;
        self.side.map_or(Ok(()), |side| check_range("side", side, 1e-4, 100.0, "m"))
    }

    /// The set-up with the constants of its flags in its material.
    ///
    /// # Errors
    /// An unknown name or file of a material, or a direction of a material without warp.
    pub fn with_flags_applied(self) -> Result<Self, InputError> {
        let Self { elastic: e, inelastic: i, .. } = &self;
        let named = |name: &str| MaterialChoice::from(name).resolve(Path::new(""));
        let mut base = e.material.as_deref().map_or_else(|| Ok(self.material.clone()), named)?;
        if let Some(direction) = e.direction {
            let isotropic = || InputError::new("direction", "is for a material with stiffness along warp and weft");
            base.orthotropic.as_mut().ok_or_else(isotropic)?.direction = direction;
        }
        let gives_creep = [i.relaxation_time, i.retardation_time, i.retarded].iter().any(Option::is_some);
        let creep = base.burgers.or(gives_creep.then_some(DEFAULT_CREEP));
        let material = Material {
            young: e.young.unwrap_or(base.young),
            poisson: e.poisson.unwrap_or(base.poisson),
            density: e.density.unwrap_or(base.density),
            thickness: e.thickness.unwrap_or(base.thickness),
            yield_stress: i.yield_stress.or(base.yield_stress),
            hardening: i.hardening.unwrap_or(base.hardening),
            burgers: creep.map(|b| BurgersCreep {
                relaxation_time: i.relaxation_time.unwrap_or(b.relaxation_time),
                retardation_time: i.retardation_time.unwrap_or(b.retardation_time),
                retarded: i.retarded.unwrap_or(b.retarded),
            }),
            ..base
        };
        Ok(Self { material, ..self })
    }

    /// Number of layers: the given one, or 2 where the structure allows it.
    pub fn layer_count(&self) -> u32 {
        let (fewest, most) = self.structure.info().layers;
        self.layers.unwrap_or_else(|| 2.clamp(fewest, most))
    }

    /// Grid and width as built. TRiMM is isotropic only with equilateral triangles whose rows run
    /// along the length, so the width is rounded to whole rows.
    pub fn as_built(&self) -> ((u32, u32), f64) {
        if !self.structure.info().triangular {
            return (self.grid, self.width);
        }
        let spacing = self.length / (f64::from(self.grid.0) - 0.5);
        let row = spacing * 3.0_f64.sqrt() / 2.0;
        let rows = (self.width / row).round().clamp(1.0, 1999.0);
        ((self.grid.0, rows as u32 + 1), rows * row)
    }

    /// A scene with the flat sheet, its bottom layer in the plane y = 0.
    pub(crate) fn scene(&self) -> Scene {
        let ((nx, nz), width) = self.as_built();
        let spacing = self.length / f64::from(nx - 1);
        let sheet = SheetSpec {
            name: "sheet".into(),
            structure: self.structure,
            grid: (nx, self.layer_count(), nz),
            size: (self.length, width),
            gap: self.gap.unwrap_or(0.5 * spacing),
            material: MaterialChoice::Inline(self.material.clone()),
            springs: self.springs,
            damping: self.damping_ratio,
            damping_ratio: Some(self.damping_ratio),
            ..SheetSpec::default()
        };
        let corner = (0.5 * self.length, 0.5 * width);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let sheet = SheetSpec {
            outline: self
                .outlined
                .then(|| OutlineSpec::Polygon(corners.map(|(x, z)| (x * corner.0, z * corner.1)).to_vec())),
            ..sheet
        };
        Scene {
            name: "measure".into(),
            gravity: DVec3::new(0.0, -self.gravity, 0.0),
            engine: self.engine,
            dt: self.dt.unwrap_or(1.0 / 60.0),
            contact: ContactDefaults {
                friction: self.friction,
                restitution: self.restitution,
                ..ContactDefaults::default()
            },
            air: Air::default(),
            sheets: vec![sheet],
            ..Scene::default()
        }
    }

    /// Gravity (m/s²), for rigs that need it.
    ///
    /// # Errors
    /// A value below 0.01 m/s².
    pub(crate) fn required_gravity(&self) -> Result<f64, InputError> {
        check_range("gravity", self.gravity, MINIMUM_GRAVITY, 1e3, "m/s²").map(|()| self.gravity)
    }

    /// Duration (s) of a fall from `height` (m).
    ///
    /// # Errors
    /// Those of [`Setup::required_gravity`].
    pub(crate) fn fall_time(&self, height: f64) -> Result<f64, InputError> {
        Ok((2.0 * height / self.required_gravity()?).sqrt())
    }

    /// Distance between the sheet's nodes and a surface at first contact, m.
    pub(crate) fn contact_offset(&self) -> Result<f64, InputError> {
        Ok(half_thickness(&Sheet::build(&self.scene(), 0)?))
    }

    /// A world of `scene` as from [`Setup::world`], with sleeping enabled.
    pub(crate) fn world_with_sleep(&self, scene: &Scene) -> Result<World, InputError> {
        let mut world = self.world(scene)?;
        world.set_sleep(true);
        Ok(world)
    }

    /// Period of the slowest bending mode of a strip clamped at one end, s.
    pub(crate) fn period(&self) -> f64 {
        let m = &self.material;
        let omega = 3.516 * (m.plate_stiffness() / (m.density * m.thickness)).sqrt() / (self.length * self.length);
        std::f64::consts::TAU / omega
    }

    /// Clamps position and slope of a border of the sheet.
    pub(crate) fn clamp(&self, scene: &mut Scene, border: Region) {
        scene.sheets[0].pins.push(PinSpec::clamped(border));
    }

    /// A world of `scene` with sleeping disabled. An explicit integrator gets a stable step when
    /// none is given.
    pub(crate) fn world(&self, scene: &Scene) -> Result<World, InputError> {
        let mut world = World::new(scene)?;
        world.set_sleep(false);
        if self.dt.is_none() && !self.engine.info().implicit {
            let omega = world.sheets()[0].largest_frequency(100);
            let sheet = &world.sheets()[0];
            // A Kelvin-Voigt solid has the damping ratio τ ω/2 at its largest frequency.
            let follows = sheet.follows_material();
            let damping = if follows { 0.5 * sheet.law().retardation * omega } else { 2.5 * self.damping_ratio };
            let step = self.stable_radians(damping) / omega;
            if step < MINIMUM_STEP {
                return Err(self.step_too_short_error(step, follows, damping, omega));
            }
            if omega > 0.0 {
                world.set_dt(step.min(1.0))?;
            }
        }
        Ok(world)
    }

    /// Error for a stable step of `step` s below the minimum. It names the settings that would
    /// allow a longer one.
    fn step_too_short_error(&self, step: f64, follows: bool, damping: f64, omega: f64) -> InputError {
        let engine = self.engine.name();
        let needs =
            format!("{engine} needs a step of {step:.1e} s on this sheet, below the shortest, {MINIMUM_STEP:e} s");
        let most = self.stable_radians(0.0) / (MINIMUM_STEP * omega);
        if !follows || most <= 1.0 {
            return InputError::new("engine", format!("{needs}; take an implicit engine, or a coarser grid"));
        }
        // Inverse of a = √(1+ζ²) + ζ: the largest damping ratio at the largest frequency.
        let ratio = self.damping_ratio * 0.5 * (most - 1.0 / most) / damping;
        let why = format!(
            "{needs}: a damping ratio of {} in its slowest vibration is {damping:.0} in the fastest",
            self.damping_ratio
        );
        InputError::new("damping_ratio", format!("{why}; take at most {ratio:.1e}, or an implicit engine"))
    }

    /// Stable step of the explicit integrator, in radians of the largest frequency, at damping
    /// ratio `damping` of that frequency. Spring dashpots that are fractions of each spring's own
    /// critical damping give two to three times their ratio where a dozen springs meet.
    fn stable_radians(&self, damping: f64) -> f64 {
        let info = self.engine.info();
        let undamped = match info.order {
            // First order: 0.1 rad keeps flight and impact accurate to a fraction of a percent.
            1 => 0.1,
            _ if info.stability_limit > 0.0 => 0.7 * info.stability_limit,
            // Without damping, the growth of a⁴/4 per step must stay small over the run. With
            // damping, half of the limit 2 ζ^(1/3).
            _ => damping.cbrt().clamp(0.05, 0.7),
        };
        // √(1+ζ²) - ζ, without cancellation.
        undamped / ((1.0 + damping * damping).sqrt() + damping)
    }
}

#[cfg(test)]
mod tests {
    use super::Setup;
    use crate::measure::measure;

    #[test]
    fn rigs_with_a_fall_reject_zero_gravity() {
        let setup = Setup { gravity: 0.0, ..Setup::default() };
        for case in ["drop-box", "bounce", "edge-landing", "weight"] {
            let told = measure(case, &setup).unwrap_err().to_string();
            assert!(told.contains("gravity") && told.contains("m/s²"), "{case}: {told}");
        }
        assert!(Setup::default().fall_time(4.905).is_ok_and(|time| (time - 1.0).abs() < 1e-12));
    }
}
