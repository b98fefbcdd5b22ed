//! What the picked member looks at and reaches for.

use egui::{RichText, Ui};
use populace::model::{Role, Side};
use populace::{Crowd, Error, JointIndex, MemberId, Reach, Target, Weight};

use crate::desk::{Aim, Desk};
use crate::theme::QUIET;

/// Hands by their names for scripts, in the order of the desk.
const HANDS: [(&str, Side, f32); 2] =
    [("left hand", Side::Left, 1.0), ("right hand", Side::Right, -1.0)];

/// Shows what a member looks at. Returns true if it was changed.
pub(super) fn gaze(
    ui: &mut Ui,
    crowd: &mut Crowd,
    desk: &mut Desk,
    member: MemberId,
    aim: &mut Option<Aim>,
) -> bool {
    let height_m = height_m(crowd, member);
    let usual = Aim { point: [0.0, 0.9 * height_m, 2.0 * height_m], weight: 0.0 };
    let mut edited = aim.unwrap_or(usual);
    if !sliders(ui, desk, "gaze", &mut edited, height_m) {
        return false;
    }
    *aim = Some(edited);
    let result = crowd.member_mut(member).and_then(|mut m| {
        if edited.weight > 0.0 {
            m.look_at(Target::InModel(edited.point), Weight::new(edited.weight)?.over_secs(0.0))
        } else {
            m.clear_look_at(0.0)
        }
    });
    say(ui, desk, result)
}

/// Shows what the hands of a member reach for. Returns true if it was changed.
pub(super) fn hands(
    ui: &mut Ui,
    crowd: &mut Crowd,
    desk: &mut Desk,
    member: MemberId,
    aims: &mut [Option<Aim>; 2],
) -> bool {
    let height_m = height_m(crowd, member);
    let mut changed = false;
    for (aim, (name, side, sign)) in aims.iter_mut().zip(HANDS) {
        let hand = crowd.member(member).ok().and_then(|m| m.joint(Role::Hand(side)));
        let Some(hand) = hand else {
            ui.label(RichText::new(format!("no {name} is known")).color(QUIET));
            continue;
        };
        ui.label(name);
        let point = [0.14 * sign * height_m, 0.82 * height_m, 0.26 * height_m];
        let mut edited = aim.unwrap_or(Aim { point, weight: 0.0 });
        if sliders(ui, desk, name, &mut edited, height_m) {
            *aim = Some(edited);
            let result = reach(crowd, member, hand, edited);
            changed |= say(ui, desk, result);
        }
    }
    changed
}

fn reach(crowd: &mut Crowd, member: MemberId, hand: JointIndex, aim: Aim) -> Result<(), Error> {
    let mut view = crowd.member_mut(member)?;
    if aim.weight > 0.0 {
        let weight = Weight::new(aim.weight)?.over_secs(0.0);
        view.reach(Reach::with(hand), Target::InModel(aim.point), weight)
    } else {
        view.clear_reach(hand, 0.0)
    }
}

/// Shows weight and place of a target. Whoever moves the place wants the target.
fn sliders(ui: &mut Ui, desk: &mut Desk, name: &str, aim: &mut Aim, height_m: f32) -> bool {
    let mut changed =
        desk.slider(ui, (&format!("{name} weight"), "weight"), &mut aim.weight, 0.0..=1.0);
    let ranges = [-1.5..=1.5, 0.0..=1.4, -0.6..=2.5];
    for (axis, (word, range)) in ["to left", "height", "ahead"].into_iter().zip(ranges).enumerate()
    {
        let range = range.start() * height_m..=range.end() * height_m;
        if desk.slider(ui, (&format!("{name} {word}"), word), &mut aim.point[axis], range) {
            aim.weight = if aim.weight > 0.0 { aim.weight } else { 1.0 };
            changed = true;
        }
    }
    changed
}

fn height_m(crowd: &Crowd, member: MemberId) -> f32 {
    let character = crowd.member(member).and_then(|m| crowd.character(m.character()));
    character.map_or(1.8, |character| character.asset().height_m().max(0.1))
}

/// Shows an error. Returns true if there was none.
fn say(ui: &Ui, desk: &mut Desk, result: Result<(), Error>) -> bool {
    if let Err(error) = &result {
        desk.say(error.to_string(), ui.input(|input| input.time));
    }
    result.is_ok()
}
