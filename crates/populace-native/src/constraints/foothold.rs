//! Heights at which feet stand or swing over the ground. Twin of
//! `kernels/foothold.cl`; twins of its functions of the ground are in populace-device.
//!
//! Reads the ground and the feet's states as of the frame before.

use populace_device::Tables;
use populace_device::layout::{FOOT_AHEAD, FOOT_CLIMB_GAIN, FOOT_CLIMB_M_PER_SEC, Ground};
use populace_model::math::{Real, vec3};

use super::foot_state::{FootState, Stance};
use crate::lanes::{LANES, Members};

/// The ground that feet stand on.
#[derive(Clone, Copy)]
pub(super) struct Floor<'a> {
    ground: &'a Ground,
    heights: &'a [f32],
    elapsed_secs: f32,
}

/// The ground under a sole that stands on its pivot.
#[derive(Clone, Copy)]
pub(super) struct Under<R: Real> {
    pivot: [R; 3],
    /// The ground's height at the pivot, and its upward unit normal.
    pub(super) ground: R,
    pub(super) normal: [R; 3],
    /// Heights at which no point of the sole is in the ground, if the sole is level or lies on the
    /// plane through the pivot.
    level: R,
    tilted: R,
    on_edge: R::Choice,
}

impl<R: Real> Under<R> {
    /// Raises the ground until no point of the sole is in it. On an edge the sole is level.
    #[inline(always)]
    pub(super) fn settle(&mut self) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        self.ground = R::choose(self.on_edge, self.level, self.tilted);
        self.normal = vec3::choose::<R>(self.on_edge, [zero, one, zero], self.normal);
    }
}

#[inline(always)]
fn larger<R: Real>(a: R, b: R) -> R {
    R::choose(a.less(b), b, a)
}

/// Returns the nearest number of a range.
#[inline(always)]
pub(super) fn within<R: Real>(value: R, least: R, most: R) -> R {
    R::choose(most.less(value), most, R::choose(value.less(least), least, value))
}

/// Returns a height on the way from that of the frame before, and the speed of the way. The speed is
/// limited, as is what it gains and loses. The way ends at rest.
#[inline(always)]
fn climbs<R: Real>(before: R, climb: R, wanted: R, elapsed_secs: f32) -> [R; 2] {
    let (zero, secs) = (R::splat(0.0), R::splat(elapsed_secs));
    let fastest = R::splat(FOOT_CLIMB_M_PER_SEC);
    let way = wanted - before;
    let down = way.less(zero);
    let far = R::choose(down, -way, way);
    let stopping = vec3::root(R::splat(2.0 * FOOT_CLIMB_GAIN) * far);
    let most = R::choose(stopping.less(fastest), stopping, fastest);
    let most = R::choose(far.less(most * secs), far / secs, most);
    let gain = R::splat(FOOT_CLIMB_GAIN) * secs;
    let speed = within(R::choose(down, -most, most), climb - gain, climb + gain);
    // A slope, along which feet do not lag.
    let slope = (far * R::splat(1.5)).at_most(fastest * secs);
    let at_once = if elapsed_secs > 0.0 { way / secs } else { climb };
    [R::choose(slope, wanted, before + speed * secs), R::choose(slope, at_once, speed)]
}

impl<'a> Floor<'a> {
    pub(super) fn floor_of(tables: &'a Tables, elapsed_secs: f32) -> Self {
        let ground = &tables.ground().as_slice()[0];
        Self { ground, heights: tables.heights().as_slice(), elapsed_secs }
    }

    /// Returns whether the ground has heights on a grid.
    #[inline(always)]
    pub(super) fn has_heights(&self) -> bool {
        self.ground.per_metre > 0.0
    }

    /// Returns whether the ground is level everywhere.
    #[inline(always)]
    pub(super) fn is_level(&self) -> bool {
        !self.has_heights() && self.ground.slope_x == 0.0 && self.ground.slope_z == 0.0
    }

    /// Returns the ground's height and upward unit normal at a position, in world space.
    #[inline(always)]
    fn ground_at<R: Members>(&self, x: R, z: R) -> (R, [R; 3]) {
        let Self { ground, heights, .. } = *self;
        if !self.has_heights() {
            let (_, [nx, ny, nz]) = ground.at(heights, 0.0, 0.0);
            return (ground.plane_at(x, z), [R::splat(nx), R::splat(ny), R::splat(nz)]);
        }
        let [mut xs, mut zs, mut all] = [[0.0; LANES]; 3];
        let mut normals = [[0.0; LANES]; 3];
        x.store(&mut xs);
        z.store(&mut zs);
        for lane in 0..R::COUNT {
            let (height, [nx, ny, nz]) = ground.at(heights, xs[lane], zs[lane]);
            all[lane] = height;
            (normals[0][lane], normals[1][lane], normals[2][lane]) = (nx, ny, nz);
        }
        let [nx, ny, nz] = &normals;
        (R::load(&all), [R::load(nx), R::load(ny), R::load(nz)])
    }

    /// Returns the ground under the pivot of a sole.
    #[inline(always)]
    pub(super) fn ground_under<R: Members>(&self, pivot: [R; 3]) -> Under<R> {
        let (ground, normal) = self.ground_at(pivot[0], pivot[2]);
        let on_edge = R::splat(1.0).less(R::splat(0.0));
        Under { pivot, ground, normal, level: ground, tilted: ground, on_edge }
    }

    /// Takes a point of the sole into account. The sole is on an edge if the ground under a point
    /// is more than `edge` off the plane through the pivot.
    #[inline(always)]
    pub(super) fn stand_on<R: Members>(&self, under: &mut Under<R>, point: [R; 3], edge: R) {
        let [nx, ny, nz] = under.normal;
        let (fall_x, fall_z) = (nx / ny, nz / ny);
        let (x, z) = (point[0] - under.pivot[0], point[2] - under.pivot[2]);
        let (ground, _) = self.ground_at(point[0], point[2]);
        let (above, fall) = (point[1] - under.pivot[1], fall_x * x + fall_z * z);
        under.level = larger(under.level, ground - above);
        under.tilted = larger(under.tilted, ground + fall - above);
        let off = ground + fall - under.ground;
        under.on_edge = R::either(under.on_edge, (edge * edge).less(off * off));
    }

    /// Returns the height that a lifted foot rises to: that of the ground, or of the ground a
    /// little ahead, whichever is higher. The nearer the foot is to standing (`near` is 1), the
    /// less it looks ahead: it comes down where it is.
    #[inline(always)]
    pub(super) fn ground_ahead<R: Members>(
        &self,
        stance: &Stance<R>,
        at: [R; 3],
        ground: R,
        [most, near]: [R; 2],
    ) -> R {
        if !self.has_heights() {
            return ground;
        }
        let ([along_x, along_z, _], [sine, cosine]) = (stance.stride, stance.standing.facing);
        let ahead = R::splat(FOOT_AHEAD) * most;
        let x = at[0] + (cosine * along_x + sine * along_z) * ahead;
        let z = at[2] + (cosine * along_z - sine * along_x) * ahead;
        let (there, _) = self.ground_at(x, z);
        let rise = larger(there - ground, R::splat(0.0));
        ground + rise * (R::splat(1.0) - near)
    }

    /// Returns the height of the ground that a foot is shown on, and the speed at which it rises. A
    /// planted foot goes to the ground, a lifted one to the height `ahead`.
    #[inline(always)]
    pub(super) fn shown_height<R: Members>(
        &self,
        state: &FootState<R>,
        planted: R::Choice,
        under: &Under<R>,
        ahead: R,
    ) -> [R; 2] {
        let zero = R::splat(0.0);
        // A foot that stays planted loses its height above or below the ground.
        let stays = R::both(planted, R::both(state.planted, R::others(under.on_edge)));
        let before = R::choose(stays, state.above, state.height);
        let wanted = R::choose(stays, zero, R::choose(planted, under.ground, ahead));
        let [height, climb] = climbs(before, state.climb, wanted, self.elapsed_secs);
        let height = R::choose(stays, under.ground + height, height);
        [R::choose(state.known, height, under.ground), R::choose(state.known, climb, zero)]
    }
}
