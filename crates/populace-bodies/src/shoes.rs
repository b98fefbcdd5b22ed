//! Shoes with flat soles, made around the feet.

use glam::{Vec2, Vec3};

use crate::body::{Body, nearest_weights};
use crate::clothes::Cover;
use crate::surface::{Surface, Vertex, grid, srgb};

/// Columns around a shoe.
const COLUMNS: usize = 28;
/// Places between the ankle, 0, and the outline, 1, at which the upper has rows.
const ROWS: [f32; 7] = [0.0, 0.12, 0.32, 0.54, 0.74, 0.9, 1.0];
/// Thickness in metres of the leather and of the sole, for an adult.
const LEATHER: f32 = 0.006;
const SOLE: f32 = 0.018;

/// Returns both shoes. Soles are lighter or darker by `sole`, which multiplies the colour.
pub(crate) fn shoes(body: &Body, cover: &Cover) -> Surface {
    let mut both = Surface::default();
    for side in [1.0, -1.0] {
        let inside = body.skin.kept(|v| (cover.shoe(v) + 0.3).min(v.base.x * side));
        if let Some(shoe) = shoe(body, cover, &inside) {
            both.add(&shoe);
        }
    }
    both
}

fn plan(at: Vec3) -> Vec2 {
    Vec2::new(at.x, at.z)
}

fn shoe(body: &Body, cover: &Cover, foot: &Surface) -> Option<Surface> {
    let (leather, sole) = (LEATHER * body.size, SOLE * body.size);
    let top = cover.shoe_top();
    let ankle: Vec<Vec3> =
        foot.vertices.iter().filter(|v| (v.base.y - top).abs() < 0.2).map(|v| v.body).collect();
    let within = |v: &&Vertex| v.base.y < top;
    let points: Vec<Vec3> = foot.vertices.iter().filter(within).map(|v| v.body).collect();
    let ground = points.iter().fold(f32::MAX, |low, p| low.min(p.y));
    let center = ankle.iter().sum::<Vec3>() / ankle.len().max(1) as f32;
    let outline = outline(&points.iter().map(|p| plan(*p)).collect::<Vec<_>>(), leather)?;
    let outline = resampled(&outline, plan(center));
    let vertex = |at: Vec3, color: Vec3| Vertex {
        base: at * 10.0,
        body: at,
        at,
        normal: Vec3::Y,
        color,
        weights: nearest_weights(foot, at - Vec3::Y * 0.004),
    };
    let sole_color = {
        let (sole, shoe) = (srgb(cover.outfit.sole_color), srgb(cover.outfit.shoe_color));
        sole / shoe.max(Vec3::splat(1e-3))
    };
    let spokes: Vec<Vec<Vec3>> = outline
        .iter()
        .enumerate()
        .map(|(column, end)| {
            let turn = column as f32 / COLUMNS as f32 * std::f32::consts::TAU;
            let d = Vec2::from(turn.sin_cos());
            let reach = ankle.iter().map(|p| plan(*p - center).dot(d)).fold(0.0, f32::max);
            let start = plan(center) + d * (reach + leather * 0.6);
            spoke([start, *end], [center.y, ground + 0.012 * body.size], &points, leather)
        })
        .collect();
    let row = |row: usize| spokes.iter().map(|s| vertex(s[row], Vec3::ONE)).collect::<Vec<_>>();
    let mut shoe = grid(&(0..ROWS.len()).map(row).collect::<Vec<_>>(), true);
    shoe.close_border(|v| {
        let top_edge = v.at.y > center.y - 0.002;
        if top_edge { v.at.lerp(center - Vec3::Y * 0.02, 0.3) } else { v.at }
    });
    let edge = |y: f32, out: f32| {
        let place = |p: &Vec2| {
            let p = *p + (*p - plan(center)).normalize_or_zero() * out;
            vertex(Vec3::new(p.x, y, p.y), sole_color)
        };
        outline.iter().map(place).collect::<Vec<_>>()
    };
    let (upper, lower) = (ground + 0.013 * body.size, ground - sole);
    let middle = outline.iter().sum::<Vec2>() / COLUMNS as f32;
    let bottom = vec![vertex(Vec3::new(middle.x, lower, middle.y), sole_color); COLUMNS];
    let out = 0.003 * body.size;
    shoe.add(&grid(&[edge(upper, 0.0), edge(upper, out), edge(lower, out)], true));
    shoe.add(&grid(&[edge(lower, out), bottom], true));
    shoe.triangles.retain(|t| {
        let [a, b, c] = t.map(|corner| shoe.vertices[corner as usize].at);
        (b - a).cross(c - a).length() > 1e-9
    });
    shoe.smooth_weights(1, |_| true);
    shoe.set_normals();
    Some(shoe)
}

/// Returns the convex outline of points in plan, counter-clockwise seen from above (from +Z to +X),
/// and pushed out.
fn outline(points: &[Vec2], out: f32) -> Option<Vec<Vec2>> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = &Vec2>| {
        let mut hull: Vec<Vec2> = Vec::new();
        for &p in points {
            while let [.., a, b] = hull[..]
                && (b - a).perp_dot(p - b) <= 1e-9
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        hull
    };
    let mut hull = half(&mut sorted.iter());
    hull.extend(half(&mut sorted.iter().rev()));
    if hull.len() < 3 {
        return None;
    }
    // In (x, z) this runs from +X to +Z, so it is turned round.
    hull.reverse();
    let middle = hull.iter().sum::<Vec2>() / hull.len() as f32;
    Some(hull.iter().map(|p| *p + (*p - middle).normalize_or_zero() * out).collect())
}

/// Returns points at equal distances along an outline, the first one in front of `center`.
fn resampled(outline: &[Vec2], center: Vec2) -> Vec<Vec2> {
    let count = outline.len();
    let length: f32 = (0..count).map(|i| outline[i].distance(outline[(i + 1) % count])).sum();
    let fine: Vec<Vec2> = (0..COLUMNS * 8)
        .map(|step| along(outline, length * step as f32 / (COLUMNS * 8) as f32))
        .collect();
    let front = |p: &Vec2| {
        let d = *p - center;
        if d.y > 0.0 { (d.x / d.y).abs() } else { f32::MAX }
    };
    let first = (0..fine.len()).min_by(|a, b| front(&fine[*a]).total_cmp(&front(&fine[*b])));
    let first = first.unwrap_or(0);
    (0..COLUMNS).map(|column| fine[(first + column * 8) % fine.len()]).collect()
}

fn along(outline: &[Vec2], mut distance: f32) -> Vec2 {
    for (index, from) in outline.iter().enumerate() {
        let to = outline[(index + 1) % outline.len()];
        let length = from.distance(to);
        if distance <= length {
            return from.lerp(to, distance / length.max(1e-9));
        }
        distance -= length;
    }
    outline[0]
}

/// Returns the points of the upper from the ankle to the outline: over the foot, and nowhere
/// hollow.
fn spoke(ends: [Vec2; 2], heights: [f32; 2], points: &[Vec3], leather: f32) -> Vec<Vec3> {
    let steps = 16;
    let mut hull: Vec<Vec2> = Vec::new();
    for step in 0..=steps {
        let t = step as f32 / steps as f32;
        let at = ends[0].lerp(ends[1], t);
        let near = points.iter().filter(|p| plan(**p).distance(at) < 0.014);
        let over = near.map(|p| p.y + leather).fold(f32::MIN, f32::max);
        let floor = heights[0] + (heights[1] - heights[0]) * t;
        let height = match step {
            0 => heights[0],
            _ if step == steps => heights[1],
            _ => over.max(if t < 0.5 { f32::MIN } else { heights[1] }).max(floor.min(over)),
        };
        let point = Vec2::new(t, height.min(heights[0]));
        while let [.., a, b] = hull[..]
            && (b - a).perp_dot(point - b) >= 0.0
        {
            hull.pop();
        }
        hull.push(point);
    }
    let height = |t: f32| {
        let next = hull.iter().position(|p| p.x >= t).unwrap_or(hull.len() - 1).max(1);
        let (a, b) = (hull[next - 1], hull[next]);
        a.y + (b.y - a.y) * ((t - a.x) / (b.x - a.x).max(1e-6)).clamp(0.0, 1.0)
    };
    let place = |t: &f32| {
        let at = ends[0].lerp(ends[1], *t);
        Vec3::new(at.x, height(*t), at.y)
    };
    ROWS.iter().map(place).collect()
}
