//! The place where agents walk.

/// A polygon with holes, in metres on the plan. Rings are not closed: the last point is joined to
/// the first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygon {
    /// The outline.
    pub outline: Vec<[f64; 2]>,
    /// The holes.
    pub holes: Vec<Vec<[f64; 2]>>,
}

/// The walkable area from a time on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaceChange {
    /// Time in seconds.
    pub from_secs: f64,
    /// The walkable area. Nobody walks in holes or outside.
    pub walkable: Vec<Polygon>,
}

/// The place of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    /// Walkable areas in the order of time; the first holds from the beginning on. Empty if nothing
    /// is known.
    pub changes: Vec<PlaceChange>,
    /// Obstacles in the walkable areas, beside their holes.
    pub obstacles: Vec<Polygon>,
    /// Areas in which agents appear.
    pub sources: Vec<Polygon>,
    /// Areas to which agents go.
    pub targets: Vec<Polygon>,
}

impl Polygon {
    fn points_mut(&mut self) -> impl Iterator<Item = &mut [f64; 2]> {
        std::iter::once(&mut self.outline).chain(&mut self.holes).flatten()
    }
}

impl Place {
    /// Returns the place with its points relative to an origin.
    pub(crate) fn relative_to(mut self, origin_m: [f64; 2]) -> Self {
        let points = self.polygons_mut().flat_map(Polygon::points_mut);
        points.for_each(|at| *at = [at[0] - origin_m[0], at[1] - origin_m[1]]);
        self
    }

    /// Returns the place in metres, if one unit of its points is `metres`.
    pub(crate) fn scaled(mut self, metres: f64) -> Self {
        let points = self.polygons_mut().flat_map(Polygon::points_mut);
        points.for_each(|at| *at = at.map(|v| v * metres));
        self
    }

    fn polygons_mut(&mut self) -> impl Iterator<Item = &mut Polygon> {
        let areas = self.changes.iter_mut().flat_map(|change| &mut change.walkable);
        let others = [&mut self.obstacles, &mut self.sources, &mut self.targets];
        areas.chain(others.into_iter().flatten())
    }

    /// Returns the walkable area at a time in seconds; empty if nothing is known.
    #[must_use]
    pub fn walkable_at(&self, secs: f64) -> &[Polygon] {
        let next = self.changes.partition_point(|change| change.from_secs <= secs);
        let change = self.changes.get(next.saturating_sub(1));
        change.map_or(&[], |change| &change.walkable)
    }
}
