//! Range checks of a scene, the same for files, command-line overrides and programs.
//!
//! The first problem found is reported: field (dotted path), value, unit and range. Checks that
//! need a file or a mesh are made when the world is built.

use glam::DVec3;

use crate::error::{InputError, check_range};
use crate::material::calibration::StiffnessTarget;
use crate::mesh::outline::{check_cuts, check_holes, check_outline};
use crate::mesh::structure::StructureKind;
use crate::scene::{
    Air, BodySpec, CameraSpec, ContactDefaults, HeatMode, HeaterSpec, Material, MaterialChoice, PathKey, PinSpec,
    Placement, Region, RegionVector, Room, Scene, Shape, SheetSpec, material,
};
use crate::units::temperature::{COLDEST, HOTTEST};

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
    vector("gravity", scene.gravity, 1e3, "m/s²")?;
    check_range("dt", scene.dt, 1e-7, 1.0, "s")?;
    check_range("tolerance", scene.tolerance, 1e-15, 1.0, "m")?;
    check_range("duration", scene.duration, 0.0, 1e6, "s")?;
    heat(scene)?;
    contact(&scene.contact)?;
    air(&scene.air)?;
    option("detail_budget", scene.detail_budget, (1e-3, 1e6), "ms")?;
    if let Some(view) = &scene.camera {
        camera(view)?;
    }
    if let Some(walls) = &scene.room {
        room(walls)?;
    }
    for (i, sheet) in scene.sheets.iter().enumerate() {
        crate::scene::validate::sheet(sheet).map_err(|e| within(&format!("sheets.{i}"), e))?;
    }
    for (i, body) in scene.bodies.iter().enumerate() {
        crate::scene::validate::body(body).map_err(|e| within(&format!("bodies.{i}"), e))?;
    }
    names("sheets", scene.sheets.iter().map(|s| s.name.as_str()))?;
    // The default name of a body must not equal another's name.
    let bodies = scene.body_names();
    names("bodies", bodies.iter().take(scene.bodies.len()).map(String::as_str))
}

/// Check a sheet that is added to a valid scene as number `index`, with a name that is not in use.
/// The errors are those of [`values`] for the scene with the sheet.
pub(crate) fn added_sheet(spec: &SheetSpec, index: usize) -> ValidationResult {
    sheet(spec).map_err(|e| within(&format!("sheets.{index}"), e))?;
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
            if !known.contains(name) {
                let problem = format!("no material is named \"{name}\"; there are {}", known.join(", "));
                return Err(InputError::new(format!("contact.pairs.{i}.between.{side}"), problem));
            }
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
            if !there.contains(name) {
                let all = if there.is_empty() {
                    "there is none".to_owned()
                } else {
                    format!("there are {}", there.join(", "))
                };
                return Err(InputError::new(
                    format!("sheets.{i}.pins.{k}.body"),
                    format!("no body is named \"{name}\"; {all}"),
                ));
            }
        }
    }
    Ok(())
}

fn within(outer: &str, mut error: InputError) -> InputError {
    error.field = if error.field.is_empty() { outer.to_owned() } else { format!("{outer}.{}", error.field) };
    error
}

fn vector(field: &str, v: DVec3, bound: f64, unit: &str) -> ValidationResult {
    for (axis, value) in v.to_array().into_iter().enumerate() {
        check_range(&format!("{field}.{axis}"), value, -bound, bound, unit)?;
    }
    Ok(())
}

fn names<'a>(field: &str, names: impl Iterator<Item = &'a str>) -> ValidationResult {
    let mut seen = std::collections::BTreeSet::new();
    for (i, name) in names.enumerate() {
        if !name.is_empty() && !seen.insert(name) {
            return Err(InputError::new(format!("{field}.{i}.name"), format!("\"{name}\" is used twice")));
        }
        check_name(&format!("{field}.{i}"), name)?;
    }
    Ok(())
}

/// Check that `name` of the object at the path `of` is neither a path nor an index.
fn check_name(of: &str, name: &str) -> ValidationResult {
    if name.contains('.') || (!name.is_empty() && name.bytes().all(|b| b.is_ascii_digit())) {
        let problem = format!("\"{name}\" cannot be told from a path or an index: no dots, not only digits");
        return Err(InputError::new(format!("{of}.name"), problem));
    }
    Ok(())
}

/// Check friction and restitution of a scene.
///
/// # Errors
/// When one is out of range.
pub fn contact(contact: &ContactDefaults) -> ValidationResult {
    check_range("contact.friction", contact.friction, 0.0, 10.0, "")?;
    check_range("contact.restitution", contact.restitution, 0.0, 1.0, "")?;
    for (i, pair) in contact.pairs.iter().enumerate() {
        let at = |name: &str| format!("contact.pairs.{i}.{name}");
        option(&at("friction"), pair.friction, (0.0, 10.0), "")?;
        option(&at("restitution"), pair.restitution, (0.0, 1.0), "")?;
        if pair.friction.is_none() && pair.restitution.is_none() {
            return Err(InputError::new(at("friction"), "says nothing: a pair has a friction, a restitution or both"));
        }
        let (a, b) = (&pair.between.0, &pair.between.1);
        if contact.pairs[..i].iter().any(|before| before.joins(a, b)) {
            return Err(InputError::new(at("between"), format!("\"{a}\" and \"{b}\" are a pair already")));
        }
    }
    Ok(())
}

/// Check the air of a scene.
///
/// # Errors
/// When a value is out of range.
pub fn air(air: &Air) -> ValidationResult {
    check_range("air.factor", air.factor, 1e-6, 1.0, "")?;
    check_range("air.per", air.per, 1e-6, 1e3, "s")?;
    check_range("air.density", air.density, 0.0, 1e4, "kg/m³")?;
    vector("air.wind", air.wind, 1e3, "m/s")
}

fn camera(camera: &CameraSpec) -> ValidationResult {
    vector("camera.eye", camera.eye, 1e4, "m")?;
    vector("camera.target", camera.target, 1e4, "m")?;
    if camera.eye.distance(camera.target) < 1e-9 {
        return Err(InputError::new("camera.target", "is where the eye is"));
    }
    Ok(())
}

fn room(room: &Room) -> ValidationResult {
    for (axis, (low, high)) in [("x", room.x), ("y", room.y), ("z", room.z)] {
        check_range(&format!("room.{axis}.0"), low, -1e4, 1e4, "m")?;
        check_range(&format!("room.{axis}.1"), high, -1e4, 1e4, "m")?;
        if low >= high {
            return Err(InputError::new(format!("room.{axis}"), format!("{low} m to {high} m has no extent")));
        }
    }
    check_range("room.grid", room.grid, 1e-4, 100.0, "m")
}

/// Check the constants of a material.
///
/// # Errors
/// When one is out of range; fields are below `field`.
pub fn material(field: &str, m: &Material) -> ValidationResult {
    let at = |name: &str| if field.is_empty() { name.to_owned() } else { format!("{field}.{name}") };
    check_range(&at("young"), m.young, 1e-3, 2e12, "Pa")?;
    check_range(&at("poisson"), m.poisson, -0.99, 0.499, "")?;
    check_range(&at("density"), m.density, 1e-3, 1e6, "kg/m³")?;
    check_range(&at("thickness"), m.thickness, 1e-7, 1.0, "m")?;
    check_range(&at("specific_heat"), m.specific_heat, 1.0, 1e5, "J/(kg K)")?;
    check_range(&at("conductivity"), m.conductivity, 0.0, 1e4, "W/(m K)")?;
    check_range(&at("emissivity"), m.emissivity, 0.0, 1.0, "")?;
    check_range(&at("expansion"), m.expansion, -1e-2, 1e-2, "1/K")?;
    softening(&at("softening"), &m.softening)?;
    check_range(&at("damping_ratio"), m.damping_ratio, 0.0, 10.0, "of critical")?;
    option(&at("yield_stress"), m.yield_stress, (1.0, 1e11), "Pa")?;
    check_range(&at("hardening"), m.hardening, 0.0, 1e12, "Pa")?;
    if let Some(b) = &m.burgers {
        check_range(&at("burgers.relaxation_time"), b.relaxation_time, 1e-6, 1e30, "s")?;
        check_range(&at("burgers.retardation_time"), b.retardation_time, 1e-6, 1e30, "s")?;
        check_range(&at("burgers.retarded"), b.retarded, 0.0, 1e4, "")?;
    }
    option(&at("glass_transition"), m.glass_transition, (-273.15, 1000.0), "°C")?;
    check_range(&at("wlf.0"), m.wlf.0, 1.0, 100.0, "")?;
    check_range(&at("wlf.1"), m.wlf.1, 1.0, 1000.0, "K")?;
    option(&at("melts_at"), m.melts_at, (COLDEST, HOTTEST), "°C")?;
    if let Some(tack) = &m.tack {
        crate::scene::adhesion::check_tack(tack).map_err(|e| within(&at("tack"), e))?;
    }
    option(&at("tears_at"), m.tears_at, (1e-3, 10.0), "of strain")?;
    let woven = m.orthotropic.as_ref().map_or(Ok(()), |measured| StiffnessTarget::orthotropic(measured).map(drop));
    woven.map_err(|e| within(&at("orthotropic"), e))
}

fn placement(p: &Placement) -> ValidationResult {
    vector("placement.position", p.position, 1e4, "m")?;
    vector("placement.rotation", p.rotation, 36000.0, "degrees")
}

fn sheet(s: &SheetSpec) -> ValidationResult {
    match &s.material {
        MaterialChoice::Named(name) => material::by_name(name).map(drop)?,
        MaterialChoice::Inline(constants) => material("material", constants)?,
        MaterialChoice::File(_) => {}
    }
    grid(s)?;
    check_range("size.0", s.size.0, 1e-6, 1e3, "m")?;
    check_range("size.1", s.size.1, 1e-6, 1e3, "m")?;
    outline(s)?;
    check_range("gap", s.gap, 1e-7, 10.0, "m")?;
    check_range("damping", s.damping, 0.0, 10.0, "of critical")?;
    option("damping_ratio", s.damping_ratio, (0.0, 10.0), "of critical")?;
    air_loads(s)?;
    check_range("flexion_stiffness", s.flexion_stiffness, 0.0, 1e3, "")?;
    check_range("thickness_limit", s.thickness_limit, 0.0, 0.95, "")?;
    option("node_mass", s.node_mass, (1e-12, 1e6), "kg")?;
    option("flexion_limit", s.flexion_limit, (1.0, 180.0), "degrees")?;
    option("friction", s.friction, (0.0, 10.0), "")?;
    option("restitution", s.restitution, (0.0, 1.0), "")?;
    option("temperature", s.temperature, (COLDEST, HOTTEST), "°C")?;
    if s.temperature_gradient && (s.structure != StructureKind::Shell || s.file.is_some()) {
        let problem = format!("is for the shell only, not for {}: layers have temperatures of their own", s.structure);
        return Err(InputError::new("temperature_gradient", problem));
    }
    placement(&s.placement)?;
    vector("velocity", s.velocity, 1e4, "m/s")?;
    vector("spin", s.spin, 1e4, "rad/s")?;
    region_vectors("velocities", &s.velocities, "m/s")?;
    region_vectors("forces", &s.forces, "N")?;
    for (i, p) in s.pins.iter().enumerate() {
        pin(p).map_err(|e| within(&format!("pins.{i}"), e))?;
    }
    s.when_unstable.check()?;
    crate::scene::rest_shape::check(s)?;
    crate::scene::fracture::check(s)?;
    crate::scene::adhesion::check(s)?;
    crate::scene::lod::check(s)?;
    for (i, spot) in s.spots.iter().enumerate() {
        spot.check().map_err(|e| within(&format!("spots.{i}"), e))?;
    }
    for (name, (u, v)) in &s.probes {
        check_range(&format!("probes.{name}.0"), *u, 0.0, 1.0, "")?;
        check_range(&format!("probes.{name}.1"), *v, 0.0, 1.0, "")?;
    }
    Ok(())
}

fn grid(s: &SheetSpec) -> ValidationResult {
    check_range("grid.0", s.grid.0.into(), 2.0, 2000.0, "masses")?;
    let (fewest, most) = s.structure.info().layers;
    if s.file.is_none() {
        check_range("grid.1", s.grid.1.into(), fewest.into(), most.into(), "layers")
            .map_err(|e| InputError::new(e.field, format!("{} for {}", e.problem, s.structure)))?;
    }
    check_range("grid.2", s.grid.2.into(), 2.0, 2000.0, "masses")
}

/// Check drag and the schedule of pressure.
fn air_loads(s: &SheetSpec) -> ValidationResult {
    check_range("drag.0", s.drag.0, 0.0, 10.0, "")?;
    check_range("drag.1", s.drag.1, 0.0, 10.0, "")?;
    for (i, key) in s.pressure.iter().enumerate() {
        check_range(&format!("pressure.{i}.time"), key.time, 0.0, 1e6, "s")?;
        check_range(&format!("pressure.{i}.pressure"), key.pressure, -1e6, 1e6, "Pa")?;
        if i > 0 && key.time <= s.pressure[i - 1].time {
            let problem = format!("{} s does not come after {} s", key.time, s.pressure[i - 1].time);
            return Err(InputError::new(format!("pressure.{i}.time"), problem));
        }
    }
    Ok(())
}

fn pin(pin: &PinSpec) -> ValidationResult {
    region(&pin.region).map_err(|e| within("region", e))?;
    path(&pin.path)?;
    let all = pin.axes == (true, true, true);
    if let Some(until) = pin.until {
        check_range("until", until, 0.0, 1e6, "s")?;
        if pin.clamp || pin.body.is_some() || !all {
            return Err(InputError::new("until", "is for masses that are held or led, without clamp, body or axes"));
        }
    }
    if pin.body.is_some() {
        if !pin.path.is_empty() {
            return Err(InputError::new("path", "does not go with a body: glued masses go where it goes"));
        }
        if pin.clamp {
            let problem = "does not go with a body: two rows of masses glued to it hold the sheet's slope";
            return Err(InputError::new("clamp", problem));
        }
        if !all {
            return Err(InputError::new("axes", "does not go with a body: masses are glued to it in every direction"));
        }
    }
    if !all && (!pin.path.is_empty() || pin.clamp) {
        let problem = "masses held along some axes only can be neither led nor clamped";
        return Err(InputError::new("axes", problem));
    }
    if pin.axes == (false, false, false) {
        return Err(InputError::new("axes", "holds nothing"));
    }
    Ok(())
}

/// Check a table of stiffness against temperature.
fn softening(field: &str, rows: &[(f64, f64)]) -> ValidationResult {
    for (i, (celsius, fraction)) in rows.iter().enumerate() {
        check_range(&format!("{field}.{i}.0"), *celsius, COLDEST, HOTTEST, "°C")?;
        check_range(&format!("{field}.{i}.1"), *fraction, 1e-9, 1e3, "of young")?;
        if i > 0 && *celsius <= rows[i - 1].0 {
            let problem = format!("{celsius} °C does not come after {} °C", rows[i - 1].0);
            return Err(InputError::new(format!("{field}.{i}.0"), problem));
        }
    }
    Ok(())
}

/// Check the ranges of outline, holes and cuts. Their geometry is checked when the sheet is built.
fn outline(s: &SheetSpec) -> ValidationResult {
    let given = [("outline", s.outline.is_some()), ("holes", !s.holes.is_empty()), ("cuts", !s.cuts.is_empty())];
    if let Some((field, _)) = given.into_iter().find(|g| g.1) {
        if s.file.is_some() {
            return Err(InputError::new(field, "does not go with a sheet from a file"));
        }
        if s.structure != StructureKind::Shell {
            return Err(InputError::new(field, format!("is for the shell only, not for {}", s.structure)));
        }
    }
    s.outline.as_ref().map_or(Ok(()), |o| check_outline(o, s.size))?;
    check_holes(&s.holes)?;
    check_cuts(&s.cuts)
}

fn option(field: &str, value: Option<f64>, (low, high): (f64, f64), unit: &str) -> ValidationResult {
    value.map_or(Ok(()), |v| check_range(field, v, low, high, unit))
}

fn region_vectors(field: &str, list: &[RegionVector], unit: &str) -> ValidationResult {
    for (i, item) in list.iter().enumerate() {
        region(&item.region).map_err(|e| within(&format!("{field}.{i}.region"), e))?;
        vector(&format!("{field}.{i}.value"), item.value, 1e6, unit)?;
    }
    Ok(())
}

fn region(region: &Region) -> ValidationResult {
    let unit = |value: f64| check_range("", value, 0.0, 1.0, "");
    match region {
        Region::Point(u, v) => unit(*u).and(unit(*v)),
        Region::Rect(u, v) => [u.0, u.1, v.0, v.1].into_iter().try_for_each(unit),
        _ => Ok(()),
    }
}

fn path(path: &[PathKey]) -> ValidationResult {
    for (i, key) in path.iter().enumerate() {
        check_range(&format!("path.{i}.time"), key.time, 0.0, 1e6, "s")?;
        vector(&format!("path.{i}.offset"), key.offset, 1e4, "m")?;
        vector(&format!("path.{i}.rotation"), key.rotation, 36000.0, "degrees")?;
        if i > 0 && key.time <= path[i - 1].time {
            let problem = format!("{} s does not come after {} s", key.time, path[i - 1].time);
            return Err(InputError::new(format!("path.{i}.time"), problem));
        }
    }
    Ok(())
}

fn body(b: &BodySpec) -> ValidationResult {
    match &b.shape {
        Shape::Box(size) => {
            for (axis, value) in size.to_array().into_iter().enumerate() {
                check_range(&format!("shape.{axis}"), value, 1e-6, 1e4, "m")?;
            }
        }
        Shape::Ball(radius) => check_range("shape", *radius, 1e-6, 1e4, "m")?,
        Shape::File(_) | Shape::Part(..) | Shape::Polyhedron(_) | Shape::HalfSpace => {}
    }
    placement(&b.placement)?;
    path(&b.path)?;
    motion(b)?;
    if b.material.as_ref().is_some_and(String::is_empty) {
        return Err(InputError::new("material", "has no name"));
    }
    option("friction", b.friction, (0.0, 10.0), "")?;
    option("temperature", b.temperature, (COLDEST, HOTTEST), "°C")?;
    option("restitution", b.restitution, (0.0, 1.0), "")
}

/// Check the heat settings of a scene, without bodies.
pub(crate) fn heat(scene: &Scene) -> ValidationResult {
    check_range("ambient_temperature", scene.ambient_temperature, COLDEST, HOTTEST, "°C")?;
    check_range("convection", scene.convection, 0.0, 1e6, "W/(m² K)")?;
    check_range("contact_conductance", scene.contact_conductance, 1e-3, 1e6, "W/(m² K)")?;
    check_range("time_lapse", scene.time_lapse, 1e-3, 1e4, "")?;
    if let HeatMode::Thesis { sensitivity, conductivity } = scene.heat_mode {
        check_range("heat_mode.sensitivity", sensitivity, 0.0, 1e6, "N/K")?;
        check_range("heat_mode.conductivity", conductivity, 0.0, 1e3, "")?;
    }
    if let Some(oven) = &scene.oven {
        check_range("oven.temperature", oven.temperature, COLDEST, HOTTEST, "°C")?;
        option("oven.convection", oven.convection, (0.0, 1e6), "W/(m² K)")?;
        for (i, key) in oven.schedule.iter().enumerate() {
            check_range(&format!("oven.schedule.{i}.time"), key.time, 0.0, 1e6, "s")?;
            option(&format!("oven.schedule.{i}.temperature"), key.temperature, (COLDEST, HOTTEST), "°C")?;
            if i > 0 && key.time <= oven.schedule[i - 1].time {
                let problem = format!("{} s does not come after {} s", key.time, oven.schedule[i - 1].time);
                return Err(InputError::new(format!("oven.schedule.{i}.time"), problem));
            }
        }
    }
    if let Some(gun) = &scene.heat_gun {
        check_range("heat_gun.temperature", gun.temperature, COLDEST, HOTTEST, "°C")?;
        check_range("heat_gun.convection", gun.convection, 0.0, 1e6, "W/(m² K)")?;
        check_range("heat_gun.half_angle", gun.half_angle, 0.1, 90.0, "degrees")?;
        check_range("heat_gun.reach", gun.reach, 1e-6, 1e4, "m")?;
        vector("heat_gun.position", gun.position, 1e4, "m")?;
        vector("heat_gun.direction", gun.direction, 1e4, "")?;
        if gun.direction == DVec3::ZERO {
            return Err(InputError::new("heat_gun.direction", "points nowhere"));
        }
        path(&gun.path).map_err(|e| within("heat_gun", e))?;
    }
    for (i, heater) in scene.heaters.iter().enumerate() {
        crate::scene::validate::heater(heater).map_err(|e| within(&format!("heaters.{i}"), e))?;
    }
    names("heaters", scene.heaters.iter().map(|h| h.name.as_str()))
}

/// Check a heater; its file is read when the world is built.
fn heater(h: &HeaterSpec) -> ValidationResult {
    for (axis, value) in h.size.iter().flat_map(|s| s.to_array()).enumerate() {
        check_range(&format!("size.{axis}"), value, 1e-6, 1e4, "m")?;
    }
    for (i, hot) in h.hot.iter().enumerate() {
        check_range(&format!("hot.{i}.temperature"), hot.temperature, COLDEST, HOTTEST, "°C")?;
        check_range(&format!("hot.{i}.emissivity"), hot.emissivity, 0.0, 1.0, "")?;
    }
    if h.file.is_none() {
        h.resolve(std::path::Path::new(""))?;
    }
    placement(&h.placement)
}

/// Check mass, density, velocity and spin of a body.
fn motion(b: &BodySpec) -> ValidationResult {
    option("mass", b.mass, (1e-9, 1e9), "kg")?;
    option("density", b.density, (1e-3, 1e6), "kg/m³")?;
    vector("velocity", b.velocity, 1e3, "m/s")?;
    vector("spin", b.spin, 1e4, "rad/s")?;
    if b.mass.is_some() && b.density.is_some() {
        return Err(InputError::new("density", "does not go with a mass: give one of the two"));
    }
    if b.is_dynamic() {
        let field = if b.mass.is_some() { "mass" } else { "density" };
        if !b.path.is_empty() {
            return Err(InputError::new(field, "does not go with a path: a body is led or moves freely"));
        }
        if b.shape == Shape::HalfSpace {
            return Err(InputError::new(field, "does not go with a half space, which has no end"));
        }
        return Ok(());
    }
    for (field, value) in [("velocity", b.velocity), ("spin", b.spin)] {
        if value != DVec3::ZERO {
            return Err(InputError::new(field, "is for a body that moves freely: give it a mass or a density"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Field and problem of the first error in `text`.
    fn refused(text: &str) -> (String, String) {
        let error = Scene::parse(text).expect_err("bad");
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
        assert_eq!(refused(&scene("body: \"arm\", axes: (true, false, true)")).0, "sheets.0.pins.0.axes");
    }
}
