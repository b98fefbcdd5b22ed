//! Agents by ids that are numbers.

use std::collections::HashMap;

use crate::rows::Rows;

/// The agents whose ids are numbers, so that not every row needs its id as text.
#[derive(Default)]
pub(crate) struct Ids(HashMap<i64, u32>);

impl Ids {
    /// Returns the index of the agent with an id.
    pub(crate) fn agent(&mut self, id: i64, rows: &mut Rows) -> u32 {
        *self.0.entry(id).or_insert_with(|| rows.agent(&id.to_string()))
    }
}
