//! Variations of people: outfits of colours that go together, other hair and other faces.

use super::{Bottom, Colors, Extra, Hair, Look, Reach, Top};

pub(super) const PALE: [f32; 3] = [0.78, 0.50, 0.38];
pub(super) const LIGHT: [f32; 3] = [0.68, 0.40, 0.27];
pub(super) const OLIVE: [f32; 3] = [0.54, 0.31, 0.18];
pub(super) const TAN: [f32; 3] = [0.42, 0.22, 0.12];
pub(super) const BROWN: [f32; 3] = [0.23, 0.11, 0.058];
pub(super) const DARK: [f32; 3] = [0.115, 0.053, 0.031];

const SKINS: [[f32; 3]; 6] = [PALE, TAN, LIGHT, BROWN, OLIVE, DARK];
const HAIRS: [[f32; 3]; 7] = [
    [0.015, 0.010, 0.009],
    [0.055, 0.027, 0.013],
    [0.14, 0.062, 0.022],
    [0.36, 0.21, 0.075],
    [0.022, 0.013, 0.010],
    [0.19, 0.055, 0.018],
    [0.09, 0.045, 0.02],
];
const BROWN_EYES: [f32; 3] = [0.075, 0.032, 0.014];
const IRISES: [[f32; 3]; 5] =
    [BROWN_EYES, [0.10, 0.19, 0.30], [0.045, 0.02, 0.010], [0.12, 0.15, 0.06], [0.17, 0.20, 0.22]];

/// Colours of top, of what shows under a jacket, of trousers, shoes, accessory and bag, each set
/// in harmony: neutral colours with one accent.
type Set = [[f32; 3]; 6];

const WHITE: [f32; 3] = [0.62, 0.60, 0.56];
const CREAM: [f32; 3] = [0.58, 0.51, 0.38];
const GREY: [f32; 3] = [0.24, 0.25, 0.26];
const CHARCOAL: [f32; 3] = [0.055, 0.058, 0.064];
const NAVY: [f32; 3] = [0.022, 0.038, 0.095];
const DENIM: [f32; 3] = [0.075, 0.135, 0.26];
const KHAKI: [f32; 3] = [0.33, 0.25, 0.145];
const LEATHER: [f32; 3] = [0.12, 0.055, 0.025];
const BLACK: [f32; 3] = [0.026, 0.026, 0.029];

const SETS: [Set; 16] = [
    [[0.50, 0.10, 0.085], WHITE, NAVY, WHITE, CREAM, LEATHER],
    [[0.16, 0.30, 0.44], WHITE, KHAKI, LEATHER, NAVY, NAVY],
    [CREAM, [0.30, 0.10, 0.06], DENIM, WHITE, [0.42, 0.16, 0.06], LEATHER],
    [[0.15, 0.22, 0.11], CREAM, CHARCOAL, LEATHER, KHAKI, KHAKI],
    [WHITE, DENIM, NAVY, LEATHER, [0.45, 0.08, 0.07], NAVY],
    [[0.55, 0.33, 0.06], CHARCOAL, DENIM, WHITE, CHARCOAL, CHARCOAL],
    [NAVY, WHITE, GREY, BLACK, [0.40, 0.07, 0.07], LEATHER],
    [[0.09, 0.27, 0.27], CREAM, BLACK, BLACK, CREAM, [0.45, 0.20, 0.05]],
    [GREY, [0.16, 0.30, 0.44], CHARCOAL, WHITE, BLACK, BLACK],
    [[0.50, 0.27, 0.28], WHITE, DENIM, CREAM, [0.30, 0.10, 0.12], CREAM],
    [KHAKI, WHITE, [0.06, 0.075, 0.05], LEATHER, [0.15, 0.22, 0.11], LEATHER],
    [[0.28, 0.06, 0.10], CREAM, CHARCOAL, BLACK, GREY, BLACK],
    [DENIM, WHITE, CREAM, WHITE, WHITE, NAVY],
    [CHARCOAL, [0.55, 0.33, 0.06], KHAKI, BLACK, [0.55, 0.33, 0.06], GREY],
    [[0.33, 0.27, 0.42], WHITE, GREY, WHITE, NAVY, GREY],
    [[0.42, 0.16, 0.06], CREAM, NAVY, LEATHER, NAVY, LEATHER],
];

const TOPS: [Top; 8] = [
    Top::Jacket,
    Top::Striped,
    Top::Hoodie,
    Top::Shirt,
    Top::Sweater,
    Top::Jacket,
    Top::Shirt,
    Top::Tee,
];

impl Colors {
    /// Returns black everywhere.
    pub(super) fn plain() -> Self {
        let none = [0.0; 3];
        let [shirt, under, trousers, shoes, accessory, bag] = [none; 6];
        Self { skin: none, hair: none, shirt, under, trousers, shoes, accessory, bag }
    }

    /// Returns these colours of skin and hair with other clothes.
    pub(super) fn dressed(mut self, set: usize) -> Self {
        let [shirt, under, trousers, shoes, accessory, bag] = SETS[set % SETS.len()];
        (self.shirt, self.under, self.trousers) = (shirt, under, trousers);
        (self.shoes, self.accessory, self.bag) = (shoes, accessory, bag);
        self
    }
}

/// Outfits after which they repeat: a multiple of all counts of choices.
const REPEATS: usize = 126_000_000;

impl Look {
    /// Returns the same build with other clothes, colours, hair and face. Hair, hat, glasses and
    /// bag are among those that the look wears or has to spare.
    /// Number 0 is `self` unchanged. The same number gives builds of different names different
    /// outfits.
    #[must_use]
    pub fn in_outfit(&self, number: usize) -> Self {
        let mut look = self.clone();
        if number == 0 {
            return look;
        }
        look.name = format!("{} {}", self.name, number.saturating_add(1));
        let number = number % REPEATS;
        // Different people start elsewhere.
        let own: usize = self.name.bytes().map(usize::from).sum();
        let seed = own + number;
        let pick = |count: usize, stride: usize| (number * stride + own) % count;
        let old = self.stoop_rad > 0.1;
        look.colors.skin = SKINS[pick(SKINS.len(), 5)];
        if !old {
            look.colors.hair = HAIRS[pick(HAIRS.len(), 3)];
        }
        let dark = look.colors.skin[0] < 0.3;
        if dark && !old {
            look.colors.hair = HAIRS[0];
        }
        look.face.iris = if dark { BROWN_EYES } else { IRISES[pick(IRISES.len(), 2)] };
        look.colors = look.colors.dressed(5 * number + 3 * own);
        look.vary_face(seed);
        look.swap(number, own);
        look.change_clothes(seed);
        look
    }

    fn vary_face(&mut self, seed: usize) {
        let vary = |salt: usize| {
            let mixed = (seed % 1000 * 37 + salt * 101) * 435 % 1000;
            mixed as f64 / 500.0 - 1.0
        };
        let face = &mut self.face;
        face.jaw *= 1.0 + 0.08 * vary(1);
        face.chin *= 1.0 + 0.5 * vary(2);
        face.smile = (face.smile + 0.35 * vary(3)).clamp(0.1, 1.0);
        face.lips *= 1.0 + 0.4 * vary(4);
        face.nose_length *= 1.0 + 0.14 * vary(5);
        face.nose_width *= 1.0 + 0.20 * vary(6);
        face.nose_hump += 0.6 * vary(7);
        face.brow *= 1.0 + 0.25 * vary(8);
        face.eyes *= 1.0 + 0.04 * vary(9);
        face.open *= 1.0 + 0.10 * vary(10);
    }

    /// Swaps what is worn for something to spare: hair by turns, the rest now and then.
    fn swap(&mut self, number: usize, own: usize) {
        let all: Vec<Extra> = self.worn().into_iter().chain(self.spare.iter().copied()).collect();
        let hairs: Vec<Hair> = all
            .iter()
            .filter_map(|e| if let Extra::Hair(hair) = e { Some(*hair) } else { None })
            .collect();
        self.hair = hairs[number % hairs.len()];
        let turn = number + own;
        let worn = |of: usize, nth: usize| turn % of == nth;
        let flat = !matches!(self.hair, Hair::Curly | Hair::Bun | Hair::Headscarf);
        (self.hat, self.glasses, self.bag) = (None, None, None);
        for extra in &all {
            match *extra {
                Extra::Hat(hat) if flat && worn(3, 0) => self.hat = Some(hat),
                Extra::Glasses(glasses) if worn(3, 1) => self.glasses = Some(glasses),
                Extra::Bag(bag) if worn(2, 1) => self.bag = Some(bag),
                _ => {}
            }
        }
        self.spare = all.into_iter().filter(|extra| !self.worn().contains(extra)).collect();
    }

    fn change_clothes(&mut self, seed: usize) {
        self.top = TOPS[seed % TOPS.len()];
        let scarf = self.hair == Hair::Headscarf;
        self.sleeves = match self.top {
            Top::Tee | Top::Striped | Top::Blouse if !scarf => Reach::Short,
            Top::Shirt if seed.is_multiple_of(3) && !scarf => Reach::Short,
            _ => Reach::Long,
        };
        let gathered = matches!(self.hair, Hair::Bob | Hair::Long | Hair::Bun | Hair::Ponytail);
        let small = self.height_m < 1.45;
        self.bottom = match seed % 4 {
            0 if gathered => Bottom::Skirt,
            2 if gathered => Bottom::Dress,
            1 | 3 if small => Bottom::Shorts,
            _ => Bottom::Trousers,
        };
        if self.bottom == Bottom::Dress && matches!(self.top, Top::Shirt | Top::Hoodie) {
            self.top = Top::Blouse;
        }
    }
}
