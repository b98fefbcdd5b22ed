//! The scenes that come as files: the stand and the battle.
#![allow(clippy::unwrap_used, reason = "a scene that cannot be made fails the test")]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use populace::model::Role;
use populace::{Crowd, Device, MemberId};
use populace_locomotion::GaitSpace;
use populace_scene::plan::{BehaviourPlan, ScenePlan};
use populace_scene::{Behaviours, Counts, Error, Person, Stage};

const SECS: f32 = 1.0 / 30.0;

struct Live {
    crowd: Crowd,
    behaviours: Behaviours,
}

/// Brings a scene with the built-in man and woman as everybody.
fn live(plan: &ScenePlan) -> Result<Live, Error> {
    live_with_gaits(plan, true)
}

/// Brings a scene with the built-in man and woman as everybody, with or without gaits.
fn live_with_gaits(plan: &ScenePlan, has_gaits: bool) -> Result<Live, Error> {
    let builder = Crowd::builder().device(Device::native()).capacity(1000).slots_per_member(8);
    let mut crowd = builder.build()?;
    let looks = [populace_cast::Look::man(), populace_cast::Look::woman()];
    let characters: Vec<_> = looks
        .iter()
        .map(|look| crowd.add_character(populace_cast::person(look).unwrap()).unwrap())
        .collect();
    let walking = if has_gaits { &characters[..] } else { &[] };
    let gaits = GaitSpace::of_all(&mut crowd, walking).into_iter().map(Result::unwrap);
    let gaits = gaits.collect();
    let person = |nth: usize| Person {
        character: characters[nth % characters.len()],
        scale: 1.0,
        look: None,
    };
    let people: Vec<Vec<Person>> =
        plan.crowds.iter().map(|of| (0..of.count).map(person).collect()).collect();
    let prepare = |character| Ok(Arc::new(character));
    let stage = Stage::new(&mut crowd, plan, &BTreeMap::new(), &prepare)?;
    let behaviours = Behaviours::new(&mut crowd, plan, &stage, &people, gaits)?;
    Ok(Live { crowd, behaviours })
}

impl Live {
    fn run(&mut self, secs: f32) -> Counts {
        let mut left = secs;
        while left > 0.0 {
            self.behaviours.advance(&mut self.crowd, SECS).unwrap();
            self.crowd.update(SECS).unwrap();
            left -= SECS;
        }
        self.behaviours.counts()
    }
}

#[test]
fn spectators_clap_cheer_and_rise_for_each_wave() {
    let mut plan = ScenePlan::parse(include_str!("../../../scenes/stand.toml")).unwrap();
    plan.crowds[0].count = 300;
    let mut live = live(&plan).unwrap();
    let before = live.run(19.0);
    assert_eq!(before.waved, 0, "the first wave begins after 20 s");
    assert!(before.clapped > 100 && before.cheered > 20, "{before:?}");
    let after = live.run(5.0);
    assert_eq!(after.waved, 300, "everybody rises once");
}

#[test]
fn more_spectators_than_seats_are_refused() {
    let mut plan = ScenePlan::parse(include_str!("../../../scenes/stand.toml")).unwrap();
    plan.props.truncate(3);
    plan.crowds[0].count = 600;
    let error = live(&plan).err().unwrap();
    assert!(error.to_string().contains("600 people watch from 500 seats"), "{error}");
}

/// Plans that are made in code are not checked as those of a file are.
#[test]
fn fewer_people_than_fill_a_row_stand_around_its_middle() {
    for (count, asides) in [(1, vec![0.0]), (3, vec![-2.0, 0.0, 2.0])] {
        let text = format!(
            "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\ncast = \"a\"\n\
             count = {count}\ndoes.stand = {{ at = [5, 6], spacing_m = 2, even = true }}\n"
        );
        let live = live(&ScenePlan::parse(&text).unwrap()).unwrap();
        let mut xs = Vec::new();
        for member in live.behaviours.people() {
            let [x, y, z] = live.crowd.member(member).unwrap().placement().position();
            assert!(y.abs() < 1e-6 && (z - 6.0).abs() < 1e-6);
            xs.push(x - 5.0);
        }
        xs.sort_by(f32::total_cmp);
        let apart = xs.iter().zip(&asides).map(|(x, wanted)| (x - wanted).abs());
        assert!(xs.len() == asides.len() && apart.fold(0.0, f32::max) < 1e-5, "{xs:?}");
    }
}

/// Both casts have the same characters.
#[test]
fn each_cast_plays_the_clips_that_it_names() {
    let cast = |name: &str, clips: &str| {
        format!(
            "[[cast]]\nname = \"{name}\"\nfrom = [\"@man\"]\nclips = {{ {clips} }}\n[[crowd]]\n\
             cast = \"{name}\"\ncount = 1\ndoes.spectate = {{}}\n[[seat]]\nat = [0, 0.5, 0]\n\
             facing_deg = 0\n"
        )
    };
    let casts = [cast("a", ""), cast("b", "sit = \"Talk\""), cast("c", "")].concat();
    let live = live(&ScenePlan::parse(&format!("schema = 1\n{casts}")).unwrap()).unwrap();
    let played = live.behaviours.people().map(|member| {
        let member = live.crowd.member(member).unwrap();
        let clips = live.crowd.character(member.character()).unwrap().clips();
        let playing = member.active_clips()[0].clip;
        clips.iter().find(|(id, _)| *id == playing).unwrap().1.name().to_owned()
    });
    assert_eq!(played.collect::<Vec<_>>(), ["Sit", "Talk", "Sit"]);
}

/// Only who walks needs gaits.
#[test]
fn who_sits_or_stands_needs_no_gaits() {
    let scene = |does: &str| {
        let text = format!(
            "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\ncast = \"a\"\n\
             count = 1\ndoes.{does} = {{}}\n[[seat]]\nat = [0, 0.5, 0]\nfacing_deg = 0\n\
             [[footway]]\nname = \"f\"\npoints = [[0, 0], [9, 0]]\nwidth_m = 3\n"
        );
        live_with_gaits(&ScenePlan::parse(&text).unwrap(), false)
    };
    for does in ["stand", "spectate"] {
        scene(does).unwrap().run(2.0);
    }
    for does in ["stroll", "fight"] {
        let error = scene(does).err().unwrap();
        assert_eq!(error, Error::Locomotion(populace_locomotion::Error::NoGaits), "{does}");
    }
}

#[test]
fn footways_without_length_are_refused() {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n\
                [[footway]]\nname = \"path\"\npoints = [[0, 0], [9, 0]]\nwidth_m = 3\n\
                [[crowd]]\ncast = \"a\"\ncount = 6\ndoes.stroll = {}\n";
    let mut plan = ScenePlan::parse(text).unwrap();
    assert!(live(&plan).is_ok());
    for points in [vec![[1.0, 2.0]; 3], vec![[1.0, 2.0]], Vec::new(), vec![[0.0, f32::NAN]; 2]] {
        plan.footways[0].points = points;
        let error = live(&plan).err().unwrap();
        assert_eq!(error, Error::FootwayWithoutLength { name: "path".into() });
    }
}

/// Nobody begins within a wall, where it would stay, and nobody walks through it.
#[test]
fn people_keep_out_of_closed_walls() {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n\
                [[footway]]\nname = \"path\"\npoints = [[0, 0], [20, 0]]\nwidth_m = 4\n\
                [[prop]]\nkind = \"planter\"\nat = [10, 0, 0]\n[[wall]]\nclosed = true\n\
                points = [[9.35, -0.3], [10.65, -0.3], [10.65, 0.3], [9.35, 0.3]]\n\
                [[crowd]]\ncast = \"a\"\ncount = 60\ndoes.stroll = {}\n";
    for seed in 0..4 {
        let plan = ScenePlan { seed, ..ScenePlan::parse(text).unwrap() };
        let mut live = live(&plan).unwrap();
        let (mut before, mut past) = (BTreeSet::new(), BTreeSet::new());
        for step in 0..20 {
            for (who, member) in live.behaviours.people().enumerate() {
                let [x, _, z] = live.crowd.member(member).unwrap().placement().position();
                let is_within = (9.4..10.6).contains(&x) && z.abs() < 0.25;
                assert!(!is_within, "seed {seed}, {step} s: {who} is at {x}, {z}");
                before.extend((x < 9.0).then_some(who));
                past.extend((x > 11.0).then_some(who));
            }
            live.run(1.0);
        }
        let passed = before.intersection(&past).count();
        assert!(passed > 20, "seed {seed}: {passed} people come past the planter");
    }
}

/// People without a free place begin within each other, but not within a wall.
#[test]
fn nobody_of_too_many_begins_within_a_closed_wall() {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n\
                [[footway]]\nname = \"path\"\npoints = [[0, 0], [9, 0]]\nwidth_m = 3\n\
                [[wall]]\npoints = [[3, -0.5], [6, -0.5], [6, 0.5], [3, 0.5]]\nclosed = true\n\
                [[crowd]]\ncast = \"a\"\ncount = 300\ndoes.stroll = {}\n";
    let live = live(&ScenePlan::parse(text).unwrap()).unwrap();
    for member in live.behaviours.people() {
        let [x, _, z] = live.crowd.member(member).unwrap().placement().position();
        assert!(!(3.0..6.0).contains(&x) || z.abs() > 0.5, "{x}, {z}");
    }
}

/// Vehicles queue before people who stand in their lane, also those that begin there.
#[test]
fn vehicles_stop_for_people_who_stand_in_their_lane() {
    for at in [-38, 0, 3, 7] {
        let text = format!(
            "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\ncast = \"a\"\n\
             count = 3\n[crowd.does.stand]\nat = [{at}, 0]\nfacing_deg = 90\nrow = 1\n\
             spacing_m = 3\n[[lane]]\nname = \"l\"\nends = [[-40, 0], [40, 0]]\nvehicles = 4\n"
        );
        let mut live = live(&ScenePlan::parse(&text).unwrap()).unwrap();
        let xs = |live: &Live, members: &[MemberId]| {
            let x = |member: &MemberId| live.crowd.member(*member).unwrap().placement();
            members.iter().map(|member| x(member).position()[0]).collect::<Vec<f32>>()
        };
        let people: Vec<_> = live.behaviours.people().collect();
        let vehicles: Vec<_> = live.behaviours.vehicles().collect();
        for step in 0..100 {
            let cars = xs(&live, &vehicles);
            for person in xs(&live, &people).into_iter().filter(|x| *x >= -40.0) {
                // The shortest vehicle is about 4 m long.
                let nearest = cars.iter().map(|x| (x - person).abs()).fold(f32::MAX, f32::min);
                assert!(nearest > 2.2, "{nearest} m from {person}, at {at}, {step}");
            }
            live.run(0.3);
        }
        let before = xs(&live, &vehicles);
        live.run(1.0);
        assert_eq!(before, xs(&live, &vehicles), "all wait");
    }
}

#[test]
fn vehicles_fade_out_at_the_end_of_their_lane_and_in_at_its_start() {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\ncast = \"a\"\n\
                count = 1\ndoes.stroll = {}\n[[footway]]\nname = \"f\"\n\
                points = [[0, 6], [60, 6]]\nwidth_m = 2\n[[lane]]\nname = \"l\"\n\
                ends = [[0, 0], [60, 0]]\nvehicles = 1\n";
    let mut live = live(&ScenePlan::parse(text).unwrap()).unwrap();
    let vehicle = live.behaviours.vehicles().next().unwrap();
    let driver = live.behaviours.people().next().unwrap();
    let (mut before, mut jumps) = ([0.0, 1.0], 0);
    for _ in 0..150 {
        live.run(0.1);
        let car = live.crowd.member(vehicle).unwrap();
        let [x, ..] = car.placement().position();
        let opacity = car.look().opacity();
        assert_eq!(live.crowd.member(driver).unwrap().look().opacity(), opacity, "at {x}");
        assert!(opacity == 1.0 || !(6.1..53.9).contains(&x), "{opacity} at {x}");
        let [x_before, opacity_before] = before;
        if x < x_before {
            assert!(opacity < 0.25 && opacity_before < 0.25, "{opacity_before}, {opacity} at {x}");
            jumps += 1;
        }
        before = [x, opacity];
    }
    assert!(jumps > 0);
}

#[test]
fn soldiers_advance_to_their_posts_fight_fall_and_get_up() {
    let mut plan = ScenePlan::parse(include_str!("../../../scenes/battle.toml")).unwrap();
    for of in &mut plan.crowds {
        of.count = 40;
        let BehaviourPlan::Fight(fight) = &mut of.does else { panic!("another behaviour") };
        (fight.rank, fight.hit) = (20, 8.0);
    }
    let mut live = live(&plan).unwrap();
    let first: Vec<_> = live.behaviours.people().collect();
    let z =
        |live: &Live, nth: usize| live.crowd.member(first[nth]).unwrap().placement().position()[2];
    assert!(z(&live, 0) < -12.0, "the line begins far behind");
    let counts = live.run(40.0);
    // The front rank of the second crowd is at 1.1 m.
    assert!((z(&live, 40) - 1.1).abs() < 0.4, "a post is at {}", z(&live, 40));
    let Counts { thrust, hit, fell, got_up, .. } = counts;
    assert!(thrust > 50 && hit > 20 && fell > 2 && got_up > 0, "{counts:?}");
    // A shield, a spear and a helmet for each.
    let held = live.crowd.members().filter(|member| member.attached_to().is_some()).count();
    assert_eq!(held, 3 * 80);
}

/// A street of 80 m with a crossing in its middle, on which people may be, and vehicles close together.
const DENSE: &str = r#"
schema = 1
[[prop]]
kind = "road"
at = [0, 0, 0]
size_m = [80, 4, 0]
[[footway]]
name = "f"
points = [[-30, 5], [30, 5]]
width_m = 3
[[crossing]]
width_m = 3
ends = [[0, -4], [0, 4]]
lights = false
[[lane]]
name = "l"
ends = [[-40, 1.6], [40, 1.6]]
vehicles = 9
[[cast]]
name = "c"
from = ["@man"]
[[crowd]]
cast = "c"
count = 4
does.stroll = { footways = ["f"] }
"#;

/// Vehicles that would stand on the crossing when people are on it stand before it, one behind the
/// other.
#[test]
fn vehicles_begin_one_behind_the_other() {
    let plan = ScenePlan::parse(DENSE).unwrap();
    let live = live(&plan).unwrap();
    let in_lane = |[_, _, z]: &[f32; 3]| (z - 1.6).abs() < 1e-3;
    let people: Vec<MemberId> = live.behaviours.people().collect();
    let things = live.crowd.members().filter(|member| !people.contains(&member.id()));
    let places = things.map(|thing| thing.placement().position());
    let mut along: Vec<f32> = places.filter(in_lane).map(|[x, ..]| x).collect();
    assert_eq!(along.len(), 9);
    along.sort_by(f32::total_cmp);
    let nearest = along.windows(2).map(|pair| pair[1] - pair[0]).fold(f32::MAX, f32::min);
    assert!(nearest > 4.0, "two vehicles stand in each other: {along:?}");
    assert!(
        along.iter().all(|x| !(-3.0..3.0).contains(x)),
        "one stands on the crossing: {along:?}"
    );
}

/// People who stroll go around those who stand, also those who read a message.
#[test]
fn strollers_go_around_people_who_stand() {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[footway]]\n\
                name = \"plaza\"\npoints = [[-12, 0], [12, 0]]\nwidth_m = 8\n[[crowd]]\n\
                cast = \"a\"\ncount = 24\ndoes.stroll = { text = 2 }\n[[crowd]]\n\
                cast = \"a\"\ncount = 40\ndoes.stand = { at = [0, 2], row = 8 }\n";
    let mut live = live(&ScenePlan::parse(text).unwrap()).unwrap();
    let people: Vec<_> = live.behaviours.people().collect();
    let at = |live: &Live, who: MemberId| {
        let [x, _, z] = live.crowd.member(who).unwrap().placement().position();
        glam::Vec2::new(x, z)
    };
    let start: Vec<_> = people[..24].iter().map(|who| at(&live, *who)).collect();
    let mut farthest = [0.0_f32; 24];
    let mut passed = 0;
    for step in 0..400 {
        for (nth, walker) in people[..24].iter().enumerate() {
            let walker = at(&live, *walker);
            farthest[nth] = farthest[nth].max(walker.distance(start[nth]));
            passed += usize::from(walker.x.abs() < 3.5 && (-3.0..3.0).contains(&walker.y));
            for stander in &people[24..] {
                let apart = at(&live, *stander).distance(walker);
                assert!(apart > 0.36, "{apart} m apart at step {step}");
            }
        }
        live.run(0.1);
    }
    assert!(passed > 100, "they go through the crowd: {passed}");
    let stuck = farthest.iter().filter(|way| **way < 4.0).count();
    assert!(stuck < 3, "nobody stays: {farthest:?}");
}

/// Who sits down stays on the floor, unless the scene says otherwise.
#[test]
fn clips_that_end_elsewhere_are_played_once() {
    let heights = |keys: &str| {
        let text = format!(
            "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\ncast = \"a\"\n\
             count = 1\ndoes.stand = {{ {keys} }}\n"
        );
        let mut live = live(&ScenePlan::parse(&text).unwrap()).unwrap();
        let who = live.behaviours.people().next().unwrap();
        let head = live.crowd.member(who).unwrap().joint(Role::Head).unwrap();
        let mut heights = Vec::new();
        for _ in 0..120 {
            live.run(0.1);
            let mut models = [populace::Affine::IDENTITY];
            live.crowd.read_joints(&[(who, head)], &mut models).unwrap();
            heights.push(models[0].origin()[1]);
        }
        heights
    };
    let falls =
        |heights: &[f32]| heights.windows(2).filter(|pair| pair[0] - pair[1] > 1e-3).count();
    let rises = |heights: &[f32]| heights.windows(2).any(|pair| pair[1] - pair[0] > 0.2);
    let once = heights("clip = \"Sit_Down\"");
    assert!(falls(&once[..40]) > 5 && !rises(&once), "{once:?}");
    let late = heights("clip = \"Sit_Down\", start_s = 5");
    assert!(falls(&late[..48]) == 0 && falls(&late[48..90]) > 5 && !rises(&late), "{late:?}");
    assert!((once[119] - late[119]).abs() < 1e-3);
    assert!(rises(&heights("clip = \"Sit_Down\", loop = true")));
    let walks = heights("clip = \"Walk\"");
    assert!(falls(&walks[60..]) > 5, "{walks:?}");
}

/// Also around the ends of their footway, past other groups, and past people who stand.
#[test]
fn groups_stay_together_and_walk_side_by_side() {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[footway]]\n\
                name = \"walk\"\npoints = [[0, 0], [50, 0]]\nwidth_m = 6\n[[crowd]]\n\
                cast = \"a\"\ncount = 20\n[crowd.does.stroll]\nlook_in = 0\ncross = 0\nsit = 0\n\
                talk = 0\nphone = 0\ntext = 0\ndrive = 0\nhurry = 0\nlean = 0\ncarry = 0\n\
                together = 1\n[[crowd]]\ncast = \"a\"\ncount = 3\ndoes.stand = { at = [25, 0] }\n";
    let mut live = live(&ScenePlan::parse(text).unwrap()).unwrap();
    assert_eq!(live.behaviours.counts().together, 20);
    let people: Vec<_> = live.behaviours.people().take(20).collect();
    let places = |live: &Live| -> Vec<(glam::Vec2, glam::Vec2)> {
        let place = |who: &MemberId| {
            let placement = live.crowd.member(*who).unwrap().placement();
            let ([x, _, z], (sin, cos)) = (placement.position(), placement.yaw_rad().sin_cos());
            (glam::vec2(x, z), glam::vec2(sin, cos))
        };
        people.iter().map(place).collect()
    };
    let first = places(&live);
    let nearest = |nth: usize| {
        let others = (0..20).filter(|other| *other != nth);
        let apart = |other: &usize| first[nth].0.distance(first[*other].0);
        others.min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
    };
    let partners: Vec<usize> = (0..20).map(nearest).collect();
    let (mut beside, mut far, mut turned) = (0, 0, BTreeSet::new());
    for _ in 0..240 {
        live.run(0.25);
        let now = places(&live);
        for (nth, partner) in partners.iter().enumerate() {
            let ((at, ahead), (other, _)) = (now[nth], now[*partner]);
            beside += usize::from(ahead.perp_dot(other - at).abs() > ahead.dot(other - at).abs());
            far += usize::from(at.distance(other) > 1.1);
            turned.extend((ahead.dot(first[nth].1) < -0.9).then_some(nth));
        }
    }
    let all = 240 * 20;
    assert!(turned.len() > 15, "{} of 20 turn back", turned.len());
    assert!(beside * 100 > 85 * all, "{beside} of {all} are beside their partners");
    assert!(far * 100 < 2 * all, "{far} of {all} are far from their partners");
}

/// More people cross than wait at the kerb in one row, from both sides at once.
#[test]
fn many_who_cross_leave_the_road_to_the_vehicles() {
    let text = "schema = 1\nseed = 5\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n[[crowd]]\n\
                cast = \"a\"\ncount = 60\ndoes.stroll = { cross = 4, together = 0 }\n\
                [[footway]]\nname = \"north\"\npoints = [[-30, -5.25], [30, -5.25]]\nwidth_m = 4\n\
                [[footway]]\nname = \"south\"\npoints = [[-30, 5.25], [30, 5.25]]\nwidth_m = 4\n\
                [[crossing]]\nends = [[0, -3.5], [0, 3.5]]\nwidth_m = 4\nlights = true\n";
    let mut live = live(&ScenePlan::parse(text).unwrap()).unwrap();
    let people: Vec<_> = live.behaviours.people().collect();
    let (mut on_road_secs, mut longest_secs) = (vec![0.0_f32; people.len()], 0.0_f32);
    for _ in 0..160 {
        live.run(0.5);
        for (who, secs) in people.iter().zip(&mut on_road_secs) {
            let [_, _, z] = live.crowd.member(*who).unwrap().placement().position();
            *secs = if z.abs() < 3.0 { *secs + 0.5 } else { 0.0 };
            longest_secs = longest_secs.max(*secs);
        }
    }
    let crossed = live.behaviours.counts().crossed;
    assert!(crossed > 30, "{crossed} cross");
    assert!(longest_secs < 12.0, "somebody is on the road for {longest_secs} s");
}
