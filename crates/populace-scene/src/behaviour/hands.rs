//! Phones in the hands of people who telephone and read.

use std::collections::HashMap;

use populace::{CharacterId, Crowd, Error as CrowdError, JointIndex, MemberId, Placement, Trs};

use super::body::{Body, Use};
use super::grips::Grip;
use crate::Error;

/// Time in which a phone comes out of a pocket, and goes back, in seconds.
const POCKET_SECS: f64 = 0.3;
/// The least size of a phone as a part of its own: it comes out of a closed hand.
const LEAST: f32 = 0.05;

/// The phones of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Phones {
    character: Option<CharacterId>,
    /// The phones in hands, and those that go back to pockets.
    held: Vec<Phone>,
    /// The indices of the phones in hands, by owners.
    in_hands: HashMap<MemberId, usize>,
}

/// A phone in a hand.
#[derive(Clone, Debug)]
struct Phone {
    owner: MemberId,
    phone: MemberId,
    joint: JointIndex,
    offset: Trs,
    /// When it came into the hand, and when it begins to go.
    since: f64,
    until: Option<f64>,
}

/// Returns where a body holds a phone for what it plays.
pub(crate) fn place(body: &Body, usage: Use) -> Option<Grip> {
    match usage {
        Use::Phone => body.grips.phones[0],
        Use::Text => body.grips.phones[1],
        _ => None,
    }
}

impl Phones {
    /// Starts without phones. `character` is their model; `None` in a scene without one.
    pub(crate) fn new(character: Option<CharacterId>) -> Self {
        Self { character, held: Vec::new(), in_hands: HashMap::new() }
    }

    /// Gives somebody a phone at a place, or takes away what it holds. `now` is the time in
    /// seconds.
    pub(crate) fn change(
        &mut self,
        crowd: &mut Crowd,
        owner: MemberId,
        place: Option<Grip>,
        now: f64,
    ) -> Result<(), Error> {
        if let Some(index) = self.in_hands.remove(&owner) {
            self.held[index].until = Some(now);
        }
        let (Some((joint, offset)), Some(character)) = (place, self.character) else {
            return Ok(());
        };
        let phone = match crowd.spawn(character, Placement::at([0.0; 3])) {
            Ok(phone) => phone,
            // Hands stay empty in a crowd without room.
            Err(CrowdError::Full { .. }) => return Ok(()),
            Err(error) => return Err(error.into()),
        };
        // People who begin in the middle of a call hold the phone already.
        let since = if now > 0.0 { now } else { -POCKET_SECS };
        let held = Phone { owner, phone, joint, offset, since, until: None };
        held.attach(crowd, now)?;
        self.in_hands.insert(owner, self.held.len());
        self.held.push(held);
        Ok(())
    }

    /// Goes on until `now` with all phones by `step_secs`: they come out of pockets and go back.
    pub(crate) fn step(
        &mut self,
        crowd: &mut Crowd,
        (now, step_secs): (f64, f64),
    ) -> Result<(), Error> {
        for phone in &self.held {
            if phone.has_gone(now) {
                crowd.despawn(phone.phone)?;
            } else if phone.until.is_some() || now - step_secs < phone.since + POCKET_SECS {
                phone.attach(crowd, now)?;
            }
        }
        let before = self.held.len();
        self.held.retain(|phone| !phone.has_gone(now));
        if self.held.len() < before {
            let in_hands = self.held.iter().enumerate().filter(|(_, phone)| phone.until.is_none());
            self.in_hands = in_hands.map(|(index, phone)| (phone.owner, index)).collect();
        }
        Ok(())
    }
}

impl Phone {
    fn has_gone(&self, now: f64) -> bool {
        self.until.is_some_and(|until| now >= until + POCKET_SECS)
    }

    /// Puts the phone into its hand, in the size that it has now.
    fn attach(&self, crowd: &mut Crowd, now: f64) -> Result<(), Error> {
        let part = |secs: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "from 0 to 1")]
            let part = (secs / POCKET_SECS).clamp(0.0, 1.0) as f32;
            part
        };
        let goes = self.until.map_or(0.0, |until| part(now - until));
        let scale = part(now - self.since).min(1.0 - goes).max(LEAST);
        let offset = Trs { scale: self.offset.scale.map(|own| own * scale), ..self.offset };
        Ok(crowd.member_mut(self.phone)?.attach_to(self.owner, self.joint, offset)?)
    }
}
