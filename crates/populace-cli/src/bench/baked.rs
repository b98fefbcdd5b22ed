//! Palettes looked up instead of computed, as many crowds have them: the price of playback alone,
//! and the measure of what control costs. A member plays one clip and nothing else: two clips
//! cannot be blended once hierarchy and binds are in the palettes, nor can a joint be masked or
//! moved.

use populace::model::Affine;
use populace::{Crowd, Device, Error, Placement, Play, Schedule};
use rayon::prelude::*;

use super::scene::Scene;

const ROWS_PER_SEC: f64 = 30.0;
/// Members that a thread takes at a time.
const RUN: usize = 256;

/// Palettes of all members, from tables that they share.
pub(crate) struct Baked {
    tables: Vec<Table>,
    actors: Vec<Actor>,
    palettes: Vec<Affine>,
    /// Palette entries of each run of members.
    run_entries: Vec<usize>,
}

/// One clip of one character: palettes at evenly spaced times from its start to its end.
struct Table {
    rows: Vec<Affine>,
    entries: usize,
    duration_secs: f64,
}

/// What baked palettes cost beside what clips take otherwise.
#[derive(Clone, Copy)]
pub(crate) struct TableSizes {
    pub(crate) clips: usize,
    /// Of all tables; every model needs its own of every clip.
    pub(crate) bytes: usize,
    /// Of the same clips as rows, which any model can play.
    pub(crate) row_bytes: usize,
}

/// A member.
struct Actor {
    table: u32,
    start_phase: f32,
}

impl Baked {
    /// Computes the tables with the native device, and lets each member play its first clip.
    pub(crate) fn new(scene: &Scene) -> Result<Self, Error> {
        let (mut tables, mut firsts) = (Vec::new(), Vec::new());
        for kind in 0..scene.characters.len() {
            firsts.push(tables.len());
            tables.extend(bake(scene, kind)?);
        }
        let actor = |member: usize| {
            let slot = scene.played(member).next();
            let (clip, start_phase) = slot.map_or((0, 0.0), |slot| (slot.clip, slot.phase));
            let table = u32::try_from(firsts[scene.kind(member)] + clip).unwrap_or(0);
            Actor { table, start_phase }
        };
        let actors: Vec<_> = (0..scene.member_count).map(actor).collect();
        let entries = |actor: &Actor| tables[actor.table as usize].entries;
        let run_entries: Vec<usize> =
            actors.chunks(RUN).map(|run| run.iter().map(entries).sum()).collect();
        let palettes = vec![Affine::IDENTITY; run_entries.iter().sum()];
        Ok(Self { tables, actors, palettes, run_entries })
    }

    /// Writes all palettes.
    pub(crate) fn update(&mut self, secs: f64) {
        let (tables, mut left) = (&self.tables, self.palettes.as_mut_slice());
        let mut runs = Vec::with_capacity(self.run_entries.len());
        for (actors, entries) in self.actors.chunks(RUN).zip(&self.run_entries) {
            let (run, rest) = left.split_at_mut(*entries);
            runs.push((actors, run));
            left = rest;
        }
        runs.into_par_iter().for_each(|(actors, mut run)| {
            for actor in actors {
                let table = &tables[actor.table as usize];
                let (palette, rest) = run.split_at_mut(table.entries);
                table.write(f64::from(actor.start_phase), secs, palette);
                run = rest;
            }
        });
    }

    /// A member's palette after the last update.
    pub(crate) fn palette(&self, member: usize) -> &[Affine] {
        let entries = |actor: &Actor| self.tables[actor.table as usize].entries;
        let first: usize = self.actors[..member].iter().map(entries).sum();
        &self.palettes[first..first + entries(&self.actors[member])]
    }

    /// What the tables take, which all members share.
    pub(crate) fn table_sizes(&self, scene: &Scene) -> TableSizes {
        let clips = scene.characters.iter().flat_map(|character| &character.clips);
        TableSizes {
            clips: self.tables.len(),
            bytes: self.tables.iter().map(|table| size_of_val(table.rows.as_slice())).sum(),
            row_bytes: clips.map(|clip| clip.stats().row_bytes).sum(),
        }
    }

    /// Bytes of palettes and of what members need to be looked up; without the tables.
    pub(crate) fn member_bytes(&self) -> usize {
        size_of_val(self.palettes.as_slice()) + size_of_val(self.actors.as_slice())
    }
}

impl Table {
    /// Mixes the two rows around a time, matrix by matrix.
    fn write(&self, start_phase: f64, secs: f64, palette: &mut [Affine]) {
        let last = self.rows.len() / self.entries - 1;
        let at = (start_phase + secs / self.duration_secs).rem_euclid(1.0) * last as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a row's number"
        )]
        let row = (at as usize).min(last - 1);
        #[expect(clippy::cast_possible_truncation, reason = "the nearest is what is wanted")]
        let share = (at - row as f64) as f32;
        let (from, to) = self.rows[row * self.entries..][..2 * self.entries].split_at(self.entries);
        for ((out, from), to) in palette.iter_mut().zip(from).zip(to) {
            let (from, to) = (from.rows.as_flattened(), to.rows.as_flattened());
            for ((out, from), to) in out.rows.as_flattened_mut().iter_mut().zip(from).zip(to) {
                *out = from + (to - from) * share;
            }
        }
    }
}

/// The tables of a character's clips: one member stands at the time of each row.
fn bake(scene: &Scene, kind: usize) -> Result<Vec<Table>, Error> {
    let character = &scene.characters[kind];
    let row_counts = character.clips.iter().map(|clip| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred"
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
    for ((clip_id, clip), rows) in crowd.clips(id)?.into_iter().zip(&row_counts) {
        for row in 0..*rows {
            let member = crowd.spawn(id, Placement::at([0.0; 3]))?;
            let share = row as f32 / (rows - 1) as f32;
            let secs = clip.start_secs() + share * clip.duration_secs();
            crowd.play(member, clip_id, Play::held_at_secs(secs))?;
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
            table.rows.extend(crowd.palette(member)?);
        }
        tables.push(table);
    }
    Ok(tables)
}
