//! Cost of the panels: CPU time of a frame with every panel open, including layout and
//! tessellation, without a window.
//!
//! `cargo run --release -p sheetwork-editor --example panel_time [scene]`

use bevy_egui::egui::{self, Pos2, Rect, UiBuilder, Vec2};
use cpu_time::ThreadTime;
use sheetwork_editor::panels::{self, EditorState, Section};
use sheetwork_editor::scenes;
use sheetwork_editor::session::Session;

/// Measured frames.
const FRAMES: usize = 400;

fn main() {
    let name = std::env::args().nth(1).unwrap_or_else(|| "heat_modes".to_owned());
    let mut session = match Session::open(&scenes::find(name.as_ref())) {
        Ok(session) => session,
        Err(error) => return eprintln!("error: {error}"),
    };
    session.run(2.0);
    let mut state = EditorState::new(&session);
    state.open_sections = Section::ALL.iter().map(|s| s.0).collect();
    state.plots.shown = true;
    let context = egui::Context::default();
    panels::apply_style(&context);
    let mut times = Vec::with_capacity(FRAMES);
    let (mut shapes, mut triangles) = (0, 0);
    for frame in 0..FRAMES + 20 {
        let start = ThreadTime::now();
        let input = egui::RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, Vec2::new(1480.0, 2600.0))),
            time: Some(frame as f64 / 60.0),
            ..Default::default()
        };
        let output = context.run_ui(input, |ui| {
            let everything = UiBuilder::new().layer_id(egui::LayerId::background()).max_rect(ui.max_rect());
            let mut ui = ui.new_child(everything);
            panels::show(&mut ui, &mut session, &mut state);
        });
        shapes = output.shapes.len();
        let made = context.tessellate(output.shapes, output.pixels_per_point);
        triangles = made
            .iter()
            .map(|p| match &p.primitive {
                egui::epaint::Primitive::Mesh(mesh) => mesh.indices.len() / 3,
                egui::epaint::Primitive::Callback(_) => 0,
            })
            .sum();
        if frame >= 20 {
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    times.sort_by(f64::total_cmp);
    let at = |part: f64| times[(part * (times.len() - 1) as f64) as usize];
    println!("{name}: {shapes} shapes, {triangles} triangles, all panels open");
    println!("median {:.2} ms, 95 % {:.2} ms, most {:.2} ms", at(0.5), at(0.95), at(1.0));
}
