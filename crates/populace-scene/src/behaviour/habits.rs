//! Habits that people of a plan cannot have, because they lack clips.

use super::body::{Body, Use, clip_name};
use crate::plan::{BehaviourPlan, CastPlan, CrowdPlan, FightPlan, SpectatePlan, StrollPlan};

/// A habit: its key, its rate and the usual one, and the clips that it needs.
type Habit = (&'static str, [f32; 2], &'static [Use]);

/// Names the habits that the plan of a crowd asks for and no `bodies` of its people have clips for. A
/// plan asks for a habit by a rate above 0 that is not the usual one.
pub(super) fn doubt(of: &CrowdPlan, cast: &CastPlan, bodies: &[&Body]) -> Option<String> {
    let (does, all) = habits(&of.does);
    let lacks = |usage: &Use| !bodies.iter().any(|body| body.has(&[*usage]));
    let is_asked = |(_, [rate, usual], _): &Habit| *rate > 0.0 && rate != usual;
    let cannot = |(_, _, uses): &Habit| !bodies.iter().any(|body| body.has(uses));
    let missing: Vec<Habit> = all.into_iter().filter(|of| is_asked(of) && cannot(of)).collect();
    if missing.is_empty() || bodies.is_empty() {
        return None;
    }
    let keys = missing.iter().map(|(key, ..)| format!("`{key}`")).collect();
    let uses = missing.iter().flat_map(|(_, _, uses)| *uses).filter(|usage| lacks(usage));
    let clips = uses.map(|usage| format!("\"{}\"", clip_name(*usage))).collect();
    let has_people = cast.clips_from.iter().any(|from| from == "@people");
    let cure = if has_people || bodies.iter().all(|body| body.upper.is_none()) {
        "name clips of its own in `clips` of its [[cast]]"
    } else {
        "write `clips_from = [\"@people\"]` into its [[cast]] for those of the built-in people, or \
         name its own in `clips`"
    };
    Some(format!(
        "nobody of the cast \"{}\" can do {} of `{does}`, for which clips are missing: {}; {cure}",
        cast.name,
        listed(keys),
        listed(clips),
    ))
}

fn listed(mut words: Vec<String>) -> String {
    let last = words.pop().unwrap_or_default();
    if words.is_empty() { last } else { format!("{} and {last}", words.join(", ")) }
}

fn habits(does: &BehaviourPlan) -> (&'static str, Vec<Habit>) {
    match does {
        BehaviourPlan::Stroll(plan) => ("stroll", of_strollers(plan)),
        BehaviourPlan::Spectate(plan) => ("spectate", of_spectators(plan)),
        BehaviourPlan::Fight(plan) => ("fight", of_soldiers(plan)),
        BehaviourPlan::Stand(_) => ("stand", Vec::new()),
    }
}

fn of_strollers(plan: &StrollPlan) -> Vec<Habit> {
    let usual = StrollPlan::default();
    vec![
        ("look_in", [plan.look_in, usual.look_in], &[Use::LookIn]),
        ("sit", [plan.sit, usual.sit], &[Use::SitDown, Use::Sit, Use::StandUp]),
        ("talk", [plan.talk, usual.talk], &[Use::Talk, Use::Listen]),
        ("lean", [plan.lean, usual.lean], &[Use::Lean]),
        ("phone", [plan.phone, usual.phone], &[Use::Phone]),
        ("text", [plan.text, usual.text], &[Use::Text]),
        ("drive", [plan.drive, usual.drive], &DRIVES),
        ("carry", [plan.carry, usual.carry], &[Use::Carry]),
    ]
}

const DRIVES: [Use; 4] = [Use::OpenDoor, Use::GetIn, Use::Drive, Use::GetOut];

fn of_spectators(plan: &SpectatePlan) -> Vec<Habit> {
    let usual = SpectatePlan::default();
    vec![
        ("clap", [plan.clap, usual.clap], &[Use::Clap]),
        ("cheer", [plan.cheer, usual.cheer], &[Use::Cheer]),
    ]
}

fn of_soldiers(plan: &FightPlan) -> Vec<Habit> {
    let usual = FightPlan::default();
    vec![
        ("thrust", [plan.thrust, usual.thrust], &[Use::Thrust]),
        ("hit", [plan.hit, usual.hit], &[Use::Hit]),
    ]
}
