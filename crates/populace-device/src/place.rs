//! Where members stand.

/// Where a member stands in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Metres.
    pub position: [f32; 3],
    /// Sine and cosine of its heading about +Y.
    pub sin_cos: [f32; 2],
    /// Times its own size; above 0.
    pub scale: f32,
}
