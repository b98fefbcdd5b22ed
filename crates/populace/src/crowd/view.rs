//! The view that a crowd is evaluated for: which members are hidden, and their levels of detail.

use populace_device::{View, Visibility};
use populace_model::convert::u32_from;

use super::base::{CharacterState, MemberState, Reach, Seen};
use super::state::State;
use super::{CharacterId, Crowd};
use crate::{Allowed, Error};

/// A member changes to a coarser level only where that one is finer than needed by this factor, so
/// that it does not change back and forth.
const HYSTERESIS: f32 = 0.85;
/// The largest error of a view, in pixels.
const LARGEST_ERROR_PX: f32 = 1e6;

impl Crowd {
    /// Sets the view that the next updates are evaluated for; `None` evaluates all members, in full
    /// detail, as from the beginning.
    ///
    /// Each member gets the coarsest level of its character's [`levels`] of which the error is less
    /// than [`View::error_px`], and is [hidden](Visibility::Hidden) if it cannot be seen. Hidden
    /// members keep their time, their placement and what they play, but are not posed: their
    /// palettes stay as they were. Members with root motion, and those that are watched or carry
    /// others, are posed all the same. Members with overrides, proportions, user stages or live
    /// clips, and attached ones, are never hidden.
    ///
    /// Levels depend on those of the update before: a level changes to a coarser one a little later
    /// than to a finer one. They are part of a [snapshot](Self::snapshot).
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] for a view with a number that is not finite, or an error in pixels below
    /// 0.
    ///
    /// [`levels`]: populace_character::Character::levels
    pub fn set_view(&mut self, view: Option<View>) -> Result<(), Error> {
        if let Some(view) = &view {
            check(view)?;
        }
        self.state.base.view = view;
        Ok(())
    }

    /// The view that updates are evaluated for.
    #[must_use]
    pub fn view(&self) -> Option<&View> {
        self.state.base.view.as_ref()
    }

    /// Counts the members by what the last update chose for them.
    #[must_use]
    pub fn view_statistics(&self) -> ViewStatistics {
        let mut counts = ViewStatistics::default();
        let members = self.state.base.members.all.iter().filter(|m| m.character.is_some());
        for Seen { visibility, level } in members.map(|member| member.seen) {
            match visibility {
                Visibility::InView => {
                    let level = level as usize;
                    counts.levels.resize(counts.levels.len().max(level + 1), 0);
                    counts.levels[level] += 1;
                }
                Visibility::ShadowOnly => counts.shadow_only += 1,
                Visibility::Hidden => counts.hidden += 1,
            }
        }
        counts
    }
}

fn check(view: &View) -> Result<(), Error> {
    let View { eye, planes, pixels_per_metre, to_sun, error_px } = view;
    let numbers = eye.iter().chain(planes.as_flattened()).chain(to_sun.iter().flatten());
    let allowed = Allowed::Finite;
    for value in numbers.chain([pixels_per_metre]) {
        if !value.is_finite() {
            return Err(Error::BadValue { what: "a number of the view", value: *value, allowed });
        }
    }
    if !(0.0..=LARGEST_ERROR_PX).contains(error_px) {
        let allowed = Allowed::Range { least: 0.0, most: LARGEST_ERROR_PX.into() };
        return Err(Error::BadValue { what: "the error of the view", value: *error_px, allowed });
    }
    Ok(())
}

/// Numbers of members by what was chosen for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ViewStatistics {
    /// Members in view by their level of detail, from level 0 on.
    pub levels: Vec<usize>,
    /// Members out of view that may throw a shadow into it.
    pub shadow_only: usize,
    /// Members that cannot be seen.
    pub hidden: usize,
}

impl State {
    /// Chooses visibility, level and joints of every member for the present view.
    pub(super) fn apply_view(&mut self) {
        let was_viewed = std::mem::replace(&mut self.base.is_viewed, self.base.view.is_some());
        if !(was_viewed || self.base.is_viewed) {
            return;
        }
        for index in 0..self.base.members.all.len() {
            let MemberState { character: Some(character), seen: before, .. } =
                self.base.members.all[index]
            else {
                continue;
            };
            let Ok(state) = self.base.character_state(character) else { continue };
            let next = match &self.base.view {
                Some(view) => self.seen_in(view, index, state, before),
                None => Seen::default(),
            };
            let reduced = state.reduced_of_level.get(next.level as usize).copied();
            if next == before && next == Seen::default() {
                continue;
            }
            let (tables, number) = (&mut self.base.tables, u32_from(index));
            let hidden = next.visibility == Visibility::Hidden && tables.can_hide(number);
            tables.set_hidden(number, hidden);
            tables.set_reduced(number, reduced.unwrap_or_default());
            self.base.members.all[index].seen = next;
        }
    }

    /// Returns centre and radius of the sphere around a member's poses.
    pub(super) fn sphere_of(&self, index: usize, character: CharacterId) -> ([f32; 3], f32) {
        let reach = self.base.character_state(character).map(|c| c.reach).unwrap_or_default();
        self.sphere_of_reach(index, reach)
    }

    fn sphere_of_reach(&self, index: usize, reach: Reach) -> ([f32; 3], f32) {
        let placement = &self.base.members.all[index].placement;
        let (scale, [x, y, z]) = (placement.scale(), placement.position());
        let [mx, my, mz] = self.offset_of(u32_from(index));
        ([x + mx, y + my + scale * reach.height_m, z + mz], scale * reach.radius_m)
    }

    fn seen_in(&self, view: &View, index: usize, state: &CharacterState, before: Seen) -> Seen {
        let (center, radius) = self.sphere_of_reach(index, state.reach);
        let scale = self.base.members.all[index].placement.scale();
        let visibility = match view.visibility(center, radius) {
            beyond
                if beyond != Visibility::InView
                    && !self.base.tables.is_bounded(u32_from(index)) =>
            {
                Visibility::InView
            }
            found => found,
        };
        let px = view.pixels_per_metre_at(center, radius) * scale;
        let levels = state.character.levels();
        let fits = |level: u32, error_px: f32| match level.checked_sub(1) {
            None => true,
            Some(coarser) => {
                levels.get(coarser as usize).is_some_and(|l| l.error_m * px <= error_px)
            }
        };
        let mut level = before.level;
        while !fits(level, view.error_px) {
            level -= 1;
        }
        while fits(level + 1, HYSTERESIS * view.error_px) {
            level += 1;
        }
        Seen { visibility, level }
    }
}
