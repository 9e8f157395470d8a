//! Effect of an edit of the scene on a running world.
//!
//! Some fields are parameters that the world accepts between two steps. Others need a new world
//! that takes the present state, as long as it has the same nodes: material constants, bodies, heat
//! sources. Other fields, such as the grid, make sheets that the present state does not fit: the
//! world restarts.

use sheetwork::scene::{Air, MaterialChoice, Placement, Region, Scene, SheetSpec};

/// Update of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// None: the edit does not concern the world.
    Nothing,
    /// Parameters are set at run time.
    Live,
    /// A new world continues from the present state.
    GoesOn,
    /// A new world starts.
    Anew,
}

/// Update needed when `old` becomes `new`.
pub fn between(old: &Scene, new: &Scene) -> Change {
    let kinds = [
        (Change::Nothing, without_words as fn(&Scene) -> Scene),
        (Change::Live, without_live),
        (Change::GoesOn, without_state_kept),
    ];
    kinds.into_iter().find(|(_, rest)| rest(old) == rest(new)).map_or(Change::Anew, |(change, _)| change)
}

/// The scene without fields for display alone, and without spots, which act at the start only and
/// are painted by hand.
fn without_words(scene: &Scene) -> Scene {
    let (name, description) = (String::new(), String::new());
    let mut scene = Scene { name, description, duration: 0.0, camera: None, file: None, ..scene.clone() };
    scene.sheets.iter_mut().for_each(|sheet| sheet.spots.clear());
    scene
}

/// The scene without parameters of a running world.
fn without_live(scene: &Scene) -> Scene {
    let blank = Scene::default();
    let mut scene = Scene {
        gravity: blank.gravity,
        engine: blank.engine,
        dt: blank.dt,
        tolerance: blank.tolerance,
        air: Air::default(),
        ambient_temperature: blank.ambient_temperature,
        convection: blank.convection,
        time_lapse: blank.time_lapse,
        ..without_words(scene)
    };
    for sheet in &mut scene.sheets {
        let base = SheetSpec::default();
        // Two constants of a material change the stiffness of the same nodes; the others change the
        // nodes.
        if let Ok(mut material) = sheet.material.resolve(&scene.base) {
            (material.young, material.poisson) = (1.0, 0.0);
            sheet.material = MaterialChoice::Inline(material);
        }
        (sheet.damping, sheet.damping_ratio, sheet.drag) = (base.damping, base.damping_ratio, base.drag);
        (sheet.friction, sheet.restitution) = (None, None);
        (sheet.flexion_limit, sheet.inter_layer_stiffness) = (base.flexion_limit, base.inter_layer_stiffness);
    }
    if let Some(oven) = &mut scene.oven {
        (oven.on, oven.temperature) = (true, 0.0);
    }
    for heater in &mut scene.heaters {
        heater.on = true;
        // The world has one temperature for all hot faces of a heater.
        let first = heater.hot.first().map(|face| face.temperature);
        if heater.hot.iter().all(|face| Some(face.temperature) == first) {
            heater.hot.iter_mut().for_each(|face| face.temperature = 0.0);
        }
    }
    if let Some(gun) = &mut scene.heat_gun {
        (gun.on, gun.temperature) = (true, 0.0);
        (gun.position, gun.direction) = Default::default();
    }
    scene
}

/// The scene without fields that the present state does not depend on.
fn without_state_kept(scene: &Scene) -> Scene {
    let blank = Scene::default();
    let heats = scene.oven.is_some()
        || scene.heat_gun.is_some()
        || !scene.heaters.is_empty()
        || scene.ambient_temperature != blank.ambient_temperature
        || scene.bodies.iter().any(|b| b.temperature.is_some())
        || scene.sheets.iter().any(|s| s.temperature.is_some() || s.temperature_gradient || !s.spots.is_empty());
    let mut scene = Scene {
        bodies: Vec::new(),
        heaters: Vec::new(),
        oven: None,
        heat_gun: None,
        contact: blank.contact.clone(),
        contact_conductance: blank.contact_conductance,
        heat_mode: blank.heat_mode,
        ..without_live(scene)
    };
    for sheet in &mut scene.sheets {
        let base = SheetSpec::default();
        sheet.material = base.material;
        sheet.slits.clear();
        // Creep, plasticity and heat are stored relative to the shape in which the sheet was built.
        if !(heats || sheet.plastic || sheet.creep) {
            sheet.creases.clear();
        }
        (sheet.forces, sheet.pressure, sheet.probes) = (Vec::new(), Vec::new(), Default::default());
        sheet.temperature = None;
        // Single nodes are pinned by hand at their present positions; pins of regions refer to
        // initial positions.
        sheet.pins.retain(|pin| !matches!(pin.region, Region::Masses(_)));
    }
    scene
}

/// Whether the dynamic bodies are the same in both scenes, so that their state can be transferred.
pub fn same_free_bodies(old: &Scene, new: &Scene) -> bool {
    let free = |scene: &Scene| {
        let all = scene.bodies.iter().enumerate().filter(|(_, b)| b.is_dynamic());
        all.map(|(i, b)| (i, b.name.clone(), b.shape.clone(), (b.mass, b.density))).collect::<Vec<_>>()
    };
    free(old) == free(new)
}

/// `placement` translated by `by`, m.
pub fn shifted(placement: &Placement, by: glam::DVec3) -> Placement {
    Placement { position: placement.position + by, rotation: placement.rotation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::{BodySpec, OvenSpec, PinSpec, Shape};

    fn scene() -> Scene {
        Scene { sheets: vec![SheetSpec { material: "hips".into(), ..SheetSpec::thesis() }], ..Scene::thesis() }
    }

    #[test]
    fn an_edit_is_classified_by_the_least_update_of_the_world() {
        let old = scene();
        let set = |path: &str, value: &str| between(&old, &old.with_override(path, value).expect("valid"));
        assert_eq!(between(&old, &old), Change::Nothing);
        assert_eq!(set("description", "\"words\""), Change::Nothing);
        assert_eq!(set("gravity", "(0, -1, 0)"), Change::Live);
        assert_eq!(set("engine", "rk4"), Change::Live);
        assert_eq!(set("sheets.0.friction", "0.5"), Change::Live);
        assert_eq!(set("sheets.0.material.density", "900"), Change::GoesOn);
        assert_eq!(set("sheets.0.material", "pvc"), Change::GoesOn);
        assert_eq!(set("sheets.0.grid", "(5, 2, 5)"), Change::Anew);
        assert_eq!(set("sheets.0.placement.position.1", "0.1"), Change::Anew);
        assert_eq!(between(&old, &Scene { oven: Some(OvenSpec::default()), ..old.clone() }), Change::GoesOn);
        let with_body = Scene { bodies: vec![BodySpec::new(Shape::Ball(0.1))], ..old.clone() };
        assert_eq!(between(&old, &with_body), Change::GoesOn);
        assert!(same_free_bodies(&old, &with_body));
        let mut free = with_body.clone();
        free.bodies[0].mass = Some(1.0);
        assert!(!same_free_bodies(&with_body, &free));
    }

    #[test]
    fn a_constant_of_an_inline_material_is_a_live_parameter() {
        let old = scene().with_override("sheets.0.material.young", "1e9").expect("valid");
        let new = old.with_override("sheets.0.material.young", "2e9").expect("valid");
        assert_eq!(between(&old, &new), Change::Live);
    }

    #[test]
    fn pinning_a_node_continues_the_run_and_pinning_an_edge_restarts_it() {
        let old = scene();
        let pinned = |region| {
            let mut new = old.clone();
            new.sheets[0].pins.push(PinSpec::fixed(region));
            between(&old, &new)
        };
        assert_eq!(pinned(Region::Masses(vec![3])), Change::GoesOn);
        assert_eq!(pinned(Region::Left), Change::Anew);
    }
}
