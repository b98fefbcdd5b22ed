//! Messages about characters without clips.

use populace::Crowd;

use super::{ClipChoice, CrowdRole};
use crate::failure::Failure;
use crate::report::message;

/// Reports which characters had no clips, and what they play.
pub(crate) fn report(
    crowd: &Crowd,
    roles: &[CrowdRole],
    choice: ClipChoice,
) -> Result<(), Failure> {
    let mut groups: Vec<(Vec<&str>, Vec<String>)> = Vec::new();
    for role in roles.iter().filter(|role| role.is_clipless) {
        let name = role.character.name.as_str();
        let clips = crowd.character(role.id)?.clips();
        let is_played = |id| role.clips.iter().any(|played| played.id == id);
        let played = clips.iter().filter(|(id, _)| is_played(*id));
        let played: Vec<_> = played.map(|(_, clip)| clip.name().to_owned()).collect();
        match groups.iter_mut().find(|(_, other)| *other == played) {
            Some((names, _)) => names.push(name),
            None => groups.push((vec![name], played)),
        }
    }
    for (names, played) in groups {
        message!("{}", words(&names, &played, choice));
    }
    Ok(())
}

/// Says of characters without clips which clips of the built-in people they play.
fn words(names: &[&str], played: &[String], choice: ClipChoice) -> String {
    let (who, has, play, is) = match names {
        [name] => (format!("\"{name}\""), "has", "it plays", "it is"),
        _ => {
            let first = names.first().unwrap_or(&"");
            let who = format!("{} characters, such as \"{first}\",", names.len());
            (who, "have", "they play", "they are")
        }
    };
    if played.is_empty() {
        return format!(
            "warning: {who} {has} no clips, and no joints of a humanoid that could play those of \
             the built-in people; {is} drawn at rest; add clips with --clips FILE"
        );
    }
    // Scenes and recordings choose among all clips.
    let clips = match choice {
        ClipChoice::Clips { .. } => format!("{} of", played.join(" and ")),
        ClipChoice::Gaits | ClipChoice::Scene => "those of".to_owned(),
    };
    format!("{who} {has} no clips; {play} {clips} the built-in people, retargeted")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_without_clips_are_counted_and_scenes_name_no_clip() {
        let played = ["Idle".to_owned(), "Walk".to_owned()];
        let clips = ClipChoice::Clips { name: None, root_motion: false };
        assert_eq!(
            words(&["golem"], &played, clips),
            "\"golem\" has no clips; it plays Idle and Walk of the built-in people, retargeted"
        );
        assert_eq!(
            words(&["man-001", "man-003"], &played, ClipChoice::Scene),
            "2 characters, such as \"man-001\", have no clips; they play those of the built-in \
             people, retargeted"
        );
        assert!(words(&["rock"], &[], clips).starts_with("warning: \"rock\" has no clips"));
    }
}
