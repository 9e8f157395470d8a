//! A study after the thesis's evaluation: the same drops with several sheets, in random order and without their names, a questionnaire after
//! each, answers as a table.
//!
//! The tests are shown one after the other in an order of chance, and in each its sheets in one: a subject compares sheets that fall on the
//! same thing. The order follows from a seed. Answers are in the file after every sheet, so that nothing is lost. What is asked, and what becomes of the
//! answers, is [`sheetwork_rigs::study`]'s.
//!
//! The sheets are those of the thesis: 11x2x11 masses of 0.04 g, 2.5 cm square, its room and gravity, springs of 405 (the second test, stiff, by rk4) and 205 mN/m
//! (the third, by euler-richardson) as its table 3.1 has them, and 305 in the first, which it only calls medium. The shell is one layer of what
//! two layers with such springs are: E t = 2 k and t = √3 h (h the distance of the layers) stretch and bend as they do.

use std::path::{Path, PathBuf};

use sheetwork::InputError;
use sheetwork::scene::Scene;
use sheetwork_rigs::study::{Answers, LAST_QUESTIONS, Overall, QUESTIONS, Rating, SHEETS, TESTS};

/// One thing that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Showing {
    /// Which test.
    pub test: &'static str,
    /// Which sheet.
    pub sheet: &'static str,
}

/// Where a session of a study stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// What it is about, and who takes part.
    Welcome,
    /// A sheet falls.
    Watching,
    /// What the subject says to it.
    Asking,
    /// What the subject says in the end.
    Last,
    /// All is in the file.
    Over,
}

/// A session of a study with one subject.
#[derive(Clone, Debug)]
pub struct Study {
    /// Who takes part; a letter or number will do.
    pub subject: String,
    /// Where the answers go.
    pub file: String,
    /// What the order follows from.
    pub seed: u64,
    stage: Stage,
    plan: Vec<Showing>,
    at: usize,
    /// Answers to what is asked now; the outer is none where nothing was chosen yet.
    pub chosen: Vec<Option<Option<u8>>>,
    answers: Answers,
    /// What was in the file before.
    before: Answers,
}

/// What is shown, in the order of `seed`.
pub fn plan(seed: u64) -> Vec<Showing> {
    let mut state = seed;
    let mut tests = TESTS;
    shuffle(&mut tests, &mut state);
    let of = |test: &'static str, state: &mut u64| {
        let mut sheets = SHEETS;
        shuffle(&mut sheets, state);
        sheets.map(|sheet| Showing { test, sheet })
    };
    tests.into_iter().flat_map(|test| of(test, &mut state)).collect()
}

/// Fisher and Yates's shuffle, by numbers of SplitMix64 (Steele, Lea and Flood 2014): the same on every machine.
fn shuffle<T>(all: &mut [T], state: &mut u64) {
    for i in (1..all.len()).rev() {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        all.swap(i, ((z ^ (z >> 31)) % (i as u64 + 1)) as usize);
    }
}

const CUBE: &str =
    r#"(name: "cube", shape: Box((0.016, 0.016, 0.016)), placement: (position: (-0.0015, -0.0201, -0.0015)))"#;
const WEDGE: &str = r#"(name: "wedge", shape: Polyhedron((
    vertices: [(-0.0165, -0.0281, 0.0145), (0.0135, -0.0281, 0.0145), (-0.0015, -0.0121, 0.0145),
        (-0.0165, -0.0281, -0.0175), (0.0135, -0.0281, -0.0175), (-0.0015, -0.0121, -0.0175)],
    faces: [[0, 1, 2], [5, 4, 3], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]])))"#;

/// Distance of the layers, m, and mass of a node, kg.
const GAP: f64 = 0.001;
const NODE: f64 = 4e-5;

/// The scene of a showing; its name says nothing of what it is.
///
/// # Errors
/// Never for what [`plan`] gives: every one is read in the tests.
pub fn scene(showing: Showing, title: &str) -> Result<Scene, InputError> {
    let (body, stiffness, engine, dt) = match showing.test {
        "cube" => (CUBE, 0.305, "rk4", 0.005),
        "wedge1" => (WEDGE, 0.405, "rk4", 0.004),
        _ => (WEDGE, 0.205, "euler-richardson", 0.0025),
    };
    let (sheet, engine, dt) = match showing.sheet {
        "shell" => {
            let thickness = 3.0_f64.sqrt() * GAP;
            let nodes = f64::from(11 * 11 + 10 * 10);
            let density = nodes * NODE / (0.025 * 0.025 * thickness);
            let young = 2.0 * stiffness / thickness;
            let material = format!("(young: {young}, thickness: {thickness}, density: {density}, poisson: 0.3)");
            (
                format!(r#"structure: "shell", grid: (11, 1, 11), material: {material}, damping_ratio: 0.1"#),
                "tr-bdf2",
                1.0 / 60.0,
            )
        }
        lattice => {
            let layers = if lattice == "provot2d" { 1 } else { 2 };
            let material = format!("(young: {}, thickness: {GAP})", stiffness / GAP);
            (
                format!(
                    r#"structure: "{lattice}", grid: (11, {layers}, 11), gap: {GAP}, material: {material}, node_mass: {NODE}"#
                ),
                engine,
                dt,
            )
        }
    };
    Scene::parse(&format!(
        r#"(name: "{title}", engine: "{engine}", dt: {dt}, gravity: (0, -0.981, 0), duration: 6,
            room: (x: (-0.065, 0.065), y: (-0.0281, 0.03), z: (-0.0299, 0.0333), grid: 0.005),
            contact: (friction: 0.3, restitution: 0.1), air: (factor: 0.97, per: 0.015),
            sheets: [({sheet}, size: (0.025, 0.025), placement: (position: (-0.0015, 0.0025, -0.0015)))],
            bodies: [{body}], camera: (eye: (0.036, 0.03, 0.066), target: (-0.0015, -0.0185, -0.002)))"#
    ))
}

impl Study {
    /// One that has not begun, in the order of `seed`.
    pub fn new(seed: u64) -> Self {
        Self {
            subject: String::new(),
            file: "study.csv".to_owned(),
            seed,
            stage: Stage::Welcome,
            plan: plan(seed),
            at: 0,
            chosen: Vec::new(),
            answers: Answers::default(),
            before: Answers::default(),
        }
    }

    /// The first sheet of the order of `seed` with its questions, for a picture; nothing is written.
    pub fn of_picture(seed: u64) -> Self {
        let mut study = Self { stage: Stage::Watching, ..Self::new(seed) };
        study.ask();
        study
    }

    /// Where it stands.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// What is shown, for those who may know.
    pub fn showing(&self) -> Option<Showing> {
        self.plan.get(self.at).copied()
    }

    /// What number of how many is shown.
    pub fn progress(&self) -> (usize, usize) {
        (self.at + 1, self.plan.len())
    }

    /// The scene that is shown now.
    ///
    /// # Errors
    /// When nothing is.
    pub fn scene(&self) -> Result<Scene, InputError> {
        let showing = self.showing().ok_or_else(|| InputError::new("study", "is over"))?;
        scene(showing, &format!("Sheet {} of {}", self.at + 1, self.plan.len()))
    }

    /// Begins, with what is in the file already.
    ///
    /// # Errors
    /// When there is no subject, the file is no table of answers, or it has answers of this subject.
    pub fn begin(&mut self) -> Result<(), InputError> {
        let subject = self.subject.trim().to_owned();
        if subject.is_empty() || subject.chars().any(char::is_control) {
            return Err(InputError::new(
                "subject",
                "is a letter, number or name, to tell the answers of several apart",
            ));
        }
        let file = Path::new(self.file.trim());
        if file.as_os_str().is_empty() {
            return Err(InputError::new("file", "is where the answers go, and is empty"));
        }
        self.before = if file.exists() { Answers::read(file)? } else { Answers::default() };
        if self.before.subjects().contains(&subject.as_str()) {
            return Err(InputError::new("subject", format!("{subject} has answered before")).in_file(file));
        }
        (self.subject, self.plan, self.at) = (subject, plan(self.seed), 0);
        self.stage = Stage::Watching;
        Ok(())
    }

    /// Asks what the subject says to what was seen.
    pub fn ask(&mut self) {
        if self.stage == Stage::Watching {
            (self.stage, self.chosen) = (Stage::Asking, vec![None; QUESTIONS.len()]);
        }
    }

    /// Whether everything that is asked was answered, if only by N/A.
    pub fn is_answered(&self) -> bool {
        !self.chosen.is_empty() && self.chosen.iter().all(Option::is_some)
    }

    /// Takes the answers and goes on. Whether another sheet is shown.
    ///
    /// # Errors
    /// When something is not answered, or the file cannot be written; it stays where it is then.
    pub fn answer(&mut self) -> Result<bool, InputError> {
        if !self.is_answered() {
            return Err(InputError::new("answers", "are not all given: N/A is one, too"));
        }
        let given = |i: usize| self.chosen.get(i).copied().flatten().flatten();
        let kept = self.answers.clone();
        match (self.stage, self.showing()) {
            (Stage::Asking, Some(showing)) => self.answers.ratings.push(Rating {
                subject: self.subject.clone(),
                order: Some(self.at as u32 + 1),
                test: showing.test.to_owned(),
                sheet: showing.sheet.to_owned(),
                answers: std::array::from_fn::<_, { QUESTIONS.len() }, _>(given),
            }),
            (Stage::Last, _) => self.answers.overall.push(Overall {
                subject: self.subject.clone(),
                answers: std::array::from_fn::<_, { LAST_QUESTIONS.len() }, _>(given),
            }),
            _ => return Ok(false),
        }
        if let Err(error) = self.write() {
            self.answers = kept;
            return Err(error);
        }
        self.chosen.clear();
        if self.stage == Stage::Last {
            self.stage = Stage::Over;
            return Ok(false);
        }
        self.at += 1;
        if self.at < self.plan.len() {
            self.stage = Stage::Watching;
            return Ok(true);
        }
        (self.stage, self.chosen) = (Stage::Last, vec![None; LAST_QUESTIONS.len()]);
        Ok(false)
    }

    /// Writes what was in the file and what was answered since, beside it first: a full disk leaves the old one.
    fn write(&self) -> Result<(), InputError> {
        let mut all = self.before.clone();
        all.join(self.answers.clone())?;
        let file = PathBuf::from(self.file.trim());
        let beside = file.with_extension("csv.part");
        let opened = std::fs::File::create(&beside).map_err(|e| InputError::io(&file, &e))?;
        all.write(opened).map_err(|e| e.in_file(&file))?;
        std::fs::rename(&beside, &file).map_err(|e| InputError::io(&file, &e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::World;

    #[test]
    fn an_order_has_everything_once_and_follows_from_its_seed() {
        for seed in 0..20 {
            let all = plan(seed);
            assert_eq!(all.len(), 15);
            for test in TESTS {
                let sheets: Vec<&str> = all.iter().filter(|s| s.test == test).map(|s| s.sheet).collect();
                assert!(SHEETS.iter().all(|s| sheets.iter().filter(|t| *t == s).count() == 1), "{seed} {test}");
            }
            assert!(all.chunks(5).all(|block| block.iter().all(|s| s.test == block[0].test)), "tests stay together");
            assert_eq!(plan(seed), all);
        }
        let orders: std::collections::BTreeSet<String> = (0..20).map(|s| format!("{:?}", plan(s))).collect();
        assert!(orders.len() > 18, "another seed, another order");
    }

    #[test]
    fn every_sheet_of_the_study_falls_and_holds() {
        for showing in plan(1) {
            let scene = scene(showing, "x").expect("valid");
            let mut world = World::new(&scene).expect("valid");
            let height = world.sheets()[0].centre_of_mass().y;
            world.advance(1.2);
            let now = world.sheets()[0].centre_of_mass().y;
            assert!(world.unstable().is_none() && now < height - 0.008, "{showing:?}: {height} {now}");
        }
    }
}
