//! The view that a crowd is evaluated for: which members are hidden, and their levels of detail.

use populace_device::{Culling, Tables, View, Visibility};
use populace_model::convert::u32_from;
use populace_settings::parts::{Key, Parts as _};
use rayon::prelude::*;

use super::attach::Attachments;
use super::base::{Assets, Base, CharacterState, MemberState, Reach, Seen};
use super::motion::RootMotion;
use super::state::{State, offset};
use super::{CharacterId, Crowd, MemberId};
use crate::{Allowed, Error, Placement};

/// A member changes to a coarser level only where that one is finer than needed by this factor, so
/// that it does not change back and forth.
const HYSTERESIS: f32 = 0.85;
/// Members that a thread chooses for at a time.
const SHARE: usize = 2048;
/// The most pixels that a metre may cover at a distance of one metre.
const LARGEST_PX_PER_METRE: f32 = 1e12;
/// The largest error of a view, in pixels.
const LARGEST_ERROR_PX: f32 = 1e6;

impl Crowd {
    /// Sets the view that the next updates are evaluated for; `None` evaluates all members, in full
    /// detail, as from the beginning.
    ///
    /// Each member gets the coarsest level of its character's [`levels`] of which the error is less
    /// than [`View::error_px`], and is [hidden](Visibility::Hidden) if it cannot be seen. Hidden
    /// members keep their time, their placement, their level and what they play, but are not posed:
    /// their palettes and joints cannot be read. Members with root motion, and those that are
    /// watched or carry others, are posed and change their level all the same. Members with
    /// overrides, proportions, user stages or live clips, and attached ones, are never hidden.
    ///
    /// The choice for a member with root motion goes by where the update before has moved it: it
    /// comes into view one update late. With such members, an update with a view waits for the one
    /// before.
    ///
    /// Levels depend on those of the update before: a level changes to a coarser one a little later
    /// than to a finer one. They are part of a [snapshot](Self::snapshot).
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] for a view with a number that is not finite, pixels per metre that are
    /// not above 0 and at most 1e12, or an error in pixels that is not from 0 to 1e6.
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
        self.view_statistics_of(|_| true)
    }

    /// Counts those members for which `is_counted` returns true, as
    /// [`view_statistics`](Self::view_statistics) counts all.
    #[must_use]
    pub fn view_statistics_of(&self, is_counted: impl Fn(MemberId) -> bool) -> ViewStatistics {
        let mut counts = ViewStatistics::default();
        let counted = self.members().map(|member| member.id()).filter(|id| is_counted(*id));
        let members = counted.map(|id| &self.state.base.members.all[id.number() as usize]);
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
    for value in numbers {
        if !value.is_finite() {
            return Err(Error::BadValue { what: "a number of the view", value: *value, allowed });
        }
    }
    if !(*pixels_per_metre > 0.0 && *pixels_per_metre <= LARGEST_PX_PER_METRE) {
        let (what, value) = ("the pixels per metre of the view", *pixels_per_metre);
        let allowed = Allowed::AboveZero { most: LARGEST_PX_PER_METRE };
        return Err(Error::BadValue { what, value, allowed });
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
    /// Chooses visibility, level and joints of every member for the present view, on all threads.
    pub(super) fn apply_view(&mut self) {
        let was_viewed = std::mem::replace(&mut self.base.is_viewed, self.base.view.is_some());
        if !(was_viewed || self.base.is_viewed) {
            return;
        }
        let Self { base, motion, attachments, .. } = self;
        let Base { tables, assets, members, view, .. } = base;
        let view = view.as_ref().map(|view| (view, view.culling()));
        let choice = Choice { view, tables, assets, motion, attachments };
        let shares = members.all.par_chunks_mut(SHARE).enumerate();
        let changes: Vec<Vec<_>> = shares
            .map(|(share, members)| {
                let members = (u32_from(share * SHARE)..).zip(members);
                members.filter_map(|(index, member)| choice.update(index, member)).collect()
            })
            .collect();
        for Change { member, is_hidden, reduced } in changes.into_iter().flatten() {
            tables.set_hidden(member, is_hidden);
            tables.set_reduced(member, reduced);
        }
    }

    /// Returns centre and radius of the sphere around a member's poses.
    pub(super) fn sphere_of(&self, index: usize, character: CharacterId) -> ([f32; 3], f32) {
        let reach = self.base.character_state(character).map(|c| c.reach).unwrap_or_default();
        let offset = self.offset_of(u32_from(index));
        sphere(&self.base.members.all[index].placement, offset, reach)
    }
}

fn sphere(placement: &Placement, [mx, my, mz]: [f32; 3], reach: Reach) -> ([f32; 3], f32) {
    let (scale, [x, y, z]) = (placement.scale(), placement.position());
    ([x + mx, y + my + scale * reach.height_m, z + mz], scale * reach.radius_m)
}

impl Assets {
    /// Returns the character of a member; `None` for an index that is free.
    fn character(&self, member: &MemberState) -> Option<&CharacterState> {
        let Key { index, generation, .. } = member.character?.parts();
        self.characters.get((index, generation))
    }
}

/// What the choice for a member depends on, besides its state.
struct Choice<'a> {
    view: Option<(&'a View, Culling)>,
    tables: &'a Tables,
    assets: &'a Assets,
    motion: &'a RootMotion,
    attachments: &'a Attachments,
}

/// A change of a member's row in the tables.
struct Change {
    /// Index of the member.
    member: u32,
    is_hidden: bool,
    /// The reduced body, as for [`Tables::set_reduced`].
    reduced: u32,
}

impl Choice<'_> {
    /// Chooses a member's visibility and level, and returns the change of the tables, if any.
    fn update(&self, index: u32, member: &mut MemberState) -> Option<Change> {
        let state = self.assets.character(member)?;
        let (mut now, mut is_hidden) = (Seen::default(), false);
        if let Some((view, culling)) = &self.view {
            let offset = offset(self.motion, self.attachments, index);
            let (center, radius) = sphere(&member.placement, offset, state.reach);
            let visibility = match culling.visibility(center, radius) {
                Visibility::InView => Visibility::InView,
                beyond if self.tables.is_bounded(index) => beyond,
                _ => Visibility::InView,
            };
            is_hidden = visibility == Visibility::Hidden && self.tables.can_hide(index);
            now = Seen { visibility, ..member.seen };
            // Members that are not posed keep their level.
            if !is_hidden {
                let px = view.pixels_per_metre_at(center, radius) * member.placement.scale();
                now.level = level(state, member.seen.level, px, view.error_px);
            }
        }
        // Few change, and what is not written does not go back to memory.
        if member.seen != now {
            member.seen = now;
        }
        let reduced = state.reduced_of_level.get(now.level as usize).copied().unwrap_or_default();
        let is_same = self.tables.is_evaluated_as(index, is_hidden, reduced);
        (!is_same).then_some(Change { member: index, is_hidden, reduced })
    }
}

/// Returns the level of a member that had a level before, of which a metre covers `px` pixels.
fn level(state: &CharacterState, before: u32, px: f32, error_px: f32) -> u32 {
    let levels = state.character.levels();
    let fits = |level: u32, error_px: f32| match level.checked_sub(1) {
        None => true,
        Some(coarser) => levels.get(coarser as usize).is_some_and(|l| l.error_m * px <= error_px),
    };
    let mut level = before;
    while !fits(level, error_px) {
        level -= 1;
    }
    while fits(level + 1, HYSTERESIS * error_px) {
        level += 1;
    }
    level
}
