//! Range checks of a scene, the same for files, command-line overrides and programs.
//!
//! The first problem found is reported: field (dotted path), value, unit and range. Checks that
//! need a file or a mesh are made when the world is built.

use glam::DVec3;

use crate::error::{InputError, check_range, reject_if};
use crate::material::calibration::{Orthotropic, StiffnessTarget};
use crate::mesh::outline::{check_cuts, check_holes, check_outline};
use crate::mesh::structure::StructureKind;
use crate::scene::contact::MINIMUM_STEP_BUDGET;
use crate::scene::{
    Air, BodySpec, BodySpotSpec, CameraSpec, ContactDefaults, HeatMode, HeaterSpec, Material, OvenKey, PathKey,
    PinSpec, Placement, Region, RegionVector, Room, Scene, Shape, SheetSpec, SpotSpec, WindZone, material, sheet_name,
};
use crate::units::parameters::ParameterId as Id;

type ValidationResult = Result<(), InputError>;

/// Check a whole scene.
///
/// # Errors
/// The first value that is non-finite or out of range, or reference to an unknown name.
pub fn scene(scene: &Scene) -> ValidationResult {
    built(scene)?;
    pair_names(scene)
}

/// Check a scene from which a world is built. Materials of its pairs may be unknown: sheets and
/// bodies can be added later.
pub(crate) fn built(scene: &Scene) -> ValidationResult {
    values(scene)?;
    check_attachments(scene)
}

/// Check every value of a scene, without the names that its pairs and pins refer to.
pub(crate) fn values(scene: &Scene) -> ValidationResult {
    Id::Gravity.check_each("gravity", scene.gravity.to_array())?;
    Id::TimeStep.check("dt", scene.dt)?;
    Id::Tolerance.check("tolerance", scene.tolerance)?;
    Id::Duration.check("duration", scene.duration)?;
    heat(scene)?;
    contact(&scene.contact)?;
    air(&scene.air)?;
    wind_zones(&scene.wind_zones)?;
    Id::DetailBudget.check_option("detail_budget", scene.detail_budget)?;
    scene.camera.as_ref().map_or(Ok(()), camera)?;
    scene.room.as_ref().map_or(Ok(()), room)?;
    each("sheets", &scene.sheets, sheet)?;
    each("bodies", &scene.bodies, body)?;
    // The default name of an object must not equal another's name.
    let sheets: Vec<String> = scene.sheets.iter().enumerate().map(|(i, s)| sheet_name(&s.name, i)).collect();
    names("sheets", sheets.iter().map(String::as_str))?;
    let bodies = scene.body_names();
    let (own, room) = bodies.split_at(scene.bodies.len());
    names("bodies", own.iter().map(String::as_str))?;
    match own.iter().position(|name| room.contains(name)) {
        Some(i) => Err(InputError::new(format!("bodies.{i}.name"), format!("\"{}\" is a part of the room", own[i]))),
        None => Ok(()),
    }
}

/// Check a sheet that is added to a valid scene as number `index`, with a name that is not in use.
/// The errors are those of [`values`] for the scene with the sheet.
pub(crate) fn added_sheet(spec: &SheetSpec, index: usize) -> ValidationResult {
    sheet(spec).map_err(|e| e.within(&format!("sheets.{index}")))?;
    check_name(&format!("sheets.{index}"), &spec.name)
}

/// Check the material names of pairs.
fn pair_names(scene: &Scene) -> ValidationResult {
    let library = material::LIBRARY.iter().map(|(name, _, _)| (*name).to_owned());
    let sheets = scene.sheets.iter().map(|s| s.material.name()).filter(|name| !name.is_empty());
    let bodies = scene.bodies.iter().filter_map(|b| b.material.clone());
    let mut known: Vec<String> = Vec::new();
    for name in sheets.chain(bodies).chain(library) {
        if !known.contains(&name) {
            known.push(name);
        }
    }
    for (i, pair) in scene.contact.pairs.iter().enumerate() {
        for (side, name) in [&pair.between.0, &pair.between.1].into_iter().enumerate() {
            let (field, all) = (format!("contact.pairs.{i}.between.{side}"), known.join(", "));
            reject_if!(!known.contains(name), field, "no material is named \"{name}\"; there are {all}");
        }
    }
    Ok(())
}

/// Check the bodies of attachments.
fn check_attachments(scene: &Scene) -> ValidationResult {
    for (i, sheet) in scene.sheets.iter().enumerate() {
        for (k, pin) in sheet.pins.iter().enumerate() {
            let Some(name) = &pin.body else { continue };
            let there = scene.body_names();
            let all = if there.is_empty() { "there is none" } else { &format!("there are {}", there.join(", ")) };
            let field = format!("sheets.{i}.pins.{k}.body");
            reject_if!(!there.contains(name), field, "no body is named \"{name}\"; {all}");
        }
    }
    Ok(())
}

/// Check the rows of the list `field`.
fn each<T>(field: &str, rows: &[T], check: impl Fn(&T) -> ValidationResult) -> ValidationResult {
    let mut rows = rows.iter().enumerate();
    rows.try_for_each(|(i, row)| check(row).map_err(|e| e.within(&format!("{field}.{i}"))))
}

fn names<'a>(field: &str, names: impl Iterator<Item = &'a str>) -> ValidationResult {
    let mut seen = std::collections::BTreeSet::new();
    for (i, name) in names.enumerate() {
        reject_if!(!name.is_empty() && !seen.insert(name), format!("{field}.{i}.name"), "\"{name}\" is used twice");
        check_name(&format!("{field}.{i}"), name)?;
    }
    Ok(())
}

/// Check that `name` of the object at the path `of` is neither a path nor an index.
fn check_name(of: &str, name: &str) -> ValidationResult {
    let is_path = name.contains('.') || (!name.is_empty() && name.bytes().all(|b| b.is_ascii_digit()));
    let problem = "cannot be told from a path or an index: no dots, not only digits";
    reject_if!(is_path, format!("{of}.name"), "\"{name}\" {problem}");
    Ok(())
}

/// Check friction and restitution of a scene.
///
/// # Errors
/// When one is out of range.
pub fn contact(contact: &ContactDefaults) -> ValidationResult {
    Id::ContactFriction.check("contact.friction", contact.friction)?;
    Id::ContactRestitution.check("contact.restitution", contact.restitution)?;
    let is_small = contact.step_budget.is_some_and(|budget| budget < MINIMUM_STEP_BUDGET);
    reject_if!(is_small, "contact.step_budget", "is below {MINIMUM_STEP_BUDGET} node-iterations");
    for (i, pair) in contact.pairs.iter().enumerate() {
        let at = |name: &str| format!("contact.pairs.{i}.{name}");
        Id::PairFriction.check_option(&at("friction"), pair.friction)?;
        Id::PairRestitution.check_option(&at("restitution"), pair.restitution)?;
        let is_empty = pair.friction.is_none() && pair.restitution.is_none();
        reject_if!(is_empty, at("friction"), "says nothing: a pair has a friction, a restitution or both");
        let (a, b) = (&pair.between.0, &pair.between.1);
        let is_repeated = contact.pairs[..i].iter().any(|before| before.joins(a, b));
        reject_if!(is_repeated, at("between"), "\"{a}\" and \"{b}\" are a pair already");
    }
    Ok(())
}

/// Check the air of a scene.
///
/// # Errors
/// When a value is out of range.
pub fn air(air: &Air) -> ValidationResult {
    Id::AirFactor.check("air.factor", air.factor)?;
    Id::AirPer.check("air.per", air.per)?;
    Id::AirDensity.check("air.density", air.density)?;
    Id::AirWind.check_each("air.wind", air.wind.to_array())
}

/// Check wind zones.
pub(crate) fn wind_zones(zones: &[WindZone]) -> ValidationResult {
    each("wind_zones", zones, WindZone::check)
}

fn camera(camera: &CameraSpec) -> ValidationResult {
    Id::CameraEye.check_each("camera.eye", camera.eye.to_array())?;
    Id::CameraTarget.check_each("camera.target", camera.target.to_array())?;
    reject_if!(camera.eye.distance(camera.target) < 1e-9, "camera.target", "is where the eye is");
    Ok(())
}

fn room(room: &Room) -> ValidationResult {
    for (axis, (low, high)) in [("x", room.x), ("y", room.y), ("z", room.z)] {
        Id::RoomExtent.check_each(&format!("room.{axis}"), [low, high])?;
        reject_if!(low >= high, format!("room.{axis}"), "{low} m to {high} m has no extent");
    }
    Id::RoomGrid.check("room.grid", room.grid)
}

/// Check the constants of a material.
///
/// # Errors
/// When one is out of range; fields are below `field`.
pub fn material(field: &str, m: &Material) -> ValidationResult {
    let at = |name: &str| if field.is_empty() { name.to_owned() } else { format!("{field}.{name}") };
    Id::MaterialYoung.check(&at("young"), m.young)?;
    Id::MaterialPoisson.check(&at("poisson"), m.poisson)?;
    Id::MaterialDensity.check(&at("density"), m.density)?;
    Id::MaterialThickness.check(&at("thickness"), m.thickness)?;
    Id::MaterialSpecificHeat.check(&at("specific_heat"), m.specific_heat)?;
    Id::MaterialConductivity.check(&at("conductivity"), m.conductivity)?;
    Id::MaterialEmissivity.check(&at("emissivity"), m.emissivity)?;
    Id::MaterialExpansion.check(&at("expansion"), m.expansion)?;
    softening(&at("softening"), &m.softening)?;
    Id::MaterialDampingRatio.check(&at("damping_ratio"), m.damping_ratio)?;
    Id::MaterialLossFactor.check_option(&at("loss_factor"), m.loss_factor)?;
    Id::MaterialYieldStress.check_option(&at("yield_stress"), m.yield_stress)?;
    Id::MaterialHardening.check(&at("hardening"), m.hardening)?;
    if let Some(b) = &m.burgers {
        Id::BurgersRelaxationTime.check(&at("burgers.relaxation_time"), b.relaxation_time)?;
        Id::BurgersRetardationTime.check(&at("burgers.retardation_time"), b.retardation_time)?;
        Id::BurgersRetarded.check(&at("burgers.retarded"), b.retarded)?;
    }
    Id::GlassTransition.check_option(&at("glass_transition"), m.glass_transition)?;
    Id::WlfFirst.check(&at("wlf.0"), m.wlf.0)?;
    Id::WlfSecond.check(&at("wlf.1"), m.wlf.1)?;
    Id::MeltsAt.check_option(&at("melts_at"), m.melts_at)?;
    let tack = m.tack.as_ref().map_or(Ok(()), crate::scene::adhesion::check_tack);
    tack.map_err(|e| e.within(&at("tack")))?;
    Id::TearsAt.check_option(&at("tears_at"), m.tears_at)?;
    Id::MaterialThesisSensitivity.check_option(&at("thesis_sensitivity"), m.thesis_sensitivity)?;
    Id::MaterialThesisConductivity.check_option(&at("thesis_conductivity"), m.thesis_conductivity)?;
    let woven = m.orthotropic.as_ref().map_or(Ok(()), |measured| StiffnessTarget::orthotropic(measured).map(drop));
    woven.map_err(|e| e.within(&at("orthotropic")))
}

pub(crate) fn placement(p: &Placement) -> ValidationResult {
    Id::PlacementPosition.check_each("placement.position", p.position.to_array())?;
    Id::PlacementRotation.check_each("placement.rotation", p.rotation.to_array())
}

/// Check that the structure of a sheet can have the warp of its material at an angle to its axes: a
/// grid has no coupling of extension and shear.
pub(crate) fn warp_direction(s: &SheetSpec, m: &Material) -> ValidationResult {
    let along = m.orthotropic.as_ref().is_none_or(Orthotropic::is_along_axes);
    let problem = "is for a shell with an outline, whose triangles may lie at any angle to the warp; a grid takes \
                   0, 90 or 180 degrees";
    reject_if!(!along && s.outline.is_none(), "material.orthotropic.direction", "{problem}");
    Ok(())
}

pub(crate) fn sheet(s: &SheetSpec) -> ValidationResult {
    s.material.check(|constants| material("material", constants))?;
    s.material.check(|constants| warp_direction(s, constants))?;
    grid(s)?;
    Id::Size.check_each("size", [s.size.0, s.size.1])?;
    outline(s)?;
    Id::Gap.check("gap", s.gap)?;
    crate::scene::inter_layer::check(s)?;
    Id::Damping.check("damping", s.damping)?;
    Id::DampingRatio.check_option("damping_ratio", s.damping_ratio)?;
    air_loads(s)?;
    Id::FlexionStiffness.check("flexion_stiffness", s.flexion_stiffness)?;
    Id::ThicknessLimit.check("thickness_limit", s.thickness_limit)?;
    Id::NodeMass.check_option("node_mass", s.node_mass)?;
    Id::FlexionLimit.check_option("flexion_limit", s.flexion_limit)?;
    Id::Friction.check_option("friction", s.friction)?;
    Id::Restitution.check_option("restitution", s.restitution)?;
    Id::Temperature.check_option("temperature", s.temperature)?;
    let layered = s.structure != StructureKind::Shell || s.file.is_some();
    let problem = format!("is for the shell only, not for {}: layers have temperatures of their own", s.structure);
    reject_if!(s.temperature_gradient && layered, "temperature_gradient", "{problem}");
    placement(&s.placement)?;
    Id::SheetVelocity.check_each("velocity", s.velocity.to_array())?;
    Id::SheetSpin.check_each("spin", s.spin.to_array())?;
    region_vectors("velocities", &s.velocities, Id::RegionVelocity)?;
    region_vectors("forces", &s.forces, Id::RegionForce)?;
    each("pins", &s.pins, pin)?;
    s.when_unstable.check()?;
    crate::scene::rest_shape::check(s)?;
    crate::scene::fracture::check(s)?;
    crate::scene::adhesion::check(s)?;
    crate::scene::contact_surface::check(s)?;
    crate::scene::lod::check(s)?;
    crate::scene::refine::check(s)?;
    each("spots", &s.spots, SpotSpec::check)?;
    for (name, (u, v)) in &s.probes {
        Id::ProbePosition.check_each(&format!("probes.{name}"), [*u, *v])?;
    }
    Ok(())
}

fn grid(s: &SheetSpec) -> ValidationResult {
    Id::GridLength.check("grid.0", s.grid.0.into())?;
    let (fewest, most) = s.structure.info().layers;
    if s.file.is_none() {
        check_range("grid.1", s.grid.1.into(), fewest.into(), most.into(), "layers")
            .map_err(|e| InputError::new(e.field, format!("{} for {}", e.problem, s.structure)))?;
    }
    Id::GridWidth.check("grid.2", s.grid.2.into())
}

/// Check drag and the schedule of pressure.
fn air_loads(s: &SheetSpec) -> ValidationResult {
    Id::DragAcross.check("drag.0", s.drag.0)?;
    Id::DragAlong.check("drag.1", s.drag.1)?;
    for (i, key) in s.pressure.iter().enumerate() {
        Id::PressureTime.check(&format!("pressure.{i}.time"), key.time)?;
        Id::PressureValue.check(&format!("pressure.{i}.pressure"), key.pressure)?;
    }
    increasing("pressure", "time", "s", s.pressure.iter().map(|key| key.time))
}

/// Check a pin.
pub(crate) fn pin(pin: &PinSpec) -> ValidationResult {
    region(&pin.region).map_err(|e| e.within("region"))?;
    path(&pin.path)?;
    let turns = pin.path.iter().position(|key| key.rotation != DVec3::ZERO);
    if let Some(i) = turns {
        let problem = "a pin has no rotation: attach its region to a body that turns, with `body`";
        return Err(InputError::new(format!("path.{i}.rotation"), problem));
    }
    let all = pin.axes == (true, true, true);
    if let Some(until) = pin.until {
        Id::PinUntil.check("until", until)?;
        let other = pin.clamp || pin.body.is_some() || !all;
        reject_if!(other, "until", "is for masses that are held or led, without clamp, body or axes");
    }
    if pin.body.is_some() {
        reject_if!(!pin.path.is_empty(), "path", "does not go with a body: glued masses go where it goes");
        reject_if!(pin.clamp, "clamp", "does not go with a body: two rows of masses glued to it hold the slope");
        reject_if!(!all, "axes", "does not go with a body: masses are glued to it in every direction");
    }
    let moved = !pin.path.is_empty() || pin.clamp;
    reject_if!(!all && moved, "axes", "masses held along some axes only can be neither led nor clamped");
    reject_if!(pin.axes == (false, false, false), "axes", "holds nothing");
    Ok(())
}

/// Check that the numbers `name` of the rows of the list `field` increase.
fn increasing(field: &str, name: &str, unit: &str, values: impl Iterator<Item = f64> + Clone) -> ValidationResult {
    for (i, (before, value)) in values.clone().zip(values.skip(1)).enumerate() {
        let at = || format!("{field}.{}.{name}", i + 1);
        reject_if!(value <= before, at(), "{value} {unit} does not come after {before} {unit}");
    }
    Ok(())
}

/// Check a table of stiffness against temperature.
fn softening(field: &str, rows: &[(f64, f64)]) -> ValidationResult {
    for (i, (celsius, fraction)) in rows.iter().enumerate() {
        Id::SofteningTemperature.check(&format!("{field}.{i}.0"), *celsius)?;
        Id::SofteningFraction.check(&format!("{field}.{i}.1"), *fraction)?;
    }
    increasing(field, "0", "°C", rows.iter().map(|row| row.0))
}

/// Check the ranges of outline, holes and cuts. Their geometry is checked when the sheet is built.
fn outline(s: &SheetSpec) -> ValidationResult {
    let given = [("outline", s.outline.is_some()), ("holes", !s.holes.is_empty()), ("cuts", !s.cuts.is_empty())];
    if let Some((field, _)) = given.into_iter().find(|g| g.1) {
        reject_if!(s.file.is_some(), field, "does not go with a sheet from a file");
        reject_if!(s.structure != StructureKind::Shell, field, "is for the shell only, not for {}", s.structure);
    }
    s.outline.as_ref().map_or(Ok(()), |o| check_outline(o, s.size))?;
    check_holes(&s.holes)?;
    check_cuts(&s.cuts)
}

fn region_vectors(field: &str, list: &[RegionVector], value: Id) -> ValidationResult {
    each(field, list, |item| {
        region(&item.region).map_err(|e| e.within("region"))?;
        value.check_each("value", item.value.to_array())
    })
}

/// Check the coordinates of a region.
pub(crate) fn region(region: &Region) -> ValidationResult {
    let unit = |value: f64| Id::RegionCoordinate.check("", value);
    match region {
        Region::Point(u, v) => unit(*u).and(unit(*v)),
        Region::Rect(u, v) => [u.0, u.1, v.0, v.1].into_iter().try_for_each(unit),
        _ => Ok(()),
    }
}

fn path(path: &[PathKey]) -> ValidationResult {
    for (i, key) in path.iter().enumerate() {
        Id::PathTime.check(&format!("path.{i}.time"), key.time)?;
        Id::PathOffset.check_each(&format!("path.{i}.offset"), key.offset.to_array())?;
        Id::PathRotation.check_each(&format!("path.{i}.rotation"), key.rotation.to_array())?;
    }
    increasing("path", "time", "s", path.iter().map(|key| key.time))
}

fn body(b: &BodySpec) -> ValidationResult {
    match &b.shape {
        Shape::Box(size) => Id::BodySize.check_each("shape", size.to_array())?,
        Shape::Ball(radius) => Id::BodySize.check("shape", *radius)?,
        Shape::File(_) | Shape::Part(..) | Shape::Polyhedron(_) | Shape::HalfSpace => {}
    }
    placement(&b.placement)?;
    path(&b.path)?;
    motion(b)?;
    reject_if!(b.material.as_ref().is_some_and(String::is_empty), "material", "has no name");
    Id::BodyFriction.check_option("friction", b.friction)?;
    Id::BodyTemperature.check_option("temperature", b.temperature)?;
    schedule("temperature_schedule", &b.temperature_schedule)?;
    Id::BodyTemperatureSlope.check_each("temperature_slope", b.temperature_slope.to_array())?;
    each("hot_spots", &b.hot_spots, BodySpotSpec::check)?;
    let field = if b.hot_spots.is_empty() { "temperature_slope" } else { "hot_spots" };
    let cold = !b.is_hot() && (field == "hot_spots" || b.temperature_slope != DVec3::ZERO);
    reject_if!(cold, field, "needs a `temperature` or a `temperature_schedule` of the body");
    Id::BodyRestitution.check_option("restitution", b.restitution)
}

/// Check the temperatures over time of an oven or a body.
fn schedule(field: &str, keys: &[OvenKey]) -> ValidationResult {
    for (i, key) in keys.iter().enumerate() {
        Id::OvenScheduleTime.check(&format!("{field}.{i}.time"), key.time)?;
        Id::OvenScheduleTemperature.check_option(&format!("{field}.{i}.temperature"), key.temperature)?;
    }
    increasing(field, "time", "s", keys.iter().map(|key| key.time))
}

/// Check the heat settings of a scene, without bodies.
pub(crate) fn heat(scene: &Scene) -> ValidationResult {
    Id::AmbientTemperature.check("ambient_temperature", scene.ambient_temperature)?;
    Id::Convection.check("convection", scene.convection)?;
    Id::ContactConductance.check("contact_conductance", scene.contact_conductance)?;
    Id::TimeLapse.check("time_lapse", scene.time_lapse)?;
    if let HeatMode::Thesis { sensitivity, conductivity } = scene.heat_mode {
        Id::ThesisSensitivity.check("heat_mode.sensitivity", sensitivity)?;
        Id::ThesisConductivity.check("heat_mode.conductivity", conductivity)?;
        let warm = scene.bodies.iter().position(|b| b.temperature.is_some() || !b.temperature_schedule.is_empty());
        let field = format!("bodies.{}.temperature", warm.unwrap_or(0));
        reject_if!(warm.is_some(), field, "has no effect with heat_mode Thesis, whose sources are oven and heaters");
    }
    if let Some(oven) = &scene.oven {
        Id::OvenTemperature.check("oven.temperature", oven.temperature)?;
        Id::OvenConvection.check_option("oven.convection", oven.convection)?;
        schedule("oven.schedule", &oven.schedule)?;
    }
    if let Some(gun) = &scene.heat_gun {
        Id::HeatGunTemperature.check("heat_gun.temperature", gun.temperature)?;
        Id::HeatGunConvection.check("heat_gun.convection", gun.convection)?;
        Id::HeatGunHalfAngle.check("heat_gun.half_angle", gun.half_angle)?;
        Id::HeatGunReach.check("heat_gun.reach", gun.reach)?;
        Id::HeatGunPositionX.check_each("heat_gun.position", gun.position.to_array())?;
        Id::HeatGunDirectionX.check_each("heat_gun.direction", gun.direction.to_array())?;
        reject_if!(gun.direction == DVec3::ZERO, "heat_gun.direction", "points nowhere");
        path(&gun.path).map_err(|e| e.within("heat_gun"))?;
    }
    each("heaters", &scene.heaters, heater)?;
    names("heaters", scene.heaters.iter().map(|h| h.name.as_str()))
}

/// Check a heater; its file is read when the world is built.
fn heater(h: &HeaterSpec) -> ValidationResult {
    Id::HeaterSize.check_each("size", h.size.iter().flat_map(|s| s.to_array()))?;
    for (i, hot) in h.hot.iter().enumerate() {
        Id::HotFaceTemperature.check(&format!("hot.{i}.temperature"), hot.temperature)?;
        Id::HotFaceEmissivity.check(&format!("hot.{i}.emissivity"), hot.emissivity)?;
    }
    if h.file.is_none() {
        h.resolve(std::path::Path::new(""))?;
    }
    placement(&h.placement)
}

/// Check mass, density, velocity and spin of a body.
fn motion(b: &BodySpec) -> ValidationResult {
    Id::BodyMass.check_option("mass", b.mass)?;
    Id::BodyDensity.check_option("density", b.density)?;
    Id::BodyVelocity.check_each("velocity", b.velocity.to_array())?;
    Id::BodySpin.check_each("spin", b.spin.to_array())?;
    reject_if!(b.mass.is_some() && b.density.is_some(), "density", "does not go with a mass: give one of the two");
    if b.is_dynamic() {
        let field = if b.mass.is_some() { "mass" } else { "density" };
        reject_if!(!b.path.is_empty(), field, "does not go with a path: a body is led or moves freely");
        reject_if!(b.shape == Shape::HalfSpace, field, "does not go with a half space, which has no end");
        return Ok(());
    }
    for (field, value) in [("velocity", b.velocity), ("spin", b.spin)] {
        reject_if!(value != DVec3::ZERO, field, "is for a body that moves freely: give it a mass or a density");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Field and problem of the first error in `text`.
    fn refused(text: &str) -> (String, String) {
        let error = InputError::from(Scene::parse(text).expect_err("bad"));
        (error.field, error.problem)
    }

    fn refused_body(fields: &str) -> (String, String) {
        refused(&format!("(bodies: [(shape: Ball(0.1), {fields})])"))
    }

    #[test]
    fn a_body_is_dynamic_static_or_kinematic() {
        let good = "(bodies: [(shape: Ball(0.1), mass: 0.2, velocity: (1, 0, 0), spin: (0, 3, 0), material: \"steel\"),
            (shape: Box((1, 1, 1)), density: 900)])";
        let scene = Scene::parse(good).expect("valid");
        assert!(scene.bodies.iter().all(BodySpec::is_dynamic));
        assert_eq!(Scene::parse(&scene.to_text().expect("text")).expect("valid"), scene);
        assert_eq!(refused_body("mass: 0").0, "bodies.0.mass");
        assert!(refused_body("mass: 2e9").1.contains("2e9 kg is outside 1e-9 to 1e9 kg"));
        assert!(refused_body("density: NaN").1.contains("kg/m³"));
        assert_eq!(refused_body("mass: 1, velocity: (0, 2000, 0)").0, "bodies.0.velocity.1");
        assert!(refused_body("mass: 1, spin: (0, 2e4, 0)").1.contains("rad/s"));
        assert!(refused_body("mass: 1, density: 1").1.contains("one of the two"));
        assert!(refused_body("density: 1, path: [(time: 0)]").1.contains("path"));
        assert!(refused("(bodies: [(shape: HalfSpace, mass: 1)])").1.contains("half space"));
        assert_eq!(refused_body("spin: (1, 0, 0)").0, "bodies.0.spin");
        assert_eq!(refused_body("material: \"\"").0, "bodies.0.material");
    }

    #[test]
    fn material_pairs_name_existing_materials() {
        let scene = |pairs: &str| {
            format!(
                "(contact: (pairs: [{pairs}]), sheets: [(material: (name: \"felt\"))],
                  bodies: [(shape: Ball(0.1), material: \"steel\")])"
            )
        };
        let one = |pair: &str| refused(&scene(pair));
        Scene::parse(&scene(
            "(between: (\"felt\", \"steel\"), friction: 0.4), (between: (\"hips\", \"hips\"), restitution: 0)",
        ))
        .expect("valid");
        let (field, problem) = one("(between: (\"felt\", \"wood\"), friction: 0.4)");
        assert_eq!(field, "contact.pairs.0.between.1");
        assert!(problem.contains("\"wood\"") && problem.contains("felt, steel, thesis, hips"), "{problem}");
        assert!(one("(between: (\"felt\", \"steel\"))").1.contains("says nothing"));
        assert_eq!(one("(between: (\"felt\", \"steel\"), friction: 11)").0, "contact.pairs.0.friction");
        let twice = "(between: (\"felt\", \"steel\"), friction: 1), (between: (\"steel\", \"felt\"), friction: 1)";
        assert_eq!(one(twice).0, "contact.pairs.1.between");
    }

    #[test]
    fn attachments_name_existing_bodies() {
        let scene = |pin: &str| {
            format!(
                "(room: (x: (0, 1), y: (0, 1), z: (0, 1)), sheets: [(pins: [(region: Left, {pin})])],
                  bodies: [(shape: Ball(0.1)), (name: \"arm\", shape: Ball(0.1))])"
            )
        };
        for name in ["body 0", "arm", "floor", "back wall"] {
            Scene::parse(&scene(&format!("body: \"{name}\""))).expect("valid");
        }
        let (field, problem) = refused(&scene("body: \"leg\""));
        assert_eq!(field, "sheets.0.pins.0.body");
        assert!(problem.contains("there are body 0, arm, floor, back wall"), "{problem}");
        assert!(refused("(sheets: [(pins: [(region: Left, body: \"leg\")])])").1.contains("there is none"));
        assert_eq!(refused(&scene("body: \"arm\", path: [(time: 0)]")).0, "sheets.0.pins.0.path");
        assert_eq!(refused(&scene("body: \"arm\", clamp: true")).0, "sheets.0.pins.0.clamp");
        let turning = scene("path: [(time: 0), (time: 1, rotation: (0, 90, 0))]");
        assert_eq!(refused(&turning).0, "sheets.0.pins.0.path.1.rotation");
        assert_eq!(refused(&scene("body: \"arm\", axes: (true, false, true)")).0, "sheets.0.pins.0.axes");
    }
}
