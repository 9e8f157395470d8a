//! Key events for the panels, each with the modifiers at the time of the event.
//!
//! bevy_egui gives all keys of a frame the modifiers at its end. After a quick Ctrl+Z, or in a slow
//! frame, the panels would see a plain Z. This system processes the messages of a frame in order.

use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy_egui::helpers::{bevy_to_egui_key, bevy_to_egui_physical_key};
use bevy_egui::input::{EguiInputEvent, ModifierKeysState};
use bevy_egui::{EguiGlobalSettings, EguiInputSet, PrimaryEguiContext, egui};

/// Replace the keyboard system of bevy_egui by [`write`].
pub(super) fn add(app: &mut App) {
    let mut settings = app.world_mut().resource_mut::<EguiGlobalSettings>();
    settings.input_system_settings.run_write_keyboard_input_messages_system = false;
    app.add_systems(PreUpdate, write.in_set(EguiInputSet::ReadBevyMessages));
}

/// Pass keys and text to the panels, in order.
fn write(
    mut keys: MessageReader<KeyboardInput>,
    mut lost: MessageReader<KeyboardFocusLost>,
    mut down: Local<ModifierKeysState>,
    contexts: Query<Entity, With<PrimaryEguiContext>>,
    mut events: MessageWriter<EguiInputEvent>,
) {
    if lost.read().count() > 0 {
        // Keys down when the window loses the focus are released elsewhere.
        *down = ModifierKeysState::default();
    }
    for key in keys.read() {
        let told = told(key, &mut down);
        for context in &contexts {
            events.write_batch(told.iter().cloned().map(|event| EguiInputEvent { context, event }));
        }
    }
}

/// Events for egui of a key message; updates the modifiers.
fn told(key: &KeyboardInput, down: &mut ModifierKeysState) -> Vec<egui::Event> {
    let pressed = key.state == ButtonState::Pressed;
    match key.logical_key {
        Key::Shift => down.shift = pressed,
        Key::Control => down.ctrl = pressed,
        Key::Alt => down.alt = pressed,
        Key::Super | Key::Meta => down.win = pressed,
        _ => {}
    }
    let mut all = Vec::new();
    if pressed && down.text_input_is_allowed() {
        match &key.logical_key {
            Key::Character(text) if !text.contains(char::is_control) => all.push(egui::Event::Text(text.to_string())),
            Key::Space => all.push(egui::Event::Text(" ".to_owned())),
            _ => {}
        }
    }
    let physical_key = bevy_to_egui_physical_key(&key.key_code);
    // Layouts without Latin letters have only the physical key.
    if let Some(logical) = bevy_to_egui_key(&key.logical_key).or(physical_key) {
        let modifiers = down.to_egui_modifiers();
        all.push(egui::Event::Key { key: logical, physical_key, pressed, repeat: key.repeat, modifiers });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(logical_key: Key, key_code: KeyCode, pressed: bool) -> KeyboardInput {
        let state = if pressed { ButtonState::Pressed } else { ButtonState::Released };
        KeyboardInput { key_code, logical_key, state, text: None, repeat: false, window: Entity::PLACEHOLDER }
    }

    #[test]
    fn a_chord_within_one_frame_keeps_its_modifiers() {
        let mut app = App::new();
        app.add_message::<KeyboardInput>().add_message::<KeyboardFocusLost>().add_message::<EguiInputEvent>();
        app.add_systems(Update, write);
        app.world_mut().spawn(PrimaryEguiContext);
        let (control, z) = (|p| key(Key::Control, KeyCode::ControlLeft, p), Key::Character("z".into()));
        let chord = [
            control(true),
            key(z.clone(), KeyCode::KeyZ, true),
            key(z.clone(), KeyCode::KeyZ, false),
            control(false),
            key(z, KeyCode::KeyZ, true),
        ];
        chord.into_iter().for_each(|k| _ = app.world_mut().write_message(k));
        app.update();
        let told = app.world().resource::<Messages<EguiInputEvent>>();
        let events: Vec<egui::Event> = told.iter_current_update_messages().map(|e| e.event.clone()).collect();
        let pressed = events.iter().filter_map(|e| match e {
            egui::Event::Key { key: egui::Key::Z, pressed: true, modifiers, .. } => Some(modifiers.command),
            _ => None,
        });
        assert_eq!(pressed.collect::<Vec<_>>(), [true, false], "with Ctrl, and then without");
        let text = events.iter().filter(|e| matches!(e, egui::Event::Text(_))).count();
        assert_eq!(text, 1, "only the plain one is a letter");
    }
}
