//! The colours that show a frame best when it may have few of them.

/// Red, green and blue.
pub(crate) type Color = [u8; 3];

/// At most `most` colours for a frame, and which of them shows each colour of the frame.
pub(crate) struct FewColors {
    pub(crate) colors: Vec<Color>,
    /// Each colour of the frame, in order, with its place in `colors`.
    places: Vec<(Color, u8)>,
}

/// Colours of the frame that are shown as one, a range of all.
struct Group {
    range: std::ops::Range<usize>,
    mean: [f64; 3],
    /// The channel in which they differ most.
    channel: usize,
    /// The sum of squared differences from the mean, over pixels and channels.
    error: f64,
}

impl Group {
    fn new(all: &[(Color, u32)], range: std::ops::Range<usize>) -> Self {
        let pixels = || {
            all[range.clone()]
                .iter()
                .map(|(color, count)| (color.map(f64::from), f64::from(*count)))
        };
        let (mut sums, mut errors) = ([0.0; 3], [0.0; 3]);
        for (color, count) in pixels() {
            (0..3).for_each(|at| sums[at] += count * color[at]);
        }
        let count: f64 = pixels().map(|(_, count)| count).sum();
        // Of a single colour, the mean is exact and the error 0. Without pixels both are 0.
        let mean = sums.map(|sum| sum / count.max(1.0));
        for (color, count) in pixels() {
            (0..3).for_each(|at| errors[at] += count * (color[at] - mean[at]).powi(2));
        }
        let channel = (0..3).fold(0, |most, at| if errors[at] > errors[most] { at } else { most });
        Self { range, mean, channel, error: errors.iter().sum() }
    }
}

impl FewColors {
    /// Chooses colours for `pixels`: the group of colours with the greatest error is split at
    /// its mean until there are `most`, which is at most 256.
    pub(crate) fn choose(pixels: impl Iterator<Item = Color>, most: usize) -> Self {
        let mut all = counted(pixels);
        let mut groups = vec![Group::new(&all, 0..all.len())];
        while groups.len() < most {
            let worst = groups.iter().enumerate().max_by(|a, b| a.1.error.total_cmp(&b.1.error));
            let Some((at, worst)) = worst.filter(|(_, worst)| worst.error > 0.0) else { break };
            let (channel, mean) = (worst.channel, worst.mean[worst.channel]);
            let range = worst.range.clone();
            let inside = &mut all[range.clone()];
            inside.sort_unstable_by_key(|(color, _)| color[channel]);
            let low = inside.partition_point(|(color, _)| f64::from(color[channel]) <= mean);
            let split = range.start + low;
            groups[at] = Group::new(&all, range.start..split);
            groups.push(Group::new(&all, split..range.end));
        }
        let mut places = Vec::with_capacity(all.len());
        for (place, group) in (0..=u8::MAX).zip(&groups) {
            places.extend(all[group.range.clone()].iter().map(|(color, _)| (*color, place)));
        }
        places.sort_unstable();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a mean of bytes is from 0 to 255"
        )]
        let colors = groups.iter().map(|group| group.mean.map(|mean| mean.round() as u8));
        Self { colors: colors.collect(), places }
    }

    /// Returns the place in `colors` of what shows `color`, which is one of the frame.
    pub(crate) fn place(&self, color: Color) -> u8 {
        let found = self.places.binary_search_by_key(&color, |(known, _)| *known);
        found.map_or(0, |at| self.places[at].1)
    }
}

/// Returns each colour once, with its number of pixels.
fn counted(pixels: impl Iterator<Item = Color>) -> Vec<(Color, u32)> {
    let mut sorted: Vec<Color> = pixels.collect();
    sorted.sort_unstable();
    let mut all: Vec<(Color, u32)> = Vec::new();
    for color in sorted {
        match all.last_mut() {
            Some((last, count)) if *last == color => *count += 1,
            _ => all.push((color, 1)),
        }
    }
    all
}
