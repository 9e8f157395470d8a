//! Keys outside text fields, and files dropped on the window.

use bevy_egui::egui::{Event, Id, Key, Modifiers, Ui};

use super::dialog::Purpose;
use super::{EditorState, Tool};
use crate::camera::Camera;
use crate::session::Session;

/// Keys of the snapshots 1 to 9.
const DIGITS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// Execute the commands of keys, and open dropped files.
pub(super) fn keys_and_drops(ui: &Ui, session: &mut Session, state: &mut EditorState) {
    let dropped: Vec<_> = ui.input(|i| i.raw.dropped_files.iter().filter_map(|f| f.path.clone()).collect());
    for file in dropped {
        state.open(session, &file);
    }
    if ui.input(|i| i.key_pressed(Key::F1)) {
        state.help = !state.help;
    }
    // When typing ends within one frame, its letters are still pending after the field has lost the
    // focus.
    let (id, typing) = (Id::new("typing"), ui.ctx().text_edit_focused());
    let typed = ui.data_mut(|d| std::mem::replace(d.get_temp_mut_or_default::<bool>(id), typing));
    if typing || typed {
        return;
    }
    commands(ui, session, state);
    time(ui, session);
    tools(ui, session, state);
}

/// Whether `key` was pressed without Ctrl or Alt, and if so whether with Shift, by the modifiers of
/// the key event.
fn plain(ui: &Ui, wanted: Key) -> Option<bool> {
    presses(ui, wanted).first().copied()
}

/// All presses of a key in this frame, each with its Shift state.
fn presses(ui: &Ui, wanted: Key) -> Vec<bool> {
    let of = |event: &Event| match event {
        Event::Key { key, pressed: true, modifiers, .. } if *key == wanted => {
            (!modifiers.command && !modifiers.ctrl && !modifiers.alt).then_some(modifiers.shift)
        }
        _ => None,
    };
    ui.input(|i| i.events.iter().filter_map(of).collect())
}

/// Keys with Ctrl.
fn commands(ui: &Ui, session: &mut Session, state: &mut EditorState) {
    let with = |modifiers: Modifiers, key| ui.input_mut(|i| i.consume_key(modifiers, key));
    // The combination with Shift first: the other would match it too.
    if with(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) || with(Modifiers::COMMAND, Key::Y) {
        session.redo();
    }
    // A slow frame may hold several presses.
    for _ in 0..ui.input_mut(|i| i.count_and_consume_key(Modifiers::COMMAND, Key::Z)) {
        session.undo();
    }
    if with(Modifiers::COMMAND | Modifiers::SHIFT, Key::S) {
        state.browse(session, Purpose::Save);
    }
    if with(Modifiers::COMMAND, Key::S) {
        state.save(session);
    }
    if with(Modifiers::COMMAND, Key::O) {
        state.browse(session, Purpose::Open);
    }
    for (i, key) in DIGITS.into_iter().enumerate() {
        if with(Modifiers::COMMAND, key) {
            session.store_snapshot(i + 1);
        }
    }
}

fn time(ui: &Ui, session: &mut Session) {
    let pressed = |key| plain(ui, key).is_some();
    // A button with the focus takes the space bar itself.
    let free = ui.memory(|m| m.focused().is_none());
    if let Some(shift) = plain(ui, Key::Space).filter(|_| free) {
        if shift { _ = session.stop() } else { session.toggle() }
    }
    if free {
        presses(ui, Key::ArrowRight).iter().for_each(|_| session.step());
        presses(ui, Key::ArrowLeft).iter().for_each(|_| _ = session.step_back());
    }
    if pressed(Key::Backspace) {
        session.reset();
    }
    if pressed(Key::Plus) || pressed(Key::Equals) {
        session.faster();
    }
    if pressed(Key::Minus) {
        session.slower();
    }
    for (i, key) in DIGITS.into_iter().enumerate() {
        if pressed(key) {
            session.restore_snapshot(i + 1);
        }
    }
}

fn tools(ui: &Ui, session: &mut Session, state: &mut EditorState) {
    let pressed = |key| plain(ui, key).is_some();
    if pressed(Key::F) {
        state.camera = Camera::from_session(session);
    }
    let keys = [Key::Q, Key::G, Key::P, Key::W, Key::C, Key::H, Key::X];
    for (key, (tool, ..)) in keys.into_iter().zip(Tool::ALL) {
        if pressed(key) {
            state.tool = tool;
        }
    }
    if pressed(Key::Escape) {
        state.help = false;
        state.selected = None;
    }
}
