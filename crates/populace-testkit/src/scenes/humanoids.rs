//! Humanoid bodies with different joints, and a clip for each.

use std::collections::HashMap;

use glam::{DQuat, DVec3};
use populace_model::convert::single;
use populace_model::{ClipSource, Interpolation, JointSource, Property, Role, RoleMap, Side, Trs};

use super::motion::{even_times, swing, uneven_times, wave};
use super::{Scene, SceneClip, bodies};
use crate::Rng;
use crate::oracle::OracleRetarget;

/// A planned joint: its name, its parent's name, its rest position in model space, and its role.
type Planned = (String, Option<String>, DVec3, Option<Role>);

/// Plans a joint: its name, its parent's name, its rest position in units of the height, its role.
type AddJoint<'a> = dyn FnMut(&str, Option<&str>, [f64; 3], Option<Role>) + 'a;

/// The proportions and joints of a body.
#[derive(Clone, Copy)]
struct Build {
    height_m: f64,
    /// The thigh's fraction of the leg.
    thigh: f64,
    /// The angle of the arms below the horizontal.
    arms_rad: f64,
    /// Number of joints of the back.
    back: usize,
    neck: bool,
    collarbones: bool,
    /// The hips have a parent, which carries the body.
    root: bool,
    /// The feet are children of the root, not of the legs.
    loose_feet: bool,
    /// The limbs have additional joints without roles.
    extra: bool,
    /// Scale of the topmost joint.
    scale: f64,
}

const PLAIN: Build = Build {
    height_m: 1.8,
    thigh: 0.5,
    arms_rad: 0.0,
    back: 3,
    neck: true,
    collarbones: true,
    root: true,
    loose_feet: false,
    extra: false,
    scale: 1.0,
};

const BUILDS: [Build; 4] = [
    PLAIN,
    Build {
        height_m: 1.1,
        thigh: 0.56,
        arms_rad: 0.8,
        back: 1,
        neck: false,
        collarbones: false,
        root: false,
        ..PLAIN
    },
    Build {
        height_m: 3.0,
        thigh: 0.45,
        arms_rad: 0.3,
        back: 2,
        loose_feet: true,
        extra: true,
        ..PLAIN
    },
    Build { height_m: 1.6, arms_rad: 0.5, back: 2, extra: true, scale: 0.01, ..PLAIN },
];

impl Scene {
    /// Creates four humanoid bodies, each with a clip that moves all its joints, and retargets of
    /// each clip to the other bodies.
    ///
    /// The bodies have backs of one to three joints, with and without neck, collarbones and root,
    /// feet that are children of the root, additional joints in limbs, arms at various angles,
    /// arbitrary rest rotations, and joints in any order.
    ///
    /// # Panics
    ///
    /// Never: the bodies are valid.
    #[must_use]
    pub fn of_humanoids() -> Self {
        let mut rng = Rng::new(5);
        let (mut all, mut clips) = (Vec::new(), Vec::new());
        for (index, build) in BUILDS.iter().enumerate() {
            let (joints, roles) = joints(&mut rng, build, index);
            let body = bodies::body(&mut rng, joints, true).with_roles(roles);
            let times = if index % 2 == 0 {
                even_times(0.0, 40, 30.0)
            } else {
                uneven_times(&mut rng, 0.1, 40, 0.02, 0.04)
            };
            let mut tracks = Vec::new();
            for joint in &body.joints {
                tracks.push(swing(&mut rng, joint, Interpolation::Linear, &times));
                if rng.chance(0.5) || joint.name.ends_with("hips") || joint.name.ends_with("root") {
                    tracks.push(wave(
                        &mut rng,
                        joint,
                        Property::Translation,
                        Interpolation::Linear,
                        &times,
                    ));
                }
            }
            clips.push(SceneClip::new(
                ClipSource { name: format!("of {index}"), tracks },
                &body,
                index,
            ));
            all.push(body);
        }
        let mut retargets = HashMap::new();
        for (clip, made) in clips.iter().enumerate() {
            for (body, target) in all.iter().enumerate().filter(|(body, _)| *body != made.body) {
                let (from, source) = (&all[made.body], made.clip.source());
                let of = |body: &super::SceneBody| (body.oracle.clone(), body.roles.clone());
                let ((a, a_roles), (b, b_roles)) = (of(from), of(target));
                let retarget =
                    OracleRetarget::new(source, &made.exact_times, (&a, &a_roles), (&b, &b_roles));
                retargets.insert((clip, body), retarget);
            }
        }
        Self { bodies: all, clips, retargets }
    }
}

impl Scene {
    /// Adds soles to feet and toes, so that the feet of retargeted clips roll where they would
    /// sink. The oracle ignores soles.
    #[must_use]
    pub fn on_soles(mut self) -> Self {
        for body in &mut self.bodies {
            let (skeleton, roles) = (body.skeleton.clone(), body.role_map());
            let half_length_m = 0.1 * skeleton.size_m();
            let points = |joint| {
                let is_foot = |role: Role| matches!(role, Role::Foot(_) | Role::Toes(_));
                let has_sole = roles.iter().any(|(role, of)| of == joint && is_foot(role));
                let [x, _, z] = skeleton.rest_model(joint).origin();
                if has_sole {
                    vec![[x, 0.0, z - half_length_m], [x, 0.0, z + half_length_m]]
                } else {
                    Vec::new()
                }
            };
            let points: Vec<_> = skeleton.joints().map(points).collect();
            body.skeleton = skeleton.with_soles(&points);
        }
        self
    }
}

impl super::SceneBody {
    fn with_roles(self, roles: Vec<(Role, usize)>) -> Self {
        Self { roles, ..self }
    }

    /// Returns the body's roles as a map.
    ///
    /// # Panics
    ///
    /// If the body is not humanoid.
    #[must_use]
    pub fn role_map(&self) -> RoleMap {
        let names: Vec<_> =
            self.roles.iter().map(|&(role, j)| (role, self.joints[j].name.as_str())).collect();
        RoleMap::from_names(&self.skeleton, &names).expect("a humanoid body")
    }
}

/// Creates the joints of a build in shuffled order, and their roles.
fn joints(rng: &mut Rng, build: &Build, index: usize) -> (Vec<JointSource>, Vec<(Role, usize)>) {
    let planned = plan(build, index);
    let rotations: Vec<DQuat> = planned.iter().map(|_| rng.rotation()).collect();
    let find = |name: &String| {
        planned.iter().position(|(own, ..)| own == name).expect("parents are planned")
    };
    let mut index_of: Vec<usize> = (0..planned.len()).collect();
    rng.shuffle(&mut index_of);
    let mut joints: Vec<Option<JointSource>> = vec![None; planned.len()];
    let mut roles = Vec::new();
    for (n, (name, parent, at, role)) in planned.iter().enumerate() {
        let parent = parent.as_ref().map(find);
        let (above, from) =
            parent.map_or((DQuat::IDENTITY, DVec3::ZERO), |p| (rotations[p], planned[p].2));
        let is_top = parent.is_none();
        let length = if is_top { 1.0 } else { 1.0 / build.scale };
        let translation = above.inverse() * (*at - from) * length;
        let rest = Trs {
            translation: translation.to_array().map(single),
            rotation: (above.inverse() * rotations[n]).to_array().map(single),
            scale: if is_top { [single(build.scale); 3] } else { [1.0; 3] },
        };
        joints[index_of[n]] =
            Some(JointSource { name: name.clone(), parent: parent.map(|p| index_of[p]), rest });
        roles.extend(role.map(|role| (role, index_of[n])));
    }
    (joints.into_iter().flatten().collect(), roles)
}

fn plan(build: &Build, index: usize) -> Vec<Planned> {
    let h = build.height_m;
    let mut planned: Vec<Planned> = Vec::new();
    let mut add = |name: &str, parent: Option<&str>, at: [f64; 3], role: Option<Role>| {
        let named = |name: &str| format!("{index} {name}");
        planned.push((named(name), parent.map(named), DVec3::from_array(at) * h, role));
    };
    let hips_parent = if build.root { Some("root") } else { None };
    if build.root {
        add("root", None, [0.0, 0.0, 0.0], None);
    }
    add("hips", hips_parent, [0.0, 0.52, 0.0], Some(Role::Hips));
    let mut top = "hips".to_owned();
    let backs: &[Role] = match build.back {
        1 => &[Role::Chest],
        2 => &[Role::Spine, Role::Chest],
        _ => &[Role::Spine, Role::Chest, Role::UpperChest],
    };
    for (n, role) in backs.iter().enumerate() {
        let name = format!("back {n}");
        add(&name, Some(&top), [0.0, 0.57 + 0.08 * n as f64, -0.01 * n as f64], Some(*role));
        top = name;
    }
    let mut head = top.clone();
    if build.neck {
        add("neck", Some(&top), [0.0, 0.82, 0.0], Some(Role::Neck));
        head = "neck".into();
    }
    add("head", Some(&head), [0.0, 0.87, 0.01], Some(Role::Head));
    for (side, x) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
        limbs(build, side, x, &top, &mut add);
    }
    planned
}

fn limbs(build: &Build, side: Side, x: f64, top: &str, add: &mut AddJoint<'_>) {
    let name = |part: &str| format!("{part} {side:?}");
    let (sin, cos) = build.arms_rad.sin_cos();
    let arm = |along: f64| [x * (0.1 + along * cos), 0.8 - along * sin, 0.0];
    let mut parent = top.to_owned();
    if build.collarbones {
        add(&name("collarbone"), Some(&parent), [x * 0.02, 0.79, 0.02], Some(Role::Shoulder(side)));
        parent = name("collarbone");
    }
    add(&name("upper arm"), Some(&parent), arm(0.0), Some(Role::UpperArm(side)));
    parent = name("upper arm");
    if build.extra {
        add(&name("twist"), Some(&parent), arm(0.1), None);
        parent = name("twist");
    }
    add(&name("lower arm"), Some(&parent), arm(0.17), Some(Role::LowerArm(side)));
    add(&name("hand"), Some(&name("lower arm")), arm(0.32), Some(Role::Hand(side)));
    let knee = 0.04 + 0.46 * (1.0 - build.thigh);
    add(&name("upper leg"), Some("hips"), [x * 0.06, 0.5, 0.0], Some(Role::UpperLeg(side)));
    parent = name("upper leg");
    if build.extra {
        add(&name("thigh"), Some(&parent), [x * 0.06, 0.4, 0.01], None);
        parent = name("thigh");
    }
    add(&name("lower leg"), Some(&parent), [x * 0.06, knee, 0.02], Some(Role::LowerLeg(side)));
    let shin = name("lower leg");
    let foot_parent = if build.loose_feet { "root" } else { shin.as_str() };
    add(&name("foot"), Some(foot_parent), [x * 0.06, 0.04, -0.02], Some(Role::Foot(side)));
    add(&name("toes"), Some(&name("foot")), [x * 0.07, 0.01, 0.07], Some(Role::Toes(side)));
}
