//! Members under the pointer: the ray from the eye against skeletons.

use glam::Vec3;
use populace::interop::Visibility;
use populace::model::Skeleton;
use populace::{Affine, JointIndex, MemberId};
use populace_render::Camera;

use crate::stage::Stage;

/// Half the thickness of a limb, as a share of a person's height.
const THICKNESS: f32 = 0.055;
/// Smallest thickness that can be hit, in pixels.
const LEAST_PX: f32 = 5.0;

/// A ray from the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    eye: Vec3,
    way: Vec3,
    /// Metres of a pixel at a distance of one metre.
    pixel: f32,
}

impl Ray {
    /// Returns the ray through a point of a picture, in pixels from its upper left corner; `None`
    /// for a camera that sees nothing.
    pub(crate) fn new(camera: &Camera, at: [f32; 2], size: [f32; 2]) -> Option<Self> {
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(Vec3::from);
        let forward = (target - eye).try_normalize()?;
        let right = forward.cross(up).try_normalize()?;
        let [width, height] = size;
        let pixel = 2.0 * (0.5 * camera.fov_y_rad).tan() / height;
        let across = right * (at[0] - 0.5 * width) + right.cross(forward) * (0.5 * height - at[1]);
        Some(Self { eye, way: (forward + across * pixel).normalize(), pixel })
    }

    /// Returns how far a segment's nearest point is from the ray, and how far along the ray that
    /// is; `None` behind the eye.
    fn distances(&self, from: Vec3, to: Vec3) -> Option<[f32; 2]> {
        let (limb, between) = (to - from, self.eye - from);
        let (length, slant) = (limb.length_squared(), limb.dot(self.way));
        let apart = length - slant * slant;
        let share = if apart > 1e-9 {
            (between.dot(limb) - between.dot(self.way) * slant) / apart
        } else {
            0.0
        };
        let point = from + limb * share.clamp(0.0, 1.0);
        let along = (point - self.eye).dot(self.way);
        (along > 0.0).then(|| [point.distance(self.eye + self.way * along), along])
    }

    /// Returns true if the ray meets a sphere.
    fn meets(&self, center: Vec3, radius_m: f32) -> bool {
        self.distances(center, center).is_some_and(|[off, _]| off <= radius_m)
            || self.eye.distance(center) <= radius_m
    }
}

/// The joints of a member in world space, each with its parent's.
pub(crate) fn limbs(stage: &mut Stage, member: MemberId) -> Option<Vec<[Vec3; 2]>> {
    let view = stage.crowd.member(member).ok()?;
    // Root motion moves joints in model space, and leaves the placement.
    let (placement, character) = (view.placement(), view.character());
    let skeleton = stage.crowd.character(character).ok()?.asset().skeleton.clone();
    let joints = stage.crowd.member_mut(member).ok()?.model_from_joints().ok()?;
    Some(limbs_of(&skeleton, &placement.world_from_model(), &joints))
}

fn limbs_of(skeleton: &Skeleton, world: &Affine, joints: &[Affine]) -> Vec<[Vec3; 2]> {
    let at = |joint: usize| {
        let rows = joints.get(joint)?.rows;
        Some(Vec3::from(world.transform_point([rows[0][3], rows[1][3], rows[2][3]])))
    };
    let limb = |joint: JointIndex| {
        let end = at(joint.index())?;
        let parent = skeleton.parent(joint).and_then(|parent| at(parent.index()));
        Some([parent.unwrap_or(end), end])
    };
    skeleton.joints().filter_map(limb).collect()
}

/// Returns the member nearest to the eye whose limbs a ray meets.
pub(crate) fn pick(stage: &mut Stage, ray: &Ray) -> Option<MemberId> {
    let near: Vec<(MemberId, f32)> = stage
        .crowd
        .members()
        .filter(|member| member.instance().visibility == Visibility::InView)
        .filter_map(|member| {
            let (center, radius_m) = member.bounding_sphere();
            ray.meets(Vec3::from(center), radius_m).then_some((member.id(), radius_m))
        })
        .collect();
    let mut best: Option<(f32, MemberId)> = None;
    for (member, _) in near {
        let Some(height_m) = stage.height_m(member) else { continue };
        for [from, to] in limbs(stage, member).unwrap_or_default() {
            let Some([off_m, along_m]) = ray.distances(from, to) else { continue };
            let thick_m = (THICKNESS * height_m).max(LEAST_PX * ray.pixel * along_m);
            if off_m <= thick_m && best.is_none_or(|(nearest_m, _)| along_m < nearest_m) {
                best = Some((along_m, member));
            }
        }
    }
    best.map(|(_, member)| member)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_find_what_is_drawn_there() {
        let camera = Camera { eye: [1.0, 2.0, 8.0], target: [0.0, 1.0, 0.0], ..Camera::default() };
        let size = [800, 600];
        for point in [[0.0, 1.0, 0.0], [1.5, 0.2, 1.0], [-1.0, 2.0, -3.0]] {
            let at = camera.project(point, size).expect("in view");
            let ray = Ray::new(&camera, at, [800.0, 600.0]).expect("a ray");
            let [off_m, along_m] =
                ray.distances(Vec3::from(point), Vec3::from(point)).expect("before the eye");
            let away_m = Vec3::from(point).distance(Vec3::from(camera.eye));
            assert!(off_m < 1e-3 && (along_m - away_m).abs() < 1e-3, "{point:?} is {off_m} off");
        }
    }

    #[test]
    fn limbs_are_met_between_their_ends() {
        let ray = Ray { eye: Vec3::ZERO, way: Vec3::Z, pixel: 0.001 };
        let met = ray.distances(Vec3::new(-1.0, 0.1, 4.0), Vec3::new(1.0, 0.1, 4.0));
        assert!(
            met.is_some_and(|[off, along]| (off - 0.1).abs() < 1e-6 && (along - 4.0).abs() < 1e-6)
        );
        assert_eq!(ray.distances(Vec3::new(0.0, 0.0, -2.0), Vec3::new(0.0, 0.0, -1.0)), None);
    }
}
