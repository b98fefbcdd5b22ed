//! Roads with sidewalks, kerbs and crossings.

mod ramps;

use glam::DVec3;
use populace_character::{Character, Error, Image};
use populace_model::convert::single;

use crate::build::{Builder, Finish, Solid, along_x, lathe, matt, plate, satin};
use crate::images;
use ramps::Ramp;

/// Width in metres of a lane.
pub const LANE_M: f32 = 3.25;
/// Height in metres of the sidewalks over the carriageway. Sidewalks are at y = 0.
pub const KERB_M: f32 = 0.12;

/// Width of a lane in metres.
const LANE: f64 = 3.25;
const DROP_M: f64 = 0.12;
/// Width in metres of the kerb stones, and of the gutters beside them.
const STONE_M: f64 = 0.16;
const GUTTER_M: f64 = 0.28;
/// Height in metres of markings over the asphalt.
const PAINT_M: f64 = 0.006;
/// Distance in metres from the ramps of a crossing within which others mark nothing.
const CLEAR_M: f64 = 1.6;

/// The way in which a crossing is marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrossingKind {
    /// Stripes, at which cars wait for people.
    Zebra,
    /// Two broken lines, and a stop line for each lane before them; lights say who waits.
    Signals,
}

/// A crossing of a road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Its middle along the road, in metres.
    pub x_m: f32,
    /// Its width along the road, in metres.
    pub width_m: f32,
    /// The way in which it is marked.
    pub kind: CrossingKind,
}

/// The plan of a straight road.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadPlan {
    /// Length in metres, from 4 to 1,000.
    pub length_m: f32,
    /// Width in metres of each sidewalk with its kerb, from 2 to 20.
    pub sidewalk_m: f32,
    /// Width in metres of the strips between lanes and sidewalks in which cars park, from 0 to 6.
    pub parking_m: f32,
    /// Crossings; at most 16. They are kept apart from each other and from the ends.
    pub crossings: Vec<Crossing>,
}

impl Default for RoadPlan {
    /// Returns 60 m of road with sidewalks of 4 m, and a zebra crossing in the middle.
    fn default() -> Self {
        let zebra = Crossing { x_m: 0.0, width_m: 4.0, kind: CrossingKind::Zebra };
        Self { length_m: 60.0, sidewalk_m: 4.0, parking_m: 0.0, crossings: vec![zebra] }
    }
}

/// A road along X with its middle at the origin: two lanes of [`LANE_M`], kerbs and sidewalks.
/// Sidewalks are at y = 0 and the carriageway at y = -[`KERB_M`]. Traffic keeps to the right: the
/// lane at z = 1.625 leads to +X, that at z = -1.625 to -X.
#[derive(Clone, Debug)]
pub struct Road {
    /// The road, of one joint.
    pub character: Character,
    length_m: f64,
    /// Distance of the kerbs from the middle.
    kerb_m: f64,
    sidewalk_m: f64,
    ramps: Vec<Ramp>,
}

/// Returns a road. Numbers beyond their ranges count as the nearest ones, and NaN as the least.
/// Crossings that overlap others, or that do not fit on the road, are left out.
///
/// # Errors
///
/// Those of [`Character::new`]; no plan causes one.
pub fn road(plan: &RoadPlan) -> Result<Road, Error> {
    let length = within(plan.length_m, 4.0, 1000.0);
    let sidewalk = within(plan.sidewalk_m, 2.0, 20.0);
    let kerb = LANE + within(plan.parking_m, 0.0, 6.0);
    let mut crossings: Vec<(Crossing, Ramp)> = Vec::new();
    for crossing in plan.crossings.iter().take(16) {
        let ramp = Ramp::new(f64::from(crossing.x_m), within(crossing.width_m, 1.5, 10.0));
        let fits = ramp.from() > -0.5 * length && ramp.to() < 0.5 * length;
        if fits && crossings.iter().all(|(_, other)| ramp.is_apart(other)) {
            crossings.push((*crossing, ramp));
        }
    }
    crossings.sort_by(|a, b| a.1.from().total_cmp(&b.1.from()));
    let mut b = Builder::new("road");
    let finishes = Finishes::new(&mut b);
    let ramps: Vec<Ramp> = crossings.iter().map(|(_, ramp)| *ramp).collect();
    let mut layer = Layer { b: &mut b, finishes: &finishes, half: 0.5 * length, kerb, sidewalk };
    layer.carriageway();
    for side in [1.0, -1.0] {
        layer.sidewalk(&ramps, side);
        layer.drains(&ramps, side);
    }
    layer.centre_line(&ramps);
    layer.parking_lines(&ramps);
    for (crossing, ramp) in &crossings {
        layer.crossing(crossing.kind, ramp);
        layer.approaches(&ramps, ramp);
    }
    let character = b.build(Vec::new())?;
    Ok(Road { character, length_m: length, kerb_m: kerb, sidewalk_m: sidewalk, ramps })
}

fn within(value: f32, low: f64, high: f64) -> f64 {
    if value.is_nan() { low } else { f64::from(value).clamp(low, high) }
}

impl Road {
    /// Length in metres.
    #[must_use]
    pub fn length_m(&self) -> f32 {
        single(self.length_m)
    }

    /// Distance in metres from the middle of the road to where houses stand.
    #[must_use]
    pub fn front_m(&self) -> f32 {
        single(self.kerb_m + self.sidewalk_m)
    }

    /// Returns the height in metres of the surface at a place, as its triangles have it. Beyond the
    /// road's ends it goes on; beyond the sidewalks it is 0.
    #[must_use]
    pub fn height_m(&self, x: f32, z: f32) -> f32 {
        let (x, away) = (f64::from(x), f64::from(z).abs() - self.kerb_m);
        if away < 0.0 {
            return -KERB_M;
        }
        single(self.ramps.iter().map(|ramp| ramp.height(x, away)).fold(0.0, f64::min))
    }
}

struct Finishes {
    asphalt: Finish,
    slabs: Finish,
    setts: Finish,
    knobs: Finish,
    kerb: Finish,
    paint: Finish,
    iron: Finish,
}

impl Finishes {
    fn new(b: &mut Builder) -> Self {
        let mut tiled = |name: &str, srgb: u32, image: Image, tile_m: f64| {
            b.tiled(matt(name, srgb), image, tile_m)
        };
        Self {
            asphalt: tiled("Asphalt", 0x6E_6E72, images::asphalt(), 3.0),
            slabs: tiled("Slabs", 0xCF_C6B8, images::slabs(3, 4, 2, 30.0), 1.8),
            setts: tiled("Setts", 0x9A_948C, images::slabs(8, 8, 3, 60.0), 1.12),
            knobs: tiled("Knobs", 0xE6_D9BC, images::knobs(), 0.4),
            kerb: b.finish(matt("Kerb", 0xB9_B3A8)),
            paint: b.finish(matt("Road paint", 0xE9_E7E0)),
            iron: b.finish(satin("Iron", 0x3A_3B3D)),
        }
    }
}

/// A road under construction.
struct Layer<'a> {
    b: &'a mut Builder,
    finishes: &'a Finishes,
    half: f64,
    /// Distance of the kerbs from the middle.
    kerb: f64,
    sidewalk: f64,
}

impl Layer<'_> {
    fn carriageway(&mut self) {
        let (half, kerb, y) = (self.half, self.kerb, -DROP_M);
        let edge = kerb - GUTTER_M;
        let mut strip = |finish: Finish, near: f64, far: f64| {
            let corners = [[-half, y, far], [half, y, far], [half, y, near], [-half, y, near]];
            self.b.on(finish).flat(&plate(&corners));
        };
        strip(self.finishes.asphalt, -edge, edge);
        strip(self.finishes.setts, edge, kerb);
        strip(self.finishes.setts, -kerb, -edge);
        // Ends, so that nobody looks under the road.
        let (out, low) = (kerb + self.sidewalk, -0.4);
        self.b.on(self.finishes.kerb).tinted([0.7; 3]);
        let profile = [
            [-out, low],
            [out, low],
            [out, 0.0],
            [kerb, 0.0],
            [kerb, y],
            [-kerb, y],
            [-kerb, 0.0],
            [-out, 0.0],
        ];
        let mut slab: Solid = along_x(&profile, -half, half);
        // Its upper faces are those of the road.
        slab.faces.retain(|face| face.iter().any(|p| slab.points[*p].y < -0.3));
        self.b.flat(&slab);
    }

    /// Adds the sidewalk at `side` Z with its kerb. Its lines along X are those of the ramps, so
    /// that neighbouring faces share their corners.
    fn sidewalk(&mut self, ramps: &[Ramp], side: f64) {
        let kerb = self.kerb;
        let mut xs = vec![-self.half, self.half];
        xs.extend(ramps.iter().flat_map(|ramp| ramp.lines(STONE_M)));
        xs.sort_by(f64::total_cmp);
        let height =
            |x: f64, away: f64| ramps.iter().map(|ramp| ramp.height(x, away)).fold(0.0, f64::min);
        let at = |x: f64, away: f64| DVec3::new(x, height(x, away), side * (kerb + away));
        let aways = [STONE_M, ramps::DEPTH_M, self.sidewalk];
        let mut slabs = Solid::default();
        let mut knobs = Solid::default();
        let mut stones = Solid::default();
        for pair in xs.windows(2) {
            let [l, r] = [pair[0], pair[1]];
            let middle = 0.5 * (l + r);
            let is_flat = ramps.iter().any(|ramp| ramp.is_dropped(middle));
            for pair in aways.windows(2) {
                let [near, far] = [pair[0], pair[1]];
                let into = if is_flat && near < ramps::DEPTH_M { &mut knobs } else { &mut slabs };
                let falls = height(l, near) < height(r, near);
                cell(into, [at(l, near), at(r, near), at(r, far), at(l, far)], falls, side);
            }
            let lip = |x: f64, away: f64, y: f64| DVec3::new(x, y, side * (kerb + away));
            let falls = height(l, 0.0) < height(r, 0.0);
            let [hl, hr] = [height(l, 0.0), height(r, 0.0)];
            let cut = 0.025_f64;
            let (cl, cr) = (cut.min(hl + DROP_M), cut.min(hr + DROP_M));
            cell(
                &mut stones,
                [at(l, cut), at(r, cut), at(r, STONE_M), at(l, STONE_M)],
                falls,
                side,
            );
            let bevel = [lip(l, 0.0, hl - cl), lip(r, 0.0, hr - cr), at(r, cut), at(l, cut)];
            cell(&mut stones, bevel, falls, side);
            let face = [lip(l, 0.0, -DROP_M), lip(r, 0.0, -DROP_M), bevel[1], bevel[0]];
            cell(&mut stones, face, falls, side);
        }
        self.b.on(self.finishes.slabs).flat(&slabs);
        self.b.on(self.finishes.knobs).flat(&knobs);
        self.b.on(self.finishes.kerb).add(&stones, 20.0);
    }

    /// Adds a flat thing on the carriageway.
    fn mark(&mut self, finish: Finish, [l, r]: [f64; 2], [near, far]: [f64; 2]) {
        let y = PAINT_M - DROP_M;
        let corners = [[l, y, far], [r, y, far], [r, y, near], [l, y, near]];
        self.b.on(finish).flat(&plate(&corners));
    }

    fn centre_line(&mut self, ramps: &[Ramp]) {
        let mut x = -self.half + 1.0;
        while x + 2.0 < self.half {
            let is_free =
                ramps.iter().all(|r| x + 2.0 < r.from() - CLEAR_M || x > r.to() + CLEAR_M);
            if is_free {
                self.mark(self.finishes.paint, [x, x + 2.0], [-0.06, 0.06]);
            }
            x += 4.0;
        }
    }

    /// Marks the edges of lanes beside which cars park.
    fn parking_lines(&mut self, ramps: &[Ramp]) {
        let mut x = -self.half + 0.3;
        while self.kerb > LANE && x + 0.6 < self.half {
            if ramps.iter().all(|ramp| x + 0.6 < ramp.from() || x > ramp.to()) {
                for z in [LANE, -LANE] {
                    self.mark(self.finishes.paint, [x, x + 0.6], [z - 0.05, z + 0.05]);
                }
            }
            x += 1.2;
        }
    }

    fn crossing(&mut self, kind: CrossingKind, ramp: &Ramp) {
        let [l, r] = ramp.flat();
        let paint = self.finishes.paint;
        match kind {
            CrossingKind::Zebra => {
                let mut z = 0.5 - self.kerb;
                while z + 0.5 < self.kerb {
                    self.mark(paint, [l, r], [z, z + 0.5]);
                    z += 1.0;
                }
            }
            CrossingKind::Signals => {
                let edge = self.kerb - GUTTER_M - 0.05;
                for x in [l, r - 0.14] {
                    let mut z = -edge;
                    while z + 0.4 < edge + 0.01 {
                        self.mark(paint, [x, x + 0.14], [z, z + 0.4]);
                        z += 0.74;
                    }
                }
            }
        }
    }

    /// Marks where cars wait before a crossing, and that nobody overtakes there. Neither is beyond
    /// the road's ends or at other crossings.
    fn approaches(&mut self, ramps: &[Ramp], ramp: &Ramp) {
        let before = ramps.iter().map(|other| other.to() + CLEAR_M).filter(|x| *x < ramp.to());
        let beyond = ramps.iter().map(|other| other.from() - CLEAR_M).filter(|x| *x > ramp.from());
        let (low, high) = (before.fold(-self.half, f64::max), beyond.fold(self.half, f64::min));
        let [l, r] = ramp.flat();
        // Cars to +X come from -X, on the side of +Z.
        let edge = LANE - GUTTER_M - 0.05;
        for (x, z) in [
            ([l - 1.6, l - 1.25], [0.12, edge]),
            ([r + 1.25, r + 1.6], [-edge, -0.12]),
            ([l - 5.4, l - 1.4], [-0.06, 0.06]),
            ([r + 1.4, r + 5.4], [-0.06, 0.06]),
        ] {
            // Between crossings close together nothing is free, and low is above high.
            let x = x.map(|x| x.max(low).min(high));
            if x[0] < x[1] {
                self.mark(self.finishes.paint, x, z);
            }
        }
    }

    /// Adds drains in the gutter, and lids of shafts.
    fn drains(&mut self, ramps: &[Ramp], side: f64) {
        let mut x = -self.half + 5.0;
        while x < self.half - 1.0 {
            if ramps.iter().all(|ramp| x + 0.6 < ramp.from() || x > ramp.to()) {
                let z = side * (self.kerb - 0.14);
                self.mark(self.finishes.iron, [x, x + 0.5], [z - 0.13, z + 0.13]);
                self.b.tinted([0.35; 3]);
                let y = PAINT_M + 0.003 - DROP_M;
                for slot in 0..5 {
                    let l = x + 0.05 + 0.09 * f64::from(slot);
                    let corners = [
                        [l, y, z + 0.1],
                        [l + 0.04, y, z + 0.1],
                        [l + 0.04, y, z - 0.1],
                        [l, y, z - 0.1],
                    ];
                    self.b.flat(&plate(&corners));
                }
            }
            if side > 0.0 {
                self.lid(ramps, x + 9.0, 0.9);
            }
            x += 17.0;
        }
    }

    fn lid(&mut self, ramps: &[Ramp], x: f64, z: f64) {
        let is_free = ramps.iter().all(|ramp| x + 0.4 < ramp.from() || x - 0.4 > ramp.to());
        if x + 0.4 > self.half || !is_free {
            return;
        }
        let disc = |radius: f64, y: f64| {
            let mut disc = lathe(&[[radius, y - 0.001], [radius, y]], 16);
            disc.faces.drain(..disc.faces.len() - 1);
            for point in &mut disc.points {
                *point += DVec3::new(x, -DROP_M, z);
            }
            disc
        };
        self.b.on(self.finishes.kerb).tinted([0.6; 3]).flat(&disc(0.36, PAINT_M));
        self.b.on(self.finishes.iron).flat(&disc(0.3, PAINT_M + 0.003));
    }
}

/// Adds a cell that faces up or to the carriageway: two triangles, cut so that the fall of a ramp
/// has the heights that [`Ramp::height`] gives. `falls` is true if the ramp rises towards +X.
fn cell(into: &mut Solid, [a, b, c, d]: [DVec3; 4], falls: bool, side: f64) {
    let triangles = if falls { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
    for mut triangle in triangles {
        if side > 0.0 {
            triangle.reverse();
        }
        into.face(&triangle);
    }
}
