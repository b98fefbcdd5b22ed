//! People and places as cameras see them.
#![expect(clippy::disallowed_methods, reason = "angles of the host alone; no device computes them")]

use glam::Vec3;
use populace_render::Camera;

/// Position and heading of a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// The ground between the feet, in world space in metres; for who sits, rides or lies, the
    /// point as far below its eyes.
    pub(crate) position: [f32; 3],
    /// Heading about +Y in radians; 0 faces +Z.
    pub(crate) heading_rad: f32,
    /// Height of the eyes above the ground in metres.
    pub(crate) eye_m: f32,
}

impl Pose {
    /// Returns the unit vector of the heading.
    pub(super) fn forward(&self) -> Vec3 {
        Vec3::new(self.heading_rad.sin(), 0.0, self.heading_rad.cos())
    }
}

/// Returns points around somebody who stands at a point, for cameras that look from anywhere.
pub(crate) fn figure([x, y, z]: [f32; 3], [height_m, half_m]: [f32; 2]) -> [[f32; 3]; 5] {
    [
        [x - half_m, y, z],
        [x + half_m, y, z],
        [x, y, z - half_m],
        [x, y, z + half_m],
        [x, y + height_m, z],
    ]
}

/// Returns the rectangle around those points that are before a camera, in pixels of a picture of a
/// size: its upper left and its lower right corner.
pub(crate) fn rectangle(
    camera: &Camera,
    points: &[[f32; 3]],
    size: [u32; 2],
) -> Option<[[f64; 2]; 2]> {
    let seen = points.iter().filter_map(|point| camera.project(*point, size));
    let ends = seen.map(|at| [at.map(f64::from); 2]);
    ends.reduce(|[low, high], [a, b]| {
        [[0, 1].map(|n| low[n].min(a[n])), [0, 1].map(|n| high[n].max(b[n]))]
    })
}

/// Where a person is at a time in seconds, as [`Subject::pose`] gives it.
pub(crate) type Poses<'a> = dyn Fn(f64) -> Option<Pose> + 'a;

/// People that cameras look at.
pub(crate) trait Subject {
    /// Returns points that the picture of all people contains, such as feet and heads, in metres.
    fn bounds(&self) -> Vec<[f32; 3]>;

    /// Returns points that the camera `top` shows besides, such as the corners of the place.
    fn place(&self) -> Vec<[f32; 3]> {
        Vec::new()
    }

    /// Returns the elevation in radians from which the camera `crowd` looks at all people; `None`
    /// to look from the front.
    fn elevation_rad(&self) -> Option<f32> {
        None
    }

    /// Returns height and half the width of a person in metres.
    fn figure_m(&self) -> [f32; 2];

    /// Returns the person that the camera `close` shows; `None` without people.
    fn closest(&self) -> Option<u64>;

    /// Returns the number of the person with an id, as users write it.
    fn find(&self, id: &str) -> Option<u64> {
        id.parse().ok()
    }

    /// Returns where a person is at a time in seconds from 0 on; before it comes, where it comes
    /// first, and after it has left, where it was last. `None` for a number of nobody.
    fn pose(&self, id: u64, secs: f64) -> Option<Pose>;

    /// Returns a clause that says which ids people have, for messages.
    fn describe_ids(&self) -> String;
}
