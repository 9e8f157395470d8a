//! Execution of the command line.

use std::process::ExitCode;

use sheetwork::InputError;
use sheetwork::scene::Scene;

use super::Arguments;
use crate::camera::Camera;
use crate::export::{Job, Kind, MAX_PICTURES, moments};
use crate::session::Session;
use crate::study::Study;
use crate::{headless, pages, playback, shell};

impl Arguments {
    /// Execute the command line.
    pub fn run(&self) -> ExitCode {
        match self.try_run() {
            Ok(code) => code,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::from(2)
            }
        }
    }

    /// Scene in `file`, or scene of the recording in `file`.
    fn described(&self, file: &std::path::Path) -> Result<Scene, InputError> {
        if !playback::is_recording(file) {
            return Ok(Scene::load(file)?);
        }
        if !self.set.is_empty() {
            return Err(InputError::new("--set", "changes nothing in a recording").in_file(file));
        }
        playback::open(file).map(|(scene, _)| scene)
    }

    fn try_run(&self) -> Result<ExitCode, InputError> {
        let times = self.at.iter().map(|t| ("--at", t)).chain(self.seconds.iter().map(|t| ("--seconds", t)));
        for (flag, seconds) in times {
            sheetwork::check_range(flag, *seconds, 0.0, 1e6, "s")?;
        }
        if let Some(folder) = &self.pictures {
            return pages::take(folder, self.only.as_deref()).map(|()| ExitCode::SUCCESS);
        }
        let file = self.scene_file();
        let mut scene = self.described(&file)?;
        for assignment in &self.set {
            scene = assigned("--set", &scene, assignment)?;
        }
        if let Some(order) = self.study.filter(|_| self.screenshot.is_some()) {
            scene = Study::for_picture(order).scene()?;
        }
        if let Some(picture) = &self.screenshot {
            let mut scenes = vec![scene.clone()];
            for assignment in &self.beside {
                scenes.push(assigned("--beside", &scene, assignment)?);
            }
            return shell::offscreen::screenshot(self, &scenes, &file, picture);
        }
        if self.sequence.is_some() || self.gltf.is_some() {
            return self.export(&scene, &file);
        }
        if !self.compare.is_empty() && !playback::is_recording(&file) {
            // An invalid variant is reported here, not as a failure to open the window.
            self.compare(&mut Session::new(&scene)?)?;
        }
        let without_window = || {
            if playback::is_recording(&file) {
                let problem = "is a recording: without a window --screenshot with --at draws a moment of it";
                return Err(InputError::new("", problem).in_file(&file));
            }
            headless::run(&scene, self.seconds, self.size)
        };
        if self.headless {
            return without_window();
        }
        if let Err(reason) = shell::probe::window_possible() {
            eprintln!("No window: {reason}.");
            eprintln!("Running \"{}\" headless instead.", scene.name);
            return without_window();
        }
        match shell::window::run(self, &scene, &file) {
            Ok(code) => Ok(code),
            Err(reason) => {
                eprintln!("The window could not be opened: {reason}.");
                eprintln!("Running \"{}\" headless instead.", scene.name);
                without_window()
            }
        }
    }

    /// Write the run as pictures, as glTF, or both.
    fn export(&self, scene: &Scene, file: &std::path::Path) -> Result<ExitCode, InputError> {
        let seconds = self.seconds.unwrap_or(scene.duration);
        let session = || {
            let recorded = playback::is_recording(file);
            let mut session = if recorded { Session::open(file)? } else { Session::new(scene)? };
            self.compare(&mut session)?;
            Ok::<_, InputError>(session)
        };
        let mut stable = true;
        if let Some(target) = &self.gltf {
            let session = session()?;
            let mut job = Job::new(Kind::Gltf, target, seconds);
            job.rate = self.rate;
            job.begin(&session, &Camera::from_session(&session))?;
            while !job.step()? {}
            stable &= job.world().is_none_or(|world| world.unstable().is_none());
            eprintln!("written: {}", target.display());
        }
        if let Some(folder) = &self.sequence {
            let count = moments(self.rate, seconds, MAX_PICTURES)?;
            stable &= shell::offscreen::sequence(self, session()?, folder, count)?;
        }
        Ok(if stable { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

/// The scene with the field of `PATH=VALUE` overridden.
fn assigned(flag: &str, scene: &Scene, assignment: &str) -> Result<Scene, InputError> {
    let wrong = || InputError::new(flag, format!("\"{assignment}\" is not PATH=VALUE"));
    let (path, value) = assignment.split_once('=').ok_or_else(wrong)?;
    Ok(scene.with_override(path.trim(), value)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_numbers_and_scenes_are_refused() {
        let refused = |a: Arguments| a.try_run().expect_err("refused").to_string();
        let nan = Arguments { headless: true, seconds: Some(f64::NAN), ..Arguments::default() };
        assert!(refused(nan).contains("--seconds"));
        let wedge = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scenes/wedge.ron");
        let set = |s: &str| Arguments { scene: Some(wedge.into()), set: vec![s.into()], ..Arguments::default() };
        assert!(refused(set("gravity")).contains("PATH=VALUE"));
        let beside = Arguments { screenshot: Some("a.png".into()), beside: vec!["dt".into()], ..set("dt=0.01") };
        assert!(refused(beside).contains("--beside"));
        assert!(refused(set("sheets.0.damping=-1")).contains("0 to 10"));
        let missing = Arguments { scene: Some("no-such-scene".into()), ..Arguments::default() };
        assert!(refused(missing).contains("no-such-scene"));
    }
}
