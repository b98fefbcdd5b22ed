//! What of the skin is covered at rest must be covered in all poses.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use libtest_mimic::Failed;
use populace::character::{Character, Mesh, Part};
use populace::model::Affine;
use populace::{ClipPlayback, Crowd, Device, Placement};

use crate::{ensure, people};

/// People of the seed that are tried: with trousers, shorts and skirts, short and long sleeves.
const PEOPLE: [u32; 4] = [1, 3, 5, 7];
/// Poses of each clip.
const POSES: u32 = 3;
/// Skin counts as covered if clothes are this near over it at rest, in metres.
const NEAR_M: f64 = 0.10;
/// In a pose, clothes may be further off.
const FAR_M: f64 = 0.35;
/// The greatest part of the covered points that may show at once. All of them lie in the margin of
/// 12 mm under an edge, or in shoes. Where limbs fold, some look out from under the edge.
const MOST_SHOWN: f64 = 0.06;

pub(crate) fn in_all_clips(wheel: &Path, folder: &Path) -> Result<(), Failed> {
    let clips = populace_assets::load(folder.join("characters/m2m_human_base.glb"))?.character;
    let mut worst = (0.0, String::new());
    for person in people(wheel, &PEOPLE)? {
        let person = Arc::new(person);
        let covered = Covered::new(&person);
        ensure(covered.points.len() > 30, || format!("{} wears little", person.name))?;
        for clip in &clips.clips {
            let mut crowd = Crowd::builder()
                .device(Device::native())
                .capacity(1)
                .slots_per_member(1)
                .build()?;
            let id = crowd.add_character(Arc::clone(&person))?;
            let clip_id = crowd.character_mut(id)?.add_clip(clip)?;
            let member = crowd.spawn(id, Placement::at([0.0; 3]))?;
            crowd.member_mut(member)?.play(clip_id, ClipPlayback::looping())?;
            for pose in 0..POSES {
                crowd.update(clip.duration_secs() / POSES as f32)?;
                let models = crowd.member_mut(member)?.model_from_joints()?;
                let shown = covered.shown(&person, &models);
                if shown > worst.0 {
                    worst = (shown, format!("{} in {} at pose {pose}", person.name, clip.name()));
                }
            }
        }
    }
    println!("at most {:.2} % of the covered skin shows: {}", worst.0 * 100.0, worst.1);
    ensure(worst.0 <= MOST_SHOWN, || format!("{:.2} % shows: {}", worst.0 * 100.0, worst.1))
}

/// The points of a person's skin that clothes cover at rest: each in front of the part that covers
/// it.
struct Covered {
    points: Vec<(usize, usize)>,
}

const CLOTHES: [&str; 3] = ["Top", "Trousers", "Shoes"];

fn parts_of<'a>(person: &'a Character, names: &[&str]) -> Vec<&'a Part> {
    let named = |part: &&Part| names.iter().any(|name| part.node_name.starts_with(name));
    person.parts.iter().filter(named).collect()
}

impl Covered {
    fn new(person: &Character) -> Self {
        let rest: Vec<DAffine3> = person.skeleton.rest_models();
        let posed = Posed::new(person, &rest);
        let skin = &posed.skin;
        let over = |vertex: usize| {
            let part = (0..posed.clothes.len()).find(|part| posed.covers(vertex, *part, NEAR_M))?;
            Some((vertex, part))
        };
        Self { points: (0..skin.len()).filter_map(over).collect() }
    }

    /// Returns which part of the points show.
    fn shown(&self, person: &Character, models: &[Affine]) -> f64 {
        let models: Vec<DAffine3> = models.iter().map(affine).collect();
        let posed = Posed::new(person, &models);
        let all = 0..posed.clothes.len();
        let hidden = |(vertex, _): &&(usize, usize)| {
            all.clone().any(|part| posed.covers(*vertex, part, FAR_M))
        };
        let shown = self.points.len() - self.points.iter().filter(hidden).count();
        shown as f64 / self.points.len() as f64
    }
}

/// A person in a pose.
struct Posed {
    /// Places and normals of the skin.
    skin: Vec<(DVec3, DVec3)>,
    /// Triangles of each part of the clothes.
    clothes: Vec<Vec<[DVec3; 3]>>,
}

impl Posed {
    fn new(person: &Character, models: &[DAffine3]) -> Self {
        let binds: Vec<DAffine3> = person
            .palette
            .iter()
            .map(|e| models[e.joint.index()] * affine(&e.joint_from_bind))
            .collect();
        let skin = parts_of(person, &["Skin"]).into_iter().flat_map(|part| {
            let mesh = &part.mesh;
            let places = skinned(mesh, &binds);
            let normals = (0..places.len()).map(|v| {
                let normal = point(mesh.normals[v]);
                moved(mesh, v, &binds, |bind| bind.transform_vector3(normal)).normalize()
            });
            places.iter().copied().zip(normals).collect::<Vec<_>>()
        });
        let clothes = parts_of(person, &CLOTHES).into_iter().map(|part| {
            let places = skinned(&part.mesh, &binds);
            let corners = part.mesh.indices.chunks_exact(3);
            corners.map(|c| [0, 1, 2].map(|k: usize| places[c[k] as usize])).collect()
        });
        Self { skin: skin.collect(), clothes: clothes.collect() }
    }

    /// Returns whether a part lies over a vertex of the skin.
    fn covers(&self, vertex: usize, part: usize, within_m: f64) -> bool {
        let (from, along) = self.skin[vertex];
        self.clothes[part].iter().any(|triangle| hit(from, along, triangle, within_m))
    }
}

fn point(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

fn affine(m: &Affine) -> DAffine3 {
    let column = |c: usize| DVec3::from(m.rows.map(|row| f64::from(row[c])));
    DAffine3::from_cols(column(0), column(1), column(2), column(3))
}

fn moved(mesh: &Mesh, vertex: usize, binds: &[DAffine3], by: impl Fn(&DAffine3) -> DVec3) -> DVec3 {
    let per = mesh.influences.per_vertex;
    let range = vertex * per..(vertex + 1) * per;
    let entries = mesh.influences.entries[range.clone()].iter();
    let pairs = entries.zip(&mesh.influences.weights[range]);
    pairs.map(|(entry, weight)| by(&binds[usize::from(*entry)]) * f64::from(*weight)).sum()
}

fn skinned(mesh: &Mesh, binds: &[DAffine3]) -> Vec<DVec3> {
    let place = |vertex: usize| {
        let at = point(mesh.positions[vertex]);
        moved(mesh, vertex, binds, |bind| bind.transform_point3(at))
    };
    (0..mesh.positions.len()).map(place).collect()
}

/// Returns whether a ray meets a triangle within a distance (T. Möller and B. Trumbore, "Fast,
/// minimum storage ray/triangle intersection", Journal of Graphics Tools 2(1), 1997).
fn hit(from: DVec3, along: DVec3, [a, b, c]: &[DVec3; 3], within_m: f64) -> bool {
    let offset = from - *a;
    if offset.length_squared() > (within_m + 0.2).powi(2) {
        return false;
    }
    let (ab, ac) = (*b - *a, *c - *a);
    let cross = along.cross(ac);
    let det = ab.dot(cross);
    if det.abs() < 1e-15 {
        return false;
    }
    let u = offset.dot(cross) / det;
    let across = offset.cross(ab);
    let v = along.dot(across) / det;
    let far = ac.dot(across) / det;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..within_m).contains(&far)
}
