//! Arguments for drawing a crowd.

use std::path::PathBuf;

use clap::Args;
use populace_render::Preset;

use super::devices::DeviceArgs;
use super::film::FilmArgs;
use super::values::{Size, height, pixels};
use crate::camera::View;
use crate::input::InputArgs;

/// Width and height of a picture in pixels, if none are given.
const SIZE: [u32; 2] = [1280, 720];

/// Options for drawing a crowd.
#[derive(Args, Debug)]
pub(crate) struct PictureArgs {
    /// Width and height of the picture in pixels [default: 1280x720; that of a scene file]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub(crate) size: Option<Size>,
    #[command(flatten)]
    pub(crate) film: FilmArgs,
    /// Camera: crowd shows all members, and close one of the nearest, with which it goes; top looks
    /// straight down, iso at a slant from far away, and orbit circles them once a minute; follow:ID
    /// goes behind the member with this number, counted from 0, or the person with this id of a
    /// trajectory file, and eye:ID sees with its eyes; six numbers are the positions of the camera
    /// and of its target in metres; NAME is a camera of the scene file, and PATH.toml holds key
    /// frames of a moving camera
    #[arg(
        long,
        value_name = "crowd|close|top|iso|orbit|follow:ID|eye:ID|X,Y,Z,X,Y,Z|NAME|PATH.toml",
        default_value = "crowd",
        allow_hyphen_values = true
    )]
    pub(crate) camera: View,
    /// Light and surroundings: a clear afternoon, a low sun, clouds, or a grey backdrop [default:
    /// that of the scene file, day without one]
    #[arg(long, value_name = "day|evening|overcast|studio")]
    pub(crate) sky: Option<Preset>,
    /// Scale every character to this height in metres [default: its own height; one below 3 cm or
    /// above 40 m, or with several characters or in a scene below 0.5 or above 2.2 m, becomes a
    /// plausible one]
    #[arg(long, value_name = "METRES", value_parser = height)]
    pub(crate) height: Option<f32>,
    /// Add the clips of this file to all characters, retargeted if skeletons differ. The file is
    /// not drawn. @people are the clips of the built-in people, @child those of one of them. Can be
    /// repeated
    #[arg(long, value_name = "FILE")]
    pub(crate) clips: Vec<PathBuf>,
    /// Clip that all members play [default: walk and idle clips, found by name; all clips if there
    /// are none]
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// Move members by the root motion of their clips, cycle after cycle. Members with clips that
    /// walk in place are always moved
    #[arg(long)]
    pub(crate) root_motion: bool,
    /// Greatest distance in pixels between the surfaces of members that are drawn with fewer
    /// triangles and their own, from 0 to 100
    #[arg(long, value_name = "PIXELS", default_value_t = 0.8, value_parser = pixels)]
    pub(crate) detail: f32,
    /// Draw and evaluate all members in full detail, also those out of view
    #[arg(long)]
    pub(crate) full_detail: bool,
    /// Keep the levels of detail of each file in NAME.levels.glb beside it, and read them from
    /// there until the file changes
    #[arg(long, conflicts_with = "full_detail")]
    pub(crate) cache_levels: bool,
    /// Give all members the colours, clothes and height of their character, rather than their own
    #[arg(long)]
    pub(crate) plain: bool,
    /// Hide the meshes of the node with this name; can be repeated
    #[arg(long, value_name = "NODE")]
    pub(crate) hide: Vec<String>,
    /// Seed of the random numbers; the same seed gives the same picture
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Print one JSON document instead of the path
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

impl PictureArgs {
    /// Returns true if no film and no document is asked for.
    #[cfg(feature = "viewer")]
    pub(crate) fn is_still(&self) -> bool {
        self.film.frames.is_none() && self.film.at.is_none() && !self.json
    }

    /// Returns width and height of the picture in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size.map_or(SIZE, |size| size.0)
    }

    /// Returns the error of levels of detail in pixels; `None` for full detail.
    pub(crate) fn detail_px(&self) -> Option<f32> {
        (!self.full_detail).then_some(self.detail)
    }
}
