//! The people of a scene: the characters of its casts, and how they look.

use std::collections::BTreeMap;
use std::path::PathBuf;

use populace::character::Region;
use populace::{Crowd, MemberId};
use populace_locomotion::GaitSpace;
use populace_scene::Person;
use populace_scene::plan::{BehaviourPlan, CastPlan, CrowdPlan, ScenePlan};

use super::SceneSource;
use crate::built_in::Clothes;
use crate::failure::Failure;
use crate::levels::Levels;
use crate::people::{appearances, gaits};
use crate::roles::{self, ClipChoice, CrowdRole};

/// Number of characters that an error names, at most.
const NAMED: usize = 3;

/// The roles of each cast, by its name.
pub(super) type Casts = BTreeMap<String, Vec<CrowdRole>>;

/// The characters of the members of a crowd of the plan.
pub(super) struct Players<'a> {
    cast: &'a CastPlan,
    /// Indices among the roles of the cast.
    chosen: Vec<usize>,
    /// The seed of how they look; `None` if they look like their characters.
    seed: Option<u64>,
}

/// Loads the characters of all casts, and names the files that they refer to.
pub(super) fn casts(
    crowd: &mut Crowd,
    source: &SceneSource<'_>,
) -> Result<(Casts, Vec<PathBuf>), Failure> {
    let args = source.picture;
    let (mut casts, mut files) = (Casts::new(), Vec::new());
    for cast in &source.plan.casts {
        let clips = cast.clips_from.iter().map(|file| source.path(file));
        let clips: Vec<_> = clips.chain(args.clips.iter().cloned()).collect();
        let clothes = Clothes {
            options: cast.varied && !args.plain,
            no_hats: cast.holds.iter().any(|thing| thing == "helmet"),
            top: cast.top,
            ..Clothes::default()
        };
        let loaded = roles::load(
            crowd,
            &args.input,
            &source.inputs(cast),
            &clips,
            ClipChoice::Scene,
            args.height.or(cast.height_m),
            Levels::wanted(args),
            clothes,
        )?;
        files.extend(loaded.files);
        casts.insert(cast.name.clone(), loaded.roles);
    }
    Ok((casts, files))
}

/// Returns the gaits of all characters that have some. Refuses a character that has to walk and
/// cannot.
pub(super) fn walks(
    crowd: &mut Crowd,
    plan: &ScenePlan,
    casts: &Casts,
) -> Result<Vec<GaitSpace>, Failure> {
    let mut all = Vec::new();
    for (cast, roles) in casts {
        let mut refused: Vec<(&str, anyhow::Error)> = Vec::new();
        for (nth, gaits) in gaits(crowd, roles, "`clips_from`")?.into_iter().enumerate() {
            match (gaits, walk_of(plan, cast, nth)) {
                (Ok(gaits), _) => all.push(gaits),
                (Err(reason), Some(does)) => refused.push((does, reason)),
                (Err(_), None) => {}
            }
        }
        if let [(does, _), ..] = refused[..] {
            let more = refused.len().saturating_sub(NAMED);
            let more =
                if more > 0 { format!("; {more} more cannot either") } else { String::new() };
            let reasons = refused.iter().take(NAMED).map(|(_, reason)| reason.to_string());
            let reasons = reasons.collect::<Vec<_>>().join("; ");
            return Err(Failure::Input(anyhow::anyhow!(
                "the cast \"{cast}\" has people who cannot walk, and a [[crowd]] of it does \
                 `{does}`: {reasons}{more}"
            )));
        }
    }
    Ok(all)
}

/// Returns how a character of a cast has to walk, by its number; `None` if it does not.
fn walk_of(plan: &ScenePlan, cast: &str, nth: usize) -> Option<&'static str> {
    // Members are the characters of their cast in turn.
    let mut of = plan.crowds.iter().filter(|crowd| crowd.cast == cast && nth < crowd.count);
    of.find_map(|crowd| match crowd.does {
        BehaviourPlan::Stroll(_) => Some("stroll"),
        BehaviourPlan::Fight(_) => Some("fight"),
        _ => None,
    })
}

/// Chooses who plays the members of each crowd of the plan: the characters of its cast in turn.
pub(super) fn players<'a>(source: &'a SceneSource<'_>, casts: &Casts) -> Vec<Players<'a>> {
    let plan = &source.plan;
    let of = |(nth, crowd): (usize, &CrowdPlan)| {
        let cast = plan.casts.iter().find(|cast| cast.name == crowd.cast)?;
        let roles = casts.get(&cast.name)?.len().max(1);
        let seed = plan.seed.wrapping_add(source.picture.seed).wrapping_add(nth as u64);
        let varied = cast.varied && !source.picture.plain;
        let chosen = (0..crowd.count).map(|member| member % roles).collect();
        Some(Players { cast, chosen, seed: varied.then_some(seed) })
    };
    plan.crowds.iter().enumerate().filter_map(of).collect()
}

impl Players<'_> {
    /// Returns the bodies of members. Their looks follow once it is known who is near whom.
    pub(super) fn people(&self, casts: &Casts) -> Vec<Person> {
        let roles = &casts[&self.cast.name];
        // Heights depend on the seed alone.
        let places: Vec<[f32; 3]> =
            (0..self.chosen.len()).map(|nth| [0.0, 0.0, nth as f32]).collect();
        let appearances = appearances(roles, &self.chosen, &places, self.seed);
        let person = |(member, role): (usize, &usize)| Person {
            character: roles[*role].id,
            scale: roles[*role].scale * appearances.get(member).map_or(1.0, |of| of.height),
            look: None,
        };
        self.chosen.iter().enumerate().map(person).collect()
    }
}

/// Gives members looks that differ from those around them.
pub(super) fn dress(
    crowd: &mut Crowd,
    players: &[Players<'_>],
    casts: &Casts,
    people: &[MemberId],
) -> Result<(), Failure> {
    let mut from = 0;
    for of in players {
        let members = &people[from..from + of.chosen.len()];
        from += of.chosen.len();
        let places = members
            .iter()
            .map(|member| Ok(crowd.member(*member)?.placement().position()))
            .collect::<Result<Vec<_>, populace::Error>>()?;
        let roles = &casts[&of.cast.name];
        let looks = appearances(roles, &of.chosen, &places, of.seed);
        for (nth, member) in members.iter().enumerate() {
            let mut member = crowd.member_mut(*member)?;
            let mut look = looks.get(nth).map_or_else(|| member.look(), |of| of.look);
            if let Some(color) = of.cast.top {
                // The clothes of built-in people have the colour.
                let is_built_in = roles[of.chosen[nth]].is_built_in;
                look = look.tinted(Region::Top, if is_built_in { [1.0; 3] } else { color });
            }
            member.set_look(look);
        }
    }
    Ok(())
}
