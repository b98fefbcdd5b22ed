//! Trajectories in memory.

use std::ops::Range;

use crate::{Place, Source, Warning};

/// A kind of agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Somebody on foot.
    Person,
    /// A vehicle; positions are those of the middle of its front.
    Vehicle,
}

/// One agent.
#[derive(Clone, Debug, PartialEq)]
pub struct Agent {
    /// The id in the file.
    pub id: String,
    /// Person or vehicle.
    pub kind: Kind,
    /// Body height in metres, if the file has it.
    pub height_m: Option<f32>,
    /// Its rows.
    pub(crate) rows: Range<usize>,
    /// Its footsteps.
    pub(crate) steps: Range<usize>,
}

/// A step of one foot, from Vadere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footstep {
    /// When the step begins and ends, in seconds.
    pub secs: [f64; 2],
    /// The middle of the body when the step begins and ends, in metres. Equal points: the agent
    /// stands.
    pub at: [[f32; 2]; 2],
}

/// A value for each row that is neither time nor place.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The name in the file.
    pub name: String,
    /// The values, one for each row of the recording.
    pub values: Values,
}

/// Values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers; NaN where a row has none.
    Numbers(Vec<f32>),
    /// Indices of words; `u32::MAX` where a row has none.
    Words {
        /// The distinct words.
        words: Vec<String>,
        /// The index of each row's word.
        indices: Vec<u32>,
    },
}

/// The trajectories of a file. Rows are sorted by agent and then by time.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Facts about the file.
    pub source: Source,
    /// The agents, in the order in which the file names them first.
    pub agents: Vec<Agent>,
    /// Extra columns.
    pub columns: Vec<Column>,
    /// The place.
    pub place: Place,
    /// Faults of the file that have a sensible reading.
    pub warnings: Vec<Warning>,
    /// The point of the file, in metres, that is `[0, 0]` here; `[0, 0]` unless coordinates are so
    /// large that single precision would round them by more than a millimetre.
    pub origin_m: [f64; 2],
    pub(crate) times: Vec<f64>,
    pub(crate) positions: Vec<[f32; 2]>,
    pub(crate) elevations: Vec<f32>,
    pub(crate) headings: Vec<f32>,
    pub(crate) views: Vec<f32>,
    pub(crate) steps: Vec<Footstep>,
}

/// The rows of one agent. Slices that the file has no values for are empty; the others have equal
/// lengths.
#[derive(Clone, Copy, Debug)]
pub struct Track<'a> {
    /// Times in seconds, each later than the one before.
    pub times: &'a [f64],
    /// Positions on the plan in metres.
    pub positions: &'a [[f32; 2]],
    /// Elevations of the ground in metres.
    pub elevations: &'a [f32],
    /// Headings in radians; NaN where a row has none.
    pub headings: &'a [f32],
    /// Directions of view in radians; NaN where a row has none.
    pub views: &'a [f32],
    /// Footsteps, in the order of time.
    pub steps: &'a [Footstep],
}

impl Recording {
    /// Returns the rows of an agent.
    #[must_use]
    pub fn track(&self, agent: &Agent) -> Track<'_> {
        fn of<T>(values: &[T], rows: Range<usize>) -> &[T] {
            values.get(rows).unwrap_or_default()
        }
        let rows = agent.rows.clone();
        Track {
            times: of(&self.times, rows.clone()),
            positions: of(&self.positions, rows.clone()),
            elevations: of(&self.elevations, rows.clone()),
            headings: of(&self.headings, rows.clone()),
            views: of(&self.views, rows),
            steps: of(&self.steps, agent.steps.clone()),
        }
    }

    /// Returns the rows of an agent, as a range of those of each column.
    #[must_use]
    pub fn rows(&self, agent: &Agent) -> Range<usize> {
        agent.rows.clone()
    }

    /// The number of rows.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.times.len()
    }

    /// Returns the first and the last time in seconds.
    #[must_use]
    pub fn secs(&self) -> [f64; 2] {
        let least = |a: f64, b: &f64| a.min(*b);
        let most = |a: f64, b: &f64| a.max(*b);
        [self.times.iter().fold(f64::MAX, least), self.times.iter().fold(f64::MIN, most)]
    }

    /// Returns the corners of all positions in metres: the least and the greatest coordinates.
    #[must_use]
    pub fn extent(&self) -> [[f32; 2]; 2] {
        let mut corners = [[f32::MAX; 2], [f32::MIN; 2]];
        for at in &self.positions {
            for axis in 0..2 {
                corners[0][axis] = corners[0][axis].min(at[axis]);
                corners[1][axis] = corners[1][axis].max(at[axis]);
            }
        }
        corners
    }

    /// Returns the column with a name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }
}
