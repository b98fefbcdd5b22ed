//! Regions of vertices: by their material's name, or by texture and joints.

use glam::{DAffine3, DVec3};
use populace_model::{Role, RoleMap, Side};

use super::Region;
use crate::mesh::rest_place;
use crate::{Character, Material, Mesh, Texture};

/// Most of the luminance of a skin's median tone by which a texel may differ from it.
const TONE_SPREAD: f64 = 0.55;
/// Number of vertices of a face from which its tone is known.
const FACE_VERTICES: usize = 8;
/// Height of the eyes between the head's joint and the crown, for characters without eye joints.
const EYE_HEIGHT: f64 = 0.5;

/// Finds the regions of a character's vertices.
///
/// A material whose name tells a region gives it to all of its vertices. Other materials with a
/// texture are taken apart vertex by vertex, so that tints of clothes keep the face's skin:
///
/// - The texel at the vertex is skin-coloured: [`Region::Skin`]. Skin has a Cb from 77 to 127 and a
///   Cr from 133 to 173 (Chai and Ngan, *Face segmentation using skin-color map in videophone
///   applications*, IEEE Transactions on Circuits and Systems for Video Technology 9(4), 1999).
///   If the face has such texels, its median luminance is known, and texels whose luminance
///   differs by more than 55 % of it are no skin: brown hair has the same hue.
/// - Otherwise the joint with the largest weight decides by its humanoid role: feet are
///   [`Region::Shoes`], legs and hips [`Region::Trousers`]; the head is [`Region::Hair`] above
///   the eyes and behind its joint, else [`Region::Other`]; all else is [`Region::Top`].
///
/// Without roles, and for materials that tell nothing and have no texture, the region is
/// [`Region::Other`].
#[derive(Debug)]
pub struct RegionFinder<'a> {
    character: &'a Character,
    /// Role of each palette entry; that of the nearest ancestor with one.
    roles: Vec<Option<Role>>,
    /// `model_from_bind` of each palette entry at rest.
    binds: &'a [DAffine3],
    head: Head,
    /// Median luminance of the face's skin, from 0 to 255.
    tone: Option<f64>,
}

/// Places at rest in model space, in metres.
#[derive(Clone, Copy, Debug, Default)]
struct Head {
    eyes_y: f64,
    joint_z: f64,
}

impl<'a> RegionFinder<'a> {
    /// Detects the character's roles, and finds the tone of its face.
    #[must_use]
    pub fn new(character: &'a Character) -> Self {
        let skeleton = &character.skeleton;
        let models = skeleton.rest_models();
        let map = RoleMap::detect(skeleton);
        let role_of = |joint| {
            let above = std::iter::successors(Some(joint), |joint| skeleton.parent(*joint));
            let map = map.as_ref()?;
            above.into_iter().find_map(|j| map.iter().find(|(_, of)| *of == j).map(|(r, _)| r))
        };
        let roles = character.palette.iter().map(|entry| role_of(entry.joint)).collect();
        let binds = character.rest_binds();
        let place = |role| Some(models[map.as_ref()?.joint(role)?.index()].translation);
        let joint = place(Role::Head).unwrap_or_default();
        let crown_y = character.rest_bounds().map_or(joint.y, |bounds| f64::from(bounds.high[1]));
        let middle = joint.y + EYE_HEIGHT * (crown_y - joint.y);
        let eyes_y = place(Role::Eye(Side::Left)).map_or(middle, |eye: DVec3| eye.y);
        let head = Head { eyes_y, joint_z: joint.z };
        let mut finder = Self { character, roles, binds, head, tone: None };
        finder.tone = finder.face_tone();
        finder
    }

    /// Returns the region of each vertex of `mesh`, which is that of `part` or one of its levels of
    /// detail. Vertices are in region [`Region::Other`] if there is no such part.
    #[must_use]
    pub fn regions(&self, part: usize, mesh: &Mesh) -> Vec<Region> {
        let material = self.material(part);
        let all = |region| vec![region; mesh.positions.len()];
        if let Some(region) = material.and_then(|m| Region::of_material(&m.name)) {
            return all(region);
        }
        let Some(texture) = material.and_then(|m| m.base_color_texture) else {
            return all(Region::Other);
        };
        let region = |vertex| {
            let texel = mesh.uvs.get(vertex).and_then(|uv| self.texel(&texture, *uv));
            if texel.is_some_and(|texel| is_skin(texel, self.tone)) {
                return Region::Skin;
            }
            self.region_by_joint(mesh, vertex)
        };
        (0..mesh.positions.len()).map(region).collect()
    }

    fn material(&self, part: usize) -> Option<&Material> {
        self.character.materials.get(self.character.parts.get(part)?.material?)
    }

    fn texel(&self, texture: &Texture, uv: [f32; 2]) -> Option<[u8; 3]> {
        let [red, green, blue, _] = self.character.images.get(texture.image)?.texel(texture, uv);
        Some([red, green, blue])
    }

    /// Returns the role of the palette entry that moves a vertex most.
    fn role(&self, mesh: &Mesh, vertex: usize) -> Option<Role> {
        let strongest = mesh.influences.shares(vertex).reduce(|a, b| if b.1 > a.1 { b } else { a });
        strongest.and_then(|(entry, _)| *self.roles.get(entry)?)
    }

    fn region_by_joint(&self, mesh: &Mesh, vertex: usize) -> Region {
        match self.role(mesh, vertex) {
            None => Region::Other,
            Some(Role::Foot(_) | Role::Toes(_)) => Region::Shoes,
            Some(Role::Hips | Role::UpperLeg(_) | Role::LowerLeg(_)) => Region::Trousers,
            Some(Role::Head | Role::Jaw | Role::Eye(_)) => {
                let place = rest_place(mesh, vertex, self.binds);
                let is_hair = place.y > self.head.eyes_y || place.z < self.head.joint_z;
                if is_hair { Region::Hair } else { Region::Other }
            }
            Some(_) => Region::Top,
        }
    }

    /// Returns the median luminance of skin-coloured texels at the front of the head, below the
    /// eyes.
    fn face_tone(&self) -> Option<f64> {
        let mut tones = Vec::new();
        for (index, part) in self.character.parts.iter().enumerate() {
            let texture = self.material(index).and_then(|material| material.base_color_texture);
            let Some(texture) = texture else { continue };
            for (vertex, uv) in part.mesh.uvs.iter().enumerate() {
                let on_face = || {
                    let place = rest_place(&part.mesh, vertex, self.binds);
                    place.y <= self.head.eyes_y && place.z > self.head.joint_z
                };
                if !matches!(self.role(&part.mesh, vertex), Some(Role::Head | Role::Jaw)) {
                    continue;
                }
                let texel = self.texel(&texture, *uv).filter(|texel| is_skin(*texel, None));
                tones.extend(texel.filter(|_| on_face()).map(luminance));
            }
        }
        tones.sort_by(f64::total_cmp);
        (tones.len() >= FACE_VERTICES).then(|| tones[tones.len() / 2])
    }
}

/// Returns the luminance of an sRGB texel (ITU-R BT.601), from 0 to 255.
fn luminance([r, g, b]: [u8; 3]) -> f64 {
    0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b)
}

/// Returns whether a texel is skin-coloured, and near the median luminance `tone` if that is known.
fn is_skin(texel: [u8; 3], tone: Option<f64>) -> bool {
    let y = luminance(texel);
    let [r, _, b] = texel.map(f64::from);
    let (cb, cr) = (128.0 + 0.564 * (b - y), 128.0 + 0.713 * (r - y));
    let is_near = tone.is_none_or(|tone| (y - tone).abs() <= TONE_SPREAD * tone);
    (77.0..=127.0).contains(&cb) && (133.0..=173.0).contains(&cr) && is_near
}

#[cfg(test)]
mod tests;
