//! Checks that the clips that a scene names are there, with their lines.

use populace::Crowd;
use populace_scene::SceneFileError;
use populace_scene::plan::{BehaviourPlan, CastPlan, CrowdPlan, ScenePlan};

use super::SceneSource;
use crate::built_in;
use crate::failure::Failure;
use crate::names::hint;
use crate::roles::CrowdRole;
use crate::text_file;

/// A clip that a scene names.
struct Named<'a> {
    of: &'a CrowdPlan,
    /// The number of the [[crowd]].
    crowd: usize,
    /// The number of the layer that plays it.
    layer: Option<usize>,
    clip: &'a str,
}

/// Refuses a clip of a [[crowd]] that a character of its cast lacks. `roles` returns the
/// characters of a cast.
pub(super) fn check<'a>(
    crowd: &Crowd,
    source: &SceneSource<'_>,
    roles: impl Fn(&str) -> &'a [CrowdRole],
) -> Result<(), Failure> {
    for named in named(&source.plan) {
        let mut casts = source.plan.casts.iter();
        let Some(cast) = casts.find(|cast| cast.name == named.of.cast) else { continue };
        // Members are the characters of their cast in turn.
        for role in roles(&cast.name).iter().take(named.of.count) {
            if crowd.clip(role.id, named.clip).is_err() {
                let reason = missing(crowd, role, cast, named.clip)?;
                return Err(source.at_clip(&named, &reason));
            }
        }
    }
    Ok(())
}

/// Returns the clips that a plan names.
fn named(plan: &ScenePlan) -> impl Iterator<Item = Named<'_>> {
    plan.crowds.iter().enumerate().flat_map(|(crowd, of)| {
        let stand = match &of.does {
            BehaviourPlan::Stand(stand) => Some(stand.clip.as_str()),
            _ => None,
        };
        let layers = of.layers.iter().enumerate().filter(|(_, layer)| layer.share > 0.0);
        let layers = layers.map(|(nth, layer)| (Some(nth), layer.clip.as_str()));
        let all = stand.map(|clip| (None, clip)).into_iter().chain(layers);
        all.map(move |(layer, clip)| Named { of, crowd, layer, clip })
    })
}

/// Returns why a character cannot play a clip, with where there is one.
fn missing(
    crowd: &Crowd,
    role: &CrowdRole,
    cast: &CastPlan,
    name: &str,
) -> Result<String, Failure> {
    let own = crowd.character(role.id)?.clips();
    let of_people = built_in::clips("people")?;
    let lent = of_people.iter().any(|clip| clip.name() == name);
    let is_humanoid = crowd.character(role.id)?.roles().is_some();
    let has_people = cast.clips_from.iter().any(|from| from == "@people");
    let cure = if lent && is_humanoid && !has_people {
        "; write `clips_from = [\"@people\"]` into its [[cast]] for that of the built-in people"
            .to_owned()
    } else {
        hint(name, own.iter().map(|(_, clip)| clip.name()))
    };
    Ok(format!("\"{}\" has no clip \"{name}\"{cure}", role.character.name))
}

impl SceneSource<'_> {
    /// Names the line of a clip in an error about it.
    fn at_clip(&self, named: &Named<'_>, reason: &str) -> Failure {
        let Some(file) = self.file else { return Failure::Input(anyhow::anyhow!("{reason}")) };
        let text = text_file::read(file).unwrap_or_default();
        let error = SceneFileError::of_clip(&text, (named.crowd, named.layer), reason);
        Failure::Input(anyhow::anyhow!("{error}"))
    }
}
