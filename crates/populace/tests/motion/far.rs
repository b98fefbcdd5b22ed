//! Root motion over long times and long ways.

use populace::{History, MemberId};

use super::fixture::{Scene, everywhere};
use super::{add, straight, walker};

fn z(scene: &mut Scene, member: MemberId) -> f64 {
    scene.edit(member).moved_placement().expect("a member").position()[2].into()
}

#[test]
fn long_updates_move_members_all_the_way() {
    for secs in [6_087.0_f32, 6_200.0, 20_000.0, 1e6] {
        everywhere(|scene| {
            let (_, walk) = add(scene, straight("walk ahead", 0.3));
            let member = walker(scene, walk);
            scene.update(1.0);
            let before = z(scene, member);
            scene.update(secs);
            let (way, wanted) = (z(scene, member) - before, f64::from(secs) * 0.3);
            assert!((way / wanted - 1.0).abs() < 1e-5, "{way} of {wanted} m in {secs} s");
            assert!((scene.crowd.time_secs() - 1.0 - f64::from(secs)).abs() < 1e-3);
            scene.update(1.0);
        });
    }
}

#[test]
fn jumps_say_that_they_move_members_no_farther_than_a_frame_can() {
    everywhere(|scene| {
        let (_, walk) = add(scene, straight("walk ahead", 0.3));
        let member = walker(scene, walk);
        let report = scene.crowd.seek(6_000.0).expect("a time");
        assert!(report.inexact.is_empty(), "{report:?}");
        assert!((z(scene, member) - 1_800.0).abs() < 0.01);
        let report = scene.crowd.seek(20_000.0).expect("a time");
        assert_eq!(report.inexact, [(History::RootMotion, vec![member])]);
    });
}

#[test]
fn many_small_moves_add_up() {
    everywhere(|scene| {
        // In single precision, 30,000 m are told to within 2 mm: half of that is lost or gained by
        // each frame.
        let (_, walk) = add(scene, straight("walk ahead", 5.0));
        let member = walker(scene, walk);
        scene.update(6_000.0);
        let before = z(scene, member);
        for _ in 0..2_000 {
            scene.update(1.0 / 144.0);
        }
        let (way, secs) = (z(scene, member) - before, scene.crowd.time_secs() - 6_000.0);
        assert!((way - 5.0 * secs).abs() < 0.01, "{way} of {} m", 5.0 * secs);
    });
}
