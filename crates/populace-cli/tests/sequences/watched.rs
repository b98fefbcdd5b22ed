//! Members that no random call reaches, and what must be true of them however long a crowd lives.

use populace::{Affine, ClipPlayback, Crowd, Error, Ground, JointIndex, MemberId, Placement, Trs};

use crate::world::{ARM, PERSON, World};

/// Number of each kind of watched members.
const COUNT: usize = 24;
/// Slope of the ground along x, so that feet have different heights.
const SLOPE: f32 = 0.1;
/// The joint of the hand that holds something, and the feet, of a person made by code.
const HAND: &str = "RightHand";
const FEET: [&str; 2] = ["LeftFoot", "RightFoot"];
/// What is held lies so in the hand.
const OFFSET: Trs = Trs {
    translation: [0.1, -0.05, 0.2],
    rotation: [0.48, 0.0, 0.6, 0.64],
    scale: [0.5, 0.5, 0.5],
};

/// Largest errors, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Drift {
    /// Of things from the hands that hold them.
    pub(crate) held_m: f32,
    /// Of planted feet from where they stood at first.
    pub(crate) planted_m: f32,
}

impl Drift {
    /// Largest errors that are no drift: rounding, and the ease of a foot's lock.
    pub(crate) const MOST: Self = Self { held_m: 1e-5, planted_m: 1e-3 };

    pub(crate) fn worst(self, other: Self) -> Self {
        Self {
            held_m: self.held_m.max(other.held_m),
            planted_m: self.planted_m.max(other.planted_m),
        }
    }

    /// Returns whether the errors are at most `most`; NaN is not.
    pub(crate) fn is_within(self, most: Self) -> bool {
        self.held_m <= most.held_m && self.planted_m <= most.planted_m
    }
}

/// Walkers that hold something, and people who stand on planted feet.
pub(crate) struct Watched {
    walkers: Vec<(MemberId, MemberId)>,
    standing: Vec<MemberId>,
    /// Where feet stood when they were looked at first.
    stood: Vec<[f32; 3]>,
    hand: JointIndex,
    feet: [JointIndex; 2],
    /// The root of what is held.
    root: Affine,
}

impl Watched {
    pub(crate) fn spawn(world: &mut World) -> Result<Self, Error> {
        world.crowd.set_ground(&Ground::plane(0.0, [SLOPE, 0.0])?)?;
        let (person, arm) = (world.bodies[PERSON].id, world.bodies[ARM].id);
        let [walk, idle] = ["Walk", "Idle"].map(|name| world.crowd.clip(person, name));
        let (walk, idle) = (walk?, idle?);
        let crowd = &mut world.crowd;
        let skeleton = crowd.character(person)?.asset().skeleton.clone();
        let joint = |name: &str| {
            skeleton.find(name).unwrap_or_else(|| panic!("people have a joint {name}"))
        };
        let (hand, feet) = (joint(HAND), FEET.map(joint));
        let rest = *crowd.character(arm)?.asset().skeleton.rest(JointIndex(0));
        let (mut walkers, mut standing) = (Vec::new(), Vec::new());
        for nth in 0..COUNT {
            let at = |z: f32| {
                let x = nth as f32;
                Placement::at([x, SLOPE * x, z]).facing(0.3 * x)
            };
            let [walker, held] = [crowd.spawn(person, at(50.0))?, crowd.spawn(arm, at(50.0))?];
            let phase = nth as f32 / COUNT as f32;
            crowd.member_mut(walker)?.play(walk, ClipPlayback::looping().phase(phase))?;
            crowd.member_mut(held)?.attach_to(walker, hand, OFFSET)?;
            walkers.push((walker, held));
            let stander = crowd.spawn(person, at(60.0))?;
            crowd.member_mut(stander)?.play(idle, ClipPlayback::looping().phase(phase))?;
            crowd.member_mut(stander)?.plant_feet(1.0)?;
            standing.push(stander);
        }
        let root = Affine::from_trs(&rest);
        Ok(Self { walkers, standing, stood: Vec::new(), hand, feet, root })
    }

    /// Returns the errors now. The first call remembers where feet stand.
    pub(crate) fn drift(&mut self, crowd: &mut Crowd) -> Result<Drift, Error> {
        let mut drift = Drift::default();
        for (walker, held) in &self.walkers {
            let hand = crowd.member_mut(*walker)?.model_from_joints()?[self.hand.index()];
            let wanted = hand.mul(&Affine::from_trs(&OFFSET)).mul(&self.root);
            let found = crowd.member_mut(*held)?.model_from_joints()?[0];
            let pairs = wanted.rows.into_iter().flatten().zip(found.rows.into_iter().flatten());
            let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, largest);
            drift.held_m = largest(drift.held_m, error);
        }
        let mut stand = Vec::new();
        for stander in &self.standing {
            let mut member = crowd.member_mut(*stander)?;
            let world = member.placement().world_from_model();
            let joints = member.model_from_joints()?;
            let foot = |foot: JointIndex| {
                let rows = joints[foot.index()].rows;
                world.transform_point([rows[0][3], rows[1][3], rows[2][3]])
            };
            stand.extend(self.feet.map(foot));
        }
        if self.stood.is_empty() {
            self.stood.clone_from(&stand);
        }
        let far = |(a, b): (&[f32; 3], &[f32; 3])| {
            let [x, y, z] = [0, 1, 2].map(|axis| a[axis] - b[axis]);
            x.hypot(y).hypot(z)
        };
        drift.planted_m = self.stood.iter().zip(&stand).map(far).fold(0.0, largest);
        Ok(drift)
    }
}

/// Returns the larger number, or NaN if one is NaN.
fn largest(a: f32, b: f32) -> f32 {
    if a.is_nan() || b.is_nan() { f32::NAN } else { a.max(b) }
}
