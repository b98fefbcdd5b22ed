//! Parsing of argument values.

use std::str::FromStr;

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size(pub(crate) [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides =
            text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        match sides {
            Some(sides) if !sides.contains(&0) => Ok(Self(sides)),
            _ => Err("write width and height in pixels, each 1 or more, such as 1280x720".into()),
        }
    }
}

/// Parses the length of trails in seconds.
pub(super) fn trail_secs(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(secs) if (0.1..=600.0).contains(&secs) => Ok(secs),
        _ => Err("write seconds from 0.1 to 600".into()),
    }
}

/// Parses the height of walls in metres.
pub(super) fn wall_height(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(height) if (0.01..=100.0).contains(&height) => Ok(height),
        _ => Err("write a height in metres from 0.01 to 100".into()),
    }
}

/// Parses a distance in pixels.
pub(super) fn pixels(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(pixels) if (0.0..=100.0).contains(&pixels) => Ok(pixels),
        _ => Err("write pixels from 0 to 100".into()),
    }
}

/// Parses the height of a character in metres.
pub(super) fn height(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(metres) if (1e-3..=1e4).contains(&metres) => Ok(metres),
        _ => Err("write metres from 0.001 to 10000".into()),
    }
}

/// A vertex by the indices in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct VertexId {
    pub(crate) node: usize,
    pub(crate) primitive: usize,
    pub(crate) vertex: usize,
}

impl FromStr for VertexId {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<usize>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[node, primitive, vertex]) => Ok(Self { node, primitive, vertex }),
            _ => Err("write the indices of node, primitive and vertex, for example 5,0,17".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn valid_values_parse_and_others_are_refused() {
        assert_eq!("640x360".parse(), Ok(Size([640, 360])));
        for bad in ["", "640", "0x3", "-1x5", "axb", "5x"] {
            assert!(bad.parse::<Size>().is_err_and(|why| why.contains("1 or more")), "{bad}");
        }
        for bad in ["0", "-1", "inf", "1e-30", "x"] {
            assert!(height(bad).is_err(), "{bad}");
        }
        assert_eq!("5,0,17".parse(), Ok(VertexId { node: 5, primitive: 0, vertex: 17 }));
        for bad in ["", "5,0", "5,0,1,2", "a,b,c", "5,-1,0"] {
            assert!(bad.parse::<VertexId>().is_err(), "{bad}");
        }
    }
}
