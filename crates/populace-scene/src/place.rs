//! Places: floors, walls, doors and obstacles as characters that are drawn like people.

mod area;
mod crossings;
mod doors;
mod gates;
mod mesh;
mod paving;
mod plan;
mod walls;

use std::fmt;
use std::sync::Arc;

use populace::Affine;
use populace::character::{
    Character, CharacterSource, Material, PaletteEntry, Part, Texture, TextureFilter, Wrap,
    vertex_reach_m,
};
use populace::model::{JointIndex, JointSource, Skeleton, Trs};
use populace_trajectory::{Place, Polygon, Recording};

pub(crate) use plan::is_inside;

use area::Cells;
use doors::Outline;
use gates::Edges;
use mesh::{Faces, over};
use plan::{Point, Ring};
use walls::{Faced, Sizes, build_sides, build_wall};

/// Largest coordinate in metres.
const LARGEST_M: f64 = 1e5;
/// Least area of a polygon in square metres.
const LEAST_M2: f64 = 1e-3;
/// Mean half width in metres up to which a hole is a solid block. Wider ones have walls around.
const SOLID_M: f64 = 0.75;

/// Linear colours of walls, door posts and edges of floors.
const WALL: [f32; 3] = [0.42, 0.41, 0.39];
const POST: [f32; 3] = [0.17, 0.19, 0.22];
const EDGE: [f32; 3] = [0.16, 0.16, 0.16];

/// How a place is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceSettings {
    /// Height of walls and obstacles in metres, 0.01 to 100. Low walls hide nobody.
    pub wall_height_m: f64,
    /// Thickness of walls in metres, 0.01 to 10. Walls stand beside the walkable area.
    pub wall_thickness_m: f64,
    /// Thickness of the floor in metres, 0.01 to 10. Its top is at y = 0.
    pub slab_m: f64,
    /// True if walls have doors where people cross an outline, or appear or leave at it.
    pub doors: bool,
}

impl Default for PlaceSettings {
    fn default() -> Self {
        Self { wall_height_m: 0.6, wall_thickness_m: 0.1, slab_m: 0.15, doors: true }
    }
}

/// The place of a recording, from one time to the next.
#[derive(Clone, Debug)]
pub struct PlacePart {
    /// Time in seconds from which it is there.
    pub from_secs: f64,
    /// A character of one joint, in metres, with plan x along X and plan y along -Z.
    pub character: Arc<Character>,
}

/// A fault of a place that was left out.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlaceWarning {
    /// A ring with a coordinate that is not finite or beyond 100 km.
    FarRing {
        /// Its kind: an outline, a hole or an obstacle.
        what: &'static str,
    },
    /// A ring of no area.
    EmptyRing {
        /// Its kind: an outline, a hole or an obstacle.
        what: &'static str,
    },
    /// A place that no character can be made of.
    Refused {
        /// The reason.
        reason: String,
    },
}

impl fmt::Display for PlaceWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FarRing { what } => write!(
                f,
                "{what} of the place was left out: it has points beyond 100 km; check the unit"
            ),
            Self::EmptyRing { what } => {
                write!(f, "{what} of the place was left out: it has no area")
            }
            Self::Refused { reason } => write!(f, "the place was left out: {reason}"),
        }
    }
}

/// The characters that show a place.
#[derive(Clone, Debug, Default)]
pub struct PlaceModel {
    /// The place from each time on, in the order of time; empty if nothing is known.
    pub parts: Vec<PlacePart>,
    /// Faults, in the order in which they were found.
    pub warnings: Vec<PlaceWarning>,
}

/// A walkable area: an outline and holes, each of some area.
struct Area {
    outline: Ring,
    holes: Vec<Ring>,
}

impl Area {
    fn of(polygon: &Polygon) -> Self {
        Self { outline: polygon.outline.clone(), holes: polygon.holes.clone() }
    }

    fn holds(&self, at: Point) -> bool {
        plan::is_inside(&self.outline, at) && !self.holes.iter().any(|h| plan::is_inside(h, at))
    }
}

impl PlaceModel {
    /// Builds the place of a recording. Settings beyond their ranges count as the nearest value.
    #[must_use]
    pub fn new(recording: &Recording, settings: &PlaceSettings) -> Self {
        let (place, mut warnings) = Self::buildable(&recording.place);
        let model = Self::assemble(&place, recording, settings);
        warnings.extend(model.warnings);
        Self { warnings, ..model }
    }

    /// Builds the place of a recording as [`new`](Self::new) does, if it is
    /// [`buildable`](Self::buildable) already: no ring is tested.
    #[must_use]
    pub fn of_buildable(recording: &Recording, settings: &PlaceSettings) -> Self {
        Self::assemble(&recording.place, recording, settings)
    }

    fn assemble(place: &Place, recording: &Recording, settings: &PlaceSettings) -> Self {
        let mut model = Self::default();
        let obstacles: Vec<Area> = place.obstacles.iter().map(Area::of).collect();
        let changes = &place.changes;
        for (index, change) in changes.iter().enumerate() {
            let areas: Vec<Area> = change.walkable.iter().map(Area::of).collect();
            if areas.is_empty() {
                continue;
            }
            let from = if index == 0 { f64::NEG_INFINITY } else { change.from_secs };
            let to = changes.get(index + 1).map_or(f64::INFINITY, |next| next.from_secs);
            let parts = build(&areas, &obstacles, recording, [from, to], settings);
            match character(parts) {
                Ok(character) => model.parts.push(PlacePart {
                    from_secs: change.from_secs,
                    character: Arc::new(character),
                }),
                Err(reason) => warn(&mut model.warnings, PlaceWarning::Refused { reason }),
            }
        }
        model
    }

    /// Returns what of a place can be built, and why other rings are left out: those with a
    /// coordinate that is not finite or beyond 100 km, and those of less than 0.001 square metres.
    /// A polygon goes with its outline. Sources and targets stay as they are.
    #[must_use]
    pub fn buildable(place: &Place) -> (Place, Vec<PlaceWarning>) {
        let (mut place, mut warnings) = (place.clone(), Vec::new());
        keep(&mut place.obstacles, ["an obstacle", "a hole of an obstacle"], &mut warnings);
        for change in &mut place.changes {
            keep(&mut change.walkable, ["an outline", "a hole"], &mut warnings);
        }
        (place, warnings)
    }
}

/// Keeps the rings of polygons that can be built.
fn keep(
    polygons: &mut Vec<Polygon>,
    [outline, hole]: [&'static str; 2],
    warnings: &mut Vec<PlaceWarning>,
) {
    polygons.retain_mut(|polygon| {
        let stays = is_sound(&mut polygon.outline, outline, warnings);
        if stays {
            polygon.holes.retain_mut(|ring| is_sound(ring, hole, warnings));
        }
        stays
    });
}

/// Returns true for a ring that can be built. Removes points that repeat the one before.
fn is_sound(ring: &mut Ring, what: &'static str, warnings: &mut Vec<PlaceWarning>) -> bool {
    if !ring.iter().flatten().all(|v| v.abs() <= LARGEST_M) {
        warn(warnings, PlaceWarning::FarRing { what });
        return false;
    }
    ring.dedup();
    let cells = Cells::new([&*ring]);
    let mut area_m2 = 0.0;
    let has_room = |triangle: [Point; 3]| {
        area_m2 += plan::area(&triangle);
        area_m2 >= LEAST_M2
    };
    let is_empty = !cells.triangles(|at| plan::is_inside(ring, at)).any(has_room);
    if is_empty {
        warn(warnings, PlaceWarning::EmptyRing { what });
    }
    !is_empty
}

/// Adds a warning that is not there yet.
fn warn(warnings: &mut Vec<PlaceWarning>, warning: PlaceWarning) {
    if !warnings.contains(&warning) {
        warnings.push(warning);
    }
}

/// The meshes of a place.
#[derive(Default)]
struct Meshes {
    floor: Faces,
    walls: Faces,
    posts: Faces,
    edges: Faces,
}

fn build(
    areas: &[Area],
    obstacles: &[Area],
    recording: &Recording,
    secs: [f64; 2],
    settings: &PlaceSettings,
) -> Meshes {
    let sizes = Sizes {
        height: within(settings.wall_height_m, 100.0),
        thickness: within(settings.wall_thickness_m, 10.0),
        slab: within(settings.slab_m, 10.0),
    };
    let rings = |areas: &'_ [Area]| -> Vec<Ring> {
        let all = areas.iter().flat_map(|area| std::iter::once(&area.outline).chain(&area.holes));
        all.cloned().collect()
    };
    let is_walkable = |at| areas.iter().any(|area| area.holds(at));
    let loops = Cells::new(&rings(areas)).loops(is_walkable);
    let (outer, holes): (Vec<Ring>, Vec<Ring>) =
        loops.into_iter().partition(|ring| plan::area(ring) > 0.0);
    let outlines = with_doors(&outer, recording, secs, settings.doors);
    let mut meshes = Meshes::default();
    // The floor has the ends of doors among its corners, so that no gap opens beside them.
    let solid = |hole: &&Ring| 2.0 * plan::area(hole).abs() <= SOLID_M * plan::perimeter(hole);
    let cells = Cells::new(outlines.iter().map(|outline| &outline.points).chain(&holes));
    let on_floor = |at| {
        outer.iter().any(|ring| plan::is_inside(ring, at))
            && !holes.iter().any(|ring| plan::is_inside(ring, at))
    };
    for triangle in cells.triangles(on_floor) {
        meshes.floor.triangle(triangle.map(|p| over(p, 0.0)));
    }
    let mut into = Faced {
        floor: &mut meshes.floor,
        walls: &mut meshes.walls,
        posts: &mut meshes.posts,
        edges: &mut meshes.edges,
    };
    for outline in &outlines {
        build_wall(outline, sizes, &mut into);
    }
    for hole in &holes {
        if solid(&hole) {
            block(into.walls, std::slice::from_ref(hole), |at| plan::is_inside(hole, at), &sizes);
        } else {
            build_wall(&Outline::closed(hole.clone()), sizes, &mut into);
        }
    }
    let is_obstacle = |at| obstacles.iter().any(|area| area.holds(at));
    block(into.walls, &rings(obstacles), is_obstacle, &sizes);
    meshes
}

/// Returns a setting in its range; the least value for NaN.
fn within(value: f64, most: f64) -> f64 {
    const LEAST: f64 = 0.01;
    if value.is_nan() { LEAST } else { value.clamp(LEAST, most) }
}

fn with_doors(outer: &[Ring], recording: &Recording, secs: [f64; 2], doors: bool) -> Vec<Outline> {
    let gates = if doors { Edges::new(outer).gates(recording, secs) } else { Vec::new() };
    let outlines = outer.iter().enumerate().map(|(index, ring)| {
        let own = gates.iter().filter(|gate| gate.outline == index);
        let places: Vec<f64> = own.map(|gate| gate.along_m).collect();
        Outline::with_doors(ring, &places)
    });
    outlines.collect()
}

/// Adds solid blocks of the walls' height.
fn block(faces: &mut Faces, rings: &[Ring], holds: impl Fn(Point) -> bool, sizes: &Sizes) {
    let cells = Cells::new(rings);
    for triangle in cells.triangles(&holds) {
        faces.triangle(triangle.map(|p| over(p, sizes.height)));
    }
    for ring in cells.loops(&holds) {
        build_sides(faces, &ring, sizes.height);
    }
}

/// Returns a character of one joint with the meshes that are not empty.
fn character(meshes: Meshes) -> Result<Character, String> {
    let joint = JointSource { name: "place".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint]).map_err(|error| error.to_string())?;
    let paving = Texture {
        image: 0,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: TextureFilter::Linear,
    };
    let matt = |name: &str, [red, green, blue]: [f32; 3]| Material {
        name: name.into(),
        base_color: [red, green, blue, 1.0],
        metallic: 0.0,
        roughness: 0.95,
        ..Material::default()
    };
    let floor = Material { base_color_texture: Some(paving), ..matt("floor", [1.0; 3]) };
    let Meshes { floor: slab, walls, posts, edges } = meshes;
    let materials = vec![floor, matt("wall", WALL), matt("post", POST), matt("edge", EDGE)];
    let faces = [("floor", slab), ("wall", walls), ("post", posts), ("edge", edges)];
    let part = |(index, (name, faces)): (usize, (&str, Faces))| Part {
        node: 0,
        node_name: name.into(),
        primitive: index,
        material: Some(index),
        mesh: faces.into_mesh(),
    };
    let parts = faces.into_iter().enumerate().filter(|(_, (_, faces))| !faces.is_empty());
    let parts: Vec<Part> = parts.map(part).collect();
    let palette = vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }];
    // Without its reach the place would be out of view with the world's origin.
    let reach_m = vertex_reach_m(&skeleton, &palette, &parts);
    Character::new(CharacterSource {
        name: "place".into(),
        skeleton: skeleton.with_reach(&reach_m),
        palette,
        parts,
        materials,
        images: vec![paving::paving()],
        skins: Vec::new(),
        clips: Vec::new(),
    })
    .map_err(|error| error.to_string())
}
