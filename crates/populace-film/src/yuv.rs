//! Brightness and colour of frames by BT.709, in limited range, with colour at half the width and
//! height.

/// One over the fixed point in which colours are converted.
const SHIFT: u32 = 16;
/// Weights of red, green and blue in brightness: 0.2126, 0.7152 and 0.0722 of the range from 16 to
/// 235 over that from 0 to 255.
const BRIGHTNESS: [i32; 3] = [11_966, 40_254, 4_064];
/// Weights in the difference of blue and brightness, by 1.8556, in the range from 16 to 240.
const BLUENESS: [i32; 3] = [-6_596, -22_189, 28_785];
/// Weights in the difference of red and brightness, by 1.5748, in the range from 16 to 240.
const REDNESS: [i32; 3] = [28_785, -26_146, -2_639];

/// A frame in planes. An odd side is one longer than in the picture, and repeats its last pixels.
pub(crate) struct Yuv {
    picture: [usize; 2],
    size: [usize; 2],
    y: Vec<u8>,
    u: Vec<u8>,
    v: Vec<u8>,
}

impl Yuv {
    /// Returns a black frame for pictures of `size` pixels (width, height).
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let picture = size.map(|side| side as usize);
        let size = picture.map(|side| side.next_multiple_of(2));
        let pixels = size[0] * size[1];
        Self {
            picture,
            size,
            y: vec![16; pixels],
            u: vec![128; pixels / 4],
            v: vec![128; pixels / 4],
        }
    }

    /// Width and height in pixels, both even.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Brightness, blueness and redness.
    pub(crate) fn planes(&self) -> [&[u8]; 3] {
        [&self.y, &self.u, &self.v]
    }

    /// Converts a picture of RGBA; its alpha is ignored.
    pub(crate) fn read(&mut self, rgba: &[u8]) {
        let ([picture_width, picture_height], [width, _]) = (self.picture, self.size);
        let planes = self.u.chunks_exact_mut(width / 2).zip(self.v.chunks_exact_mut(width / 2));
        for ((pair, rows), (u_row, v_row)) in
            (0..).zip(self.y.chunks_exact_mut(2 * width)).zip(planes)
        {
            let row = |y: usize| {
                let begin = 4 * picture_width * y.min(picture_height - 1);
                &rgba[begin..begin + 4 * picture_width]
            };
            let (upper, lower) = (row(2 * pair), row(2 * pair + 1));
            let (y_upper, y_lower) = rows.split_at_mut(width);
            for x in 0..width / 2 {
                let at = [2 * x, (2 * x + 1).min(picture_width - 1)];
                let [a, b] = at.map(|x| color(upper, x));
                let [c, d] = at.map(|x| color(lower, x));
                (y_upper[2 * x], y_upper[2 * x + 1]) = (brightness(a), brightness(b));
                (y_lower[2 * x], y_lower[2 * x + 1]) = (brightness(c), brightness(d));
                let sum = std::array::from_fn(|i| a[i] + b[i] + c[i] + d[i]);
                (u_row[x], v_row[x]) = (chroma(BLUENESS, sum), chroma(REDNESS, sum));
            }
        }
    }
}

fn color(row: &[u8], x: usize) -> [i32; 3] {
    [row[4 * x], row[4 * x + 1], row[4 * x + 2]].map(i32::from)
}

fn weighted(weights: [i32; 3], [r, g, b]: [i32; 3]) -> i32 {
    weights[0] * r + weights[1] * g + weights[2] * b
}

fn byte(value: i32) -> u8 {
    u8::try_from(value.clamp(0, 255)).unwrap_or_default()
}

fn brightness(color: [i32; 3]) -> u8 {
    byte(16 + ((weighted(BRIGHTNESS, color) + (1 << (SHIFT - 1))) >> SHIFT))
}

/// Returns the weighted sum of four colours as a quarter of it.
fn chroma(weights: [i32; 3], sum: [i32; 3]) -> u8 {
    byte(128 + ((weighted(weights, sum) + (1 << (SHIFT + 1))) >> (SHIFT + 2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of BT.709 in 8 bits for white, black and the primaries.
    #[test]
    fn colors_are_those_of_bt_709() {
        for (rgb, [y, u, v]) in [
            ([255, 255, 255], [235, 128, 128]),
            ([0, 0, 0], [16, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 255, 0], [173, 42, 26]),
            ([0, 0, 255], [32, 240, 118]),
        ] {
            let mut yuv = Yuv::new([2, 2]);
            let [r, g, b] = rgb;
            yuv.read(&[r, g, b, 7].repeat(4));
            assert_eq!(yuv.planes(), [&[y; 4][..], &[u], &[v]], "{rgb:?}");
        }
    }

    #[test]
    fn odd_sides_repeat_their_last_pixels() {
        let mut yuv = Yuv::new([3, 1]);
        yuv.read(&[[0, 0, 0, 255], [0, 0, 0, 255], [255, 255, 255, 255]].concat());
        assert_eq!((yuv.size(), yuv.planes()[0]), ([4, 2], &[16, 16, 235, 235].repeat(2)[..]));
    }
}
