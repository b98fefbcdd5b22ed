//! Meeting and talking.

use std::f32::consts::TAU;

use glam::Vec2;
use populace::{ClipPlayback, Crowd};

use super::body::Use;
use super::footways::Place;
use super::person::Doing;
use super::places::PlacePlan;
use super::settling::Settling;
use super::world::{Talk, UPPER, World};
use crate::Error;

/// Distance within which somebody is met, in metres.
const MET_M: f32 = 5.0;
/// Distance of those who talk from their middle, in metres.
const AROUND_M: f32 = 0.58;
/// Seconds in which all must have come.
const COME_SECS: f64 = 9.0;
const FADE_SECS: f32 = 0.35;
/// The chance that a speaker shows the others a window, distances of such windows in metres, and
/// seconds of showing and of the motion of the hand in it.
const SHOWS: f32 = 0.3;
const SHOWN_M: std::ops::Range<f32> = 1.5..9.0;
const SHOWS_SECS: f64 = 5.6;
const POINTS_SECS: f64 = 2.8;
/// Seconds of a goodbye.
const GOODBYE_SECS: f64 = 1.6;

/// Lets somebody who strolls meet one or two others who stroll near by. Returns true if there is
/// somebody.
pub(crate) fn begin(world: &mut World, who: usize) -> Result<bool, Error> {
    if !world.body(who).has(&[Use::Talk, Use::Listen]) {
        return Ok(false);
    }
    let at = world.position(who);
    let footway = world.people[who].footway;
    let mut near: Vec<(f32, usize)> = (0..world.people.len())
        .filter(|other| {
            let person = &world.people[*other];
            *other != who && person.strolls() && person.footway == footway
        })
        .map(|other| (world.position(other).distance(at), other))
        .filter(|(m, other)| *m < MET_M && world.body(*other).has(&[Use::Talk, Use::Listen]))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let most = if world.people[who].random.chance(0.4) { 2 } else { 1 };
    let mut people = vec![who];
    people.extend(near.into_iter().take(most).map(|(_, other)| other));
    if people.len() < 2 {
        return Ok(false);
    }
    let sum: Vec2 = people.iter().map(|person| world.position(*person)).sum();
    let strip = &world.footways[footway];
    let place = strip.place(sum / people.len() as f32);
    let room = (strip.half_m - AROUND_M).max(0.0);
    let (middle, _) = strip.at(Place { aside_m: place.aside_m.clamp(-room, room), ..place });
    let begins = Vec2::normalize_or(at - middle, Vec2::X);
    // The others stand around the circle in the order in which they come.
    let mut others: Vec<usize> = people[1..].to_vec();
    let turn = |world: &World, other: usize| {
        let angle = begins.angle_to(world.position(other) - middle);
        if angle < 0.0 { angle + TAU } else { angle }
    };
    others.sort_by(|a, b| turn(world, *a).total_cmp(&turn(world, *b)));
    people.truncate(1);
    people.extend(others);
    let secs = world.people[who].random.between_f32(9.0, 22.0);
    let talk = Talk {
        people: people.clone(),
        middle,
        until: world.now + COME_SECS + f64::from(secs),
        speaker: 0,
        turn_until: 0.0,
        has_begun: false,
        shows: None,
    };
    let free = world.talks.iter().position(Option::is_none).unwrap_or(world.talks.len());
    world.talks.resize_with(world.talks.len().max(free + 1), || None);
    world.talks[free] = Some(talk);
    for (nth, person) in people.iter().enumerate() {
        let angle = TAU * nth as f32 / people.len() as f32;
        let to = middle + Vec2::from_angle(angle).rotate(begins) * AROUND_M;
        world.people[*person].doing = Doing::Meets { talk: free };
        world.send(*person, to)?;
    }
    Ok(true)
}

/// Begins in the middle of a talk on a footway. Returns false without a place for it.
pub(crate) fn settle(
    world: &mut World,
    crowd: &mut Crowd,
    people: &[usize],
    settling: &mut Settling<'_>,
) -> Result<bool, Error> {
    let can = |who: &usize| world.body(*who).has(&[Use::Talk, Use::Listen]);
    let Some(first) = people.first().filter(|_| people.len() > 1 && people.iter().all(can)) else {
        return Ok(false);
    };
    let Some((footway, middle, _)) = settling.place(world, *first, AROUND_M, 2.0 * AROUND_M) else {
        return Ok(false);
    };
    let begins = Vec2::from_angle(TAU * world.people[*first].random.unit());
    let index = world.talks.len();
    for (nth, who) in people.iter().enumerate() {
        let away = begins.rotate(Vec2::from_angle(TAU * nth as f32 / people.len() as f32));
        let yaw_rad = (-away.x).atan2(-away.y);
        settling.put(world, crowd, *who, (middle + away * AROUND_M, yaw_rad, 0.0))?;
        world.face(*who, Some(yaw_rad))?;
        let person = &mut world.people[*who];
        (person.footway, person.doing) = (footway, Doing::Talks { talk: index });
    }
    let until = f64::from(world.people[*first].random.between_f32(2.0, 20.0));
    let mut talk = Talk {
        people: people.to_vec(),
        middle,
        until,
        speaker: 0,
        turn_until: 0.0,
        has_begun: true,
        shows: None,
    };
    converse(world, crowd, &mut talk)?;
    world.talks.push(Some(talk));
    Ok(true)
}

/// Goes on with all talks.
pub(crate) fn step_all(world: &mut World, crowd: &mut Crowd) -> Result<(), Error> {
    for index in 0..world.talks.len() {
        let Some(mut talk) = world.talks[index].take() else { continue };
        let goes_on = if talk.has_begun {
            converse(world, crowd, &mut talk)?
        } else {
            gather(world, crowd, &mut talk, index)?
        };
        world.talks[index] = goes_on.then_some(talk);
    }
    Ok(())
}

/// Waits until all have come. Returns false if they have not in time.
fn gather(
    world: &mut World,
    crowd: &mut Crowd,
    talk: &mut Talk,
    index: usize,
) -> Result<bool, Error> {
    let has_come = |who: &usize| world.position(*who).distance(world.people[*who].goal) < 0.3;
    let have_come = talk.people.iter().all(has_come);
    let is_late = world.now > talk.until - COME_SECS;
    if have_come || is_late && talk.people.iter().filter(|who| has_come(who)).count() > 1 {
        let (come, gone): (Vec<_>, Vec<_>) = talk.people.iter().partition(|who| has_come(who));
        gone.into_iter().try_for_each(|who| world.go_on(who))?;
        talk.people = come;
        for who in talk.people.clone() {
            let to = talk.middle - world.position(who);
            world.halt(who)?;
            world.face(who, Some(to.x.atan2(to.y)))?;
            world.people[who].doing = Doing::Talks { talk: index };
        }
        talk.has_begun = true;
        talk.until -= COME_SECS.min((talk.until - world.now - 6.0).max(0.0));
        talk.speaker = talk.people.len() - 1;
        world.counts.talked += 1;
        return Ok(true);
    }
    if is_late {
        leave(world, crowd, talk, false)?;
    }
    Ok(!is_late)
}

/// Lets one talk and the others listen, in turns. Returns false at the end.
fn converse(world: &mut World, crowd: &mut Crowd, talk: &mut Talk) -> Result<bool, Error> {
    if world.now > talk.until {
        leave(world, crowd, talk, true)?;
        return Ok(false);
    }
    if world.now < talk.turn_until {
        point(world, crowd, talk)?;
        return Ok(true);
    }
    if talk.shows.take().is_some() {
        let speaker = talk.people[talk.speaker];
        let to = talk.middle - world.position(speaker);
        world.face(speaker, Some(to.x.atan2(to.y)))?;
    }
    talk.speaker = (talk.speaker + 1) % talk.people.len();
    let speaker = talk.people[talk.speaker];
    let secs = world.people[speaker].random.between_f32(2.5, 5.5);
    talk.turn_until = world.now + f64::from(secs);
    let listener = talk.people[(talk.speaker + 1) % talk.people.len()];
    for who in talk.people.clone() {
        if let Doing::Points { talk } = world.people[who].doing {
            world.people[who].doing = Doing::Talks { talk };
        }
        let usage = if who == speaker { Use::Talk } else { Use::Listen };
        let phase = world.people[who].random.unit();
        let playback = ClipPlayback::looping().phase(phase).fade_in_secs(FADE_SECS);
        world.play(crowd, who, usage, (UPPER, playback))?;
        let at = world.above(crowd, if who == speaker { listener } else { speaker }, 1.0)?;
        world.look(crowd, who, at)?;
    }
    show(world, crowd, talk)?;
    Ok(true)
}

/// Lets the speaker turn to a window near by, now and then, and all look at it.
fn show(world: &mut World, crowd: &mut Crowd, talk: &mut Talk) -> Result<(), Error> {
    let speaker = talk.people[talk.speaker];
    if !world.body(speaker).has(&[Use::Point]) || !world.people[speaker].random.chance(SHOWS) {
        return Ok(());
    }
    let at = world.position(speaker);
    let distance = |spot: &usize| world.spots[*spot].at().distance(at);
    let near = (0..world.spots.len()).filter(|spot| SHOWN_M.contains(&distance(spot)));
    let Some(spot) = near.min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
        return Ok(());
    };
    let shown = world.spots[spot].look_at;
    world.face(speaker, Some((shown[0] - at.x).atan2(shown[2] - at.y)))?;
    for who in &talk.people {
        world.look(crowd, *who, shown)?;
    }
    talk.shows = Some(spot);
    talk.turn_until = world.now + SHOWS_SECS;
    Ok(())
}

/// Lets a speaker who has turned to a window point at it.
fn point(world: &mut World, crowd: &mut Crowd, talk: &Talk) -> Result<(), Error> {
    let (Some(spot), speaker) = (talk.shows, talk.people[talk.speaker]) else { return Ok(()) };
    let Doing::Talks { talk: index } = world.people[speaker].doing else { return Ok(()) };
    let (at, shown) = (world.position(speaker), world.spots[spot].look_at);
    let yaw_rad = (shown[0] - at.x).atan2(shown[2] - at.y);
    let is_late = talk.turn_until - world.now < POINTS_SECS;
    if !is_late && !world.faces(crowd, speaker, yaw_rad)? {
        return Ok(());
    }
    let once = ClipPlayback::once().fade_in_secs(FADE_SECS);
    world.play(crowd, speaker, Use::Point, (UPPER, once))?;
    world.people[speaker].doing = Doing::Points { talk: index };
    world.counts.pointed += 1;
    Ok(())
}

/// Ends a talk: one waves, and all go on.
fn leave(world: &mut World, crowd: &mut Crowd, talk: &Talk, waves: bool) -> Result<(), Error> {
    for (nth, who) in talk.people.iter().enumerate() {
        if waves && nth == 0 && world.body(*who).has(&[Use::Wave]) {
            let playback = ClipPlayback::looping().fade_in_secs(FADE_SECS);
            world.play(crowd, *who, Use::Wave, (UPPER, playback))?;
            world.people[*who].doing = Doing::Leaves { until: world.now + GOODBYE_SECS };
            continue;
        }
        world.end(crowd, *who, UPPER, FADE_SECS)?;
        world.look_ahead(crowd, *who)?;
        world.go_on(*who)?;
    }
    Ok(())
}

/// Ends a goodbye.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
    if let Doing::Leaves { until } = world.people[who].doing
        && world.now > until
    {
        world.end(crowd, who, UPPER, FADE_SECS)?;
        world.look_ahead(crowd, who)?;
        world.go_on(who)?;
    }
    Ok(())
}
