//! Strides of the built-in people against a published curve.

#![expect(clippy::disallowed_methods, reason = "the curve is for the test alone")]

use populace::{Crowd, Device};
use populace_locomotion::GaitSpace;

/// Height of the people that the curve is of, in metres.
const HEIGHT_M: f32 = 1.7;
/// Smaller bodies are children; the curve is of adults.
const ADULT_M: f32 = 1.5;
/// Step length divided by cadence, in metres per step a minute, of people who walk at 62 m/min or
/// faster (N. Sekiya, H. Nagasaki, "Reproducibility of the walking patterns of normal young adults",
/// Gait & Posture 7 (1998), 225-227).
const WALK_RATIO: f32 = 0.0064;
/// The speed below which that ratio is not kept, in metres per second (R. Murakami, Y. Otaka,
/// "Estimated lower speed boundary at which the walk ratio constancy is broken in healthy adults",
/// J. Physical Therapy Science 29 (2017), 722-725). Below it steps shorten with the power 0.42 of
/// the speed (D. W. Grieve 1968).
const BROKEN_AT: f32 = 62.0 / 60.0;

/// Returns the length of a stride at a speed, in metres, of a body of a height. Bodies of other
/// heights walk alike at equal Froude numbers.
fn published(speed: f32, height_m: f32) -> f32 {
    let scale = height_m / HEIGHT_M;
    let speed = speed / scale.sqrt();
    let kept = |speed: f32| 2.0 * (WALK_RATIO * 60.0 * speed).sqrt();
    let stride = if speed < BROKEN_AT {
        kept(BROKEN_AT) * (speed / BROKEN_AT).powf(0.42)
    } else {
        kept(speed)
    };
    stride * scale
}

#[test]
fn strides_of_adults_follow_a_published_curve() {
    let people = populace_cast::cast().expect("people").into_iter();
    for character in people.filter(|character| character.height_m() > ADULT_M) {
        let (name, height_m) = (character.name.clone(), character.height_m());
        let builder = Crowd::builder().device(Device::native()).capacity(1);
        let mut crowd = builder.build().expect("a crowd");
        let id = crowd.add_character(character).expect("enough memory");
        let gaits = GaitSpace::of(&mut crowd, id).expect("clips that walk");
        for tenths in 4_u8..=18 {
            let speed = f32::from(tenths) / 10.0;
            let stride = speed / gaits.at_speed(speed).cycles_per_sec;
            let apart = stride / published(speed, height_m) - 1.0;
            assert!(apart.abs() < 0.1, "{name}: {stride} m at {speed} m/s, {apart} apart");
        }
    }
}

/// Stance of a leg, in heights of the body: a foot that stands passes from a little less than 0.7
/// leg lengths ahead of the hip to as far behind it, and rolls over its length.
const STANCE: f32 = 0.75;
/// The contact of the run, as a part of its cycle.
const RUN_STANDS: f32 = 0.38;

#[test]
fn beyond_the_fastest_clip_contacts_stay_within_reach_of_the_legs() {
    for character in populace_cast::cast().expect("people") {
        let (name, height_m) = (character.name.clone(), character.height_m());
        let builder = Crowd::builder().device(Device::native()).capacity(1);
        let mut crowd = builder.build().expect("a crowd");
        let id = crowd.add_character(character).expect("enough memory");
        let gaits = GaitSpace::of(&mut crowd, id).expect("clips that walk");
        let [_, fastest] = gaits.speeds_m_per_sec();
        let step = gaits.at_speed(2.9 * fastest);
        let stance = RUN_STANDS * 2.9 * fastest / step.cycles_per_sec;
        assert!(stance < STANCE * height_m, "{name}: {stance} m of {height_m}");
    }
}
