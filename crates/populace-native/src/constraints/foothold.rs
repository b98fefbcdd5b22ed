//! The height at which a foot of a member stands or swings over the ground. Twin of the functions of
//! the ground in `kernels/foot.cl`.
//!
//! Reads the ground and the foot's state as of the frame before.

use populace_device::Tables;
use populace_device::layout::{FOOT_AHEAD, FOOT_CLIMB_GAIN, FOOT_CLIMB_M_PER_SEC};
use populace_model::math::vec3;

use super::foot::{FootState, within};
use super::targets::Solver;

/// Returns the ground's height and upward unit normal at a position, in world space.
fn ground_at(tables: &Tables, x: f32, z: f32) -> (f32, [f32; 3]) {
    tables.ground().as_slice()[0].at(tables.heights().as_slice(), x, z)
}

fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

impl Solver<'_> {
    /// Returns the ground's height and normal under a sole with these points, of which `pivot`
    /// stands, and whether it is on an edge: the ground under a point is more than `edge` off the
    /// plane through the pivot. The sole is level there. It is so high that none of its points is
    /// in the ground.
    #[inline(always)]
    pub(super) fn ground_under(
        &self,
        pivot: [f32; 3],
        points: impl ExactSizeIterator<Item = [f32; 3]>,
        edge: f32,
    ) -> (f32, [f32; 3], bool) {
        let (height, normal) = ground_at(self.tables, pivot[0], pivot[2]);
        if self.tables.ground().as_slice()[0].per_metre <= 0.0 || points.len() == 0 {
            return (height, normal, false);
        }
        let (fall_x, fall_z) = (normal[0] / normal[1], normal[2] / normal[1]);
        let (mut level, mut tilted, mut on_edge) = (height, height, false);
        for at in points {
            let (x, z) = (at[0] - pivot[0], at[2] - pivot[2]);
            let ground = ground_at(self.tables, at[0], at[2]).0;
            let (above, fall) = (at[1] - pivot[1], fall_x * x + fall_z * z);
            level = larger(level, ground - above);
            tilted = larger(tilted, ground + fall - above);
            let off = ground + fall - height;
            on_edge |= off * off > edge * edge;
        }
        if on_edge { (level, [0.0, 1.0, 0.0], true) } else { (tilted, normal, false) }
    }

    /// Returns the ground beneath a lifted foot, and the speed at which the foot rises to it: its
    /// true height or that a little ahead, whichever is higher. The nearer the foot is to standing
    /// (`near` is 1), the less it looks ahead: it comes down where it is.
    pub(super) fn ground_beneath(
        &self,
        state: &FootState,
        at: [f32; 3],
        height: f32,
        [most, near]: [f32; 2],
    ) -> [f32; 2] {
        if !state.known {
            return [height, 0.0];
        }
        let mut wanted = height;
        if self.tables.ground().as_slice()[0].per_metre > 0.0 {
            let [along_x, along_z, ..] = self.control.stride.0;
            let [sine, cosine, ..] = self.control.facing.0;
            let ahead = FOOT_AHEAD * most;
            let (x, z) = (
                at[0] + (cosine * along_x + sine * along_z) * ahead,
                at[2] + (cosine * along_z - sine * along_x) * ahead,
            );
            let rise = larger(ground_at(self.tables, x, z).0 - height, 0.0);
            wanted = height + rise * (1.0 - near);
        }
        self.climbs(state.height, state.climb, wanted)
    }

    /// Returns the height that a planted foot is shown at, and the speed at which it rises.
    pub(super) fn height_planted(&self, state: &FootState, ground: f32, on_edge: bool) -> [f32; 2] {
        if !state.known {
            [ground, 0.0]
        } else if state.planted && !on_edge {
            // What the foot is above or below the ground, it loses.
            let [above, climb] = self.climbs(state.above, state.climb, 0.0);
            [ground + above, climb]
        } else {
            self.climbs(state.height, state.climb, ground)
        }
    }

    /// Returns a height on the way from that of the frame before, and the speed of the way. The
    /// speed is limited, as is what it gains and loses. The way ends at rest.
    fn climbs(&self, before: f32, climb: f32, wanted: f32) -> [f32; 2] {
        let secs = self.inputs.frame.elapsed_secs();
        let way = wanted - before;
        let far = if way < 0.0 { -way } else { way };
        // A slope, along which feet do not lag.
        if far * 1.5 <= FOOT_CLIMB_M_PER_SEC * secs {
            return [wanted, if secs > 0.0 { way / secs } else { climb }];
        }
        let stopping = vec3::root(2.0 * FOOT_CLIMB_GAIN * far);
        let most = if stopping < FOOT_CLIMB_M_PER_SEC { stopping } else { FOOT_CLIMB_M_PER_SEC };
        let most = if most * secs > far { far / secs } else { most };
        let gain = FOOT_CLIMB_GAIN * secs;
        let speed = within(if way < 0.0 { -most } else { most }, climb - gain, climb + gain);
        [before + speed * secs, speed]
    }
}
