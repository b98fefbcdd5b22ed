//! The plan of a street: shops, footways, crossings, benches, trees and vehicles, and the people who
//! are out.

use crate::plan::{
    BayPlan, BehaviourPlan, CameraKey, CameraPlan, CastPlan, CrossingPlan, CrowdPlan, FootwayPlan,
    LanePlan, PropPlan, ScenePlan, StrollPlan, WallPlan,
};

/// Length of a block along the street, in metres.
const BLOCK_M: f32 = 48.0;
/// People for whom a block has room.
const PER_BLOCK: usize = 130;
/// Distances from the middle of the road, in metres: the middle of a lane, of parked vehicles, the
/// kerb, benches and trees, the footway's middle, and the fronts of the houses.
const LANE_M: f32 = 1.6;
const PARKED_M: f32 = 4.35;
const KERB_M: f32 = 5.5;
const BENCH_M: f32 = 6.9;
const TREE_M: f32 = 6.35;
const FOOTWAY_M: f32 = 9.8;
const FRONT_M: f32 = 12.5;
/// Width of a lane, in metres.
const LANE_WIDTH_M: f32 = 3.25;
/// Width of a footway, and height of a kerb, in metres.
const FOOTWAY_WIDTH_M: f32 = 4.8;
const KERB_HEIGHT_M: f32 = 0.12;
/// Middles of parked vehicles along a block, and vehicles that drive in each lane of it.
const BAYS_M: [f32; 4] = [6.0, 17.0, 31.0, 42.0];
const DRIVING_PER_BLOCK: f32 = 1.9;
/// Where the crossing of a block is, and its width in metres.
const CROSSING_M: f32 = 24.0;
const CROSSING_WIDTH_M: f32 = 4.0;
/// How far lanes go on beyond the houses, in metres.
const BEYOND_M: f32 = 40.0;
/// Where people pass behind a parked vehicle, as distances behind its middle in metres.
const PASSAGE_M: [f32; 2] = [2.3, 4.4];

/// Settings of a street.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreetSettings {
    /// Number of people.
    pub members: usize,
    /// Seed of everything that varies.
    pub seed: u64,
}

/// Returns the plan of a street with room for its people.
#[must_use]
pub fn street(settings: StreetSettings) -> ScenePlan {
    let StreetSettings { members, seed } = settings;
    let blocks = members.div_ceil(PER_BLOCK).max(2);
    let length = blocks as f32 * BLOCK_M;
    let mut plan = ScenePlan {
        seed,
        casts: vec![CastPlan {
            name: "people".into(),
            from: vec!["@people".into()],
            clips_from: Vec::new(),
            clips: std::collections::BTreeMap::new(),
            varied: true,
            height_m: None,
            holds: Vec::new(),
            top: None,
        }],
        crowds: vec![CrowdPlan {
            cast: "people".into(),
            count: members,
            does: BehaviourPlan::Stroll(StrollPlan::default()),
            layers: Vec::new(),
            gaze: None,
        }],
        cameras: vec![camera(length)],
        ..ScenePlan::default()
    };
    for side in [Side::North, Side::South] {
        side.footway(&mut plan, length);
        side.lane(&mut plan, length, blocks);
        for block in 0..blocks {
            let nth = seed.wrapping_add(block as u64 * 8);
            side.block(&mut plan, block as f32 * BLOCK_M, nth);
        }
    }
    for block in 0..blocks {
        let x = block as f32 * BLOCK_M + CROSSING_M;
        plan.crossings.push(CrossingPlan {
            ends: [[x, -KERB_M - 0.6], [x, KERB_M + 0.6]],
            width_m: CROSSING_WIDTH_M,
            lights: block % 2 == 0,
            ahead_s: 11.0 * block as f32,
        });
        let has_lights = block % 2 == 0;
        plan.props.push(PropPlan {
            size_m: vec![BLOCK_M, FRONT_M - KERB_M, KERB_M - LANE_WIDTH_M],
            ..prop("road", [x, 0.0, 0.0], 0.0, u64::from(has_lights))
        });
        if has_lights {
            lights(&mut plan, x, block);
        }
    }
    for x in [-0.5 * BEYOND_M, length + 0.5 * BEYOND_M] {
        plan.props.push(PropPlan {
            size_m: vec![BEYOND_M, FRONT_M - KERB_M, KERB_M - LANE_WIDTH_M],
            ..prop("road", [x, 0.0, 0.0], 0.0, 0)
        });
    }
    plan
}

/// Plans the lights of a crossing.
fn lights(plan: &mut ScenePlan, x: f32, crossing: usize) {
    let half = 0.5 * CROSSING_WIDTH_M;
    for side in [Side::North, Side::South] {
        let [away, _] = side.away_and_towards();
        // Those who cross see the one at the other side, and drivers the one before the crossing.
        let across = [side.ahead(x, half + 0.5), 0.0, side.z(KERB_M + 0.5)];
        let light = prop("walk_light", across, away + 180.0, 0);
        plan.props.push(PropPlan { crossing: Some(crossing), ..light });
        let before = [side.ahead(x, -half - 0.9), 0.0, side.z(KERB_M + 0.5)];
        let facing_deg = if side == Side::North { -90.0 } else { 90.0 };
        let light = prop("traffic_light", before, facing_deg, 0);
        plan.props.push(PropPlan { crossing: Some(crossing), ..light });
    }
}

fn camera(length: f32) -> CameraPlan {
    let middle = (0.5 * length / BLOCK_M).floor() * BLOCK_M;
    let key = CameraKey {
        time: 0.0,
        from: [middle - 6.0, 4.2, 2.0],
        to: [middle + 24.0, 1.2, 6.0],
        fov: 45.0,
    };
    CameraPlan { name: "street".into(), keys: vec![key] }
}

/// A side of the street.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    /// Towards +Z; vehicles drive towards +X on it.
    North,
    /// Towards -Z; vehicles drive towards -X on it.
    South,
}

impl Side {
    const fn name(self) -> &'static str {
        match self {
            Self::North => "north",
            Self::South => "south",
        }
    }

    /// Returns the z at a distance from the middle of the road.
    const fn z(self, distance_m: f32) -> f32 {
        match self {
            Self::North => distance_m,
            Self::South => -distance_m,
        }
    }

    /// Returns the x ahead of another one, as vehicles drive.
    const fn ahead(self, x: f32, distance_m: f32) -> f32 {
        match self {
            Self::North => x + distance_m,
            Self::South => x - distance_m,
        }
    }

    /// The headings away from the road and towards it, in degrees.
    const fn away_and_towards(self) -> [f32; 2] {
        match self {
            Self::North => [0.0, 180.0],
            Self::South => [180.0, 0.0],
        }
    }

    fn footway(self, plan: &mut ScenePlan, length: f32) {
        let z = self.z(FOOTWAY_M);
        plan.footways.push(FootwayPlan {
            name: self.name().into(),
            points: vec![[0.5, z], [length - 0.5, z]],
            width_m: FOOTWAY_WIDTH_M,
        });
        let front = self.z(FRONT_M);
        let points = vec![[-2.0, front], [length + 2.0, front]];
        plan.walls.push(WallPlan { points, closed: false });
        for x in [-1.5, length + 1.5] {
            let points = vec![[x, self.z(KERB_M)], [x, front]];
            plan.walls.push(WallPlan { points, closed: false });
        }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some thousands")]
    fn lane(self, plan: &mut ScenePlan, length: f32, blocks: usize) {
        let [start, end] = match self {
            Self::North => [-BEYOND_M, length + BEYOND_M],
            Self::South => [length + BEYOND_M, -BEYOND_M],
        };
        let z = self.z(LANE_M);
        plan.lanes.push(LanePlan {
            name: self.name().into(),
            ends: [[start, z], [end, z]],
            vehicles: (blocks as f32 * DRIVING_PER_BLOCK) as usize,
            height_m: -KERB_HEIGHT_M,
            speed: 8.0,
        });
    }

    /// Plans what is on this side of a block that begins at an x.
    fn block(self, plan: &mut ScenePlan, from: f32, seed: u64) {
        let [away, towards] = self.away_and_towards();
        for house in 0..HOUSES {
            let x = from + HOUSE_M * (house as f32 + 0.5);
            let side = 3 * u64::from(self == Self::South);
            let seed = seed.wrapping_add(5 * house as u64 + side) % VARIANTS;
            let house = prop("shopfront", [x, 0.0, self.z(FRONT_M)], towards, seed);
            plan.props.push(PropPlan { size_m: vec![HOUSE_M], ..house });
        }
        for (nth, bay) in BAYS_M.into_iter().enumerate() {
            let x = from + bay;
            plan.bays.push(BayPlan {
                lane: self.name().into(),
                at: [x, self.z(PARKED_M)],
                taken: (nth + usize::from(self == Self::South)) % 2 == 0,
            });
        }
        for x in [12.0, 36.0] {
            self.tree(plan, from + x, seed.wrapping_add(u64::from(x > 20.0)) % VARIANTS);
        }
        for x in [14.3, 33.7] {
            self.bench(plan, from + x, away);
        }
        let lamp = [from, 0.0, self.z(TREE_M)];
        plan.props.push(prop("street_lamp", lamp, towards, 0));
        self.kerb(plan, from);
    }

    fn tree(self, plan: &mut ScenePlan, x: f32, seed: u64) {
        let z = self.z(TREE_M);
        plan.props.push(prop("tree", [x, 0.0, z], 0.0, seed));
        let points = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]
            .map(|[off_x, off_z]| [x + off_x, z + off_z]);
        plan.walls.push(WallPlan { points: points.to_vec(), closed: true });
    }

    fn bench(self, plan: &mut ScenePlan, x: f32, facing_deg: f32) {
        let z = self.z(BENCH_M);
        plan.props.push(prop("bench", [x, 0.0, z], facing_deg, 0));
        let back = self.z(BENCH_M - 0.3);
        let points = vec![[x - 0.9, back], [x + 0.9, back]];
        plan.walls.push(WallPlan { points, closed: false });
    }

    /// Plans the kerb, which people pass at the crossing and behind parked vehicles.
    fn kerb(self, plan: &mut ScenePlan, from: f32) {
        let half = 0.5 * CROSSING_WIDTH_M + 0.3;
        let mut gaps = vec![[from + CROSSING_M - half, from + CROSSING_M + half]];
        for bay in BAYS_M {
            let [a, b] = PASSAGE_M.map(|behind| self.ahead(from + bay, -behind));
            gaps.push([a.min(b), a.max(b)]);
        }
        gaps.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let z = self.z(KERB_M + 0.25);
        let mut begin = from;
        for [to, next] in gaps.into_iter().chain([[from + BLOCK_M, 0.0]]) {
            if to - begin > 0.5 {
                plan.walls.push(WallPlan { points: vec![[begin, z], [to, z]], closed: false });
            }
            begin = next;
        }
    }
}

/// Houses of a side of a block, and their width in metres.
const HOUSES: usize = 6;
const HOUSE_M: f32 = BLOCK_M / HOUSES as f32;
/// Number of different houses and of different trees.
const VARIANTS: u64 = 8;

fn prop(kind: &str, at: [f32; 3], facing_deg: f32, seed: u64) -> PropPlan {
    let (kind, file) = (kind.into(), None);
    PropPlan { kind, file, at, facing_deg, seed, size_m: Vec::new(), crossing: None }
}
