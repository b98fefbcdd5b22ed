//! Bodies with equal legs and different feet, in simple poses.

use populace_model::humanoid::RoleMap;
use populace_model::{JointSource, Skeleton, Trs, f64math};

use super::*;

const NAMES: [(Role, &str); 9] = [
    (Role::Hips, "hips"),
    (Role::UpperLeg(Side::Left), "thigh.l"),
    (Role::LowerLeg(Side::Left), "shin.l"),
    (Role::Foot(Side::Left), "foot.l"),
    (Role::Toes(Side::Left), "toes.l"),
    (Role::UpperLeg(Side::Right), "thigh.r"),
    (Role::LowerLeg(Side::Right), "shin.r"),
    (Role::Foot(Side::Right), "foot.r"),
    (Role::Toes(Side::Right), "toes.r"),
];
const ANKLE_M: f64 = 0.08;

/// Creates a body 1.6 m high, with soles from 5 cm behind the ankle to `foot_m` in front of it.
/// Toes, if any, begin at half of that and are children of `toes_on`.
fn body(foot_m: f32, toes_on: Option<&str>) -> (Skeleton, RoleMap) {
    let mut joints: Vec<JointSource> = Vec::new();
    let mut add = |name: &str, parent: Option<&str>, translation: [f32; 3]| {
        let parent = parent.map(|parent| joints.iter().position(|j| j.name == parent).unwrap());
        joints.push(JointSource {
            name: name.into(),
            parent,
            rest: Trs { translation, ..Trs::IDENTITY },
        });
    };
    add("hips", None, [0.0, 0.9, 0.0]);
    add("head", Some("hips"), [0.0, 0.7, 0.0]);
    let mut soles = Vec::new();
    for (side, x) in [("l", 0.1), ("r", -0.1)] {
        let name = |part: &str| format!("{part}.{side}");
        add(&name("thigh"), Some("hips"), [x, -0.02, 0.0]);
        add(&name("shin"), Some(&name("thigh")), [0.0, -0.4, 0.0]);
        add(&name("foot"), Some(&name("shin")), [0.0, -0.4, 0.0]);
        let on_foot = if toes_on.is_some() { 0.5 * foot_m } else { foot_m };
        soles.push((name("foot"), vec![[x, 0.0, -0.05], [x, 0.0, on_foot]]));
        if let Some(on) = toes_on {
            let from = if on == "hips" { [x, -0.88, on_foot] } else { [0.0, -0.06, on_foot] };
            add(&name("toes"), Some(&if on == "hips" { on.to_owned() } else { name(on) }), from);
            soles.push((name("toes"), vec![[x, 0.0, on_foot], [x, 0.0, foot_m]]));
        }
    }
    let skeleton = Skeleton::new(&joints).unwrap();
    let of =
        |joint| soles.iter().find(|(name, _)| name == skeleton.name(joint)).map(|(_, p)| p.clone());
    let points: Vec<_> = skeleton.joints().map(|joint| of(joint).unwrap_or_default()).collect();
    let skeleton = skeleton.with_soles(&points);
    let names: Vec<_> =
        NAMES.into_iter().filter(|(_, name)| skeleton.find(name).is_some()).collect();
    let roles = RoleMap::from_names(&skeleton, &names).unwrap();
    (skeleton, roles)
}

/// The rest pose with the hips raised and joints pitched toes down.
fn pose(skeleton: &Skeleton, higher_m: f64, pitches: &[(&str, f64)]) -> Vec<DAffine3> {
    let local = |joint| {
        let name = skeleton.name(joint);
        let mut local = f64math::affine(skeleton.rest(joint));
        for (_, pitch) in pitches.iter().filter(|(pitched, _)| *pitched == name) {
            local *= DAffine3::from_rotation_x(*pitch);
        }
        local.translation.y += if name == "hips" { higher_m } else { 0.0 };
        local
    };
    skeleton.joints().map(local).collect()
}

/// Returns the corrections of the target's joints for a pose of the source.
fn corrections(
    source: &(Skeleton, RoleMap),
    target: &(Skeleton, RoleMap),
    pose: &[DAffine3],
) -> Option<Vec<DQuat>> {
    let [source, target] = [source, target].map(|(skeleton, roles)| Figure::new(skeleton, roles));
    let common = Common::new(source, target);
    Some(Soles::new(&common)?.rotations(pose))
}

fn angle(rotation: DQuat) -> f64 {
    2.0 * rotation.x.atan2(rotation.w)
}

#[test]
fn longer_foot_rolls_until_its_tip_is_on_the_ground() {
    let (source, target) = (body(0.15, None), body(0.3, None));
    let higher = 0.15 * 0.6_f64.sin() - ANKLE_M * (1.0 - 0.6_f64.cos());
    let found =
        corrections(&source, &target, &pose(&source.0, higher, &[("foot.l", 0.6)])).unwrap();
    let down = 0.6 + angle(found[0]);
    let tip = higher + ANKLE_M - ANKLE_M * down.cos() - 0.3 * down.sin();
    assert!((tip + DEPTH_TOLERANCE * 1.6).abs() < 1e-4, "the tip is {tip} m high");
    assert!(down > 0.2, "the heel is up: {down}");
    assert_eq!(found[1], DQuat::IDENTITY, "the right foot is in the air");
}

#[test]
fn airborne_deep_and_lying_feet_do_not_roll() {
    let (source, target) = (body(0.15, None), body(0.3, None));
    for (higher, pitch) in [(0.5, 0.6), (-0.3, 0.0), (-0.05, -1.5), (0.0, 2.5)] {
        let found =
            corrections(&source, &target, &pose(&source.0, higher, &[("foot.l", pitch)])).unwrap();
        assert!(Soles::are_negligible(&found), "{higher} m higher and {pitch} rad: {found:?}");
    }
}

#[test]
fn toes_stay_flat_while_the_foot_rolls() {
    let (source, target) = (body(0.2, Some("foot")), body(0.4, Some("foot")));
    let higher = 0.1 * 0.6_f64.sin();
    let pose = pose(&source.0, higher, &[("foot.l", 0.6), ("toes.l", -0.6)]);
    let found = corrections(&source, &target, &pose).unwrap();
    let toes = DQuat::from_rotation_x(0.6) * found[0] * DQuat::from_rotation_x(-0.6) * found[1];
    assert!(angle(found[0]) < -0.1, "the foot has not rolled");
    assert!(angle(toes).abs() < 1e-6, "toes are rotated by {}", angle(toes));
}

#[test]
fn toes_without_partner_bend_by_themselves() {
    let (source, target) = (body(0.15, None), body(0.3, Some("foot")));
    let higher = 0.15 * 0.6_f64.sin();
    let found =
        corrections(&source, &target, &pose(&source.0, higher, &[("foot.l", 0.6)])).unwrap();
    assert!(angle(found[1]) < -0.1, "the tip of the toes is in the ground");
}

/// From a heel in the air over a flat foot to its tip, in small steps.
#[test]
fn roll_is_continuous() {
    let (source, target) = (body(0.15, None), body(0.3, None));
    let mut before: Option<f64> = None;
    for step in 0..=400 {
        let pitch = -0.6 + f64::from(step) * 0.005;
        let higher =
            ANKLE_M * (pitch.cos() - 1.0) + if pitch < 0.0 { -0.05 } else { 0.15 } * pitch.sin();
        let found =
            corrections(&source, &target, &pose(&source.0, higher.max(0.0), &[("foot.l", pitch)]))
                .unwrap();
        let now = pitch + angle(found[0]);
        let jump = before.map_or(0.0, |before| (now - before).abs());
        assert!(jump < 0.05, "from {before:?} to {now} at {pitch}");
        before = Some(now);
    }
}

#[test]
fn unknown_soles_and_detached_toes_are_not_corrected() {
    let source = body(0.15, None);
    let at_rest = pose(&source.0, 0.0, &[]);
    let (skeleton, roles) = body(0.3, None);
    let bare = skeleton.clone().with_soles(&vec![Vec::new(); skeleton.joint_count()]);
    assert_eq!(corrections(&source, &(bare, roles), &at_rest), None);
    assert_eq!(corrections(&source, &body(0.3, Some("hips")), &at_rest), None);
    assert!(Soles::are_negligible(&corrections(&source, &body(0.3, None), &at_rest).unwrap()));
}

#[test]
fn foot_scaled_to_zero_is_not_corrected() {
    let (source, target) = (body(0.15, None), body(0.3, None));
    let mut pose = pose(&source.0, 0.0, &[("foot.l", 0.6)]);
    pose[source.0.find("foot.l").unwrap().index()].matrix3 = glam::DMat3::ZERO;
    let found = corrections(&source, &target, &pose).unwrap();
    assert!(found.iter().all(|rotation| rotation.is_finite()), "{found:?}");
}
