//! Where bodies hold and wear things. The built-in people have places of their own; on other bodies
//! they follow from humanoid roles, and from the part of the mesh that moves with a hand or the head.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace::character::Character;
use populace::clip::Clip;
use populace::model::{Role, RoleMap, Side};
use populace::retarget::Binding;
use populace::{JointIndex, Trs};
use populace_props::PARCEL_WIDTH_M;

/// A joint, and `joint_from_prop`.
pub(crate) type Grip = (JointIndex, Trs);

/// How far a thing's place is out of the palm, as a fraction of its distance from the wrist: the fist's
/// axis, and a phone.
const FIST_OUT: f64 = 0.34;
const PHONE_OUT: f64 = 0.26;
/// Distance of a phone from the wrist, as a fraction of that of the fist: at the ear, and to read.
const PHONE_AHEAD: [f64; 2] = [0.75, 0.95];
/// Distance of the fist from the wrist, as a fraction of the forearm: the least and the most, and
/// that of a hand without a mesh.
const FIST_AHEAD: [f64; 2] = [0.15, 0.6];
const USUAL_FIST_AHEAD: f64 = 0.4;
/// How far the underside of a carried box is beneath the palms, as a fraction of the body's height.
const UNDER_PALMS: f64 = 0.045;
/// Part of a head above its joint, and height of the middle of the skull above the joint, as fractions
/// of its height from chin to crown.
const ABOVE_JOINT: f64 = 0.8;
const SKULL: f64 = 0.38;
/// Height in metres of the head for which helmets are made, from chin to crown.
const ADULT_HEAD_M: f64 = 0.235;

/// The places of a body for things.
#[derive(Clone, Debug)]
pub(crate) struct Grips {
    pub(crate) helmet: Option<Grip>,
    /// What a fist holds.
    pub(crate) left: Option<Grip>,
    pub(crate) right: Option<Grip>,
    /// A phone in the right hand: at the ear, and to read.
    pub(crate) phones: [Option<Grip>; 2],
    /// A parcel between both hands, for those who play the clip of carrying.
    pub(crate) parcel: Option<Grip>,
}

impl Grips {
    /// Returns the places of a body. `carry` is its clip of carrying.
    pub(crate) fn new(body: &Character, roles: Option<&RoleMap>, carry: Option<&Clip>) -> Self {
        let by_roles = roles.map(|roles| ByRoles { body, roles });
        let fist = |own: Option<Grip>, side| own.or_else(|| by_roles.as_ref()?.fist(side));
        let phone = |own: Option<Grip>, nth| own.or_else(|| by_roles.as_ref()?.phone(nth));
        Self {
            helmet: populace_cast::helmet(body).or_else(|| by_roles.as_ref()?.helmet()),
            left: fist(populace_cast::grip(body, populace_cast::Side::Left), Side::Left),
            right: fist(populace_cast::grip(body, populace_cast::Side::Right), Side::Right),
            phones: [
                phone(populace_cast::phone_at_ear(body), 0),
                phone(populace_cast::phone_to_read(body), 1),
            ],
            parcel: populace_cast::carried(body, PARCEL_WIDTH_M)
                .or_else(|| by_roles.as_ref()?.parcel(carry?)),
        }
    }
}

/// A body with humanoid roles, which faces +Z.
struct ByRoles<'a> {
    body: &'a Character,
    roles: &'a RoleMap,
}

/// A hand at rest, in model space.
struct Hand {
    wrist: JointIndex,
    at: DVec3,
    /// To the fingers, and out of the back of the hand.
    along: DVec3,
    back: DVec3,
    /// Distance from the wrist to the middle of the hand.
    middle_m: f64,
}

impl ByRoles<'_> {
    /// Returns where a fist holds things. Axes are those of [`populace_cast::grip`].
    fn fist(&self, side: Side) -> Option<Grip> {
        let hand = self.hand(side)?;
        let axes = DMat3::from_cols(DVec3::Z.cross(hand.back), DVec3::Z, hand.back);
        self.place(hand.wrist, hand.at_fist(), axes, 1.0)
    }

    fn phone(&self, nth: usize) -> Option<Grip> {
        let hand = self.hand(Side::Right)?;
        let at = hand.at + hand.along * PHONE_AHEAD[nth] * hand.middle_m
            - hand.back * PHONE_OUT * hand.middle_m;
        let up = [hand.along, (hand.along + DVec3::Z).normalize()][nth];
        let axes = DMat3::from_cols(up.cross(-hand.back), up, -hand.back);
        self.place(hand.wrist, at, axes, 1.0)
    }

    fn helmet(&self) -> Option<Grip> {
        let head = self.roles.joint(Role::Head)?;
        let joint = self.rest(head)?.translation;
        let skin = self.skin_of(head);
        let crown = skin.iter().map(|p| p.y).reduce(f64::max)?;
        let [back, front] = [f64::min, f64::max].map(|f| skin.iter().map(|p| p.z).reduce(f));
        let size = (crown - joint.y) / ABOVE_JOINT;
        if size <= 0.0 {
            return None;
        }
        let middle = DVec3::new(joint.x, joint.y + SKULL * size, 0.5 * (back? + front?));
        self.place(head, middle, DMat3::IDENTITY, size / ADULT_HEAD_M)
    }

    /// Returns where a parcel is between the hands in the first pose of the clip, upright.
    fn parcel(&self, carry: &Clip) -> Option<Grip> {
        let skeleton = &self.body.skeleton;
        let of_clip = RoleMap::detect(carry.skeleton());
        let binding = Binding::fitting(carry, of_clip.as_ref(), skeleton, Some(self.roles)).ok()?;
        let clip = binding.converted().map_or(carry, |converted| &converted.clip);
        let mut models: Vec<DAffine3> = Vec::new();
        for (joint, local) in skeleton.joints().zip(clip.row_poses(1).next()?) {
            let above = skeleton.parent(joint).and_then(|parent| models.get(parent.index()));
            models.push(above.map_or(local, |above| *above * local));
        }
        let chest = [Role::UpperChest, Role::Chest, Role::Spine];
        let chest = chest.into_iter().find_map(|role| self.roles.joint(role))?;
        let [left, right] = [Side::Left, Side::Right].map(|side| {
            let hand = self.hand(side)?;
            let posed = *models.get(hand.wrist.index())? * self.rest(hand.wrist)?.inverse();
            // In the palm, not on the axis of a fist.
            Some(posed.transform_point3(hand.at + hand.along * hand.middle_m))
        });
        let (left, right) = (left?, right?);
        let height_m = f64::from(self.body.height_m());
        let underside = 0.5 * (left + right) - DVec3::Y * UNDER_PALMS * height_m;
        let size = left.distance(right) / f64::from(PARCEL_WIDTH_M);
        let model = models.get(chest.index())?;
        let parcel = DAffine3::from_scale_rotation_translation(
            DVec3::splat(size),
            DQuat::IDENTITY,
            underside,
        );
        Some((chest, trs(model.inverse() * parcel)))
    }

    fn hand(&self, side: Side) -> Option<Hand> {
        let [elbow, wrist] =
            [Role::LowerArm(side), Role::Hand(side)].map(|role| self.roles.joint(role));
        let (elbow, wrist) = (self.rest(elbow?)?.translation, wrist?);
        let at = self.rest(wrist)?.translation;
        let along = (at - elbow).try_normalize()?;
        let forearm_m = at.distance(elbow);
        // Things that a mesh has in its hand, such as a staff, reach far from it.
        let skin = self.skin_of(wrist).into_iter().filter(|p| p.distance(at) < forearm_m);
        let mut ahead: Vec<f64> = skin.map(|p| (p - at).dot(along)).collect();
        ahead.sort_by(f64::total_cmp);
        let [least, most] = FIST_AHEAD.map(|part| part * forearm_m);
        let middle_m = match ahead.get(ahead.len() / 2) {
            Some(middle) => middle.clamp(least, most),
            None => USUAL_FIST_AHEAD * forearm_m,
        };
        // At rest thumbs are forward, and arms in the plane of the body or lower.
        let sign = if side == Side::Left { 1.0 } else { -1.0 };
        let back = (DVec3::Z.cross(along) * sign).try_normalize()?;
        Some(Hand { wrist, at, along, back, middle_m })
    }

    fn rest(&self, joint: JointIndex) -> Option<DAffine3> {
        self.body.skeleton.rest_models().get(joint.index()).copied()
    }

    /// Returns the vertices that move with a joint or those below it most, in model space at rest.
    fn skin_of(&self, joint: JointIndex) -> Vec<DVec3> {
        let skeleton = &self.body.skeleton;
        let moves: Vec<bool> = self
            .body
            .palette
            .iter()
            .map(|entry| entry.joint == joint || skeleton.is_below(entry.joint, joint))
            .collect();
        let mut found = Vec::new();
        for (nth, part) in self.body.parts.iter().enumerate() {
            let influences = &part.mesh.influences;
            let vertices = self.body.rest_positions(nth).into_iter().enumerate();
            found.extend(vertices.filter_map(|(vertex, place)| {
                let of_vertex =
                    influences.per_vertex * vertex..influences.per_vertex * (vertex + 1);
                let entries = influences.entries[of_vertex.clone()].iter();
                let strongest =
                    entries.zip(&influences.weights[of_vertex]).max_by(|a, b| a.1.total_cmp(b.1));
                let is_moved = strongest.is_some_and(|(entry, _)| moves[usize::from(*entry)]);
                is_moved.then(|| DVec3::from(place.map(f64::from)))
            }));
        }
        found
    }

    /// Returns a joint, and a place of model space at rest relative to it.
    fn place(&self, joint: JointIndex, at: DVec3, axes: DMat3, size: f64) -> Option<Grip> {
        let prop = DAffine3 { matrix3: axes * size, translation: at };
        Some((joint, trs(self.rest(joint)?.inverse() * prop)))
    }
}

impl Hand {
    /// Returns the middle of the fist's axis.
    fn at_fist(&self) -> DVec3 {
        self.at + (self.along - self.back * FIST_OUT) * self.middle_m
    }
}

fn trs(transform: DAffine3) -> Trs {
    let (scale, rotation, translation) = transform.to_scale_rotation_translation();
    Trs {
        translation: translation.as_vec3().to_array(),
        rotation: rotation.as_quat().normalize().to_array(),
        scale: scale.as_vec3().to_array(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use populace::character::{CharacterSource, Influences};
    use populace::model::{JointSource, Skeleton};
    use populace_cast::{Look, person};

    /// Returns the same body with joints of other names, so that it passes for somebody else.
    fn stranger(body: &Character) -> Character {
        let mut source = CharacterSource::clone(body);
        let joint = |joint: JointIndex| JointSource {
            name: format!("other_{}", body.skeleton.name(joint)),
            parent: body.skeleton.parent(joint).map(JointIndex::index),
            rest: *body.skeleton.rest(joint),
        };
        let joints: Vec<JointSource> = body.skeleton.joints().map(joint).collect();
        source.skeleton = Skeleton::new(&joints).unwrap();
        source.clips.clear();
        Character::new(source).unwrap()
    }

    /// Returns a grip in model space at rest.
    fn at_rest(body: &Character, grip: Option<Grip>) -> DAffine3 {
        let (joint, Trs { translation, rotation, scale }) = grip.unwrap();
        let local = DAffine3::from_scale_rotation_translation(
            DVec3::from(scale.map(f64::from)),
            DQuat::from_array(rotation.map(f64::from)),
            DVec3::from(translation.map(f64::from)),
        );
        body.skeleton.rest_models()[joint.index()] * local
    }

    #[test]
    fn other_bodies_hold_things_where_the_built_in_people_do() {
        let man = person(&Look::man()).unwrap();
        let other = stranger(&man);
        let roles = RoleMap::detect(&man.skeleton).unwrap();
        let carry = man.clips.iter().find(|clip| clip.name() == "Carry").unwrap();
        let own = Grips::new(&man, None, Some(carry));
        let found = Grips::new(&other, Some(&roles), Some(carry));
        assert!(
            populace_cast::helmet(&other).is_none(),
            "it passes for one of the built-in people"
        );
        for (what, own, found) in [
            ("helmet", own.helmet, found.helmet),
            ("left", own.left, found.left),
            ("right", own.right, found.right),
            ("phone at the ear", own.phones[0], found.phones[0]),
            ("phone to read", own.phones[1], found.phones[1]),
            ("parcel", own.parcel, found.parcel),
        ] {
            let [a, b] = [at_rest(&man, own), at_rest(&other, found)];
            let apart_m = a.translation.distance(b.translation);
            let cos = a.matrix3.x_axis.angle_between(b.matrix3.x_axis).cos();
            let size = b.matrix3.x_axis.length() / a.matrix3.x_axis.length();
            assert!(apart_m < 0.035 && cos > 0.99, "{what}: {apart_m} m, {cos}");
            assert!((0.85..1.2).contains(&size), "{what}: {size}");
        }
    }

    #[test]
    fn a_staff_in_the_hand_does_not_move_the_fist() {
        let man = person(&Look::man()).unwrap();
        let mut source = CharacterSource::clone(&stranger(&man));
        let bare = Character::new(source.clone()).unwrap();
        let roles = RoleMap::detect(&man.skeleton).unwrap();
        let wrist = roles.joint(Role::Hand(Side::Right)).unwrap();
        let is_of_hand: Vec<bool> = source
            .palette
            .iter()
            .map(|e| e.joint == wrist || bare.skeleton.is_below(e.joint, wrist))
            .collect();
        let mut moved = 0;
        for mesh in source.parts.iter_mut().map(|part| &mut part.mesh) {
            let Influences { per_vertex, entries, .. } = &mesh.influences;
            let firsts = entries.iter().step_by(*per_vertex);
            for (nth, (place, entry)) in mesh.positions.iter_mut().zip(firsts).enumerate() {
                if is_of_hand[usize::from(*entry)] && nth % 3 > 0 {
                    place[1] -= 1.0;
                    moved += 1;
                }
            }
        }
        assert!(moved > 20, "{moved}");
        let armed = Character::new(source).unwrap();
        let fist = |body: &Character| {
            at_rest(body, Grips::new(body, Some(&roles), None).right).translation
        };
        assert!(fist(&bare).distance(fist(&armed)) < 0.03);
    }
}
