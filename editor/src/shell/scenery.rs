//! Display of the session's world: room, bodies, heaters, sheets as meshes coloured by a field;
//! springs as lines and nodes as dots on request.

use bevy::camera::visibility::NoFrustumCulling;
use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;
use bevy_sheetwork::render::{
    ColourScale, MeshedSurface, SheetRoom, glow, grid_picture, heater_meshes, polyhedra_mesh, room_mesh,
};
use sheetwork::scene::Shape;
use sheetwork::sheet::surface::SurfaceSmoothing;

use super::stage::{self, Quality, Scale};
use super::{Editor, shapes};
use crate::camera::Camera as View;
use crate::gap::PARTS;
use crate::panels::Display;
use crate::session::{Item, Session};

/// Colours of sheets, sRGB.
const SHEET_COLOURS: [(f32, f32, f32); 6] = [
    (0.86, 0.20, 0.08),
    (0.06, 0.42, 0.50),
    (0.88, 0.58, 0.10),
    (0.28, 0.24, 0.58),
    (0.30, 0.50, 0.16),
    (0.72, 0.22, 0.42),
];

/// Brightness factors of sheets of one material in turn, to distinguish stacked sheets.
const SHADES: [f32; 4] = [1.0, 0.80, 0.90, 0.70];

/// Add the systems that display the session's world, for window and pictures.
pub(super) fn add(app: &mut App, quality: Quality) {
    app.insert_resource(quality).insert_resource(Scale(1.0)).init_resource::<DisplayedScene>();
    app.add_systems(Startup, (stage::set_up, mix_paints));
    let show = (rebuild, choose, animate, dots, springs, stage::move_camera);
    // Before the panels, which may replace the session's world: the displayed entities would belong
    // to the old one.
    let order = show.chain().before(EguiPostUpdateSet::EndPass).before(TransformSystems::Propagate);
    app.add_systems(PostUpdate, order);
}

/// Parent of all entities of world `0` of the comparison, with its scale and offset.
#[derive(Component)]
pub struct Root(usize);

/// Part of the room.
#[derive(Component)]
pub struct RoomPart;

/// Body `index` of world `world` of the comparison.
#[derive(Component)]
pub struct BodyPart {
    world: usize,
    index: usize,
}

/// Part of heater `index`.
#[derive(Component)]
pub struct HeaterPart {
    world: usize,
    index: usize,
}

/// Part of the heat gun of world `0`.
#[derive(Component)]
pub struct GunPart(usize);

/// Surface of a sheet.
#[derive(Component)]
pub struct SheetPart {
    world: usize,
    index: usize,
    surface: MeshedSurface,
    smooth: (bool, SurfaceSmoothing),
}

/// Dot of node `node` of sheet `sheet`.
#[derive(Component)]
pub struct Dot {
    world: usize,
    sheet: usize,
    node: usize,
}

/// State for which the entities were made.
#[derive(Resource, Default)]
pub struct DisplayedScene {
    generation: Option<u64>,
    masses: bool,
    moment: Option<(u64, u64, u64, f64, Option<ColourScale>)>,
}

/// Shared materials.
#[derive(Resource)]
pub struct Paints {
    room: Handle<StandardMaterial>,
    body: Handle<StandardMaterial>,
    heater: Handle<StandardMaterial>,
    /// Materials of sheets of the scene's first material, the second and so on, in turn.
    sheets: Vec<Handle<StandardMaterial>>,
    /// White sheet material for vertex colours.
    coloured: Handle<StandardMaterial>,
    dot: Handle<StandardMaterial>,
    touching: Handle<StandardMaterial>,
    round: Handle<Mesh>,
}

/// Create the materials.
pub fn mix_paints(
    mut commands: Commands,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let matt =
        |base_color: Color| StandardMaterial { base_color, perceptual_roughness: 0.85, reflectance: 0.25, ..default() };
    let glowing = |colour: Color| StandardMaterial { emissive: colour.to_linear() * 0.6, ..matt(colour) };
    let sheet = StandardMaterial {
        base_color: Color::WHITE,
        perceptual_roughness: 0.38,
        reflectance: 0.45,
        double_sided: true,
        cull_mode: None,
        // Draws a sheet in front of a coplanar face.
        depth_bias: 40.0,
        ..default()
    };
    commands.insert_resource(Paints {
        room: materials.add(StandardMaterial {
            base_color_texture: Some(images.add(grid_picture())),
            ..matt(Color::srgb(0.95, 0.95, 0.95))
        }),
        body: materials.add(StandardMaterial { perceptual_roughness: 0.6, ..matt(Color::srgb(0.60, 0.67, 0.77)) }),
        heater: materials.add(matt(Color::srgb(0.42, 0.43, 0.45))),
        coloured: materials.add(StandardMaterial { reflectance: 0.35, ..sheet.clone() }),
        sheets: SHEET_COLOURS
            .iter()
            .flat_map(|(r, g, b)| SHADES.map(|shade| Color::srgb(r * shade, g * shade, b * shade)))
            .map(|base_color| materials.add(StandardMaterial { base_color, ..sheet.clone() }))
            .collect(),
        dot: materials.add(glowing(Color::srgb(0.16, 0.18, 0.22))),
        touching: materials.add(glowing(Color::srgb(1.0, 0.80, 0.15))),
        round: meshes.add(shapes::dot()),
    });
}

/// Create the entities of a newly opened scene.
pub fn rebuild(
    mut commands: Commands,
    editor: Res<Editor>,
    paints: Res<Paints>,
    mut shown: ResMut<DisplayedScene>,
    mut scale: ResMut<Scale>,
    (mut meshes, mut materials): (ResMut<Assets<Mesh>>, ResMut<Assets<StandardMaterial>>),
    roots: Query<Entity, With<Root>>,
) {
    if shown.generation == Some(editor.session.generation()) {
        return;
    }
    *shown = DisplayedScene { generation: Some(editor.session.generation()), ..default() };
    roots.iter().for_each(|root| commands.entity(root).despawn());
    scale.0 = 2.0 / View::fitted(editor.session.world()).distance.max(1e-6);
    let assets = &mut (&mut *meshes, &mut *materials);
    for (which, session) in (0..).map_while(|which| Some((which, editor.session.shown(which)?))) {
        let place = Transform::from_scale(Vec3::splat(scale.0)).with_translation(stage::aside(which));
        let root = commands.spawn((Root(which), place, Visibility::default())).id();
        furnish(&mut commands, (session, which, root), &paints, assets);
        for index in 0..session.world().sheets().len() {
            let Some((part, mesh)) = sheet_part(&editor, (which, index), editor.state.display) else { continue };
            let paint = paint_of(&paints, session, index, part.surface.is_coloured());
            let look = (Mesh3d(assets.0.add(mesh)), MeshMaterial3d(paint), Transform::default());
            commands.spawn((part, NoFrustumCulling, look, stage::layer(which), ChildOf(root)));
        }
    }
}

/// Create the room, the bodies and the heaters of a world.
fn furnish(
    commands: &mut Commands,
    (session, world, root): (&Session, usize, Entity),
    paints: &Paints,
    (meshes, materials): &mut (&mut Assets<Mesh>, &mut Assets<StandardMaterial>),
) {
    let mut look = |mesh: Mesh, paint: &Handle<StandardMaterial>| {
        (Mesh3d(meshes.add(mesh)), MeshMaterial3d(paint.clone()), stage::layer(world), ChildOf(root))
    };
    if let Some(room) = &session.scene().room {
        commands.spawn((look(room_mesh(&SheetRoom::from(room)), &paints.room), RoomPart, NotShadowCaster));
    }
    for (index, body) in session.world().rigid().iter().flat_map(|r| r.bodies()).enumerate() {
        let mesh = match &body.shape {
            Shape::Ball(radius) => Sphere::new(*radius as f32).mesh().uv(64, 40),
            Shape::HalfSpace => continue,
            _ => polyhedra_mesh(&body.polyhedra),
        };
        commands.spawn((look(mesh, &paints.body), BodyPart { world, index }));
    }
    for (index, spec) in session.scene().heaters.iter().enumerate() {
        // The files were validated when the world was built.
        let heaters = spec.resolve(&session.scene().base).unwrap_or_default();
        let (cold, faces) = heater_meshes(&heaters);
        let at = Transform::from_translation(spec.placement.position.as_vec3())
            .with_rotation(spec.placement.quaternion().as_quat());
        // A shadow would hide the heated sheet.
        let part = || (at, HeaterPart { world, index }, NotShadowCaster);
        if let Some(mesh) = cold {
            commands.spawn((look(mesh, &paints.heater), part()));
        }
        for (mesh, celsius) in faces {
            let colour = if spec.on { glow(celsius) } else { LinearRgba::gray(0.15) };
            let material = materials.add(StandardMaterial { base_color: colour.into(), unlit: spec.on, ..default() });
            commands.spawn((look(mesh, &material), part()));
        }
    }
    if let Some(spec) = &session.scene().heat_gun {
        let mut part = |mesh: Mesh, paint: &Handle<StandardMaterial>| {
            let look = look(mesh.scaled_by(Vec3::splat(spec.reach as f32)), paint);
            commands.spawn((look, GunPart(world), NotShadowCaster));
        };
        part(shapes::barrel(), &paints.heater);
        if spec.on {
            let base_color = Color::from(glow(spec.temperature)).with_alpha(0.22);
            let alpha_mode = AlphaMode::Blend;
            let air = StandardMaterial { base_color, alpha_mode, unlit: true, cull_mode: None, ..default() };
            part(shapes::jet(spec.half_angle.to_radians() as f32), &materials.add(air));
        }
    }
}

fn sheet_part(editor: &Editor, (world, index): (usize, usize), display: Display) -> Option<(SheetPart, Mesh)> {
    let sheet = editor.session.shown(world)?.world().sheets().get(index)?;
    let parts = if display.smooth && sheet.model.triangles.is_none() { PARTS } else { 1 };
    let layer = (display.layer, parts, display.spline);
    let (mesh, surface) = MeshedSurface::new(sheet, &sheet.state.x, layer, is_coloured(editor, world, index))?;
    Some((SheetPart { world, index, surface, smooth: (display.smooth, display.spline) }, mesh))
}

/// Material of sheet `index`: white for vertex colours, otherwise a colour per material of the
/// scene, in shades for its sheets in turn.
fn paint_of(paints: &Paints, session: &Session, index: usize, coloured: bool) -> Handle<StandardMaterial> {
    // Materials, and the number of sheets of each so far.
    let mut kinds = Vec::new();
    let numbers = session.scene().sheets.iter().map(|spec| {
        let number = kinds.iter().position(|(kind, _)| *kind == &spec.material).unwrap_or_else(|| {
            kinds.push((&spec.material, 0));
            kinds.len() - 1
        });
        kinds[number].1 += 1;
        (number, kinds[number].1 - 1)
    });
    let (number, before) = numbers.take(index + 1).last().unwrap_or_default();
    let shade = SHADES.len() * (number % SHEET_COLOURS.len()) + before % SHADES.len();
    let paint = if coloured { Some(&paints.coloured) } else { paints.sheets.get(shade) };
    paint.cloned().unwrap_or_default()
}

/// Whether sheet `index` has vertex colours. Compared worlds share one scale.
fn is_coloured(editor: &Editor, world: usize, index: usize) -> bool {
    let scale = editor.state.display.scale_of(&editor.session);
    let sheet = editor.session.shown(world).and_then(|s| s.world().sheets().get(index));
    scale.zip(sheet).is_some_and(|(scale, sheet)| scale.applies_to(sheet))
}

/// Show or hide parts by the display settings.
pub fn choose(
    editor: Res<Editor>,
    mut rooms: Query<&mut Visibility, (With<RoomPart>, Without<SheetPart>)>,
    mut bodies: Query<&mut Visibility, (With<BodyPart>, Without<SheetPart>, Without<RoomPart>)>,
    mut sheets: Query<(&mut Visibility, &mut SheetPart, &mut Mesh3d, &mut MeshMaterial3d<StandardMaterial>)>,
    mut meshes: ResMut<Assets<Mesh>>,
    paints: Res<Paints>,
    mut shown: ResMut<DisplayedScene>,
) {
    let display = editor.state.display;
    let seen = |yes: bool| if yes { Visibility::Inherited } else { Visibility::Hidden };
    for mut visibility in &mut rooms {
        visibility.set_if_neq(seen(display.room));
    }
    for mut visibility in &mut bodies {
        visibility.set_if_neq(seen(display.bodies));
    }
    for (mut visibility, mut part, mut mesh, mut material) in &mut sheets {
        visibility.set_if_neq(seen(display.surface));
        let Some(session) = editor.session.shown(part.world) else { continue };
        let Some(sheet) = session.world().sheets().get(part.index) else { continue };
        let coloured = is_coloured(&editor, part.world, part.index);
        if (part.smooth != (display.smooth, display.spline) || !part.surface.fits(sheet, display.layer, coloured))
            && let Some((new, fresh)) = sheet_part(&editor, (part.world, part.index), display)
        {
            material.0 = paint_of(&paints, session, new.index, coloured);
            *part = new;
            mesh.0 = meshes.add(fresh);
            shown.moment = None;
        }
    }
}

/// Update bodies, surfaces and dots to the session's present state.
pub fn animate(
    editor: Res<Editor>,
    mut shown: ResMut<DisplayedScene>,
    mut bodies: Query<(&BodyPart, &mut Transform), (Without<Dot>, Without<HeaterPart>, Without<GunPart>)>,
    mut heaters: Query<(&HeaterPart, &mut Transform), (Without<Dot>, Without<GunPart>)>,
    mut guns: Query<(&GunPart, &mut Transform), Without<Dot>>,
    mut sheets: Query<(&mut SheetPart, &Mesh3d)>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let session = &editor.session;
    let scale = editor.state.display.scale_of(session);
    let at = session.playback().map_or(0.0, |recording| recording.at());
    let moment = Some((session.generation(), session.revision(), session.world().steps(), session.alpha() + at, scale));
    // The meshes of a static scene are not uploaded again.
    if shown.moment == moment {
        return;
    }
    shown.moment = moment;
    for (part, mut transform) in &mut bodies {
        let pose = session.shown(part.world).and_then(|s| s.body_pose(part.index));
        if let Some((position, rotation)) = pose {
            transform.set_if_neq(Transform::from_translation(position.as_vec3()).with_rotation(rotation.as_quat()));
        }
    }
    for (part, mut transform) in &mut heaters {
        let place = session.shown(part.world).and_then(|s| s.displayed_position(Item::Heater(part.index)));
        if let Some(place) = place {
            transform.translation = place.as_vec3();
        }
    }
    for (part, mut transform) in &mut guns {
        if let Some((place, to)) = session.shown(part.0).and_then(Session::gun_aim) {
            let turn = Quat::from_rotation_arc(Vec3::Y, to.as_vec3());
            transform.set_if_neq(Transform::from_translation(place.as_vec3()).with_rotation(turn));
        }
    }
    for (mut part, handle) in &mut sheets {
        let Some(session) = session.shown(part.world) else { continue };
        let (Some(sheet), Some(before)) = (session.world().sheets().get(part.index), session.before().get(part.index))
        else {
            continue;
        };
        let Some(mut mesh) = meshes.get_mut(&handle.0) else { continue };
        let moved = session.moved_item().filter(|c| c.0 == Item::Sheet(part.index)).map(|c| c.1.as_vec3());
        // A sleeping sheet keeps its contacts of the last step.
        let met = session.world().rigid().filter(|_| moved.is_none() && sheet.touching().contains(&true));
        let bodies = met.map(|rigid| rigid.view());
        let between = (before, &sheet.state.x, session.alpha() as f32);
        part.surface.write(&mut mesh, between, bodies.as_ref(), |positions, _| {
            if let Some(by) = moved {
                positions.iter_mut().for_each(|p| *p = (Vec3::from(*p) + by).into());
            }
        });
        if let Some(scale) = scale.filter(|_| part.surface.is_coloured()) {
            part.surface.paint(&mut mesh, sheet, &scale);
        }
    }
}

/// Create, move and remove the dots of the nodes.
pub fn dots(
    mut commands: Commands,
    editor: Res<Editor>,
    paints: Res<Paints>,
    mut shown: ResMut<DisplayedScene>,
    roots: Query<(Entity, &Root)>,
    mut dots: Query<(Entity, &Dot, &mut Transform, &mut MeshMaterial3d<StandardMaterial>)>,
) {
    let session = &editor.session;
    let wanted = editor.state.display.nodes;
    if shown.masses != wanted {
        shown.masses = wanted;
        dots.iter().for_each(|(entity, ..)| commands.entity(entity).despawn());
        let of_root = |(root, which): (Entity, &Root)| Some((root, which.0, session.shown(which.0)?));
        let worlds = roots.iter().filter_map(of_root).filter(|_| wanted);
        let sheets =
            worlds.flat_map(|(root, world, s)| s.world().sheets().iter().enumerate().map(move |p| (root, world, p)));
        for (root, world, (index, sheet)) in sheets {
            // A dot is about a third as wide as the shortest spacing.
            let radius = sheet.spacing().map_or(1e-3, |(shortest, _)| 0.16 * shortest) as f32;
            for mass in 0..sheet.node_count() {
                let place =
                    Transform::from_translation(sheet.state.x.get(mass).as_vec3()).with_scale(Vec3::splat(radius));
                let look = (Mesh3d(paints.round.clone()), MeshMaterial3d(paints.dot.clone()), NotShadowCaster);
                commands.spawn((
                    Dot { world, sheet: index, node: mass },
                    look,
                    place,
                    stage::layer(world),
                    ChildOf(root),
                ));
            }
        }
        return;
    }
    let alpha = session.alpha();
    for (_, dot, mut transform, mut paint) in &mut dots {
        let Some(session) = session.shown(dot.world) else { continue };
        let (Some(sheet), Some(before)) = (session.world().sheets().get(dot.sheet), session.before().get(dot.sheet))
        else {
            continue;
        };
        if dot.node < sheet.node_count() && dot.node < before.len() {
            let place = before.get(dot.node).lerp(sheet.state.x.get(dot.node), alpha).as_vec3();
            if transform.translation != place {
                transform.translation = place;
            }
            let touching = sheet.touching().get(dot.node).copied().unwrap_or(false);
            paint.set_if_neq(MeshMaterial3d(if touching { paints.touching.clone() } else { paints.dot.clone() }));
        }
    }
}

/// Draw the springs as lines: blue in compression, red in tension, full colour at the sheet's
/// largest strain. For a sheet without springs its mesh edges are drawn.
pub fn springs(editor: Res<Editor>, scale: Res<Scale>, mut gizmos: Gizmos) {
    if !editor.state.display.springs {
        return;
    }
    for (which, session) in (0..).map_while(|which| Some((which, editor.session.shown(which)?))) {
        springs_of(session, stage::aside(which), scale.0, &mut gizmos);
    }
}

fn springs_of(session: &Session, aside: Vec3, scale: f32, gizmos: &mut Gizmos) {
    let alpha = session.alpha();
    for (sheet, before) in session.world().sheets().iter().zip(session.before()) {
        let springs = sheet.springs();
        let at = |i: u32| before.get(i as usize).lerp(sheet.state.x.get(i as usize), alpha);
        let seen = |i: u32| at(i).as_vec3() * scale + aside;
        let strain = |i: usize| at(springs.a[i]).distance(at(springs.b[i])) / springs.rest[i] - 1.0;
        let largest = (0..springs.len()).map(|i| strain(i).abs()).fold(1e-3, f64::max);
        if springs.is_empty() {
            for [a, b] in sheet.edges() {
                gizmos.line(seen(a), seen(b), strain_colour(0.0));
            }
        }
        for i in 0..springs.len() {
            gizmos.line(seen(springs.a[i]), seen(springs.b[i]), strain_colour((strain(i) / largest) as f32));
        }
    }
}

/// -1 blue, 0 pale, 1 red.
fn strain_colour(s: f32) -> LinearRgba {
    let pale = LinearRgba::rgb(0.85, 0.85, 0.80);
    let full = if s < 0.0 { LinearRgba::rgb(0.03, 0.16, 0.95) } else { LinearRgba::rgb(0.95, 0.05, 0.02) };
    pale + (full - pale) * s.abs().min(1.0).sqrt()
}
