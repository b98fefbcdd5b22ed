//! The arguments of `populace pose`.

use std::path::PathBuf;

use clap::Args;

use super::devices::DeviceArgs;
use super::values::VertexId;
use crate::aim::{Point, ReachArg};
use crate::input::InputArgs;
use crate::mix::{LayerArg, SlotArg};

#[derive(Args, Debug)]
pub(crate) struct PoseArgs {
    /// A glTF 2.0 file (.gltf, .glb); - is standard input
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Clip to play, by name or by index [default: none; shows the rest pose]
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<String>,
    /// Append the clips of this file to the character's own, retargeted if the skeletons differ.
    /// @people are the clips of the built-in people
    #[arg(long, value_name = "FILE")]
    pub(crate) clips: Option<PathBuf>,
    /// Time of the clip in seconds; not wrapped
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    pub(crate) time: f32,
    /// Blend a clip, by name or by index, held at a time in seconds; can be repeated up to 8 times
    /// [defaults: time 0, weight 1, layer 0]. Add "partial" to accept a clip of which less than
    /// 30 % of the joints are found by name. Write a backslash before a comma, an equals sign or a
    /// backslash in a name
    #[arg(
        long,
        value_name = "clip=C,time=S,weight=W,layer=L,partial",
        conflicts_with_all = ["clip", "time"]
    )]
    pub(crate) slot: Vec<SlotArg>,
    /// Set layer 1, 2 or 3, which overrides the layers below it or, with "additive", adds to them.
    /// The mask limits it to a joint and its descendants. Can be repeated [defaults: all joints,
    /// weight 1]
    #[arg(long, value_name = "L,mask=JOINT,additive,weight=W", allow_hyphen_values = true)]
    pub(crate) layer: Vec<LayerArg>,
    /// Look at a point of model space, in metres. Spine, neck, head and eyes share the rotation
    /// within their limits
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) look_at: Option<Point>,
    /// Reach for a point of model space, in metres, with the two-bone limb that ends in this joint;
    /// can be repeated. Write a backslash before a comma, an equals sign or a backslash in the
    /// name
    #[arg(long, value_name = "JOINT=X,Y,Z")]
    pub(crate) reach: Vec<ReachArg>,
    /// Also print the skinned vertices, in scene space
    #[arg(long)]
    pub(crate) vertices: bool,
    /// Print only this vertex, by the indices in the file; can be repeated
    #[arg(
        long,
        value_name = "NODE,PRIMITIVE,VERTEX",
        requires = "vertices",
        allow_hyphen_values = true
    )]
    pub(crate) vertex: Vec<VertexId>,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}
