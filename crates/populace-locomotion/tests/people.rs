//! Gaits of the people made by code, against the published figures that they were made from
//! (`motion/gait.rs` of populace-cast).

use std::sync::Arc;

use populace::model::Side;
use populace_cast::cast;
use populace_locomotion::Gait;

/// Speed in metres per second and length of the cycle in seconds of a body of 1.75 m.
const WALK: (f32, f32) = (1.3, 1.03);
const RUN: (f32, f32) = (2.9, 0.72);
/// The shares of the cycle in which a foot stands.
const WALK_STANDS: f32 = 0.60;
const RUN_STANDS: f32 = 0.36;

fn near(found: f32, wanted: f32, tolerance: f32) -> bool {
    (found - wanted).abs() <= tolerance
}

#[test]
fn gaits_are_those_that_people_were_made_from() {
    for person in cast().unwrap().into_iter().map(Arc::new) {
        let gait = |name: &str| {
            let clip = person.clips.iter().find(|clip| clip.name() == name).unwrap();
            Gait::measure(&person, clip).unwrap().unwrap()
        };
        let (walk, run) = (gait("Walk"), gait("Run"));
        let name = &person.name;
        // By the root of the leg's length and by pace both gaits are faster alike.
        let faster = walk.speed_m_per_sec() / WALK.0;
        assert!((0.7..1.2).contains(&faster), "{name}: {walk:?}");
        assert!(near(run.speed_m_per_sec() / RUN.0, faster, 0.02), "{name}: {faster} {run:?}");
        assert!(near(run.duration_secs / RUN.1, walk.duration_secs / WALK.1, 1e-3), "{name}");
        for (gait, stands) in [(&walk, WALK_STANDS), (&run, RUN_STANDS)] {
            for (nth, foot) in [Side::Left, Side::Right].into_iter().enumerate() {
                assert!(near(gait.contact_share_of(foot), stands, 0.06), "{name}: {gait:?}");
                assert!(near(gait.sole_height_m[nth].unwrap(), 0.0, 3e-3), "{name}: {gait:?}");
            }
            assert!(near(gait.velocity_m_per_sec[0], 0.0, 0.02), "{name}: {gait:?}");
            assert!(gait.skate_m_per_sec < 0.05 * gait.speed_m_per_sec(), "{name}: {gait:?}");
            assert_eq!(gait.step_count(), 2, "{name}: {gait:?}");
            let apart = gait.contacts[1].from_secs - gait.contacts[0].from_secs;
            assert!(near(apart / gait.duration_secs, 0.5, 0.05), "{name}: {gait:?}");
        }
        for idle in ["Idle", "Idle_Shift"].map(gait) {
            assert_eq!((idle.step_count(), idle.contact_share()), (0, 1.0), "{name}: {idle:?}");
            assert!(idle.speed_m_per_sec() < 0.01, "{name}: {idle:?}");
        }
    }
}
