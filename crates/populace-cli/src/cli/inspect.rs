//! The arguments of `populace inspect`.

use std::path::PathBuf;

use clap::Args;

use crate::input::InputArgs;
use crate::trajectory::ReadArgs;

#[derive(Args, Debug)]
pub(crate) struct InspectArgs {
    /// glTF 2.0 files (.gltf, .glb), with - for standard input, or trajectory files
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Show only the sizes of clips: their rows, the bytes of the rows, and the bytes of the keys
    /// in the files
    #[arg(long)]
    pub(crate) rows: bool,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
    #[command(flatten)]
    pub(crate) input: InputArgs,
}
