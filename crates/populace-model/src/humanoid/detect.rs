//! Detection of roles by joint names.

use std::collections::HashMap;

use super::names::Name;
use super::schemes::{ALL, Scheme};
use super::{NEEDED, Role, RoleMap, Side};
use crate::role::all_roles;
use crate::{JointIndex, Skeleton};

impl RoleMap {
    /// Detects roles by joint names. Of all known namings it uses the one that finds the most
    /// roles. Returns `None` if no naming finds hips, legs with feet, arms and a joint of the back
    /// or head, each in a valid position of the hierarchy.
    #[must_use]
    pub fn detect(skeleton: &Skeleton) -> Option<Self> {
        let mut best: Option<Self> = None;
        for scheme in &ALL {
            let found = by_scheme(skeleton, scheme);
            if let Some(map) =
                found.filter(|map| best.as_ref().is_none_or(|b| b.joints.len() < map.joints.len()))
            {
                best = Some(map);
            }
        }
        best
    }
}

/// Returns the best map of a naming: some namings have several candidates for the hips.
fn by_scheme(skeleton: &Skeleton, scheme: &Scheme) -> Option<RoleMap> {
    let mut names = Names::new();
    for joint in skeleton.joints() {
        names.entry(Name::of(skeleton.name(joint), scheme.drop)).or_default().push(joint);
    }
    let maps = candidates(&names, scheme, Role::Hips)
        .into_iter()
        .map(|hips| assign_roles(skeleton, scheme, &names, hips));
    let mut maps: Vec<RoleMap> = maps.filter(is_humanoid).collect();
    maps.sort_by_key(|map| std::cmp::Reverse(map.joints.len()));
    maps.into_iter().next()
}

fn is_humanoid(map: &RoleMap) -> bool {
    let sides = [Side::Left, Side::Right];
    let arms = sides.into_iter().flat_map(|side| [Role::UpperArm(side), Role::LowerArm(side)]);
    let back = [Role::Spine, Role::Chest, Role::UpperChest, Role::Head];
    NEEDED.into_iter().chain(arms).all(|role| map.joint(role).is_some())
        && back.into_iter().any(|role| map.joint(role).is_some())
}

/// The joints of each name, in level order. A file may hold many bodies.
type Names = HashMap<Name, Vec<JointIndex>>;

/// Returns the joints whose names fit a role, most likely first.
fn candidates(names: &Names, scheme: &Scheme, role: Role) -> Vec<JointIndex> {
    matching(names, &scheme.names_of(role), role)
}

fn matching(names: &Names, wanted: &[String], role: Role) -> Vec<JointIndex> {
    let named = |key: &String| names.get(&Name { side: role.side(), key: key.clone() });
    wanted.iter().filter_map(named).flatten().copied().collect()
}

/// Finds all roles below these hips.
fn assign_roles(skeleton: &Skeleton, scheme: &Scheme, names: &Names, hips: JointIndex) -> RoleMap {
    let mut map = RoleMap::empty(skeleton, scheme.name);
    map.joints.insert(Role::Hips, hips);
    for role in all_roles().filter(|role| *role != Role::Hips) {
        let free = |j: &JointIndex| map.joints.values().all(|taken| taken != j);
        let fits = |j: &JointIndex| free(j) && map.check(skeleton, role, *j).is_ok();
        if let Some(joint) = candidates(names, scheme, role).into_iter().find(fits) {
            map.joints.insert(role, joint);
        }
    }
    for (role, also) in scheme.also {
        for role in [Side::Left, Side::Right].map(|side| role.on(side)) {
            let wanted: Vec<String> = also.iter().map(|&name| name.to_owned()).collect();
            let joints = matching(names, &wanted, role).into_iter();
            let others =
                joints.filter(|j| map.joints.values().all(|taken| taken != j)).map(|j| (role, j));
            map.followers.extend(others.collect::<Vec<_>>());
        }
    }
    map
}
