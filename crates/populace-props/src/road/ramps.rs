//! Dropped kerbs.

/// Depth in metres of a ramp, from the kerb's face.
pub(super) const DEPTH_M: f64 = 1.3;
/// Length in metres of the slopes at its sides.
const FLARE_M: f64 = 0.7;
/// Height in metres by which the kerb is lower.
const FALL_M: f64 = 0.105;

/// The dropped kerb of a crossing, on both sides of the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    middle: f64,
    /// Half the length in which the kerb is lowest.
    half: f64,
}

impl Ramp {
    pub(super) fn new(middle: f64, width: f64) -> Self {
        Self { middle, half: 0.5 * width }
    }

    /// The end at -X, with the slope.
    pub(super) fn from(&self) -> f64 {
        self.middle - self.half - FLARE_M
    }

    /// The end at +X, with the slope.
    pub(super) fn to(&self) -> f64 {
        self.middle + self.half + FLARE_M
    }

    /// The ends of the lowest part.
    pub(super) fn flat(&self) -> [f64; 2] {
        [self.middle - self.half, self.middle + self.half]
    }

    /// The lines along z at which its faces meet. Two are where the edge of a slope leaves the kerb
    /// stones, `stone_m` wide.
    pub(super) fn lines(&self, stone_m: f64) -> [f64; 6] {
        let ([from, to], kerb) = (self.flat(), FLARE_M * stone_m / DEPTH_M);
        [self.from(), self.from() + kerb, from, to, self.to() - kerb, self.to()]
    }

    pub(super) fn is_apart(&self, other: &Self) -> bool {
        // A place at NaN is apart from none.
        self.from() > other.to() || self.to() < other.from()
    }

    pub(super) fn is_dropped(&self, x: f64) -> bool {
        (x - self.middle).abs() < self.half
    }

    /// Returns the height of the sidewalk, `away` metres from the kerb's face: -[`FALL_M`] to 0.
    pub(super) fn height(&self, x: f64, away: f64) -> f64 {
        let along = (1.0 - ((x - self.middle).abs() - self.half) / FLARE_M).clamp(0.0, 1.0);
        let across = (1.0 - away / DEPTH_M).clamp(0.0, 1.0);
        // A plane at the sides, not a twisted surface.
        -FALL_M * (along + across - 1.0).max(0.0)
    }
}
