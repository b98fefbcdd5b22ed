//! Characters from arbitrary glTF bytes, evaluated in a small crowd.
//!
//! The fuzz target `gltf_evaluate` runs [`survives`] too.

use std::sync::Arc;

use populace::{
    ClipId, ClipPlayback, Crowd, Device, Error, LayerMode, LayerSettings, MemberId, Placement,
};
use populace_assets::load_from_slice;
use populace_testkit::Rng;

use crate::builder::{rigid, skinned};

/// Members of the crowd. Each plays one clip, or two of them on two layers.
const MEMBERS: usize = 4;
/// Steps of the crowd in seconds.
const STEPS: [f32; 4] = [0.0, 1.0 / 60.0, 0.7, 1000.0];

/// Returns the bytes of small files.
pub(crate) fn seeds() -> [Vec<u8>; 2] {
    [rigid(), skinned()].map(|file| file.glb())
}

/// Checks the seeds, and 2,000 copies of them with one to three bytes changed.
pub(crate) fn check_mutations() -> Result<(), libtest_mimic::Failed> {
    for seed in seeds() {
        load_from_slice(&seed, None).map_err(|error| format!("a seed is refused: {error}"))?;
        survives(&seed)?;
    }
    let mut rng = Rng::new(411);
    for nth in 0..2000 {
        let mut bytes = seeds()[nth % 2].clone();
        for _ in 0..1 + rng.below(3) {
            let at = rng.below(bytes.len());
            bytes[at] = rng.bits().to_le_bytes()[0];
        }
        survives(&bytes).map_err(|fault| format!("{fault}: {bytes:?}"))?;
    }
    Ok(())
}

/// Loads a character and evaluates all of its clips. What is refused must say why.
pub(crate) fn survives(bytes: &[u8]) -> Result<(), String> {
    let refused =
        |text: String| if text.is_empty() { Err("it does not say why".into()) } else { Ok(()) };
    match load_from_slice(bytes, None) {
        Err(error) => refused(error.to_string()),
        Ok(imported) => match evaluate(imported.character) {
            Err(error) => refused(error.to_string()),
            Ok(true) => Ok(()),
            Ok(false) => Err("a palette is not finite".into()),
        },
    }
}

/// Returns true if all palettes are finite.
fn evaluate(character: populace::character::Character) -> Result<bool, Error> {
    let mut crowd =
        Crowd::builder().devices(Device::Native { threads: 1 }).capacity(MEMBERS).build()?;
    let id = crowd.add_character(Arc::new(character))?;
    let clips: Vec<ClipId> =
        crowd.character(id)?.clips().into_iter().map(|(clip, _)| clip).collect();
    let mut members = Vec::new();
    for nth in 0..MEMBERS {
        let member = crowd.spawn(id, Placement::at([0.0; 3]))?;
        members.push(member);
        let mut view = crowd.member_mut(member)?;
        if let Some(clip) = clips.get(nth) {
            view.play(*clip, ClipPlayback::looping())?;
        }
        if let Some(clip) = clips.get(nth + 1) {
            let settings = LayerSettings { mode: LayerMode::Additive, weight: 0.5 };
            view.set_layer(1, settings, None)?;
            view.play(*clip, ClipPlayback::once().on_layer(1))?;
        }
    }
    let mut is_finite = true;
    for secs in STEPS {
        crowd.update(secs)?;
        for member in &members {
            is_finite &= has_finite_palette(&mut crowd, *member)?;
        }
    }
    Ok(is_finite)
}

/// Returns true if all numbers of a member's palette are finite.
pub(crate) fn has_finite_palette(crowd: &mut Crowd, member: MemberId) -> Result<bool, Error> {
    let palette = crowd.member_mut(member)?.palette()?;
    Ok(palette.iter().flat_map(|m| m.rows).flatten().all(f32::is_finite))
}
