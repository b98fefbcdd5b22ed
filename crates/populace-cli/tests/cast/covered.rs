//! Clothes that cover skin at rest cover it in all poses.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use libtest_mimic::Failed;
use populace::character::{Character, Part};
use populace::model::{Affine, RoleMap};
use populace::{ClipPlayback, Crowd, Device, Placement};

use crate::posed::{Binds, Patch, borders, crossing, part, triangles, without_bands};
use crate::{ensure, people};

/// People of the seed that are tried: with trousers, shorts and skirts, short and long sleeves.
const PEOPLE: [u32; 6] = [0, 2, 3, 5, 6, 7];
/// Poses of each clip.
const POSES: u32 = 3;
/// Cloth covers skin at rest if it is this near over it, in metres.
const NEAR_M: f64 = 0.06;
/// Skin that lies this deep under cloth at rest has room to move, in metres.
const DEEP_M: f64 = 0.015;
/// Skin this near the collar of a shoe is left out, in metres: ankles press through it.
const COLLAR_M: f64 = 0.05;
/// Skin shows if it is this far outside of the cloth, in metres.
const SHOWS_M: f64 = 0.007;
/// Legs cross a skirt in this part of the poses at most, and only this far above the hem in metres.
const MOST_CROSSED: f64 = 0.25;
const MOST_ABOVE_HEM_M: f64 = 0.14;

/// Skin that is seen through clothes, over all poses.
#[derive(Default)]
struct Seen {
    poses: u32,
    /// The furthest that skin is outside of cloth, in metres, and where.
    most_m: f64,
    place: String,
    /// Poses of people in skirts, those in which legs cross the cloth, and how far above the hem.
    skirts: u32,
    crossed: u32,
    above_hem_m: f64,
}

pub(crate) fn in_all_clips(wheel: &Path, folder: &Path) -> Result<(), Failed> {
    let sources = humanoids(folder)?;
    let clips: usize = sources.iter().map(|source| source.clips.len()).sum();
    ensure(clips > 200, || format!("{clips} clips are too few to trust this test"))?;
    let mut seen = Seen::default();
    for person in people(wheel, &PEOPLE)? {
        let person = Arc::new(person);
        let dressed = Dressed::new(&person).ok_or("no skin")?;
        let points = dressed.covered.len();
        ensure(points > 30, || format!("{} wears little", person.name))?;
        for source in &sources {
            for (clip, models) in in_poses(&person, source)? {
                seen.count(&dressed, &models, &format!("{clip} of {}", source.name));
            }
        }
    }
    let Seen { poses, most_m, place, skirts, crossed, above_hem_m } = seen;
    println!("{clips} clips, {poses} poses: skin at most {:.1} mm outside: {place}", most_m * 1e3);
    println!("{crossed} of {skirts} skirts crossed, at most {:.0} mm above", above_hem_m * 1e3);
    ensure(most_m <= SHOWS_M, || format!("{:.1} mm of skin show: {place}", most_m * 1e3))?;
    let part = f64::from(crossed) / f64::from(skirts.max(1));
    ensure(skirts > 1000 && part <= MOST_CROSSED, || format!("legs cross {part} of the skirts"))?;
    ensure(above_hem_m <= MOST_ABOVE_HEM_M, || format!("{above_hem_m} m above a hem"))
}

impl Seen {
    fn count(&mut self, dressed: &Dressed, models: &[Affine], clip: &str) {
        let binds = Binds::new(dressed.person, models);
        self.poses += 1;
        let (outside_m, garment) = dressed.outside_m(&binds);
        if outside_m > self.most_m {
            self.most_m = outside_m;
            self.place = format!("{garment} of {} in {clip}", dressed.person.name);
        }
        if let Some(skirt) = &dressed.skirt {
            let above_m = skirt.crossed_m(dressed, &binds);
            self.skirts += 1;
            self.crossed += u32::from(above_m > 0.0);
            self.above_hem_m = self.above_hem_m.max(above_m);
        }
    }
}

/// Returns the characters of the test data whose clips people can play.
fn humanoids(folder: &Path) -> Result<Vec<Character>, Failed> {
    let mut files = Vec::new();
    for kind in ["characters", "mocap"] {
        collect(&folder.join(kind), &mut files)?;
    }
    files.sort();
    let plays = |character: &Character| {
        !character.clips.is_empty() && RoleMap::detect(&character.skeleton).is_some()
    };
    let loaded = files.iter().filter_map(|file| populace_assets::load(file).ok());
    Ok(loaded.map(|imported| imported.character).filter(plays).collect())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Failed> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        match path.is_dir() {
            true => collect(&path, files)?,
            false => files.push(path),
        }
    }
    Ok(())
}

/// Returns the joints' transforms of a person in poses of each clip of a character, with the
/// clips' names.
fn in_poses(
    person: &Arc<Character>,
    source: &Character,
) -> Result<Vec<(String, Vec<Affine>)>, Failed> {
    let mut poses = Vec::new();
    for clip in &source.clips {
        let mut crowd =
            Crowd::builder().device(Device::native()).capacity(1).slots_per_member(1).build()?;
        let id = crowd.add_character(Arc::clone(person))?;
        let clip_id = crowd.character_mut(id)?.add_clip(clip)?;
        let member = crowd.spawn(id, Placement::at([0.0; 3]))?;
        let Ok(_) = crowd.member_mut(member)?.play(clip_id, ClipPlayback::looping()) else {
            continue;
        };
        for _ in 0..POSES {
            crowd.update(clip.duration_secs() / POSES as f32)?;
            poses.push((clip.name().to_owned(), crowd.member_mut(member)?.model_from_joints()?));
        }
    }
    Ok(poses)
}

/// A person's clothes, with the skin that they cover at rest.
struct Dressed<'a> {
    person: &'a Character,
    skin: &'a Part,
    clothes: Vec<&'a Part>,
    /// Vertices of the skin, each with the garments that cover it, and their patches over it.
    covered: Vec<(usize, Vec<(usize, Patch)>)>,
    skirt: Option<Skirt>,
}

impl<'a> Dressed<'a> {
    fn new(person: &'a Character) -> Option<Self> {
        let rest = Binds::at_rest(person);
        let skin = part(person, "Skin")?;
        let places = rest.skinned(&skin.mesh);
        let clothes: Vec<&Part> =
            ["Top", "Trousers"].iter().filter_map(|name| part(person, name)).collect();
        let cloth: Vec<_> =
            clothes.iter().map(|part| without_bands(triangles(&part.mesh))).collect();
        let worn: Vec<_> = clothes.iter().map(|part| rest.skinned(&part.mesh)).collect();
        let edges: Vec<HashSet<usize>> =
            cloth.iter().map(|cloth| borders(cloth).into_iter().flatten().collect()).collect();
        let collars = part(person, "Shoes").map_or(Vec::new(), |shoes| {
            let places = rest.skinned(&shoes.mesh);
            let edges = borders(&without_bands(triangles(&shoes.mesh)));
            edges.into_iter().flatten().map(|vertex| places[vertex]).collect()
        });
        let over = |vertex: usize, garment: usize| {
            let normal = DVec3::from(skin.mesh.normals[vertex].map(f64::from));
            let is_over = |triangle: &&[usize; 3]| {
                let [a, b, c] = triangle.map(|corner| worn[garment][corner]);
                let near = [a, b, c].iter().any(|at| at.distance(places[vertex]) < NEAR_M);
                near && (b - a).cross(c - a).dot(normal) > 0.0
            };
            let patch = Patch::new(cloth[garment].iter().filter(is_over).copied().collect());
            let outside_m = patch.outside_m(&worn[garment], places[vertex])?;
            (-DEEP_M..0.0).contains(&outside_m).then_some((garment, patch))
        };
        let over = |vertex: usize| {
            if collars.iter().any(|at| at.distance(places[vertex]) < COLLAR_M) {
                return None;
            }
            let patches: Vec<_> = (0..clothes.len()).filter_map(|g| over(vertex, g)).collect();
            (!patches.is_empty()).then_some((vertex, patches))
        };
        let covered = (0..places.len()).filter_map(over).collect();
        let skirt = clothes.iter().position(|part| part.node_name.contains("skirt"));
        let skirt = skirt.map(|garment| Skirt {
            garment,
            triangles: cloth[garment].clone(),
            edge: edges[garment].clone(),
            legs: legs(person, skin),
        });
        Some(Self { person, skin, clothes, covered, skirt })
    }

    /// Returns how far skin is outside of the clothes in a pose, in metres, and of which garment.
    fn outside_m(&self, binds: &Binds) -> (f64, &'a str) {
        let skin = binds.skinned(&self.skin.mesh);
        let worn: Vec<_> = self.clothes.iter().map(|part| binds.skinned(&part.mesh)).collect();
        let mut most = (0.0, 0);
        for (vertex, patches) in &self.covered {
            // Skin that another garment still covers does not show.
            let outside = patches.iter().map(|(garment, patch)| {
                (patch.outside_m(&worn[*garment], skin[*vertex]).unwrap_or(0.0), *garment)
            });
            let least = outside.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(most);
            most = if least.0 > most.0 { least } else { most };
        }
        (most.0, &self.clothes[most.1].node_name)
    }
}

/// Cloth that hangs around both legs, and edges of the legs' skin, which may not cross it.
struct Skirt {
    garment: usize,
    triangles: Vec<[usize; 3]>,
    /// Vertices of its edges.
    edge: HashSet<usize>,
    legs: Vec<[usize; 2]>,
}

impl Skirt {
    /// Returns how far above the hem legs cross the skirt in a pose, in metres; 0 if they do not.
    fn crossed_m(&self, dressed: &Dressed, binds: &Binds) -> f64 {
        let skin = binds.skinned(&dressed.skin.mesh);
        let worn = binds.skinned(&dressed.clothes[self.garment].mesh);
        let above_hem = |at: DVec3| {
            self.edge.iter().map(|vertex| worn[*vertex].distance(at)).fold(f64::MAX, f64::min)
        };
        let through = |[from, to]: &[usize; 2]| {
            let (from, to) = (skin[*from], skin[*to]);
            let near = from.distance(to) + NEAR_M;
            let corners = self.triangles.iter().map(|triangle| triangle.map(|c| worn[c]));
            let near = corners.filter(move |[a, ..]| a.distance(from) < near);
            near.filter_map(move |corners| crossing(from, to, corners)).map(above_hem)
        };
        self.legs.iter().flat_map(through).fold(0.0, f64::max)
    }
}

/// Returns the edges of the skin that moves with thighs and shins.
fn legs(person: &Character, skin: &Part) -> Vec<[usize; 2]> {
    let mesh = &skin.mesh;
    let per = mesh.influences.per_vertex;
    let on_leg = |vertex: usize| {
        let range = vertex * per..(vertex + 1) * per;
        let entries = mesh.influences.entries[range.clone()].iter();
        let on_leg = |entry: u16| {
            let joint = person.palette[usize::from(entry)].joint;
            person.skeleton.name(joint).contains("Leg")
        };
        let pairs = entries.zip(&mesh.influences.weights[range]);
        pairs.filter(|(entry, _)| on_leg(**entry)).map(|(_, weight)| weight).sum::<f32>() > 0.5
    };
    let triangles = triangles(mesh);
    let edges = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    edges.filter(|edge| edge[0] < edge[1] && edge.iter().all(|v| on_leg(*v))).collect()
}
