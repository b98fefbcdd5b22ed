//! Checks of who is in a scene, and what they do.

use super::fault::{Fault, first, first_of, unknown};
use super::limits::{
    ADVANCE, BODY_HEIGHT, COORDINATE, HEADING, MEMBERS, PART, RATE, SPACING, START, WALKING_SPEED,
    WAVE_EVERY, WAVE_SPEED,
};
use crate::THING_KINDS;
use crate::behaviour::use_keys;
use crate::plan::{
    BehaviourPlan, CastPlan, CrowdPlan, FightPlan, GazePlan, LayerPlan, ScenePlan, SpectatePlan,
    StandPlan, StrollPlan,
};
use crate::stage::Bearer;

pub(super) fn check(plan: &ScenePlan) -> Option<Fault> {
    first_of("cast", &plan.casts, |cast| check_cast(plan, cast))
        .or_else(|| first_of("crowd", &plan.crowds, |crowd| check_crowd(plan, crowd)))
}

fn check_cast(plan: &ScenePlan, cast: &CastPlan) -> Option<Fault> {
    if cast.from.is_empty() {
        let rule = "a list of files or built-in people, such as [\"@people\"]";
        return Some(Fault::of("from", rule));
    }
    let unknown_use = cast.clips.keys().find_map(|key| {
        let rule = unknown("a use of clips", key, use_keys())?;
        Some(Fault::of(key.clone(), rule).within("clips"))
    });
    // Files of props may be held too.
    let files = plan.props.iter().filter_map(|prop| prop.file.as_deref());
    let things: Vec<_> = THING_KINDS.into_iter().chain(files).collect();
    let unknown_thing = cast.holds.iter().find_map(|thing| {
        let rule = unknown("things to hold", thing, things.iter().copied())?;
        Some(Fault::of("holds", rule))
    });
    let in_one_place = || {
        let (first, second) = in_one_place(&cast.holds)?;
        let rule = format!(
            "at most one thing for the head and each hand: the {} has \"{first}\" and \"{second}\"",
            Bearer::of(first).name()
        );
        Some(Fault::of("holds", rule))
    };
    unknown_use
        .or(unknown_thing)
        .or_else(in_one_place)
        .or_else(|| BODY_HEIGHT.check("height_m", cast.height_m?))
        .or_else(|| PART.check_all("top", cast.top.as_ref()?))
}

/// Returns the first two things that are held or worn in one place.
fn in_one_place(things: &[String]) -> Option<(&str, &str)> {
    things.iter().enumerate().find_map(|(nth, second)| {
        let first = things[..nth].iter().find(|first| Bearer::of(first) == Bearer::of(second))?;
        Some((first.as_str(), second.as_str()))
    })
}

fn check_crowd(plan: &ScenePlan, crowd: &CrowdPlan) -> Option<Fault> {
    let casts = plan.casts.iter().map(|cast| cast.name.as_str());
    if let Some(rule) = unknown("a cast of the file", &crowd.cast, casts) {
        return Some(Fault::of("cast", rule));
    }
    MEMBERS
        .check("count", crowd.count)
        .or_else(|| check_does(plan, &crowd.does))
        .or_else(|| first_of("layers", &crowd.layers, check_layer))
        .or_else(|| check_gaze(crowd.gaze.as_ref()?))
}

fn check_layer(layer: &LayerPlan) -> Option<Fault> {
    first([PART.check("weight", layer.weight), PART.check("share", layer.share)])
}

fn check_gaze(gaze: &GazePlan) -> Option<Fault> {
    let fault = first([COORDINATE.check_all("at", &gaze.at), PART.check("weight", gaze.weight)]);
    fault.map(|fault| fault.within("gaze"))
}

fn check_does(plan: &ScenePlan, does: &BehaviourPlan) -> Option<Fault> {
    match does {
        BehaviourPlan::Stroll(_) if plan.footways.is_empty() => {
            Some(Fault::of("does", "another kind: `stroll` needs a [[footway]]"))
        }
        BehaviourPlan::Stroll(stroll) => {
            check_stroll(plan, stroll).map(|fault| fault.within("does.stroll"))
        }
        BehaviourPlan::Spectate(spectate) => {
            check_spectate(spectate).map(|fault| fault.within("does.spectate"))
        }
        BehaviourPlan::Fight(fight) => check_fight(fight).map(|fault| fault.within("does.fight")),
        BehaviourPlan::Stand(stand) => check_stand(stand).map(|fault| fault.within("does.stand")),
    }
}

fn check_stroll(plan: &ScenePlan, stroll: &StrollPlan) -> Option<Fault> {
    let known = || plan.footways.iter().map(|footway| footway.name.as_str());
    let mut unknowns = stroll.footways.iter();
    if let Some(rule) =
        unknowns.find_map(|name| unknown("names of footways of the file", name, known()))
    {
        return Some(Fault::of("footways", rule));
    }
    first([
        WALKING_SPEED.check("speed", stroll.speed),
        RATE.check("look_in", stroll.look_in),
        RATE.check("cross", stroll.cross),
        RATE.check("sit", stroll.sit),
        RATE.check("talk", stroll.talk),
        RATE.check("lean", stroll.lean),
        RATE.check("phone", stroll.phone),
        RATE.check("text", stroll.text),
        RATE.check("drive", stroll.drive),
        RATE.check("hurry", stroll.hurry),
        PART.check("carry", stroll.carry),
        PART.check("together", stroll.together),
    ])
}

fn check_spectate(spectate: &SpectatePlan) -> Option<Fault> {
    first([
        RATE.check("clap", spectate.clap),
        RATE.check("cheer", spectate.cheer),
        WAVE_EVERY.check("wave_every_s", spectate.wave_every_s),
        WAVE_SPEED.check("wave_speed", spectate.wave_speed),
    ])
}

fn check_fight(fight: &FightPlan) -> Option<Fault> {
    first([
        COORDINATE.check_all("at", &fight.at),
        HEADING.check("facing_deg", fight.facing_deg),
        MEMBERS.check("rank", fight.rank),
        SPACING.check_all("spacing_m", &fight.spacing_m),
        ADVANCE.check("advance_m", fight.advance_m),
        RATE.check("thrust", fight.thrust),
        RATE.check("hit", fight.hit),
    ])
}

fn check_stand(stand: &StandPlan) -> Option<Fault> {
    first([
        COORDINATE.check_all("at", &stand.at),
        HEADING.check("facing_deg", stand.facing_deg),
        MEMBERS.check("row", stand.row),
        SPACING.check("spacing_m", stand.spacing_m),
        START.check("start_s", stand.start_s),
    ])
}
