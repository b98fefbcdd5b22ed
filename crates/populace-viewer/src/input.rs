//! Events of windows as the panels take them. Scripts make the same events.

use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Vec2};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{Key as Logical, ModifiersState, NamedKey};

/// Translates events, and knows where the pointer is.
#[derive(Default)]
pub(crate) struct Translator {
    pub(crate) modifiers: Modifiers,
    at: Pos2,
}

impl Translator {
    /// Adds what an event means. `scale` is the number of pixels of a point.
    pub(crate) fn translate(&mut self, event: &WindowEvent, scale: f64, events: &mut Vec<Event>) {
        match event {
            WindowEvent::ModifiersChanged(modifiers) => {
                self.modifiers = modifiers_of(modifiers.state());
            }
            WindowEvent::CursorMoved { position, .. } => {
                let position = position.to_logical::<f32>(scale);
                self.at = Pos2::new(position.x, position.y);
                events.push(Event::PointerMoved(self.at));
            }
            WindowEvent::CursorLeft { .. } => events.push(Event::PointerGone),
            WindowEvent::MouseInput { state, button, .. } => {
                let button = match button {
                    MouseButton::Left => PointerButton::Primary,
                    MouseButton::Right => PointerButton::Secondary,
                    MouseButton::Middle => PointerButton::Middle,
                    _ => return,
                };
                let pressed = *state == ElementState::Pressed;
                let (pos, modifiers) = (self.at, self.modifiers);
                events.push(Event::PointerButton { pos, button, pressed, modifiers });
            }
            WindowEvent::MouseWheel { delta, .. } => {
                #[expect(clippy::cast_possible_truncation, reason = "a few pixels")]
                let (unit, delta) = match delta {
                    MouseScrollDelta::LineDelta(x, y) => (MouseWheelUnit::Line, Vec2::new(*x, *y)),
                    MouseScrollDelta::PixelDelta(by) => {
                        (MouseWheelUnit::Point, Vec2::new(by.x as f32, by.y as f32) / scale as f32)
                    }
                };
                events.push(Event::MouseWheel { unit, delta, modifiers: self.modifiers });
            }
            WindowEvent::KeyboardInput { event, .. } => self.key(event, events),
            WindowEvent::Focused(focused) => events.push(Event::WindowFocused(*focused)),
            _ => {}
        }
    }

    fn key(&self, event: &KeyEvent, events: &mut Vec<Event>) {
        let pressed = event.state == ElementState::Pressed;
        let key = match &event.logical_key {
            Logical::Named(named) => named_key(*named),
            // Letters keep their keys while Shift is held.
            Logical::Character(text) => {
                Key::from_name(text).or_else(|| Key::from_name(&text.to_uppercase()))
            }
            _ => None,
        };
        if let Some(key) = key {
            let modifiers = self.modifiers;
            events.push(Event::Key {
                key,
                physical_key: None,
                pressed,
                repeat: event.repeat,
                modifiers,
            });
        }
        let text = event.text.as_ref().filter(|text| !text.chars().any(char::is_control));
        if let Some(text) = text.filter(|_| pressed && !self.modifiers.ctrl) {
            events.push(Event::Text(text.to_string()));
        }
    }
}

fn modifiers_of(state: ModifiersState) -> Modifiers {
    Modifiers {
        alt: state.alt_key(),
        ctrl: state.control_key(),
        shift: state.shift_key(),
        mac_cmd: false,
        command: state.control_key(),
    }
}

fn named_key(key: NamedKey) -> Option<Key> {
    Some(match key {
        NamedKey::ArrowDown => Key::ArrowDown,
        NamedKey::ArrowLeft => Key::ArrowLeft,
        NamedKey::ArrowRight => Key::ArrowRight,
        NamedKey::ArrowUp => Key::ArrowUp,
        NamedKey::Escape => Key::Escape,
        NamedKey::Tab => Key::Tab,
        NamedKey::Backspace => Key::Backspace,
        NamedKey::Enter => Key::Enter,
        NamedKey::Space => Key::Space,
        NamedKey::Delete => Key::Delete,
        NamedKey::Home => Key::Home,
        NamedKey::End => Key::End,
        NamedKey::F1 => Key::F1,
        _ => return None,
    })
}
