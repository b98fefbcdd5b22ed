//! State machines and blend spaces from arbitrary bytes, in a small crowd.
//!
//! The fuzz target `builders` runs [`survives`] too. What is refused must say why, and what is
//! accepted must give finite palettes.

use std::sync::Arc;

use arbitrary::{Result as Drawn, Unstructured};
use populace::{
    BlendSpace, BlendSpacePlayback, ClipId, Condition, Crowd, Device, Error, MachinePlayback,
    MemberId, Placement, SpacePoint, StateMachine, StatePlayback,
};
use populace_testkit::Rng;

use crate::fixture::characters;
use crate::imported::has_finite_palette;

/// Names of states and parameters. Few, so that they often meet.
const NAMES: [&str; 5] = ["speed", "idle", "walk", "run", ""];
/// Steps of a crowd, in seconds.
const STEPS: [f32; 5] = [1.0 / 60.0, 0.3, 0.0, 1e-5, 1000.0];

/// Checks 400 random inputs.
pub(crate) fn check_random() -> Result<(), libtest_mimic::Failed> {
    let mut rng = Rng::new(401);
    for _ in 0..400 {
        let bytes: Vec<u8> = (0..24).flat_map(|_| rng.bits().to_le_bytes()).collect();
        survives(&bytes).map_err(|fault| format!("{fault}: {bytes:?}"))?;
    }
    Ok(())
}

/// Builds a machine and a blend space from bytes, and plays what is accepted. The error describes
/// the fault.
pub(crate) fn survives(bytes: &[u8]) -> Result<(), String> {
    let mut input = Unstructured::new(bytes);
    // Bytes that end early make a shorter run.
    run(&mut input).unwrap_or(Ok(()))
}

/// A crowd with two bodies and a member of each.
struct Stage {
    crowd: Crowd,
    members: Vec<MemberId>,
    clips: Vec<ClipId>,
}

impl Stage {
    fn new() -> Result<Self, Error> {
        let devices = Device::Native { threads: 1 };
        let mut crowd = Crowd::builder().devices(devices).capacity(4).build()?;
        let (mut members, mut clips) = (Vec::new(), Vec::new());
        for character in &characters()[..2] {
            let id = crowd.add_character(Arc::clone(character))?;
            clips.extend(crowd.character(id)?.clips().into_iter().map(|(clip, _)| clip));
            members.push(crowd.spawn(id, Placement::at([0.0; 3]))?);
        }
        Ok(Self { crowd, members, clips })
    }

    fn has_finite_palettes(&mut self) -> Result<bool, Error> {
        let mut is_finite = true;
        for member in &self.members {
            is_finite &= has_finite_palette(&mut self.crowd, *member)?;
        }
        Ok(is_finite)
    }
}

/// Returns what was accepted, or an error if a refusal does not say why.
fn accepted<T>(result: Result<T, Error>) -> Result<Option<T>, String> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(error) if error.to_string().is_empty() => Err(format!("{error:?} does not say why")),
        Err(_) => Ok(None),
    }
}

fn run(input: &mut Unstructured<'_>) -> Drawn<Result<(), String>> {
    let mut stage = Stage::new().expect("two characters fit");
    let machine = machine(input, &stage.clips)?;
    let space = space(input, &stage.clips)?;
    let member = stage.members[input.choose_index(stage.members.len())?];
    let playback = MachinePlayback::new()
        .weight(number(input)?)
        .fade_in_secs(number(input)?)
        .after_secs(number(input)?)
        .on_layer(input.int_in_range(0..=5)?);
    let at = point(input)?;
    let sample = BlendSpacePlayback::new().speed(number(input)?).weight(number(input)?);
    let sample = sample.fade_in_secs(number(input)?).on_layer(input.int_in_range(0..=5)?);
    Ok((|| {
        if let Some(machine) = accepted(stage.crowd.add_machine(&machine))? {
            let mut member = stage.crowd.member_mut(member).expect("a member");
            accepted(member.play_machine(machine, playback))?;
        }
        if let Some(space) = accepted(space.and_then(|space| stage.crowd.add_blend_space(space)))? {
            let mut member = stage.crowd.member_mut(member).expect("a member");
            accepted(member.play_blend_space(space, at, sample))?;
        }
        play(input, &mut stage, member).unwrap_or(Ok(()))
    })())
}

/// Changes parameters and updates the crowd, until the bytes end or for eight frames.
fn play(
    input: &mut Unstructured<'_>,
    stage: &mut Stage,
    member: MemberId,
) -> Drawn<Result<(), String>> {
    for _ in 0..8 {
        let (name, value, at) = (name(input)?, number(input)?, point(input)?);
        let secs = *input.choose(&STEPS)?;
        let checked = (|| {
            let mut view = stage.crowd.member_mut(member).expect("a member");
            accepted(view.set_parameter(name, value))?;
            accepted(view.set_blend_parameter(at, value))?;
            accepted(view.machine_state(0))?;
            accepted(stage.crowd.update(secs))?;
            match stage.has_finite_palettes() {
                Ok(true) => Ok(()),
                Ok(false) => Err("a palette is not finite".to_owned()),
                Err(error) => Err(format!("no palettes: {error}")),
            }
        })();
        if checked.is_err() {
            return Ok(checked);
        }
    }
    Ok(Ok(()))
}

/// Draws a number: mostly a plain one, sometimes any bits.
fn number(input: &mut Unstructured<'_>) -> Drawn<f32> {
    if input.ratio(1, 8)? {
        return input.arbitrary();
    }
    Ok(f32::from(input.int_in_range(-4_i8..=12)?) / 8.0)
}

fn name(input: &mut Unstructured<'_>) -> Drawn<&'static str> {
    Ok(*input.choose(&NAMES)?)
}

fn point(input: &mut Unstructured<'_>) -> Drawn<SpacePoint> {
    let point = SpacePoint::from([number(input)?, number(input)?]);
    Ok(if input.ratio(1, 4)? { point.at_cycles_per_sec(number(input)?) } else { point })
}

fn state(input: &mut Unstructured<'_>) -> Drawn<StatePlayback> {
    let state = match input.int_in_range(0..=3)? {
        0 => StatePlayback::once(),
        1 => StatePlayback::held_at_secs(number(input)?),
        _ => StatePlayback::looping(),
    };
    let state = state.speed(number(input)?).phase(number(input)?);
    Ok(if input.ratio(1, 8)? { state.partial() } else { state })
}

fn condition(input: &mut Unstructured<'_>) -> Drawn<Condition> {
    Ok(match input.int_in_range(0..=3)? {
        0 => Condition::above(name(input)?, number(input)?),
        1 => Condition::below(name(input)?, number(input)?),
        2 => Condition::AfterSecs(number(input)?),
        _ => Condition::Ended,
    })
}

fn machine(input: &mut Unstructured<'_>, clips: &[ClipId]) -> Drawn<StateMachine> {
    let mut machine = StateMachine::new();
    for _ in 0..input.int_in_range(0..=3)? {
        machine = machine.parameter(name(input)?, number(input)?);
    }
    for _ in 0..input.int_in_range(0..=5)? {
        machine = machine.state(name(input)?, *input.choose(clips)?, state(input)?);
    }
    for _ in 0..input.int_in_range(0..=8)? {
        let conditions =
            (0..input.int_in_range(0..=3)?).map(|_| condition(input)).collect::<Drawn<Vec<_>>>()?;
        let (to, fade_secs) = (name(input)?, number(input)?);
        machine = if input.ratio(1, 4)? {
            machine.transition_from_any(to, fade_secs, &conditions)
        } else {
            machine.transition(name(input)?, to, fade_secs, &conditions)
        };
    }
    Ok(machine)
}

fn space(input: &mut Unstructured<'_>, clips: &[ClipId]) -> Drawn<Result<BlendSpace, Error>> {
    let count = input.int_in_range(0..=7)?;
    let space = if input.arbitrary()? {
        let sample = |input: &mut Unstructured<'_>| Ok((*input.choose(clips)?, number(input)?));
        BlendSpace::line(&(0..count).map(|_| sample(input)).collect::<Drawn<Vec<_>>>()?)
    } else {
        let sample = |input: &mut Unstructured<'_>| {
            Ok((*input.choose(clips)?, [number(input)?, number(input)?]))
        };
        BlendSpace::plane(&(0..count).map(|_| sample(input)).collect::<Drawn<Vec<_>>>()?)
    };
    if !input.ratio(1, 3)? {
        return Ok(space);
    }
    let (clip, cycles) = (*input.choose(clips)?, number(input)?);
    Ok(space.and_then(|space| space.with_offset(clip, cycles)))
}
