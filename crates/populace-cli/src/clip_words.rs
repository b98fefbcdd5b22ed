//! Clips that people stand and walk with, found by the words of their names.

/// Beginnings of words that a name has beside "walk" or "idle" if nobody stands or walks in it.
const OTHERWISE: [&str; 16] = [
    "pose", "jump", "hop", "fall", "swim", "float", "fly", "hang", "climb", "ladder", "sit",
    "seat", "crouch", "crawl", "lie", "dead",
];

/// Returns the indices of up to `count` names with a word, the shortest first. Names of clips in
/// which people jump, sit or do something else are left out.
pub(crate) fn shortest<'a>(
    names: impl IntoIterator<Item = &'a str>,
    word: &str,
    count: usize,
) -> Vec<usize> {
    let fits = |name: &str| {
        let is_other = |part: &String| OTHERWISE.iter().any(|other| part.starts_with(other));
        name.to_lowercase().contains(word) && !words(name).iter().any(is_other)
    };
    let mut found: Vec<(usize, &str)> =
        names.into_iter().enumerate().filter(|(_, name)| fits(name)).collect();
    found.sort_by_key(|(_, name)| name.len());
    found.into_iter().take(count).map(|(index, _)| index).collect()
}

/// Returns the words of a name in lower case: `Robot_WalkJump` has three.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_lower = false;
    for letter in name.chars() {
        if !letter.is_alphabetic() || (after_lower && letter.is_uppercase()) {
            words.push(String::new());
        }
        if letter.is_alphabetic() {
            let word = words.last_mut();
            word.into_iter().for_each(|word| word.extend(letter.to_lowercase()));
        }
        after_lower = letter.is_lowercase();
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_stands_or_walks_by_a_jump() {
        let robot = ["Robot_Idle", "Robot_Jump", "Robot_Walking", "Robot_WalkJump"];
        assert_eq!(shortest(robot, "walk", 3), [2]);
        assert_eq!(shortest(robot, "idle", 1), [0]);
        let mannequin = ["Rig|Jump_Idle", "Rig|Walking_A", "SwimIdle", "sitting idle", "Idle-Pose"];
        assert_eq!(shortest(mannequin, "idle", 1), [0_usize; 0]);
        assert_eq!(shortest(mannequin, "walk", 3), [1]);
    }

    #[test]
    fn the_shortest_names_come_first_and_syllables_are_no_words() {
        let names = ["Walk_Transition", "Sword_Idle", "IDLE", "walk", "WalkBack", "Walk2"];
        assert_eq!(shortest(names, "walk", 3), [3, 5, 4]);
        assert_eq!(shortest(names, "walk", 4), [3, 5, 4, 0]);
        assert_eq!(shortest(names, "idle", 1), [2]);
    }
}
