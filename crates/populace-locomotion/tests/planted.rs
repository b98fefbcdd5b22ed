//! Members that the caller moves, with planted feet: their hips stay up, and they find their stance.

#![expect(clippy::unwrap_used, reason = "tests panic on errors")]

use std::sync::Arc;

use populace::clip::MotionSettings;
use populace::model::{Role, Side};
use populace::{
    Affine, CharacterId, ClipId, ClipPlayback, Crowd, Device, JointIndex, MemberId, Placement,
};
use populace_cast::Look;
use populace_locomotion::{Gait, GaitSpace};

const FRAME_SECS: f32 = 1.0 / 60.0;
/// The speed at which the built-in man's clip walks, in metres per second.
const SPEED: f32 = 1.31;
/// The least height of the man's hips in that clip, and how much lower planted feet may take hips.
const LOWEST_IN_WALK_M: f32 = 0.919;
const MOST_SINK_M: f32 = 0.03;
/// How much lower they may take hips at a start, at which a foot that is known to stand holds longer.
const MOST_SINK_AT_START_M: f32 = 0.08;

struct Street {
    crowd: Crowd,
    person: CharacterId,
    member: MemberId,
    along_m: f32,
    speed: f32,
}

impl Street {
    fn new(look: &Look, is_measured: bool) -> Self {
        let mut crowd = Crowd::builder().device(Device::Native { threads: 1 }).build().unwrap();
        let person = crowd.add_character(populace_cast::person(look).unwrap()).unwrap();
        if is_measured {
            GaitSpace::of(&mut crowd, person).unwrap();
        }
        let member = crowd.spawn(person, Placement::at([0.0; 3])).unwrap();
        crowd.member_mut(member).unwrap().plant_feet(1.0).unwrap();
        Self { crowd, person, member, along_m: 0.0, speed: 0.0 }
    }

    fn clip(&self, name: &str) -> ClipId {
        self.crowd.clip(self.person, name).unwrap()
    }

    fn joint(&self, role: Role) -> JointIndex {
        self.crowd.member(self.member).unwrap().joint(role).unwrap()
    }

    /// Where a joint is in the world.
    fn place(&mut self, joint: JointIndex) -> [f32; 3] {
        let mut model = [Affine::IDENTITY];
        self.crowd.read_joints(&[(self.member, joint)], &mut model).unwrap();
        let placement = self.crowd.member(self.member).unwrap().placement();
        placement.world_from_model().mul(&model[0]).origin()
    }

    /// Returns the least and the greatest height of the hips in some frames.
    fn hips_over(&mut self, frames: u32, mut each: impl FnMut(&mut Self)) -> [f32; 2] {
        let hips = self.joint(Role::Hips);
        let (mut least, mut most) = (f32::MAX, f32::MIN);
        for _ in 0..frames {
            each(self);
            self.crowd.update(FRAME_SECS).unwrap();
            let height = self.place(hips)[1];
            (least, most) = (least.min(height), most.max(height));
        }
        [least, most]
    }

    /// Moves the member on as a controller does that gains or loses 4 metres per second in one.
    fn drive(&mut self, to: f32) {
        let gain = 4.0 * FRAME_SECS;
        self.speed += (to - self.speed).clamp(-gain, gain);
        self.along_m += self.speed * FRAME_SECS;
        let placement = Placement::at([0.0, 0.0, self.along_m]);
        self.crowd.member_mut(self.member).unwrap().set_placement(placement).unwrap();
    }

    fn walk_with_root_motion(&mut self) -> ClipId {
        let clips = self.crowd.character(self.person).unwrap().clips();
        let (_, walk) = clips.into_iter().find(|(_, clip)| clip.name() == "Walk").unwrap();
        let walk = Arc::new(walk.with_root_motion(&MotionSettings::default()).unwrap());
        self.crowd.character_mut(self.person).unwrap().add_clip(&walk).unwrap()
    }

    /// Measures the contacts of the clip that walks, and sets them for another clip.
    fn tell_contacts(&mut self, of: ClipId) {
        let body = self.crowd.character(self.person).unwrap().asset().clone();
        let walk = body.clips.iter().find(|clip| clip.name() == "Walk").unwrap();
        let gait = Gait::measure(&body, walk).unwrap().unwrap();
        gait.set_contacts(&mut self.crowd, self.person, of).unwrap();
    }

    fn fade_to(&mut self, name: &str) {
        let clip = self.clip(name);
        self.crowd.member_mut(self.member).unwrap().crossfade(clip, 0.25).unwrap();
    }
}

#[test]
fn contacts_can_be_told_for_a_clip_with_root_motion() {
    let least = [false, true].map(|is_told| {
        let mut street = Street::new(&Look::man(), false);
        let walk = street.walk_with_root_motion();
        if is_told {
            street.tell_contacts(walk);
        }
        let mut member = street.crowd.member_mut(street.member).unwrap();
        member.play(walk, ClipPlayback::looping()).unwrap();
        member.start_root_motion().unwrap();
        street.hips_over(180, |_| ());
        street.hips_over(300, |_| ())[0]
    });
    assert!(least[1] > LOWEST_IN_WALK_M - 0.012 && least[0] < least[1], "{least:?}");
}

/// Without contacts a foot is planted by the height of its ankle alone, and often too early.
#[test]
fn hips_of_a_walk_without_contacts_sink_little() {
    for look in [Look::man(), Look::woman(), Look::child()] {
        let [[unplanted, _], [planted, _]] = [0.0, 1.0].map(|weight| {
            let mut street = Street::new(&look, false);
            let walk = street.walk_with_root_motion();
            let mut member = street.crowd.member_mut(street.member).unwrap();
            member.plant_feet(weight).unwrap();
            member.play(walk, ClipPlayback::looping()).unwrap();
            member.start_root_motion().unwrap();
            street.hips_over(180, |_| ());
            street.hips_over(300, |_| ())
        });
        assert!(planted > unplanted - MOST_SINK_M, "{planted} m, {unplanted} m in the clip");
    }
}

/// The foot that happens to stand at a start does not hold the body back, and a stop in the middle
/// of a step does not leave the legs apart.
#[test]
fn hips_sink_little_at_starts_and_feet_find_their_stance_after_stops() {
    for (is_measured, late_frames) in [(false, 0), (true, 0), (true, 6)] {
        let mut street = Street::new(&Look::man(), is_measured);
        let (idle, playback) = (street.clip("Idle"), ClipPlayback::looping());
        street.crowd.member_mut(street.member).unwrap().play(idle, playback).unwrap();
        let [stands, _] = street.hips_over(60, |_| ());
        let [late, _] = street.hips_over(late_frames, |street| street.drive(SPEED));
        street.fade_to("Walk");
        let [starts, _] = street.hips_over(270 - late_frames, |street| street.drive(SPEED));
        street.fade_to("Idle");
        street.hips_over(240, |street| street.drive(0.0));
        let [rests, _] = street.hips_over(180, |street| street.drive(0.0));
        let least = starts.min(late);
        let sink = if is_measured { MOST_SINK_AT_START_M } else { MOST_SINK_M };
        assert!(least > LOWEST_IN_WALK_M - sink, "{least} m: {is_measured} {late_frames}");
        assert!(rests > stands - 0.003, "{rests} m, {stands} m at first: {is_measured}");
        let hips = street.joint(Role::Hips);
        let [_, _, middle] = street.place(hips);
        for side in [Side::Left, Side::Right] {
            let ankle = street.joint(Role::Foot(side));
            let ahead = street.place(ankle)[2] - middle;
            assert!(ahead.abs() < 0.1, "{ahead} m: {is_measured} {late_frames}");
        }
    }
}
