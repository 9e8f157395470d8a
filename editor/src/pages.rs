//! Pictures of `docs/editor.md`, with each panel and dialog in at least one, and of the README:
//! their contents, and the command that writes them.

use std::path::Path;

use bevy_sheetwork::SheetColour;
use sheetwork::InputError;
use sheetwork::scene::{Scene, SpotSpec};

use crate::camera::Camera;
use crate::export::{Job, Kind};
use crate::panels::{Draft, EditorState, Plots, Purpose, Section, Tool, blind};
use crate::session::{Item, Session, Variant};
use crate::shell::offscreen::Offscreen;
use crate::shell::probe;
use crate::study::Study;
use crate::{scenes, templates};

/// Picture: file, size in pixels, scene, and its preparation.
pub struct Page {
    /// Name of the file.
    pub file: &'static str,
    size: (u32, u32),
    scene: fn() -> Result<Scene, InputError>,
    prepare: fn(&mut Session, &mut EditorState),
    /// Whether it includes the panels.
    panels: bool,
}

impl Page {
    const fn new(
        file: &'static str,
        scene: fn() -> Result<Scene, InputError>,
        prepare: fn(&mut Session, &mut EditorState),
    ) -> Self {
        Self { file, size: (1400, 860), scene, prepare, panels: true }
    }
}

/// All pictures.
pub const ALL: &[Page] = &[
    Page::new("editor.png", || shipped("heat_modes"), heat),
    Page::new("editor_new.png", || template("Sheet on a box"), material),
    Page::new("editor_compare.png", || shipped("box_drop"), compare),
    Page::new("editor_hands.png", || shipped("cantilever_sheet"), hands),
    Page::new("editor_gun.png", || shipped("heat_gun"), gun),
    Page::new("editor_stages.png", || shipped("box_on_sheet"), stages),
    Page { size: (1100, 760), ..Page::new("editor_study.png", || Study::for_picture(1).scene(), study) },
    Page::new("editor_light.png", || shipped("materials_hanging"), light),
    Page::new("editor_sheet.png", || shipped("pvc_drape"), display),
    Page::new("editor_generate.png", || shipped("hemisphere"), generate),
    Page::new("editor_files.png", || shipped("creased_sheet"), files),
    Page::new("editor_export.png", || shipped("box_drop"), export),
    Page { size: (1400, 1040), ..Page::new("editor_help.png", || shipped("ball_on_sheet"), help) },
    Page {
        size: (1280, 800),
        panels: false,
        ..Page::new("materials.png", || shipped("materials_hanging"), |session, _| session.run(2.0))
    },
];

fn shipped(name: &str) -> Result<Scene, InputError> {
    Ok(Scene::load(&scenes::find(Path::new(name)))?)
}

fn template(name: &str) -> Result<Scene, InputError> {
    let found = templates::TABLE.iter().find(|t| t.name == name);
    found.map(templates::Template::scene).ok_or_else(|| InputError::new("template", format!("there is no \"{name}\"")))
}

impl Page {
    /// Session and panels of the picture.
    ///
    /// # Errors
    /// When its scene is not found.
    pub fn open(&self) -> Result<(Session, EditorState), InputError> {
        let scene = (self.scene)()?;
        let mut session = Session::new(&scene)?;
        if let Some(file) = &scene.file {
            session = session.read_from(file);
        }
        let mut state = EditorState::new(&session);
        (self.prepare)(&mut session, &mut state);
        Ok((session, state))
    }
}

/// Write all pictures to `folder`, or those whose names contain `only`.
///
/// # Errors
/// When there is no graphics driver, a scene is missing or a file cannot be written.
pub fn take(folder: &Path, only: Option<&str>) -> Result<(), InputError> {
    let adapter = probe::adapter().map_err(|reason| InputError::new("--pictures", reason))?;
    eprintln!("Drawing with {}.", adapter.name);
    std::fs::create_dir_all(folder).map_err(|e| InputError::io(folder, &e))?;
    let chosen: Vec<_> = ALL.iter().filter(|page| only.is_none_or(|only| page.file.contains(only))).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = ALL.iter().map(|page| page.file).collect();
        return Err(InputError::new("--only", format!("is in the name of no picture; there are {}", names.join(", "))));
    }
    for page in chosen {
        let (session, state) = page.open()?;
        for message in session.messages() {
            eprintln!("{}: {}", page.file, message.text);
        }
        let file = folder.join(page.file);
        let made = if page.panels { Offscreen::editor } else { Offscreen::scene };
        let picture = made(session, state, page.size).warm_picture();
        let picture = picture.map_err(|problem| InputError::new("", problem).in_file(&file))?;
        picture.save(&file).map_err(|e| InputError::io(&file, &e))?;
        eprintln!("{}", file.display());
    }
    Ok(())
}

/// A heater over a sheet on a wedge, with temperatures and plots.
fn heat(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Heat].into();
    state.plots.shown = true;
    session.run(3.0);
    (state.tool, state.selected) = (Tool::Move, session.items().into_iter().find(|i| matches!(i, Item::Heater(_))));
    state.camera.zoom(-1.0);
}

/// A new scene while it runs, with its material.
fn material(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Material, Section::Bodies].into();
    session.choose_material(0, "card");
    session.set("sheets.0.material.thickness", "3e-4");
    session.run(0.75);
    state.camera.zoom(1.5);
    session.set_speed(0.25);
    session.play();
}

/// Four materials side by side.
fn compare(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Compare, Section::Engine].into();
    let material = |name: &str| Variant { path: "sheets.0.material".into(), value: name.into() };
    session.compare_with(["rubber", "paper", "pet"].map(material).to_vec());
    session.run(0.6);
    state.plots = Plots { shown: true, step: false, temperature: false, ..Plots::default() };
    state.camera = Camera { yaw: 0.5, pitch: 0.3, ..state.camera };
    state.camera.zoom(1.0);
}

/// Painted heat on a sheet with a cut.
fn hands(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Sheet].into();
    // A fine grid, for a thin cut and a round patch.
    session.edit("grid", "grid", |scene| scene.sheets[0].grid = (51, 1, 51));
    session.cut(0, ((0.55, 0.2), (0.85, 0.2)));
    session.run(0.4);
    if session.begin_stroke(0) {
        for i in 0..12 {
            let s = f64::from(i) / 11.0;
            session.dab(SpotSpec { at: (0.25 + 0.25 * s, 0.75 - 0.45 * s), radius: 0.02, temperature: 150.0 });
        }
        session.end_stroke();
    }
    session.run(0.3);
    state.tool = Tool::Heat;
    state.camera.zoom(0.5);
}

/// A heat gun over a strip that softens.
fn gun(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Heat, Section::Camera].into();
    session.run(2.4);
    (state.tool, state.selected) = (Tool::Move, Some(Item::HeatGun));
    state.camera.target.y += 0.05;
    state.camera.zoom(-3.0);
}

/// A box on a sheet, and the profile of its steps.
fn stages(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Engine, Section::Bodies].into();
    state.plots = Plots { shown: true, stages: true, temperature: false, ..Plots::default() };
    state.display.colour = Some(SheetColour::Contact);
    state.display.contacts = true;
    session.time_stages(true);
    session.run(0.8);
    state.camera.zoom(1.5);
}

/// The questions after a blind trial.
fn study(session: &mut Session, state: &mut EditorState) {
    session.run(1.0);
    state.study = Some(Study::for_picture(1));
    state.display = blind();
}

/// Strips of five materials, light theme.
fn light(session: &mut Session, state: &mut EditorState) {
    (state.light, state.sheet) = (true, 1);
    state.open_sections = [Section::Material, Section::Display].into();
    session.run(2.0);
    state.camera.zoom(0.5);
}

/// A film on a ball coloured by strain, with the display section.
fn display(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Display, Section::Camera].into();
    session.run(19.0);
    state.display.colour = Some(SheetColour::Bending);
    // The heater appears beside the tools instead of behind them.
    state.camera.target.y += 0.012;
    state.camera.zoom(-1.0);
}

/// Generation of a sheet.
fn generate(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Sheet].into();
    session.run(1.2);
    state.generate = Some(Draft::from_sheet(session, 0));
    // Beside the dialog.
    state.camera.target.y += 0.006;
}

/// Choice of a file, and the live link.
fn files(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Link, Section::Sheet].into();
    session.run(1.0);
    state.browse(session, Purpose::Open);
    state.tool = Tool::Crease;
    // Below the dialog.
    state.camera.target.y += 0.1;
    state.camera.zoom(-0.5);
}

/// Setup of an export.
fn export(session: &mut Session, state: &mut EditorState) {
    state.open_sections = [Section::Bodies].into();
    session.run(0.6);
    // Below the dialog.
    state.camera.target.y += 0.2 * state.camera.distance * (0.5 * state.camera.field_of_view).tan();
    state.export = Some(Job::new(Kind::Gltf, Path::new("box_drop.glb"), 4.0));
}

/// Mouse and keys.
fn help(session: &mut Session, state: &mut EditorState) {
    session.run(0.3);
    state.help = true;
    // Above the window.
    state.camera.zoom(-2.5);
    state.camera.target.y -= 0.4 * state.camera.distance * (0.5 * state.camera.field_of_view).tan();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_docs_use_every_written_picture_and_no_other() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        if !root.join("docs").is_dir() {
            return; // A packed crate has no docs beside it.
        }
        let read = |file: &str| std::fs::read_to_string(root.join(file)).expect("the docs");
        let (editor, readme) = (read("docs/editor.md"), read("README.md"));
        for page in ALL {
            assert!(editor.contains(page.file) || readme.contains(page.file), "{} is nowhere", page.file);
            (page.scene)().expect(page.file);
        }
        let named = editor.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for file in named.filter(|file| file.ends_with(".png")) {
            assert!(ALL.iter().any(|page| page.file == file), "{file} is not taken by the command");
            assert!(root.join("docs").join(file).exists(), "{file} is missing");
        }
    }
}
