//! The form of a car's body: surfaces as functions of the place on them.

use glam::DVec3;

/// Kinds of cars.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CarKind {
    /// A small car with a large rear door.
    Hatchback,
    /// A car with a boot.
    Saloon,
    /// A high car for people and goods.
    Van,
}

/// Height in metres of the cabin's floor.
pub(super) const FLOOR_M: f64 = 0.25;
/// Height in metres of the body's lower edge.
pub(super) const SILL_M: f64 = 0.22;
/// Radius in metres of the steering wheel.
pub(super) const STEERING_M: f64 = 0.19;
/// The gap in metres between a wheel and its arch.
const ARCH_M: f64 = 0.065;
/// Corners of an arch.
const ARCH_STEPS: u32 = 6;
/// How far the front and the back bulge in their middle, in metres.
const BULGE_M: f64 = 0.11;
/// Fractions of the height at which the body's faces meet.
pub(super) const ROWS: [f64; 5] = [0.0, 0.13, 0.42, 0.86, 1.0];
/// Fractions of the half width at which faces of front, bonnet and roof meet.
pub(super) const COLUMNS: [f64; 6] = [-1.0, -0.92, -0.4, 0.4, 0.92, 1.0];

/// The middle of the steering wheel.
pub(super) fn wheel_middle() -> DVec3 {
    DVec3::new(0.38, 0.88, 0.41)
}

/// The direction of the steering wheel's axis, towards the driver.
pub(super) fn wheel_axis() -> DVec3 {
    DVec3::new(0.0, 0.42, -0.9).normalize()
}

/// Sizes of a body in metres, and lines in its side view as pairs of z and y, from front to back.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) kind: CarKind,
    pub(super) half: f64,
    pub(super) front: f64,
    pub(super) back: f64,
    pub(super) axles: [f64; 2],
    pub(super) wheel: f64,
    /// The upper edge of the body's sides: bonnet, windows and boot.
    belt: Vec<[f64; 2]>,
    /// The windscreen's foot, in z, and its head.
    pub(super) screen: [f64; 2],
    /// The rear window's head, in z, and its foot.
    pub(super) rear: [f64; 2],
    pub(super) roof_edge: f64,
    pub(super) roof_half: f64,
    /// Borders of the driver's door, in z.
    pub(super) door: [f64; 2],
}

impl Shape {
    pub(super) fn new(kind: CarKind) -> Self {
        match kind {
            CarKind::Hatchback => Self::hatchback(),
            CarKind::Saloon => Self::saloon(),
            CarKind::Van => Self::van(),
        }
    }

    fn hatchback() -> Self {
        let belt =
            [[2.12, 0.74], [1.7, 0.86], [1.08, 0.95], [-0.3, 0.97], [-1.2, 1.0], [-1.82, 1.02]];
        Self {
            kind: CarKind::Hatchback,
            half: 0.875,
            front: 2.12,
            back: -1.82,
            axles: [1.42, -1.14],
            wheel: 0.31,
            belt: belt.to_vec(),
            screen: [1.08, 0.42],
            rear: [-1.3, -1.82],
            roof_edge: 1.42,
            roof_half: 0.6,
            door: [0.93, -0.3],
        }
    }

    fn saloon() -> Self {
        let belt = [
            [2.2, 0.72],
            [1.75, 0.84],
            [1.1, 0.93],
            [-0.3, 0.95],
            [-1.3, 0.985],
            [-1.7, 0.98],
            [-2.35, 0.93],
        ];
        Self {
            kind: CarKind::Saloon,
            front: 2.2,
            back: -2.35,
            axles: [1.44, -1.3],
            wheel: 0.32,
            belt: belt.to_vec(),
            screen: [1.1, 0.38],
            rear: [-0.98, -1.62],
            ..Self::hatchback()
        }
    }

    fn van() -> Self {
        let belt =
            [[2.1, 0.86], [1.75, 0.97], [1.2, 1.06], [-0.3, 1.08], [-1.3, 1.08], [-2.4, 1.08]];
        Self {
            kind: CarKind::Van,
            half: 0.92,
            front: 2.1,
            back: -2.4,
            axles: [1.42, -1.45],
            wheel: 0.33,
            belt: belt.to_vec(),
            screen: [1.2, 0.52],
            rear: [-2.25, -2.4],
            roof_edge: 1.78,
            roof_half: 0.72,
            ..Self::hatchback()
        }
    }

    /// Returns the height of the sides' upper edge.
    pub(super) fn belt(&self, z: f64) -> f64 {
        let pair = self.belt.windows(2).find(|pair| z >= pair[1][0]);
        let Some([[z0, y0], [z1, y1]]) = pair.map(|pair| [pair[0], pair[1]]) else {
            return self.belt.last().map_or(0.9, |last| last[1]);
        };
        let t = ((z - z0) / (z1 - z0)).clamp(0.0, 1.0);
        y0 + (y1 - y0) * t
    }

    /// Returns how far a place is in the body's front end (0 to 1) and in its rear end.
    fn ends(&self, z: f64) -> [f64; 2] {
        let front = (z - self.axles[0] - 0.1) / (self.front - self.axles[0] - 0.1);
        let back = (z - self.axles[1] + 0.1) / (self.back - self.axles[1] + 0.1);
        [front, back].map(|t| t.clamp(0.0, 1.0))
    }

    /// Returns the point of the left side at a place and height.
    pub(super) fn side(&self, z: f64, y: f64) -> DVec3 {
        let rise = ((y - SILL_M) / (self.belt(z) - SILL_M)).clamp(0.0, 1.0);
        let [front, back] = self.ends(z);
        // Fullest below the middle, and drawn in at the shoulder.
        let section =
            [[0.0, 0.95], [0.13, 0.985], [0.45, 1.0], [0.75, 0.985], [0.9, 0.96], [1.0, 0.915]];
        let x = self.half
            * table(&section, rise)
            * (1.0 - 0.1 * front * front)
            * (1.0 - 0.08 * back * back);
        DVec3::new(x, y, z + self.lean(z, rise))
    }

    /// Returns how far the ends stand out at a fraction of the height.
    fn lean(&self, z: f64, rise: f64) -> f64 {
        let [front, back] = self.ends(z);
        let nose =
            [[0.0, -0.07], [0.13, 0.0], [0.42, 0.03], [0.55, -0.01], [0.9, -0.07], [1.0, -0.16]];
        let tail = [[0.0, 0.08], [0.13, 0.0], [0.45, -0.03], [0.6, 0.02], [1.0, 0.05]];
        front * front * table(&nose, rise) + back * back * table(&tail, rise)
    }

    /// Returns a point of the front (`sign` 1) or of the back (-1): `across` from -1 on the right
    /// side of the car to 1 on its left, `rise` from 0 to 1.
    pub(super) fn end(&self, sign: f64, across: f64, rise: f64) -> DVec3 {
        let z = if sign > 0.0 { self.front } else { self.back };
        let low = SILL_M + 0.02;
        let edge = self.side(z, low + rise * (self.belt(z) - low));
        let round = 1.0 - across * across;
        let crown = if rise > 0.99 { self.crown(z) } else { 0.02 * rise };
        DVec3::new(across * edge.x, edge.y + crown * round, edge.z + sign * BULGE_M * round)
    }

    /// Returns how much higher bonnet and boot are in the middle than at their sides.
    fn crown(&self, z: f64) -> f64 {
        let [front, back] = self.ends(z);
        0.05 - 0.03 * front.max(back)
    }

    /// Returns a point of bonnet or boot.
    pub(super) fn deck(&self, z: f64, across: f64) -> DVec3 {
        let edge = self.side(z, self.belt(z));
        let round = 1.0 - across * across;
        let sign = if z > 0.0 { 1.0 } else { -1.0 };
        DVec3::new(across * edge.x, edge.y + self.crown(z) * round, edge.z + sign * BULGE_M * round)
    }

    /// Returns a point of the roof: `along` from 0 at the windscreen to 1 at the rear window.
    pub(super) fn roof(&self, along: f64, across: f64) -> DVec3 {
        let [front, back] = [self.screen[1], self.rear[0]];
        let bow = 4.0 * along * (1.0 - along);
        let round = 1.0 - across * across;
        let narrow = 1.0 - 0.05 * along * along;
        let z = front + (back - front) * along + (0.07 * (1.0 - along) - 0.05 * along) * round;
        let high = self.roof_edge + 0.025 * bow - 0.02 * along * along;
        DVec3::new(across * self.roof_half * narrow, high + 0.075 * round, z)
    }

    /// Returns the left edge of the roof over a place in z.
    pub(super) fn roof_side(&self, z: f64) -> DVec3 {
        let [front, back] = [self.screen[1], self.rear[0]];
        self.roof(((z - front) / (back - front)).clamp(0.0, 1.0), 1.0)
    }

    /// Returns places and lower heights of the side's faces, from the back to the front.
    pub(super) fn stations(&self) -> Vec<[f64; 2]> {
        let mut stations = vec![[self.front, SILL_M + 0.02], [self.back, SILL_M + 0.02]];
        let radius = self.wheel + ARCH_M;
        for axle in self.axles {
            for z in [axle - radius, axle + radius] {
                stations.push([z, SILL_M]);
            }
            for step in 1..ARCH_STEPS {
                let turn = std::f64::consts::PI * f64::from(step) / f64::from(ARCH_STEPS);
                let (sin, cos) = turn.sin_cos();
                stations.push([axle + radius * cos, self.wheel + radius * sin]);
            }
        }
        let middle = 0.5 * (self.front + self.axles[0] + radius);
        let rear = 0.5 * (self.back + self.axles[1] - radius);
        let low = |z: f64| {
            let axle = self.axles.iter().find(|axle| (*axle - z).abs() < radius);
            let rise = axle.map(|axle| (radius * radius - (axle - z) * (axle - z)).sqrt());
            rise.map_or(SILL_M, |rise| self.wheel + rise)
        };
        let free = [middle, 0.3, rear];
        for z in free.into_iter().filter(|z| low(*z) <= SILL_M) {
            stations.push([z, SILL_M]);
        }
        for z in [self.screen[0], self.door[0], self.door[1], self.rear[1]] {
            if stations.iter().all(|s| (s[0] - z).abs() > 1e-6) {
                stations.push([z, low(z)]);
            }
        }
        stations.sort_by(|a, b| a[0].total_cmp(&b[0]));
        stations
    }

    /// The hinge of the driver's door.
    pub(super) fn hinge(&self) -> DVec3 {
        let at = self.side(self.door[0], 0.6);
        DVec3::new(at.x - 0.04, 0.6, self.door[0])
    }

    /// The handle of the driver's door.
    pub(super) fn handle(&self) -> DVec3 {
        let z = self.door[1] + 0.13;
        let at = self.side(z, self.belt(z) - 0.14);
        at + DVec3::X * 0.03
    }

    pub(super) fn front_most(&self) -> f64 {
        self.end(1.0, 0.0, 0.42).z
    }

    pub(super) fn back_most(&self) -> f64 {
        self.end(-1.0, 0.0, 0.45).z
    }
}

/// Returns the value of a table of points at `x`, between its ends.
fn table(points: &[[f64; 2]], x: f64) -> f64 {
    let pair = points.windows(2).find(|pair| x <= pair[1][0]);
    let Some([[x0, y0], [x1, y1]]) = pair.map(|pair| [pair[0], pair[1]]) else {
        return points.last().map_or(0.0, |last| last[1]);
    };
    y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
}
