//! Parts that the rest pose mirrors.

use crate::{Character, Part};

impl Character {
    /// Returns true if the rest pose mirrors a part, as joints with a negative scale do: its
    /// triangles, counter-clockwise in bind space, are then clockwise at rest. Palette entries that
    /// mirror have most of the part's skinning weight. False if there is no such part.
    #[must_use]
    pub fn is_mirrored(&self, part: usize) -> bool {
        let Some(Part { mesh, .. }) = self.parts.get(part) else { return false };
        let mirrors =
            |entry: u16| self.rest_binds()[usize::from(entry)].matrix3.determinant() < 0.0;
        let influences = mesh.influences.entries.iter().zip(&mesh.influences.weights);
        let signed =
            |(&entry, &weight): (&u16, &f32)| if mirrors(entry) { weight } else { -weight };
        influences.map(signed).sum::<f32>() > 0.0
    }
}
