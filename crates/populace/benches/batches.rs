//! Calls for one member, and the batch calls for the same, at 10,000 members:
//! `cargo bench -p populace --bench batches`.
//!
//! Both are run in turns; the table shows medians in nanoseconds for a member, and their ratio. The
//! last two lines are in milliseconds.

#![expect(clippy::print_stdout, reason = "a bench prints its figures")]

use std::hint::black_box;
use std::time::Instant;

use populace::{
    Affine, BlendSpace, BlendSpaceId, BlendSpacePlayback, ClipId, ClipPlayback, Crowd, Device,
    Error, JointIndex, MachinePlayback, MemberId, ParameterId, Placement, Schedule, SpacePoint,
    StateMachine, StatePlayback, doc_fixture,
};

const MEMBERS: usize = 10_000;
const ROUNDS: usize = 15;

struct Scene {
    crowd: Crowd,
    members: Vec<MemberId>,
    clips: [ClipId; 2],
    space: BlendSpaceId,
    speed: ParameterId,
    /// Arguments of the calls: one list for even numbers, one for odd.
    placements: [Vec<(MemberId, Placement)>; 2],
    values: [Vec<(MemberId, f32)>; 2],
    joints: Vec<(MemberId, JointIndex)>,
}

fn placement(nth: usize) -> Placement {
    Placement::at([nth as f32 * 0.01, 0.0, 1.0]).facing(nth as f32 * 1e-3)
}

/// Plays a blend space and, on the layer above, a clip.
fn play_space(
    crowd: &mut Crowd,
    id: MemberId,
    space: BlendSpaceId,
    clip: ClipId,
) -> Result<(), Error> {
    let mut member = crowd.member_mut(id)?;
    member.play_blend_space(space, 0.5, BlendSpacePlayback::new())?;
    member.play(clip, ClipPlayback::looping().on_layer(1))?;
    Ok(())
}

impl Scene {
    fn new(schedule: Schedule, machines: bool) -> Result<Self, Error> {
        let builder = Crowd::builder().device(Device::native()).schedule(schedule);
        let mut crowd = builder.capacity(2 * MEMBERS).build()?;
        let knight = doc_fixture::knight(&mut crowd)?;
        let [idle, walk] = [crowd.clip(knight, "Idle")?, crowd.clip(knight, "Walk")?];
        let machine = StateMachine::new().parameter("speed", 0.0).state(
            "idle",
            idle,
            StatePlayback::looping(),
        );
        let machine = crowd.add_machine(&machine)?;
        let speed = crowd.parameter(machine, "speed")?;
        let space = crowd.add_blend_space(BlendSpace::line(&[(idle, 0.0), (walk, 1.4)])?)?;
        let mut members = Vec::new();
        for nth in 0..MEMBERS {
            let id = crowd.spawn(knight, placement(nth))?;
            if machines {
                crowd.member_mut(id)?.play_machine(machine, MachinePlayback::new())?;
            } else {
                play_space(&mut crowd, id, space, walk)?;
            }
            members.push(id);
        }
        crowd.update(0.1)?;
        let numbered = || members.iter().copied().enumerate();
        let placements =
            [0, 1].map(|odd| numbered().map(|(n, m)| (m, placement(n + odd))).collect());
        let values = [0.3, 0.9].map(|value| numbered().map(|(_, m)| (m, value)).collect());
        let joints = numbered().map(|(_, member)| (member, JointIndex(0))).collect();
        let clips = [idle, walk];
        Ok(Self { crowd, clips, space, speed, placements, values, joints, members })
    }
}

/// A call on all members, for the `nth` time. It returns members to despawn afterwards.
type Call = fn(&mut Scene, usize) -> Result<Vec<MemberId>, Error>;

/// Times calls in turns and returns their medians in nanoseconds for a member.
fn medians<const N: usize>(scene: &mut Scene, calls: [Call; N]) -> Result<[f64; N], Error> {
    let mut times = calls.map(|_| Vec::new());
    for round in 0..ROUNDS {
        for (nth, call) in calls.into_iter().enumerate() {
            let start = Instant::now();
            let new = call(scene, 2 * round + nth)?;
            times[nth].push(start.elapsed().as_nanos() as f64 / MEMBERS as f64);
            new.into_iter().try_for_each(|member| scene.crowd.despawn(member))?;
            scene.crowd.update(0.01)?;
        }
    }
    Ok(times.map(median))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Times both calls in turns and prints the medians.
fn compare(name: &str, scene: &mut Scene, calls: [Call; 2]) -> Result<(), Error> {
    let [single, batch] = medians(scene, calls)?;
    println!("{name:<24} {single:>9.1} {batch:>9.1} {:>7.1}", single / batch);
    Ok(())
}

/// Starts the other clip on each member, with a crossfade that is over when the next one begins.
fn crossfade(scene: &mut Scene, nth: usize) -> Result<Vec<MemberId>, Error> {
    let Scene { crowd, members, clips, .. } = scene;
    let clip = clips[nth / 2 % 2];
    for id in &*members {
        crowd.member_mut(*id)?.play(clip, ClipPlayback::looping().fade_in_secs(0.005))?;
    }
    Ok(Vec::new())
}

/// Despawns every tenth member, spawns as many, which then play what the others play, and updates
/// the crowd. Returns the milliseconds of the exchange and of the update: medians of rounds without
/// the exchange and with it.
fn churn(scene: &mut Scene) -> Result<[[f64; 2]; 2], Error> {
    let mut times = [false, true].map(|_| [Vec::new(), Vec::new()]);
    let knight = scene.crowd.member(scene.members[0])?.character();
    for round in 0..2 * ROUNDS {
        let Scene { crowd, members, space, clips, .. } = &mut *scene;
        let (changes, first) = (round % 2, round / 2 % 10);
        let start = Instant::now();
        if changes == 1 {
            for (nth, member) in members.iter_mut().enumerate().skip(first).step_by(10) {
                crowd.despawn(*member)?;
                *member = crowd.spawn(knight, placement(nth))?;
            }
        }
        times[changes][0].push(start.elapsed().as_secs_f64() * 1e3);
        if changes == 1 {
            for member in members.iter().skip(first).step_by(10) {
                play_space(crowd, *member, *space, clips[1])?;
            }
        }
        let start = Instant::now();
        crowd.update(0.01)?;
        times[changes][1].push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(times.map(|calls_and_update| calls_and_update.map(median)))
}

const SPAWN: [Call; 2] = [
    |scene, _| {
        let knight = scene.crowd.member(scene.members[0])?.character();
        let spawn = |nth| scene.crowd.spawn(knight, placement(nth));
        (0..MEMBERS).map(spawn).collect()
    },
    |scene, _| {
        let knight = scene.crowd.member(scene.members[0])?.character();
        let all: Vec<_> = (0..MEMBERS).map(placement).collect();
        scene.crowd.spawn_many(knight, &all)
    },
];

const PLACE: [Call; 2] = [
    |scene, nth| {
        let Scene { crowd, placements, .. } = scene;
        let all = &placements[nth / 2 % 2];
        all.iter().try_for_each(|(id, at)| crowd.member_mut(*id)?.set_placement(*at))?;
        Ok(Vec::new())
    },
    |scene, nth| {
        scene.crowd.set_placements(&scene.placements[nth / 2 % 2])?;
        Ok(Vec::new())
    },
];

const PARAMETER: [Call; 2] = [
    |scene, nth| {
        let Scene { crowd, values, .. } = scene;
        let all = &values[nth % 2];
        all.iter()
            .try_for_each(|(id, value)| crowd.member_mut(*id)?.set_parameter("speed", *value))?;
        Ok(Vec::new())
    },
    |scene, nth| {
        scene.crowd.set_parameters(scene.speed, &scene.values[nth % 2])?;
        Ok(Vec::new())
    },
];

const BLEND: [Call; 2] = [
    |scene, nth| {
        let Scene { crowd, values, .. } = scene;
        let all = &values[nth % 2];
        all.iter().try_for_each(|(id, at)| crowd.member_mut(*id)?.set_blend_parameter(*at, 0.2))?;
        Ok(Vec::new())
    },
    |scene, nth| {
        let all = scene.values[nth % 2].iter();
        let points: Vec<_> = all.map(|(id, at)| (*id, SpacePoint::from(*at))).collect();
        scene.crowd.set_blend_parameters(&points, 0.2)?;
        Ok(Vec::new())
    },
];

const JOINTS: [Call; 2] = [
    |scene, _| {
        let Scene { crowd, members, .. } = scene;
        members.iter().try_for_each(|id| {
            black_box(crowd.member_mut(*id)?.model_from_joints()?[0]);
            Ok::<(), Error>(())
        })?;
        Ok(Vec::new())
    },
    |scene, _| {
        let mut models = vec![Affine::IDENTITY; MEMBERS];
        scene.crowd.read_joints(&scene.joints, &mut models)?;
        black_box(&models);
        Ok(Vec::new())
    },
];

const PALETTES: [Call; 2] = [
    |scene, _| {
        let Scene { crowd, members, .. } = scene;
        members.iter().try_for_each(|id| {
            black_box(crowd.member_mut(*id)?.palette()?);
            Ok::<(), Error>(())
        })?;
        Ok(Vec::new())
    },
    |scene, _| {
        scene.crowd.palettes(&mut |_, palette| {
            black_box(palette);
        })?;
        Ok(Vec::new())
    },
];

fn main() -> Result<(), Error> {
    println!("{:<24} {:>9} {:>9} {:>7}", "ns for a member", "single", "batch", "ratio");
    let mut fused = Scene::new(Schedule::Fused, false)?;
    compare("spawn", &mut fused, SPAWN)?;
    compare("placements", &mut fused, PLACE)?;
    compare("blend parameters", &mut fused, BLEND)?;
    compare("palettes", &mut fused, PALETTES)?;
    compare("joints, fused", &mut fused, JOINTS)?;
    compare("joints, staged", &mut Scene::new(Schedule::Staged, false)?, JOINTS)?;
    compare("machine parameters", &mut Scene::new(Schedule::Fused, true)?, PARAMETER)?;
    let [play] = medians(&mut Scene::new(Schedule::Fused, true)?, [crossfade])?;
    println!("{:<24} {play:>9.1}", "play with a crossfade");
    let [[_, still], [calls, update]] = churn(&mut Scene::new(Schedule::Fused, false)?)?;
    println!("despawn and spawn {}: {calls:.2} ms", MEMBERS / 10);
    println!("update after that: {update:.2} ms, without changes {still:.2} ms");
    Ok(())
}
