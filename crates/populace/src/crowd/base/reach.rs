//! How far a body reaches in the poses that its clips give it.

use populace_model::Skeleton;
use populace_model::convert::single;
use populace_retarget::Binding;

/// Steps of a row's 16-bit numbers.
const ROW_STEPS: f32 = 65_535.0;
/// Growth of a sphere, for what foot constraints lower the body by.
const MARGIN: f32 = 1.1;

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
        Self::of(skeleton, |_| [0.0; 3])
    }

    /// Returns the reach of a body that plays a clip.
    pub(super) fn with_clip(skeleton: &Skeleton, binding: &Binding) -> Self {
        let ranges = binding.ranges();
        let joints: Vec<_> = skeleton.joints().collect();
        Self::of(skeleton, |joint| {
            let [translation, ..] = ranges[joint];
            let rest = skeleton.rest(joints[joint]).translation;
            let spread = 0.5 * translation.step * ROW_STEPS;
            [0, 1, 2].map(|axis: usize| (translation.offset[axis] - rest[axis]).abs() + spread)
        })
    }

    /// `shift` returns the most by which a joint leaves its rest translation along each axis.
    fn of(skeleton: &Skeleton, shift: impl Fn(usize) -> [f32; 3]) -> Self {
        let joints: Vec<_> = skeleton.joints().collect();
        let parents: Vec<Option<usize>> = joints
            .iter()
            .map(|joint| skeleton.parent(*joint).map(|parent| parent.index()))
            .collect();
        let shifted = |joint: usize| length(shift(joint));
        // The joint where the body branches: all else hangs from it.
        let children = |joint: usize| parents.iter().filter(|p| **p == Some(joint)).count();
        let center = (0..joints.len()).find(|joint| children(*joint) != 1).unwrap_or_default();
        let models = skeleton.rest_models();
        let at = |joint: usize| {
            models.get(joint).map_or([0.0; 3], |m| m.translation.to_array().map(single))
        };
        let [x, y, z] = at(center);
        let mut above = shifted(center);
        let mut next = parents.get(center).copied().flatten();
        while let Some(joint) = next {
            above += shifted(joint);
            next = parents[joint];
        }
        // Length of the chain from the centre to each joint, at most.
        let mut chains = vec![0.0_f32; joints.len()];
        let mut most = 0.0_f32;
        for joint in 0..joints.len() {
            chains[joint] = match parents[joint] {
                _ if joint == center => 0.0,
                Some(parent) => {
                    let bone = [0, 1, 2].map(|i: usize| at(joint)[i] - at(parent)[i]);
                    chains[parent] + length(bone) + shifted(joint)
                }
                // Another root: it is as far from the centre as at rest.
                None => {
                    let away = [0, 1, 2].map(|i: usize| at(joint)[i] - at(center)[i]);
                    length(away) + shifted(joint)
                }
            };
            most = most.max(chains[joint] + skeleton.reach_m()[joint]);
        }
        let aside = length([x, 0.0, z]);
        Self { height_m: y, radius_m: MARGIN * (above + most + aside) }
    }

    /// Returns a reach around both.
    pub(super) fn and(self, other: Self) -> Self {
        let apart = (self.height_m - other.height_m).abs();
        Self { radius_m: self.radius_m.max(other.radius_m + apart), ..self }
    }
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
}
