//! Dressed people: surfaces of their own, on joints and with clips that those of one build share.

use std::sync::Arc;

use populace_character::{
    Character, CharacterSource, Error, Material, PaletteEntry, Part, SkinInstance, sole_points,
    vertex_reach_m,
};
use populace_clip::Clip;
use populace_model::{ClipSource, Skeleton};
use rayon::prelude::*;

use crate::Look;
use crate::anatomy::Body;
use crate::motion;
use crate::rig::Joints;
use crate::surface::{self, Wardrobe};

/// Returns one person; all its options are parts if `options`.
pub(crate) fn one(look: &Look, options: bool) -> Result<Character, Error> {
    let person = Dressed::new(look, options)?;
    let build = Build::new(look.build(), &[&person]);
    let clips = build.sources().into_par_iter().map(|source| build.clip(source));
    let clips: Vec<_> = clips.collect::<Result<_, _>>()?;
    person.finish(&build, &clips)
}

/// Returns people in the order of their looks.
pub(crate) fn all(looks: &[Look], options: bool) -> Result<Vec<Character>, Error> {
    let people: Vec<Dressed> =
        looks.par_iter().map(|look| Dressed::new(look, options)).collect::<Result<_, _>>()?;
    // The looks of each build, by their numbers.
    let mut groups: Vec<(Look, Vec<usize>)> = Vec::new();
    for (number, build) in looks.iter().map(Look::build).enumerate() {
        match groups.iter_mut().find(|(known, _)| *known == build) {
            Some((_, members)) => members.push(number),
            None => groups.push((build, vec![number])),
        }
    }
    let builds: Vec<Build> = groups
        .iter()
        .map(|(look, members)| {
            let members: Vec<&Dressed> = members.iter().map(|&number| &people[number]).collect();
            Build::new(look.clone(), &members)
        })
        .collect();
    let sources: Vec<(usize, ClipSource)> = builds
        .par_iter()
        .enumerate()
        .flat_map_iter(|(at, build)| build.sources().into_iter().map(move |source| (at, source)))
        .collect();
    let clips: Vec<(usize, Arc<Clip>)> = sources
        .into_par_iter()
        .map(|(at, source)| Ok((at, builds[at].clip(source)?)))
        .collect::<Result<_, Error>>()?;
    let mut shared = vec![Vec::new(); builds.len()];
    clips.into_iter().for_each(|(at, clip)| shared[at].push(clip));
    let mut of_look = vec![0; looks.len()];
    for (at, (_, members)) in groups.iter().enumerate() {
        members.iter().for_each(|&number| of_look[number] = at);
    }
    let finish = |(person, at): (Dressed, usize)| person.finish(&builds[at], &shared[at]);
    people.into_iter().zip(of_look).map(finish).collect()
}

/// The surface of one person.
struct Dressed {
    name: String,
    palette: Vec<PaletteEntry>,
    parts: Vec<Part>,
    materials: Vec<Material>,
    skeleton: Skeleton,
    /// Distances of vertices from the joints in metres.
    reach_m: Vec<f32>,
}

impl Dressed {
    fn new(look: &Look, options: bool) -> Result<Self, Error> {
        let body = Body::new(look);
        let joints = Joints::new(&body);
        let skeleton = joints.skeleton()?;
        let palette = joints.palette(&skeleton);
        let wardrobe = Wardrobe::of(&body, options);
        let (parts, materials) = surface::parts(&wardrobe, &joints, &look.colors);
        let reach_m = vertex_reach_m(&skeleton, &palette, &parts);
        let soles = sole_points(&skeleton, &palette, &parts);
        let skeleton = skeleton.with_soles(&soles);
        Ok(Self { name: look.name.clone(), palette, parts, materials, skeleton, reach_m })
    }

    fn finish(self, build: &Build, clips: &[Arc<Clip>]) -> Result<Character, Error> {
        let skins = vec![SkinInstance { skin: 0, node: 0, joints: self.palette.clone() }];
        Character::new(CharacterSource {
            name: self.name,
            skeleton: build.skeleton.clone(),
            palette: self.palette,
            parts: self.parts,
            materials: self.materials,
            images: Vec::new(),
            skins,
            clips: clips.to_vec(),
        })
    }
}

/// Data that people of one build share.
struct Build {
    body: Body,
    joints: Joints,
    /// The skeleton with the farthest reach of all the people.
    skeleton: Skeleton,
}

impl Build {
    /// Takes a look of [`Look::build`], and at least one person of this build.
    fn new(look: Look, people: &[&Dressed]) -> Self {
        let body = Body::new(&look);
        let joints = Joints::new(&body);
        let mut reach_m = people[0].reach_m.clone();
        for person in &people[1..] {
            reach_m.iter_mut().zip(&person.reach_m).for_each(|(all, own)| *all = all.max(*own));
        }
        let skeleton = people[0].skeleton.clone().with_reach(&reach_m);
        Self { body, joints, skeleton }
    }

    /// Returns the keys of all motions.
    fn sources(&self) -> Vec<ClipSource> {
        let surface = Wardrobe::touching(&self.body);
        let motions = motion::all(&self.body, &self.joints, &surface);
        motions.iter().map(|motion| self.joints.tracks(&self.body, motion)).collect()
    }

    fn clip(&self, source: ClipSource) -> Result<Arc<Clip>, Error> {
        Ok(Arc::new(Clip::new(source, &self.skeleton)?))
    }
}
