//! The member that is picked: its clips, layers and targets, and what can be done with it.

use egui::{CollapsingHeader, ComboBox, RichText, Ui};
use populace::model::{Role, Side};
use populace::{
    ActiveClip, CharacterId, ClipId, ClipPlayback, Crowd, LayerMode, LayerSettings, MAX_LAYERS,
    MemberId,
};

use super::targets;
use crate::desk::{Command, Desk, Edits, LayerEdit};
use crate::stage::Stage;
use crate::theme::{ACCENT, QUIET};

/// Time in which a clip fades in, in seconds.
const FADE_SECS: f32 = 0.3;
/// Masks that a layer can have, by the role of the highest joint.
const MASKS: [(&str, Option<Role>); 5] = [
    ("all joints", None),
    ("upper body", Some(Role::Spine)),
    ("right arm", Some(Role::UpperArm(Side::Right))),
    ("left arm", Some(Role::UpperArm(Side::Left))),
    ("head", Some(Role::Head)),
];

pub(super) fn show(ui: &mut Ui, stage: &mut Stage, desk: &mut Desk) {
    let Some(member) = desk.picked else {
        ui.label(RichText::new("Click somebody in the picture.").color(QUIET));
        return;
    };
    let Ok(view) = stage.crowd.member(member) else {
        desk.picked = None;
        return;
    };
    let character = view.character();
    let level = view.instance().level;
    facts(ui, stage, member, level);
    buttons(ui, stage, desk, member);
    let mut edits = desk.edits.remove(&member).unwrap_or_default();
    let mut changed = false;
    section(ui, desk, "Clips", true, |ui, desk| {
        changed |= clips(ui, stage, desk, (member, character), &mut edits);
    });
    section(ui, desk, "Gaze", true, |ui, desk| {
        changed |= targets::gaze(ui, &stage.crowd, desk, member, &mut edits.aims);
    });
    section(ui, desk, "Reach", true, |ui, desk| {
        changed |= targets::hands(ui, &stage.crowd, desk, member, &mut edits.aims);
    });
    section(ui, desk, "Layers", false, |ui, desk| {
        changed |= layers(ui, stage, desk, (member, character), &mut edits);
    });
    desk.edits.insert(member, edits);
    if changed {
        desk.wish(Command::Refresh);
    }
}

fn section(
    ui: &mut Ui,
    desk: &mut Desk,
    name: &str,
    is_open: bool,
    content: impl FnOnce(&mut Ui, &mut Desk),
) {
    let shown = CollapsingHeader::new(RichText::new(name).color(QUIET)).default_open(is_open);
    let shown = shown.show_unindented(ui, |ui| content(ui, desk));
    desk.widgets.note(name, shown.header_response);
}

fn facts(ui: &mut Ui, stage: &mut Stage, member: MemberId, level: u32) {
    let name = |stage: &Stage| {
        let character = stage.crowd.member(member).ok()?.character();
        Some(stage.crowd.character(character).ok()?.asset().name.clone())
    };
    let name = name(stage).unwrap_or_default();
    let number = stage.show.person(member).map(|number| format!(" {number}")).unwrap_or_default();
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("{name}{number}")).color(ACCENT));
        if stage.you() == Some(member) {
            ui.label("this is you");
        }
    });
    if let Some(followed) = stage.followed(member) {
        let [x, _, z] = followed.feet.to_array();
        let does = stage.falls.describe(member);
        let text = format!("at {x:.1}, {z:.1} m, level of detail {level}, {does}");
        ui.label(RichText::new(text).color(QUIET).small());
    }
}

fn buttons(ui: &mut Ui, stage: &Stage, desk: &mut Desk, member: MemberId) {
    ui.horizontal_wrapped(|ui| {
        if desk.button(ui, "Look at") {
            desk.wish(Command::Frame(member));
        }
        if desk.button(ui, "Go along") {
            desk.wish(Command::Follow(member));
        }
        let drives = stage.you() == Some(member);
        if desk.button(ui, if drives { "Leave" } else { "Be this person" }) {
            desk.wish(Command::Drive(member));
        }
        if desk.button(ui, "Ragdoll") {
            desk.wish(Command::Fall(member));
        }
        let is_down = stage.falls.is_down(member);
        let response = ui.add_enabled(is_down, egui::Button::new("Get up"));
        if desk.widgets.note("Get up", response).clicked() {
            desk.wish(Command::GetUp(member));
        }
    });
}

/// Shows the slots with clips, and adds others. Returns true if something was changed.
fn clips(
    ui: &mut Ui,
    stage: &mut Stage,
    desk: &mut Desk,
    (member, character): (MemberId, CharacterId),
    edits: &mut Edits,
) -> bool {
    let crowd = &mut stage.crowd;
    let Ok(clips) = crowd.character(character).map(|character| character.clips()) else {
        return false;
    };
    let active = crowd.member(member).map(|view| view.active_clips()).unwrap_or_default();
    let mut changed = false;
    if active.is_empty() {
        ui.label(RichText::new("plays nothing").color(QUIET));
    }
    for (nth, playing) in active.iter().enumerate() {
        let known = clips.iter().find(|(id, _)| *id == playing.clip);
        let (name, length_secs) =
            known.map_or(("?", 0.0), |(_, clip)| (clip.name(), clip.duration_secs()));
        changed |= slot(ui, crowd, desk, (member, nth), playing, (name, length_secs));
    }
    ui.horizontal(|ui| {
        edits.clip = edits.clip.min(clips.len().saturating_sub(1));
        let name = |nth: usize| clips.get(nth).map_or("", |(_, clip)| clip.name()).to_owned();
        let combo = ComboBox::from_id_salt("next clip").width(118.0);
        combo.selected_text(name(edits.clip)).show_ui(ui, |ui| {
            for nth in 0..clips.len() {
                ui.selectable_value(&mut edits.clip, nth, name(nth));
            }
        });
        let layer = format!("layer {}", edits.layer);
        ComboBox::from_id_salt("next layer").width(64.0).selected_text(layer).show_ui(ui, |ui| {
            for nth in 0..MAX_LAYERS {
                ui.selectable_value(&mut edits.layer, nth, format!("layer {nth}"));
            }
        });
    });
    let Some((clip, _)) = clips.get(edits.clip) else { return changed };
    ui.horizontal(|ui| {
        let playback = ClipPlayback::looping().on_layer(edits.layer).fade_in_secs(FADE_SECS);
        let (plays, adds) = (desk.button(ui, "Play it"), desk.button(ui, "Blend it in"));
        if plays || adds {
            let result = start(crowd, member, (*clip, playback), plays);
            if let Err(error) = result {
                desk.say(error.to_string(), ui.input(|input| input.time));
            }
            changed = true;
        }
        if desk.button(ui, "Stop") {
            let _ = crowd.member_mut(member).and_then(|mut m| m.stop(edits.layer, FADE_SECS));
            changed = true;
        }
    });
    changed
}

/// Plays a clip in place of the others of its layer, or with them.
fn start(
    crowd: &mut Crowd,
    member: MemberId,
    (clip, playback): (ClipId, ClipPlayback),
    replaces: bool,
) -> Result<(), populace::Error> {
    let mut view = crowd.member_mut(member)?;
    if replaces { view.play(clip, playback) } else { view.blend(clip, playback) }.map(|_| ())
}

/// Shows a slot: the clip, how far it is, its weight and its speed.
fn slot(
    ui: &mut Ui,
    crowd: &mut Crowd,
    desk: &mut Desk,
    (member, nth): (MemberId, usize),
    playing: &ActiveClip,
    (name, length_secs): (&str, f32),
) -> bool {
    ui.horizontal(|ui| {
        ui.label(name);
        let text =
            format!("layer {}, {:.2} of {length_secs:.2} s", playing.layer, playing.time_secs);
        ui.label(RichText::new(text).color(QUIET).small());
    });
    let Some(id) = playing.id else { return false };
    let mut weight = playing.weight;
    let mut changed = false;
    if desk.slider(ui, (&format!("weight {nth}"), "weight"), &mut weight, 0.0..=1.0) {
        // A weight of 0 would end the clip, and the slider with it.
        let weight = weight.max(0.001);
        let _ = crowd.member_mut(member).and_then(|mut m| m.set_weight(id, weight, 0.0));
        changed = true;
    }
    let mut speed = playing.speed;
    if desk.slider(ui, (&format!("speed {nth}"), "speed"), &mut speed, 0.0..=3.0) {
        let _ = crowd.member_mut(member).and_then(|mut m| m.set_speed(id, speed));
        changed = true;
    }
    changed
}

/// Shows weight, mode and mask of the layers above the lowest.
fn layers(
    ui: &mut Ui,
    stage: &mut Stage,
    desk: &mut Desk,
    (member, character): (MemberId, CharacterId),
    edits: &mut Edits,
) -> bool {
    let mut any = false;
    for nth in 0..edits.layers.len() {
        let layer = nth + 1;
        let LayerEdit { mut weight, mut additive, mut mask } = edits.layers[nth];
        let label = format!("layer {layer}");
        let mut changed = desk.slider(ui, (&label, &label), &mut weight, 0.0..=1.0);
        ui.horizontal(|ui| {
            changed |= ui.checkbox(&mut additive, "additive").changed();
            let combo = ComboBox::from_id_salt(("mask", layer)).width(104.0);
            combo.selected_text(MASKS[mask].0).show_ui(ui, |ui| {
                for (other, (name, _)) in MASKS.iter().enumerate() {
                    changed |= ui.selectable_value(&mut mask, other, *name).changed();
                }
            });
        });
        if changed {
            edits.layers[nth] = LayerEdit { weight, additive, mask };
            let mode = if additive { LayerMode::Additive } else { LayerMode::Override };
            let mask = MASKS[mask].1.and_then(|role| stage.mask(character, role));
            let settings = LayerSettings { weight, mode };
            let set =
                stage.crowd.member_mut(member).and_then(|mut m| m.set_layer(layer, settings, mask));
            if let Err(error) = set {
                desk.say(error.to_string(), ui.input(|input| input.time));
            }
            any = true;
        }
    }
    ui.label(RichText::new("Clips play on a layer by the list above.").color(QUIET).small());
    any
}
