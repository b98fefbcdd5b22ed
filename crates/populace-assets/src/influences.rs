//! Joint influences of vertices, and the palette of joint and bind matrix pairs.

use std::collections::HashMap;

use populace_character::{Influences, PaletteEntry};
use populace_model::{Affine, JointIndex};

use crate::log::{Checked, Log};

/// Number of entries that a 16-bit index can address.
const PALETTE_LIMIT: usize = 1 << 16;

/// Distinct pairs of joint and bind matrix, in the order of first use.
#[derive(Default)]
pub(crate) struct Palette {
    entries: Vec<PaletteEntry>,
    known: HashMap<(JointIndex, [[u32; 4]; 3]), u16>,
}

impl Palette {
    /// Returns the index of a pair, adding it if necessary. Bitwise equal pairs share an index.
    pub(crate) fn entry(&mut self, entry: &PaletteEntry, place: &str, log: &Log) -> Checked<u16> {
        let bits = entry.joint_from_bind.rows.map(|row| row.map(f32::to_bits));
        if let Some(&known) = self.known.get(&(entry.joint, bits)) {
            return Ok(known);
        }
        let index = u16::try_from(self.entries.len()).map_err(|_| {
            log.problem(
                place,
                format!(
                    "needs more than {PALETTE_LIMIT} pairs of joint and bind matrix, the most that \
                     16-bit indices can address; split the file"
                ),
            )
        })?;
        self.entries.push(*entry);
        self.known.insert((entry.joint, bits), index);
        Ok(index)
    }

    pub(crate) fn entries(&self) -> &[PaletteEntry] {
        &self.entries
    }

    pub(crate) fn into_entries(self) -> Vec<PaletteEntry> {
        self.entries
    }
}

/// Returns influences that bind every vertex to `joint` alone.
pub(crate) fn rigid(
    joint: JointIndex,
    vertex_count: usize,
    palette: &mut Palette,
    place: &str,
    log: &Log,
) -> Checked<Influences> {
    let joint_from_bind = Affine::IDENTITY;
    let entry = palette.entry(&PaletteEntry { joint, joint_from_bind }, place, log)?;
    Ok(Influences {
        per_vertex: 4,
        entries: vec![entry; vertex_count * 4],
        weights: [1.0, 0.0, 0.0, 0.0].repeat(vertex_count),
    })
}

/// Joints and weights of the vertices of a primitive: one or two sets of four per vertex.
pub(crate) struct Sets {
    pub(crate) joints: Vec<Vec<u32>>,
    pub(crate) weights: Vec<Vec<f32>>,
}

/// Deviation of the sum of weights from 1 above which a note is added. Rounding errors are smaller.
const SUM_TOLERANCE: f64 = 0.01;

/// Returns influences with the joints of a skin mapped to palette entries.
pub(crate) fn skinned(
    sets: &Sets,
    skin: &[PaletteEntry],
    palette: &mut Palette,
    place: &str,
    log: &Log,
) -> Checked<Influences> {
    let vertex_count = sets.joints[0].len() / 4;
    // A second set without weights is dropped to save memory.
    let has_weight = |set: &Vec<f32>| set.iter().any(|w| *w != 0.0);
    let used = sets.weights.iter().rposition(has_weight).unwrap_or(0) + 1;
    let mapped = vec![None; skin.len()];
    let mut binder = Binder { skin, mapped, palette, place, log };
    let mut influences = Influences {
        per_vertex: 4 * used,
        entries: vec![0; 4 * used * vertex_count],
        weights: vec![0.0; 4 * used * vertex_count],
    };
    let entries = influences.entries.chunks_exact_mut(4 * used);
    let weights = influences.weights.chunks_exact_mut(4 * used);
    for (vertex, (entries, weights)) in entries.zip(weights).enumerate() {
        let from = vertex * 4..vertex * 4 + 4;
        let joints: Vec<u32> =
            sets.joints[..used].iter().flat_map(|set| &set[from.clone()]).copied().collect();
        for (set, weights) in weights.chunks_exact_mut(4).enumerate() {
            weights.copy_from_slice(&sets.weights[set][from.clone()]);
        }
        binder.bind_vertex(vertex, &joints, entries, weights)?;
    }
    Ok(influences)
}

struct Binder<'a> {
    skin: &'a [PaletteEntry],
    /// Palette entry of each joint of the skin, `None` until a vertex uses it.
    mapped: Vec<Option<u16>>,
    palette: &'a mut Palette,
    place: &'a str,
    log: &'a Log,
}

impl Binder<'_> {
    /// Fills in the entries of one vertex and keeps its weights, except for negative and all-zero
    /// ones. Influences without weight use the entry of a weighted one, because their joint indices
    /// may be invalid.
    fn bind_vertex(
        &mut self,
        vertex: usize,
        joints: &[u32],
        entries: &mut [u16],
        weights: &mut [f32],
    ) -> Checked<()> {
        for weight in weights.iter_mut().filter(|w| **w < 0.0) {
            self.log.note(self.place, "has negative weights; they are treated as zero");
            *weight = 0.0;
        }
        let sum: f64 = weights.iter().copied().map(f64::from).sum();
        if sum > 0.0 {
            if (sum - 1.0).abs() > SUM_TOLERANCE {
                let what = "has vertices whose weights do not sum to 1; they are not changed";
                self.log.note(self.place, what);
            }
        } else {
            let what = "has vertices whose weights are all zero; they follow their first joint";
            self.log.note(self.place, what);
            weights[0] = 1.0;
        }
        let first_weighted = weights.iter().position(|w| *w > 0.0).unwrap_or(0);
        let default_entry = self.entry(vertex, joints[first_weighted])?;
        for ((entry, joint), weight) in entries.iter_mut().zip(joints).zip(weights) {
            *entry = if *weight > 0.0 { self.entry(vertex, *joint)? } else { default_entry };
        }
        Ok(())
    }

    fn entry(&mut self, vertex: usize, joint: u32) -> Checked<u16> {
        let index = joint as usize;
        let Some(entry) = self.skin.get(index) else {
            let what = format!(
                "binds vertex {vertex} to joint {joint}, but the skin has only {} joints",
                self.skin.len()
            );
            return Err(self.log.problem(self.place, what));
        };
        if let Some(known) = self.mapped[index] {
            return Ok(known);
        }
        let known = self.palette.entry(entry, self.place, self.log)?;
        self.mapped[index] = Some(known);
        Ok(known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(joint: u32, x: f32) -> PaletteEntry {
        let mut joint_from_bind = Affine::IDENTITY;
        joint_from_bind.rows[0][3] = x;
        PaletteEntry { joint: JointIndex(joint), joint_from_bind }
    }

    fn bind(
        joints: &[[u32; 4]],
        weights: &[[f32; 4]],
    ) -> Result<(Influences, Vec<PaletteEntry>), String> {
        let skin = [entry(5, 0.0), entry(6, 1.0), entry(5, 0.0), entry(5, 2.0)];
        let sets = Sets {
            joints: joints.chunks(1).map(|s| s[0].to_vec()).collect(),
            weights: weights.chunks(1).map(|s| s[0].to_vec()).collect(),
        };
        let (log, mut palette) = (Log::default(), Palette::default());
        let influences = skinned(&sets, &skin, &mut palette, "here", &log);
        influences
            .map(|i| (i, palette.into_entries()))
            .map_err(|_| log.finish().unwrap_err()[0].to_string())
    }

    #[test]
    fn weights_are_kept_and_equal_pairs_share_an_entry() {
        let (influences, palette) = bind(&[[1, 0, 2, 3]], &[[2.0, 1.0, 1.0, 0.0]]).unwrap();
        assert_eq!(influences.weights, [2.0, 1.0, 1.0, 0.0]);
        assert_eq!(influences.entries[..3], [0, 1, 1]);
        assert_eq!(palette, [entry(6, 1.0), entry(5, 0.0)], "joint 3 has no weight");
    }

    #[test]
    fn second_set_is_dropped_if_all_its_weights_are_zero() {
        let (both, palette) =
            bind(&[[0, 0, 0, 0], [1, 0, 0, 0]], &[[0.25, 0.0, 0.0, 0.0], [0.75, 0.0, 0.0, 0.0]])
                .unwrap();
        assert_eq!(both.per_vertex, 8);
        assert_eq!((both.weights[0], both.weights[4]), (0.25, 0.75));
        assert_eq!(palette[usize::from(both.entries[4])], entry(6, 1.0));
        let (one, _) = bind(&[[0; 4], [1; 4]], &[[1.0, 0.0, 0.0, 0.0], [0.0; 4]]).unwrap();
        assert_eq!(one.per_vertex, 4);
    }

    #[test]
    fn joint_indices_are_checked_only_for_nonzero_weights() {
        assert!(bind(&[[0, 99, 99, 99]], &[[1.0, 0.0, 0.0, -0.5]]).is_ok());
        let error = bind(&[[0, 99, 0, 0]], &[[0.5, 0.5, 0.0, 0.0]]).unwrap_err();
        assert_eq!(error, "here: binds vertex 0 to joint 99, but the skin has only 4 joints");
        let (zero, palette) = bind(&[[1, 0, 0, 0]], &[[0.0; 4]]).unwrap();
        assert_eq!(zero.weights, [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(palette, [entry(6, 1.0)]);
    }

    #[test]
    fn palette_is_limited_to_16_bit_indices() {
        let (log, mut palette) = (Log::default(), Palette::default());
        for joint in 0..65_536 {
            palette.entry(&entry(joint, 0.0), "here", &log).unwrap();
        }
        assert!(palette.entry(&entry(0, 0.0), "here", &log).is_ok());
        assert!(palette.entry(&entry(65_536, 0.0), "here", &log).is_err());
        assert!(log.finish().unwrap_err()[0].what.contains("65536"));
    }
}
