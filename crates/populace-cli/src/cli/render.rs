//! The arguments of `populace render`.

use std::path::PathBuf;

use clap::Args;

use super::picture::PictureArgs;
use super::trajectories::TrajectoryArgs;

#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    /// A trajectory file, a scene (.toml), or characters: glTF 2.0 files (.gltf, .glb), - for one
    /// from standard input, @people for all built-in people, or one of them, such as @woman or
    /// @child. Characters beside a trajectory file play its people. The clips of files without
    /// meshes are added to all characters
    #[arg(required_unless_present = "cast", value_name = "FILE")]
    pub(crate) inputs: Vec<PathBuf>,
    /// More characters: files, folders with glTF files, or built-in people. A scene names its own
    #[arg(long, value_name = "PATH", num_args = 1..)]
    pub(crate) cast: Vec<PathBuf>,
    /// Number of members of a crowd of characters [default: 1000]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=10_000_000)
    )]
    pub(crate) members: Option<u32>,
    /// File to write: .png, .mp4 or .gif. With --frames, a number is added to the name of each PNG
    /// file, and films of characters need it
    #[arg(long, value_name = "FILE", required_unless_present = "no_draw")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) trajectory: TrajectoryArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}
