//! The node forest and the nodes of the imported scene (glTF 2.0, section 3.5).

use glam::{DMat3, DQuat, DVec3};
use populace_model::Trs;

use crate::budget::Budget;
use crate::json::{Cursor, to_f32};
use crate::log::{Checked, Log, Reported};

/// Tolerance of the shear test: the largest error of a matrix column after decomposition, relative
/// to the length of the column.
const SHEAR: f64 = 1e-3;

/// A node.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) place: String,
    /// Empty if the file gives none.
    pub(crate) name: String,
    pub(crate) parent: Option<usize>,
    pub(crate) children: Vec<usize>,
    pub(crate) local: Trs,
    pub(crate) has_matrix: bool,
    pub(crate) mesh: Option<usize>,
    pub(crate) skin: Option<usize>,
    /// Whether the node belongs to the imported scene.
    pub(crate) in_scene: bool,
    /// Nodes with coarser meshes, finest first, and their errors in metres (MSFT_lod).
    pub(crate) levels: Vec<(usize, f32)>,
}

/// Numbers of the objects that nodes can refer to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    pub(crate) meshes: usize,
    pub(crate) skins: usize,
    pub(crate) cameras: usize,
}

/// Maximum number of nodes of a file.
const MAX_NODES: usize = 1 << 17;
/// Upper bound of the memory of a node during the import in bytes, without its name and JSON.
const NODE_BYTES: u64 = 1200;

/// Checks the number of nodes and reserves their memory.
pub(crate) fn check_count(root: &Cursor, budget: &Budget) -> Checked<()> {
    let Some(at) = root.get("nodes") else { return Ok(()) };
    let count = at.item_count();
    if count > MAX_NODES {
        return Err(at.problem(format!("has {count} nodes; at most {MAX_NODES} are supported")));
    }
    budget.take(at.place(), format!("{count} nodes"), count as u64 * NODE_BYTES)
}

/// Reads all nodes and marks those of the scene. The second value says whether the nodes form a
/// forest, which later stages need. Invalid properties of single nodes are logged and treated as
/// missing.
pub(crate) fn read(root: &Cursor, log: &Log, counts: Counts) -> (Vec<Node>, Checked<()>) {
    let items = root.objects("nodes");
    let mut nodes: Vec<_> = items.iter().map(|at| read_node(at, items.len(), counts)).collect();
    let linked = link(&mut nodes, log);
    let acyclic = check_cycles(&nodes, log);
    let roots = scene_roots(root, &nodes);
    let forest = linked.and(acyclic).and(roots.map(|roots| mark_scene(&mut nodes, roots)));
    (nodes, forest)
}

/// Marks the nodes at and below `roots` as part of the scene.
fn mark_scene(nodes: &mut [Node], roots: Vec<usize>) {
    let mut rest = roots;
    while let Some(node) = rest.pop() {
        if !std::mem::replace(&mut nodes[node].in_scene, true) {
            rest.extend_from_slice(&nodes[node].children);
        }
    }
}

/// Depth-first numbering of a forest, which answers ancestor queries in constant time.
pub(crate) struct Ancestry {
    /// Root of each node's tree.
    pub(crate) roots: Vec<usize>,
    /// For each node, the half-open range of depth-first indices of its subtree.
    spans: Vec<(usize, usize)>,
}

impl Ancestry {
    pub(crate) fn new(nodes: &[Node]) -> Self {
        let mut roots: Vec<_> = (0..nodes.len()).collect();
        let mut spans = vec![(0, 0); nodes.len()];
        let mut order = Vec::with_capacity(nodes.len());
        let mut rest: Vec<_> = (0..nodes.len()).filter(|n| nodes[*n].parent.is_none()).collect();
        while let Some(node) = rest.pop() {
            spans[node] = (order.len(), order.len() + 1);
            order.push(node);
            for &child in &nodes[node].children {
                roots[child] = roots[node];
                rest.push(child);
            }
        }
        for &node in order.iter().rev() {
            if let Some(parent) = nodes[node].parent {
                spans[parent].1 = spans[parent].1.max(spans[node].1);
            }
        }
        Self { roots, spans }
    }

    /// Returns whether `node` is `root` or one of its descendants.
    pub(crate) fn is_at_or_below(&self, node: usize, root: usize) -> bool {
        (self.spans[root].0..self.spans[root].1).contains(&self.spans[node].0)
    }
}

fn read_node(at: &Cursor, count: usize, counts: Counts) -> Node {
    let index = |key, count, what: &str| at.optional(key, |i| i.index(count, what)).ok().flatten();
    if let Some(extensions) = at.get("extensions") {
        extensions.object().ok();
    }
    index("camera", counts.cameras, "camera");
    let children = at.list("children");
    Node {
        place: at.place().to_owned(),
        name: at.name(),
        parent: None,
        children: children.iter().filter_map(|c| c.index(count, "node").ok()).collect(),
        local: read_local(at).unwrap_or(Trs::IDENTITY),
        has_matrix: at.get("matrix").is_some(),
        mesh: index("mesh", counts.meshes, "mesh"),
        skin: index("skin", counts.skins, "skin"),
        in_scene: false,
        levels: read_levels(at, count).unwrap_or_default(),
    }
}

/// Reads the coarser nodes of a node. Without errors in metres they are of no use.
fn read_levels(at: &Cursor, count: usize) -> Checked<Vec<(usize, f32)>> {
    let Some(extension) = at.extension("MSFT_lod") else { return Ok(Vec::new()) };
    let ids = extension.list("ids");
    let ids: Checked<Vec<usize>> = ids.iter().map(|id| id.index(count, "node")).collect();
    let extras = at.get("extras").filter(|extras| extras.object().is_ok());
    let errors_m = extras.map_or(Vec::new(), |extras| extras.list("error_m"));
    let errors_m: Checked<Vec<f64>> = errors_m.iter().map(Cursor::number).collect();
    let (ids, errors_m) = (ids?, errors_m?);
    if ids.len() != errors_m.len() {
        at.note("has levels of detail without an error in metres for each; they are ignored");
        return Ok(Vec::new());
    }
    Ok(ids.into_iter().zip(errors_m.into_iter().map(to_f32)).collect())
}

fn read_local(at: &Cursor) -> Checked<Trs> {
    let translation = at.optional("translation", Cursor::numbers::<3>);
    let rotation = at.optional("rotation", Cursor::numbers::<4>);
    let scale = at.optional("scale", Cursor::numbers::<3>);
    let (translation, rotation, scale) = (translation?, rotation?, scale?);
    if let Some(matrix) = at.get("matrix") {
        if translation.is_some() || rotation.is_some() || scale.is_some() {
            at.note("has both a matrix and translation, rotation or scale; the matrix is used");
        }
        return decompose(&matrix, matrix.numbers::<16>()?);
    }
    let rotation = rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let length = DQuat::from_array(rotation).length();
    if length < 1e-6 {
        return Err(at.problem("has a rotation of length zero; it must be a unit quaternion"));
    }
    if (length - 1.0).abs() > 1e-3 {
        at.note("has a rotation that is not a unit quaternion; it is normalised");
    }
    Ok(Trs {
        translation: translation.unwrap_or([0.0; 3]).map(to_f32),
        rotation: rotation.map(to_f32),
        scale: scale.unwrap_or([1.0; 3]).map(to_f32),
    })
}

/// Decomposes a column-major matrix. Fails if it has shear (glTF 2.0, section 3.5.3).
fn decompose(at: &Cursor, matrix: [f64; 16]) -> Checked<Trs> {
    let last_row = [matrix[3], matrix[7], matrix[11], matrix[15] - 1.0];
    if last_row.iter().any(|v| v.abs() > 1e-5) {
        return Err(at.problem("has a last row other than 0 0 0 1; the matrix must be affine"));
    }
    let columns = [0, 4, 8].map(|c| DVec3::new(matrix[c], matrix[c + 1], matrix[c + 2]));
    let mut scale = columns.map(DVec3::length);
    if DMat3::from_cols(columns[0], columns[1], columns[2]).determinant() < 0.0 {
        scale[0] = -scale[0];
    }
    let axes = axes(columns, scale);
    let is_sheared =
        (0..3).any(|c| (axes.col(c) * scale[c] - columns[c]).length() > SHEAR * scale[c].abs());
    if is_sheared {
        return Err(at.problem(
            "is sheared; a node's matrix must be a product of translation, rotation and scale \
             (glTF 2.0, section 3.5.3)",
        ));
    }
    Ok(Trs {
        translation: [matrix[12], matrix[13], matrix[14]].map(to_f32),
        rotation: DQuat::from_mat3(&axes).normalize().to_array().map(to_f32),
        scale: scale.map(to_f32),
    })
}

/// Returns the rotation with the directions of `columns` as axes. Columns of length zero are
/// replaced by directions perpendicular to the others.
fn axes(columns: [DVec3; 3], scale: [f64; 3]) -> DMat3 {
    let axis = |c: usize| (scale[c] != 0.0).then(|| columns[c] / scale[c]);
    let (x, y) = match [axis(0), axis(1), axis(2)] {
        [Some(x), Some(y), _] => (x, y),
        [Some(x), None, Some(z)] => (x, z.cross(x)),
        [None, Some(y), Some(z)] => (y.cross(z), y),
        [Some(x), None, None] => (x, x.any_orthonormal_vector()),
        [None, Some(y), None] => (y.any_orthonormal_vector(), y),
        [None, None, Some(z)] => {
            let x = z.any_orthonormal_vector();
            (x, z.cross(x))
        }
        [None, None, None] => (DVec3::X, DVec3::Y),
    };
    let x = x.normalize();
    let y = (y - x * x.dot(y)).try_normalize().unwrap_or_else(|| x.any_orthonormal_vector());
    DMat3::from_cols(x, y, x.cross(y))
}

/// Sets the parent of each child. Fails if a node is listed as a child twice.
fn link(nodes: &mut [Node], log: &Log) -> Checked<()> {
    let mut failed = None;
    for parent in 0..nodes.len() {
        for child in nodes[parent].children.clone() {
            if let Some(first) = nodes[child].parent.replace(parent) {
                let what = format!(
                    "lists node {child} as a child, but it is already a child of node {first}; a \
                     node has at most one parent"
                );
                failed = Some(log.problem(format!("{}.children", nodes[parent].place), what));
            }
        }
    }
    failed.map_or(Ok(()), Err)
}

/// Checks that there are no cycles. Each cycle is reported once. Every node has at most one parent,
/// so following the parents finds all cycles.
fn check_cycles(nodes: &[Node], log: &Log) -> Checked<()> {
    let mut failed = None;
    let mut seen_from = vec![usize::MAX; nodes.len()];
    for start in 0..nodes.len() {
        let mut at = Some(start);
        while let Some(node) = at.filter(|n| seen_from[*n] == usize::MAX) {
            seen_from[node] = start;
            at = nodes[node].parent;
        }
        if let Some(node) = at.filter(|n| seen_from[*n] == start) {
            let what = "is its own ancestor; nodes must form a forest (glTF 2.0, section 3.5.2)";
            failed = Some(log.problem(&nodes[node].place, what));
        }
    }
    failed.map_or(Ok(()), Err)
}

/// Returns the roots of the scene to import: the default scene, else the first one. If there are no
/// scenes, returns all nodes without a parent.
fn scene_roots(root: &Cursor, nodes: &[Node]) -> Checked<Vec<usize>> {
    let read_scene = |at: &Cursor| -> Checked<Vec<usize>> {
        let roots = at.list("nodes").into_iter().map(|item| {
            let node = item.index(nodes.len(), "node")?;
            match nodes[node].parent {
                Some(parent) => Err(item.problem(format!(
                    "refers to node {node}, which is a child of node {parent}; a scene may only \
                     list root nodes"
                ))),
                None => Ok(node),
            }
        });
        // Collected first, so that all problems are reported.
        let roots: Vec<_> = roots.collect();
        roots.into_iter().collect()
    };
    let mut scenes: Vec<_> = root.objects("scenes").iter().map(read_scene).collect();
    if root.get("scenes").is_none() {
        if let Some(at) = root.get("scene") {
            at.uint()?;
            at.note("refers to a scene, but the file has none; all nodes are imported");
        }
        return Ok((0..nodes.len()).filter(|n| nodes[*n].parent.is_none()).collect());
    }
    let default = root.optional("scene", |at| at.index(scenes.len(), "scene"))?;
    if scenes.is_empty() {
        return Ok(Vec::new());
    }
    if scenes.len() > 1 {
        root.note(format!(
            "has {} scenes; scene {} is imported",
            scenes.len(),
            default.unwrap_or(0)
        ));
    }
    scenes.swap_remove(default.unwrap_or(0)).map_err(|Reported| Reported)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::tests::tree;

    fn local(matrix: [f64; 16]) -> Result<Trs, String> {
        let text = format!("{{\"matrix\": {matrix:?}}}");
        let value = tree(&text);
        let log = Log::default();
        let trs = read_local(&Cursor::root(&value, &log));
        trs.map_err(|_| log.finish().unwrap_err()[0].to_string())
    }

    #[test]
    fn ancestry_lists_descendants_of_each_node() {
        let value = tree(
            r#"{"nodes": [
                {"children": [2, 1]}, {"children": [3]}, {}, {}, {"children": [5]}, {}
            ]}"#,
        );
        let log = Log::default();
        let counts = Counts { meshes: 0, skins: 0, cameras: 0 };
        let (nodes, forest) = read(&Cursor::root(&value, &log), &log, counts);
        forest.unwrap();
        let ancestry = Ancestry::new(&nodes);
        assert_eq!(ancestry.roots, [0, 0, 0, 0, 4, 4]);
        let below: Vec<_> = (0..6)
            .map(|root| (0..6).filter(|n| ancestry.is_at_or_below(*n, root)).collect::<Vec<_>>())
            .collect();
        assert_eq!(below, [vec![0, 1, 2, 3], vec![1, 3], vec![2], vec![3], vec![4, 5], vec![5]]);
    }

    #[test]
    fn matrix_decomposes_into_translation_rotation_and_scale() {
        // A scale by 2, 3, 4, then a rotation by 90 degrees about z.
        let trs = local([
            0.0, 2.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 5.0, 6.0, 7.0, 1.0,
        ])
        .unwrap();
        assert_eq!((trs.translation, trs.scale), ([5.0, 6.0, 7.0], [2.0, 3.0, 4.0]));
        let half = std::f32::consts::FRAC_1_SQRT_2;
        for (is, wanted) in trs.rotation.iter().zip([0.0, 0.0, half, half]) {
            assert!((is - wanted).abs() < 1e-6, "{trs:?}");
        }
    }

    #[test]
    fn reflections_and_singular_matrices_decompose_and_shear_fails() {
        let diagonal =
            |x, y, z| [x, 0.0, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0, 1.0];
        for [x, y, z] in
            [[-1.0, 2.0, 3.0], [0.0, 2.0, 3.0], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, 0.0]]
        {
            let trs = local(diagonal(x, y, z)).unwrap();
            let back = populace_model::Affine::from_trs(&trs);
            for (row, wanted) in [x, y, z].into_iter().enumerate() {
                assert!(
                    (f64::from(back.rows[row][row]) - wanted).abs() < 1e-6,
                    "{x} {y} {z}: {back:?}"
                );
            }
        }
        let mut sheared = diagonal(1.0, 1.0, 1.0);
        sheared[4] = 0.5;
        assert!(local(sheared).unwrap_err().contains("matrix: is sheared"));
        let mut projective = diagonal(1.0, 1.0, 1.0);
        projective[3] = 0.5;
        assert!(local(projective).unwrap_err().contains("last row"));
    }
}
