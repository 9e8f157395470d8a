//! File menu and file dialog.

use std::path::{Path, PathBuf};

use bevy_egui::egui::{self, Button, Key, ScrollArea, Ui, Window};

use super::dialog::{Dialog, Purpose};
use super::{EditorState, Section, Tool};
use crate::browser::Browser;
use crate::camera::Camera;
use crate::export::{Job, Kind, picture_file};
use crate::picture::{Look, Picture};
use crate::session::{Item, Session};
use crate::{scenes, templates};

impl EditorState {
    /// Open the dialog for `purpose`.
    pub fn browse(&mut self, session: &Session, purpose: Purpose) {
        let own = session.file().and_then(Path::parent).map(Path::to_path_buf);
        let last = self.folder.clone();
        // A scene with a file is saved beside it; other purposes start in the folder of the last
        // such file.
        let beside = match purpose {
            Purpose::Open => last.or(own),
            Purpose::Save => own.or(last),
            _ => self.out.clone().or(own).or(last),
        };
        let folder = beside.filter(|p| p.is_dir()).or_else(scenes::folder).unwrap_or_else(|| PathBuf::from("."));
        let (_, endings) = purpose.row();
        let mut browser = Browser::new(&folder, endings);
        let stem = session.file().and_then(Path::file_stem).map(|s| s.to_string_lossy().into_owned());
        let stem = stem.unwrap_or_else(|| session.scene().name.replace([' ', '/'], "_"));
        let own = session.file().and_then(Path::file_name).filter(|_| purpose == Purpose::Save);
        browser.name = match own {
            Some(name) => name.to_string_lossy().into(),
            None if purpose == Purpose::Open => String::new(),
            None => format!("{stem}.{}", endings[0]),
        };
        self.dialog = Some(Dialog { purpose, browser, over: None, shown: false });
    }

    /// Save the scene in its file, or open the dialog where it has none.
    pub fn save(&mut self, session: &mut Session) {
        let own = session.file().map(Path::to_path_buf).filter(|f| scenes::is_scene(f));
        match own {
            Some(file) => _ = self.save_as(session, &file),
            None => self.browse(session, Purpose::Save),
        }
    }

    /// Save the scene in `file` and add it to the recent files.
    pub fn save_as(&mut self, session: &mut Session, file: &Path) -> bool {
        let saved = session.save_as(file);
        if saved {
            let file = session.file().unwrap_or(file).to_path_buf();
            self.persistence.note(&file);
            self.persistence.back_up(session);
            session.note(format!("saved: {}", file.display()));
        }
        saved
    }

    /// Start the scene of a template.
    pub fn begin(&mut self, session: &mut Session, scene: &sheetwork::scene::Scene) {
        self.make_room(session, |session| session.begin_scene(scene));
    }

    /// Start a recovered scene.
    pub fn recover(&mut self, session: &mut Session, scene: &sheetwork::scene::Scene) {
        self.make_room(session, |session| session.recover_scene(scene));
    }

    /// Write unsaved work aside, start another scene by `begin`, and look at it. Returns whether it
    /// was started.
    fn make_room(&mut self, session: &mut Session, begin: impl FnOnce(&mut Session) -> bool) -> bool {
        let aside = self.persistence.write_aside(session);
        let begun = begin(session);
        if begun {
            tell_of(session, aside.as_deref());
            self.look_at(session);
        }
        begun
    }
}

/// The file menu.
pub(super) fn menu(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    ui.menu_button("New", |ui| {
        for template in templates::TABLE {
            if ui.button(template.name).on_hover_text(template.about).clicked() {
                state.begin(session, &template.scene());
                ui.close();
            }
        }
    });
    if ui.add(Button::new("Open…").shortcut_text("Ctrl+O")).clicked() {
        state.browse(session, Purpose::Open);
        ui.close();
    }
    let mut chosen = None;
    ui.menu_button("Scenes", |ui| chosen = shipped(ui, state));
    ui.menu_button("Recent", |ui| {
        for file in state.persistence.recent() {
            if ui.button(scenes::title(file)).on_hover_text(file.display().to_string()).clicked() {
                chosen = Some(file.clone());
            }
        }
        if state.persistence.recent().is_empty() {
            ui.weak("nothing yet");
        }
    });
    recover(ui, session, state);
    ui.separator();
    let own = session.playback().is_none();
    if ui.add_enabled(own, Button::new("Save").shortcut_text("Ctrl+S")).clicked() {
        state.save(session);
        ui.close();
    }
    if ui.add_enabled(own, Button::new("Save as…").shortcut_text("Ctrl+Shift+S")).clicked() {
        state.browse(session, Purpose::Save);
        ui.close();
    }
    exports(ui, session, state);
    if ui.button("Reload from its file").on_hover_text("Restart with the values of the file").clicked() {
        session.reload();
        ui.close();
    }
    ui.separator();
    if let Some(file) = path_field(ui, state) {
        chosen = Some(file);
    }
    ui.weak("or drop a file on the window")
        .on_hover_text("A scene, recording, material, sheet, polyhedra or heater file");
    ui.separator();
    if ui.button("Study…").on_hover_text("Blind trials of sheets with a questionnaire; answers as CSV").clicked() {
        super::study::open(state);
        ui.close();
    }
    if ui.button("Quit").clicked() {
        state.quit = true;
    }
    if let Some(file) = chosen {
        state.open(session, &file);
        ui.close();
    }
}

/// Exports.
fn exports(ui: &mut Ui, session: &Session, state: &mut EditorState) {
    let gltf = "A run from the present state on: deforming sheets and moving bodies, for other programs";
    let exports = [
        ("Export pictures…", "A run from the present state on, as a sequence of PNG files", Purpose::Sequence),
        ("Export glTF…", gltf, Purpose::Gltf),
        ("Export samples…", "Energies, step time, heights and temperatures as CSV", Purpose::Csv),
        ("Export picture…", "The present view as PNG, without panels", Purpose::Picture),
    ];
    for (title, about, purpose) in exports {
        if ui.button(title).on_hover_text(about).clicked() {
            state.browse(session, purpose);
            ui.close();
        }
    }
}

/// Recovery of unsaved work found at the start.
fn recover(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    if let Some((copy, scene)) = state.left.clone() {
        let about = "Unsaved work of the last run of the editor";
        if ui.button(format!("Recover \"{}\"", scene.name)).on_hover_text(about).clicked() {
            state.recover(session, &scene);
            state.persistence.forget(&copy);
            state.left = None;
            ui.close();
        }
    }
}

/// Shipped scenes.
fn shipped(ui: &mut Ui, state: &EditorState) -> Option<PathBuf> {
    let mut chosen = None;
    ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
        ui.set_min_width(190.0);
        for file in &state.scenes {
            if ui.button(scenes::title(file)).on_hover_text(file.display().to_string()).clicked() {
                chosen = Some(file.clone());
            }
        }
        if state.scenes.is_empty() {
            ui.weak("No folder assets/scenes was found.");
        }
    });
    chosen
}

/// Text field for a file name.
fn path_field(ui: &mut Ui, state: &mut EditorState) -> Option<PathBuf> {
    let mut chosen = None;
    ui.horizontal(|ui| {
        let label = ui.label("File");
        let field = egui::TextEdit::singleline(&mut state.path).desired_width(220.0).hint_text("path/to/scene.ron");
        let entered = ui.add(field).labelled_by(label.id).lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        let given = !state.path.trim().is_empty();
        if ui.add_enabled(given, Button::new("Open")).clicked() || (entered && given) {
            chosen = Some(scenes::find(Path::new(state.path.trim())));
        }
    });
    chosen
}

/// The dialog, while a file is being chosen.
pub fn dialog(ui: &mut Ui, session: &mut Session, state: &mut EditorState) {
    let Some(mut dialog) = state.dialog.take() else { return };
    let (title, _) = dialog.purpose.row();
    let (mut open, mut chosen) = (true, None);
    let window =
        Window::new(title).open(&mut open).collapsible(false).default_pos([300.0, 120.0]).default_size([460.0, 420.0]);
    window.show(ui.ctx(), |ui| {
        ui.horizontal(|ui| {
            if ui.button("⬆").on_hover_text("The folder above").clicked() {
                dialog.browser.up();
            }
            let folder = dialog.browser.folder();
            // Relative to the working directory, where possible.
            let here = std::env::current_dir().ok();
            let short = here.as_ref().and_then(|here| folder.strip_prefix(here).ok()).unwrap_or(folder);
            ui.label(short.display().to_string()).on_hover_text(folder.display().to_string());
        });
        entries(ui, &mut dialog, &mut chosen);
        ui.horizontal(|ui| {
            let label = ui.label("Name");
            let field = egui::TextEdit::singleline(&mut dialog.browser.name).desired_width(280.0);
            let response = ui.add(field).labelled_by(label.id);
            if !std::mem::replace(&mut dialog.shown, true) {
                response.request_focus();
                select_stem(ui, response.id, &dialog.browser.name);
            }
            let entered = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            let over = dialog.over.is_some();
            let word = match dialog.purpose {
                Purpose::Open => "Open it",
                _ if over => "Write over it",
                _ => "Save it",
            };
            if ui.button(word).clicked() || entered {
                chosen = chosen.take().or_else(|| dialog.browser.chosen());
            }
            if response.changed() {
                dialog.over = None;
            }
        });
        if let Some(file) = &dialog.over {
            ui.colored_label(ui.visuals().warn_fg_color, format!("{} exists already.", file.display()));
        }
    });
    match chosen {
        Some(file) => take(session, state, dialog, file),
        None if open && !ui.input(|i| i.key_pressed(Key::Escape)) => state.dialog = Some(dialog),
        None => {}
    }
}

/// Select the name without its extension, for replacement by typing.
fn select_stem(ui: &Ui, field: egui::Id, name: &str) {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let mut text = egui::text_edit::TextEditState::load(ui.ctx(), field).unwrap_or_default();
    let (from, to) = (egui::text::CCursor::new(0), egui::text::CCursor::new(stem.chars().count()));
    text.cursor.set_char_range(Some(egui::text::CCursorRange::two(from, to)));
    text.store(ui.ctx(), field);
}

/// Folders and files; a double click chooses a file.
fn entries(ui: &mut Ui, dialog: &mut Dialog, chosen: &mut Option<PathBuf>) {
    let mut into = None;
    ScrollArea::vertical().max_height(300.0).auto_shrink(false).show(ui, |ui| {
        let title = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for folder in dialog.browser.folders() {
            if ui.selectable_label(false, format!("🗀 {}", title(folder))).clicked() {
                into = Some(folder.clone());
            }
        }
        let mut clicked = None;
        for file in dialog.browser.files() {
            let response = ui.selectable_label(dialog.browser.name == title(file), title(file));
            if response.clicked() {
                clicked = Some(title(file));
            }
            if response.double_clicked() {
                *chosen = Some(file.clone());
            }
        }
        if let Some(name) = clicked {
            dialog.browser.name = name;
            dialog.over = None;
        }
    });
    if let Some(folder) = into {
        dialog.browser.go(&folder);
    }
}

fn take(session: &mut Session, state: &mut EditorState, mut dialog: Dialog, file: PathBuf) {
    let folder = file.parent().map(Path::to_path_buf);
    match dialog.purpose {
        Purpose::Open | Purpose::Save => state.folder = folder,
        _ => state.out = folder,
    }
    let ending = dialog.purpose.row().1[0];
    let file = match dialog.purpose {
        Purpose::Save | Purpose::Csv | Purpose::Picture if file.extension().is_none() => file.with_extension(ending),
        Purpose::Gltf if file.extension().is_none_or(|e| e != ending) => file.with_extension(ending),
        _ => file,
    };
    let own = session.file() == Some(file.as_path());
    let first = if dialog.purpose == Purpose::Sequence { picture_file(&file, 0) } else { file.clone() };
    if dialog.purpose != Purpose::Open && first.exists() && !own && dialog.over.as_ref() != Some(&file) {
        dialog.over = Some(file);
        state.dialog = Some(dialog);
        return;
    }
    match dialog.purpose {
        // After a failure the user can choose another file.
        Purpose::Open if !state.open(session, &file) => state.dialog = Some(dialog),
        Purpose::Save if !state.save_as(session, &file) => state.dialog = Some(dialog),
        Purpose::Open | Purpose::Save => {}
        Purpose::Csv | Purpose::Picture => {
            let written = match dialog.purpose {
                Purpose::Csv => std::fs::write(&file, session.csv()),
                _ => picture(session, state).save(&file),
            };
            match written {
                Ok(()) => session.note(format!("written: {}", file.display())),
                Err(error) => session.fail(format!("{}: {error}", file.display())),
            }
        }
        Purpose::Sequence => {
            let (look, size) = look(state);
            state.export = Some(Job::new(Kind::Sequence(look, size), &file, session.scene().duration));
        }
        Purpose::Gltf => state.export = Some(Job::new(Kind::Gltf, &file, session.scene().duration)),
    }
}

/// The present view at twice the size, by the software rasteriser.
fn picture(session: &Session, state: &EditorState) -> Picture {
    let (look, size) = look(state);
    Picture::draw(session.world(), &state.camera, &look, (2 * size.0, 2 * size.1))
}

/// Display settings of the scene, and size of the view, pixels.
fn look(state: &EditorState) -> (Look, (u32, u32)) {
    // Even sizes, as required by video encoders.
    let even = |length: f32| (length.max(8.0) as u32) & !1;
    (state.display.look(), (even(state.viewport.width()), even(state.viewport.height())))
}

impl EditorState {
    /// Open a file: a scene or recording replaces the present one, other files are added to it. An
    /// error becomes a message. Returns whether the file was accepted.
    pub fn open(&mut self, session: &mut Session, file: &Path) -> bool {
        let is_scene = scenes::is_scene(file) || crate::playback::is_recording(file);
        if is_scene && !is_material(file) {
            let loaded = self.make_room(session, |session| session.load(file));
            if loaded {
                self.persistence.note(file);
            }
            return loaded;
        }
        let before = Self::parts(session);
        let added = session.add_file(file, self.sheet);
        if added {
            self.turn_to_what_is_new(session, before, file);
        }
        added
    }

    /// Select the object that was added to the scene, show its controls, and choose the move tool.
    fn turn_to_what_is_new(&mut self, session: &mut Session, before: (usize, usize, usize), file: &Path) {
        let after = Self::parts(session);
        let item = if after.0 > before.0 {
            Item::Sheet(before.0)
        } else if after.1 > before.1 {
            Item::Body(before.1)
        } else if after.2 > before.2 {
            Item::Heater(before.2)
        } else {
            // A material.
            self.open_sections = [Section::Material].into();
            let name = session.world().sheets().get(self.sheet).map_or(String::new(), |s| s.name.clone());
            session.note(format!(
                "the material of {name} is now {}",
                file.file_name().unwrap_or_default().to_string_lossy()
            ));
            return;
        };
        if before == (0, 0, 0) {
            self.camera = Camera::from_session(session);
        }
        self.turn_to(session, item);
    }

    /// Select a new object, choose the move tool, and bring the object into view.
    pub(super) fn turn_to(&mut self, session: &Session, item: Item) {
        self.choose(Some(item));
        self.tool = Tool::Move;
        if let Some(place) = session.handle_of(item) {
            let size = glam::Vec2::new(self.viewport.width(), self.viewport.height());
            self.camera.hold(place.as_vec3(), size);
        }
    }

    /// Numbers of sheets, bodies and heaters of the scene.
    fn parts(session: &Session) -> (usize, usize, usize) {
        let scene = session.scene();
        (scene.sheets.len(), scene.bodies.len(), scene.heaters.len())
    }

    fn look_at(&mut self, session: &Session) {
        self.display = self.display.for_session(session);
        self.camera = Camera::from_session(session);
        self.sheet = 0;
        self.selected = None;
    }
}

/// Report the file of unsaved work that another scene replaced.
fn tell_of(session: &mut Session, aside: Option<&Path>) {
    if let Some(file) = aside {
        session.note(format!("unsaved work was written to: File, Recent, {}", scenes::title(file)));
    }
}

/// Whether a `.ron` file is a material and not a scene.
fn is_material(file: &Path) -> bool {
    scenes::is_scene(file)
        && sheetwork::scene::Scene::load(file).is_err()
        && sheetwork::scene::material::read_material_file(file).is_ok()
}
