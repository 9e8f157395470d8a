//! Rules of the example `game`, without a window.
#![cfg(feature = "render")]

mod common;
#[path = "../examples/game/rules.rs"]
mod rules;

use bevy::prelude::*;
use bevy_sheetwork::prelude::*;
use common::{app_with, run};
use rules::{Restart, Round, RulesPlugin, Throw};

#[test]
fn cards_fall_when_they_are_hit_and_the_house_is_built_again() {
    let mut app = app_with(SheetworkPlugins.build().add(RulesPlugin));
    app.world_mut().spawn(SheetBody::floor());
    run(&mut app, 0.5);
    assert_eq!(app.world().resource::<Round>().fallen, 0);
    app.world_mut().write_message(Throw(Vec3::new(-0.85, 0.06, 0.004), Vec3::new(3.0, 1.6, 0.0)));
    run(&mut app, 1.0);
    let (fallen, thrown) = (app.world().resource::<Round>().fallen, app.world().resource::<Round>().thrown);
    assert!(fallen >= 5 && thrown == 1, "{fallen} cards fell of {thrown} throws");
    app.world_mut().write_message(Restart);
    run(&mut app, 0.5);
    assert_eq!(app.world().resource::<Round>().fallen, 0);
    assert_eq!(app.world().resource::<SheetWorld>().sheets().len(), 24);
}
