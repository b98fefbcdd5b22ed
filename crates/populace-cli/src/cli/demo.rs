//! The arguments of `populace demo`.

use std::path::PathBuf;

use clap::Args;

use super::picture::PictureArgs;

#[derive(Args, Debug)]
pub(crate) struct DemoArgs {
    /// Number of people [default: 500; in a window, as many as this machine draws well]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=10_000_000)
    )]
    pub(crate) members: Option<u32>,
    /// Characters of the crowd: files, folders with glTF files, or built-in people [default:
    /// @people]
    #[arg(long, value_name = "PATH", num_args = 1..)]
    pub(crate) cast: Vec<PathBuf>,
    /// File to write: .png, .mp4 or .gif. With --frames, a number is added to the name of each PNG
    /// file [default: none where there is a display; populace-demo.png elsewhere]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write the scene to this file and draw nothing: `populace render` and `populace view` take it
    #[arg(long, value_name = "FILE.toml", conflicts_with = "out")]
    pub(crate) write_scene: Option<PathBuf>,
    /// File with lines such as "at 0.5 click 300 200" that drive the window
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    pub(crate) script: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
}
