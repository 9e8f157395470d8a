//! Transfer of new, changed, moved and removed entities to the world.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::{Allow, Has};
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;
use sheetwork::scene::{BodySpec, PathKey, PinSpec, Polyhedron, Shape, SheetSpec};
use sheetwork::{InputError, SheetId};

use super::motion::{LastParent, PoseHistory};
use super::placement::parent_transform;
use super::world::KinematicMotion;
use super::{
    BodyMotion, BodyShape, Sheet, SheetBody, SheetClock, SheetMotion, SheetPolyhedra, SheetState, SheetWorld, placement,
};

/// Marker of an entity whose description was rejected. It is tried again after a change of the
/// description.
#[derive(Component)]
pub(crate) struct Rejected;

/// Insert the link of an entity to what was added to the world, or mark a rejected entity, which
/// loses its link `L`.
pub(super) fn insert_link<L: Component>(
    mut entity: EntityCommands,
    kind: &str,
    added: Result<impl Bundle, InputError>,
) {
    match added {
        Ok(link) => _ = entity.try_insert(link).try_remove::<Rejected>(),
        Err(problem) => {
            error!("{kind} {} is left out: {problem}", entity.id());
            entity.try_insert(Rejected).try_remove::<L>();
        }
    }
}

/// Name and place of a sheet's entity.
type SheetPlace<'a> = (Option<&'a Name>, &'a Transform, Option<&'a ChildOf>);

/// Add new sheets; change or rebuild sheets with a changed description.
pub(super) fn sync_sheets(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    clock: Res<SheetClock>,
    mut sheets: Query<(Entity, Ref<Sheet>, Option<&mut SheetMotion>, SheetPlace, Has<Rejected>)>,
    transforms: TransformHelper,
) {
    for (entity, sheet, motion, (name, transform, parent), refused) in &mut sheets {
        let stale = match &motion {
            None => !refused || sheet.is_changed(),
            Some(motion) => {
                motion.generation != world.generation() || (sheet.is_changed() && motion.built_from != *sheet)
            }
        };
        if !stale {
            continue;
        }
        // In a restarted world the sheet is at its first place again, unless it was sent elsewhere.
        let start = motion.as_ref().and_then(|m| m.start());
        let anew = motion.as_ref().is_some_and(|m| m.generation != world.generation() && m.given == Some(*transform));
        if let Some(mut motion) = motion.filter(|m| m.generation == world.generation()) {
            if change_in_place(&mut world, &motion, &sheet) {
                motion.built_from = Sheet::clone(&sheet);
                continue;
            }
            world.remove_sheet(motion.id());
        }
        let place = start.filter(|_| anew).unwrap_or(*transform);
        let above = parent_transform(parent, &transforms);
        let there = above * place;
        let mut added = add_sheet(&mut world, &clock, &sheet, name, &there);
        if let Ok((motion, _)) = &mut added {
            motion.given = Some(*transform);
            motion.parent = Some(LastParent::new(parent, above));
            if let Some(sheet) = world.get_sheet(motion.id()) {
                motion.follow(sheet, (world.time(), placement::pose_of(&there)), start.unwrap_or(*transform));
            }
        }
        insert_link::<SheetMotion>(commands.entity(entity), "sheet", added);
    }
}

fn add_sheet(
    world: &mut SheetWorld,
    clock: &SheetClock,
    sheet: &Sheet,
    name: Option<&Name>,
    there: &GlobalTransform,
) -> Result<(SheetMotion, SheetState), InputError> {
    let mut spec = sheet.scaled(there.scale());
    let inner = placement::pose_of_placement(&spec.placement);
    spec.placement = placement::placement_of(placement::compose(placement::pose_of(there), inner));
    if let (true, Some(name)) = (spec.name.is_empty(), name) {
        spec.name = name.as_str().to_owned();
    }
    let built = insert_sheet(world, &spec, sheet)?;
    if clock.auto_step {
        shorten_step(world, built.0.id());
    }
    Ok(built)
}

/// Add a sheet to the world at the placement of its description. Its paths start at the present
/// time.
pub(crate) fn insert_sheet(
    world: &mut SheetWorld,
    spec: &SheetSpec,
    built_from: &Sheet,
) -> Result<(SheetMotion, SheetState), InputError> {
    let mut spec = spec.clone();
    for pin in &mut spec.pins {
        delay(&mut pin.path, world.time());
        pin.until = pin.until.map(|time| time + world.time());
    }
    let id = world.add_sheet(&spec)?;
    let added = world.get_sheet(id).ok_or_else(|| InputError::new("sheets", "the added sheet is gone"))?;
    let motion = SheetMotion::new(
        (id, added.name.clone()),
        world.generation(),
        built_from.clone(),
        world.time(),
        &added.state.x,
    );
    Ok((motion, SheetState::from_sheet(added)))
}

/// Shift a path to start at `time`, s: paths are in the world's time.
fn delay(path: &mut [PathKey], time: f64) {
    path.iter_mut().for_each(|key| key.time += time);
}

/// Reduce the world's time step to the stability limit of a sheet.
fn shorten_step(world: &mut SheetWorld, id: SheetId) {
    let engine = world.engine().info();
    let Some(sheet) = world.get_sheet(id) else { return };
    let name = sheet.name.clone();
    let frequency = sheet.largest_frequency(40);
    // hω = 1 is stable for every explicit scheme with damping; implicit schemes have no limit.
    if engine.adaptive || !engine.stability_limit.is_finite() || frequency <= 0.0 {
        return;
    }
    let longest = 1.0 / frequency;
    if longest < world.dt() && world.set_dt(longest.max(1e-7)).is_ok() {
        info!("{name} oscillates at up to {frequency:.0} rad/s: the time step is now {longest:.2e} s");
    }
}

/// Apply the changes of a description to the running sheet. Returns false, without a change, when
/// the sheet must be rebuilt.
fn change_in_place(world: &mut SheetWorld, motion: &SheetMotion, sheet: &Sheet) -> bool {
    let (old, new) = (&motion.built_from.spec, &sheet.spec);
    let alike = SheetSpec {
        material: old.material.clone(),
        damping: old.damping,
        damping_ratio: old.damping_ratio,
        drag: old.drag,
        friction: old.friction,
        restitution: old.restitution,
        flexion_limit: old.flexion_limit,
        inter_layer_stiffness: old.inter_layer_stiffness,
        grid: (old.grid.0, new.grid.1, old.grid.2),
        pins: old.pins.clone(),
        ..new.clone()
    };
    if alike != *old || !change_pins(world, motion.id(), &old.pins, &new.pins) {
        return false;
    }
    let grid = (new.grid.0, new.grid.2);
    if grid != (old.grid.0, old.grid.2) && world.remap(motion.name(), grid).is_err() {
        return false;
    }
    let defaults = world.scene().contact.clone();
    let material = new.material.resolve(&world.scene().base);
    let Some(running) = world.get_sheet_mut(motion.id()) else { return false };
    let changed = material.and_then(|material| {
        let ratio = new.damping_ratio.unwrap_or(material.damping_ratio);
        running.set_material(material)?;
        running.set_damping(new.damping)?;
        running.set_damping_ratio(ratio)?;
        running.set_drag(new.drag.0, new.drag.1)?;
        running.set_inter_layer_stiffness(new.inter_layer_stiffness)?;
        running.set_flexion_limit(new.flexion_limit)
    });
    running.parameters.friction = new.friction.unwrap_or(defaults.friction).clamp(0.0, 10.0);
    running.parameters.restitution = new.restitution.unwrap_or(defaults.restitution).clamp(0.0, 1.0);
    running.wake();
    if let Err(problem) = changed {
        warn!("{}: {problem}", motion.name());
    }
    true
}

/// Unpin what the list of pins no longer has, and pin what is new, where the sheet is. Returns
/// false, without a change, when a pin cannot change on a running sheet.
fn change_pins(world: &mut SheetWorld, id: SheetId, old: &[PinSpec], new: &[PinSpec]) -> bool {
    let gone: Vec<&PinSpec> = old.iter().filter(|pin| !new.contains(pin)).collect();
    let added: Vec<&PinSpec> = new.iter().filter(|pin| !old.contains(pin)).collect();
    if !gone.iter().chain(&added).all(|pin| pin.is_live()) {
        return false;
    }
    let mut changes = gone.iter().map(|pin| world.unpin(id, &pin.region).map(|_| ())).collect::<Vec<_>>();
    changes.extend(added.iter().map(|pin| world.pin(id, pin).map(|_| ())));
    for problem in changes.into_iter().filter_map(Result::err) {
        error!("pins of a sheet: {problem}");
    }
    true
}

/// Add new bodies; rebuild changed ones.
pub(super) fn sync_bodies(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    assets: Option<Res<Assets<SheetPolyhedra>>>,
    mut bodies: Query<(Entity, Ref<SheetBody>, Option<&Name>, Option<&mut BodyMotion>, Has<Rejected>)>,
    transforms: TransformHelper,
) {
    for (entity, body, name, mut motion, refused) in &mut bodies {
        if let Some(motion) = motion.as_mut().filter(|_| body.is_changed()) {
            update_temperature(&mut world, motion.bypass_change_detection(), &body);
        }
        let motion = motion.as_deref();
        let stale = match motion {
            None => !refused || body.is_changed(),
            Some(motion) => {
                motion.generation != world.generation() || (body.is_changed() && motion.built_from != *body)
            }
        };
        let ready = polyhedra_of(&body.shape, assets.as_deref());
        let (true, Some(polyhedra)) = (stale, ready) else { continue };
        // The transform of a body on a path holds its present pose, so the rebuilt body starts from
        // its original pose. A dynamic body continues from its present pose, unless the world was
        // restarted.
        let led = |m: &BodyMotion| m.follows_path() && m.built_from.path == body.path;
        let anew = |m: &BodyMotion| m.history.is_some() && m.generation != world.generation();
        let start = motion.filter(|m| led(m) || anew(m)).map(|m| m.given);
        let Some(there) = start.or_else(|| transforms.compute_global_transform(entity).ok()) else { continue };
        remove_body(&mut world, motion);
        let added = add_body(&mut world, &body, polyhedra, name, there);
        insert_link::<BodyMotion>(commands.entity(entity), "body", added);
    }
}

/// Apply a changed temperature to the running body.
fn update_temperature(world: &mut SheetWorld, motion: &mut BodyMotion, body: &SheetBody) {
    let (Some(was), Some(celsius)) = (motion.built_from.temperature, body.temperature) else { return };
    if was == celsius || motion.generation != world.generation() {
        return;
    }
    for name in &motion.names {
        if let Err(problem) = world.set(&format!("bodies.{name}.temperature"), &celsius.to_string()) {
            error!("{problem}");
            return;
        }
    }
    motion.built_from.temperature = Some(celsius);
}

/// Polyhedra of a shape, empty for other shapes; `None` while their file is loading.
fn polyhedra_of<'a>(shape: &'a BodyShape, assets: Option<&'a Assets<SheetPolyhedra>>) -> Option<&'a [Polyhedron]> {
    match shape {
        BodyShape::Polyhedra(polyhedra) => Some(polyhedra),
        BodyShape::Asset(handle) => assets?.get(handle).map(|a| a.polyhedra.as_slice()),
        BodyShape::Cuboid(_) | BodyShape::Ball(_) | BodyShape::HalfSpace { .. } => Some(&[]),
    }
}

fn add_body(
    world: &mut SheetWorld,
    body: &SheetBody,
    polyhedra: &[Polyhedron],
    name: Option<&Name>,
    there: GlobalTransform,
) -> Result<BodyMotion, InputError> {
    let scale = there.scale().abs().as_dvec3();
    let shapes: Vec<Shape> = match &body.shape {
        BodyShape::Cuboid(size) => vec![Shape::Box(*size * scale)],
        BodyShape::Ball(radius) => vec![Shape::Ball(radius * scale.x)],
        BodyShape::HalfSpace { .. } => vec![Shape::HalfSpace],
        BodyShape::Polyhedra(_) | BodyShape::Asset(_) => {
            polyhedra.iter().map(|p| Shape::Polyhedron(p.clone().scaled(scale))).collect()
        }
    };
    if shapes.is_empty() {
        return Err(InputError::new("shape", "no polyhedra: a body has at least 1"));
    }
    if shapes.len() > 1 && body.is_free() {
        return Err(InputError::new("shape", format!("{} polyhedra: a body that moves freely is one", shapes.len())));
    }
    let mut path = body.path.clone();
    delay(&mut path, world.time());
    let entity_name = name.map(|n| n.as_str().to_owned()).unwrap_or_default();
    let name = if body.name.is_empty() { entity_name } else { body.name.clone() };
    let placement = placement::placement_of(placement::pose_of(&there));
    let (mut ids, mut names) = (Vec::new(), Vec::new());
    for shape in shapes {
        let spec = BodySpec {
            name: name.clone(),
            placement,
            path: path.clone(),
            mass: body.mass,
            density: body.density,
            velocity: body.velocity,
            spin: body.spin,
            material: body.material.clone(),
            temperature: body.temperature,
            friction: body.friction,
            restitution: body.restitution,
            ..BodySpec::new(shape)
        };
        match world.add_body(&spec) {
            Ok(id) => {
                ids.push(id);
                names.extend(world.body_name(id).map(str::to_owned));
            }
            Err(problem) => {
                ids.into_iter().for_each(|id| {
                    world.remove_body(id);
                });
                return Err(problem.into());
            }
        }
    }
    let history = pose_history_of(world, body, names.first());
    Ok(BodyMotion { ids, names, generation: world.generation(), built_from: body.clone(), given: there, path, history })
}

/// Present pose of a dynamic body of that name; `None` for other bodies.
fn pose_history_of(world: &SheetWorld, body: &SheetBody, name: Option<&String>) -> Option<PoseHistory> {
    let rigid = world.rigid().filter(|_| body.is_free())?;
    let pose = rigid.pose(rigid.index_of(name?)?)?;
    Some(PoseHistory::new(world.time(), pose))
}

/// Add a body to the world at the placement of its description. Its path starts at the present
/// time.
pub(crate) fn insert_body(
    world: &mut SheetWorld,
    spec: &BodySpec,
    built_from: &SheetBody,
    there: GlobalTransform,
) -> Result<BodyMotion, InputError> {
    let mut spec = spec.clone();
    delay(&mut spec.path, world.time());
    spec.temperature_schedule.iter_mut().for_each(|key| key.time += world.time());
    let id = world.add_body(&spec)?;
    let name = world.body_name(id).unwrap_or_default().to_owned();
    let (generation, built_from) = (world.generation(), built_from.clone());
    let history = pose_history_of(world, &built_from, Some(&name));
    Ok(BodyMotion { ids: vec![id], names: vec![name], generation, built_from, given: there, path: spec.path, history })
}

pub(super) fn remove_body(world: &mut SheetWorld, motion: Option<&BodyMotion>) {
    let Some(motion) = motion.filter(|m| m.generation == world.generation()) else { return };
    for id in &motion.ids {
        world.remove_body(*id);
    }
}

/// Move kinematic bodies whose transform has changed since the last tick; place them directly while
/// time is paused.
pub(super) fn move_bodies(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    clock: Res<SheetClock>,
    mut bodies: Query<(Entity, &mut BodyMotion)>,
    transforms: TransformHelper,
) {
    for (entity, mut motion) in bodies.iter_mut().filter(|(_, m)| !m.writes_transform()) {
        let Ok(there) = transforms.compute_global_transform(entity) else { continue };
        if there == motion.given || motion.generation != world.generation() {
            continue;
        }
        let scaled = (there.scale() - motion.given.scale()).abs().max_element() > 1e-5;
        if clock.due() <= 0.0 || scaled {
            // The next run of `sync_bodies` adds it again at its new pose, at rest.
            remove_body(&mut world, Some(&motion));
            commands.entity(entity).try_remove::<BodyMotion>();
            continue;
        }
        let (from, to) = (placement::pose_of(&motion.given), placement::pose_of(&there));
        for id in &motion.ids {
            // A motion that no step has begun yet keeps its start.
            match world.moves.iter_mut().find(|m| m.body == *id) {
                Some(waiting) => waiting.to = to,
                None => world.moves.push(KinematicMotion { body: *id, from, to }),
            }
        }
        motion.given = there;
    }
}

/// Move the sheets whose transform was written there, at once and with their velocities; a changed
/// scale builds the sheet again. Motion of a parent moves pins alone.
pub(super) fn move_sheets(
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    mut sheets: Query<(Entity, Ref<Transform>, Option<&ChildOf>, &mut SheetMotion)>,
    transforms: TransformHelper,
) {
    for (entity, transform, parent, mut motion) in &mut sheets {
        if motion.generation != world.generation() {
            continue;
        }
        let above = parent_transform(parent, &transforms);
        let Some(given) = motion.given else {
            let motion = motion.bypass_change_detection();
            motion.given = Some(*transform);
            if let Some(sheet) = world.get_sheet(motion.id()) {
                motion.follow(sheet, (world.time(), placement::pose_of(&(above * *transform))), *transform);
            }
            continue;
        };
        if *transform == given || !transform.is_changed() {
            continue;
        }
        motion.given = Some(*transform);
        if !transform.is_finite() {
            error!("the transform of {entity} is not finite: sheet {} stays where it was", motion.name());
            continue;
        }
        if (transform.scale - given.scale).abs().max_element() > 1e-5 {
            // The next run of `sync_sheets` adds it again at its new size.
            world.remove_sheet(motion.id());
            commands.entity(entity).try_remove::<SheetMotion>();
            continue;
        }
        let from = motion.pose().unwrap_or_else(|| placement::pose_of(&(above * given)));
        let to = placement::pose_of(&(above * *transform));
        let turn = (to.1 * from.1.conjugate()).normalize();
        match world.move_sheet(motion.id(), to.0 - turn * from.0, turn) {
            Ok(()) => {
                if let Some(sheet) = world.get_sheet(motion.id()) {
                    motion.jump(sheet);
                }
            }
            Err(problem) => error!("the transform of {} is not followed: {problem}", motion.name()),
        }
    }
}

/// Remove the sheet from the world with its component.
pub(super) fn sheet_removed(
    removed: On<Remove, Sheet>,
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    motions: Query<&SheetMotion, Allow<Disabled>>,
) {
    if let Ok(motion) = motions.get(removed.entity) {
        if motion.generation == world.generation() {
            world.remove_sheet(motion.id());
        }
        commands.entity(removed.entity).try_remove::<SheetMotion>();
    }
}

/// Remove the body from the world with its component.
pub(super) fn body_removed(
    removed: On<Remove, SheetBody>,
    mut commands: Commands,
    mut world: ResMut<SheetWorld>,
    motions: Query<&BodyMotion>,
) {
    if let Ok(motion) = motions.get(removed.entity) {
        remove_body(&mut world, Some(motion));
        commands.entity(removed.entity).try_remove::<BodyMotion>();
    }
}
