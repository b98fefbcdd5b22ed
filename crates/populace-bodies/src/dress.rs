//! Builds characters: a body with clothes, hair and eyes as parts of one skeleton.

use glam::Vec3;
use populace_character::{
    Character, CharacterSource, Influences, Material, Mesh, PaletteEntry, Part, SkinInstance,
    sole_points, vertex_reach_m,
};
use populace_model::{Affine, JointSource, Skeleton, Trs};

use crate::body::{Body, BodySystem};
use crate::clothes::{self, Cover};
use crate::hair::Hair;
use crate::person::{Bottom, Person};
use crate::surface::{Surface, rgba, srgb};
use crate::{Error, face, shoes};

/// How far skin reaches under the edge of clothes, into shoes and skirts, and under hair, in
/// decimetres.
const UNDER_CLOTHES: f32 = 0.12;
const IN_SHOES: f32 = 0.4;
const IN_SKIRTS: f32 = 0.35;
const UNDER_HAIR: f32 = 0.3;

/// A part of a person before it becomes one of a character.
struct Piece {
    name: &'static str,
    color: [u8; 3],
    double_sided: bool,
    surface: Surface,
}

impl BodySystem {
    /// Builds a person: a character of 52 joints with Mixamo's names, in metres, facing +Z, its
    /// soles at y = 0. Its materials are named after what they are of: `Skin`, `Eyes`, `Hair`,
    /// `Top`, `Trousers` and `Shoes`, and its nodes likewise. The body under clothes is left out.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] and [`Error::BadTarget`] for a body out of its ranges, [`Error::Io`] and
    /// [`Error::BadData`] for targets that cannot be read.
    pub fn character(&mut self, person: &Person) -> Result<Character, Error> {
        let body = self.body(&person.body)?;
        let mut pieces = self.pieces(&body, person);
        pieces.retain(|piece| !piece.surface.triangles.is_empty());
        let all = pieces.iter().flat_map(|piece| &piece.surface.vertices);
        let ground = all.fold(f32::MAX, |low, v| low.min(v.at.y));
        let lift = Vec3::Y * -ground;
        for vertex in pieces.iter_mut().flat_map(|piece| &mut piece.surface.vertices) {
            vertex.at += lift;
        }
        let places: Vec<Vec3> = body.places.iter().map(|place| *place + lift).collect();
        self.assemble(&person.name, &places, &pieces)
    }

    fn pieces(&self, body: &Body, person: &Person) -> Vec<Piece> {
        let Person { features, outfit, seed, .. } = person;
        let cover = Cover { marks: &self.marks, outfit };
        let hair = Hair { marks: &self.marks, features, seed: *seed };
        let under_bottom = match outfit.bottom {
            Bottom::Skirt => IN_SKIRTS,
            _ => UNDER_CLOTHES,
        };
        let bare = body.skin.kept(|v| {
            let clothes = (UNDER_CLOTHES - cover.top(v)).min(under_bottom - cover.bottom(v));
            clothes.min(IN_SHOES - cover.shoe(v)).min(UNDER_HAIR - hair.scalp(v))
        });
        let mut hairs = hair.all(body);
        hairs.add(&face::brows(body, self));
        let bottom = match outfit.bottom {
            Bottom::Skirt => "Trousers (skirt)",
            Bottom::Shorts => "Trousers (shorts)",
            Bottom::Trousers => "Trousers",
        };
        let piece = |name, color, surface| Piece { name, color, double_sided: false, surface };
        let two_sided = |piece| Piece { double_sided: true, ..piece };
        vec![
            piece("Skin", features.skin_color, face::painted(&bare, &self.marks, features)),
            piece("Eyes", [255; 3], face::eyes(body, self, features)),
            two_sided(piece("Hair", features.hair_color, hairs)),
            piece("Top", outfit.top_color, clothes::top(body, &cover)),
            two_sided(piece(bottom, outfit.bottom_color, clothes::bottom(body, &cover))),
            piece("Shoes", outfit.shoe_color, shoes::shoes(body, &cover)),
        ]
    }

    fn assemble(&self, name: &str, places: &[Vec3], pieces: &[Piece]) -> Result<Character, Error> {
        let joint = |(index, joint): (usize, &crate::rig_file::RigJoint)| JointSource {
            name: joint.name.clone(),
            parent: joint.parent,
            rest: Trs {
                translation: (places[index] - joint.parent.map_or(Vec3::ZERO, |p| places[p]))
                    .to_array(),
                ..Trs::IDENTITY
            },
        };
        let joints: Vec<_> = self.rig.joints.iter().enumerate().map(joint).collect();
        let skeleton = Skeleton::new(&joints)?;
        let palette: Vec<PaletteEntry> = places
            .iter()
            .enumerate()
            .map(|(index, place)| PaletteEntry {
                joint: skeleton.joint_from_source(index),
                joint_from_bind: Affine::from_trs(&Trs {
                    translation: (-*place).to_array(),
                    ..Trs::IDENTITY
                }),
            })
            .collect();
        let first_node = joints.len();
        let part = |(index, piece): (usize, &Piece)| Part {
            node: first_node + index,
            node_name: piece.name.to_owned(),
            primitive: 0,
            material: Some(index),
            mesh: mesh_of(&piece.surface),
        };
        let parts: Vec<Part> = pieces.iter().enumerate().map(part).collect();
        let materials = pieces.iter().map(|piece| Material {
            name: piece.name.to_owned(),
            base_color: rgba(srgb(piece.color)),
            double_sided: piece.double_sided,
            ..Material::default()
        });
        let skin = |part: &Part| SkinInstance { skin: 0, node: part.node, joints: palette.clone() };
        let skeleton = skeleton.clone().with_reach(&vertex_reach_m(&skeleton, &palette, &parts));
        let soles = sole_points(&skeleton, &palette, &parts);
        Ok(Character::new(CharacterSource {
            name: name.to_owned(),
            skeleton: skeleton.with_soles(&soles),
            skins: parts.iter().map(skin).collect(),
            palette,
            materials: materials.collect(),
            parts,
            images: Vec::new(),
            clips: Vec::new(),
        })?)
    }
}

fn mesh_of(surface: &Surface) -> Mesh {
    let vertices = &surface.vertices;
    Mesh {
        positions: vertices.iter().map(|v| v.at.to_array()).collect(),
        normals: vertices.iter().map(|v| v.normal.to_array()).collect(),
        uvs: Vec::new(),
        colors: vertices.iter().map(|v| rgba(v.color)).collect(),
        influences: Influences {
            per_vertex: 4,
            entries: vertices.iter().flat_map(|v| v.weights.joints).collect(),
            weights: vertices.iter().flat_map(|v| v.weights.shares).collect(),
        },
        indices: surface.triangles.iter().flatten().copied().collect(),
    }
}
