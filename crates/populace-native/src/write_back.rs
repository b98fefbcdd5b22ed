//! Write-back stage: the matrix palettes, `model_from_bind = model_from_joint * joint_from_bind`.
//! Twin of `kernels/write_back.cl`.
//!
//! Reads rows of `model_from_joint`, and entries. Writes each palette entry of the frame's members
//! once; padding stays untouched.

use populace_device::layout::{Float4, NONE, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_device::{Frame, Tables};
use populace_model::Affine;
use rayon::prelude::*;

use crate::buffers::ModelRows;
use crate::members::body_of;
use crate::pages::Pages;

/// Palette entries that one thread takes at a time.
const GRAIN: usize = 4096;

/// Writes the palettes of the frame's members.
pub(crate) fn write_back(tables: &Tables, frame: Frame, models: &ModelRows, pages: &mut Pages) {
    for (page, palettes) in pages.iter_mut().enumerate() {
        palettes.par_chunks_mut(GRAIN * 3).enumerate().for_each(|(chunk, palettes)| {
            let first = page * PAGE_ENTRIES as usize + chunk * GRAIN;
            for (index, matrix) in palettes.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                write_entry(tables, frame, models, first + index, matrix);
            }
        });
    }
}

/// Writes the palette entry at an index over all pages.
fn write_entry(
    tables: &Tables,
    frame: Frame,
    models: &ModelRows,
    index: usize,
    matrix: &mut [Float4; 3],
) {
    let Some(&owner) = tables.palette_blocks().as_slice().get(index / PALETTE_BLOCK as usize)
    else {
        return;
    };
    if owner == NONE || !frame.evaluates(owner) {
        return;
    }
    let member = &tables.members().as_slice()[owner as usize];
    let body = body_of(tables, owner);
    let index = index - member.palette_first as usize;
    if index >= body.entry_count as usize {
        return; // padding
    }
    let entry = &tables.entries().as_slice()[body.entry_first as usize + index];
    let joint = (member.joint_first + entry.joint) as usize;
    let model_from_joint = Affine { rows: models.0.each_ref().map(|rows| rows[joint].0) };
    let joint_from_bind = Affine { rows: [entry.row0.0, entry.row1.0, entry.row2.0] };
    *matrix = model_from_joint.mul(&joint_from_bind).rows.map(Float4);
}
