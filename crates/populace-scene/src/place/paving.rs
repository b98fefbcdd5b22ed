//! The texture of floors: four slabs of a metre, with quiet joints.

use populace::character::Image;

/// Pixels of a side.
const SIDE: u32 = 256;
/// Width of a joint in pixels.
const JOINT: u32 = 2;
/// sRGB value of the joints, and of the slabs.
const JOINT_VALUE: i32 = 104;
const SLAB_VALUES: [i32; 4] = [136, 139, 141, 137];

/// Returns the texture of a square of two by two metres, which repeats.
pub(super) fn paving() -> Image {
    let half = SIDE / 2;
    let value = |x: u32, y: u32| {
        if x % half < JOINT || y % half < JOINT {
            return JOINT_VALUE;
        }
        let slab = SLAB_VALUES[(x / half + 2 * (y / half)) as usize % SLAB_VALUES.len()];
        slab + grain(x, y)
    };
    let pixel = |x, y| {
        // Somewhat warm, as concrete is.
        let value = value(x, y);
        [value + 2, value, value - 4, 255].map(|v| u8::try_from(v).unwrap_or(u8::MAX))
    };
    let rgba = (0..SIDE).flat_map(|y| (0..SIDE).flat_map(move |x| pixel(x, y))).collect();
    Image { width: SIDE, height: SIDE, rgba }
}

/// Returns a number from -3 to 3 that looks random.
fn grain(x: u32, y: u32) -> i32 {
    let mut hash = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2C1B_3C6D);
    hash ^= hash >> 13;
    i32::try_from(hash % 7).unwrap_or(3) - 3
}
