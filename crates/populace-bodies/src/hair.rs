//! Hair made from the scalp: a cap, and what hangs or stands out from it.

use glam::{Vec2, Vec3};

use crate::body::Body;
use crate::marks::Marks;
use crate::person::{Features, Haircut};
use crate::random::noise;
use crate::rig_file::Weights;
use crate::surface::{Surface, Vertex, grid, smoothstep};

/// Height of the hairline over the eyes by the angle from the front, in units of the head
/// ([`Marks::in_head`]) and degrees: over the forehead, down to the sideburn, over the ear, and
/// down to the nape.
const HAIRLINE: [(f32, f32); 12] = [
    (0.0, 0.70),
    (22.0, 0.72),
    (38.0, 0.67),
    (52.0, 0.50),
    (62.0, 0.34),
    (74.0, 0.25),
    (80.0, 0.02),
    (87.0, 0.00),
    (93.0, 0.24),
    (122.0, 0.22),
    (138.0, -0.42),
    (180.0, -0.62),
];
/// The axis of the head behind the eyes, in units of the head.
const AXIS_Z: f32 = -0.68;
/// Columns of hanging hair.
const COLUMNS: usize = 40;

/// The hair of a person.
pub(crate) struct Hair<'a> {
    pub(crate) marks: &'a Marks,
    pub(crate) features: &'a Features,
    pub(crate) seed: u64,
}

impl Hair<'_> {
    /// Where the scalp is, as a field: about the distance in decimetres from the hairline.
    pub(crate) fn scalp(&self, v: &Vertex) -> f32 {
        let at = self.marks.in_head(v);
        let angle = at.x.abs().atan2(at.z - AXIS_Z).to_degrees();
        let ragged = 0.05 * (noise(at.x * 9.0 + 50.0, self.seed ^ 11) - 0.5);
        (at.y - hairline(angle) + ragged).min((self.marks.head_share(v) - 0.2) * 4.0)
    }

    /// Returns the hair, the brows and the beard.
    pub(crate) fn all(&self, body: &Body) -> Surface {
        let mut hair = self.cap(body);
        let hangs = match self.features.haircut {
            Haircut::Bob => self.curtain(body, &hair, 62.0, |_| -0.95),
            Haircut::Long => self
                .curtain(body, &hair, 64.0, |angle| -1.0 - 1.9 * smoothstep(100.0, 145.0, angle)),
            Haircut::Ponytail => self.tail(body, &hair),
            Haircut::Bun => self.bun(body, &hair),
            _ => Surface::default(),
        };
        hair.add(&hangs);
        self.paint_strands(&mut hair);
        if self.features.beard {
            hair.add(&self.beard(body));
        }
        hair
    }

    /// Thickness of the cap in metres.
    fn thickness(&self, v: &Vertex) -> f32 {
        let at = self.marks.in_head(v);
        let up = smoothstep(0.25, 0.95, at.y);
        let front = smoothstep(-0.9, 0.1, at.z);
        let angle = at.x.atan2(at.z - AXIS_Z);
        let lock = noise(angle * 6.0 + at.y * 3.0 + 40.0, self.seed) - 0.5;
        // Thin in front of the ears.
        let side = smoothstep(0.1, 0.4, at.y).max(smoothstep(-0.9, -1.2, at.z));
        let thin = side.max(0.25);
        let full = match self.features.haircut {
            Haircut::Cropped => 0.006,
            Haircut::Short => 0.009 + (0.016 + 0.010 * front + 0.010 * lock) * up,
            Haircut::Full => 0.018 + 0.014 * up + 0.008 * lock,
            Haircut::Bob | Haircut::Long => 0.014 + 0.008 * up + 0.003 * lock,
            Haircut::Ponytail | Haircut::Bun => 0.009 + 0.004 * up + 0.002 * lock,
            Haircut::Curly => {
                let curl = noise(angle * 9.0 + at.y * 17.0 + 80.0, self.seed)
                    + noise(at.y * 11.0 - angle * 7.0 + at.z * 5.0 + 160.0, self.seed);
                0.042 + 0.014 * (curl - 1.0)
            }
        };
        full * thin
    }

    fn cap(&self, body: &Body) -> Surface {
        let scalp = body.skin.kept(|v| self.scalp(v) + 0.1).subdivided();
        let mut cap = scalp.kept(|v| self.scalp(v));
        let rounded = |v: &Vertex| {
            let (edge, full) = (0.0012, self.thickness(v) * body.size.powf(0.5));
            let wide = (full * 14.0).clamp(0.1, 0.4);
            let rise = smoothstep(-0.02, wide, self.scalp(v));
            edge + (full - edge).max(0.0) * rise * (2.0 - rise)
        };
        for v in &mut cap.vertices {
            v.at = v.body + v.normal * rounded(v);
        }
        let curly = self.features.haircut == Haircut::Curly;
        cap.smooth(if curly { 1 } else { 4 }, |_| 0.4);
        for v in &mut cap.vertices {
            let short = 0.0012 - (v.at - v.body).dot(v.normal);
            v.at += v.normal * short.max(0.0);
        }
        cap.close_border(|v| v.body - v.normal * 0.001);
        cap.set_normals();
        cap
    }

    /// Darkens and lightens strands that run from the crown.
    fn paint_strands(&self, hair: &mut Surface) {
        hair.tint(|v| {
            let at = self.marks.in_head(v);
            let angle = at.x.atan2(at.z - AXIS_Z);
            let strand = noise(angle * 14.0 + 60.0, self.seed ^ 5);
            Vec3::splat(0.74 + 0.26 * strand)
        });
    }

    /// Returns a place in metres for a place in units of the head.
    fn place(&self, body: &Body, at: Vec3) -> Vec3 {
        // The nearest vertices of the head tell how the head was shaped.
        let near = body.skin.vertices.iter().filter(|v| self.marks.head_share(v) > 0.5);
        let mut near: Vec<(f32, &Vertex)> =
            near.map(|v| (self.marks.in_head(v).distance_squared(at), v)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(8);
        let unit = 0.1 * body.size.powf(0.4);
        let moved = |(_, v): &(f32, &Vertex)| v.body + (at - self.marks.in_head(v)) * unit;
        near.iter().map(moved).sum::<Vec3>() / near.len().max(1) as f32
    }

    /// Returns hair that hangs from the cap around the sides and the back: from `first` degrees on
    /// one side to the same on the other, down to a height for each angle.
    fn curtain(
        &self,
        body: &Body,
        cap: &Surface,
        first: f32,
        length: impl Fn(f32) -> f32,
    ) -> Surface {
        let rows = 12;
        let points = self.outside_points(body, cap);
        let axis = self.place(body, Vec3::new(0.0, 0.0, AXIS_Z));
        let unit = 0.1 * body.size.powf(0.4);
        let mut columns: Vec<Vec<Vertex>> = Vec::new();
        for column in 0..COLUMNS {
            let across = column as f32 / (COLUMNS - 1) as f32;
            let turn = first + (360.0 - 2.0 * first) * across;
            let angle = if turn > 180.0 { 360.0 - turn } else { turn };
            let d = Vec2::from(turn.to_radians().sin_cos());
            let ragged = 0.10 * (noise(across * 26.0, self.seed ^ 9) - 0.5);
            let (top, end) = (0.42, length(angle) + ragged);
            let mut reach = 0.0_f32;
            let mut strand = Vec::new();
            for row in 0..rows {
                let down = row as f32 / (rows - 1) as f32;
                let y = axis.y + (top + (end - top) * down) * unit;
                let slack = [0.002, 0.008][usize::from(row > 0)]
                    + 0.006 * noise(across * 30.0 + 7.0, self.seed ^ 3) * down;
                let found = reach_of(&points, Vec3::new(axis.x, y, axis.z), d, 0.016);
                reach = (found + slack).max(reach * 0.965);
                let at = Vec3::new(axis.x + d.x * reach, y, axis.z + d.y * reach);
                strand.push(self.hanging(body, at, d));
            }
            columns.push(strand);
        }
        let row = |row: usize| columns.iter().map(|c| c[row]).collect::<Vec<_>>();
        let mut curtain = grid(&(0..rows).map(row).collect::<Vec<_>>(), false);
        curtain.smooth(3, |_| 0.35);
        curtain.set_normals();
        curtain
    }

    /// Returns points that hair must lie outside of: of the cap, the head, the neck and the trunk.
    fn outside_points(&self, body: &Body, cap: &Surface) -> Vec<Vec3> {
        let trunk = |v: &&Vertex| {
            let below_chin = v.base.y < self.marks.neck_at.y + 0.4;
            let beside = v.base.x.abs() > 1.1 && below_chin;
            self.marks.arm_share(v) < 0.3 && v.base.y > self.marks.waist_y + 1.0 && !beside
        };
        // Clothes lie about a centimetre over the trunk.
        let lift = |v: &Vertex| {
            let cloth = smoothstep(self.marks.neck_at.y, self.marks.neck_at.y - 0.4, v.base.y);
            v.body + v.normal * 0.013 * cloth
        };
        let skin = body.skin.vertices.iter().filter(trunk).map(lift);
        skin.chain(cap.vertices.iter().map(|v| v.at)).collect()
    }

    /// Returns a vertex of hanging hair, which follows the head, and further down the neck and the
    /// chest.
    fn hanging(&self, body: &Body, at: Vec3, d: Vec2) -> Vertex {
        let marks = self.marks;
        let place = |joint: u16| body.places[usize::from(joint)];
        let (neck, head) = (place(marks.neck), place(marks.head));
        let above = smoothstep(neck.y - 0.02, head.y + 0.02, at.y);
        let low = smoothstep(neck.y, neck.y - 0.12, at.y);
        let weights = Weights::mix(&[
            (Weights::one(marks.head), above),
            (Weights::one(marks.neck), (1.0 - above) * (1.0 - low)),
            (Weights::one(marks.chest), (1.0 - above) * low),
        ]);
        Vertex {
            base: Vec3::new(d.x, 7.0 + (at.y - head.y) * 10.0, d.y),
            body: at,
            at,
            normal: Vec3::new(d.x, 0.0, d.y),
            color: Vec3::ONE,
            weights,
        }
    }

    /// Returns a tail from the back of the head down to the shoulders.
    fn tail(&self, body: &Body, cap: &Surface) -> Surface {
        let tied = self.behind(body, cap, 0.38);
        let unit = 0.1 * body.size.powf(0.4);
        let (rows, columns) = (10, 12);
        let ring = |row: usize| {
            let t = row as f32 / (rows - 1) as f32;
            let middle =
                tied + Vec3::new(0.0, 0.12 - 1.75 * t * t, -0.42 * (t * 2.6).sin_cos().0) * unit;
            let radius = [0.03, 0.22, 0.30][row.min(2)] * (1.0 - 0.8 * t.powi(3)) * unit;
            let vertex = |column: usize| {
                let turn = column as f32 / columns as f32 * std::f32::consts::TAU;
                let d = Vec2::from(turn.sin_cos());
                let at = middle + Vec3::new(d.x, 0.35 * d.y, d.y * 0.8) * radius;
                Vertex { base: Vec3::new(d.x * 2.0, 7.0, d.y), ..self.on_head(at) }
            };
            (0..columns).map(vertex).collect::<Vec<_>>()
        };
        let mut tail = grid(&(0..rows).map(ring).collect::<Vec<_>>(), true);
        tail.set_normals();
        tail
    }

    /// Returns a knot at the back of the head.
    fn bun(&self, body: &Body, cap: &Surface) -> Surface {
        let radius = 0.036 * body.size.powf(0.4);
        let middle = self.behind(body, cap, 0.52) - Vec3::Z * radius * 0.45;
        let (rows, columns) = (9, 14);
        let ring = |row: usize| {
            let (sin, cos) = (row as f32 / (rows - 1) as f32 * std::f32::consts::PI).sin_cos();
            let vertex = |column: usize| {
                let turn = column as f32 / columns as f32 * std::f32::consts::TAU;
                let d = Vec2::from(turn.sin_cos());
                let lock = 0.92 + 0.16 * noise(turn * 2.0 + cos * 5.0 + 20.0, self.seed ^ 7);
                let at =
                    middle + Vec3::new(d.x * sin, cos * 0.95, d.y * sin * 0.85) * radius * lock;
                Vertex { base: Vec3::new(d.x, 7.0 + cos, d.y), ..self.on_head(at) }
            };
            (0..columns).map(vertex).collect::<Vec<_>>()
        };
        let mut bun = grid(&(0..rows).map(ring).collect::<Vec<_>>(), true);
        bun.set_normals();
        bun
    }

    fn on_head(&self, at: Vec3) -> Vertex {
        Vertex {
            base: at,
            body: at,
            at,
            normal: Vec3::Y,
            color: Vec3::ONE,
            weights: Weights::one(self.marks.head),
        }
    }

    /// Returns the hindmost point of the cap at a height in units of the head.
    fn behind(&self, body: &Body, cap: &Surface, height: f32) -> Vec3 {
        let level = |v: &&Vertex| (self.marks.in_head(v).y - height).abs() < 0.2;
        let back = cap.vertices.iter().filter(level).min_by(|a, b| a.at.z.total_cmp(&b.at.z));
        let at = self.place(body, Vec3::new(0.0, height, AXIS_Z - 0.95));
        back.map_or(at, |v| Vec3::new(at.x, v.at.y, v.at.z))
    }

    /// Returns the beard: the jaw and the chin without the lips.
    fn beard(&self, body: &Body) -> Surface {
        let field = |v: &Vertex| {
            let at = self.marks.in_head(v);
            let cheek = -0.50 + 0.43 * (0.3 - at.z).max(-0.1) - at.y;
            let throat = at.y + 1.10 - 0.35 * (0.25 - at.z).max(0.0);
            let lips = (lip_field(at, 1.28) * -0.2).max(-0.3);
            let ear = at.z + 0.82;
            let face = (self.marks.head_share(v) - 0.6) * 2.0;
            cheek.min(throat).min(lips).min(ear).min(face)
        };
        let mut beard = body.skin.kept(field);
        for v in &mut beard.vertices {
            let thick = 0.001 + 0.004 * smoothstep(0.0, 0.12, field(v));
            v.at = v.body + v.normal * thick;
        }
        beard.smooth(2, |_| 0.4);
        beard.close_border(|v| v.body - v.normal * 0.001);
        beard.set_normals();
        beard
    }
}

/// The lips as a field over places in the head: positive inside, at most 1.
pub(crate) fn lip_field(at: Vec3, size: f32) -> f32 {
    let (x, y) = (at.x / (0.27 * size), (at.y + 0.675) / (0.105 * size));
    // The bow of the upper lip.
    let bow = if y > 0.0 { 0.12 * (at.x.abs() * 22.0).sin_cos().1 } else { 0.0 };
    if at.z < -0.1 { -1.0 } else { 1.0 + bow.min(0.0) - Vec2::new(x, y).length() }
}

fn hairline(angle: f32) -> f32 {
    let next = HAIRLINE.iter().position(|(a, _)| *a >= angle).unwrap_or(HAIRLINE.len() - 1).max(1);
    let ((from, low), (to, high)) = (HAIRLINE[next - 1], HAIRLINE[next]);
    low + (high - low) * ((angle - from) / (to - from)).clamp(0.0, 1.0)
}

/// Returns how far points near a height reach from an axis in a direction.
fn reach_of(points: &[Vec3], from: Vec3, d: Vec2, height: f32) -> f32 {
    let out = |p: &Vec3| {
        let offset = Vec2::new(p.x - from.x, p.z - from.z);
        let along = offset.dot(d);
        (along > offset.length() * 0.94).then_some(along)
    };
    let level = points.iter().filter(|p| (p.y - from.y).abs() < height);
    level.filter_map(out).fold(0.0, f32::max)
}
