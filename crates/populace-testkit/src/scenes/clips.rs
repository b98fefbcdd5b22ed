//! Clips of the scene.

use populace_model::Interpolation::{Linear, Step};
use populace_model::{ClipSource, JointSource, Property, Track};

use super::motion::{even_times, jumps, spline, swing, uneven_times, wave, wide_rotations, zigzag};
use super::{SceneBody, SceneClip, body, clip};
use crate::Rng;

/// Names and bodies, in the order of [`super::clip`].
const CLIPS: [(&str, usize); 15] = [
    ("even", body::SMALL),
    ("uneven", body::TWO_ROOTS),
    ("scaled", body::SCALED),
    ("steps", body::TWO_ROOTS),
    ("linear and steps", body::SMALL),
    ("still", body::SMALL),
    ("strangers", body::SMALL),
    ("wide", body::SMALL),
    ("wide uneven", body::SCALED),
    ("spline", body::TWO_ROOTS),
    ("all kinds", body::SMALL),
    ("large", body::LARGE),
    ("pair", body::PAIR),
    ("leaves", body::SMALL),
    ("bare", body::BARE),
];

pub(super) fn all(bodies: &[SceneBody]) -> Vec<SceneClip> {
    let mut rng = Rng::new(77);
    let mut clip = |(index, (name, body)): (usize, (&str, usize))| {
        let source = ClipSource {
            name: name.to_owned(),
            tracks: tracks(index, &mut rng, &bodies[body].joints),
        };
        let clip = SceneClip::new(source, &bodies[body], body);
        if index == clip::LEAVES { clip.with_halves() } else { clip }
    };
    CLIPS.into_iter().enumerate().map(&mut clip).collect()
}

fn tracks(index: usize, rng: &mut Rng, joints: &[JointSource]) -> Vec<Track> {
    let even = even_times(0.0, 46, 30.0);
    let later = even_times(0.5, 50, 30.0);
    let uneven = uneven_times(rng, 0.033, 60, 0.012, 0.045);
    let sparse = uneven_times(rng, -0.1, 8, 0.07, 0.3);
    match index {
        clip::EVEN => gentle(rng, joints, 0.8, &even),
        clip::UNEVEN => gentle(rng, joints, 0.8, &uneven),
        clip::SCALED => gentle_scaled(rng, joints, &uneven),
        clip::STEPS => steps(rng, joints),
        clip::LINEAR_AND_STEPS => linear_and_steps(rng, joints, &later),
        clip::STILL => gentle(rng, joints, 0.9, &[0.7]),
        clip::STRANGERS => strangers(rng, joints, &even),
        clip::WIDE => far(rng, joints, &even_times(0.0, 7, 5.0), false),
        clip::WIDE_UNEVEN => far(rng, joints, &sparse, true),
        clip::SPLINE => splines(rng, joints),
        clip::ALL_KINDS => all_kinds(rng, joints),
        clip::LARGE => gentle(rng, joints, 0.7, &even),
        clip::PAIR => gentle(rng, joints, 1.0, &uneven),
        clip::LEAVES => leaves(rng, joints, &even_times(0.3, 8, 5.0)),
        _ => gentle(rng, joints, 0.8, &later),
    }
}

/// Creates swings and waves with LINEAR keys for a fraction `share` of the joints. Some tracks have
/// only every second key.
fn gentle(rng: &mut Rng, joints: &[JointSource], share: f64, times: &[f32]) -> Vec<Track> {
    let seconds: Vec<f32> = times.iter().copied().step_by(2).collect();
    let mut tracks = Vec::new();
    for joint in joints {
        let times = if rng.chance(0.3) { &seconds } else { times };
        if rng.chance(share) {
            tracks.push(swing(rng, joint, Linear, times));
        }
        if rng.chance(share * 0.4) {
            tracks.push(wave(rng, joint, Property::Translation, Linear, times));
        }
    }
    tracks
}

fn gentle_scaled(rng: &mut Rng, joints: &[JointSource], times: &[f32]) -> Vec<Track> {
    let mut tracks = gentle(rng, joints, 0.8, times);
    for joint in joints {
        if rng.chance(0.6) {
            tracks.push(wave(rng, joint, Property::Scale, Linear, times));
        }
    }
    tracks
}

fn steps(rng: &mut Rng, joints: &[JointSource]) -> Vec<Track> {
    let times = [uneven_times(rng, 0.1, 6, 0.1, 0.4), even_times(0.0, 9, 6.0)];
    let mut tracks = Vec::new();
    for joint in joints {
        let times = &times[rng.below(2)];
        tracks.push(swing(rng, joint, Step, times));
        if rng.chance(0.4) {
            tracks.push(wave(rng, joint, Property::Translation, Step, times));
        }
    }
    tracks
}

fn linear_and_steps(rng: &mut Rng, joints: &[JointSource], times: &[f32]) -> Vec<Track> {
    let sparse = even_times(0.6, 5, 4.0);
    let mut tracks = Vec::new();
    for joint in joints {
        if rng.chance(0.3) {
            tracks.push(swing(rng, joint, Step, &sparse));
            tracks.push(wave(rng, joint, Property::Translation, Linear, times));
        } else {
            tracks.push(swing(rng, joint, Linear, times));
            tracks.push(wave(rng, joint, Property::Translation, Step, &sparse));
        }
        if rng.chance(0.3) {
            tracks.push(wave(rng, joint, Property::Scale, Step, &sparse));
        }
    }
    tracks
}

/// Creates rotations of joints without children.
fn leaves(rng: &mut Rng, joints: &[JointSource], times: &[f32]) -> Vec<Track> {
    let is_leaf = |at: usize| joints.iter().all(|joint| joint.parent != Some(at));
    let leaves = (0..joints.len()).filter(|&at| is_leaf(at));
    leaves.map(|at| zigzag(rng, &joints[at], times)).collect()
}

/// Creates tracks of a few joints, mixed with tracks of joints that no skeleton has.
fn strangers(rng: &mut Rng, joints: &[JointSource], times: &[f32]) -> Vec<Track> {
    let mut tracks = gentle(rng, joints, 0.3, times);
    for name in ["tail", "left ear", "cape 7"] {
        let stranger = JointSource { name: name.into(), ..joints[0].clone() };
        tracks.insert(rng.below(tracks.len()), swing(rng, &stranger, Linear, times));
    }
    tracks
}

fn far(rng: &mut Rng, joints: &[JointSource], times: &[f32], scaled: bool) -> Vec<Track> {
    let mut tracks = Vec::new();
    for joint in joints {
        tracks.push(wide_rotations(rng, joint, times));
        if rng.chance(0.5) {
            tracks.push(jumps(rng, joint, Property::Translation, times));
        }
        if scaled && rng.chance(0.5) {
            tracks.push(jumps(rng, joint, Property::Scale, times));
        }
    }
    tracks
}

fn splines(rng: &mut Rng, joints: &[JointSource]) -> Vec<Track> {
    let times = uneven_times(rng, 0.05, 7, 0.12, 0.4);
    let mut tracks = Vec::new();
    for joint in joints {
        tracks.push(spline(rng, joint, Property::Rotation, &times));
        if rng.chance(0.5) {
            tracks.push(spline(rng, joint, Property::Translation, &times));
        }
        if rng.chance(0.2) {
            tracks.push(spline(rng, joint, Property::Scale, &times));
        }
    }
    tracks
}

fn all_kinds(rng: &mut Rng, joints: &[JointSource]) -> Vec<Track> {
    let (sparse, dense) = (even_times(0.1, 5, 3.0), even_times(0.0, 40, 25.0));
    let mut tracks = Vec::new();
    for joint in joints {
        match rng.below(4) {
            0 => tracks.push(spline(rng, joint, Property::Rotation, &sparse)),
            1 => tracks.push(swing(rng, joint, Step, &sparse)),
            2 => tracks.push(swing(rng, joint, Linear, &dense)),
            _ => tracks.push(wide_rotations(rng, joint, &sparse)),
        }
        match rng.below(4) {
            0 => tracks.push(spline(rng, joint, Property::Translation, &sparse)),
            1 => tracks.push(wave(rng, joint, Property::Translation, Step, &sparse)),
            2 => tracks.push(wave(rng, joint, Property::Translation, Linear, &dense)),
            _ => {}
        }
    }
    tracks
}
