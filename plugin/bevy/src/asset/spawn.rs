//! Scenes as entities: spawned under a root, and spawned again when the scene changes.

use bevy::ecs::system::SystemState;
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sheetwork::scene::{BodySpec, HeatGunSpec, HeaterSpec, PathKey, Placement, Room, Scene, Shape, SheetSpec};
use sheetwork::{InputError, World as Sheets};

use super::SheetScene;
use crate::core::placement::Pose;
use crate::core::{BodyShape, Sheet, SheetBody, SheetHeater, SheetWorld, heater, placement, sync};
#[cfg(feature = "render")]
use crate::render::SheetRoom;

/// Component that spawns the sheets, bodies, heaters and room of a [`SheetScene`] as children of
/// its entity.
///
/// The entity's transform, without its scale, places the scene. An otherwise empty world restarts
/// at time 0 with the scene's gravity, integrator, step, air, contact defaults, surroundings, oven
/// and heat gun. In a world with other entities the newest scene sets gravity, integrator, step,
/// air and surroundings, and oven and heat gun where it has them. The scene restarts when the asset
/// changes or the component is inserted again.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
#[cfg_attr(feature = "render", require(Visibility))]
pub struct SheetSceneRoot(pub Handle<SheetScene>);

/// Message after a [`SheetSceneRoot`] has been spawned or respawned.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SheetSceneSpawned {
    /// Root of the scene.
    pub root: Entity,
}

/// Entities spawned under a root.
#[derive(Component, Default)]
pub(super) struct Spawned {
    children: Vec<Entity>,
}

/// Spawn the scenes of roots whose asset has been loaded or has changed.
pub(super) fn spawn_scenes(
    mut commands: Commands,
    roots: Query<(Entity, Ref<SheetSceneRoot>, Has<Spawned>)>,
    scenes: Res<Assets<SheetScene>>,
    mut changes: MessageReader<AssetEvent<SheetScene>>,
) {
    let modified: Vec<AssetId<SheetScene>> =
        changes.read().filter_map(|e| if let AssetEvent::Modified { id } = e { Some(*id) } else { None }).collect();
    for (entity, root, spawned) in &roots {
        let changed = !spawned || root.is_changed() || modified.contains(&root.0.id());
        if changed && let Some(asset) = scenes.get(&root.0) {
            let scene = asset.scene.clone();
            commands.queue(move |world: &mut World| respawn(world, entity, &scene));
        }
    }
}

/// Replace the children of `root` by `scene`, unless the scene is invalid.
fn respawn(world: &mut World, root: Entity, scene: &Scene) {
    // Set for an invalid scene too, which would otherwise be tried and reported in every frame.
    let before = world.get_mut::<Spawned>(root).map(|mut s| std::mem::take(&mut s.children)).unwrap_or_default();
    if let Err(problem) = Sheets::new(scene) {
        error!("scene \"{}\" is left as it was: {problem}", scene.name);
        set_spawned(world, root, before);
        return;
    }
    for child in before {
        world.try_despawn(child).ok();
    }
    let mut helper = SystemState::<TransformHelper>::new(world);
    let Some(there) = helper.get(world).ok().and_then(|h| h.compute_global_transform(root).ok()) else { return };
    let mut children = Vec::new();
    let built = world.resource_scope(|world, mut sheets: Mut<SheetWorld>| {
        apply_settings(&mut sheets, scene, placement::pose_of(&there))?;
        spawn(world, &mut sheets, root, placement::pose_of(&there), scene, &mut children)
    });
    if let Err(problem) = built {
        error!("scene \"{}\" is incomplete: {problem}", scene.name);
    }
    set_spawned(world, root, children);
    world.write_message(SheetSceneSpawned { root });
}

fn set_spawned(world: &mut World, root: Entity, children: Vec<Entity>) {
    if let Ok(mut root) = world.get_entity_mut(root) {
        root.insert(Spawned { children });
    }
}

fn apply_settings(sheets: &mut SheetWorld, scene: &Scene, outer: Pose) -> Result<(), InputError> {
    let gun = scene.heat_gun.clone().map(|gun| placed_gun(gun, outer));
    if sheets.is_empty() {
        return sheets.restart(&Scene { heat_gun: gun, ..scene.clone() });
    }
    let now = sheets.time();
    sheets.set_surroundings(scene)?;
    if let Some(mut oven) = scene.oven.clone() {
        oven.schedule.iter_mut().for_each(|key| key.time += now);
        sheets.set_oven(Some(oven))?;
    }
    if let Some(mut gun) = gun {
        gun.path.iter_mut().for_each(|key| key.time += now);
        sheets.set_heat_gun(Some(gun))?;
    }
    sheets.set_gravity(scene.gravity)?;
    sheets.set_air(scene.air)?;
    sheets.set_dt(scene.dt)?;
    sheets.set_tolerance(scene.tolerance)?;
    sheets.set_engine(scene.engine);
    sheets.add_pairs(&scene.contact.pairs)
}

/// Add heaters, room, bodies and sheets from the description itself: an entity's transform has
/// single precision.
fn spawn(
    world: &mut World,
    sheets: &mut SheetWorld,
    root: Entity,
    outer: Pose,
    scene: &Scene,
    children: &mut Vec<Entity>,
) -> Result<(), InputError> {
    for spec in &scene.heaters {
        let mut spec = spec.clone();
        let local = placement::transform_of(placement::pose_of_placement(&spec.placement));
        spec.file = spec.file.map(|file| absolute(scene, &file)).transpose()?;
        spec.placement = placed(&spec.placement, outer);
        // The entity's transform holds the placement.
        let component = SheetHeater::from(HeaterSpec { placement: Placement::default(), ..spec.clone() });
        let there = GlobalTransform::from(placement::transform_of(placement::pose_of_placement(&spec.placement)));
        let put = heater::insert(sheets, &spec, &component, there)?;
        let name = Name::new(put.name().to_owned());
        children.push(world.spawn((component, put, local, name, ChildOf(root))).id());
    }
    #[cfg(feature = "render")]
    if let Some(room) = &scene.room {
        children.push(world.spawn((SheetRoom::from(room), Name::new("room"), ChildOf(root))).id());
    }
    let names = spawn_bodies(world, sheets, root, outer, scene, children)?;
    spawn_sheets((world, sheets), root, outer, scene, &names, children)
}

/// Add the bodies; returns their names in the scene with the unique names that the world gave.
fn spawn_bodies(
    world: &mut World,
    sheets: &mut SheetWorld,
    root: Entity,
    outer: Pose,
    scene: &Scene,
    children: &mut Vec<Entity>,
) -> Result<Vec<(String, String)>, InputError> {
    let defaults = &scene.contact;
    let room = scene.room.iter().flat_map(room_bodies);
    let mut names = Vec::new();
    for (spec, scene_name) in scene.bodies.iter().cloned().chain(room).zip(scene.body_names()) {
        if sheets.borrows_bodies() {
            break;
        }
        let mut spec = BodySpec { name: scene_name.clone(), ..spec };
        let local = placement::transform_of(placement::pose_of_placement(&spec.placement));
        match &mut spec.shape {
            Shape::File(file) | Shape::Part(file, _) => *file = absolute(scene, file)?,
            Shape::Polyhedron(_) | Shape::Box(_) | Shape::Ball(_) | Shape::HalfSpace => {}
        }
        spec.friction = spec.friction.or(Some(defaults.friction));
        spec.restitution = spec.restitution.or(Some(defaults.restitution));
        place_body(&mut spec, outer);
        let component = body_component(scene, &spec)?;
        let there = GlobalTransform::from(placement::transform_of(placement::pose_of_placement(&spec.placement)));
        let motion = sync::insert_body(sheets, &spec, &component, there)?;
        names.push((scene_name, motion.name().to_owned()));
        let name = Name::new(motion.name().to_owned());
        children.push(world.spawn((component, motion, local, name, ChildOf(root))).id());
    }
    Ok(names)
}

/// Add the sheets, whose pins name bodies by their `names` in the scene.
fn spawn_sheets(
    (world, sheets): (&mut World, &mut SheetWorld),
    root: Entity,
    outer: Pose,
    scene: &Scene,
    names: &[(String, String)],
    children: &mut Vec<Entity>,
) -> Result<(), InputError> {
    let defaults = &scene.contact;
    for (index, spec) in scene.sheets.iter().enumerate() {
        let mut spec = spec.clone();
        if spec.name.is_empty() {
            spec.name = format!("sheet {index}");
        }
        let local = placement::transform_of(placement::pose_of_placement(&spec.placement));
        spec.file = spec.file.map(|file| absolute(scene, &file)).transpose()?;
        spec.friction = spec.friction.or(Some(defaults.friction));
        spec.restitution = spec.restitution.or(Some(defaults.restitution));
        for body in spec.pins.iter_mut().filter_map(|pin| pin.body.as_mut()) {
            if let Some((_, now)) = names.iter().find(|(name, _)| name == body) {
                body.clone_from(now);
            }
        }
        place_sheet(&mut spec, outer);
        // The entity's transform holds the placement.
        let component = Sheet::from(SheetSpec { placement: Placement::default(), ..spec.clone() });
        let (motion, state) = sync::insert_sheet(sheets, &spec, &component)?;
        let name = Name::new(motion.name().to_owned());
        children.push(world.spawn((component, motion, state, local, name, ChildOf(root))).id());
    }
    Ok(())
}

/// Heat gun in the frame of the scene's root.
fn placed_gun(mut gun: HeatGunSpec, outer: Pose) -> HeatGunSpec {
    gun.position = outer.0 + outer.1 * gun.position;
    gun.direction = outer.1 * gun.direction;
    turn_path(&mut gun.path, outer);
    gun
}

/// Absolute path of a file of the scene: the world resolves relative paths against the folder of
/// its own scene.
fn absolute(scene: &Scene, file: &std::path::Path) -> Result<std::path::PathBuf, InputError> {
    let found = scene.resolve(file);
    std::path::absolute(&found).map_err(|e| InputError::io(&found, &e))
}

fn body_component(scene: &Scene, spec: &BodySpec) -> Result<SheetBody, InputError> {
    let drawn_by_room = |name: &str| scene.room.is_some() && (name == "floor" || name == "back wall");
    let shape = match &spec.shape {
        Shape::File(file) => BodyShape::Polyhedra(sheetwork::scene::pol::read_pol_file(file)?),
        Shape::Part(file, part) => {
            let polyhedra = sheetwork::scene::pol::read_pol_file(file)?;
            BodyShape::Polyhedra(polyhedra.into_iter().skip(*part).take(1).collect())
        }
        Shape::Polyhedron(polyhedron) => BodyShape::Polyhedra(vec![polyhedron.clone()]),
        Shape::Box(size) => BodyShape::Cuboid(*size),
        Shape::Ball(radius) => BodyShape::Ball(*radius),
        Shape::HalfSpace if drawn_by_room(&spec.name) => BodyShape::HalfSpace { drawn: 0.0 },
        Shape::HalfSpace => BodyShape::HalfSpace { drawn: 10.0 },
    };
    Ok(SheetBody {
        name: spec.name.clone(),
        shape,
        friction: spec.friction,
        restitution: spec.restitution,
        path: spec.path.clone(),
        mass: spec.mass,
        density: spec.density,
        velocity: spec.velocity,
        spin: spec.spin,
        material: spec.material.clone(),
        temperature: spec.temperature,
    })
}

/// Half-spaces of the floor and the back wall of a room.
fn room_bodies(room: &Room) -> Vec<BodySpec> {
    let plane = |name: &str, position: [f64; 3], turn: f64| BodySpec {
        name: name.to_owned(),
        placement: Placement { position: position.into(), rotation: [turn, 0.0, 0.0].into() },
        ..BodySpec::new(Shape::HalfSpace)
    };
    let mut planes = vec![plane("floor", [0.0, room.y.0, 0.0], 0.0)];
    if room.back_wall {
        planes.push(plane("back wall", [0.0, 0.0, room.z.0], 90.0));
    }
    planes
}

/// Move the placement of a body from the frame of its scene to world axes.
fn place_body(spec: &mut BodySpec, outer: Pose) {
    if !placement::is_identity(outer) {
        spec.placement = placed(&spec.placement, outer);
        turn_path(&mut spec.path, outer);
        spec.velocity = outer.1 * spec.velocity;
        spec.spin = outer.1 * spec.spin;
    }
}

/// Move the placement, velocities and forces of a sheet from the frame of its scene to world axes.
fn place_sheet(spec: &mut SheetSpec, outer: Pose) {
    if placement::is_identity(outer) {
        return;
    }
    spec.placement = placed(&spec.placement, outer);
    spec.velocity = outer.1 * spec.velocity;
    spec.spin = outer.1 * spec.spin;
    for vector in spec.velocities.iter_mut().chain(&mut spec.forces) {
        vector.value = outer.1 * vector.value;
    }
    for pin in &mut spec.pins {
        turn_path(&mut pin.path, outer);
    }
}

fn placed(inner: &Placement, outer: Pose) -> Placement {
    placement::placement_of(placement::compose(outer, placement::pose_of_placement(inner)))
}

/// Rotate displacements and rotations of a path from the frame of its scene to world axes.
fn turn_path(path: &mut [PathKey], outer: Pose) {
    for key in path {
        key.offset = outer.1 * key.offset;
        let turn = Placement { rotation: key.rotation, ..Placement::default() }.quaternion();
        key.rotation = placement::placement_of((key.offset, outer.1 * turn * outer.1.inverse())).rotation;
    }
}
