//! Colours of vertices in place of a texture, for levels whose triangles cover a few pixels.

use std::sync::LazyLock;

use glam::Vec3;
use populace_character::{Image, Mesh, Texture, linear_from_srgb};

/// Most samples of the texture along a side of a triangle.
const SAMPLES: f32 = 16.0;

/// Linear light of each byte of sRGB.
static LIGHT: LazyLock<[f32; 256]> = LazyLock::new(|| {
    #[expect(clippy::cast_possible_truncation, reason = "byte is below 256; light is at most 1")]
    std::array::from_fn(|byte| linear_from_srgb(byte as u8) as f32)
});

/// Returns for each vertex the mean linear colour of the texture on its triangles. Texels count by
/// their area and their nearness to the vertex. A vertex without triangles is white.
pub(super) fn colors(mesh: &Mesh, texture: &Texture, image: &Image) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::ZERO, 0.0); mesh.positions.len()];
    for triangle in mesh.indices.as_chunks::<3>().0 {
        let corners = triangle.map(|index| index as usize);
        let [a, b, c] = corners.map(|corner| Vec3::from(mesh.positions[corner]));
        let area = (b - a).cross(c - a).length();
        let uvs = corners.map(|corner| mesh.uvs[corner]);
        let shares = shares(side_in_texels(uvs, image));
        for share in &shares {
            let uv = [0, 1].map(|i| (0..3).map(|corner| share[corner] * uvs[corner][i]).sum());
            let [red, green, blue, _] = image.texel(texture, uv);
            let color = Vec3::from([red, green, blue].map(|byte| LIGHT[usize::from(byte)]));
            for (corner, share) in corners.iter().zip(share) {
                let weight = share * area / shares.len() as f32;
                sums[*corner].0 += weight * color;
                sums[*corner].1 += weight;
            }
        }
    }
    let mean = |(sum, weight): (Vec3, f32)| if weight > 0.0 { sum / weight } else { Vec3::ONE };
    sums.into_iter().map(mean).collect()
}

/// Returns the longest side of a triangle, in texels of the image.
fn side_in_texels(uvs: [[f32; 2]; 3], image: &Image) -> f32 {
    let size = [image.width as f32, image.height as f32];
    let side = |[from, to]: [usize; 2]| {
        let [x, y] = [0, 1].map(|i| (uvs[to][i] - uvs[from][i]) * size[i]);
        x.hypot(y)
    };
    [[0, 1], [1, 2], [2, 0]].map(side).into_iter().fold(0.0, f32::max)
}

/// Divides a triangle into equal ones, with at most [`SAMPLES`] along a side of `texels`. Returns
/// the share that each corner has in the centre of each.
fn shares(texels: f32) -> Vec<[f32; 3]> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to 16")]
    let side = texels.ceil().clamp(1.0, SAMPLES) as usize;
    let share = |i: usize, j: usize, third: f32| {
        let [b, c] = [i, j].map(|at| (at as f32 + third / 3.0) / side as f32);
        [1.0 - b - c, b, c]
    };
    let mut shares = Vec::with_capacity(side * side);
    for i in 0..side {
        shares.extend((0..side - i).map(|j| share(i, j, 1.0)));
        shares.extend((0..side - i - 1).map(|j| share(i, j, 2.0)));
    }
    shares
}

#[cfg(test)]
mod tests {
    use populace_character::{Influences, TextureFilter, Wrap};

    use super::*;

    const TEXTURE: Texture = Texture {
        image: 0,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: TextureFilter::Linear,
    };

    /// Returns a square of two triangles, with the texture over all of it, and a lone vertex.
    fn square() -> Mesh {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]];
        Mesh {
            positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 5],
            uvs: corners.map(|[x, y]| [0.999 * x, 0.999 * y]).to_vec(),
            colors: Vec::new(),
            influences: Influences {
                per_vertex: 4,
                entries: vec![0; 20],
                weights: [1.0, 0.0, 0.0, 0.0].repeat(5),
            },
            indices: vec![0, 1, 2, 0, 2, 3],
        }
    }

    #[test]
    fn a_plain_texture_gives_its_colour() {
        let image = Image { width: 1, height: 1, rgba: vec![188, 255, 0, 7] };
        let colors = colors(&square(), &TEXTURE, &image);
        for color in &colors[..4] {
            assert!(color.distance(Vec3::new(0.502_886, 1.0, 0.0)) < 1e-5, "{color}");
        }
        assert_eq!(colors[4], Vec3::ONE);
    }

    #[test]
    fn texels_count_by_nearness() {
        // Black on the left, white on the right.
        let row: Vec<u8> = (0..64).flat_map(|x| [if x < 32 { 0 } else { 255 }; 4]).collect();
        let image = Image { width: 64, height: 64, rgba: row.repeat(64) };
        let colors = colors(&square(), &TEXTURE, &image);
        let grey: Vec<f32> = colors[..4].iter().map(|color| color.x).collect();
        // Integrals of the corner's share over the white half: 1/8 of a triangle with its right
        // angle there; the mean of 1/8 and 1/2 for the two triangles at corner 0.
        assert!((grey[3] - 0.125).abs() < 0.02 && (grey[0] - 0.3125).abs() < 0.02, "{grey:?}");
        assert!((grey[0] + grey[2] - 1.0).abs() < 0.02, "both halves are alike: {grey:?}");
        assert!((grey[1] + grey[3] - 1.0).abs() < 0.02, "{grey:?}");
    }

    #[test]
    fn shares_are_those_of_equal_triangles() {
        for (texels, count) in [(0.0, 1), (1.5, 4), (1e9, 256)] {
            let shares = shares(texels);
            assert_eq!(shares.len(), count);
            let sums = [0, 1, 2].map(|i| shares.iter().map(|share| share[i]).sum::<f32>());
            for sum in sums {
                assert!((sum - count as f32 / 3.0).abs() < 1e-3, "{sums:?}");
            }
        }
    }
}
