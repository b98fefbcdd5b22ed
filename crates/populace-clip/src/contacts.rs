//! Ground contact of feet: touch-downs, and the walking speed of a clip that walks in place.

use std::sync::Arc;

use glam::DVec3;
use populace_model::humanoid::name_words;
use populace_model::{JointIndex, Skeleton, f64math};

use crate::rows::Rows;

/// Height above its lowest position, as a fraction of the body's size, up to which a foot counts as
/// planted.
const PLANTED: f64 = 0.02;

/// Multiple of that height from which a planted foot counts as lifted.
const LIFTED: f64 = 2.0;

/// A foot touching the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Footstep {
    /// Name of the joint that touches the ground, in the clip's own skeleton.
    pub joint: Arc<str>,
    /// Time on the clip's own axis, in seconds.
    pub secs: f32,
}

/// Ground contacts of all feet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    /// Mean backward speed of the planted foot in metres per second: the speed at which the ground
    /// must move so that feet do not slide. `None` if no joint has a known foot name or no foot is
    /// ever planted.
    pub(crate) speed: Option<f32>,
    /// In ascending order of time.
    pub(crate) footsteps: Vec<Footstep>,
}

impl Contacts {
    pub(crate) fn new(rows: &Rows, skeleton: &Skeleton) -> Self {
        let feet = feet(skeleton);
        if feet.is_empty() || rows.times.len() < 2 {
            return Self::default();
        }
        let position = |row: usize, foot: JointIndex| {
            let chain = std::iter::successors(Some(foot), |joint| skeleton.parent(*joint));
            chain.fold(DVec3::ZERO, |point, joint| {
                rows.local(joint, row, 0.0).affine().transform_point3(point)
            })
        };
        let positions: Vec<Vec<DVec3>> = (0..rows.times.len())
            .map(|row| feet.iter().map(|foot| position(row, *foot)).collect())
            .collect();
        let lowest =
            |foot: usize| positions.iter().map(|p| p[foot].y).fold(f64::INFINITY, f64::min);
        let heights: Vec<f64> = (0..feet.len()).map(lowest).collect();
        let limit = PLANTED * f64::from(skeleton.size_m());
        let mut footsteps = Vec::new();
        for (foot, joint) in feet.iter().enumerate() {
            let above: Vec<f64> =
                positions.iter().map(|place| (place[foot].y - heights[foot]) / limit).collect();
            let name: Arc<str> = skeleton.name(*joint).into();
            let step = |secs| Footstep { joint: Arc::clone(&name), secs };
            footsteps.extend(touch_downs(&rows.times, &above).into_iter().map(step));
        }
        footsteps.sort_by(|a, b| a.secs.total_cmp(&b.secs));
        Self { speed: ground_speed(&rows.times, &positions, &heights, limit), footsteps }
    }
}

/// Returns the times at which a height falls to 1 after it was above [`LIFTED`]. Times are
/// interpolated linearly between rows. A foot that ends lifted and starts planted touches down at
/// the first row.
fn touch_downs(times: &[f32], above: &[f64]) -> Vec<f32> {
    let (mut lifted, mut found) = (above[0] > 1.0, Vec::new());
    for row in 1..times.len() {
        let (from, to) = (above[row - 1], above[row]);
        if lifted && to <= 1.0 {
            let part = if from > to { ((from - 1.0) / (from - to)).clamp(0.0, 1.0) } else { 1.0 };
            let secs = f64::from(times[row - 1])
                + part * (f64::from(times[row]) - f64::from(times[row - 1]));
            found.push(f64math::to_f32([secs])[0]);
            lifted = false;
        }
        lifted |= to > LIFTED;
    }
    if lifted && above[0] <= 1.0 {
        found.push(times[0]);
    }
    found
}

fn ground_speed(
    times: &[f32],
    positions: &[Vec<DVec3>],
    heights: &[f64],
    limit: f64,
) -> Option<f32> {
    let (mut distance, mut time) = (0.0, 0.0);
    for (times, pair) in times.windows(2).zip(positions.windows(2)) {
        let secs = f64::from(times[1]) - f64::from(times[0]);
        let above = |foot: &usize| pair[0][*foot].y.max(pair[1][*foot].y) - heights[*foot];
        let planted = (0..heights.len()).min_by(|a, b| above(a).total_cmp(&above(b)));
        if let Some(foot) = planted.filter(|foot| above(foot) <= limit && secs > 0.0) {
            distance += pair[0][foot].z - pair[1][foot].z;
            time += secs;
        }
    }
    (time > 0.0).then(|| f64math::to_f32([distance / time])[0])
}

/// Returns the joints that touch the ground, by name: toes, else feet, else ankles, without the
/// helper joints of rigs.
fn feet(skeleton: &Skeleton) -> Vec<JointIndex> {
    let words: Vec<Vec<String>> = skeleton.joints().map(|j| name_words(skeleton.name(j))).collect();
    let named = |part: &&str| -> Vec<JointIndex> {
        let joints = skeleton.joints().zip(&words);
        joints.filter(|(_, words)| is_named(words, part)).map(|(joint, _)| joint).collect()
    };
    let all = ["toe", "foot", "ankle"];
    all.iter().map(named).find(|feet| !feet.is_empty()).unwrap_or_default()
}

/// Words of the names of helper joints.
const HELPERS: [&str; 6] = ["control", "ik", "roll", "pole", "target", "end"];

/// Returns whether one of a name's words has `part` in it and none tells of a helper, such as "ik",
/// "ikl" and "footik". Bodies may be called Mike.
fn is_named(words: &[String], part: &str) -> bool {
    let helps = |word: &String| {
        let word = word.trim_end_matches(char::is_numeric);
        HELPERS.iter().any(|helper| match word.strip_prefix(helper) {
            Some("" | "l" | "r") => true,
            _ => word.contains(part) && word.contains(helper),
        })
    };
    words.iter().any(|word| word.contains(part)) && !words.iter().any(helps)
}

#[cfg(test)]
mod tests {
    use populace_model::{JointSource, Trs};

    use super::*;

    fn is_foot(name: &str) -> bool {
        let joint = JointSource { name: name.into(), parent: None, rest: Trs::IDENTITY };
        !feet(&Skeleton::new(&[joint]).unwrap()).is_empty()
    }

    #[test]
    fn names_of_bodies_make_no_helpers_of_feet() {
        for name in [
            "LeftToeBase",
            "Viking:LeftToeBase",
            "Troll|foot.L",
            "Mike_LeftFoot",
            "Legend_L_Foot",
            "Napoleon:ankle_r",
            "toe1",
        ] {
            assert!(is_foot(name), "{name}");
        }
        for name in [
            "foot_ik.L",
            "footik_l",
            "Target01_foot",
            "IKFootL",
            "FootIKL",
            "foot_roll",
            "toe_end",
            "LeftToe_End",
            "FootControl",
            "foot_pole_target",
            "hand",
            "Foot:hand",
        ] {
            assert!(!is_foot(name), "{name}");
        }
    }
}
