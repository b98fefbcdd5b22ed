//! Many members, each in a crossfade.

use std::collections::HashSet;

use populace::interop::PaletteSource;
use populace::{ClipPlayback, Crowd, CrowdBuilder, Placement};
use populace_device::layout::Float4;

use crate::fixture::{JOINTS, Motion, crowd_of};
use crate::on_every_device;

const MEMBERS: u16 = 10_000;

fn motions() -> Vec<Motion> {
    let motion = |nth: u8, name| Motion {
        name,
        duration_secs: 1.0,
        rotations: [0.5_f32, 1.0, 0.7, 0.9].map(|part| {
            let angles = (0..=8_u8).map(|key| part * f32::from(key) / 8.0 + 0.1 * f32::from(nth));
            ([1.0, 0.2 * f32::from(nth), 0.0], angles.collect())
        }),
    };
    vec![motion(0, "a"), motion(1, "b"), motion(2, "c")]
}

/// Returns the bits of all palettes, member by member.
fn palettes(crowd: &mut Crowd) -> Vec<Vec<[u32; 4]>> {
    let mut pages = Vec::new();
    for page in 0..crowd.page_lengths().len() {
        let mut keep = |elements: &[Float4]| pages.extend_from_slice(elements);
        crowd.with_page(page, &mut keep).unwrap();
    }
    let entries = |first: u32| &pages[first as usize * 3..][..JOINTS * 3];
    crowd
        .instances()
        .map(|i| entries(i.palette_first).iter().map(|e| e.0.map(f32::to_bits)).collect())
        .collect()
}

fn changing_one_of_10000_crossfading_members_affects_no_other(builder: &CrowdBuilder) {
    let (mut crowd, id, clips) = crowd_of(&builder.clone().capacity(MEMBERS.into()), &motions());
    let place = Placement::at([0.0; 3]);
    let members: Vec<_> = (0..MEMBERS).map(|_| crowd.spawn(id, place).unwrap()).collect();
    for (nth, &member) in (0..MEMBERS).zip(&members) {
        let phase = f32::from(nth) / f32::from(MEMBERS);
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[0], ClipPlayback::looping().phase(phase))
            .unwrap();
    }
    crowd.update(0.1).unwrap();
    for (nth, &member) in (0..MEMBERS).zip(&members) {
        let play = ClipPlayback::looping()
            .phase(f32::from(nth % 97) / 97.0)
            .fade_in_secs(0.5 + f32::from(nth % 31) * 0.1);
        crowd.member_mut(member).unwrap().play(clips[1 + usize::from(nth % 2)], play).unwrap();
    }
    crowd.update(0.25).unwrap();
    assert!(
        members.iter().all(|m| crowd.member(*m).unwrap().active_clips().len() == 2),
        "not all members are in a crossfade"
    );
    let before = palettes(&mut crowd);
    assert_eq!(
        before.iter().collect::<HashSet<_>>().len(),
        usize::from(MEMBERS),
        "two members have the same pose"
    );

    let changed = 4321;
    crowd
        .member_mut(members[changed])
        .unwrap()
        .play(clips[0], ClipPlayback::held_at_secs(0.9))
        .unwrap();
    crowd.update(0.0).unwrap();
    let after = palettes(&mut crowd);
    assert!(before[changed] != after[changed]);
    let others = before.iter().zip(&after).enumerate().filter(|(nth, _)| *nth != changed);
    assert!(
        others.into_iter().all(|(_, (before, after))| before == after),
        "another member changed"
    );
}

on_every_device!(changing_one_of_10000_crossfading_members_affects_no_other);
