//! The --slot and --layer arguments of `populace pose`: comma-separated lists of `key=value`.

use std::str::FromStr;

use populace::{CharacterId, ClipPlayback, Crowd, LayerMode, LayerSettings, Mask, MemberId};
use populace::{MAX_LAYERS, MAX_SLOTS};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::fit;
use crate::names;
use crate::report::as_typed;

/// A clip held at a time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SlotArg {
    pub(crate) clip: String,
    pub(crate) time_secs: f32,
    pub(crate) weight: f32,
    pub(crate) layer: usize,
    /// Plays the clip even if joint names bind little of it.
    pub(crate) partial: bool,
}

impl SlotArg {
    /// Holds a clip at a time with full weight in layer 0.
    pub(crate) fn alone(clip: &str, time_secs: f32) -> Self {
        Self { clip: clip.to_owned(), time_secs, weight: 1.0, layer: 0, partial: false }
    }
}

/// The settings of a layer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LayerArg {
    pub(crate) layer: usize,
    /// The root of the subtree that the layer affects; all joints if `None`.
    pub(crate) mask: Option<String>,
    pub(crate) settings: LayerSettings,
}

impl FromStr for SlotArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut slot = Self::alone("", 0.0);
        let mut seen = Vec::new();
        for field in fields(text)? {
            let (key, value) = field;
            match (key.as_str(), value) {
                (key, _) if seen.iter().any(|k| k == key) => {
                    return Err(format!("{key} is given twice"));
                }
                ("clip", Some(clip)) => slot.clip = clip,
                ("time", Some(secs)) => {
                    slot.time_secs = finite("time", &secs, "a number of seconds")?
                }
                ("weight", Some(weight)) => slot.weight = share(&weight)?,
                ("layer", Some(layer)) => slot.layer = layer_index(&layer, 0)?,
                ("partial", None) => slot.partial = true,
                _ => {
                    return Err(format!(
                        "\"{key}\" is none of clip=, time=, weight=, layer= and partial"
                    ));
                }
            }
            seen.push(key);
        }
        if seen.iter().any(|key| key == "clip") {
            Ok(slot)
        } else {
            Err("clip= is missing; write for example clip=Walk,time=0.5,weight=1,layer=0".into())
        }
    }
}

impl FromStr for LayerArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut all = fields(text)?.into_iter();
        let layer = match all.next() {
            Some((layer, None)) => layer_index(&layer, 1)?,
            _ => {
                return Err(
                    "write the layer first, for example 1,mask=Spine,additive,weight=0.5".into()
                );
            }
        };
        let mut arg = Self { layer, mask: None, settings: LayerSettings::default() };
        let mut seen = Vec::new();
        for (key, value) in all {
            match (key.as_str(), value) {
                (key, _) if seen.iter().any(|k| k == key) => {
                    return Err(format!("{key} is given twice"));
                }
                ("mask", Some(joint)) => arg.mask = Some(joint),
                ("weight", Some(weight)) => arg.settings.weight = share(&weight)?,
                ("additive", None) => arg.settings.mode = LayerMode::Additive,
                _ => return Err(format!("\"{key}\" is none of mask=, weight= and additive")),
            }
            seen.push(key);
        }
        Ok(arg)
    }
}

/// Splits a text at the first equals sign that is not escaped. Returns the unescaped name and the
/// rest.
pub(crate) fn name_and_rest(text: &str) -> Result<(String, Option<&str>), String> {
    let mut name = String::new();
    let mut letters = text.char_indices();
    while let Some((at, letter)) = letters.next() {
        match letter {
            '=' => return Ok((name, Some(&text[at + 1..]))),
            '\\' => match letters.next() {
                Some((_, quoted @ (',' | '=' | '\\'))) => name.push(quoted),
                _ => {
                    return Err(
                        "a backslash must precede a comma, an = or another backslash".into()
                    );
                }
            },
            plain => name.push(plain),
        }
    }
    Ok((name, None))
}

/// Splits a text at commas into keys and optional values.
fn fields(text: &str) -> Result<Vec<(String, Option<String>)>, String> {
    let mut all = Vec::new();
    let (mut key, mut value) = (String::new(), None::<String>);
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        match letter {
            ',' => all.push((std::mem::take(&mut key), value.take())),
            '=' if value.is_none() => value = Some(String::new()),
            '=' => return Err("write an = in a name as \\=".into()),
            '\\' => match letters.next() {
                Some(quoted @ (',' | '=' | '\\')) => {
                    value.as_mut().unwrap_or(&mut key).push(quoted)
                }
                _ => {
                    return Err(
                        "a backslash must precede a comma, an = or another backslash".into()
                    );
                }
            },
            plain => value.as_mut().unwrap_or(&mut key).push(plain),
        }
    }
    all.push((key, value));
    Ok(all)
}

fn finite(what: &str, text: &str, rule: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|n| n.is_finite());
    number.ok_or_else(|| format!("{what}={text} is not {rule}"))
}

fn share(text: &str) -> Result<f32, String> {
    let rule = "a number from 0 to 1";
    let weight = finite("weight", text, rule)?;
    if (0.0..=1.0).contains(&weight) {
        Ok(weight)
    } else {
        Err(format!("weight={text} is not {rule}"))
    }
}

fn layer_index(text: &str, least: usize) -> Result<usize, String> {
    let most = MAX_LAYERS - 1;
    match text.parse::<usize>() {
        Ok(layer) if (least..=most).contains(&layer) => Ok(layer),
        Ok(0) => Err("layer 0 is mixed by its slots' weights alone; masks, weights and additive \
                      are for layers 1 to 3"
            .into()),
        _ => Err(format!("there is no layer {text}; choose one from {least} to {most}")),
    }
}

/// Refuses more slots than a member has, and layers that are set twice.
pub(crate) fn check(slots: &[SlotArg], layers: &[LayerArg]) -> Result<(), Failure> {
    if slots.len() > MAX_SLOTS {
        let message = format!("{} slots are given; a member has at most {MAX_SLOTS}", slots.len());
        return Err(Failure::usage(message));
    }
    let twice = layers
        .iter()
        .enumerate()
        .find(|(nth, l)| layers[..*nth].iter().any(|o| o.layer == l.layer));
    twice.map_or(Ok(()), |(_, l)| Err(Failure::usage(format!("layer {} is set twice", l.layer))))
}

/// Plays slots in layers on a member, and describes both as JSON. `find` returns a clip and its
/// name for the text typed.
pub(crate) fn apply(
    crowd: &mut Crowd,
    (id, member): (CharacterId, MemberId),
    (slots, layers): (&[SlotArg], &[LayerArg]),
    find: impl Fn(&Crowd, &str) -> Result<(populace::ClipId, String), Failure>,
) -> Result<(Vec<Value>, Vec<Value>), Failure> {
    let mut described = (Vec::new(), Vec::new());
    for slot in slots {
        let (clip, name) = find(crowd, &slot.clip)?;
        let play =
            ClipPlayback::held_at_secs(slot.time_secs).weight(slot.weight).on_layer(slot.layer);
        crowd.member_mut(member)?.blend(clip, if slot.partial { play.partial() } else { play })?;
        let report = crowd.character(id)?.binding(clip)?;
        fit::warn(&name, &crowd.character(id)?.asset().name, &report);
        described.0.push(json!({
            "clip": name,
            "time": as_typed(slot.time_secs),
            "weight": as_typed(slot.weight),
            "layer": slot.layer,
            "binding": fit::as_json(&report),
        }));
    }
    for arg in layers {
        let joint = arg.mask.as_ref();
        let mask = match joint {
            Some(joint) => {
                names::joint(&crowd.character(id)?.asset().skeleton, joint)?;
                let mask = Mask::of_subtrees(&crowd.character(id)?.asset().skeleton, [joint]);
                Some(crowd.character_mut(id)?.add_mask(&mask.map_err(populace::Error::from)?)?)
            }
            None => None,
        };
        crowd.member_mut(member)?.set_layer(arg.layer, arg.settings, mask)?;
        let additive = arg.settings.mode == LayerMode::Additive;
        let weight = as_typed(arg.settings.weight);
        described.1.push(
            json!({"layer": arg.layer, "mask": joint, "additive": additive, "weight": weight}),
        );
    }
    Ok(described)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn slot(text: &str) -> SlotArg {
        text.parse().unwrap()
    }

    #[track_caller]
    fn refused<T: FromStr<Err = String> + std::fmt::Debug>(text: &str, word: &str) {
        let error = text.parse::<T>().unwrap_err();
        assert!(error.contains(word), "{text}: no {word:?} in {error}");
    }

    #[test]
    fn slots_parse_in_any_order() {
        let full =
            SlotArg { weight: 0.25, layer: 3, partial: true, ..SlotArg::alone("Walk", -0.5) };
        assert_eq!(slot("clip=Walk,time=-0.5,weight=0.25,layer=3,partial"), full);
        assert_eq!(slot("partial,layer=3,weight=0.25,time=-.5,clip=Walk"), full);
        assert_eq!(slot("clip=7"), SlotArg::alone("7", 0.0));
        assert_eq!(slot("clip="), SlotArg::alone("", 0.0), "an empty clip name is allowed");
        assert_eq!(slot("clip=a b"), SlotArg::alone("a b", 0.0));
    }

    #[test]
    fn backslash_escapes_names() {
        assert_eq!(slot(r"clip=a\,b\=c\\d,time=1"), SlotArg::alone(r"a,b=c\d", 1.0));
        assert_eq!(slot(r"clip=\\"), SlotArg::alone(r"\", 0.0));
        refused::<SlotArg>("clip=a=b", r"\=");
        refused::<SlotArg>(r"clip=a\b", "a backslash must precede");
        refused::<SlotArg>(r"clip=a\", "a backslash must precede");
        refused::<SlotArg>("clip=a,b", "\"b\" is none of");
        let layer: LayerArg = r"1,mask=arm\=l\,r".parse().unwrap();
        assert_eq!(layer.mask.as_deref(), Some("arm=l,r"));
    }

    #[test]
    fn layers_parse_in_any_order() {
        let additive = LayerSettings { mode: LayerMode::Additive, weight: 0.5 };
        let full = LayerArg { layer: 2, mask: Some("Spine".into()), settings: additive };
        assert_eq!("2,mask=Spine,additive,weight=0.5".parse(), Ok(full.clone()));
        assert_eq!("2,weight=.5,additive,mask=Spine".parse(), Ok(full));
        let plain = LayerArg { layer: 3, mask: None, settings: LayerSettings::default() };
        assert_eq!("3".parse(), Ok(plain));
    }

    #[test]
    fn invalid_values_are_refused_with_the_reason() {
        for (bad, word) in [
            ("", "none of clip="),
            ("time=1", "clip= is missing"),
            ("Walk", "none of clip="),
            ("clip", "none of clip="),
            ("clip=a,clip=b", "clip is given twice"),
            ("clip=a,time=nan", "time=nan is not a number of seconds"),
            ("clip=a,time=", "time= is not"),
            ("clip=a,weight=1.5", "weight=1.5 is not a number from 0 to 1"),
            ("clip=a,weight=inf", "weight=inf is not a number from 0 to 1"),
            ("clip=a,weight=-0.1", "from 0 to 1"),
            ("clip=a,layer=4", "there is no layer 4; choose one from 0 to 3"),
            ("clip=a,layer=-1", "there is no layer -1"),
            ("clip=a,", "\"\" is none of"),
        ] {
            refused::<SlotArg>(bad, word);
        }
        for (bad, word) in [
            ("", "there is no layer "),
            ("mask=Spine", "write the layer first"),
            ("0,mask=Spine", "layer 0 is mixed by its slots"),
            ("4", "there is no layer 4; choose one from 1 to 3"),
            ("one", "there is no layer one"),
            ("1,additive=yes", "\"additive\" is none of"),
            ("1,mask", "\"mask\" is none of"),
            ("1,mask=a,mask=b", "mask is given twice"),
            ("1,additive,additive", "additive is given twice"),
            ("1,weight=2", "weight=2 is not"),
            ("1=2", "write the layer first"),
        ] {
            refused::<LayerArg>(bad, word);
        }
    }
}
