//! Rules of the game: a house of cards, three balls, a point for every card that falls.

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use bevy_sheetwork::sheetwork::scene::Scene;

/// The house, and cards that lie beside it: 24 sheets.
const HOUSE: &str = include_str!("../../../../assets/scenes/cards_house.ron");
const LYING: u32 = 9;
const BALLS: u32 = 3;
/// A card has fallen when its centre is lower by this, m, than in the house.
const FALL: f32 = 0.02;
/// A card of the house, with the height of its centre as built, m.
#[derive(Component)]
pub struct Card(f32);

#[derive(Component)]
pub struct Ball;

/// State of a round.
#[derive(Resource, Default)]
pub struct Round {
    pub fallen: usize,
    pub thrown: u32,
    pub is_over: bool,
}

/// Throw of a ball, from a place with a velocity, m and m/s.
#[derive(Message)]
pub struct Throw(pub Vec3, pub Vec3);

/// Build the house again.
#[derive(Message)]
pub struct Restart;

pub struct RulesPlugin;

impl Plugin for RulesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Round>().add_message::<Throw>().add_message::<Restart>();
        app.insert_resource(Time::<Fixed>::from_hz(60.0));
        app.add_systems(Startup, build).add_systems(Update, (restart, throw, score).chain());
    }
}

fn build(mut commands: Commands, mut world: ResMut<SheetWorld>, mut paints: ResMut<Assets<StandardMaterial>>) {
    let mut paint = |colour: Color| {
        paints.add(StandardMaterial { base_color: colour, double_sided: true, cull_mode: None, ..default() })
    };
    let backs = [paint(Color::srgb(0.93, 0.90, 0.82)), paint(Color::srgb(0.62, 0.14, 0.16))];
    let scene = Scene::parse(HOUSE).expect("a shipped scene");
    world.restart(&scene).expect("a shipped scene");
    for (k, spec) in scene.sheets.into_iter().enumerate() {
        let card = Card(spec.placement.position.y as f32);
        let back = MeshMaterial3d(backs[k % 2].clone());
        commands.spawn((Sheet::from(spec), SheetContacts::above(0.05), card, back));
    }
    for k in 0..LYING {
        let angle = 0.25 * k as f32;
        let place = Vec3::new(0.3 * angle.cos(), 0.0008 + 0.0007 * k as f32, -0.3 * angle.sin() - 0.05);
        let turned = Transform::from_translation(place).with_rotation(Quat::from_rotation_y(angle));
        let card = Sheet::new("playing-card").grid(5, 3).size(0.088, 0.063);
        commands.spawn((card, Card(place.y), MeshMaterial3d(backs[k as usize % 2].clone()), turned));
    }
}

fn restart(
    mut asked: MessageReader<Restart>,
    mut commands: Commands,
    (world, paints): (ResMut<SheetWorld>, ResMut<Assets<StandardMaterial>>),
    mut round: ResMut<Round>,
    old: Query<Entity, Or<(With<Card>, With<Ball>)>>,
) {
    if asked.read().count() > 0 {
        old.iter().for_each(|entity| commands.entity(entity).despawn());
        *round = Round::default();
        build(commands, world, paints);
    }
}

fn throw(mut thrown: MessageReader<Throw>, mut commands: Commands, mut round: ResMut<Round>) {
    for Throw(place, velocity) in thrown.read() {
        if round.thrown < BALLS {
            round.thrown += 1;
            let ball = SheetBody::ball(0.02).density(650.0).velocity(velocity.as_dvec3());
            commands.spawn((ball, Ball, Transform::from_translation(*place)));
        }
    }
}

fn score(mut round: ResMut<Round>, world: Res<SheetWorld>, cards: Query<(&Card, &SheetState)>) {
    if world.steps() == 0 {
        return;
    }
    let fallen = cards.iter().filter(|(card, state)| state.centre.y < card.0 - FALL).count();
    if fallen != round.fallen {
        round.fallen = fallen;
        info!("{fallen} cards down with {} of {BALLS} balls", round.thrown);
    }
    round.is_over = round.thrown == BALLS && cards.iter().all(|(_, state)| state.asleep);
}
