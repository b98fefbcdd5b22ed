//! Images that repeat: paving, asphalt, bricks, roof tiles and grass. They are grey or coloured
//! around their mean, so that a material's base colour keeps its meaning.

use populace_character::Image;

/// Pixels of a side.
const SIDE: u32 = 256;

/// Returns an image of the sRGB colours that `color` gives for pixels across and down.
fn image(color: impl Fn(u32, u32) -> [f64; 3]) -> Image {
    let mut rgba = Vec::with_capacity(4 * (SIDE * SIDE) as usize);
    for y in 0..SIDE {
        for x in 0..SIDE {
            rgba.extend(color(x, y).map(byte));
            rgba.push(u8::MAX);
        }
    }
    Image { width: SIDE, height: SIDE, rgba }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a byte")]
fn byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

/// Returns a number from 0 to 1 that looks random.
fn hash(x: u32, y: u32, salt: u32) -> f64 {
    let mut h = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ salt;
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    f64::from(h ^ (h >> 15)) / f64::from(u32::MAX)
}

/// Returns smooth noise from -1 to 1 that repeats after the image, with `cells` along a side.
fn noise(x: u32, y: u32, cells: u32, salt: u32) -> f64 {
    let cell = SIDE / cells;
    let (i, j) = (x / cell, y / cell);
    let ease = |t: u32| {
        let t = f64::from(t) / f64::from(cell);
        t * t * (3.0 - 2.0 * t)
    };
    let (u, v) = (ease(x % cell), ease(y % cell));
    let at = |a: u32, b: u32| hash((i + a) % cells, (j + b) % cells, salt.wrapping_mul(77) + 5);
    let row = |b: u32| at(0, b) * (1.0 - u) + at(1, b) * u;
    2.0 * (row(0) * (1.0 - v) + row(1) * v) - 1.0
}

/// Returns asphalt with small stones and large, faint patches.
pub(crate) fn asphalt() -> Image {
    image(|x, y| {
        let grain = 26.0 * (hash(x, y, 1) - 0.5) + 10.0 * noise(x, y, 64, 2);
        let patch = 9.0 * noise(x, y, 4, 3) + 6.0 * noise(x, y, 16, 4);
        let stone = if hash(x / 2, y / 2, 5) > 0.97 { 26.0 } else { 0.0 };
        let value = 196.0 + grain + patch + stone;
        [value, value, value + 2.0]
    })
}

/// Returns slabs in rows, each half a slab beside the row before: `across` slabs along a side and
/// `down` rows, an even number.
pub(crate) fn slabs(across: u32, down: u32, joint: u32, contrast: f64) -> Image {
    let (width, height) = (SIDE / across, SIDE / down);
    image(|x, y| {
        let row = y / height;
        let along = (x + if row % 2 == 1 { width / 2 } else { 0 }) % SIDE;
        let (column, u, v) = (along / width, along % width, y % height);
        let grain = 9.0 * (hash(x, y, 11) - 0.5) + 5.0 * noise(x, y, 32, 12);
        if u < joint || v < joint {
            return [168.0 - contrast + grain, 164.0 - contrast + grain, 158.0 - contrast + grain];
        }
        // A worn edge beside each joint.
        let edge = u.min(v).min(width - 1 - u + joint).min(height - 1 - v + joint);
        let worn = if edge < joint + 2 { -6.0 } else { 0.0 };
        let tone = 0.8 * contrast * (hash(column, row, 13) - 0.5);
        let warm = 7.0 * (hash(column, row, 14) - 0.5);
        let value = 214.0 + tone + grain + worn;
        [value + warm, value, value - warm]
    })
}

/// Returns a slab with knobs that feet and sticks feel, four along each side.
pub(crate) fn knobs() -> Image {
    image(|x, y| {
        let cell = SIDE / 4;
        let at = |v: u32| f64::from(v % cell) - 0.5 * f64::from(cell);
        let (u, v) = (at(x), at(y));
        let radius = (u * u + v * v).sqrt() / f64::from(cell);
        // The side towards the light is brighter.
        let lit = -0.7 * (u + v) / f64::from(cell);
        let knob = if radius < 0.27 { 14.0 + 40.0 * lit } else { 0.0 };
        let edge = if (0.27..0.33).contains(&radius) { 60.0 * lit.min(0.0) } else { 0.0 };
        let joint = if x < 4 || y < 4 { -40.0 } else { 0.0 };
        let value = 212.0 + knob + edge + joint + 8.0 * (hash(x, y, 61) - 0.5);
        [value, value, value]
    })
}

/// Returns bricks in a running bond of 16 courses, with light mortar.
pub(crate) fn bricks() -> Image {
    let (width, height, joint) = (SIDE / 4, SIDE / 16, 2);
    image(|x, y| {
        let row = y / height;
        let along = (x + if row % 2 == 1 { width / 2 } else { 0 }) % SIDE;
        let (column, u, v) = (along / width, along % width, y % height);
        let grain = 14.0 * (hash(x, y, 21) - 0.5);
        if u < joint || v < joint {
            return [216.0 + grain, 208.0 + grain, 196.0 + grain];
        }
        let tone = 46.0 * (hash(column, row, 22) - 0.5) + grain + 6.0 * noise(x, y, 8, 23);
        let hot = 10.0 * hash(column, row, 24);
        [206.0 + tone + hot, 196.0 + tone, 190.0 + tone - hot]
    })
}

/// Returns eight rows of roof tiles that overlap.
pub(crate) fn tiles() -> Image {
    let (width, height) = (SIDE / 16, SIDE / 8);
    image(|x, y| {
        let row = y / height;
        let along = (x + if row % 2 == 1 { width / 2 } else { 0 }) % SIDE;
        let (column, u, v) = (along / width, along % width, y % height);
        // Round below, dark where the next row lies above.
        let side = f64::from(u) / f64::from(width) - 0.5;
        let down = f64::from(v) / f64::from(height);
        let bow = 1.0 - 2.4 * side * side;
        let shade = if down < 0.12 { 0.72 } else { 0.86 + 0.16 * down };
        let tone = 0.88 + 0.2 * hash(column, row, 31);
        let value = 205.0 * bow * shade * tone + 8.0 * (hash(x, y, 32) - 0.5);
        [value + 6.0, value, value - 2.0]
    })
}

/// Returns cut stone in courses, with thin joints.
pub(crate) fn ashlar() -> Image {
    slabs(2, 4, 2, 26.0)
}

/// Returns mown grass: blades of many greens, and faint patches.
pub(crate) fn grass() -> Image {
    image(|x, y| {
        let blade = hash(x, y / 3, 41) - 0.5;
        let patch = 0.5 * noise(x, y, 4, 42) + 0.5 * noise(x, y, 16, 43);
        let value = 200.0 + 44.0 * blade + 18.0 * patch;
        let dry = 14.0 * noise(x, y, 8, 44) + 10.0 * hash(x, y, 45);
        [value - 8.0 + dry, value, value - 24.0]
    })
}

/// Returns trodden earth with small stones.
pub(crate) fn earth() -> Image {
    image(|x, y| {
        let value = 196.0
            + 22.0 * noise(x, y, 8, 51)
            + 14.0 * noise(x, y, 32, 52)
            + 26.0 * (hash(x, y, 53) - 0.5);
        let stone = if hash(x / 3, y / 3, 54) > 0.985 { 34.0 } else { 0.0 };
        [value + stone, value - 4.0 + stone, value - 12.0 + stone]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_repeat_without_a_seam() {
        // The step from the last column to the first is no greater than steps inside.
        let image = asphalt();
        let at = |x: u32, y: u32| i32::from(image.rgba[4 * (y * SIDE + x) as usize]);
        let step = |a: u32, b: u32| -> i32 { (0..SIDE).map(|y| (at(a, y) - at(b, y)).abs()).sum() };
        let inside: i32 = (1..SIDE).map(|x| step(x - 1, x)).max().unwrap_or_default();
        assert!(step(SIDE - 1, 0) <= inside);
    }
}
