//! Opening and saving: scenes, recordings, and files of parts of a scene.

use std::path::Path;

use glam::DVec3;
use sheetwork::InputError;
use sheetwork::scene::heater_file::read_heaters_file;
use sheetwork::scene::material::read_material_file;
use sheetwork::scene::pol::read_pol_file;
use sheetwork::scene::sht::read_sht_file;
use sheetwork::scene::{BodySpec, HeaterSpec, MaterialChoice, Placement, Scene, Shape, SheetSpec};

use super::Session;
use crate::document::files;
use crate::{pick, playback};

/// Clearance between an added object and the floor, m.
const CLEARANCE: f64 = 0.01;

/// Kind of a file, by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Scene or material, both `.ron`.
    Ron,
    /// Recording.
    Recording,
    /// Sheet.
    Sheet,
    /// Polyhedra.
    Polyhedra,
    /// Heaters.
    Heaters,
}

/// Kind of the file; `None` for one that the editor does not read.
pub fn kind_of(file: &Path) -> Option<Kind> {
    let ending = file.extension()?.to_string_lossy().to_lowercase();
    Some(match ending.as_str() {
        "ron" => Kind::Ron,
        "swr" => Kind::Recording,
        "sht" => Kind::Sheet,
        "pol" => Kind::Polyhedra,
        "heater" => Kind::Heaters,
        _ => return None,
    })
}

impl Session {
    /// Session with the scene or recording in `file`.
    ///
    /// # Errors
    /// When the file cannot be read, or the scene or recording is not valid.
    pub fn open(file: &Path) -> Result<Self, InputError> {
        if playback::is_recording(file) {
            let (scene, recording) = playback::open(file)?;
            return Ok(Self::new(&scene)?.play_back(recording).read_from(file));
        }
        Ok(Self::new(&Scene::load(file)?)?.read_from(file))
    }

    /// The session with the file of its scene, which [`Session::reload`] reads again.
    pub fn read_from(self, file: &Path) -> Self {
        Self { file: Some(file.to_path_buf()), ..self }
    }

    /// Replace the world by the scene in `file`; speed and play state are kept. When the file is
    /// invalid the old world continues and the error becomes a message. Returns whether the file
    /// was opened.
    pub fn load(&mut self, file: &Path) -> bool {
        self.accept(Self::open(file)).map(|fresh| self.replace_by(fresh)).is_some()
    }

    /// Start a scene without a file and without unsaved work. A rejection becomes a message.
    /// Returns whether the scene was accepted.
    pub fn begin_scene(&mut self, scene: &Scene) -> bool {
        let Some(fresh) = self.accept(Self::new(scene)) else { return false };
        self.pause();
        self.replace_by(fresh);
        true
    }

    /// Start a recovered scene, which is unsaved. Returns whether the scene was accepted.
    pub fn recover_scene(&mut self, scene: &Scene) -> bool {
        let begun = self.begin_scene(scene);
        if begun {
            self.document.never_saved();
        }
        begun
    }

    /// Replace this session by `fresh`, which keeps speed, messages, live link and play state.
    /// Returns the old session.
    pub fn replace_by(&mut self, fresh: Self) -> Self {
        let (playing, looped, speed) = (self.playing, self.looped, self.speed);
        let (generation, revision) = (self.generation + 1, self.revision + 1);
        // Error messages stay until dismissed, except those of the replaced run.
        let mut messages = std::mem::take(&mut self.messages);
        messages.retain(|m| m.error && !m.of_run);
        let link = std::mem::take(&mut self.link);
        let stages = self.stages.take();
        let fresh = Self { looped, speed, generation, revision, messages, link, stages, ..fresh };
        let mut old = std::mem::replace(self, fresh);
        old.watch_world();
        self.watch_world();
        if playing {
            self.play();
        }
        self.link.look_again();
        old
    }

    /// Read the scene's file again and start with its values.
    pub fn reload(&mut self) -> bool {
        match self.file.clone() {
            Some(file) => self.load(&file),
            None => {
                let opened = self.document.opened().clone();
                self.edit("back to the scene as it was opened", "reload", |scene| *scene = opened) && self.reset()
            }
        }
    }

    /// Write the scene to `file`, which becomes its file. An error becomes a message. Returns
    /// whether it was written.
    pub fn save_as(&mut self, file: &Path) -> bool {
        let file = if file.extension().is_none() { file.with_extension("ron") } else { file.to_path_buf() };
        let saved = files::save(self.scene(), &file).map_err(|error| format!("not saved: {error}"));
        let Some(scene) = self.accept(saved) else { return false };
        self.document.wrote(scene);
        self.file = Some(file);
        true
    }

    /// Add the contents of a sheet, polyhedra or heater file to the scene as one edit; a material
    /// file sets the material of sheet `sheet`. The object is placed as its file has it, or where
    /// there is room: on the floor, above bodies, beside sheets. An error becomes a message.
    /// Returns whether the file was added.
    pub fn add_file(&mut self, file: &Path, sheet: usize) -> bool {
        let path = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        let name = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let label = format!("add {}", file.file_name().unwrap_or_default().to_string_lossy());
        let placement = self.place_for(file);
        match kind_of(file) {
            Some(Kind::Sheet) => self.edit(&label, &label, |scene| {
                scene.sheets.push(SheetSpec { name, file: Some(path), placement, ..SheetSpec::thesis() });
            }),
            Some(Kind::Polyhedra) => self.edit(&label, &label, |scene| {
                scene.bodies.push(BodySpec { name, placement, ..BodySpec::new(Shape::File(path)) });
            }),
            Some(Kind::Heaters) => self.edit(&label, &label, |scene| {
                scene.heaters.push(HeaterSpec { name, file: Some(path), placement, ..HeaterSpec::default() });
            }),
            Some(Kind::Ron) => {
                let is_material = self.accept(read_material_file(file)).is_some();
                is_material && self.take_material(sheet, MaterialChoice::File(path))
            }
            Some(Kind::Recording) => self.load(file),
            None => {
                self.fail(format!(
                    "{}: not a scene or material (.ron), recording (.swr), sheet (.sht), polyhedra (.pol) or heater (.heater) file",
                    file.display()
                ));
                false
            }
        }
    }

    /// Placement of the contents of `file`, whose coordinates belong to another room: above this
    /// room's floor; a sheet above the bodies that it intersects, then beside the sheets; other
    /// objects beside those that they intersect.
    fn place_for(&self, file: &Path) -> Placement {
        let mut position = DVec3::ZERO;
        // The edit reports an unreadable file.
        if let Some((low, high)) = bounds(file).unwrap_or_default() {
            let is_sheet = kind_of(file) == Some(Kind::Sheet);
            if let Some(room) = self.scene().room.as_ref().filter(|room| low.y < room.y.0) {
                position.y = room.y.0 - low.y + if is_sheet { CLEARANCE } else { 0.0 };
            }
            let meets = |position: DVec3, (l, h): (DVec3, DVec3)| {
                (low + position).cmple(h).all() && (high + position).cmpge(l).all()
            };
            let (mut above, mut beside) = (pick::body_boxes(&self.world), Vec::new());
            if !is_sheet {
                beside.append(&mut above);
            }
            above.sort_by(|a, b| a.1.y.total_cmp(&b.1.y));
            for one in above {
                if meets(position, one) {
                    position.y = one.1.y - low.y + CLEARANCE;
                }
            }
            beside.extend(self.world().sheets().iter().filter_map(|s| s.state.x.bounds()));
            beside.sort_by(|a, b| a.1.x.total_cmp(&b.1.x));
            for one in beside {
                if meets(position, one) {
                    position.x = one.1.x - low.x + CLEARANCE;
                }
            }
        }
        Placement { position, ..Placement::default() }
    }
}

/// Bounding box of the contents of a sheet, polyhedra or heater file, m; `None` for other files.
fn bounds(file: &Path) -> Result<Option<(DVec3, DVec3)>, InputError> {
    let points: Vec<DVec3> = match kind_of(file) {
        Some(Kind::Sheet) => read_sht_file(file)?.masses.iter().map(|m| m.position).collect(),
        Some(Kind::Polyhedra) => read_pol_file(file)?.into_iter().flat_map(|p| p.vertices).collect(),
        Some(Kind::Heaters) => read_heaters_file(file)?.into_iter().flat_map(|h| h.polyhedron.vertices).collect(),
        _ => Vec::new(),
    };
    Ok(pick::box_of(points.into_iter()))
}
