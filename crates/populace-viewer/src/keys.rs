//! Keys: those that are held, and what each does when it is pressed.

use std::collections::HashSet;

use egui::{Event, Key, Modifiers};

use crate::you::Steering;

/// Keys that this window takes before its panels do, unless somebody types.
const TAKEN: [Key; 24] = [
    Key::Space,
    Key::Comma,
    Key::Period,
    Key::Home,
    Key::OpenBracket,
    Key::CloseBracket,
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::F,
    Key::Y,
    Key::R,
    Key::G,
    Key::K,
    Key::B,
    Key::L,
    Key::T,
    Key::V,
    Key::Tab,
    Key::Questionmark,
    Key::F1,
    Key::Escape,
    Key::Enter,
];
/// Keys that are pressed again and again while they are held.
const REPEATED: [Key; 4] = [Key::Comma, Key::Period, Key::OpenBracket, Key::CloseBracket];
/// Speed of flying in m/s, and its factor with Shift.
const FLIGHT: f32 = 4.0;
const FAST: f32 = 4.0;

/// Keys that are held.
#[derive(Default)]
pub(crate) struct Held {
    keys: HashSet<Key>,
    modifiers: Modifiers,
}

impl Held {
    /// Notes keys that go down and up. Takes those that this window knows out of `events`, and
    /// returns them in their order. Those that somebody types into a field stay.
    pub(crate) fn take(
        &mut self,
        events: &mut Vec<Event>,
        modifiers: Modifiers,
        is_typing: bool,
    ) -> Vec<Key> {
        self.modifiers = modifiers;
        let mut pressed = Vec::new();
        events.retain(|event| {
            let Event::Key { key, pressed: is_down, repeat, modifiers, .. } = event else {
                return !matches!(event, Event::Text(_)) || is_typing;
            };
            if !is_down {
                self.keys.remove(key);
                return true;
            }
            if is_typing || modifiers.ctrl || modifiers.command {
                return true;
            }
            self.keys.insert(*key);
            let is_taken = TAKEN.contains(key);
            if is_taken && (!repeat || REPEATED.contains(key)) {
                pressed.push(*key);
            }
            !(is_taken
                || matches!(key, Key::ArrowUp | Key::ArrowDown | Key::ArrowLeft | Key::ArrowRight))
        });
        pressed
    }

    /// Forgets all keys, as when the window is left.
    pub(crate) fn clear(&mut self) {
        self.keys.clear();
    }

    /// Returns true while a key is held that moves something.
    pub(crate) fn moves(&self) -> bool {
        self.flight() != [0.0; 3]
            || self.steering() != Steering { runs: self.modifiers.shift, ..Steering::default() }
    }

    fn axis(&self, more: Key, less: Key) -> f32 {
        f32::from(u8::from(self.keys.contains(&more)))
            - f32::from(u8::from(self.keys.contains(&less)))
    }

    /// Returns the speed of flying to the right, upwards and forwards in m/s.
    pub(crate) fn flight(&self) -> [f32; 3] {
        let speed = if self.modifiers.shift { FAST * FLIGHT } else { FLIGHT };
        [
            speed * self.axis(Key::D, Key::A),
            speed * self.axis(Key::E, Key::Q),
            speed * self.axis(Key::W, Key::S),
        ]
    }

    /// Returns where the driven member goes.
    pub(crate) fn steering(&self) -> Steering {
        Steering {
            forward: self.axis(Key::ArrowUp, Key::ArrowDown),
            left: self.axis(Key::ArrowLeft, Key::ArrowRight),
            runs: self.modifiers.shift,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(key: Key, pressed: bool) -> Event {
        let modifiers = Modifiers::NONE;
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers }
    }

    #[test]
    fn keys_are_taken_unless_somebody_types() {
        let mut held = Held::default();
        let mut events = vec![event(Key::Space, true), event(Key::W, true), event(Key::Num7, true)];
        assert_eq!(held.take(&mut events, Modifiers::NONE, false), [Key::Space]);
        assert_eq!(events.len(), 2);
        assert_eq!(held.flight(), [0.0, 0.0, FLIGHT]);
        let mut up = vec![event(Key::W, false)];
        held.take(&mut up, Modifiers::NONE, false);
        assert!(!held.moves());
        let mut typed = vec![event(Key::Space, true)];
        assert!(held.take(&mut typed, Modifiers::NONE, true).is_empty() && typed.len() == 1);
    }

    #[test]
    fn keys_that_are_held_are_pressed_once_unless_they_step() {
        let mut held = Held::default();
        for (key, wanted) in [(Key::V, false), (Key::Space, false), (Key::Period, true)] {
            let Event::Key { physical_key, pressed, modifiers, .. } = event(key, true) else {
                panic!("a key");
            };
            let mut events =
                vec![Event::Key { key, physical_key, pressed, repeat: true, modifiers }];
            let taken = held.take(&mut events, Modifiers::NONE, false);
            assert_eq!(taken, if wanted { vec![key] } else { Vec::new() });
            assert!(events.is_empty(), "no panel takes it");
        }
    }
}
