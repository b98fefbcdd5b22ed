//! The corner of a legend: one in which it covers nobody, if there is one.

use populace_overlay::{Corner, Legend};
use populace_render::Camera;

use crate::camera::{figure, rectangle};

/// Corners in the order in which they are taken.
const CORNERS: [Corner; 4] =
    [Corner::TopRight, Corner::BottomRight, Corner::BottomLeft, Corner::TopLeft];
/// Half the width of a person in metres.
const HALF_M: f32 = 0.3;

/// People in a picture: the camera, and where each stands, with its height in metres.
pub(super) type Seen = (Camera, Vec<([f32; 3], f32)>);

/// Returns the first corner in which a legend covers the fewest people of some pictures of a size.
/// The upper left one may be taken by the clock.
pub(super) fn free(
    legend: &Legend,
    size: [u32; 2],
    pictures: &[Seen],
    is_top_left_taken: bool,
) -> Corner {
    let boxes: Vec<_> = pictures.iter().flat_map(|seen| boxes(seen, size)).collect();
    let covered = |corner: &Corner| {
        let Some([low, high]) = legend.bounds(size, *corner) else { return 0 };
        let is_covered = |[from, to]: &&[[f64; 2]; 2]| {
            (0..2).all(|axis| from[axis] < high[axis] && low[axis] < to[axis])
        };
        boxes.iter().filter(is_covered).count()
    };
    let free = CORNERS.into_iter().filter(|at| *at != Corner::TopLeft || !is_top_left_taken);
    free.min_by_key(covered).unwrap_or(Corner::TopRight)
}

/// Returns the rectangle that each person covers.
fn boxes<'a>(
    (camera, people): &'a Seen,
    size: [u32; 2],
) -> impl Iterator<Item = [[f64; 2]; 2]> + 'a {
    people.iter().filter_map(move |(at, height_m)| {
        rectangle(camera, &figure(*at, [*height_m, HALF_M]), size)
    })
}

#[cfg(test)]
mod tests {
    use populace_overlay::Scale;

    use super::*;

    #[test]
    fn legends_are_put_where_nobody_is() {
        let legend = Legend {
            title: "Speed".to_owned(),
            unit: "m/s".to_owned(),
            scale: Scale::number(0.0, 2.0),
            words: Vec::new(),
            has_none: false,
        };
        let camera = Camera {
            eye: [0.0, 20.0, 0.0],
            target: [0.0; 3],
            up: [0.0, 0.0, -1.0],
            fov_y_rad: 0.8,
            ..Camera::default()
        };
        let corner = |places: &[[f32; 2]], is_taken| {
            let people = places.iter().map(|[x, z]| ([*x, 0.0, *z], 1.8)).collect();
            free(&legend, [640, 360], &[(camera, people)], is_taken)
        };
        let [right, left, below] = [[12.0, -6.5], [-12.0, -6.5], [12.0, 6.5]];
        assert_eq!(corner(&[[0.0; 2]], false), Corner::TopRight);
        assert_eq!(corner(&[right], false), Corner::BottomRight);
        assert_eq!(corner(&[right, below], false), Corner::BottomLeft);
        assert_eq!(corner(&[right, below, [-12.0, 6.5]], false), Corner::TopLeft);
        // The clock is there, and all others have one.
        assert_eq!(corner(&[right, below, [-12.0, 6.5]], true), Corner::TopRight);
        let all = [right, right, below, [-12.0, 6.5], left];
        assert_eq!(corner(&all, false), Corner::BottomRight, "the fewest");
    }
}
