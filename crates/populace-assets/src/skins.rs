//! Skins: joints and inverse bind matrices (glTF 2.0, section 3.7.3).

use std::collections::HashSet;

use populace_model::Affine;

use crate::accessor::{Component, Shape};
use crate::data::{Data, Format};
use crate::json::Cursor;
use crate::log::{Checked, Log};
use crate::nodes::{Ancestry, Node};

/// The declaration of a skin.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    pub(crate) place: String,
    pub(crate) name: String,
    /// Joint nodes, in the order that the vertices index.
    pub(crate) joints: Vec<usize>,
    skeleton: Option<usize>,
    inverse_bind: Option<usize>,
}

/// Reads and checks the declarations of all skins. The `skeleton` property is not used, but it must
/// refer to an existing node.
pub(crate) fn read(root: &Cursor, node_count: usize, data: &Data) -> Vec<Checked<Skin>> {
    let read = |at: &Cursor| read_skin(at, node_count, data);
    root.objects("skins").iter().map(read).collect()
}

fn read_skin(at: &Cursor, node_count: usize, data: &Data) -> Checked<Skin> {
    let skeleton = at.optional("skeleton", |s| s.index(node_count, "node"));
    let joints = at.require("joints").and_then(|joints| {
        let items = joints.items()?;
        if items.is_empty() {
            return Err(joints.problem("is empty; a skin must have at least one joint"));
        }
        let nodes: Vec<_> = items.iter().map(|j| j.index(node_count, "node")).collect();
        nodes.into_iter().collect::<Checked<Vec<usize>>>()
    });
    let inverse_bind =
        at.optional("inverseBindMatrices", |i| i.index(data.accessor_count(), "accessor"));
    let (joints, inverse_bind, skeleton) = (joints?, inverse_bind?, skeleton?);
    let mut seen = HashSet::new();
    if let Some(twice) = joints.iter().find(|j| !seen.insert(**j)) {
        at.note(format!("lists node {twice} more than once in its joints"));
    }
    if let Some(index) = inverse_bind {
        let format = [Format::plain(Shape::MAT4, Component::F32)];
        let accessor = data.accessor_with_format(index, "inverse bind matrices", &format)?;
        if accessor.count < joints.len() {
            return Err(at.problem(format!(
                "has {} joints, but only {} inverse bind matrices; each joint needs one",
                joints.len(),
                accessor.count
            )));
        }
        if data.has_stride(accessor) {
            at.note(
                "has inverse bind matrices in a buffer view with a byteStride, which only vertex \
                 data may have; it is used anyway",
            );
        }
    }
    Ok(Skin { place: at.place().to_owned(), name: at.name(), joints, skeleton, inverse_bind })
}

impl Skin {
    /// Returns `joint_from_bind` of each joint, or identities if the file has no inverse bind
    /// matrices.
    pub(crate) fn bind_matrices(&self, data: &Data, log: &Log) -> Checked<Vec<Affine>> {
        let Some(index) = self.inverse_bind else {
            return Ok(vec![Affine::IDENTITY; self.joints.len()]);
        };
        let matrices = data.vectors::<16>(index)?;
        for (at, m) in matrices.iter().enumerate().take(self.joints.len()) {
            let last_row = [m[3], m[7], m[11], m[15] - 1.0];
            if last_row.iter().any(|v| v.abs() > 1e-3) {
                let what =
                    format!("has an inverse bind matrix {at} with a last row other than 0 0 0 1");
                return Err(log.problem(&self.place, what));
            }
        }
        Ok(matrices.iter().take(self.joints.len()).map(Affine::from_cols_array).collect())
    }

    /// Adds notes about joints without a common root, a `skeleton` that is not an ancestor, and
    /// joints outside the scene. glTF forbids these, but the import does not depend on them.
    pub(crate) fn note_roots(&self, nodes: &[Node], ancestry: &Ancestry, log: &Log) {
        let mut own = self.joints.iter().map(|j| ancestry.roots[*j]);
        let first = own.next();
        if own.any(|root| Some(root) != first) {
            log.note(&self.place, "has joints without a common root (glTF 2.0, section 3.7.3.2)");
        }
        let misplaced =
            |root: usize| self.joints.iter().any(|j| !ancestry.is_at_or_below(*j, root));
        if self.skeleton.is_some_and(misplaced) {
            let what = "is not an ancestor of all joints of the skin; it is a hint and not used";
            log.note(format!("{}.skeleton", self.place), what);
        }
        if self.joints.iter().any(|j| !nodes[*j].in_scene) {
            log.note(&self.place, "has joints that are not in the scene; they are imported anyway");
        }
    }
}
