//! Input of the rigs: sheet, integrator and situation, with the defaults of the command line.

use glam::DVec3;

use crate::measure::thermal::Thermal;
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

/// The sheet and its situation. Each rig uses a part of the fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Structure of the sheet.
    pub structure: StructureKind,
    /// Nodes along length and width of the bottom layer, 2 to 2000 each.
    pub grid: (u32, u32),
    /// Number of layers, for structures with a variable number.
    pub layers: u32,
    /// Time integrator.
    pub engine: IntegratorKind,
    /// Rule by which springs get their stiffness from the material.
    pub springs: SpringLaw,
    /// Step, s, 1e-7 to 1. `None` gives 1/60 s with an implicit integrator and a stable step with
    /// an explicit one.
    pub dt: Option<f64>,
    /// Material: modulus, density, thickness.
    pub material: Material,
    /// Length of the sheet, m, 1e-4 to 100.
    pub length: f64,
    /// Width of the sheet, m, 1e-4 to 100.
    pub width: f64,
    /// Gravity downwards, m/s², 0 to 1000.
    pub gravity: f64,
    /// Damping ratio of the slowest bending mode (shell and calibrated springs), 0 to 10.
    pub damping_ratio: f64,
    /// Angle, degrees: of an incline or a landing 0 to 89, of a fold 0 to 170.
    pub angle: f64,
    /// Friction coefficient, 0 to 10.
    pub friction: f64,
    /// Restitution coefficient, 0 to 1.
    pub restitution: f64,
    /// Drop height, m, 1e-3 to 1000.
    pub height: f64,
    /// Initial speed of a slide, m/s, 1e-3 to 100.
    pub speed: f64,
    /// Factor on the ball speed of the scene, 0.1 to 3.
    pub throw: f64,
    /// Angular velocity of a spin, rad/s, 1e-3 to 1000.
    pub rate: f64,
    /// Step to rest in place of the equilibrium solution.
    pub dynamic: bool,
    /// Mesh the rectangle with the triangles of sheets with an outline (shell).
    pub outlined: bool,
    /// Boundary condition of the sheet's edges.
    pub boundary: Boundary,
    /// Number of vibration modes, 1 to 50.
    pub modes: u32,
    /// Side of a square, m, 1e-4 to 100; `None` uses the length.
    pub side: Option<f64>,
    /// Side of the patch that carries a square sheet, m, 1e-5 to 100.
    pub patch: f64,
    /// Radius of a disc, m, 1e-4 to 100.
    pub radius: f64,
    /// Diameter of a hole, m, 1e-5 to 100.
    pub hole: f64,
    /// Side of a box below or on the sheet, m, 1e-3 to 100.
    pub box_side: f64,
    /// Number of sheets in a pile, 1 to 100.
    pub sheets: u32,
    /// Land on a corner in place of an edge.
    pub corner: bool,
    /// Land with the surface on the ridge of a wedge in place of an edge on the floor.
    pub edge_of_body: bool,
    /// Use a sheet with all nodes fixed in place of a plane, or a striking sheet in place of a
    /// ball.
    pub on_sheet: bool,
    /// Number of halvings of the step, each with its own measurement, 0 to 6.
    pub refine: u32,
    /// Number of threads that step several sheets, 1 to 256.
    pub threads: u32,
    /// Input of the thermal rigs.
    pub thermal: Thermal,
    /// Temperature of the sheet, °C, -273.15 to 5000. `None` gives 40 K above the glass transition,
    /// or 20 °C for a material without one.
    pub celsius: Option<f64>,
    /// Duration of the measurement, s, 1e-3 to 1e9.
    pub seconds: f64,
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
    fn default() -> Self {
        Self {
            structure: StructureKind::Shell,
            grid: (21, 21),
            layers: 1,
            springs: SpringLaw::Calibrated,
            engine: IntegratorKind::TrBdf2,
            dt: None,
            material: Material {
                young: 3e9,
                poisson: 0.35,
                density: 1050.0,
                thickness: 5e-4,
                yield_stress: Some(3e7),
                burgers: Some(BurgersCreep { relaxation_time: 10.0, retardation_time: 1.0, retarded: 0.5 }),
                ..Material::default()
            },
            length: 0.25,
            width: 0.25,
            gravity: 9.81,
            damping_ratio: 0.05,
            angle: 20.0,
            friction: 0.3,
            restitution: 0.5,
            height: 0.2,
            speed: 1.0,
            throw: 1.0,
            rate: 10.0,
            dynamic: false,
            outlined: false,
            boundary: Boundary::Cantilever,
            modes: 3,
            side: None,
            patch: 0.05,
            radius: 0.125,
            hole: 0.1,
            box_side: 0.1,
            sheets: 5,
            corner: false,
            edge_of_body: false,
            on_sheet: false,
            refine: 0,
            threads: 1,
            thermal: Thermal::default(),
            celsius: None,
            seconds: 10.0,
        }
    }
}

impl Setup {
    /// Checks the range of every value.
    ///
    /// # Errors
    /// The first value out of range, named as its flag.
    pub fn check(&self) -> Result<(), InputError> {
        Id::GridLength.check("grid", self.grid.0.into())?;
        Id::GridWidth.check("grid", self.grid.1.into())?;
        let (fewest, most) = self.structure.info().layers;
        check_range("layers", self.layers.into(), fewest.into(), most.into(), "layers")?;
        if let Some(dt) = self.dt {
            Id::TimeStep.check("dt", dt)?;
        }
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
        check_range("seconds", self.seconds, 1e-3, 1e9, "s")?;
        if let Some(celsius) = self.celsius {
            Id::Temperature.check("celsius", celsius)?;
        }
        check_range("refine", self.refine.into(), 0.0, 6.0, "halvings")?;
        self.thermal.check()?;
        self.side.map_or(Ok(()), |side| check_range("side", side, 1e-4, 100.0, "m"))
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
            grid: (nx, self.layers, nz),
            size: (self.length, width),
            gap: 0.5 * spacing,
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
