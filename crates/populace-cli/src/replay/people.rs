//! The people who play the agents of a recording.

use populace::character::Character;
use populace_random::{Rng, mixed_text};
use populace_scene::{Motion, Motions, Person};
use populace_trajectory::{Agent, Kind, Recording, counts_present};
use populace_variety::Variety;

use crate::roles::CrowdRole;

/// Fewest agents of whom equal heights are an assumption of the file, and not measured.
const ASSUMED_FROM: usize = 3;
/// Characters that are within this part of an agent's height may play it.
const FITS: f32 = 0.1;

/// Settings of a cast.
pub(crate) struct CastSettings {
    pub(crate) seed: u64,
    /// True if all people of a character look like it.
    pub(crate) plain: bool,
    /// Height of everybody in metres, if it was asked for.
    pub(crate) height_m: Option<f32>,
}

/// Returns a person for each agent. Its character and look depend on the seed and the agent's id
/// alone, so that an id is the same person in all films of a simulation and its variants.
pub(crate) fn cast(
    recording: &Recording,
    roles: &[CrowdRole],
    settings: &CastSettings,
) -> Vec<Person> {
    let heights: Vec<Option<f32>> = heights(recording, settings.height_m);
    let keys = recording.agents.iter().map(|agent| mixed_text(&agent.id));
    let role = |(key, height): (u64, &Option<f32>)| {
        (role_of_height(roles, *height, &mut Rng::stream(settings.seed, key)), key)
    };
    let chosen: Vec<(usize, u64)> = keys.zip(&heights).map(role).collect();
    let characters: Vec<&Character> = roles.iter().map(|role| &*role.character).collect();
    let variety = Variety { seed: settings.seed, ..Variety::default() };
    let of_keys = || variety.appearances_by_key(&characters, &chosen);
    let appearances = if settings.plain { Vec::new() } else { of_keys() };
    let person = |(agent, (role, _)): (usize, &(usize, u64))| {
        let role = &roles[*role];
        let appearance = appearances.get(agent);
        let scale = match heights[agent] {
            Some(height_m) => height_m / role.character.height_m().max(1e-3),
            None => role.scale * appearance.map_or(1.0, |appearance| appearance.height),
        };
        Person { character: role.id, scale, look: appearance.map(|appearance| appearance.look) }
    };
    chosen.iter().enumerate().map(person).collect()
}

/// Returns the heights of bodies in metres.
pub(crate) fn body_heights(people: &[Person], roles: &[CrowdRole]) -> Vec<f32> {
    let height = |person: &Person| {
        let role = roles.iter().find(|role| role.id == person.character);
        role.map_or(0.0, |role| person.scale * role.character.height_m())
    };
    people.iter().map(height).collect()
}

/// Returns the heights of agents in metres, where they are known.
fn heights(recording: &Recording, asked_m: Option<f32>) -> Vec<Option<f32>> {
    let of = |agent: &Agent| agent.height_m.filter(|_| agent.kind == Kind::Person);
    let known: Vec<f32> = recording.agents.iter().filter_map(of).collect();
    let differ = known.windows(2).any(|pair| pair[0] != pair[1]);
    let measured = differ || known.len() < ASSUMED_FROM;
    let height = |agent| asked_m.or_else(|| of(agent).filter(|_| measured));
    recording.agents.iter().map(height).collect()
}

/// Returns a role at random among those whose height is near that of an agent; the nearest one if
/// there is none.
fn role_of_height(roles: &[CrowdRole], height_m: Option<f32>, random: &mut Rng) -> usize {
    let Some(height_m) = height_m else { return random.below(roles.len()) };
    let off = |role: &CrowdRole| (role.character.height_m() * role.scale / height_m - 1.0).abs();
    let fitting: Vec<usize> = (0..roles.len()).filter(|nth| off(&roles[*nth]) < FITS).collect();
    if fitting.is_empty() {
        let order = |a: &usize, b: &usize| off(&roles[*a]).total_cmp(&off(&roles[*b]));
        return (0..roles.len()).min_by(order).unwrap_or(0);
    }
    fitting[random.below(fitting.len())]
}

/// Returns the middle of the longest time in which most agents are there, in seconds; `None` if
/// nobody ever is.
pub(super) fn busiest(motions: &Motions) -> Option<f64> {
    let counts = counts_present(motions.agents.iter().flat_map(Motion::secs));
    let most = counts.iter().map(|(_, count)| *count).max()?;
    let busy = counts.windows(2).filter(|pair| pair[0].1 == most);
    let longest = busy.max_by(|a, b| (a[1].0 - a[0].0).total_cmp(&(b[1].0 - b[0].0)));
    longest.map(|pair| f64::midpoint(pair[0].0, pair[1].0))
}

/// Returns a warning if nobody is there from the first time to the last, in seconds since `start`,
/// with the nearest times before and after at which somebody is.
pub(super) fn absence(motions: &Motions, start: f64, [first, last]: [f64; 2]) -> Option<String> {
    let spans = motions.agents.iter().flat_map(Motion::secs);
    let (mut before, mut after) = (None, None);
    for [from, until] in spans.map(|span| span.map(|secs| secs - start)) {
        if from <= last && until + Motion::PAST_SECS >= first {
            return None;
        } else if until < first {
            before = Some(until.max(before.unwrap_or(until)));
        } else {
            after = Some(from.min(after.unwrap_or(from)));
        }
    }
    let when = if first == last {
        format!("at {first:.2} s")
    } else {
        format!("from {first:.2} to {last:.2} s")
    };
    // Rounded into the time in which somebody is there.
    let before = before.map(|secs| format!("until {:.2} s", (secs * 100.0).floor() / 100.0));
    let after = after.map(|secs| format!("from {:.2} s on", (secs * 100.0).ceil() / 100.0));
    let nearest: Vec<_> = before.into_iter().chain(after).collect();
    Some(match nearest.join(", and ") {
        nearest if nearest.is_empty() => format!("nobody is there {when}, nor at any other time"),
        nearest => format!("nobody is there {when}; somebody is there {nearest}"),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::path::Path;
    use std::sync::Arc;

    use populace::{Crowd, Device};
    use populace_trajectory::{ReadSettings, parse};

    use super::*;
    use crate::built_in;

    fn recording(rows: String) -> Recording {
        parse(Path::new("a.csv"), rows.into(), &ReadSettings::default()).expect("a recording")
    }

    #[test]
    fn an_id_is_the_same_person_in_any_order_and_company() {
        let mut crowd = Crowd::builder().device(Device::Native { threads: 1 }).build().unwrap();
        let characters = built_in::people("people").unwrap();
        let role = |character: Arc<Character>| CrowdRole {
            id: crowd.add_character(character.clone()).unwrap(),
            character,
            clips: Vec::new(),
            scale: 1.0,
            is_built_in: true,
            is_clipless: false,
        };
        let roles: Vec<_> = characters.into_iter().map(role).collect();
        let people = |ids: &[usize], seed| {
            let row = |id: &usize| format!("p{id},0,{id},0\np{id},1,{id},1\n");
            let recording =
                recording("id,t,x,y\n".to_owned() + &ids.iter().map(row).collect::<String>());
            let settings = CastSettings { seed, plain: false, height_m: None };
            cast(&recording, &roles, &settings)
        };
        let all: Vec<usize> = (0..40).collect();
        let others: Vec<usize> = (10..60).rev().collect();
        let [found, with_others] = [&all, &others].map(|ids| people(ids, 0));
        let facts = |of: &Person| (of.character, of.scale, of.look);
        for (person, other) in found[10..].iter().zip(with_others[20..].iter().rev()) {
            assert_eq!(facts(person), facts(other));
        }
        let of_seed = people(&all, 1);
        assert!(found.iter().zip(&of_seed).any(|(a, b)| a.character != b.character));
        let kinds: HashSet<_> = found.iter().map(|person| person.character).collect();
        assert!(kinds.len() > 4, "{kinds:?}");
    }

    #[test]
    fn times_without_people_name_the_nearest_ones_with_people() {
        let mut rows = "id,t,x,y\n".to_owned();
        for tenth in (10..31).chain(90..111) {
            rows += &format!("{},{},{},0\n", tenth / 50, f64::from(tenth) / 10.0, tenth);
        }
        let motions = Motions::new(&recording(rows));
        let of = |first, last| absence(&motions, 1.0, [first, last]);
        let gap = "nobody is there at 5.00 s; somebody is there until 2.00 s, and from 8.00 s on";
        assert_eq!(of(5.0, 5.0).as_deref(), Some(gap));
        let end = "nobody is there at 50.00 s; somebody is there until 10.00 s";
        assert_eq!(of(50.0, 50.0).as_deref(), Some(end));
        let film = of(3.0, 4.0).expect("a warning");
        assert!(film.starts_with("nobody is there from 3.00 to 4.00 s; "), "{film}");
        for [first, last] in [[0.0, 0.0], [2.0, 2.0], [8.0, 8.0], [10.0, 10.0], [3.0, 9.0]] {
            assert_eq!(of(first, last), None, "{first} to {last}");
        }
    }
}
