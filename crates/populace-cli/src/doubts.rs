//! Doubts about a recording that was read without a fault: heights of heads taken for elevations,
//! jumps, and areas where nobody walks.

use std::collections::HashSet;

use populace_scene::Motion;
use populace_trajectory::{Kind, PlaceChange, Polygon, Recording, Track};

/// A point `[x, y]` in metres.
type Point = [f64; 2];

/// Heights in metres at which heads are, and by how far those of a person and of people may differ.
const HEADS_M: [f32; 2] = [1.2, 2.2];
const BOBS_M: f32 = 0.15;
const DIFFERS_M: f32 = 0.02;
/// The part of positions within an area below which it is that of another place.
const WITHIN: f64 = 0.05;
/// The longer side of an area in metres, and in longer sides of what people cover, from which on its
/// unit is another.
const HUGE_M: f64 = 1000.0;
const HUGE: f64 = 50.0;
/// Most positions that are looked for in an area.
const SAMPLES: usize = 2000;
/// Most pairs of sides of outlines that are compared, and of positions and sides. Files may hold
/// millions of points, and all are looked at before the first picture.
const MOST_PAIRS: usize = 20_000_000;

/// Returns what looks wrong in a recording, and how to mend it.
pub(crate) fn doubts(recording: &Recording) -> Vec<String> {
    let of = [heads, jumps, shape, elsewhere, huge];
    of.into_iter().filter_map(|doubt| doubt(recording)).collect()
}

fn people(recording: &Recording) -> impl Iterator<Item = (&str, Track<'_>)> {
    let people = recording.agents.iter().filter(|agent| agent.kind == Kind::Person);
    people.map(|agent| (agent.id.as_str(), recording.track(agent)))
}

/// Elevations that are those of heads.
fn heads(recording: &Recording) -> Option<String> {
    let mut all: Option<[f32; 2]> = None;
    for (_, track) in people(recording) {
        let range = track.elevations.iter().map(|z| [*z; 2]);
        let [low, high] = range.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
        if low < HEADS_M[0] || high > HEADS_M[1] || high - low > BOBS_M {
            return None;
        }
        all = all.map_or(Some([low, high]), |[a, b]| Some([a.min(low), b.max(high)]));
    }
    let [low, high] = all.filter(|[low, high]| high - low > DIFFERS_M)?;
    Some(format!(
        "the elevations, from {low:.2} to {high:.2} m and nearly the same in all rows of a person, \
         look like heights of heads; name the column \"height\" rather than \"z\" if they are"
    ))
}

/// Steps that are too fast.
fn jumps(recording: &Recording) -> Option<String> {
    let (mut count, mut fastest) = (0_usize, (0.0, "", 0.0));
    for (id, track) in people(recording) {
        for (secs, at) in track.times.windows(2).zip(track.positions.windows(2)) {
            let way = [0, 1].map(|axis| f64::from(at[1][axis]) - f64::from(at[0][axis]));
            let speed = way[0].hypot(way[1]) / (secs[1] - secs[0]);
            if speed > Motion::SPRINT_M_PER_SEC {
                count += 1;
                fastest = if speed > fastest.0 { (speed, id, secs[0]) } else { fastest };
            }
        }
    }
    let (speed, id, secs) = fastest;
    let after_secs = secs - recording.secs()[0];
    let steps = crate::report::counted(count, "step");
    (count > 0).then(|| {
        format!(
            "{steps} from a row to the next faster than {} m/s: the fastest is that of \"{id}\", \
             {after_secs:.2} s after the beginning, with {speed:.1} m/s; look for jumps in the \
             rows",
            Motion::SPRINT_M_PER_SEC
        )
    })
}

/// Walkable areas whose outline crosses itself. Outlines that stay the same when the area changes
/// are looked at once.
fn shape(recording: &Recording) -> Option<String> {
    let mut looked_at = HashSet::new();
    let bits = |ring: &[Point]| ring.iter().map(|at| at.map(f64::to_bits)).collect::<Vec<_>>();
    let mut pairs_left = MOST_PAIRS;
    let areas = recording.place.changes.iter().flat_map(|change| &change.walkable);
    let mut rings = areas.flat_map(rings).filter(|ring| looked_at.insert(bits(ring)));
    rings.find_map(|ring| {
        let [x, y] = crossing(ring, &mut pairs_left)?;
        Some(format!(
            "an outline of the walkable area crosses itself near {x:.2}, {y:.2} m; bring its \
             points into the order in which they go round"
        ))
    })
}

/// Returns the outline of an area and its holes.
fn rings(area: &Polygon) -> impl Iterator<Item = &[Point]> {
    std::iter::once(&area.outline).chain(&area.holes).map(Vec::as_slice)
}

/// Returns where two sides of a ring cross each other. Pairs whose ranges of x overlap are compared,
/// and taken from `pairs_left`, until none is left.
fn crossing(ring: &[Point], pairs_left: &mut usize) -> Option<Point> {
    let mut sides: Vec<[Point; 2]> =
        (0..ring.len()).map(|nth| [ring[nth], ring[(nth + 1) % ring.len()]]).collect();
    let low_x = |[a, b]: &[Point; 2]| a[0].min(b[0]);
    sides.sort_by(|a, b| low_x(a).total_cmp(&low_x(b)));
    for (nth, side) in sides.iter().enumerate() {
        let high_x = side[0][0].max(side[1][0]);
        for other in sides[nth + 1..].iter().take_while(|other| low_x(other) <= high_x) {
            *pairs_left = pairs_left.checked_sub(1)?;
            let at = meeting(*side, *other);
            if at.is_some() {
                return at;
            }
        }
    }
    None
}

/// Returns where two sides cross between their ends.
fn meeting([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Point> {
    let turn = |a: Point, b: Point, c: Point| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let (from, to) = (turn(a, b, c), turn(a, b, d));
    let part = from / (from - to);
    let cross = from * to < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0;
    cross.then(|| [0, 1].map(|axis| c[axis] + (d[axis] - c[axis]) * part))
}

/// A walkable area in which nobody, or almost nobody, walks.
fn elsewhere(recording: &Recording) -> Option<String> {
    let rows: usize = people(recording).map(|(_, track)| track.times.len()).sum();
    let all = people(recording).flat_map(|(_, track)| track.times.iter().zip(track.positions));
    let points =
        |change: &PlaceChange| change.walkable.iter().flat_map(rings).map(<[_]>::len).sum();
    let most_points = recording.place.changes.iter().map(points).max().unwrap_or(0);
    let samples = SAMPLES.min(MOST_PAIRS / most_points.max(1)).max(1);
    let (mut looked, mut within) = (0_usize, 0_usize);
    for (secs, at) in all.step_by(rows.div_ceil(samples).max(1)) {
        let areas = recording.place.walkable_at(*secs);
        if areas.is_empty() {
            return None;
        }
        looked += 1;
        within += usize::from(areas.iter().any(|area| holds(area, at.map(f64::from))));
    }
    #[expect(clippy::cast_precision_loss, reason = "some thousands")]
    let part = within as f64 / looked.max(1) as f64;
    (looked > 0 && part < WITHIN).then(|| {
        format!(
            "{:.0} % of the positions are within the walkable area; check its origin, and its \
             unit: areas of other files are in metres",
            100.0 * part
        )
    })
}

/// A walkable area that is far larger than the ways of people, as one in centimetres is.
fn huge(recording: &Recording) -> Option<String> {
    let areas = recording.place.changes.iter().flat_map(|change| &change.walkable);
    let area_m = side(areas.flat_map(|area| &area.outline).copied())?;
    let ways = people(recording).flat_map(|(_, track)| track.positions);
    let ways_m = side(ways.map(|at| at.map(f64::from)))?;
    (area_m > HUGE_M && area_m > HUGE * ways_m).then(|| {
        format!(
            "the walkable area is {area_m:.0} m long, and people walk within {ways_m:.0} m; check \
             its unit: areas of other files are in metres"
        )
    })
}

/// Returns the longer side of the rectangle around points.
fn side(points: impl Iterator<Item = Point>) -> Option<f64> {
    let grown = |[low, high]: [Point; 2], [a, b]: [Point; 2]| {
        [[0, 1].map(|n| low[n].min(a[n])), [0, 1].map(|n| high[n].max(b[n]))]
    };
    let [low, high] = points.map(|at| [at; 2]).reduce(grown)?;
    Some((high[0] - low[0]).max(high[1] - low[1]))
}

/// Returns true for a point within a polygon and outside of its holes.
fn holds(area: &Polygon, [x, y]: Point) -> bool {
    let within = |ring: &Vec<Point>| {
        let next = ring.iter().cycle().skip(1);
        let crossed = ring.iter().zip(next).filter(|(a, b)| {
            (a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])
        });
        crossed.count() % 2 == 1
    };
    within(&area.outline) && !area.holes.iter().any(within)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use populace_trajectory::{Place, ReadSettings, parse};

    use super::*;

    /// Two people who walk for a second, with a column for elevations.
    fn walk(z: [f32; 2]) -> Recording {
        let mut rows = "id,t,x,y,z\n".to_owned();
        for tenth in 0..11 {
            let secs = f64::from(tenth) / 10.0;
            writeln!(rows, "a,{secs},{secs},1,{}\nb,{secs},{secs},2,{}", z[0], z[1]).unwrap();
        }
        read(&rows)
    }

    fn read(rows: &str) -> Recording {
        parse("rows.csv".as_ref(), rows.into(), &ReadSettings::default()).expect("a recording")
    }

    fn in_area(outline: &[[f64; 2]]) -> Vec<String> {
        let area = Polygon { outline: outline.to_vec(), holes: Vec::new() };
        let change = PlaceChange { from_secs: 0.0, walkable: vec![area] };
        let place = Place { changes: vec![change], ..Place::default() };
        let mut recording = walk([0.0; 2]);
        recording.place = place;
        doubts(&recording)
    }

    #[test]
    fn elevations_that_look_like_heads_are_doubted() {
        let found = doubts(&walk([1.62, 1.81]));
        assert!(found.len() == 1 && found[0].contains("from 1.62 to 1.81 m"), "{found:?}");
        for floors in [[0.0, 3.5], [1.5, 1.5], [1.5, 4.5]] {
            assert_eq!(doubts(&walk(floors)), [""; 0], "{floors:?}");
        }
        assert_eq!(doubts(&read("id,t,x,y,z\na,0,0,0,1.5\na,1,1,0,2\nb,0,0,0,1.3\n")), [""; 0]);
    }

    #[test]
    fn jumps_are_doubted_at_times_since_the_beginning() {
        let rows = "id,t,x,y\na,100,0,0\na,100.5,0.5,0\na,101,0.5,8\na,101.5,0.5,1\na,102,1,1\n";
        let found = doubts(&read(rows));
        assert!(found[0].starts_with("2 steps from a row to the next"), "{found:?}");
        assert!(found[0].contains("\"a\", 0.50 s after the beginning, with 16.0 m/s"), "{found:?}");
    }

    #[test]
    fn areas_elsewhere_and_crossed_outlines_are_doubted() {
        let square = [[-1.0, 0.0], [3.0, 0.0], [3.0, 4.0], [-1.0, 4.0]];
        assert_eq!(in_area(&square), [""; 0]);
        let far = in_area(&square.map(|[x, y]| [x + 100.0, y]));
        assert!(far.len() == 1 && far[0].starts_with("0 % of the positions"), "{far:?}");
        let long = in_area(&square.map(|at| at.map(|v| 500.0 * v)));
        assert!(long.len() == 1 && long[0].contains("is 2000 m long"), "{long:?}");
        let crossed = in_area(&[square[0], square[2], square[1], square[3]]);
        assert!(crossed[0].contains("crosses itself near 1.00, 2.00 m"), "{crossed:?}");
    }

    /// The sides from the first corner to the second and from the third to the fourth are crossed;
    /// that along y = 0 has many points.
    fn crossed_with_points(count: u32) -> Vec<Point> {
        let along = (0..=count).map(|nth| [4.0 * f64::from(nth) / f64::from(count) - 1.0, 0.0]);
        along.chain([[-1.0, 4.0], [3.0, 4.0]]).collect()
    }

    #[test]
    fn long_outlines_that_cross_themselves_are_doubted() {
        let found = in_area(&crossed_with_points(10_000));
        assert!(found.iter().any(|doubt| doubt.contains("near 1.00, 2.00 m")), "{found:?}");
    }

    #[test]
    fn no_more_pairs_of_sides_are_compared_than_are_left() {
        let outline = crossed_with_points(10_000);
        let mut pairs_left = MOST_PAIRS;
        assert!(crossing(&outline, &mut pairs_left).is_some());
        assert!(MOST_PAIRS - pairs_left < 50_000, "{pairs_left} pairs are left");
        pairs_left = 0;
        assert_eq!((crossing(&outline, &mut pairs_left), pairs_left), (None, 0));
    }

    /// All sides of the first outline are side by side, and no two of such outlines can be looked
    /// at.
    #[test]
    fn outlines_that_come_again_are_looked_at_once() {
        let zigzag = (0..5001_u32).map(|nth| [f64::from(nth % 2), f64::from(nth)]);
        let zigzag: Vec<Point> = zigzag.chain([[2.0, 5001.0], [2.0, -1.0]]).collect();
        let outlines = [&zigzag, &zigzag, &zigzag, &crossed_with_points(10)];
        let mut recording = walk([0.0; 2]);
        let change = |outline: &Vec<Point>| PlaceChange {
            from_secs: 0.0,
            walkable: vec![Polygon { outline: outline.clone(), holes: Vec::new() }],
        };
        recording.place.changes = outlines.map(change).into();
        let found = shape(&recording);
        assert!(found.is_some_and(|doubt| doubt.contains("near 1.00, 2.00 m")));
    }
}
