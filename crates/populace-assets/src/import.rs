//! Top level of the import: runs all stages in order, from bytes to a character.

use std::path::PathBuf;

use populace_character::{Character, CharacterSource, PaletteEntry, Part, SkinInstance};
use populace_model::Affine;

use crate::animations::{self, Animation, Clips};
use crate::budget::Budget;
use crate::data::Data;
use crate::extensions;
use crate::extents::Extents;
use crate::folder::Folder;
use crate::influences::Palette;
use crate::json::Cursor;
use crate::levels::Levels;
use crate::log::{Checked, Log};
use crate::materials;
use crate::nodes::{self, Ancestry, Counts, Node};
use crate::parts::{Mover, PartBuilder, PartSource};
use crate::primitive::{self, Mesh};
use crate::rig::Rig;
use crate::skins::{self, Skin};
use crate::tree;
use crate::uri::Uri;
use crate::{Imported, SkinInfo, glb, levels};

/// Imports the bytes of a file. Problems and notes go to the log.
pub(crate) fn import(
    bytes: &[u8],
    name: &str,
    folder: &Folder,
    budget: &Budget,
    log: &Log,
) -> Checked<Imported> {
    let container = glb::split(bytes, log)?;
    let value = tree::parse(without_padding(container.json, log), budget, log)?;
    let root = Cursor::root(&value, log);
    let generator = check_asset(&root);
    let extensions = extensions::check(&root)?;
    nodes::check_count(&root, budget)?;
    let data = Data::new(&root, log, &container, budget, folder);
    let surfaces = materials::read(&root, &data, log, budget, folder);
    let document = Document::read(&root, &data, log, surfaces.materials.len());
    document.forest?;
    let mut rig = document.rig(log)?;
    let assembly = Assembly {
        document: &document,
        rig: &rig,
        builder: PartBuilder { data: &data, log, extensions, textures: &surfaces.textures },
    };
    let mut palette = Palette::default();
    let built = assembly.parts(&mut palette);
    if let Ok(built) = &built {
        rig.measure_vertices(palette.entries(), &built.parts, &built.skins);
        if !document.animations.is_empty() {
            rig.note_far_vertices(palette.entries(), &built.parts, log);
        }
    }
    let clips = Clips::new(&data, log, &rig).all(&document.animations);
    let Built { parts, vertex_counts, skins, levels } = built?;
    let clips = clips?;
    Extents::of(&rig, &clips).check(&rig, &document.nodes, log)?;
    data.note_unused_buffers();
    let node_from_joint = rig.node_from_joint();
    let character = Character::new(CharacterSource {
        name: name.to_owned(),
        skeleton: rig.skeleton,
        palette: palette.into_entries(),
        parts,
        materials: surfaces.materials,
        images: surfaces.images,
        skins,
        clips,
    });
    let character = character.and_then(|character| levels.give(character, &document.nodes, log));
    Ok(Imported {
        character: character.map_err(|e| log.problem("file", e.to_string()))?,
        notes: Vec::new(),
        generator: generator?,
        node_from_joint,
        named_files: named_files(&root, folder),
        vertex_counts,
        skins: document.skins.iter().flatten().map(SkinInfo::of).collect(),
    })
}

/// Returns the paths that buffers and images refer to, in file order.
fn named_files(root: &Cursor, folder: &Folder) -> Vec<PathBuf> {
    let holders = root.list("buffers").into_iter().chain(root.list("images"));
    let uris = holders.filter_map(|holder| holder.get("uri")?.text().ok());
    let path = |uri: &str| match Uri::parse(uri) {
        Ok(Uri::File(path)) => folder.join(&path),
        _ => None,
    };
    uris.filter_map(path).collect()
}

/// Removes zeros from the end of the JSON chunk, which some exporters write in place of spaces.
fn without_padding<'a>(json: &'a [u8], log: &Log) -> &'a [u8] {
    let end = json.iter().rposition(|b| *b != 0).map_or(0, |at| at + 1);
    if end < json.len() {
        log.note(
            "chunk 0",
            "is padded with zeros; JSON must be padded with spaces (glTF 2.0, section 4.4.3.2)",
        );
    }
    &json[..end]
}

/// Checks the version and returns the generator (glTF 2.0, section 3.2).
fn check_asset(root: &Cursor) -> Checked<Option<String>> {
    let asset = root.require("asset")?;
    let version = asset.require("version")?;
    if version.text()?.split('.').next() != Some("2") {
        return Err(
            version.problem(format!("is \"{}\"; only version 2 is supported", version.text()?))
        );
    }
    if let Some(least) = asset.get("minVersion") {
        match least.text()? {
            "2.0" => {}
            text if text.split('.').next() == Some("2") => {
                least.note(format!("asks for version {text}; features after 2.0 are ignored"));
            }
            text => {
                return Err(least.problem(format!("is \"{text}\"; only version 2 is supported")));
            }
        }
    }
    Ok(asset.optional("generator", Cursor::text)?.map(str::to_owned))
}

impl SkinInfo {
    fn of(skin: &Skin) -> Self {
        Self { name: skin.name.clone(), joint_count: skin.joints.len() }
    }
}

/// The declarations of nodes, meshes, skins and animations.
struct Document {
    nodes: Vec<Node>,
    /// Whether the nodes form a forest.
    forest: Checked<()>,
    meshes: Vec<Mesh>,
    skins: Vec<Checked<Skin>>,
    animations: Vec<Animation>,
}

impl Document {
    fn read(root: &Cursor, data: &Data, log: &Log, material_count: usize) -> Self {
        let meshes = primitive::read_meshes(root, data.accessor_count(), material_count);
        let counts = Counts {
            meshes: meshes.len(),
            skins: root.objects("skins").len(),
            cameras: root.objects("cameras").len(),
        };
        let (nodes, forest) = nodes::read(root, log, counts);
        let skins = skins::read(root, nodes.len(), data);
        let animations = animations::read(root, &nodes, data);
        for primitive in meshes.iter().flatten().flatten().filter(|p| p.has_morph_targets) {
            log.note(&primitive.place, "has morph targets, which are ignored");
        }
        Self { nodes, forest, meshes, skins, animations }
    }

    /// Builds the skeleton from skin joints and their descendants, nodes with meshes of their own,
    /// and animated nodes.
    fn rig(&self, log: &Log) -> Checked<Rig> {
        let ancestry = Ancestry::new(&self.nodes);
        let mut joints = Vec::new();
        for skin in self.skins.iter().flatten() {
            skin.note_roots(&self.nodes, &ancestry, log);
            joints.extend_from_slice(&skin.joints);
        }
        let rigid = (0..self.nodes.len())
            .filter(|n| self.nodes[*n].in_scene && self.is_rigid(&self.nodes[*n]));
        let driven = self.animations.iter().flat_map(|a| a.channels.iter().map(|c| c.node));
        Rig::new(&self.nodes, rigid.chain(driven), &joints, log)
    }

    /// Returns whether a node has a mesh that moves rigidly with it.
    fn is_rigid(&self, node: &Node) -> bool {
        let mut primitives = node.mesh.iter().flat_map(|m| self.meshes[*m].iter().flatten());
        primitives.any(|p| node.skin.is_none() || !p.is_skinned())
    }
}

/// Least memory of a part in bytes, without its mesh.
const PART_BYTES: usize = size_of::<Part>();

struct Assembly<'a> {
    document: &'a Document,
    rig: &'a Rig,
    builder: PartBuilder<'a>,
}

/// Parts made of the nodes with meshes.
#[derive(Default)]
struct Built {
    parts: Vec<Part>,
    /// The file's vertex count of each part.
    vertex_counts: Vec<usize>,
    /// The skins of the nodes that have one.
    skins: Vec<SkinInstance>,
    levels: Levels,
}

impl Assembly<'_> {
    /// Builds the parts of all nodes in the scene.
    fn parts(&self, palette: &mut Palette) -> Checked<Built> {
        let mut built = Built::default();
        let mut failed = None;
        for (index, node) in self.document.nodes.iter().enumerate().filter(|(_, n)| n.in_scene) {
            let Some(mesh) = node.mesh else { continue };
            let Ok(skin) = self.skin_instance(index, node).inspect_err(|r| failed = Some(*r))
            else {
                continue;
            };
            for (primitive, declared) in self.document.meshes[mesh].iter().enumerate() {
                let node_name = self.rig.node_name(&self.document.nodes, index);
                // Charged even if the primitive has no triangles: many nodes times many empty
                // primitives would take long without using memory.
                self.builder.data.budget.charge(&node.place, PART_BYTES + node_name.len())?;
                let Ok(declared) = declared else { continue };
                let mover = match &skin {
                    Some(skin) if declared.is_skinned() => Mover::Skin(&skin.joints),
                    _ => self.rigid_mover(index, node, declared, skin.is_some())?,
                };
                let source = PartSource { node: index, node_name, primitive };
                match self.builder.part(source, declared, mover, palette) {
                    Ok(Some((part, count))) => {
                        built.parts.push(part);
                        built.vertex_counts.push(count);
                        let levels = self.levels(index, primitive, mover, palette);
                        levels.map_or_else(|r| failed = Some(r), |l| built.levels.add(index, l));
                    }
                    Ok(None) => {}
                    Err(reported) => failed = Some(reported),
                }
            }
            built.skins.extend(skin);
        }
        failed.map_or(Ok(built), Err)
    }

    /// Builds the coarser meshes of a primitive. A level without it has a mesh without triangles.
    fn levels(
        &self,
        index: usize,
        primitive: usize,
        mover: Mover,
        palette: &mut Palette,
    ) -> Checked<Vec<populace_character::Mesh>> {
        let nodes = &self.document.nodes;
        let mesh = |level: &(usize, f32)| {
            let coarse = &nodes[level.0];
            let declared = coarse.mesh.and_then(|m| self.document.meshes[m].get(primitive));
            let Some(declared) = declared else { return Ok(levels::empty()) };
            let declared = declared.as_ref().map_err(|reported| *reported)?;
            if coarse.skin != nodes[index].skin
                || matches!(mover, Mover::Skin(_)) != declared.is_skinned()
            {
                return Err(self.builder.log.problem(
                    &coarse.place,
                    "is a level of detail of a node with another skin; both must have the same",
                ));
            }
            let source = PartSource { node: level.0, node_name: String::new(), primitive };
            let part = self.builder.part(source, declared, mover, palette)?;
            Ok(part.map_or_else(levels::empty, |(part, _)| part.mesh))
        };
        nodes[index].levels.iter().map(mesh).collect()
    }

    fn rigid_mover(
        &self,
        index: usize,
        node: &Node,
        declared: &primitive::Primitive,
        has_skin: bool,
    ) -> Checked<Mover<'_>> {
        let log = self.builder.log;
        if has_skin {
            log.note(
                &declared.place,
                "has no joints and weights, although its node has a skin; it moves with the node",
            );
        }
        let joint = self.rig.joint_from_node[index]
            .ok_or_else(|| log.problem(&node.place, "has a mesh, but did not become a joint"))?;
        Ok(Mover::Rigid { joint })
    }

    /// Returns the skin of a mesh node with its joints mapped to the skeleton.
    fn skin_instance(&self, index: usize, node: &Node) -> Checked<Option<SkinInstance>> {
        let Some(skin_index) = node.skin else {
            return Ok(None);
        };
        let skin = self.document.skins[skin_index].as_ref().map_err(|reported| *reported)?;
        self.builder
            .data
            .budget
            .charge(&node.place, skin.joints.len().saturating_mul(size_of::<PaletteEntry>()))?;
        let matrices = skin.bind_matrices(self.builder.data, self.builder.log)?;
        let entry = |(node, joint_from_bind): (&usize, Affine)| {
            // The skeleton contains all joints of all skins, so this is never `None`.
            Some(PaletteEntry { joint: self.rig.joint_from_node[*node]?, joint_from_bind })
        };
        Ok(Some(SkinInstance {
            skin: skin_index,
            node: index,
            joints: skin.joints.iter().zip(matrices).filter_map(entry).collect(),
        }))
    }
}
