//! The placement of members as devices store it.

/// Position, heading and scale of a member in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The position in metres.
    pub position: [f32; 3],
    /// Sine and cosine of its heading about +Y.
    pub sin_cos: [f32; 2],
    /// The factor on the member's own size; above 0.
    pub scale: f32,
}
