//! One person of a scene.

use glam::Vec2;
use populace::MemberId;
use populace_random::Rng;

/// The activity of a person. Times are seconds of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Doing {
    /// Walks along its footway.
    Strolls,
    /// Walks to a spot, and gives up at a time.
    NearsSpot { spot: usize, until: f64 },
    /// Turns to what is to be seen there.
    FacesSpot { spot: usize, until: f64 },
    /// Looks.
    LooksIn { spot: usize, until: f64 },
    /// Walks to a seat.
    NearsSeat { seat: usize, until: f64 },
    /// Turns its back to it.
    FacesSeat { seat: usize, until: f64 },
    /// Sits down.
    SitsDown { seat: usize, until: f64 },
    /// Sits.
    Sits { seat: usize, until: f64 },
    /// Stands up.
    StandsUp { seat: usize, until: f64 },
    /// Walks to a wall.
    NearsWall { lean: usize, until: f64 },
    /// Turns its back to it.
    FacesAway { lean: usize, until: f64 },
    /// Leans.
    Leans { lean: usize, until: f64 },
    /// Stands up from the wall.
    Straightens { lean: usize, until: f64 },
    /// Walks to the end `side` of a crossing.
    NearsCrossing { crossing: usize, side: usize, until: f64 },
    /// Looks left and right since a time.
    LooksBothWays { crossing: usize, side: usize, since: f64 },
    /// Waits for the lights and for vehicles.
    Waits { crossing: usize, side: usize },
    /// Crosses from an end.
    Crosses { crossing: usize, side: usize, until: f64 },
    /// Walks to its place in a talk.
    Meets { talk: usize },
    /// Talks.
    Talks { talk: usize },
    /// Talks, and points at a window.
    Points { talk: usize },
    /// Says goodbye.
    Leaves { until: f64 },
    /// Walks on with a telephone at its ear.
    Phones { until: f64 },
    /// Walks on and reads a message.
    Texts { until: f64 },
    /// Walks to the door of a vehicle.
    NearsCar { car: usize, until: f64 },
    /// Turns to the vehicle.
    FacesCar { car: usize, until: f64 },
    /// Reaches for the handle and opens the door.
    OpensDoor { car: usize, since: f64 },
    /// Steps to the seat past the open door.
    StepsIn { car: usize, until: f64 },
    /// Gets in.
    GetsIn { car: usize, until: f64 },
    /// Drives. It may get out after a time.
    Drives { car: usize, since: f64 },
    /// Gets out.
    GetsOut { car: usize, until: f64 },
    /// Walks from a vehicle back to its footway.
    WalksFromCar { until: f64 },
    /// Hurries towards somebody who does not look.
    Hurries { victim: usize, until: f64 },
    /// Has run into somebody, and stops.
    Stops { until: f64 },
    /// Falls, and lies until a time.
    Falls { until: f64 },
    /// Gets up.
    GetsUp,
    /// Sits and watches.
    Watches,
    /// Sits and claps.
    Claps { until: f64 },
    /// Sits and cheers.
    Cheers { until: f64 },
    /// Rises for a wave.
    Rises { until: f64 },
    /// Sits down after a wave.
    Subsides { until: f64 },
    /// Advances to its post in a line of battle.
    Advances,
    /// Stands at its post.
    Guards,
    /// Thrusts its spear.
    Thrusts { until: f64 },
    /// Is hit.
    Flinches { until: f64 },
    /// Stands where it is.
    Stands,
}

/// The kind of a person's behaviour, and its index among those of the kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Strolls(usize),
    Spectates(usize),
    Fights(usize),
    Stands,
}

/// A person.
#[derive(Clone, Debug)]
pub(crate) struct Person {
    pub(crate) member: MemberId,
    /// Index of its body.
    pub(crate) body: usize,
    pub(crate) kind: Kind,
    pub(crate) scale: f32,
    pub(crate) random: Rng,
    pub(crate) doing: Doing,
    /// Its own walking speed in metres per second.
    pub(crate) pace: f32,
    pub(crate) footway: usize,
    /// 1 along the footway's line, -1 against it.
    pub(crate) direction: f32,
    /// Distance to the right of the line in its direction, as a part of half the width.
    pub(crate) lane: f32,
    /// The index of the group with which it walks.
    pub(crate) group: Option<usize>,
    /// The number of turns for which people who stand have held it up.
    pub(crate) held_up: u8,
    /// Where it is sent.
    pub(crate) goal: Vec2,
    /// The place of who has one: in a line of battle, or on a stand.
    pub(crate) post: Vec2,
    /// True for somebody who carries a parcel with both hands.
    pub(crate) carries: bool,
    /// True for a soldier of the front rank.
    pub(crate) is_in_front: bool,
}

impl Person {
    /// Returns true for somebody who walks along its footway alone, with free hands.
    pub(crate) fn strolls(&self) -> bool {
        self.doing == Doing::Strolls && !self.carries && self.group.is_none()
    }
}
