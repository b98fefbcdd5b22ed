use glam::{DQuat, DVec3};
use populace_model::{Interpolation, JointSource, Property, Track, f64math};

use super::*;

const BONE: DVec3 = DVec3::new(0.0, 0.5, 0.0);

/// A chain of `count` joints, each 0.5 m above the previous one.
fn chain(count: usize) -> Skeleton {
    let joint = |i: usize| JointSource {
        name: format!("joint {i}"),
        parent: i.checked_sub(1),
        rest: Trs { translation: [0.0, 0.5, 0.0], ..Trs::IDENTITY },
    };
    Skeleton::new(&(0..count).map(joint).collect::<Vec<_>>()).unwrap()
}

/// A track of rotations about an axis, one every 0.2 s.
fn turns(joint: usize, axis: DVec3, interpolation: Interpolation, angles: &[f64]) -> Track {
    let key = |angle: &f64| f64math::to_f32(DQuat::from_axis_angle(axis, *angle).to_array());
    Track {
        joint: format!("joint {joint}"),
        property: Property::Rotation,
        interpolation,
        times: (0..angles.len()).map(|key| 0.2 * key as f32).collect(),
        values: angles.iter().flat_map(key).collect(),
    }
}

fn clip(tracks: Vec<Track>, joints: usize) -> Clip {
    Clip::new(ClipSource { name: "turns".into(), tracks }, &chain(joints)).unwrap()
}

/// The product of both rotations of the source, at the first joint.
fn product(_: RowPlace, pose: &[Local]) -> Vec<Local> {
    let mut poses = vec![pose[0]; 2];
    poses[0].rotation = (pose[0].rotation * pose[1].rotation).normalize();
    poses[1].rotation = DQuat::IDENTITY;
    poses
}

#[test]
fn products_of_rotations_get_rows_between_those_of_the_clip() {
    let linear = Interpolation::Linear;
    let (a, b) = ([0.0, 0.4, 0.1], [0.0, 0.3, -0.2]);
    let source = clip(vec![turns(0, DVec3::X, linear, &a), turns(1, DVec3::Z, linear, &b)], 2);
    let converted = source.converted(&chain(2), vec![[true; 3]; 2], product);
    assert!(converted.row_count() > 2 * source.row_count(), "{}", converted.row_count());
    assert_eq!(converted.duration_secs(), source.duration_secs());
    let stats = converted.stats();
    assert!(stats.error_bound_m <= stats.tolerance_m, "{stats:?}");
    let rotations = |clip: &Clip, secs: f64| {
        let times = &clip.rows.times;
        let row = times.partition_point(|t| f64::from(*t) <= secs).max(1) - 1;
        let [from, to] =
            [row, (row + 1).min(times.len() - 1)].map(|row: usize| f64::from(times[row]));
        let u = if to > from { (secs - from) / (to - from) } else { 0.0 };
        [0, 1].map(|joint| clip.rows.local(JointIndex(joint), row, u).rotation)
    };
    for at in 0..=1000 {
        let secs = 0.0004 * f64::from(at);
        let [first, second] = rotations(&source, secs);
        let [found, _] = rotations(&converted, secs);
        // The second joint, half a metre away, moves most.
        let off_m = (first * second * BONE).distance(found * BONE);
        let allowed_m = f64::from(stats.tolerance_m);
        assert!(off_m <= allowed_m, "off by {off_m} m at {secs} s, {allowed_m} m is allowed");
    }
}

#[test]
fn jumps_and_constants_stay() {
    let step = turns(0, DVec3::X, Interpolation::Step, &[0.0, 1.0, 0.2]);
    let source = clip(vec![step], 2);
    let converted = source.converted(&chain(2), vec![[true; 3]; 2], product);
    assert_eq!(converted.rows.times, source.rows.times);
    let angle = |row| converted.rows.local(JointIndex(0), row, 0.0).rotation.to_scaled_axis().x;
    // Before and after each jump.
    for (row, wanted) in [0.0, 0.0, 1.0, 1.0, 0.2].into_iter().enumerate() {
        assert!((angle(row) - wanted).abs() < 1e-3, "row {row}: {}", angle(row));
    }
    assert!(converted.ranges()[1].iter().all(|range| range.step == 0.0));
}

#[test]
fn arranged_columns_keep_their_values() {
    // 40 joints of which the last third moves so far that it is stored as floats.
    let joints = 40;
    let mut tracks: Vec<_> = (0..joints)
        .map(|i| turns(i, DVec3::Z, Interpolation::Linear, &[0.0, 0.01 * i as f64, -0.02, 0.1]))
        .collect();
    for track in &mut tracks[30..] {
        *track = Track {
            property: Property::Translation,
            times: vec![0.0, 0.2, 0.6],
            values: [[-900.0; 3], [0.1; 3], [900.0; 3]].concat(),
            ..track.clone()
        };
    }
    let source = clip(tracks, joints);
    let floats = |clip: &Clip| {
        let lanes = clip.row_blocks().iter().map(|block| block.translation_lanes);
        lanes.filter(|lanes| lanes & crate::ROW_FLOATS != 0).count()
    };
    assert!(floats(&source) > 0, "the test needs floats");
    // The other way round, without every seventh, and with one joint more.
    let other = chain(joints + 1);
    let columns: Vec<Option<JointIndex>> =
        (0..=40).map(|i| (i < 40 && i % 7 != 0).then(|| JointIndex(39 - i))).collect();
    let arranged = source.arranged(&other, &columns);
    assert_eq!(arranged.rows.times, source.rows.times);
    for row in 0..source.row_count() {
        for joint in other.joints() {
            let found = arranged.rows.local(joint, row, 0.0);
            let wanted = match columns[joint.index()] {
                Some(from) => {
                    let (from, rest) =
                        (source.rows.local(from, row, 0.0), Local::of(other.rest(joint)));
                    let moves = source
                        .drives_property(columns[joint.index()].unwrap(), Property::Translation);
                    Local {
                        translation: if moves { from.translation } else { rest.translation },
                        ..from
                    }
                }
                None => Local::of(other.rest(joint)),
            };
            let off = (found.translation - wanted.translation).length()
                + (found.rotation - wanted.rotation).length();
            // Numbers that become floats are rounded once.
            let size = 1.0 + wanted.translation.length();
            assert!(off <= size * 1.2e-7, "row {row}, joint {joint:?}: {off:e}");
        }
    }
}
