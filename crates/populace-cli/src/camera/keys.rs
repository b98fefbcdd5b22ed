//! Key frames of a moving camera, from a TOML file.

use std::ops::Range;
use std::path::Path;

use populace_scene::plan::{CameraKey, CameraPlan};
use serde::Deserialize;
use toml::Spanned;

use crate::text_file;

/// Vertical field of view in degrees, if the file does not say.
const DEFAULT_FOV_DEG: f64 = 40.0;

/// A key frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Key {
    /// Seconds since frame 0.
    pub(super) time: f64,
    /// Position of the camera, in metres.
    pub(super) from: [f64; 3],
    /// Point in the middle of the picture, in metres.
    pub(super) to: [f64; 3],
    /// Vertical field of view in degrees.
    pub(super) fov_deg: f64,
}

/// Key frames in the order of time, at least one. Two at one time are a cut: the camera comes to the
/// first, and goes on from the second.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Keys(Vec<Key>);

/// The file: a list of tables `[[key]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFile {
    key: Spanned<Vec<Spanned<KeyTable>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyTable {
    time: Spanned<f64>,
    from: Spanned<Vec<f64>>,
    to: Spanned<Vec<f64>>,
    fov: Option<Spanned<f64>>,
}

impl Keys {
    /// The keys of a camera of a scene, which has at least one.
    pub(crate) fn of_plan(camera: &CameraPlan) -> Self {
        let key = |key: &CameraKey| Key {
            time: key.time,
            from: key.from.map(f64::from),
            to: key.to.map(f64::from),
            fov_deg: f64::from(key.fov),
        };
        Self(camera.keys.iter().map(key).collect())
    }

    /// Reads a file. Errors name it and the line.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let named = |reason: String| format!("{}: {reason}", path.display());
        let text = text_file::read(path).map_err(named)?;
        Self::parse(&text).map_err(named)
    }

    /// Reads the text of a file. Errors name the line.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let at_line = |span: Range<usize>, message: &str| {
            let before = text.get(..span.start).unwrap_or(text);
            format!("line {}: {message}", before.matches('\n').count() + 1)
        };
        let file: KeyFile =
            toml::from_str(text).map_err(|e| at_line(e.span().unwrap_or_default(), e.message()))?;
        let point = |of: &Spanned<Vec<f64>>, name: &str| {
            let three = <[f64; 3]>::try_from(of.get_ref().as_slice()).ok();
            let near = three.filter(|three| three.iter().all(|number| number.abs() <= 1e6));
            let rule = format!("`{name}` must be three numbers of at most 1000000 metres");
            near.ok_or_else(|| at_line(of.span(), &rule))
        };
        let mut keys: Vec<Key> = Vec::new();
        for table in file.key.get_ref() {
            let table = table.get_ref();
            let fov_deg = table.fov.as_ref().map_or(DEFAULT_FOV_DEG, |fov| *fov.get_ref());
            let [from, to] = [point(&table.from, "from")?, point(&table.to, "to")?];
            let key = Key { time: *table.time.get_ref(), from, to, fov_deg };
            let wrong = |span, message: &str| Err(at_line(span, message));
            if !(0.0..=1e6).contains(&key.time) {
                return wrong(table.time.span(), "`time` must be from 0 to 1000000 seconds");
            }
            if keys.last().is_some_and(|before| before.time > key.time) {
                return wrong(
                    table.time.span(),
                    "`time` must not be before that of the key before",
                );
            }
            if keys.iter().rev().nth(1).is_some_and(|early| early.time >= key.time) {
                return wrong(
                    table.time.span(),
                    "`time` must differ from that of the two keys before, which are a cut",
                );
            }
            if from == to {
                return wrong(table.to.span(), "`to` must differ from `from`");
            }
            if !(1.0..=170.0).contains(&fov_deg) {
                let span = table.fov.as_ref().map_or(0..0, Spanned::span);
                return wrong(span, "`fov` must be from 1 to 170 degrees");
            }
            keys.push(key);
        }
        if keys.is_empty() {
            return Err(at_line(file.key.span(), "there is no key; add one with [[key]]"));
        }
        Ok(Self(keys))
    }

    /// Returns the time of the last key in seconds.
    pub(super) fn last_secs(&self) -> f64 {
        self.0.last().map_or(0.0, |key| key.time)
    }

    /// Returns the time of the first cut after `start` and up to `end`, in seconds.
    pub(super) fn cut_between(&self, start: f64, end: f64) -> Option<f64> {
        let cuts = self.0.iter().zip(self.0.iter().skip(1)).filter(|(a, b)| a.time >= b.time);
        cuts.map(|(key, _)| key.time).find(|cut| start < *cut && *cut <= end)
    }

    /// Returns the camera at a time. It passes through the keys without stops or detours, stays
    /// where two keys are equal, and rests before the first, after the last, and at cuts.
    pub(super) fn at(&self, secs: f64) -> Key {
        let after = self.0.partition_point(|key| key.time <= secs);
        let (Some(low), Some(high)) = (after.checked_sub(1), self.0.get(after)) else {
            return self.0[after.min(self.0.len() - 1)];
        };
        let share = (secs - self.0[low].time) / (high.time - self.0[low].time);
        let between = |of: &dyn Fn(&Key) -> f64| {
            let (from, to) = (of(&self.0[low]), of(high));
            let [out, into] =
                [low, after].map(|at| self.slope(at, of) * (high.time - self.0[low].time));
            let (square, cube) = (share * share, share * share * share);
            (2.0 * cube - 3.0 * square + 1.0) * from
                + (cube - 2.0 * square + share) * out
                + (3.0 * square - 2.0 * cube) * to
                + (cube - square) * into
        };
        Key {
            time: secs,
            from: std::array::from_fn(|axis| between(&|key| key.from[axis])),
            to: std::array::from_fn(|axis| between(&|key| key.to[axis])),
            fov_deg: between(&|key| key.fov_deg),
        }
    }

    /// Returns how fast a number changes at a key, so that it never leaves the range between two
    /// keys: the weighted harmonic mean of its speeds before and after (Fritsch and Butland, "A
    /// method for constructing local monotone piecewise cubic interpolants", SIAM J. Sci. Stat.
    /// Comput. 5, 1984). It is 0 at both ends and at cuts.
    fn slope(&self, at: usize, of: &dyn Fn(&Key) -> f64) -> f64 {
        let [Some(before), Some(key), Some(after)] =
            [at.checked_sub(1), Some(at), Some(at + 1)].map(|i| i.and_then(|i| self.0.get(i)))
        else {
            return 0.0;
        };
        let [early, late] = [key.time - before.time, after.time - key.time];
        if early <= 0.0 || late <= 0.0 {
            return 0.0;
        }
        let [came, goes] = [(of(key) - of(before)) / early, (of(after) - of(key)) / late];
        if came * goes <= 0.0 {
            return 0.0;
        }
        let [first, second] = [2.0 * late + early, late + 2.0 * early];
        (first + second) / (first / came + second / goes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\
        [[key]]\n\
        time = 0\n\
        from = [0, 2, 8]\n\
        to = [0, 1, 0]\n\
        [[key]]\n\
        time = 2\n\
        from = [4, 2, 8]\n\
        to = [0, 1, 0]\n\
        fov = 30\n\
        [[key]]\n\
        time = 3.0\n\
        from = [5, 2, 8]\n\
        to = [0, 1, 0]\n\
        fov = 30\n";

    #[test]
    fn seed_of_camera_files_is_read() {
        crate::fuzz_seeds::write("camera_file", "path", FILE.as_bytes());
        assert_eq!(crate::check_camera_file(FILE), Ok(()));
    }

    #[test]
    fn two_keys_at_one_time_are_a_cut() {
        let key = |time: f64, x: f64| {
            format!("[[key]]\ntime = {time}\nfrom = [{x}, 2, 8]\nto = [0, 1, 0]\n")
        };
        let shots = [key(0.0, 0.0), key(2.0, 4.0), key(2.0, -9.0), key(3.0, -8.0)].concat();
        let keys = Keys::parse(&shots).unwrap();
        let x = |secs: f64| keys.at(secs).from[0];
        assert_eq!([x(1.0), x(2.0), x(2.5), x(9.0)], [2.0, -9.0, -8.5, -8.0]);
        assert!((x(2.0_f64.next_down()) - 4.0).abs() < 1e-9);
        let cuts = [(0.0, 1.9), (1.9, 2.0), (1.9, 2.1), (2.0, 9.0)];
        let cuts = cuts.map(|(start, end)| keys.cut_between(start, end));
        assert_eq!(cuts, [None, Some(2.0), Some(2.0), None]);
        let early = Keys::parse(&[key(2.0, 0.0), key(1.0, 1.0)].concat()).unwrap_err();
        assert!(early.starts_with("line 6: `time` must not be before"), "{early}");
        let three = [key(2.0, 0.0), key(2.0, 1.0), key(2.0, 2.0)].concat();
        let three = Keys::parse(&three).unwrap_err();
        assert!(three.starts_with("line 10: `time` must differ"), "{three}");
    }

    #[test]
    fn cameras_pass_through_their_keys_smoothly() {
        let keys = Keys::parse(FILE).unwrap();
        for (secs, x) in [(-1.0, 0.0), (0.0, 0.0), (2.0, 4.0), (3.0, 5.0), (99.0, 5.0)] {
            assert_eq!(keys.at(secs).from, [x, 2.0, 8.0], "at {secs} s");
        }
        assert_eq!((keys.at(0.0).fov_deg, keys.at(2.5).fov_deg), (40.0, 30.0));
        let mut before = keys.at(0.0);
        let mut speed = 0.0;
        for step in 1..=300 {
            let now = keys.at(f64::from(step) / 100.0);
            let change = now.from[0] - before.from[0];
            assert!(change >= 0.0, "it goes back at {} s", now.time);
            assert!((change - speed).abs() < 2e-3, "it jerks at {} s", now.time);
            (before, speed) = (now, change);
        }
        assert!(speed < 2e-3, "it comes to rest");
    }

    #[test]
    fn errors_name_the_line_and_what_is_wrong() {
        for (from, to, words) in [
            ("time = 2\n", "", ["line 5", "time"]),
            ("time = 3.0\n", "time = 1\n", ["line 11", "not be before"]),
            ("time = 2\n", "time = \"2\"\n", ["line 6", "f64"]),
            ("time = 2\n", "time = -2\n", ["line 6", "`time`"]),
            ("fov = 30\n", "fow = 30\n", ["line 9", "fow"]),
            ("fov = 30\n", "fov = 0\n", ["line 9", "1 to 170"]),
            ("from = [4, 2, 8]", "from = [4, 2]", ["line 7", "three"]),
            ("from = [4, 2, 8]", "from = [4, 2, 8, 0]", ["line 7", "three"]),
            ("from = [4, 2, 8]", "from = [4, nan, 8]", ["line 7", "`from`"]),
            ("from = [4, 2, 8]", "from = [0, 1, 0]", ["line 8", "differ"]),
            ("[[key]]\ntime = 2\n", "[[key\ntime = 2\n", ["line 5", ""]),
        ] {
            let text = FILE.replacen(from, to, 1);
            let message = Keys::parse(&text).unwrap_err();
            assert!(words.iter().all(|word| message.contains(word)), "{message}: {words:?}");
        }
        assert!(Keys::parse("").unwrap_err().contains("key"));
        assert!(Keys::parse("key = []").unwrap_err().contains("[[key]]"));
    }
}
