//! Writes characters as binary glTF files, with levels of detail.
//!
//! Levels are stored as the extension MSFT_lod
//! (<https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/MSFT_lod>): the node of
//! each part names the nodes of its coarser meshes, which are in no scene, so that programs without
//! the extension show the finest level alone. `extras.error_m` of the node lists the levels' errors
//! in metres at rest.

mod buffer;
mod pictures;

use std::collections::HashMap;

use populace_character::{AlphaMode, Character, Material, Mesh, Part, Texture};
use populace_model::{Affine, JointIndex};
use serde_json::{Map, Value, json};

use crate::Error;
use buffer::Buffer;

/// Program and rights that a written file names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions<'a> {
    /// The program that writes the file (`asset.generator`); empty to name none.
    pub generator: &'a str,
    /// Authors and terms of use (`asset.copyright`); empty to name none.
    pub copyright: &'a str,
}

/// Returns a character with its levels of detail as a binary glTF 2.0 file. Each part becomes a
/// node with a mesh of one primitive. Clips are not written.
///
/// Reading the file gives the same skeleton, parts, materials and levels. Parts that moved rigidly
/// with a joint have a skin of that joint. Joints that are neither above nor below one that moves
/// vertices are not read again.
///
/// # Errors
///
/// [`Error::Unwritable`] if a part has no triangles, which a mesh of glTF must have, or two palette
/// entries of one joint, which a skin of glTF cannot have, if an image cannot be encoded, or if the file would take 4 GiB or more.
pub fn to_glb(character: &Character, options: &WriteOptions) -> Result<Vec<u8>, Error> {
    let mut writer = Writer::new(character);
    for index in 0..character.parts.len() {
        writer.part(index)?;
    }
    let document = writer.finish(options)?;
    writer.buffer.glb(&document).ok_or_else(|| Error::Unwritable {
        character: character.name.clone(),
        what: "it takes 4 GiB or more".into(),
    })
}

/// A file in the making: the lists of its objects, and its data.
struct Writer<'a> {
    character: &'a Character,
    buffer: Buffer,
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    skins: Vec<Value>,
    /// Skins by the palette entries that they hold, in order.
    known_skins: HashMap<Vec<u16>, usize>,
    /// Nodes without a parent.
    roots: Vec<usize>,
}

impl<'a> Writer<'a> {
    /// Starts with the joints, in level order.
    fn new(character: &'a Character) -> Self {
        let skeleton = &character.skeleton;
        let (mut roots, mut children) = (Vec::new(), vec![Vec::new(); skeleton.joint_count()]);
        for joint in skeleton.joints() {
            let siblings = match skeleton.parent(joint) {
                Some(parent) => &mut children[parent.index()],
                None => &mut roots,
            };
            siblings.push(joint.index());
        }
        let node = |joint: JointIndex| {
            let rest = skeleton.rest(joint);
            let mut node = json!({
                "name": skeleton.name(joint),
                "translation": rest.translation,
                "rotation": rest.rotation,
                "scale": rest.scale,
            });
            let children = &children[joint.index()];
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            node
        };
        Self {
            character,
            buffer: Buffer::default(),
            nodes: skeleton.joints().map(node).collect(),
            meshes: Vec::new(),
            skins: Vec::new(),
            known_skins: HashMap::new(),
            roots,
        }
    }

    fn fail<T>(&self, what: String) -> Result<T, Error> {
        Err(Error::Unwritable { character: self.character.name.clone(), what })
    }

    /// Adds a part with its levels.
    fn part(&mut self, index: usize) -> Result<(), Error> {
        let character = self.character;
        let part = &character.parts[index];
        if part.mesh.indices.is_empty() {
            return self.fail(format!(
                "its part \"{}\" has no triangles, which glTF cannot hold; leave it out",
                part.node_name
            ));
        }
        let levels = character.levels().iter().map(|level| &level.meshes[index]);
        let meshes: Vec<&Mesh> = std::iter::once(&part.mesh).chain(levels).collect();
        let (skin, slots) = self.skin(part, &meshes)?;
        let first = self.nodes.len();
        for (level, mesh) in meshes.iter().enumerate() {
            let mut node = json!({ "name": part.node_name });
            if !mesh.indices.is_empty() {
                node["mesh"] = self.mesh(part, mesh, &slots).into();
                node["skin"] = skin.into();
            }
            if level == 0 && meshes.len() > 1 {
                let ids: Vec<usize> = (1..meshes.len()).map(|level| first + level).collect();
                node["extensions"] = json!({ "MSFT_lod": { "ids": ids } });
                let errors_m: Vec<f32> = character.levels().iter().map(|l| l.error_m).collect();
                node["extras"] = json!({ "error_m": errors_m });
            }
            self.nodes.push(node);
        }
        self.roots.push(first);
        Ok(())
    }

    /// Returns a skin with all palette entries of a part, and the place in it of each entry.
    fn skin(&mut self, part: &Part, meshes: &[&Mesh]) -> Result<(usize, Vec<u16>), Error> {
        let palette = &self.character.palette;
        let mut used = vec![false; palette.len()];
        for mesh in meshes {
            mesh.influences.entries.iter().for_each(|entry| used[usize::from(*entry)] = true);
        }
        let mut slots = vec![0; palette.len()];
        let mut entries: Vec<u16> = Vec::new();
        let mut joints = HashMap::new();
        for (entry, slot) in (0u16..).zip(&mut slots).filter(|(e, _)| used[usize::from(*e)]) {
            let joint = palette[usize::from(entry)].joint;
            if joints.insert(joint, entry).is_some() {
                let joint = self.character.skeleton.name(joint);
                let part = &part.node_name;
                return self.fail(format!(
                    "its part \"{part}\" binds the joint \"{joint}\" in two ways, which one skin \
                     cannot hold"
                ));
            }
            *slot = u16::try_from(entries.len()).unwrap_or(u16::MAX);
            entries.push(entry);
        }
        if let Some(known) = self.known_skins.get(&entries) {
            return Ok((*known, slots));
        }
        let of = |entry: &u16| &palette[usize::from(*entry)];
        let binds: Vec<f32> =
            entries.iter().flat_map(|e| columns(&of(e).joint_from_bind)).collect();
        let accessor = self.buffer.floats(&binds, "MAT4", None);
        let nodes: Vec<usize> = entries.iter().map(|e| of(e).joint.index()).collect();
        self.skins.push(json!({ "joints": nodes, "inverseBindMatrices": accessor }));
        self.known_skins.insert(entries, self.skins.len() - 1);
        Ok((self.skins.len() - 1, slots))
    }

    fn mesh(&mut self, part: &Part, mesh: &Mesh, slots: &[u16]) -> usize {
        let buffer = &mut self.buffer;
        let flat = |vectors: &[[f32; 3]]| vectors.iter().flatten().copied().collect::<Vec<_>>();
        let mut attributes = Map::new();
        let mut add = |name: &str, accessor: usize| attributes.insert(name.into(), accessor.into());
        add("POSITION", buffer.positions(&mesh.positions));
        add("NORMAL", buffer.vertices(&flat(&mesh.normals), "VEC3"));
        if !mesh.uvs.is_empty() {
            let uvs: Vec<f32> = mesh.uvs.iter().flatten().copied().collect();
            add("TEXCOORD_0", buffer.vertices(&uvs, "VEC2"));
        }
        if !mesh.colors.is_empty() {
            let colors: Vec<f32> = mesh.colors.iter().flatten().copied().collect();
            add("COLOR_0", buffer.vertices(&colors, "VEC4"));
        }
        let influences = &mesh.influences;
        for set in 0..influences.per_vertex / 4 {
            let of_set = |at: &usize| at % influences.per_vertex / 4 == set;
            let all = 0..influences.entries.len();
            let places: Vec<usize> = all.filter(of_set).collect();
            // glTF wants joint 0 where there is no weight, and no joint twice.
            let joint = |at: &usize| match influences.weights[*at] {
                0.0 => 0,
                _ => slots[usize::from(influences.entries[*at])],
            };
            let joints: Vec<u16> = places.iter().map(joint).collect();
            let weights: Vec<f32> = places.iter().map(|at| influences.weights[*at]).collect();
            add(&format!("JOINTS_{set}"), buffer.joints(&joints));
            add(&format!("WEIGHTS_{set}"), buffer.vertices(&weights, "VEC4"));
        }
        let indices = buffer.indices(&mesh.indices, mesh.positions.len());
        let mut primitive = json!({ "attributes": attributes, "indices": indices });
        if let Some(material) = part.material {
            primitive["material"] = material.into();
        }
        self.meshes.push(json!({ "name": part.node_name, "primitives": [primitive] }));
        self.meshes.len() - 1
    }

    /// Returns the JSON document.
    fn finish(&mut self, options: &WriteOptions) -> Result<Value, Error> {
        let character = self.character;
        let mut asset = json!({ "version": "2.0" });
        for (name, text) in [("generator", options.generator), ("copyright", options.copyright)] {
            if !text.is_empty() {
                asset[name] = text.into();
            }
        }
        let mut document = json!({
            "asset": asset,
            "scene": 0,
            "scenes": [{ "name": character.name, "nodes": self.roots }],
            "nodes": self.nodes,
        });
        let textures: Vec<Texture> =
            character.materials.iter().flat_map(Material::textures).collect();
        let materials = character.materials.iter().map(|m| material(m, &textures));
        let mut list = |name: &str, items: Vec<Value>| {
            if !items.is_empty() {
                document[name] = items.into();
            }
        };
        list("materials", materials.collect());
        list(
            "textures",
            textures
                .iter()
                .zip(0..)
                .map(|(t, index)| json!({ "source": t.image, "sampler": index }))
                .collect(),
        );
        list("samplers", textures.iter().map(pictures::sampler).collect());
        let mut images = Vec::new();
        for (index, image) in character.images.iter().enumerate() {
            let Some(png) = pictures::png(image) else {
                return self.fail(format!("its image {index} cannot be encoded as PNG"));
            };
            let view = self.buffer.view(&png, None);
            images.push(json!({ "bufferView": view, "mimeType": "image/png" }));
        }
        list("images", images);
        list("meshes", std::mem::take(&mut self.meshes));
        list("skins", std::mem::take(&mut self.skins));
        self.buffer.describe(&mut document);
        let glows = character.materials.iter().any(|m| m.emissive.iter().any(|c| *c > 1.0));
        let used = [
            (!character.levels().is_empty(), "MSFT_lod"),
            (glows, "KHR_materials_emissive_strength"),
        ];
        let used: Vec<&str> =
            used.into_iter().filter_map(|(is_used, name)| is_used.then_some(name)).collect();
        if !used.is_empty() {
            document["extensionsUsed"] = json!(used);
        }
        Ok(document)
    }
}

/// Returns a matrix of glTF: 16 numbers, column by column.
fn columns(affine: &Affine) -> [f32; 16] {
    let mut columns = [0.0; 16];
    for (row, values) in affine.rows.iter().enumerate() {
        for (column, value) in values.iter().enumerate() {
            columns[column * 4 + row] = *value;
        }
    }
    columns[15] = 1.0;
    columns
}

fn material(material: &Material, textures: &[Texture]) -> Value {
    let index = |texture: Texture| textures.iter().position(|known| *known == texture).unwrap_or(0);
    let mut metallic = json!({
        "baseColorFactor": material.base_color,
        "metallicFactor": material.metallic,
        "roughnessFactor": material.roughness,
    });
    if let Some(texture) = material.base_color_texture {
        metallic["baseColorTexture"] = json!({ "index": index(texture) });
    }
    if let Some(texture) = material.metallic_roughness_texture {
        metallic["metallicRoughnessTexture"] = json!({ "index": index(texture) });
    }
    let mut written = json!({ "pbrMetallicRoughness": metallic });
    if let Some(texture) = material.normal_texture {
        written["normalTexture"] =
            json!({ "index": index(texture), "scale": material.normal_scale });
    }
    if let Some(texture) = material.occlusion_texture {
        written["occlusionTexture"] =
            json!({ "index": index(texture), "strength": material.occlusion_strength });
    }
    if let Some(texture) = material.emissive_texture {
        written["emissiveTexture"] = json!({ "index": index(texture) });
    }
    // The factor of glTF is at most 1; an extension multiplies it.
    let strength = material.emissive.into_iter().fold(1.0, f32::max);
    if material.emissive != [0.0; 3] {
        written["emissiveFactor"] = json!(material.emissive.map(|c| c / strength));
    }
    if strength > 1.0 {
        written["extensions"] =
            json!({ "KHR_materials_emissive_strength": { "emissiveStrength": strength } });
    }
    if !material.name.is_empty() {
        written["name"] = material.name.as_str().into();
    }
    match material.alpha {
        AlphaMode::Opaque => {}
        AlphaMode::Mask { cutoff } => {
            written["alphaMode"] = "MASK".into();
            written["alphaCutoff"] = cutoff.into();
        }
        AlphaMode::Blend => written["alphaMode"] = "BLEND".into(),
    }
    if material.double_sided {
        written["doubleSided"] = true.into();
    }
    written
}
