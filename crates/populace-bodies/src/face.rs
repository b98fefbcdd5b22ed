//! Faces: lips, cheeks, brows, lashes and eyes.

use glam::{Vec2, Vec3};

use crate::body::{Body, BodySystem};
use crate::hair::lip_field;
use crate::marks::Marks;
use crate::person::Features;
use crate::rig_file::Weights;
use crate::surface::{Surface, Vertex, grid, smoothstep, srgb};

/// Columns around an eye.
const EYE_COLUMNS: usize = 16;

/// Returns the skin with painted lips, cheeks and ears.
pub(crate) fn painted(skin: &Surface, marks: &Marks, features: &Features) -> Surface {
    let dark = 1.0 - srgb(features.skin_color).max_element();
    let lips = Vec3::new(0.80, 0.60, 0.60).lerp(Vec3::new(0.92, 0.72, 0.72), dark);
    let field = |v: &Vertex| {
        if marks.head_share(v) > 0.5 { lip_field(marks.in_head(v), 1.0) } else { -1.0 }
    };
    let (mut mouth, mut painted) = skin.split(field);
    mouth.tint(|_| lips);
    painted.add(&mouth);
    painted.tint(|v| {
        if marks.head_share(v) < 0.5 {
            return Vec3::ONE;
        }
        let at = marks.in_head(v);
        let spot = |center: Vec3, radius: f32| {
            let mirrored = Vec3::new(at.x.abs(), at.y, at.z);
            1.0 - smoothstep(0.0, radius, mirrored.distance(center))
        };
        let red = spot(Vec3::new(0.42, -0.36, 0.05), 0.34)
            .max(spot(Vec3::new(0.0, -0.34, 0.42), 0.2))
            .max(spot(Vec3::new(0.85, -0.05, -0.9), 0.3));
        let socket = spot(Vec3::new(marks.eye_x(), 0.02, 0.12), 0.24);
        Vec3::ONE.lerp(Vec3::new(1.0, 0.87, 0.85), red * 0.8)
            * Vec3::ONE.lerp(Vec3::new(0.86, 0.80, 0.80), socket * 0.7)
    });
    painted
}

/// Returns the brows and the upper lashes.
pub(crate) fn brows(body: &Body, system: &BodySystem) -> Surface {
    let marks = &system.marks;
    let around = |v: &Vertex| {
        let at = marks.in_head(v);
        let inside = (0.66 - at.x.abs()).min(at.y - 0.12).min(0.5 - at.y).min(at.z + 0.25);
        inside.min(marks.head_share(v) - 0.5)
    };
    let brow = |v: &Vertex| {
        let at = marks.in_head(v);
        let t = (at.x.abs() - 0.11) / 0.46;
        let middle = 0.25 + 0.055 * (t * 2.2).sin_cos().0 - 0.05 * t * t;
        let ends = smoothstep(0.0, 0.3, t) * smoothstep(1.0, 0.6, t);
        let thick = 0.009 + 0.015 * ends;
        (thick - (at.y - middle).abs()).min(t * 0.2).min((1.0 - t) * 0.2)
    };
    let patch = body.skin.kept(around).subdivided().subdivided();
    let mut brows = patch.kept(brow);
    for v in &mut brows.vertices {
        v.at = v.body + v.normal * 0.0014;
    }
    for group in ["helper-l-eyelashes-2", "helper-r-eyelashes-2"] {
        let mut lashes = system.surface(&body.positions, &system.group(group));
        for v in &mut lashes.vertices {
            v.weights = Weights::one(marks.head);
            v.color = Vec3::splat(0.4);
        }
        brows.add(&lashes);
    }
    brows
}

/// Returns both eyes: whites, irises and pupils as vertex colours.
pub(crate) fn eyes(body: &Body, system: &BodySystem, features: &Features) -> Surface {
    let mut eyes = Surface::default();
    for group in ["helper-l-eye", "helper-r-eye"] {
        let all = system.mesh.vertices(group).into_iter().map(|v| body.positions[v]);
        let (low, high) = all.fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(p), h.max(p)));
        if low.cmple(high).all() {
            eyes.add(&eye(low, high, &system.marks, features));
        }
    }
    eyes
}

/// Returns the front of an eye in a box.
fn eye(low: Vec3, high: Vec3, marks: &Marks, features: &Features) -> Surface {
    let radius = (high.x - low.x + high.y - low.y) / 4.0;
    let center = Vec3::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0, high.z - radius * 1.03);
    let (pupil, white) = (Vec3::splat(0.008), Vec3::new(0.80, 0.78, 0.76));
    let iris = srgb(features.eye_color);
    let ring = |degrees: f32, color: Vec3| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let vertex = |column: usize| {
            let d =
                Vec2::from((column as f32 / EYE_COLUMNS as f32 * std::f32::consts::TAU).sin_cos());
            // Rows run outwards from the middle, so columns run the other way round.
            let normal = Vec3::new(-d.x * sin, d.y * sin, cos);
            let at = center + normal * radius;
            let weights = Weights::one(marks.head);
            Vertex { base: at, body: at, at, normal, color, weights }
        };
        (0..EYE_COLUMNS).map(vertex).collect::<Vec<_>>()
    };
    let bands: [&[(f32, Vec3)]; 3] = [
        &[(0.01, pupil), (11.0, pupil)],
        &[(11.0, iris), (23.0, iris), (28.0, iris * 0.45)],
        &[(28.0, white), (50.0, white), (85.0, white * 0.8)],
    ];
    let mut eye = Surface::default();
    for band in bands {
        eye.add(&grid(&band.iter().map(|(d, c)| ring(*d, *c)).collect::<Vec<_>>(), true));
    }
    eye
}
