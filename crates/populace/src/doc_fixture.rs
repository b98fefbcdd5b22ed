//! A small character for examples in the documentation.

use populace_character::{Character, CharacterSource, PaletteEntry};
use populace_clip::Clip;
use populace_model::{
    Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs,
};

use crate::{CharacterId, Crowd, Error};

/// The seconds and the height in metres to which each clip raises the hips.
const CLIPS: [(&str, f32, f32); 6] = [
    ("Idle", 4.0, 0.0),
    ("Walk", 1.0, 1.0),
    ("Run", 0.5, 2.0),
    ("Wave", 1.0, 0.5),
    ("Jump", 0.5, 3.0),
    ("Rise", 1.0, 2.0),
];

/// Adds a character "knight" of one joint, whose clips move it straight up.
///
/// # Errors
///
/// None for a crowd with free memory.
pub fn knight(crowd: &mut Crowd) -> Result<CharacterId, Error> {
    let joint = JointSource { name: "hips".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint])?;
    let clip = |(name, secs, height): (&str, f32, f32)| {
        let track = Track {
            joint: "hips".into(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: vec![0.0, secs],
            values: vec![0.0, 0.0, 0.0, 0.0, height, 0.0],
        };
        let source = ClipSource { name: name.into(), tracks: vec![track] };
        Ok(Clip::new(source, &skeleton)?.into())
    };
    let clips = CLIPS.into_iter().map(clip).collect::<Result<_, Error>>()?;
    let entry = PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY };
    crowd.add_character(Character::new(CharacterSource {
        name: "knight".into(),
        skeleton,
        palette: vec![entry],
        parts: vec![],
        materials: vec![],
        images: vec![],
        skins: vec![],
        clips,
    })?)
}
