//! One person of a scene.

use glam::Vec2;
use populace::MemberId;

use super::random::Random;

/// The activity of a person. Times are seconds of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Doing {
    /// It walks along its footway.
    Strolls,
    /// It walks to a spot, and gives up at a time.
    NearsSpot { spot: usize, until: f64 },
    /// It turns to what is to be seen there.
    FacesSpot { spot: usize, until: f64 },
    /// It looks.
    LooksIn { spot: usize, until: f64 },
    /// It walks to a seat.
    NearsSeat { seat: usize, until: f64 },
    /// It turns its back to it.
    FacesSeat { seat: usize, until: f64 },
    /// It sits down.
    SitsDown { seat: usize, until: f64 },
    /// It sits.
    Sits { seat: usize, until: f64 },
    /// It stands up.
    StandsUp { seat: usize, until: f64 },
    /// It walks to a wall.
    NearsWall { lean: usize, until: f64 },
    /// It turns its back to it.
    FacesAway { lean: usize, until: f64 },
    /// It leans.
    Leans { lean: usize, until: f64 },
    /// It stands up from the wall.
    Straightens { lean: usize, until: f64 },
    /// It walks to the end `side` of a crossing.
    NearsCrossing { crossing: usize, side: usize, until: f64 },
    /// It looks left and right since a time.
    LooksBothWays { crossing: usize, side: usize, since: f64 },
    /// It waits for the lights and for vehicles.
    Waits { crossing: usize, side: usize },
    /// It crosses from an end.
    Crosses { crossing: usize, side: usize, until: f64 },
    /// It walks to its place in a talk.
    Meets { talk: usize },
    /// It talks.
    Talks { talk: usize },
    /// It talks, and points at a window.
    Points { talk: usize },
    /// It says goodbye.
    Leaves { until: f64 },
    /// It walks on with a telephone at its ear.
    Phones { until: f64 },
    /// It walks on and reads a message.
    Texts { until: f64 },
    /// It walks to the door of a vehicle.
    NearsCar { car: usize, until: f64 },
    /// It turns to the vehicle.
    FacesCar { car: usize, until: f64 },
    /// It reaches for the handle and opens the door.
    OpensDoor { car: usize, since: f64 },
    /// It steps to the seat past the open door.
    StepsIn { car: usize, until: f64 },
    /// It gets in.
    GetsIn { car: usize, until: f64 },
    /// It drives. It may get out after a time.
    Drives { car: usize, since: f64 },
    /// It gets out.
    GetsOut { car: usize, until: f64 },
    /// It walks from a vehicle back to its footway.
    WalksFromCar { until: f64 },
    /// It hurries towards somebody who does not look.
    Hurries { victim: usize, until: f64 },
    /// It has run into somebody, and stops.
    Stops { until: f64 },
    /// It falls, and lies until a time.
    Falls { until: f64 },
    /// It gets up.
    GetsUp,
    /// It sits and watches.
    Watches,
    /// It sits and claps.
    Claps { until: f64 },
    /// It sits and cheers.
    Cheers { until: f64 },
    /// It rises for a wave.
    Rises { until: f64 },
    /// It sits down after a wave.
    Subsides { until: f64 },
    /// It advances to its post in a line of battle.
    Advances,
    /// It stands at its post.
    Guards,
    /// It thrusts its spear.
    Thrusts { until: f64 },
    /// It is hit.
    Flinches { until: f64 },
    /// It stands where it is.
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
    pub(crate) random: Random,
    pub(crate) doing: Doing,
    /// Its own walking speed in metres per second.
    pub(crate) pace: f32,
    pub(crate) footway: usize,
    /// 1 along the footway's line, -1 against it.
    pub(crate) direction: f32,
    /// Distance to the right of the line in its direction, as a part of half the width.
    pub(crate) lane: f32,
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
    /// Returns true for somebody who walks along its footway with free hands.
    pub(crate) fn strolls(&self) -> bool {
        self.doing == Doing::Strolls && !self.carries
    }
}
