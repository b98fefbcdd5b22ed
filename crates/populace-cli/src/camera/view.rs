//! The argument `--camera`.

use std::path::Path;
use std::str::FromStr;

use super::keys::Keys;

/// The camera that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum View {
    /// Shows all people from the front.
    Crowd,
    /// Shows one of the nearest people, and goes with it.
    Close,
    /// Looks straight down at all people and the place; +X is to the right.
    Top,
    /// Looks at a slant from far away.
    Iso,
    /// Circles all people once a minute.
    Orbit,
    /// Looks from a position to a target, in metres.
    At { eye: [f32; 3], target: [f32; 3] },
    /// Goes behind a person.
    Follow { id: String },
    /// Sees with the eyes of a person.
    Eye { id: String },
    /// Moves by key frames.
    Keys(Keys),
    /// A camera of a scene.
    Named { name: String },
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "crowd" => return Ok(Self::Crowd),
            "close" => return Ok(Self::Close),
            "top" => return Ok(Self::Top),
            "iso" => return Ok(Self::Iso),
            "orbit" => return Ok(Self::Orbit),
            _ => {}
        }
        if Path::new(text).extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
            return Keys::read(Path::new(text)).map(Self::Keys);
        }
        let is_name = |text: &str| {
            text.starts_with(char::is_alphabetic) && !text.contains([':', ',', '/', '.'])
        };
        if is_name(text) && !["follow", "eye"].contains(&text) {
            return Ok(Self::Named { name: text.to_owned() });
        }
        if let Some((kind @ ("follow" | "eye"), id)) = text.split_once(':') {
            if id.is_empty() {
                return Err(format!("write {kind}: and whom, for example {kind}:0"));
            }
            let id = id.to_owned();
            return Ok(if kind == "eye" { Self::Eye { id } } else { Self::Follow { id } });
        }
        let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[a, b, c, x, y, z]) if [a, b, c, x, y, z].iter().all(|v| v.is_finite()) => {
                Ok(Self::At { eye: [a, b, c], target: [x, y, z] })
            }
            _ => {
                Err("write crowd, close, top, iso, orbit, follow:ID, eye:ID, the path of a .toml \
                      file, or the positions of camera and target, for example 0,1.6,5,0,1,0"
                    .into())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of cameras that scene files may give are those that mean no other view.
    #[test]
    fn cameras_of_scene_files_can_be_chosen() {
        let names = ["crowd", "close", "top", "iso", "orbit", "follow", "eye", "a:b", "a.b", "2nd"];
        for name in names.into_iter().chain(["a", "over the street", "école"]) {
            let key = "key = [{ from = [0, 1, 2], to = [0, 0, 0] }]";
            let text = format!("schema = 1\n[[camera]]\nname = \"{name}\"\n{key}\n");
            let is_named = matches!(name.parse(), Ok(View::Named { .. }));
            assert_eq!(populace_scene::plan::ScenePlan::parse(&text).is_ok(), is_named, "{name}");
        }
    }

    #[test]
    fn known_views_parse_and_others_are_refused() {
        assert_eq!("close".parse(), Ok(View::Close));
        assert_eq!("orbit".parse(), Ok(View::Orbit));
        assert_eq!("follow:12".parse(), Ok(View::Follow { id: "12".into() }));
        assert_eq!("eye:0".parse(), Ok(View::Eye { id: "0".into() }));
        let wanted = View::At { eye: [0.0, 1.5, -5.0], target: [0.0; 3] };
        assert_eq!("0,1.5,-5,0,0,0".parse(), Ok(wanted));
        for bad in ["", "1,2,3", "1,2,3,4,5,nan", "follow", "follow:", "look:3"] {
            assert!(bad.parse::<View>().is_err(), "{bad}");
        }
        assert_eq!("pitch".parse(), Ok(View::Named { name: "pitch".into() }));
        let missing = "no-such.toml".parse::<View>().expect_err("no file");
        assert!(missing.contains("no-such.toml"), "{missing}");
    }
}
