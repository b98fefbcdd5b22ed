//! Scenes as text, so that other programs can evaluate the same crowd.

use std::io::{self, Write};

use populace::character::Character;
use populace::clip::Clip;
use populace::model::{Affine, ClipSource, Interpolation, JointIndex, Property, Skeleton, Track};
use populace_model::convert::single;
use populace_testkit::oracle::track_value;

use crate::scene::Scene;

/// Keys per second that stand for steps and splines.
const KEYS_PER_SEC: f32 = 60.0;
/// Longest clip whose steps and splines are sampled.
const LONGEST_SECS: f32 = 3600.0;

impl Scene {
    /// Writes the scene as numbers and white space, with times in seconds and lengths in metres:
    ///
    /// ```text
    /// scene     = characters character* members slots member*
    /// character = joints joint* entries entry* clips clip*
    /// joint     = parent transform            (-1 for a root; parents stand before children)
    /// transform = translation[3] rotation[4] scale[3]        (x y z, x y z w, x y z)
    /// entry     = joint joint_from_bind[12]                  (three rows of four)
    /// clip      = duration (track track track)*              (of each joint, in that order)
    /// track     = keys (time value[3 or 4])*                 (translation, rotation, scale)
    /// member    = (clip phase weight)*                       (of each slot)
    /// ```
    ///
    /// Tracks have at least one key, and hold their first and last value outside their keys.
    /// Between keys, rotations go along the shorter arc at constant speed (slerp), and the rest
    /// linearly. Steps and splines are sampled 60 times a second.
    ///
    /// Member `m` has character `m` modulo `characters`. A clip starts at `phase` times its
    /// duration and repeats; one of duration 0 stands still. Weights are shares of their sum. Each
    /// rotation is brought into the hemisphere of the joint's rest rotation before the sum, and the
    /// sum to length 1. A matrix of a palette is `model_from_joint * joint_from_bind`.
    ///
    /// Layers, constraints, crossfades and clips of other skeletons are not written: another
    /// program evaluates plain crowds alone.
    ///
    /// # Errors
    ///
    /// Errors of `out`. Refuses a clip longer than an hour if a track has steps or splines.
    pub fn write_text(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "{}", self.characters.len())?;
        for character in &self.characters {
            write_character(out, character)?;
        }
        writeln!(out, "{} {}", self.member_count, self.slot_count)?;
        for member in 0..self.member_count {
            for slot in self.initial_slots(member) {
                write!(out, "{} {} {} ", slot.clip, slot.phase, slot.weight)?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

fn write_character(out: &mut impl Write, character: &Character) -> io::Result<()> {
    let skeleton = &character.skeleton;
    writeln!(out, "{}", skeleton.joint_count())?;
    for joint in skeleton.joints() {
        let parent = skeleton.parent(joint).map_or("-1".into(), |at| at.index().to_string());
        write!(out, "{parent}")?;
        Property::ALL.into_iter().try_for_each(|of| rest(out, skeleton, joint, of))?;
        writeln!(out)?;
    }
    writeln!(out, "{}", character.palette.len())?;
    for entry in &character.palette {
        let Affine { rows } = &entry.joint_from_bind;
        write!(out, "{}", entry.joint.index())?;
        numbers(out, rows.as_flattened())?;
        writeln!(out)?;
    }
    writeln!(out, "{}", character.clips.len())?;
    character.clips.iter().try_for_each(|clip| write_clip(out, clip, skeleton))
}

fn write_clip(out: &mut impl Write, clip: &Clip, skeleton: &Skeleton) -> io::Result<()> {
    writeln!(out, "{}", clip.duration_secs())?;
    for joint in skeleton.joints() {
        for property in Property::ALL {
            match track(clip.source(), skeleton.name(joint), property) {
                Some(track) => write_track(out, clip, track)?,
                None => {
                    write!(out, "1 0")?;
                    rest(out, skeleton, joint, property)?;
                }
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

fn track<'a>(clip: &'a ClipSource, joint: &str, property: Property) -> Option<&'a Track> {
    clip.tracks.iter().find(|track| track.joint == joint && track.property == property)
}

fn write_track(out: &mut impl Write, clip: &Clip, track: &Track) -> io::Result<()> {
    let start = clip.start_secs();
    if track.interpolation == Interpolation::Linear {
        write!(out, "{}", track.times.len())?;
        for (key, time) in track.times.iter().enumerate() {
            numbers(out, &[time - start])?;
            numbers(out, track.value(key))?;
        }
        return Ok(());
    }
    let duration = clip.duration_secs();
    if duration > LONGEST_SECS {
        let name = clip.name();
        return Err(io::Error::other(format!("the clip {name:?} is longer than an hour")));
    }
    let times: Vec<f32> = (0_u32..)
        .map(|key| single(f64::from(key)) / KEYS_PER_SEC)
        .take_while(|time| *time < duration)
        .chain([duration])
        .collect();
    write!(out, "{}", times.len())?;
    for time in times {
        let value = track_value(track, f64::from(start + time)).to_array().map(single);
        numbers(out, &[time])?;
        numbers(out, &value[..track.property.width()])?;
    }
    Ok(())
}

fn rest(
    out: &mut impl Write,
    skeleton: &Skeleton,
    joint: JointIndex,
    property: Property,
) -> io::Result<()> {
    numbers(out, &property.of(skeleton.rest(joint))[..property.width()])
}

fn numbers(out: &mut impl Write, values: &[f32]) -> io::Result<()> {
    values.iter().try_for_each(|value| write!(out, " {value}"))
}

#[cfg(test)]
mod tests {
    use std::str::SplitWhitespace;
    use std::sync::Arc;

    use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};
    use populace::Error;
    use populace::character::{CharacterSource, PaletteEntry};
    use populace::model::{JointSource, Trs};
    use populace_testkit::Rng;

    use super::*;
    use crate::check::allowed_m;
    use crate::scene::{Load, SceneSettings};

    /// A crowd, read from the text of its scene.
    struct Told {
        characters: Vec<Character>,
        /// The clip of each slot, its phase and its weight.
        members: Vec<Vec<(usize, [f64; 2])>>,
    }

    struct Character {
        parents: Vec<Option<usize>>,
        entries: Vec<(usize, DAffine3)>,
        clips: Vec<(f64, Vec<[Keys; 3]>)>,
    }

    type Keys = Vec<(f64, DVec4)>;

    struct Numbers<'a>(SplitWhitespace<'a>);

    impl Numbers<'_> {
        fn next(&mut self) -> f64 {
            self.0.next().expect("a number").parse().expect("a number")
        }

        fn index(&mut self) -> usize {
            self.0.next().expect("an index").parse().expect("an index")
        }

        fn many<T>(&mut self, mut read: impl FnMut(&mut Self) -> T) -> Vec<T> {
            let count = self.index();
            (0..count).map(|_| read(self)).collect()
        }

        fn keys(&mut self, width: usize) -> Keys {
            self.many(|from| {
                let time = from.next();
                let value: Vec<f64> = (0..width).map(|_| from.next()).collect();
                (time, DVec4::from_array(std::array::from_fn(|i| *value.get(i).unwrap_or(&0.0))))
            })
        }

        fn character(&mut self) -> Character {
            let parents: Vec<_> = self.many(|from| {
                let parent = from.0.next().expect("a parent").parse().ok();
                (0..10).for_each(|_| _ = from.next());
                parent
            });
            let entries = self.many(|from| {
                let joint = from.index();
                let rows: [[f64; 4]; 3] = [(); 3].map(|()| [(); 4].map(|()| from.next()));
                let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
                let matrix = DMat3::from_cols(column(0), column(1), column(2));
                (joint, DAffine3 { matrix3: matrix, translation: column(3) })
            });
            let joints = parents.len();
            let clips = self.many(|from| {
                let duration = from.next();
                (duration, (0..joints).map(|_| [3, 4, 3].map(|width| from.keys(width))).collect())
            });
            Character { parents, entries, clips }
        }
    }

    impl Told {
        fn by(scene: &Scene) -> Self {
            let mut text = Vec::new();
            scene.write_text(&mut text).unwrap();
            let text = String::from_utf8(text).unwrap();
            let mut from = Numbers(text.split_whitespace());
            let characters = from.many(Numbers::character);
            let [members, slots] = [from.index(), from.index()];
            let mut slot = || (from.index(), [from.next(), from.next()]);
            let members = (0..members).map(|_| (0..slots).map(|_| slot()).collect()).collect();
            assert_eq!(from.0.next(), None, "nothing follows");
            Self { characters, members }
        }

        fn palette(&self, member: usize, secs: f64) -> Vec<Affine> {
            let character = &self.characters[member % self.characters.len()];
            let mut models: Vec<DAffine3> = Vec::new();
            for joint in 0..character.parents.len() {
                let mut mean = [DVec4::ZERO; 3];
                let mut total = 0.0;
                for &(clip, [phase, weight]) in &self.members[member] {
                    let (duration, tracks) = &character.clips[clip];
                    let time = (phase + secs / duration).fract() * duration;
                    for (property, mean) in mean.iter_mut().enumerate() {
                        let value = value_at(&tracks[joint][property], time, property == 1);
                        let opposite = property == 1 && value.dot(*mean) < 0.0;
                        *mean += value * if opposite { -weight } else { weight };
                    }
                    total += weight;
                }
                let [t, r, s] = mean;
                let local = DAffine3::from_scale_rotation_translation(
                    s.truncate() / total,
                    DQuat::from_vec4(r.normalize()),
                    t.truncate() / total,
                );
                models
                    .push(character.parents[joint].map_or(local, |parent| models[parent] * local));
            }
            let palette = character.entries.iter().map(|(joint, bind)| models[*joint] * *bind);
            palette.map(|m| Affine { rows: rows_of(&m) }).collect()
        }
    }

    fn rows_of(m: &DAffine3) -> [[f32; 4]; 3] {
        let [x, y, z] = [m.matrix3.row(0), m.matrix3.row(1), m.matrix3.row(2)];
        let t = m.translation;
        [x.extend(t.x), y.extend(t.y), z.extend(t.z)].map(|row| row.as_vec4().to_array())
    }

    fn value_at(keys: &Keys, time: f64, is_rotation: bool) -> DVec4 {
        let after = keys.iter().position(|(at, _)| *at > time).unwrap_or(keys.len());
        let ((from, a), (to, b)) = (keys[after.saturating_sub(1)], keys[after.min(keys.len() - 1)]);
        let part = if to > from { (time - from) / (to - from) } else { 0.0 };
        if is_rotation {
            DQuat::from_vec4(a).slerp(DQuat::from_vec4(b), part).into()
        } else {
            a.lerp(b, part)
        }
    }

    fn error_m(scene: &Scene) -> f64 {
        let told = Told::by(scene);
        let palette = |member: usize| Ok::<_, Error>(told.palette(member, 7.0 / 60.0));
        scene.error_of(7, palette).unwrap()
    }

    #[test]
    fn another_program_can_evaluate_the_crowd() {
        let scene = |load, joints| {
            let settings = SceneSettings { joints, slots: 2, seed: 3 };
            Scene::new(settings, load).unwrap().with_members(10)
        };
        for scene in [scene(Load::Plain, Some(20)), scene(Load::Plain, None)] {
            let error = error_m(&scene);
            assert!(error > 0.0 && error < allowed_m(&scene), "{error} m");
            let told = Told::by(&scene);
            let late = scene.error_of(8, |m| Ok::<_, Error>(told.palette(m, 7.0 / 60.0))).unwrap();
            assert!(late > 10.0 * allowed_m(&scene), "a frame late: {late} m");
        }
    }

    /// The error of a clip of one joint that begins at half a second.
    fn hopping(interpolation: Interpolation, numbers_per_key: usize) -> f64 {
        let rest = Trs { translation: [0.0, 1.0, 0.0], ..Trs::IDENTITY };
        let root = JointSource { name: "root".into(), parent: None, rest };
        let skeleton = Skeleton::new(&[root]).unwrap();
        let mut random = Rng::from_state(1);
        let times: Vec<f32> = (0_u8..5).map(|key| 0.5 + f32::from(key) * 0.25).collect();
        let values = (0..times.len() * numbers_per_key).map(|_| 0.2 * random.signed()).collect();
        let (joint, property) = ("root".into(), Property::Translation);
        let track = Track { joint, property, interpolation, times, values };
        let clip = Clip::new(ClipSource { name: "hop".into(), tracks: vec![track] }, &skeleton);
        let joint = skeleton.joint_from_source(0);
        let hopper = populace::character::Character::new(CharacterSource {
            name: "hopper".into(),
            skeleton,
            palette: vec![PaletteEntry { joint, joint_from_bind: Affine::IDENTITY }],
            parts: Vec::new(),
            materials: Vec::new(),
            images: Vec::new(),
            skins: Vec::new(),
            clips: vec![Arc::new(clip.unwrap())],
        });
        let given = vec![Arc::new(hopper.unwrap())];
        error_m(&Scene::of_characters(given, 1, 0, Load::Plain).unwrap().with_members(6))
    }

    #[test]
    fn splines_are_sampled_and_times_begin_at_zero() {
        let error = hopping(Interpolation::Linear, 3);
        assert!(error < 1e-5, "linear: {error} m");
        // A spline bends between two samples.
        let error = hopping(Interpolation::CubicSpline, 9);
        assert!(error < 1e-3, "spline: {error} m");
    }
}
