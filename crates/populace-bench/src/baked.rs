//! Baked palettes: looked up in tables instead of computed, as in many crowd renderers.
//!
//! They show the cost of playback alone. A member plays one clip. Baked palettes include the
//! hierarchy and bind matrices, so clips cannot be blended, and joints cannot be masked or moved.

use populace::model::Affine;
use populace::{ClipPlayback, Crowd, Device, Error, Placement, Schedule};
use populace_model::convert::single;
use rayon::prelude::*;

use crate::scene::Scene;

/// Rows per second of clip time.
const ROWS_PER_SEC: f64 = 30.0;
/// Number of members in a batch of one thread.
const BATCH_MEMBERS: usize = 256;

/// The palettes of all members, and the tables that they share.
pub(crate) struct Baked {
    tables: Vec<Table>,
    members: Vec<BakedMember>,
    palettes: Vec<Affine>,
    /// Number of palette entries of each batch of members.
    batch_entries: Vec<usize>,
}

/// The table of one clip of one character: palettes at evenly spaced times from start to end.
struct Table {
    rows: Vec<Affine>,
    entries: usize,
    duration_secs: f64,
}

/// Sizes of baked tables, and of the same clips as rows.
#[derive(Clone, Copy)]
pub struct TableSizes {
    /// Number of tables: of pairs of a character and a clip.
    pub clips: usize,
    /// Bytes of all tables. Each pair of character and clip has its own.
    pub bytes: usize,
    /// Bytes of the same clips as rows, which any character can play.
    pub row_bytes: usize,
}

/// A member's table and starting phase.
struct BakedMember {
    table: u32,
    start_phase: f32,
}

impl Baked {
    /// Computes the tables on the native device, and plays the first clip of each member.
    pub(crate) fn new(scene: &Scene) -> Result<Self, Error> {
        let (mut tables, mut first_tables) = (Vec::new(), Vec::new());
        for index in 0..scene.characters.len() {
            first_tables.push(tables.len());
            tables.extend(bake(scene, index)?);
        }
        let member = |member: usize| {
            let slot = scene.initial_slots(member).next();
            let (clip, start_phase) = slot.map_or((0, 0.0), |slot| (slot.clip, slot.phase));
            let first = first_tables[scene.character_index(member)];
            let table = u32::try_from(first + clip).unwrap_or(0);
            BakedMember { table, start_phase }
        };
        let members: Vec<_> = (0..scene.member_count).map(member).collect();
        let entries = |member: &BakedMember| tables[member.table as usize].entries;
        let batches = members.chunks(BATCH_MEMBERS);
        let batch_entries: Vec<usize> =
            batches.map(|batch| batch.iter().map(entries).sum()).collect();
        let palettes = vec![Affine::IDENTITY; batch_entries.iter().sum()];
        Ok(Self { tables, members, palettes, batch_entries })
    }

    /// Writes all palettes.
    pub(crate) fn update(&mut self, secs: f64) {
        let (tables, mut remaining) = (&self.tables, self.palettes.as_mut_slice());
        let mut batches = Vec::with_capacity(self.batch_entries.len());
        for (members, entries) in self.members.chunks(BATCH_MEMBERS).zip(&self.batch_entries) {
            let (palettes, rest) = remaining.split_at_mut(*entries);
            batches.push((members, palettes));
            remaining = rest;
        }
        batches.into_par_iter().for_each(|(members, mut palettes)| {
            for member in members {
                let table = &tables[member.table as usize];
                let (palette, rest) = palettes.split_at_mut(table.entries);
                table.write(f64::from(member.start_phase), secs, palette);
                palettes = rest;
            }
        });
    }

    /// Returns a member's palette after the last update.
    pub(crate) fn palette(&self, member: usize) -> &[Affine] {
        let entries = |member: &BakedMember| self.tables[member.table as usize].entries;
        let first: usize = self.members[..member].iter().map(entries).sum();
        &self.palettes[first..first + entries(&self.members[member])]
    }

    /// Returns the sizes of the tables, which all members share.
    pub(crate) fn table_sizes(&self, scene: &Scene) -> TableSizes {
        let clips = scene.characters.iter().flat_map(|character| &character.clips);
        TableSizes {
            clips: self.tables.len(),
            bytes: self.tables.iter().map(|table| size_of_val(table.rows.as_slice())).sum(),
            row_bytes: clips.map(|clip| clip.stats().row_bytes).sum(),
        }
    }

    /// Returns the bytes of palettes and members, without the tables.
    pub(crate) fn member_bytes(&self) -> usize {
        size_of_val(self.palettes.as_slice()) + size_of_val(self.members.as_slice())
    }
}

impl Table {
    /// Interpolates the two rows around a time, element by element.
    fn write(&self, start_phase: f64, secs: f64, palette: &mut [Affine]) {
        let last = self.rows.len() / self.entries - 1;
        // A clip of one pose has no duration, and all its rows are that pose.
        let played = if self.duration_secs > 0.0 { secs / self.duration_secs } else { 0.0 };
        let at = (start_phase + played).rem_euclid(1.0) * last as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a row index, not negative"
        )]
        let row = (at as usize).min(last - 1);
        let share = single(at - row as f64);
        let (from, to) = self.rows[row * self.entries..][..2 * self.entries].split_at(self.entries);
        for ((out, from), to) in palette.iter_mut().zip(from).zip(to) {
            let (from, to) = (from.rows.as_flattened(), to.rows.as_flattened());
            for ((out, from), to) in out.rows.as_flattened_mut().iter_mut().zip(from).zip(to) {
                *out = from + (to - from) * share;
            }
        }
    }
}

/// Bakes the tables of a character's clips with one held member per row.
fn bake(scene: &Scene, character: usize) -> Result<Vec<Table>, Error> {
    let character = &scene.characters[character];
    let row_counts = character.clips.iter().map(|clip| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred rows, not negative"
        )]
        let steps = (f64::from(clip.duration_secs()) * ROWS_PER_SEC).round().max(1.0) as usize;
        steps + 1
    });
    let row_counts: Vec<usize> = row_counts.collect();
    let builder =
        Crowd::builder().device(Device::native()).schedule(Schedule::Fused).slots_per_member(1);
    let mut crowd = builder.capacity(row_counts.iter().sum()).build()?;
    let id = crowd.add_character(std::sync::Arc::clone(character))?;
    let mut members = Vec::new();
    for ((clip_id, clip), rows) in crowd.character(id)?.clips().into_iter().zip(&row_counts) {
        for row in 0..*rows {
            let member = crowd.spawn(id, Placement::at([0.0; 3]))?;
            let share = row as f32 / (rows - 1) as f32;
            let secs = clip.start_secs() + share * clip.duration_secs();
            crowd.member_mut(member)?.play(clip_id, ClipPlayback::held_at_secs(secs))?;
            members.push(member);
        }
    }
    crowd.update(0.0)?;
    let mut members = members.into_iter();
    let mut tables = Vec::new();
    for (clip, rows) in character.clips.iter().zip(row_counts) {
        let mut table = Table {
            rows: Vec::new(),
            entries: character.palette.len(),
            duration_secs: f64::from(clip.duration_secs()),
        };
        for member in members.by_ref().take(rows) {
            table.rows.extend(crowd.member_mut(member)?.palette()?);
        }
        tables.push(table);
    }
    Ok(tables)
}
