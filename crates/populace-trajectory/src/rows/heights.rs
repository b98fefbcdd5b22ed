//! Body heights of agents, and a warning of those that no body has.

use std::ops::RangeInclusive;

use super::Rows;
use crate::fields::shortened;
use crate::recording::Kind;

/// Body heights in metres; other values are no heights.
const BODY_HEIGHTS_M: RangeInclusive<f32> = 0.5..=2.6;

impl Rows {
    /// Gives agents their heights, where a body can have them. Warns of others, except 0, which
    /// stands for an unknown height. Agents must have their rows.
    pub(super) fn heights_in_metres(&mut self, metres: f32) {
        let mut strange = Vec::new();
        for (index, agent) in self.agents.iter_mut().enumerate() {
            let in_unit = self.heights.get(index).map(|height| height * metres);
            let heights_m = [agent.height_m, in_unit].into_iter().flatten();
            agent.height_m = heights_m.clone().find(|m| BODY_HEIGHTS_M.contains(m));
            let is_person = agent.kind == Kind::Person && !agent.rows.is_empty();
            if agent.height_m.is_none() && is_person {
                let mut said = heights_m.filter(|m| m.is_finite() && *m != 0.0);
                strange.extend(said.next().map(|m| (m, agent.id.as_str())));
            }
        }
        if let Some(warning) = warning_of(&strange) {
            self.warnings.whole(warning);
        }
    }
}

/// Returns a warning of heights in metres that no body has, with the ids of their agents.
fn warning_of(strange: &[(f32, &str)]) -> Option<String> {
    let (height_m, id) = strange.first()?;
    let agents = match strange.len() {
        1 => "1 agent has".to_owned(),
        count => format!("{count} agents have"),
    };
    let [least, most] = [BODY_HEIGHTS_M.start(), BODY_HEIGHTS_M.end()];
    let centimetres = strange.iter().filter(|(m, _)| BODY_HEIGHTS_M.contains(&(m / 100.0)));
    let hint = if 2 * centimetres.count() > strange.len() {
        "; most look like centimetres, which a name such as height_cm says"
    } else {
        ""
    };
    Some(format!(
        "{agents} a body height outside {least} to {most} m, which was left out, such as \
         {height_m:.2} m of agent \"{}\"{hint}",
        shortened(id)
    ))
}
