//! Numbered pictures: `crowd_0000.png`, `crowd_0001.png` and so on, named after `crowd.png`.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::folder::paths_in;
use crate::output::numbered;

/// Gaps that a message names at most.
const NAMED_GAPS: usize = 5;

/// Pictures with the numbers of frames.
#[derive(Debug)]
pub(crate) struct Series {
    /// The name without a number.
    name: PathBuf,
    /// Numbers of the frames that exist, ascending, at least one.
    numbers: Vec<u32>,
}

impl Series {
    /// Finds the pictures that are named after `path`, or the only series in the folder `path`.
    pub(crate) fn find(path: &Path) -> Result<Self, Failure> {
        if path.is_dir() {
            return Self::in_folder(path);
        }
        let mut numbers = Vec::new();
        for (number, name) in pictures(path.parent().unwrap_or(Path::new("")))? {
            if numbered(path, number).file_name() == Some(&name) {
                numbers.push(number);
            }
        }
        if numbers.is_empty() {
            let own = path.file_name().and_then(OsStr::to_str).and_then(parts);
            return Err(match own.filter(|_| path.is_file()) {
                Some((name, _)) => Failure::usage(format!(
                    "{} is one picture of a series; name the series by {}",
                    path.display(),
                    path.with_file_name(name).display()
                )),
                None => nothing(path, path),
            });
        }
        Ok(Self { name: path.to_owned(), numbers })
    }

    /// Finds the only series in a folder. Names that are no Unicode do not count.
    fn in_folder(folder: &Path) -> Result<Self, Failure> {
        let mut series: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for (_, file) in pictures(folder)? {
            if let Some((name, number)) = file.to_str().and_then(parts) {
                series.entry(name).or_default().push(number);
            }
        }
        let mut series = series.into_iter().map(|(name, numbers)| (folder.join(name), numbers));
        match (series.next(), series.next()) {
            (Some((name, numbers)), None) => Ok(Self { name, numbers }),
            (Some((first, _)), Some((second, _))) => Err(Failure::usage(format!(
                "{} holds several series of pictures; name one of them, such as {} or {}",
                folder.display(),
                first.display(),
                second.display()
            ))),
            (None, _) => Err(nothing(folder, &folder.join("crowd.png"))),
        }
    }

    /// Returns the frames from the first to the last picture.
    pub(crate) fn frames(&self) -> RangeInclusive<u32> {
        let [first, last] = [self.numbers.first(), self.numbers.last()].map(|n| n.copied());
        first.unwrap_or_default()..=last.unwrap_or_default()
    }

    /// Returns the path of a frame's picture.
    pub(crate) fn path(&self, frame: u32) -> PathBuf {
        numbered(&self.name, frame)
    }

    /// Refuses a series without a picture for each of `frames`, and names the missing ones.
    pub(crate) fn check_complete(&self, frames: &RangeInclusive<u32>) -> Result<(), Failure> {
        let gaps = gaps(&self.numbers, frames);
        let Some([first, last]) = gaps.first() else { return Ok(()) };
        let count: u32 = gaps.iter().map(|[first, last]| last - first + 1).sum();
        let name = |frame: &u32| self.path(*frame).display().to_string();
        let named = gaps.iter().take(NAMED_GAPS).map(|[first, last]| match first == last {
            true => name(first),
            false => format!("{} to {}", name(first), name(last)),
        });
        let more = if gaps.len() > NAMED_GAPS { ", and more" } else { "" };
        let are = if count == 1 { "picture is" } else { "pictures are" };
        Err(Failure::Input(anyhow::anyhow!(
            "{count} {are} missing: {}{more}; draw them with --frames {first}..{last}{}",
            named.collect::<Vec<_>>().join(", "),
            if gaps.len() > 1 { " and so on" } else { "" }
        )))
    }
}

/// Returns the failure of a search for pictures, with `example` as a name for them.
fn nothing(path: &Path, example: &Path) -> Failure {
    Failure::Input(anyhow::anyhow!(
        "{}: there is no picture named like {}, which `populace render --frames N --out {}` writes",
        path.display(),
        numbered(example, 0).display(),
        example.display()
    ))
}

/// Returns the first and the last of each run of frames that `numbers`, ascending, lacks.
fn gaps(numbers: &[u32], frames: &RangeInclusive<u32>) -> Vec<[u32; 2]> {
    let mut gaps = Vec::new();
    let mut next = *frames.start();
    for number in numbers.iter().filter(|number| frames.contains(number)) {
        if *number > next {
            gaps.push([next, number - 1]);
        }
        let Some(following) = number.checked_add(1) else { return gaps };
        next = following;
    }
    if next <= *frames.end() {
        gaps.push([next, *frames.end()]);
    }
    gaps
}

/// Returns the names and numbers of all numbered pictures in a folder, in the order of numbers.
fn pictures(folder: &Path) -> Result<Vec<(u32, OsString)>, Failure> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut found = Vec::new();
    for path in paths_in(folder)? {
        let name = path.file_name().unwrap_or_default();
        if let Some((_, number)) = parts(&name.to_string_lossy()) {
            found.push((number, name.to_owned()));
        }
    }
    found.sort();
    Ok(found)
}

/// Returns the name and the number of a picture: `crowd.png` and 7 of `crowd_0007.png`.
fn parts(file: &str) -> Option<(String, u32)> {
    let (stem, extension) = file.rsplit_once('.')?;
    let (name, digits) = stem.rsplit_once('_')?;
    let number: u32 = digits.parse().ok()?;
    let is_numbered = extension.eq_ignore_ascii_case("png") && format!("{number:04}") == digits;
    is_numbered.then(|| (format!("{name}.{extension}"), number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_apart_as_they_were_put_together() {
        for (name, number) in [("crowd.png", 0), ("a_b.c.PNG", 12345), ("_0001.png", 7)] {
            let file = numbered(Path::new(name), number);
            assert_eq!(parts(file.to_str().expect("text")), Some((name.to_owned(), number)));
        }
        for other in [
            "crowd.png",
            "crowd_7.png",
            "crowd_00007.png",
            "crowd_0007.depth.png",
            "crowd_0007.jpg",
            "crowd_+007.png",
            "crowd_0007",
        ] {
            assert_eq!(parts(other), None, "{other}");
        }
    }

    #[test]
    fn a_picture_of_a_series_is_refused_with_the_name_of_the_series() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let picture = folder.path().join("crowd_0003.png");
        std::fs::write(&picture, "").expect("a file");
        let refusal = Series::find(&picture).expect_err("a refusal").to_string();
        let series = folder.path().join("crowd.png");
        assert!(refusal.ends_with(&format!("by {}", series.display())), "{refusal}");
        assert_eq!(Series::find(&series).expect("a series").numbers, [3]);
    }

    #[test]
    fn gaps_are_found_at_both_ends_and_between() {
        assert_eq!(gaps(&[2, 3, 6], &(0..=8)), [[0, 1], [4, 5], [7, 8]]);
        assert_eq!(gaps(&[0, 1, 2, 9], &(1..=2)), Vec::<[u32; 2]>::new());
        assert_eq!(gaps(&[u32::MAX], &(u32::MAX - 1..=u32::MAX)), [[u32::MAX - 1, u32::MAX - 1]]);
    }
}
