//! Layers and crossfades against the oracle.

use populace::clip::TICKS_PER_SEC;
use populace::{
    ClipPlayback, Crowd, CrowdBuilder, LayerMode, LayerSettings, Mask, MemberId, Placement,
};
use populace_testkit::oracle::{OracleBody, OracleLayer, OracleSlot, evaluate};

use crate::fixture::{JOINTS, Motion, crowd_of, moving};
use crate::on_every_device;

/// Tolerance in rotation components and metres: 16-bit rows over angles of up to a radian, and the
/// linear interpolation between dense keys.
const TOLERANCE: f64 = 2e-4;

fn motions() -> Vec<Motion> {
    moving(32, |joint, nth, phase| 0.3 * (joint + nth) * 0.3 + 0.4 * f32::sin(phase + joint * nth))
}

/// Compares a member's joints with the oracle's, which evaluates the active clips of the member.
#[track_caller]
fn assert_matches_oracle(crowd: &mut Crowd, member: MemberId, layers: &[OracleLayer]) {
    let id = crowd.member(member).unwrap().character();
    let clips = crowd.character(id).unwrap().clips();
    let body = OracleBody::from_character(crowd.character(id).unwrap().asset());
    let playing = crowd.member(member).unwrap().active_clips();
    let slots: Vec<_> = playing
        .iter()
        .map(|p| OracleSlot {
            retarget: None,
            clip: clips.iter().find(|(clip, _)| *clip == p.clip).unwrap().1.source(),
            time_secs: f64::from(p.time_secs),
            weight: f64::from(p.weight),
            layer: p.layer,
        })
        .collect();
    let wanted = evaluate(&body, &slots, layers).model_from_joint;
    for (joint, (found, wanted)) in crowd
        .member_mut(member)
        .unwrap()
        .model_from_joints()
        .unwrap()
        .iter()
        .zip(&wanted)
        .enumerate()
    {
        let wanted = glam::DMat4::from(*wanted).transpose().to_cols_array();
        for (found, wanted) in found.rows.as_flattened().iter().zip(wanted) {
            let off = (f64::from(*found) - wanted).abs();
            assert!(off < TOLERANCE, "joint {joint} is off by {off} with {} clips", slots.len());
        }
    }
}

fn layers_with_masks_agree_with_the_oracle(builder: &CrowdBuilder) {
    let (mut crowd, id, clips) = crowd_of(&builder.clone().slots_per_member(8), &motions());
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    let skeleton = crowd.character(id).unwrap().asset().skeleton.clone();
    let fading =
        Mask::of_subtrees(&skeleton, ["joint 1"]).unwrap().with_falloff(&skeleton, 3).unwrap();
    let all_but = Mask::of_joints(&skeleton, ["joint 2"]).unwrap().inverted();
    let wide = |mask: &Mask| Some(mask.weights().iter().map(|w| f64::from(*w)).collect());
    let layers = [
        OracleLayer::default(),
        OracleLayer { mode: LayerMode::Override, weight: 0.75, mask: wide(&fading) },
        OracleLayer { mode: LayerMode::Additive, weight: 0.5, mask: wide(&all_but) },
        OracleLayer { mode: LayerMode::Override, weight: 0.25, mask: None },
    ];
    let masks = [
        None,
        Some(crowd.character_mut(id).unwrap().add_mask(&fading).unwrap()),
        Some(crowd.character_mut(id).unwrap().add_mask(&all_but).unwrap()),
        None,
    ];
    for (index, (layer, mask)) in layers.iter().zip(masks).enumerate().skip(1) {
        let settings = LayerSettings { mode: layer.mode, weight: layer.weight as f32 };
        crowd.member_mut(member).unwrap().set_layer(index, settings, mask).unwrap();
    }
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    for step in 0..60 {
        let clip = clips[step % 4];
        let play = ClipPlayback::looping()
            .fade_in_secs(0.3)
            .on_layer(step % 4)
            .phase(0.1)
            .speed(if step % 3 == 0 { -0.7 } else { 1.2 });
        match step % 7 {
            0 | 3 => drop(crowd.member_mut(member).unwrap().play(clip, play).unwrap()),
            1 => drop(crowd.member_mut(member).unwrap().blend(clip, play.weight(0.4)).unwrap()),
            2 => drop(crowd.member_mut(member).unwrap().queue(clip, play).unwrap()),
            5 => {
                let over = ClipPlayback::once().on_layer(2).fade_in_secs(0.1);
                let _ = crowd.member_mut(member).unwrap().play(clip, over).unwrap();
            }
            _ => {}
        }
        crowd.update(0.07).unwrap();
        assert_matches_oracle(&mut crowd, member, &layers);
    }
}

/// A crossfade is linear, and clips that already fade out keep their proportion.
fn crossfades_agree_with_the_oracle(builder: &CrowdBuilder) {
    let (mut crowd, id, clips) = crowd_of(builder, &motions());
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.2).unwrap();
    crowd.member_mut(member).unwrap().crossfade(clips[1], 0.4).unwrap();
    crowd.update(0.1).unwrap();
    crowd.member_mut(member).unwrap().crossfade(clips[2], 0.8).unwrap();
    for quarter in 0..=4_u8 {
        let new = f64::from(quarter) / 4.0;
        let wanted = [0.75 * (1.0 - new), 0.25 * (1.0 - new), new];
        for (clip, wanted) in clips.iter().zip(wanted) {
            let playing = crowd.member(member).unwrap().active_clips();
            let found = playing.iter().find(|p| p.clip == *clip).map_or(0.0, |p| p.weight);
            assert!(
                (f64::from(found) - wanted).abs() < 1e-5,
                "the weight is {found}, not {wanted}"
            );
        }
        crowd.update(0.0).unwrap();
        assert_matches_oracle(&mut crowd, member, &[]);
        crowd.update(0.2).unwrap();
    }
    assert_eq!(TICKS_PER_SEC % 5, 0, "a fifth of a second is not a whole number of ticks");
    assert_eq!(crowd.member_mut(member).unwrap().model_from_joints().unwrap().len(), JOINTS);
}

on_every_device!(layers_with_masks_agree_with_the_oracle, crossfades_agree_with_the_oracle);
