use populace_testkit::Rng;

use super::*;

fn random(rng: &mut Rng) -> f32 {
    single(rng.between(0.0, 1.0))
}

/// Sample layouts: random points, grids, a circle, lines and a locomotion set.
fn layouts() -> Vec<Vec<[f32; 2]>> {
    let mut rng = Rng::new(5);
    let mut all: Vec<Vec<[f32; 2]>> = (1..=24)
        .map(|count| (0..count).map(|_| [random(&mut rng) * 5.0, random(&mut rng) - 0.5]).collect())
        .collect();
    let grid =
        |w: u8, h: u8| (0..w * h).map(|i| [f32::from(i % w), f32::from(i / w) * 0.25]).collect();
    all.extend([grid(3, 3), grid(5, 4), grid(7, 1), grid(1, 6), grid(2, 2)]);
    let on_circle = (0..12).map(|i| {
        let angle = f64::from(i) / 12.0 * std::f64::consts::TAU;
        [single(angle.cos()), single(angle.sin())]
    });
    all.push(on_circle.chain([[0.0, 0.0]]).collect());
    all.push((0..150).map(|_| [random(&mut rng), random(&mut rng)]).collect());
    // On a slanted line, and the same with one point beside it.
    let line: Vec<[f32; 2]> = (0..5_u8).map(|i| [f32::from(i), 2.0 - 0.5 * f32::from(i)]).collect();
    all.extend([line.clone(), line.iter().copied().chain([[1.0, 5.0]]).collect()]);
    // A locomotion set: idle, walk and run, with turns to both sides.
    all.push(vec![
        [0.0, 0.0],
        [0.0, 1.0],
        [0.0, -1.0],
        [1.4, 0.0],
        [1.4, 0.8],
        [1.4, -0.8],
        [3.4, 0.0],
    ]);
    all
}

fn weight(weights: &Weights, sample: usize) -> f32 {
    weights
        .iter()
        .filter(|(own, weight)| *own == sample && *weight > 0.0)
        .map(|(_, weight)| *weight)
        .sum()
}

#[test]
fn weight_is_one_at_a_sample() {
    for points in layouts() {
        let plane = Plane::new(&points);
        for (sample, at) in points.iter().enumerate() {
            let found = weight(&plane.weights(at.map(f64::from)), sample);
            assert!(
                (found - 1.0).abs() < 1e-5,
                "the weight is {found} at sample {sample} of {points:?}"
            );
        }
    }
}

/// Returns the largest change of a weight between two positions.
fn jump(plane: &Plane, from: Point, to: Point) -> f32 {
    let (before, after) = (plane.weights(from), plane.weights(to));
    let samples = 0..plane.points.len();
    samples.map(|s| (weight(&after, s) - weight(&before, s)).abs()).fold(0.0, f32::max)
}

/// Bisects towards the largest change of weights and returns what remains. Only a discontinuity
/// does.
fn remaining_jump(plane: &Plane, mut from: Point, mut to: Point) -> f32 {
    for _ in 0..26 {
        let middle = [0, 1].map(|i| 0.5 * (from[i] + to[i]));
        if jump(plane, from, middle) > jump(plane, middle, to) {
            to = middle;
        } else {
            from = middle;
        }
    }
    jump(plane, from, to)
}

#[test]
fn weights_sum_to_one_and_are_continuous() {
    let mut rng = Rng::new(9);
    for points in layouts() {
        let plane = Plane::new(&points);
        let (from, to) =
            ([random(&mut rng), random(&mut rng)], [random(&mut rng), random(&mut rng)]);
        // A line through all samples and beyond them.
        let at = |step: i32| {
            let t = f64::from(step) / 500.0;
            [0, 1].map(|i| (f64::from(from[i]) * (1.0 - t) + f64::from(to[i]) * t) * 12.0 - 4.0)
        };
        for step in 0..500 {
            let weights = plane.weights(at(step));
            let total: f32 = weights.iter().map(|(_, weight)| weight).sum();
            assert!(
                (total - 1.0).abs() < 1e-5 && weights.iter().all(|(_, w)| *w >= 0.0),
                "{weights:?}"
            );
            let jump = remaining_jump(&plane, at(step), at(step + 1));
            assert!(
                jump < 1e-3,
                "a jump of {jump} between {:?} and {:?} of {points:?}",
                at(step),
                at(step + 1)
            );
        }
    }
}

#[test]
fn weighted_mean_of_samples_is_the_point_inside() {
    let mut rng = Rng::new(77);
    for points in layouts().into_iter().filter(|points| points.len() >= 3) {
        let plane = Plane::new(&points);
        for _ in 0..50 {
            // A random mean of the samples lies inside their hull.
            let parts: Vec<f64> =
                points.iter().map(|_| f64::from(random(&mut rng)).powi(3)).collect();
            let total: f64 = parts.iter().sum();
            let mean = |axis: usize| {
                points.iter().zip(&parts).map(|(p, part)| f64::from(p[axis]) * part).sum::<f64>()
                    / total
            };
            let at = [mean(0), mean(1)];
            let weights = plane.weights(at);
            for (axis, wanted) in at.into_iter().enumerate() {
                let found: f64 = weights
                    .iter()
                    .map(|(sample, w)| f64::from(points[*sample][axis]) * f64::from(*w))
                    .sum();
                assert!((found - wanted).abs() < 1e-4, "{found} instead of {wanted} in {points:?}");
            }
        }
    }
}

#[test]
fn triangulation_is_delaunay() {
    for points in layouts() {
        let plane = Plane::new(&points);
        for corners in &plane.triangles {
            let circle = corners.map(|corner| plane.points[corner]);
            assert!(
                area(circle[0], circle[1], circle[2]) > 0.0,
                "a triangle is not counter-clockwise"
            );
            let inside =
                plane.points.iter().filter(|point| in_circle(circle, **point) > 1e-7).count();
            assert_eq!(inside, 0, "{corners:?} of {points:?}");
        }
    }
}

#[test]
fn points_of_a_slanted_line_mix_with_their_neighbours_alone() {
    // Tenths are no numbers of single precision, so these points leave their line by rounding.
    let line: Vec<[f32; 2]> =
        (0..7_u8).map(|i| [0.1 * f32::from(i), 0.37 + 0.3 * f32::from(i)]).collect();
    for offset in [0.0, 5.0] {
        let line: Vec<_> = line.iter().map(|[x, y]| [x + offset, *y]).collect();
        let plane = Plane::new(&line);
        for (nth, pair) in line.windows(2).enumerate() {
            for beside in [-1e-3, -1e-7, 0.0, 1e-7, 1e-3] {
                let middle =
                    [0, 1].map(|axis| f64::from(f32::midpoint(pair[0][axis], pair[1][axis])));
                let weights = plane.weights([middle[0] + beside, middle[1]]);
                let found = [nth, nth + 1].map(|sample| weight(&weights, sample));
                assert!(found.iter().all(|w| (w - 0.5).abs() < 0.01), "{weights:?} after {nth}");
            }
        }
    }
}

#[test]
fn points_outside_take_the_nearest_point_of_the_hull() {
    let plane = Plane::new(&[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]]);
    let weights = plane.weights([1.0, -5.0]);
    assert_eq!((weight(&weights, 0), weight(&weights, 1)), (0.5, 0.5));
    assert_eq!(weight(&plane.weights([9.0, 8.0]), 3), 1.0);
    let lone = Plane::new(&[[3.0, 4.0]]);
    assert_eq!(weight(&lone.weights([-1.0, 0.0]), 0), 1.0);
}

#[test]
fn points_that_differ_by_rounding_are_one() {
    let near = [[0.0, 0.0], [0.0, 1.0], [1e-10, 0.0], [1.0, 0.0]];
    assert_eq!(doubled(&near), Some([1e-10, 0.0]));
    assert_eq!(doubled(&[[0.0, 0.0], [0.0, 1.0], [1e-5, 0.0], [1.0, 0.0]]), None);
    assert_eq!(doubled(&[[0.0, 0.0], [1e-10, 0.0], [2e-10, 0.0]]), None, "the extent counts");
    assert_eq!(doubled(&[[3.0, 4.0]]), None);
}
