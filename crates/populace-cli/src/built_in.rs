//! The built-in people, who stand for files by name: `@man`, or `@people` for all of them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use populace::character::Character;
use populace::clip::Clip;
use populace_cast::{Colors, Extra, Look, dress, dress_with_options, person};

use crate::failure::Failure;

/// Returns the name of a built-in person given in place of a file: `people` for `@people`.
pub(crate) fn name_of(input: &Path) -> Option<&str> {
    input.to_str()?.strip_prefix('@')
}

/// What the built-in people of a cast wear.
#[derive(Clone, Copy, Default)]
pub(crate) struct Clothes {
    /// They have what they could wear besides what they wear.
    pub(crate) options: bool,
    /// They wear no hats, which helmets do not cover.
    pub(crate) no_hats: bool,
    /// The colour of their upper clothes, linear red, green and blue from 0 to 1.
    pub(crate) top: Option<[f32; 3]>,
    /// Their hats, headscarves and bags are grey, for members that are dyed: a tint is that of all
    /// of them, and would leave each the hue by which it differs from the others.
    pub(crate) grey_accessories: bool,
}

impl Clothes {
    fn put_on(&self, look: &mut Look) {
        if self.no_hats {
            look.hat = None;
            look.spare.retain(|extra| !matches!(extra, Extra::Hat(_)));
        }
        if let Some(color) = self.top {
            look.colors.shirt = color;
        }
        if self.grey_accessories {
            let Colors { accessory, bag, .. } = &mut look.colors;
            [accessory, bag].into_iter().for_each(|color| *color = [luminance(*color); 3]);
        }
    }
}

/// Returns the light of a linear colour, as grey of it has.
fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Number of outfits of each person among `@people`.
const OUTFITS: usize = 3;

/// Returns the looks of built-in people: all of them in several outfits for `people`, otherwise the
/// one with this name.
fn looks(name: &str) -> Result<Vec<Look>, Failure> {
    let presets = Look::presets();
    if name == "people" {
        let outfits =
            (0..OUTFITS).flat_map(|number| presets.iter().map(move |look| look.in_outfit(number)));
        return Ok(outfits.collect());
    }
    let list =
        presets.iter().map(|look| format!("\"@{}\"", look.name)).collect::<Vec<_>>().join(", ");
    let look = presets.into_iter().find(|look| look.name == name).ok_or_else(|| {
        Failure::usage(format!(
            "there is no built-in \"@{name}\"; choose one of \"@people\", {list}"
        ))
    })?;
    Ok(vec![look])
}

/// Returns the built-in person of this name.
pub(crate) fn person_of(name: &str) -> Result<Character, Failure> {
    match &looks(name)?[..] {
        [look] => create_person(look),
        _ => Err(Failure::usage(format!("@{name} are several; name one, such as @man"))),
    }
}

fn create_person(look: &Look) -> Result<Character, Failure> {
    person(look).map_err(|e| Failure::Run(e.into()))
}

/// Returns the people of this name, each in one outfit; all of them for `people`.
#[cfg(feature = "bench")]
pub(crate) fn people(name: &str) -> Result<Vec<Arc<Character>>, Failure> {
    let looks = if name == "people" { Look::presets() } else { looks(name)? };
    looks.iter().map(|look| create_person(look).map(Arc::new)).collect()
}

/// Returns the people of this name in their outfits, in what `clothes` says.
pub(crate) fn dressed(name: &str, clothes: Clothes) -> Result<Vec<Character>, Failure> {
    let mut looks = looks(name)?;
    looks.iter_mut().for_each(|look| clothes.put_on(look));
    let make = if clothes.options { dress_with_options } else { dress };
    make(&looks).map_err(|e| Failure::Run(e.into()))
}

/// Returns the clips of a built-in person; `people` stands for the first of them. They are made
/// once.
pub(crate) fn clips(name: &str) -> Result<Vec<Arc<Clip>>, Failure> {
    static MADE: Mutex<BTreeMap<String, Vec<Arc<Clip>>>> = Mutex::new(BTreeMap::new());
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(clips) = made.get(name) {
        return Ok(clips.clone());
    }
    let looks = looks(name)?;
    let clips = looks.first().map(create_person).transpose()?.map_or(vec![], |p| p.clips.clone());
    made.insert(name.to_owned(), clips.clone());
    Ok(clips)
}

#[cfg(test)]
mod tests {
    use populace::MemberLook;
    use populace::character::Region;
    use populace_cast::option_of;
    use populace_variety::Dye;

    use super::*;

    #[test]
    fn who_wears_a_helmet_has_no_hat_to_wear() {
        let hats = |no_hats| {
            let clothes = Clothes { options: true, no_hats, ..Clothes::default() };
            let people = dressed("people", clothes).unwrap();
            let parts = people.iter().flat_map(|person| &person.parts);
            let groups = parts.filter_map(|part| Some(option_of(&part.node_name)?.0));
            groups.filter(|group| *group == "hat").count()
        };
        assert!(hats(false) > 0);
        assert_eq!(hats(true), 0);
    }

    /// Each accessory has the same hue as the colour, however bright it is.
    #[test]
    fn caps_and_bags_of_dyed_people_have_no_hue_of_their_own() {
        let clothes = Clothes { options: true, grey_accessories: true, ..Clothes::default() };
        let mut seen = 0;
        for person in dressed("people", clothes).unwrap() {
            let look = Dye::of(&person).dyed(MemberLook::PLAIN, [0.4; 3]);
            let tint = look.tint(Region::Accessory);
            for material in person.materials.iter().filter(|m| m.name.starts_with("Accessory")) {
                let shown = [0, 1, 2].map(|c| material.base_color[c] * tint[c]);
                let [low, high] = [f32::min, f32::max].map(|of| shown.into_iter().reduce(of));
                let (low, high) = (low.unwrap(), high.unwrap());
                let name = (&person.name, &material.name);
                assert!(high < 1.15 * low, "{name:?} is {shown:?}");
                seen += 1;
            }
        }
        assert!(seen > 20, "{seen} accessories");
    }

    #[test]
    fn all_tops_take_the_colour_that_was_asked_for() {
        let clothes = Clothes { top: Some([0.8, 0.1, 0.1]), ..Clothes::default() };
        for person in dressed("people", clothes).unwrap() {
            let tops = person.materials.iter().filter(|m| m.name.starts_with("Top"));
            let colors: Vec<[f32; 4]> = tops.map(|material| material.base_color).collect();
            assert_eq!(colors, [[0.8, 0.1, 0.1, 1.0]], "{}", person.name);
        }
    }
}
