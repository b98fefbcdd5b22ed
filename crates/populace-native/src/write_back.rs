//! Write-back: `model_from_bind = model_from_joint * joint_from_bind`; the twin of
//! `kernels/write_back.cl`.

use populace_device::layout::{Float4, NONE, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_device::{Frame, Tables};
use populace_model::Affine;
use rayon::prelude::*;

use crate::ModelRows;
use crate::pages::Pages;

/// Palette entries that one thread takes at a time.
const GRAIN: usize = 4096;

pub(crate) fn run(tables: &Tables, frame: Frame, models: &ModelRows, pages: &mut Pages) {
    for (page, palettes) in pages.iter_mut().enumerate() {
        palettes.par_chunks_mut(GRAIN * 3).enumerate().for_each(|(chunk, palettes)| {
            let first = page * PAGE_ENTRIES as usize + chunk * GRAIN;
            for (place, matrix) in palettes.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                write_entry(tables, frame, models, first + place, matrix);
            }
        });
    }
}

fn write_entry(
    tables: &Tables,
    frame: Frame,
    models: &ModelRows,
    place: usize,
    matrix: &mut [Float4; 3],
) {
    let Some(&owner) = tables.palette_blocks().as_slice().get(place / PALETTE_BLOCK as usize)
    else {
        return;
    };
    if owner == NONE || !frame.evaluates(owner) {
        return;
    }
    let member = &tables.members().as_slice()[owner as usize];
    let body = &tables.bodies().as_slice()[member.body as usize];
    let index = place - member.palette_first as usize;
    if index >= body.entry_count as usize {
        return; // padding
    }
    let entry = &tables.entries().as_slice()[body.entry_first as usize + index];
    let joint = (member.joint_first + entry.joint) as usize;
    let model_from_joint = Affine { rows: models.0.each_ref().map(|rows| rows[joint].0) };
    let joint_from_bind = Affine { rows: [entry.row0.0, entry.row1.0, entry.row2.0] };
    *matrix = model_from_joint.mul(&joint_from_bind).rows.map(Float4);
}
