//! Layout of a window, remembered from one day to the next.

use serde::{Deserialize, Serialize};

use crate::Error;

/// Smallest and largest side of a window in points.
const SIDES: [f32; 2] = [320.0, 16384.0];

/// Size and panels of a window.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Layout {
    /// Width of the window in points, which are pixels on most screens.
    pub width: f32,
    /// Height of the window in points.
    pub height: f32,
    /// True if the panels are shown.
    pub panels: bool,
    /// True if the times of stages and passes are shown.
    pub times: bool,
    /// True if skeletons are drawn.
    pub skeletons: bool,
    /// True if bounding spheres are drawn.
    pub bounds: bool,
    /// True if levels of detail are written over members.
    pub levels: bool,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            width: 1280.0,
            height: 720.0,
            panels: true,
            times: false,
            skeletons: false,
            bounds: false,
            levels: false,
        }
    }
}

impl Layout {
    /// Reads a layout from TOML. What cannot be read is as usual: a broken file is no reason not to
    /// open a window.
    #[must_use]
    pub fn from_toml(text: &str) -> Self {
        Self::parse(text).unwrap_or_default()
    }

    /// Reads a layout from TOML. A size that no window has is as usual.
    ///
    /// # Errors
    ///
    /// [`Error::Layout`] for text that is no layout, with the first line that cannot be read.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let mut layout: Self = toml::from_str(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start).min(text.len());
            let line = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
            Error::Layout { line, fault: error.message().to_owned() }
        })?;
        let usual = Self::default();
        let [least, most] = SIDES;
        let fits = |side: f32| (least..=most).contains(&side);
        if !(fits(layout.width) && fits(layout.height)) {
            (layout.width, layout.height) = (usual.width, usual.height);
        }
        Ok(layout)
    }

    /// Returns the layout as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let Self { width, height, panels, times, skeletons, bounds, levels } = self;
        format!(
            "width = {width:.1}\nheight = {height:.1}\npanels = {panels}\ntimes = {times}\n\
             skeletons = {skeletons}\nbounds = {bounds}\nlevels = {levels}\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_read_as_they_were_written() {
        let layout = Layout { width: 960.0, height: 540.0, panels: false, ..Layout::default() };
        assert_eq!(Layout::from_toml(&layout.to_toml()), layout);
    }

    #[test]
    fn broken_files_are_no_error() {
        for text in ["", "width = ", "width = \"wide\"", "width = -3.0", "width = nan", "a = 1"] {
            assert_eq!(Layout::from_toml(text), Layout::default(), "{text}");
        }
    }

    #[test]
    fn other_files_are_no_layouts() {
        for (text, message) in [
            ("panels = true\nwidth = ", "line 2: "),
            ("# people\n\nmembers = 3\n", "line 3: unknown field `members`"),
            ("[ground]\nheight_m = 1.0\n", "line 1: unknown field `ground`"),
            ("panels = 1\n", "line 1: invalid type"),
        ] {
            let error = Layout::parse(text).expect_err(text).to_string();
            assert!(error.starts_with(message), "{error}");
        }
        for text in ["", "# nothing yet\n", "panels = false\n", "width = -3.0\n"] {
            Layout::parse(text).expect(text);
        }
    }
}
