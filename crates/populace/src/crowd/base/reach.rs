//! How far a body reaches in the poses that its clips give it.

use populace_clip::Range;
use populace_model::Skeleton;
use populace_model::convert::single;
use populace_retarget::Binding;

/// Steps of a row's 16-bit numbers.
const ROW_STEPS: f32 = 65_535.0;
/// Growth of a sphere, for what foot constraints lower the body by.
const MARGIN: f32 = 1.1;
/// The largest radius in metres, as far as joints can be. Products of scales along chains of joints
/// are larger in the worst case, which no pose comes to.
const LARGEST_M: f32 = 1e18;
const AXES: [usize; 3] = [0, 1, 2];

/// A sphere around a body in every pose that its clips can give it, in model space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::crowd) struct Reach {
    /// Height of the centre, above the model's origin, in metres.
    pub(in crate::crowd) height_m: f32,
    pub(in crate::crowd) radius_m: f32,
}

impl Reach {
    /// Returns the reach of a body whose joints only rotate.
    pub(super) fn at_rest(skeleton: &Skeleton) -> Self {
        let joints: Vec<_> = skeleton.joints().collect();
        Self::of(skeleton, |joint| {
            let scales = skeleton.rest(joints[joint]).scale.map(f32::abs);
            Freedom { shift: 0.0, turn: 0.0, scales: [scales; 2] }
        })
    }

    /// Returns the reach of a body that plays a clip.
    pub(super) fn with_clip(skeleton: &Skeleton, binding: &Binding) -> Self {
        let ranges = binding.ranges();
        let joints: Vec<_> = skeleton.joints().collect();
        Self::of(skeleton, |joint| {
            let [translation, rotation, scale] = ranges[joint];
            let at_rest = skeleton.rest(joints[joint]);
            let rest = at_rest.translation;
            let spread = |range: Range| 0.5 * range.step * ROW_STEPS;
            let shift = AXES
                .map(|axis| (translation.offset[axis] - rest[axis]).abs() + spread(translation));
            let middle = AXES.map(|axis| scale.offset[axis].abs());
            let least = middle.map(|middle| (middle - spread(scale)).max(0.0));
            let greatest = middle.map(|middle| middle + spread(scale));
            let turn = turn_within(at_rest.rotation, rotation.offset, spread(rotation));
            Freedom { shift: length(shift), turn, scales: [least, greatest] }
        })
    }

    fn of(skeleton: &Skeleton, freedom: impl Fn(usize) -> Freedom) -> Self {
        let joints: Vec<_> = skeleton.joints().collect();
        let parents: Vec<Option<usize>> = joints
            .iter()
            .map(|joint| skeleton.parent(*joint).map(|parent| parent.index()))
            .collect();
        let free: Vec<_> = (0..joints.len()).map(freedom).collect();
        let mut stretches: Vec<Stretch> = Vec::with_capacity(joints.len());
        for (joint, parent) in parents.iter().enumerate() {
            let above = parent.map_or(Stretch::NONE, |parent| stretches[parent]);
            let rest = skeleton.rest(joints[joint]).scale;
            stretches.push(above.with_joint(rest, free[joint].scales));
        }
        // The joint where the body branches: all else hangs from it.
        let children = |joint: usize| parents.iter().filter(|p| **p == Some(joint)).count();
        let center = (0..joints.len()).find(|joint| children(*joint) != 1).unwrap_or_default();
        let models = skeleton.rest_models();
        let at = |joint: usize| {
            models.get(joint).map_or([0.0; 3], |m| m.translation.to_array().map(single))
        };
        let between = |a: usize, b: usize| length(AXES.map(|axis| at(a)[axis] - at(b)[axis]));
        // The most by which the centre leaves its place at rest.
        let mut away = 0.0;
        let mut next = Some(center);
        while let Some(joint) = next {
            next = parents[joint];
            away += match next {
                Some(parent) => stretches[parent].change(between(joint, parent), &free[joint]),
                None => free[joint].shift,
            };
            away += free[joint].turn * stretches[joint].own[1] * between(joint, center);
        }
        // Length of the chain from the centre to each joint, at most.
        let mut chains = vec![0.0_f32; joints.len()];
        let mut most = 0.0_f32;
        for joint in 0..joints.len() {
            chains[joint] = match parents[joint] {
                _ if joint == center => 0.0,
                Some(parent) => {
                    let bone = between(joint, parent);
                    chains[parent] + stretches[parent].bone(bone, &free[joint])
                }
                // Another root: it is as far from the centre as at rest.
                None => between(joint, center) + free[joint].shift,
            };
            most = most.max(chains[joint] + stretches[joint].own[1] * skeleton.reach_m()[joint]);
        }
        let [x, y, z] = at(center);
        let aside = length([x, 0.0, z]);
        Self { height_m: y, radius_m: (MARGIN * (away + most + aside)).min(LARGEST_M) }
    }

    /// Returns a reach around both.
    pub(super) fn and(self, other: Self) -> Self {
        let apart = (self.height_m - other.height_m).abs();
        Self { radius_m: self.radius_m.max(other.radius_m + apart), ..self }
    }
}

/// How far a joint may leave its rest.
struct Freedom {
    /// The most by which it leaves its rest translation, in the space of its parent.
    shift: f32,
    /// The most by which its rotations move a point that is 1 m away.
    turn: f32,
    /// The least and the greatest scale along each axis, without signs.
    scales: [[f32; 3]; 2],
}

/// How the scales of a joint and of all above it change lengths.
#[derive(Clone, Copy)]
struct Stretch {
    /// The greatest length in model space of what is 1 long in the joint's space.
    scale: f32,
    /// The least and the greatest length of what moves with the joint, for each metre at rest.
    own: [f32; 2],
    /// The same below the joint. What lies along one axis of the joint at rest may turn to another.
    below: [f32; 2],
}

impl Stretch {
    const NONE: Self = Self { scale: 1.0, own: [1.0; 2], below: [1.0; 2] };

    /// Adds a joint below, of which the scales are given at rest and at their least and greatest.
    fn with_joint(self, rest: [f32; 3], [least, greatest]: [[f32; 3]; 2]) -> Self {
        // What is flat at rest tells nothing of its length.
        let rest = rest.map(|scale| if scale == 0.0 { 1.0 } else { scale.abs() });
        let by_rest = |scales: [f32; 3]| AXES.map(|axis| scales[axis] / rest[axis]);
        let [low, high] = self.below;
        Self {
            scale: self.scale * most_of(greatest),
            own: [low * least_of(by_rest(least)), high * most_of(by_rest(greatest))],
            below: [
                low * least_of(least) / most_of(rest),
                high * most_of(greatest) / least_of(rest),
            ],
        }
    }

    /// The greatest distance from the joint to a child, which is `bone` metres away at rest.
    fn bone(&self, bone: f32, child: &Freedom) -> f32 {
        self.own[1] * bone + self.scale * child.shift
    }

    /// The most by which that distance changes.
    fn change(&self, bone: f32, child: &Freedom) -> f32 {
        let [low, high] = self.own;
        (high - 1.0).max(1.0 - low) * bone + self.scale * child.shift
    }
}

/// Returns the most by which a rotation moves a point that is 1 m away from where it is at `rest`, if
/// the rotation's components lie within `spread` of those of `middle`.
fn turn_within(rest: [f32; 4], middle: [f32; 4], spread: f32) -> f32 {
    let apart = |sign: f32| {
        let differences = rest.iter().zip(middle).map(|(rest, middle)| sign * rest - middle);
        differences.fold(0.0, f32::hypot)
    };
    // A rotation by 2a moves the point by 2 sin(a), and its quaternion by 2 sin(a / 2).
    (2.0 * (apart(1.0).min(apart(-1.0)) + 2.0 * spread)).min(2.0)
}

fn least_of([x, y, z]: [f32; 3]) -> f32 {
    x.min(y).min(z)
}

fn most_of([x, y, z]: [f32; 3]) -> f32 {
    x.max(y).max(z)
}

fn length(v: [f32; 3]) -> f32 {
    v[0].hypot(v[1]).hypot(v[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use populace_clip::Clip;
    use populace_model::{ClipSource, Interpolation, JointSource, Property, Track, Trs};

    #[test]
    fn the_sphere_holds_a_movement_to_one_side() {
        let joint = |name: &str, parent, y| JointSource {
            name: name.into(),
            parent,
            rest: Trs { translation: [0.0, y, 0.0], ..Trs::IDENTITY },
        };
        let joints = [joint("root", None, 0.0), joint("hips", Some(0), 1.0)];
        let skeleton = Skeleton::new(&joints).unwrap();
        // From rest to 6 m along each axis.
        let track = Track {
            joint: "hips".into(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0],
            values: vec![0.0, 1.0, 0.0, -6.0, -5.0, -6.0],
        };
        let source = ClipSource { name: "sways".into(), tracks: vec![track] };
        let clip = Clip::new(source, &skeleton).unwrap();
        let reach = Reach::with_clip(&skeleton, &Binding::new(&clip, &skeleton));
        assert!(reach.radius_m >= 10.4, "{reach:?}");
        assert!(Reach::at_rest(&skeleton).radius_m < 2.0);
    }

    #[test]
    fn the_sphere_of_scales_that_undo_each_other_is_finite() {
        let joint = |n: usize| JointSource {
            name: format!("joint {n}"),
            parent: n.checked_sub(1),
            rest: Trs {
                translation: [0.0, 1.0, 0.0],
                scale: if n.is_multiple_of(2) { [1e5, 1.0, 1.0] } else { [1e-5, 1.0, 1.0] },
                ..Trs::IDENTITY
            },
        };
        let skeleton = Skeleton::new(&(0..12).map(joint).collect::<Vec<_>>()).unwrap();
        let radius_m = Reach::at_rest(&skeleton.with_reach(&[1.0; 12])).radius_m;
        assert!((12.0..=1e18).contains(&radius_m), "{radius_m}");
    }

    #[test]
    fn the_sphere_holds_a_body_that_a_root_on_the_ground_turns_over() {
        let joint = |name: &str, parent, y| JointSource {
            name: name.into(),
            parent,
            rest: Trs { translation: [0.0, y, 0.0], ..Trs::IDENTITY },
        };
        let joints = [
            joint("root", None, 0.0),
            joint("hips", Some(0), 1.0),
            joint("head", Some(1), 0.5),
            joint("foot", Some(1), -1.0),
        ];
        let skeleton = Skeleton::new(&joints).unwrap();
        let reach_of = |angle: f32| {
            let (sin, cos) = (0.5 * angle).sin_cos();
            let track = Track {
                joint: "root".into(),
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                times: vec![0.0, 1.0],
                values: vec![0.0, 0.0, 0.0, 1.0, sin, 0.0, 0.0, cos],
            };
            let source = ClipSource { name: "turns".into(), tracks: vec![track] };
            let clip = Clip::new(source, &skeleton).unwrap();
            Reach::with_clip(&skeleton, &Binding::new(&clip, &skeleton))
        };
        let rest = Reach::at_rest(&skeleton);
        assert!((reach_of(0.0).radius_m - rest.radius_m).abs() < 0.01);
        // The head is then 1.5 m below the ground, and the sphere's centre 1 m above.
        assert!(reach_of(std::f32::consts::PI).radius_m >= 2.5);
        let little = reach_of(0.1).radius_m - rest.radius_m;
        assert!((0.1..0.5).contains(&little), "{little}");
    }
}
