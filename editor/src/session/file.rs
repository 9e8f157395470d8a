//! Opening and saving: scenes, recordings, and the parts of a scene that have files of their own.

use std::path::Path;

use glam::DVec3;
use sheetwork::InputError;
use sheetwork::scene::heater::read_heaters_file;
use sheetwork::scene::material::read_material_file;
use sheetwork::scene::pol::read_pol_file;
use sheetwork::scene::sht::read_sht_file;
use sheetwork::scene::{BodySpec, HeaterSpec, MaterialChoice, Placement, Scene, Shape, SheetSpec};

use super::Session;
use crate::document::files;
use crate::{pick, playback};

/// Between what is put on the floor and what is there, m.
const OVER: f64 = 0.01;

/// What a file is, by the end of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A scene, or a material: both are `.ron`.
    Ron,
    /// A recording.
    Recording,
    /// A sheet.
    Sheet,
    /// Polyhedra.
    Polyhedra,
    /// Heaters.
    Heaters,
}

/// What the file is; none for one that nothing here reads.
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
    /// A session with the scene in `file`, or with the recording there.
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

    /// The session, remembering the file its scene came from: [`Session::reload`] reads it again.
    pub fn read_from(self, file: &Path) -> Self {
        Self { file: Some(file.to_path_buf()), ..self }
    }

    /// Replaces the world by the scene in `file`; keeps speed and whether it plays. When the file is refused the old
    /// world goes on and the refusal becomes a message. Returns whether it was opened.
    pub fn load(&mut self, file: &Path) -> bool {
        match Self::open(file) {
            Ok(fresh) => {
                self.make_way_for(fresh);
                true
            }
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// Begins a scene that no file has, and in which there is no work yet. A refusal becomes a message. Returns whether it was taken.
    pub fn begin_scene(&mut self, scene: &Scene) -> bool {
        match Self::new(scene) {
            Ok(mut fresh) => {
                fresh.playing = false;
                self.pause();
                self.make_way_for(fresh);
                true
            }
            Err(error) => {
                self.fail(error.to_string());
                false
            }
        }
    }

    /// The same with work that was left behind: it is not saved until it is in a file.
    pub fn recover_scene(&mut self, scene: &Scene) -> bool {
        let begun = self.begin_scene(scene);
        if begun {
            self.document.never_saved();
        }
        begun
    }

    /// Makes room for `fresh`, which takes over speed, messages, the live link and whether it plays; what was here is given back as it was.
    pub fn make_way_for(&mut self, fresh: Self) -> Self {
        let (playing, looped, speed) = (self.playing, self.looped, self.speed);
        let (generation, revision) = (self.generation + 1, self.revision + 1);
        // What went wrong stays until it is read, unless it was the run that is no more.
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

    /// Reads the scene's file again and starts it with the file's own values.
    pub fn reload(&mut self) -> bool {
        match self.file.clone() {
            Some(file) => self.load(&file),
            None => {
                let opened = self.document.opened().clone();
                self.edit("back to the scene as it was opened", "reload", |scene| *scene = opened) && self.reset()
            }
        }
    }

    /// Writes the scene to `file`, which is its own from then on. A refusal becomes a message. Returns whether it was written.
    pub fn save_as(&mut self, file: &Path) -> bool {
        let file = if file.extension().is_none() { file.with_extension("ron") } else { file.to_path_buf() };
        match files::save(self.scene(), &file) {
            Ok(scene) => {
                self.document.wrote(scene);
                self.file = Some(file);
                true
            }
            Err(error) => {
                self.fail(format!("not saved: {error}"));
                false
            }
        }
    }

    /// Writes the scene to its own file. Returns false where it has none, or could not be written.
    pub fn save(&mut self) -> bool {
        match self.file.clone().filter(|f| kind_of(f) == Some(Kind::Ron)) {
            Some(file) => self.save_as(&file),
            None => false,
        }
    }

    /// Adds what is in a sheet, polyhedra or heater file to the scene, as one edit; a material file is given to sheet `sheet`. It is put where
    /// its file has it, or where there is room: on the floor, above bodies, beside the sheets. Returns whether it was taken; a refusal becomes a message.
    pub fn add_file(&mut self, file: &Path, sheet: usize) -> bool {
        let path = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        let name = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let label = format!("add {}", file.file_name().unwrap_or_default().to_string_lossy());
        let placement = self.place_for(file);
        match kind_of(file) {
            Some(Kind::Sheet) => self.edit(&label, &label, |scene| {
                scene.sheets.push(SheetSpec { name, file: Some(path), placement, ..SheetSpec::default() });
            }),
            Some(Kind::Polyhedra) => self.edit(&label, &label, |scene| {
                scene.bodies.push(BodySpec { name, placement, ..BodySpec::new(Shape::File(path)) });
            }),
            Some(Kind::Heaters) => self.edit(&label, &label, |scene| {
                scene.heaters.push(HeaterSpec { name, file: Some(path), placement, ..HeaterSpec::default() });
            }),
            Some(Kind::Ron) => match read_material_file(file) {
                Ok(_) => self.take_material(sheet, MaterialChoice::File(path)),
                Err(error) => {
                    self.fail(error.to_string());
                    false
                }
            },
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

    /// Where to put what is in `file`, whose coordinates are those of another room: higher than this one's floor, a sheet above the bodies that it
    /// would be in, and then beside the sheets; anything else beside what it would be in.
    fn place_for(&self, file: &Path) -> Placement {
        let mut position = DVec3::ZERO;
        // A file that cannot be read is refused by the edit, with its reason.
        if let Some((low, high)) = bounds(file).unwrap_or_default() {
            let is_sheet = kind_of(file) == Some(Kind::Sheet);
            if let Some(room) = self.scene().room.as_ref().filter(|room| low.y < room.y.0) {
                position.y = room.y.0 - low.y + if is_sheet { OVER } else { 0.0 };
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
                    position.y = one.1.y - low.y + OVER;
                }
            }
            beside.extend(self.world().sheets().iter().filter_map(|s| s.x.bounds()));
            beside.sort_by(|a, b| a.1.x.total_cmp(&b.1.x));
            for one in beside {
                if meets(position, one) {
                    position.x = one.1.x - low.x + OVER;
                }
            }
        }
        Placement { position, ..Placement::default() }
    }
}

/// Corners of the box around what is in a file of a sheet, polyhedra or heaters, m; none of any other.
fn bounds(file: &Path) -> Result<Option<(DVec3, DVec3)>, InputError> {
    let points: Vec<DVec3> = match kind_of(file) {
        Some(Kind::Sheet) => read_sht_file(file)?.masses.iter().map(|m| m.position).collect(),
        Some(Kind::Polyhedra) => read_pol_file(file)?.into_iter().flat_map(|p| p.vertices).collect(),
        Some(Kind::Heaters) => read_heaters_file(file)?.into_iter().flat_map(|h| h.polyhedron.vertices).collect(),
        _ => Vec::new(),
    };
    Ok(pick::box_of(points.into_iter()))
}
