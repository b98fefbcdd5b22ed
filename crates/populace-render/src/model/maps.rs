//! Textures of a part beside its base colour.

use std::rc::Rc;

use super::ModelPart;
use crate::gl::Texture;

/// Which textures a shader samples, and whether the surface emits light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Maps {
    /// Substance (metallic and roughness), normal, occlusion and emitted light.
    sampled: [bool; MAPS],
    emits: bool,
}

/// Number of textures beside the base colour.
const MAPS: usize = 4;
/// Their defines, and from `FIRST_UNIT` on their texture units.
const DEFINES: [&str; MAPS] = ["SUBSTANCE_MAP", "NORMAL_MAP", "OCCLUSION_MAP", "EMISSIVE_MAP"];
const FIRST_UNIT: u32 = 3;

/// The textures beside the base colour, in the order of [`Maps`].
pub(crate) type MapTextures = [Option<Rc<Texture>>; MAPS];

impl Maps {
    /// Returns true if a shader samples any of the textures.
    pub(crate) fn is_sampled(self) -> bool {
        self.sampled.contains(&true)
    }

    /// Returns the defines of the shader.
    pub(crate) fn defines(self) -> String {
        let sampled = DEFINES.iter().zip(self.sampled).filter(|(_, sampled)| *sampled);
        let maps = sampled.map(|(name, _)| format!("#define {name}\n"));
        maps.chain(self.emits.then(|| "#define EMISSIVE\n".to_owned())).collect()
    }
}

impl ModelPart {
    /// Returns what a shader samples beside the base colour.
    pub(crate) fn sampled_maps(&self) -> Maps {
        Maps { sampled: [0, 1, 2, 3].map(|map: usize| self.maps[map].is_some()), emits: self.emits }
    }

    /// Binds the textures that a shader samples.
    pub(crate) fn bind_maps(&self, maps: Maps) {
        for ((texture, sampled), unit) in self.maps.iter().zip(maps.sampled).zip(FIRST_UNIT..) {
            if let Some(texture) = texture.as_ref().filter(|_| sampled) {
                texture.bind(unit);
            }
        }
    }
}
