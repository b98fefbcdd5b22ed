//! Construction of a character from solids, materials and joints.

mod finish;
mod shapes;
mod solid;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use populace_character::{
    Character, CharacterSource, Error, Image, Influences, Material, Mesh, PaletteEntry, Part,
    Texture, TextureFilter, Wrap, vertex_reach_m,
};
use populace_clip::Clip;
use populace_model::convert::{single, u32_from};
use populace_model::{Affine, ClipSource, JointSource, Skeleton, Trs};

pub(crate) use finish::{alpha, glass, glow, linear, matt, metal, pane, satin};
pub(crate) use shapes::{
    along_x, bevelled, block, extrude, grid, lathe, lump, plate, polygon, sheet, spun, tube, turned,
};
pub(crate) use solid::Solid;

/// A material that a builder knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Finish(usize);

/// A joint that a builder knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Joint(usize);

/// A factor of colours that changes with the height in model space: `low` and below it, `high` and
/// above it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fade {
    pub(crate) low_m: f64,
    pub(crate) high_m: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Fade {
    const NONE: Self = Self { low_m: 0.0, high_m: 1.0, low: 1.0, high: 1.0 };

    fn at(&self, height_m: f64) -> f64 {
        let t = ((height_m - self.low_m) / (self.high_m - self.low_m)).clamp(0.0, 1.0);
        self.low + (self.high - self.low) * t
    }
}

/// Triangles of one material in one node.
#[derive(Default)]
struct Piece {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    uvs: Vec<[f64; 2]>,
    colors: Vec<[f64; 4]>,
    joints: Vec<u16>,
    indices: Vec<u32>,
}

/// A character under construction. What is added gets the material, joint, transform and colours
/// that are set at that time.
pub(crate) struct Builder {
    name: String,
    joints: Vec<JointSource>,
    places: Vec<DVec3>,
    materials: Vec<Material>,
    /// Side in metres of the square that a material's texture covers.
    tiles_m: Vec<Option<f64>>,
    images: Vec<Image>,
    nodes: Vec<String>,
    pieces: BTreeMap<(usize, Finish), Piece>,
    node: usize,
    finish: Finish,
    joint: usize,
    /// Transform from the space of solids to model space.
    pub(crate) at: DAffine3,
    /// Linear factors of the material's colour, and alpha.
    pub(crate) tint: [f64; 4],
    /// A factor of the material's colour by height.
    pub(crate) fade: Fade,
}

impl Builder {
    /// Returns a character of one joint at the origin, which has the character's name.
    pub(crate) fn new(name: &str) -> Self {
        let root = JointSource { name: name.into(), parent: None, rest: Trs::IDENTITY };
        Self {
            name: name.into(),
            joints: vec![root],
            places: vec![DVec3::ZERO],
            materials: Vec::new(),
            tiles_m: Vec::new(),
            images: Vec::new(),
            nodes: vec![name.into()],
            pieces: BTreeMap::new(),
            node: 0,
            finish: Finish(0),
            joint: 0,
            at: DAffine3::IDENTITY,
            tint: [1.0; 4],
            fade: Fade::NONE,
        }
    }

    /// Adds a material.
    pub(crate) fn finish(&mut self, material: Material) -> Finish {
        self.materials.push(material);
        self.tiles_m.push(None);
        Finish(self.materials.len() - 1)
    }

    /// Adds a material with a texture that covers squares of `tile_m` metres.
    pub(crate) fn tiled(&mut self, material: Material, image: Image, tile_m: f64) -> Finish {
        self.images.push(image);
        let texture = Texture {
            image: self.images.len() - 1,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            filter: TextureFilter::Linear,
        };
        let finish = self.finish(Material { base_color_texture: Some(texture), ..material });
        self.tiles_m[finish.0] = Some(tile_m);
        finish
    }

    /// Chooses a material, in its own colours.
    pub(crate) fn on(&mut self, finish: Finish) -> &mut Self {
        self.finish = finish;
        self.tint = [1.0; 4];
        self.fade = Fade::NONE;
        self
    }

    /// Chooses factors of the material's colour.
    pub(crate) fn tinted(&mut self, factors: [f64; 3]) -> &mut Self {
        self.tint = [factors[0], factors[1], factors[2], 1.0];
        self
    }

    /// Chooses a colour of the material's by height.
    pub(crate) fn faded(&mut self, [low_m, high_m]: [f64; 2], [low, high]: [f64; 2]) -> &mut Self {
        self.fade = Fade { low_m, high_m, low, high };
        self
    }

    /// Adds a joint at a place in model space, which hangs from the root.
    pub(crate) fn joint(&mut self, name: &str, place: DVec3, parent: Option<Joint>) -> Joint {
        let parent = parent.map_or(0, |joint| joint.0);
        let offset = (place - self.places[parent]).to_array().map(single);
        let rest = Trs { translation: offset, ..Trs::IDENTITY };
        self.joints.push(JointSource { name: name.into(), parent: Some(parent), rest });
        self.places.push(place);
        Joint(self.joints.len() - 1)
    }

    /// Chooses the joint that moves what follows; `None` for the root.
    pub(crate) fn moved_by(&mut self, joint: Option<Joint>) {
        self.joint = joint.map_or(0, |joint| joint.0);
    }

    /// Chooses the node of what follows; the character's own for `None`.
    pub(crate) fn node(&mut self, name: Option<&str>) {
        let name = name.unwrap_or(&self.name).to_owned();
        self.node = self.nodes.iter().position(|n| *n == name).unwrap_or_else(|| {
            self.nodes.push(name);
            self.nodes.len() - 1
        });
    }

    /// Places what follows at the origin.
    pub(crate) fn home(&mut self) {
        self.at = DAffine3::IDENTITY;
    }

    /// Adds a solid. Faces that meet at an angle of at most `crease_deg` are smooth.
    pub(crate) fn add(&mut self, solid: &Solid, crease_deg: f64) -> &mut Self {
        let ([r, g, b, a], fade) = (self.tint, self.fade);
        let factor = |position: DVec3| fade.at(position.y);
        self.colored(solid, crease_deg, |position| {
            let factor = factor(position);
            [r * factor, g * factor, b * factor, a]
        })
    }

    /// Adds a solid as [`Self::add`] does, with a factor of its colour and alpha by position.
    pub(crate) fn colored(
        &mut self,
        solid: &Solid,
        crease_deg: f64,
        color: impl Fn(DVec3) -> [f64; 4],
    ) -> &mut Self {
        let moved = solid.moved(&self.at);
        let tile_m = self.tiles_m.get(self.finish.0).copied().flatten();
        let joint = u16::try_from(self.joint).unwrap_or_default();
        let piece = self.pieces.entry((self.node, self.finish)).or_default();
        let mut known: BTreeMap<(usize, [i64; 3], usize), u32> = BTreeMap::new();
        for face in moved.corners(crease_deg) {
            let axis = solid::main_axis(face.normal);
            let mut index = |(point, normal): (usize, DVec3)| {
                let texture_axis = if tile_m.is_some() { axis } else { 0 };
                let key = (point, solid::rounded(normal), texture_axis);
                *known.entry(key).or_insert_with(|| {
                    let position = moved.points[point];
                    piece.positions.push(position);
                    piece.normals.push(normal);
                    piece.colors.push(color(position));
                    piece.joints.push(joint);
                    if let Some(tile_m) = tile_m {
                        piece.uvs.push(solid::planar(position, axis).map(|v| v / tile_m));
                    }
                    u32_from(piece.positions.len() - 1)
                })
            };
            let mut corners = face.corners;
            // Corners that meet, as at the tip of a cone, would give triangles without area.
            corners.dedup_by_key(|corner| corner.0);
            if corners.len() > 1 && corners.first().map(|c| c.0) == corners.last().map(|c| c.0) {
                corners.pop();
            }
            let indices: Vec<u32> = corners.into_iter().map(&mut index).collect();
            for pair in indices.windows(2).skip(1) {
                piece.indices.extend([indices[0], pair[0], pair[1]]);
            }
        }
        self
    }

    /// Adds a solid with flat faces.
    pub(crate) fn flat(&mut self, solid: &Solid) -> &mut Self {
        self.add(solid, 0.5)
    }

    /// Adds a box with flat faces.
    pub(crate) fn block(&mut self, low: [f64; 3], high: [f64; 3]) -> &mut Self {
        self.flat(&block(low, high))
    }

    /// Returns the character, with clips.
    pub(crate) fn build(self, clips: Vec<ClipSource>) -> Result<Character, Error> {
        let skeleton = Skeleton::new(&self.joints)?;
        let entry = |(source, place): (usize, &DVec3)| {
            let [x, y, z] = (-*place).to_array().map(single);
            let rows = [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]];
            let joint = skeleton.joint_from_source(source);
            PaletteEntry { joint, joint_from_bind: Affine { rows } }
        };
        let palette: Vec<PaletteEntry> = self.places.iter().enumerate().map(entry).collect();
        let mut parts = Vec::new();
        for ((node, finish), piece) in self.pieces {
            parts.push(Part {
                node,
                node_name: self.nodes[node].clone(),
                primitive: finish.0,
                material: Some(finish.0),
                mesh: piece.into_mesh(),
            });
        }
        let reach_m = vertex_reach_m(&skeleton, &palette, &parts);
        let skeleton = skeleton.with_reach(&reach_m);
        let clips = clips
            .into_iter()
            .map(|clip| Clip::new(clip, &skeleton).map(Arc::new))
            .collect::<Result<_, _>>()?;
        Character::new(CharacterSource {
            name: self.name,
            skeleton,
            palette,
            parts,
            materials: self.materials,
            images: self.images,
            skins: Vec::new(),
            clips,
        })
    }
}

impl Piece {
    fn into_mesh(self) -> Mesh {
        let narrow = |points: Vec<DVec3>| -> Vec<[f32; 3]> {
            points.into_iter().map(|p| p.to_array().map(single)).collect()
        };
        let count = self.positions.len();
        Mesh {
            positions: narrow(self.positions),
            normals: narrow(self.normals),
            uvs: self.uvs.into_iter().map(|uv| uv.map(single)).collect(),
            colors: self.colors.into_iter().map(|color| color.map(single)).collect(),
            influences: Influences {
                per_vertex: 4,
                entries: self.joints.into_iter().flat_map(|joint| [joint, 0, 0, 0]).collect(),
                weights: [1.0, 0.0, 0.0, 0.0].repeat(count),
            },
            indices: self.indices,
        }
    }
}
