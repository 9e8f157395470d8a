//! A study: trials are anonymous, answers are in the file after every sheet, and the scene comes
//! back.

use bevy_egui::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use sheetwork_editor::study::{Stage, Study};
use sheetwork_rigs::bench::thesis::REFERENCES;
use sheetwork_rigs::study::{Answers, QUESTIONS, SHEETS};

use super::common::{folder, strip, whole};

#[test]
fn a_subject_sees_sheets_blind_and_answers() {
    let folder = folder("study");
    let file = folder.join("answers.csv");
    let mut session = strip();
    session.run(0.25);
    assert!(session.set("gravity", "(0, -5, 0)"));
    let (steps, tip) = (session.world().steps(), session.world().sheets()[0].state.x.clone());
    let mut harness = whole(session);
    let mut study = Study::new(5);
    (study.file, study.subject) = (file.display().to_string(), "a".to_owned());
    let first = study.trial().expect("something");
    harness.state_mut().1.study = Some(study);
    harness.run_steps(2);
    harness.get_by_label("Begin").click();
    harness.run_steps(3);
    let scene = harness.state().0.scene().clone();
    assert_eq!((scene.name.as_str(), harness.state().0.playing()), ("Sheet 1 of 15", true));
    assert_eq!(scene.sheets[0].structure.name(), first.sheet);
    for telling in [first.sheet, "Material", "nodes", "springs"] {
        assert!(harness.query_by_label_contains(telling).is_none(), "{telling} says what it is");
    }
    assert_eq!(harness.query_all_by_label_contains("Sheet ").count(), 1, "only its number");
    let (_, _, caption) = REFERENCES.into_iter().find(|(test, ..)| *test == first.test).expect("of each test");
    assert!(harness.query_by_label(caption).is_some(), "the real drop is beside it");
    assert!(!harness.state().1.display.bodies && !harness.state().1.display.springs);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.key_press(Key::G);
    harness.run_steps(2);
    assert!(harness.state().1.dialog.is_none(), "keys do nothing now");
    harness.get_by_label("Rate it").click();
    harness.run_steps(2);
    assert!(!harness.state().0.playing());
    let answer = |harness: &mut egui_kittest::Harness<'_, _>, all: usize| {
        for question in &QUESTIONS[..all] {
            let given = if question.key == "A5" { "N/A" } else { "6" };
            harness.get_by_label(&format!("{} {given}", question.key)).click();
            harness.run_steps(2);
        }
        harness.get_by_label("Next").click();
        harness.run_steps(3);
    };
    answer(&mut harness, 8);
    assert_eq!(harness.state().0.scene().name, "Sheet 2 of 15");
    let read = Answers::read(&file).expect("written at once");
    assert_eq!((read.ratings.len(), read.ratings[0].sheet.as_str(), read.ratings[0].order), (1, first.sheet, Some(1)));
    assert_eq!(read.ratings[0].answers, [Some(6), Some(6), Some(6), Some(6), None, Some(6), Some(6), Some(6)]);
    harness.get_by_label("Stop the study").click();
    harness.run_steps(3);
    assert!(harness.state().1.study.is_none() && harness.state().1.display.bodies);
    let session = &mut harness.state_mut().0;
    assert_eq!(session.scene().name, "strip", "what was open is back");
    assert_eq!((session.world().steps(), &session.world().sheets()[0].state.x), (steps, &tip), "where it was");
    assert!(session.undo() && session.scene().gravity.y < -9.0, "and can be undone");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_whole_session_has_everything_once_and_a_subject_answers_once() {
    let folder = folder("study-whole");
    let file = folder.join("answers.csv").display().to_string();
    let begun = |subject: &str| {
        let mut study = Study::new(3);
        (study.file, study.subject) = (file.clone(), subject.to_owned());
        study.begin().map(|()| study)
    };
    for (subject, rate) in [("a", 7), ("b", 3)] {
        let mut study = begun(subject).expect("new");
        for _ in 0..15 {
            study.ask();
            assert!(study.answer().is_err(), "not all is answered");
            study.chosen.iter_mut().for_each(|c| *c = Some(Some(rate)));
            study.answer().expect("written");
        }
        assert_eq!(study.stage(), Stage::Last);
        study.chosen.iter_mut().for_each(|c| *c = Some(None));
        study.answer().expect("written");
        assert_eq!(study.stage(), Stage::Over);
    }
    let all = Answers::read(std::path::Path::new(&file)).expect("valid");
    assert_eq!((all.ratings.len(), all.overall.len(), all.subjects()), (30, 2, vec!["a", "b"]));
    let found = all.findings("provot2d");
    assert_eq!((found.tests.len(), found.tests[0].questions[0].sheets.len()), (3, SHEETS.len()));
    let one = found.tests[0].questions[0].sheets[0].summary.expect("some");
    assert_eq!((one.n, one.mean, one.deviation), (2, 5.0, 2.0));
    assert!(begun("a").expect_err("twice").to_string().contains("answered before"));
    assert!(begun(" ").is_err());
    std::fs::write(&file, "not a table\n").expect("written");
    assert!(begun("c").is_err(), "a file of something else is left alone");
    std::fs::remove_dir_all(&folder).expect("removed");
}
