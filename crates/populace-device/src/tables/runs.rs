//! Runs of table elements that an asset holds.

use std::ops::Range;

use super::Table;
use super::set::TableSet;
use crate::Error;

/// The kinds of data that are added and removed as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Asset {
    Body,
    Clip,
    BoundClip,
    Contacts,
    States,
    Mask,
    JointScales,
}

/// The runs that one asset holds, by table name.
#[derive(Clone, Debug, Default)]
pub(super) struct Runs(Vec<(&'static str, Range<usize>)>);

impl Runs {
    /// Adds elements to a table and returns the index of the first; 0 for none.
    pub(super) fn add<T: bytemuck::Pod>(
        &mut self,
        table: &mut Table<T>,
        values: impl IntoIterator<Item = T>,
    ) -> Result<u32, Error> {
        let values: Vec<T> = values.into_iter().collect();
        let first = table.add(&values)?;
        self.0.push((table.name(), first as usize..first as usize + values.len()));
        Ok(first)
    }

    /// Returns the run of a table; `None` if the asset holds none of it.
    pub(super) fn of(&self, table: &str) -> Option<Range<usize>> {
        self.0.iter().find(|(name, _)| *name == table).map(|(_, run)| run.clone())
    }

    /// Frees all runs.
    pub(super) fn release(self, all: &mut TableSet) {
        for (table, run) in self.0 {
            all.release(table, run);
        }
    }
}
