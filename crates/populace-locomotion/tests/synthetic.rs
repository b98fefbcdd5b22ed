//! Gaits of a body of two blocks under a pole, whose contacts, speed and stride are known exactly.

#![expect(clippy::unwrap_used, reason = "tests panic on errors")]

use std::sync::Arc;

use populace::character::{Character, CharacterSource, Influences, Mesh, PaletteEntry, Part};
use populace::clip::Clip;
use populace::model::{
    Affine, ClipSource, Interpolation, JointSource, Property, Side, Skeleton, Track, Trs,
};
use populace_locomotion::{Contact, Gait, GaitClips, MixedClip};

const FEET: [(&str, f32); 2] = [("left", 0.1), ("right", -0.1)];
/// The height of ankles above their soles.
const ANKLE: f32 = 0.1;
/// The time in which a foot is lifted or set down.
const INSTANT: f32 = 0.002;
/// Two samples, in seconds.
const NEAR_SECS: f32 = 2.0 / 120.0;

fn body() -> Arc<Character> {
    let joint = |name: &str, parent, translation| JointSource {
        name: name.into(),
        parent,
        rest: Trs { translation, ..Trs::IDENTITY },
    };
    let [left, right] = FEET.map(|(name, x)| joint(name, Some(0), [x, ANKLE, 0.0]));
    let skeleton = Skeleton::new(&[joint("pole", None, [0.0; 3]), left, right]).unwrap();
    let mut palette = Vec::new();
    let (mut positions, mut entries) = (Vec::new(), Vec::new());
    for (at, joint) in (0u16..).zip(skeleton.joints()) {
        let [x, y, z] = skeleton.rest(joint).translation;
        let mut joint_from_bind = Affine::IDENTITY;
        for (row, offset) in joint_from_bind.rows.iter_mut().zip([-x, -y, -z]) {
            row[3] = offset;
        }
        palette.push(PaletteEntry { joint, joint_from_bind });
        let corners = match skeleton.name(joint) {
            "pole" => [[0.0, 1.0, 0.0], [0.1, 1.7, 0.0], [-0.1, 1.7, 0.0]],
            _ => [[x, 0.0, -0.1], [x - 0.04, 0.0, 0.2], [x + 0.04, 0.0, 0.2]],
        };
        positions.extend(corners);
        entries.extend([[at, 0, 0, 0]; 3].as_flattened());
    }
    let mesh = Mesh {
        normals: vec![[0.0, 1.0, 0.0]; positions.len()],
        uvs: Vec::new(),
        colors: Vec::new(),
        influences: Influences {
            per_vertex: 4,
            entries,
            weights: [[1.0, 0.0, 0.0, 0.0]; 9].as_flattened().to_vec(),
        },
        indices: (0..9).collect(),
        positions,
    };
    let part = Part { node: 0, node_name: String::new(), primitive: 0, material: None, mesh };
    let source = CharacterSource {
        name: "blocks".into(),
        skeleton,
        palette,
        parts: vec![part],
        materials: Vec::new(),
        images: Vec::new(),
        skins: Vec::new(),
        clips: Vec::new(),
    };
    Arc::new(Character::new(source).unwrap())
}

/// The path of a foot through its own cycle: phases with the height of its sole and its place along
/// Z, which are interpolated linearly.
type Path = Vec<(f32, [f32; 2])>;

/// Returns the path of a foot that stands from phase 0 to `off` while it moves back over `reach`,
/// and is lifted for the rest of the cycle of `secs`.
fn steps(secs: f32, off: f32, reach: f32) -> Path {
    let (instant, half) = (INSTANT / secs, 0.5 * reach);
    vec![
        (0.0, [0.0, half]),
        (off, [0.0, -half]),
        (off + instant, [0.2, -half]),
        (1.0 - instant, [0.2, half]),
        (1.0, [0.0, half]),
    ]
}

fn at(path: &Path, phase: f32) -> [f32; 2] {
    let next = path.iter().position(|(at, _)| *at >= phase).unwrap().max(1);
    let ((from, a), (to, b)) = (path[next - 1], path[next]);
    let share = (phase - from) / (to - from);
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

/// Returns a clip in which the left foot starts its path at `phases[0]`, and the right one at
/// `phases[1]`. `carried_m` is how far the clip carries the whole body forwards.
fn clip(secs: f32, paths: &[Path; 2], phases: [f32; 2], carried_m: f32) -> Arc<Clip> {
    named("gait", secs, paths, phases, carried_m)
}

/// As [`clip`], with a name.
fn named(name: &str, secs: f32, paths: &[Path; 2], phases: [f32; 2], carried_m: f32) -> Arc<Clip> {
    let track = |(foot, phase): (usize, f32)| {
        let (name, x) = FEET[foot];
        let own = |time: f32| (time / secs + phase).rem_euclid(1.0);
        let knots = paths[foot].iter().map(|(at, _)| (at - phase).rem_euclid(1.0) * secs);
        let mut times: Vec<f32> = knots.chain([0.0, secs]).collect();
        times.sort_by(f32::total_cmp);
        times.dedup_by(|b, a| *b - *a < 1e-5);
        let place = |time: &f32| {
            let [y, z] = at(&paths[foot], own(*time));
            [x, ANKLE + y, z]
        };
        let values = times.iter().flat_map(place).collect();
        let (property, interpolation) = (Property::Translation, Interpolation::Linear);
        Track { joint: name.into(), property, interpolation, times, values }
    };
    let mut tracks: Vec<Track> = phases.into_iter().enumerate().map(track).collect();
    tracks.push(Track {
        joint: "pole".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, secs],
        values: vec![0.0, 0.0, 0.0, 0.0, 0.0, carried_m],
    });
    Arc::new(Clip::new(ClipSource { name: name.into(), tracks }, &body().skeleton).unwrap())
}

/// Returns a gait with both feet half a cycle apart, the left one touching down at `phase`.
fn symmetric(secs: f32, path: Path, phase: f32) -> Arc<Clip> {
    clip(secs, &[path.clone(), path], [-phase, 0.5 - phase], 0.0)
}

fn measure(clip: &Arc<Clip>) -> Gait {
    Gait::measure(&body(), clip).unwrap().unwrap()
}

#[track_caller]
fn near(found: f32, wanted: f32, tolerance: f32) {
    assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted} +- {tolerance}");
}

#[track_caller]
fn contacts_are(gait: &Gait, wanted: &[(Side, f32, f32)]) {
    let close = |(contact, (foot, from, until)): (&Contact, &(Side, f32, f32))| {
        contact.foot == *foot
            && (contact.from_secs - from).abs() < NEAR_SECS
            && (contact.until_secs - until).abs() < NEAR_SECS
    };
    let contacts = &gait.contacts;
    let fits = contacts.len() == wanted.len() && contacts.iter().zip(wanted).all(close);
    assert!(fits, "{contacts:?} are not {wanted:?}");
}

#[test]
fn contacts_speed_and_stride_of_a_square_wave_are_exact() {
    // The left foot touches down at 0.25 s, the right one at 0.75 s and through the end.
    let gait = measure(&symmetric(1.0, steps(1.0, 0.6, 0.72), 0.25));
    contacts_are(&gait, &[(Side::Left, 0.25, 0.85), (Side::Right, 0.75, 1.35)]);
    near(gait.velocity_m_per_sec[0], 0.0, 1e-3);
    near(gait.velocity_m_per_sec[1], 1.2, 1e-2);
    near(gait.speed_m_per_sec(), 1.2, 1e-2);
    near(gait.cadence_per_min().unwrap(), 120.0, 1e-3);
    near(gait.stride_m().unwrap(), 1.2, 1e-2);
    near(gait.contact_share(), 0.6, 0.02);
    near(gait.skate_m_per_sec, 0.0, 0.02);
    for (foot, (_, x)) in FEET.into_iter().enumerate() {
        let [center_x, center_z] = gait.stance_center_m[foot].unwrap();
        near(center_x, x, 1e-3);
        near(center_z, 0.0, 0.01);
        near(gait.sole_height_m[foot].unwrap(), 0.0, 2e-3);
    }
}

#[test]
fn a_run_has_short_contacts() {
    let gait = measure(&symmetric(0.7, steps(0.7, 0.3, 0.63), 0.0));
    contacts_are(&gait, &[(Side::Left, 0.0, 0.21), (Side::Right, 0.35, 0.56)]);
    near(gait.speed_m_per_sec(), 3.0, 0.03);
    near(gait.stride_m().unwrap(), 2.1, 0.02);
}

#[test]
fn backward_walks_have_a_negative_velocity() {
    let gait = measure(&symmetric(1.0, steps(1.0, 0.6, -0.6), 0.25));
    near(gait.velocity_m_per_sec[1], -1.0, 1e-2);
    near(gait.contact_share(), 0.6, 0.02);
}

#[test]
fn soles_that_dip_below_the_ground_stand() {
    let mut path = steps(1.0, 0.6, 0.6);
    path.splice(1..1, [(0.1, [-0.06, 0.2]), (0.2, [0.0, 0.1])]);
    let gait = measure(&symmetric(1.0, path, 0.25));
    contacts_are(&gait, &[(Side::Left, 0.25, 0.85), (Side::Right, 0.75, 1.35)]);
    near(gait.speed_m_per_sec(), 1.0, 0.01);
    // A triangle of 6 cm over a third of the contact.
    near(gait.sole_height_m[0].unwrap(), -0.01, 2e-3);
}

#[test]
fn a_foot_that_slides_stands_all_the_same() {
    // The first quarter of the contact is 2.5 times as fast as the rest.
    let mut path = steps(1.0, 0.6, 0.825);
    path.insert(1, (0.15, [0.0, 0.0375]));
    let gait = measure(&symmetric(1.0, path, 0.25));
    contacts_are(&gait, &[(Side::Left, 0.25, 0.85), (Side::Right, 0.75, 1.35)]);
    near(gait.speed_m_per_sec(), 1.0, 0.01);
    near(gait.skate_m_per_sec, 0.25 * 1.5, 0.03);
}

#[test]
fn a_foot_that_never_lifts_stands_throughout() {
    let still: Path = vec![(0.0, [0.0, 0.0]), (1.0, [0.0, 0.0])];
    let gait = measure(&clip(1.0, &[still.clone(), still.clone()], [0.0; 2], 0.0));
    contacts_are(&gait, &[(Side::Left, 0.0, 1.0), (Side::Right, 0.0, 1.0)]);
    assert_eq!((gait.step_count(), gait.cadence_per_min(), gait.stride_m()), (0, None, None));
    near(gait.speed_m_per_sec(), 0.0, 1e-3);
    // The other foot taps.
    let gait = measure(&clip(1.0, &[still, steps(1.0, 0.5, 0.0)], [0.0; 2], 0.0));
    contacts_are(&gait, &[(Side::Left, 0.0, 1.0), (Side::Right, 0.0, 0.5)]);
    near(gait.contact_share_of(Side::Right), 0.5, 0.02);
    assert_eq!(gait.step_count(), 1);
}

#[test]
fn a_dragged_foot_stands_only_while_it_moves_back() {
    let mut dragged = steps(1.0, 0.6, 0.6);
    dragged.iter_mut().for_each(|(_, place)| place[0] = 0.0);
    let gait = measure(&clip(1.0, &[steps(1.0, 0.6, 0.6), dragged], [0.75, 0.25], 0.0));
    contacts_are(&gait, &[(Side::Left, 0.25, 0.85), (Side::Right, 0.75, 1.35)]);
    near(gait.velocity_m_per_sec[1], 1.0, 0.01);
}

#[test]
fn a_foot_that_is_held_up_has_no_contact() {
    let up: Path = vec![(0.0, [0.3, -0.2]), (1.0, [0.3, -0.2])];
    let gait = measure(&clip(0.5, &[steps(0.5, 0.4, 0.2), up], [0.0; 2], 0.0));
    contacts_are(&gait, &[(Side::Left, 0.0, 0.2)]);
    assert!(gait.stance_center_m[1].is_none() && gait.sole_height_m[1].is_none());
    near(gait.speed_m_per_sec(), 1.0, 0.02);
}

#[test]
fn a_clip_that_carries_the_body_walks_at_the_same_speed() {
    let path = steps(1.0, 0.6, 0.6);
    let gait = measure(&clip(1.0, &[path.clone(), path], [0.75, 0.25], 1.0));
    contacts_are(&gait, &[(Side::Left, 0.25, 0.85), (Side::Right, 0.75, 1.35)]);
    near(gait.velocity_m_per_sec[1], 1.0, 0.01);
    near(gait.stance_center_m[0].unwrap()[1], 0.0, 0.01);
}

#[test]
fn a_clip_that_carries_the_body_is_chosen_in_place() {
    let still = vec![(0.0, [0.0, 0.0]), (1.0, [0.0, 0.0])];
    let idle = symmetric(1.0, still, 0.0);
    // In model space feet stand where they are, and the body is carried over them.
    let path = steps(1.0, 0.6, 0.6);
    let carried = clip(1.0, &[path.clone(), path], [0.0, 0.5], 1.0);
    let chosen = GaitClips::among(&body(), &[idle, Arc::clone(&carried)]).unwrap();
    let [walk] = chosen.moving.as_slice() else { panic!("{:?}", chosen.moving.len()) };
    assert!(!Arc::ptr_eq(walk, &carried) && walk.root_motion().is_some());
    near(measure(walk).speed_m_per_sec(), 1.0, 0.02);
}

#[test]
fn clips_of_the_usual_names_are_chosen_also_if_one_is_there_twice() {
    let still = vec![(0.0, [0.0, 0.0]), (1.0, [0.0, 0.0])];
    let idle = named("Idle", 1.0, &[still.clone(), still], [0.0, 0.5], 0.0);
    let walks = |name: &str, reach: f32| {
        let path = steps(1.0, 0.6, reach);
        named(name, 1.0, &[path.clone(), path], [0.0, 0.5], 0.0)
    };
    let [walk, twin, nearer] = [walks("Walk", 0.3), walks("Walk", 0.3), walks("Stroll", 0.75)];
    let chosen = |clips: &[&Arc<Clip>]| {
        let clips: Vec<_> = clips.iter().map(|clip| Arc::clone(clip)).collect();
        GaitClips::among(&body(), &clips).unwrap().moving[0].name().to_owned()
    };
    assert_eq!(chosen(&[&idle, &walk, &nearer]), "Walk");
    assert_eq!(chosen(&[&idle, &walk, &nearer, &twin]), "Walk");
    let unnamed = walks("Amble", 0.3);
    assert_eq!(chosen(&[&idle, &unnamed, &nearer]), "Stroll");
}

#[test]
fn mixes_share_one_phase() {
    let body = body();
    let mix = |clips: &[MixedClip]| Gait::measure_mix(&body, clips).unwrap().unwrap();
    let slow = symmetric(1.0, steps(1.0, 0.6, 0.3), 0.0);
    let fast = symmetric(0.8, steps(0.8, 0.6, 0.6), 0.0);
    let gait = mix(&[MixedClip::new(&slow, 0.25), MixedClip::new(&fast, 0.75)]);
    // Cycles per second are the mean of 1 and 1.25, and lengths of strides that of 0.5 and 1 m.
    near(gait.duration_secs, 1.0 / 1.1875, 1e-4);
    near(gait.speed_m_per_sec(), 0.875 * 1.1875, 0.01);
    near(gait.contact_share(), 0.6, 0.03);
    // The same clip that starts with the other foot.
    let late = symmetric(1.0, steps(1.0, 0.6, 0.3), 0.3);
    let pair = [MixedClip::new(&slow, 0.5), MixedClip::new(&late, 0.5).with_offset(0.3)];
    near(mix(&pair).speed_m_per_sec(), 0.5, 0.01);
    contacts_are(&mix(&pair), &measure(&slow).contacts.iter().map(of).collect::<Vec<_>>());
    // A pose halves the stride and does not count towards the rate.
    let zero: Path = vec![(0.0, [0.0, 0.0]), (1.0, [0.0, 0.0])];
    let source = ClipSource {
        name: "pose".into(),
        tracks: FEET
            .map(|(name, x)| Track {
                joint: name.into(),
                property: Property::Translation,
                interpolation: Interpolation::Linear,
                times: vec![0.0],
                values: vec![x, ANKLE + at(&zero, 0.0)[0], 0.0],
            })
            .into(),
    };
    let pose = Arc::new(Clip::new(source, &body.skeleton).unwrap());
    let gait = mix(&[MixedClip::new(&pose, 0.5), MixedClip::new(&fast, 0.5)]);
    near(gait.duration_secs, 0.8, 1e-4);
    near(gait.speed_m_per_sec(), 0.625, 0.01);
    assert_eq!(Gait::measure(&body, &pose).unwrap(), None);
    assert_eq!(Gait::measure_mix(&body, &[]).unwrap(), None);
    for weight in [1.5, -0.1, f32::NAN] {
        assert!(Gait::measure_mix(&body, &[MixedClip::new(&fast, weight)]).is_err(), "{weight}");
    }
}

fn of(contact: &Contact) -> (Side, f32, f32) {
    (contact.foot, contact.from_secs, contact.until_secs)
}
