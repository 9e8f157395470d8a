//! Small picture by the graphics driver, where there is one.

use std::path::Path;

use sheetwork_editor::panels::{Display, EditorState};
use sheetwork_editor::picture::Picture;
use sheetwork_editor::session::Session;
use sheetwork_editor::shell::{offscreen, probe};

fn share(picture: &Picture, like: impl Fn([u8; 3]) -> bool) -> f64 {
    let all = picture.width * picture.height;
    let hits = (0..all).filter(|i| like(picture.at(i % picture.width, i / picture.width))).count();
    hits as f64 / f64::from(all)
}

#[test]
fn the_driver_draws_the_sheet_the_body_and_the_panels() {
    if let Err(reason) = probe::adapter() {
        println!("skipped: {reason}");
        return;
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/wedge.ron");
    let mut session = Session::open(&file).expect("the test's scene is valid");
    session.run(0.05);
    let picture = offscreen::draw(session, (320, 200), Display::default()).expect("a picture");
    assert_eq!((picture.width, picture.height, picture.pixels.len()), (320, 200, 320 * 200 * 3));
    let red = share(&picture, |[r, _, b]| i32::from(r) - i32::from(b) > 70);
    assert!((0.02..0.6).contains(&red), "the sheet covers {red}");
    let session = Session::open(&file).expect("valid");
    let state = EditorState::new(&session);
    let panels = offscreen::draw_panels(session, state, (640, 400)).expect("a picture");
    let dark = share(&panels, |[r, g, b]| r < 60 && g < 60 && b < 60);
    assert!((0.4..0.95).contains(&dark), "the panels cover {dark}");
    let blue = share(&picture, |[r, _, b]| i32::from(b) - i32::from(r) > 12);
    assert!(blue > 0.01, "the wedge covers {blue}");
}
