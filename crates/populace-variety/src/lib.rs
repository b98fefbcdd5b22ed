//! Members of a crowd that differ: tints by region, options such as hair cuts and hats, height and
//! pace. Works for any character; see [`Region`] for what can be told
//! apart on it.
//!
//! People find clones by heads and upper bodies (R. McDonnell, M. Larkin, B. Hernández, I. Rudomin
//! and C. O'Sullivan, "Eye-catching crowds: saliency based selective variation", ACM Transactions
//! on Graphics 28(3), 2009), so these two differ first between neighbours.
//!
//! ```
//! use populace_variety::{Variety, clones};
//!
//! let people = populace_cast::cast()?;
//! let characters: Vec<_> = people.iter().collect();
//! let members: Vec<_> = (0..50).map(|i| (i % people.len(), [i as f32, 0.0, 0.0])).collect();
//! let appearances = Variety { seed: 7, ..Variety::default() }.appearances(&characters, &members);
//! assert_eq!(appearances.len(), 50);
//! assert_eq!(clones(&members, &appearances), 0);
//! # Ok::<(), populace_character::Error>(())
//! ```

mod neighbours;
mod paint;
mod palettes;
mod wardrobe;

use populace_character::{Character, Region};
use populace_device::MemberLook;
use populace_model::convert::single;

use crate::neighbours::nearest;
use crate::wardrobe::Wardrobe;

pub use crate::paint::Dye;

/// Neighbours from which a member differs.
pub const NEIGHBOURS: usize = 20;
/// Looks that are tried for a member. The one least like its neighbours' is taken.
const TRIES: usize = 8;

/// A description of how members differ. Equal descriptions give equal members.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variety {
    /// Number that decides everything.
    pub seed: u64,
    /// Standard deviation of heights, as a fraction from 0 to 0.3. Heights stay within two and a
    /// half of them. A number beyond the range counts as the nearest one, and NaN as 0.
    pub height: f32,
    /// Largest deviation of paces, as a fraction from 0 to 0.9. A number beyond the range counts as
    /// the nearest one, and NaN as 0.
    pub pace: f32,
    /// Share of members, from 0 to 1, that wear an option of each group but hair.
    pub worn: f32,
}

impl Default for Variety {
    fn default() -> Self {
        Self { seed: 0, height: 0.025, pace: 0.06, worn: 0.3 }
    }
}

/// How one member differs from its character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Appearance {
    /// Tints, and options that are not shown.
    pub look: MemberLook,
    /// Factor of the height.
    pub height: f32,
    /// Factor of the speed at which clips play.
    pub pace: f32,
}

impl Variety {
    /// Returns the appearance of each member, given as the number of its character in `characters`
    /// and its position in metres. Members of numbers out of range look as their characters do.
    #[must_use]
    pub fn appearances(
        &self,
        characters: &[&Character],
        members: &[(usize, [f32; 3])],
    ) -> Vec<Appearance> {
        let wardrobes: Vec<_> = characters.iter().map(|c| Wardrobe::of(c)).collect();
        let near = nearest(members, NEIGHBOURS);
        let mut all: Vec<Option<Appearance>> = vec![None; members.len()];
        // Makes the relation mutual: a member is compared with all that list it as near.
        let mut nearby = near.clone();
        for (member, others) in near.iter().enumerate() {
            others.iter().for_each(|other| nearby[*other].push(member));
        }
        for (member, (character, _)) in members.iter().enumerate() {
            let mut random = self.random(member as u64);
            let decided = nearby[member].iter().filter_map(|other| {
                (members[*other].0 == *character).then_some(all[*other].as_ref()?.look)
            });
            let decided: Vec<MemberLook> = decided.collect();
            let likeness = |look: &MemberLook| -> usize {
                decided.iter().map(|other| likeness(look, other)).sum()
            };
            let tried = wardrobes.get(*character).into_iter().flat_map(|wardrobe| {
                (0..TRIES).map(|_| wardrobe.look(&mut random, self.worn)).collect::<Vec<_>>()
            });
            let look = tried.min_by_key(|look| likeness(look)).unwrap_or_default();
            all[member] = Some(self.appearance(look, &mut random));
        }
        all.into_iter().flatten().collect()
    }

    /// Returns the appearance of each member, given as the number of its character in `characters`
    /// and a key. The looks of a member depend on the seed, its character and its key alone.
    /// Neighbours can look alike. Members of numbers out of range look as their characters do.
    #[must_use]
    pub fn appearances_by_key(
        &self,
        characters: &[&Character],
        members: &[(usize, u64)],
    ) -> Vec<Appearance> {
        let wardrobes: Vec<_> = characters.iter().map(|c| Wardrobe::of(c)).collect();
        let appearance = |(character, key): &(usize, u64)| {
            let mut random = self.random(*key);
            let wardrobe = wardrobes.get(*character);
            let look = wardrobe.map(|wardrobe| wardrobe.look(&mut random, self.worn));
            self.appearance(look.unwrap_or_default(), &mut random)
        };
        members.iter().map(appearance).collect()
    }

    /// Returns the random numbers of a member.
    fn random(&self, key: u64) -> fastrand::Rng {
        let number = key.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        fastrand::Rng::with_seed(self.seed.wrapping_add(number))
    }

    /// Returns an appearance with a look.
    fn appearance(&self, look: MemberLook, random: &mut fastrand::Rng) -> Appearance {
        let height = 1.0 + within(self.height, 0.3) * bell(random);
        let pace = 1.0 + within(self.pace, 0.9) * (2.0 * random.f32() - 1.0);
        Appearance { look, height, pace }
    }
}

fn within(value: f32, most: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, most) }
}

/// Returns a number from -2.5 to 2.5 with a standard deviation of about 1.
fn bell(random: &mut fastrand::Rng) -> f32 {
    let sum: f64 = (0..12).map(|_| random.f64()).sum();
    single((sum - 6.0).clamp(-2.5, 2.5))
}

/// Returns whether two members of one character have the same head.
fn same_head(a: &MemberLook, b: &MemberLook) -> bool {
    a.hidden == b.hidden && [Region::Hair, Region::Skin].iter().all(|r| a.tint(*r) == b.tint(*r))
}

/// Returns how alike two members of one character look: 6 with the same head and top.
fn likeness(a: &MemberLook, b: &MemberLook) -> usize {
    match (same_head(a, b), a.tint(Region::Top) == b.tint(Region::Top)) {
        (true, true) => 6,
        (true, false) | (false, true) => 1,
        (false, false) => 0,
    }
}

/// Returns the number of pairs in which one is among the [`NEIGHBOURS`] nearest of the other, and
/// both have the same head and the same top. `members` are those of [`Variety::appearances`].
///
/// # Panics
///
/// If there are fewer appearances than members.
#[must_use]
pub fn clones(members: &[(usize, [f32; 3])], appearances: &[Appearance]) -> usize {
    let near = nearest(members, NEIGHBOURS);
    let pairs = near.iter().enumerate().flat_map(|(a, others)| others.iter().map(move |b| (a, *b)));
    pairs
        .filter(|(a, b)| *a < *b || !near[*b].contains(a))
        .filter(|(a, b)| members[*a].0 == members[*b].0)
        .filter(|(a, b)| likeness(&appearances[*a].look, &appearances[*b].look) == 6)
        .count()
}
