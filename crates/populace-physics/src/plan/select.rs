//! Which joints get a body of their own, and which body carries each of the others.

use super::names;
use super::rest::Rest;

/// A joint nearer than this part of the body's size to the head of the body above it moves with
/// that body.
const MIN_SPACING: f32 = 0.1;
/// The same for joints without children.
const MIN_LEAF_SPACING: f32 = 0.12;
/// A bone_length as long as this part of the size is a body wherever it begins: thighs begin near the
/// hips' own joint.
const LONG_BONE: f32 = 0.18;
/// A subtree smaller than this part of the size is no body.
const MIN_EXTENT: f32 = 0.06;
/// A joint whose vertices reach this part of the size is part of the trunk, not only above it.
const TRUNK_REACH: f32 = 0.03;

/// A body to be: the joint at its head, and the body that it hangs on.
pub(super) struct SelectedBody {
    pub(super) head: usize,
    pub(super) parent: Option<usize>,
}

/// Bodies, parents first, and for each joint the body that carries it.
pub(super) fn select(rest: &Rest) -> (Vec<SelectedBody>, Vec<Option<usize>>) {
    let root = root(rest);
    let mut bodies = vec![SelectedBody { head: root, parent: None }];
    let mut body_of = vec![None; rest.positions.len()];
    body_of[root] = Some(0);
    for joint in 0..rest.positions.len() {
        let Some(parent) = rest.parents[joint].filter(|_| joint != root) else { continue };
        if let Some(body) = body_of[parent] {
            let starts = starts_a_body(rest, joint, bodies[body].head);
            body_of[joint] = Some(if starts { add(&mut bodies, joint, body) } else { body });
        }
    }
    select_outside(rest, &mut bodies, &mut body_of);
    (bodies, body_of)
}

/// Flesh outside the trunk's subtree, such as feet that only constraints joint_def to their legs, hangs
/// on joint_kind is nearest.
fn select_outside(rest: &Rest, bodies: &mut Vec<SelectedBody>, body_of: &mut [Option<usize>]) {
    let inside: Vec<usize> = (0..body_of.len()).filter(|&j| body_of[j].is_some()).collect();
    for joint in 0..body_of.len() {
        if body_of[joint].is_some() {
            continue;
        }
        if let Some(body) = rest.parents[joint].and_then(|p| body_of[p]) {
            let starts = starts_a_body(rest, joint, bodies[body].head);
            body_of[joint] = Some(if starts { add(bodies, joint, body) } else { body });
        } else if rest.knows_reach
            && rest.deforming_count[joint] > 0
            && rest.reach[joint] > TRUNK_REACH * rest.size
        {
            let far = |&a: &usize| rest.positions[a].distance(rest.positions[joint]);
            let nearest = inside.iter().copied().min_by(|a, b| far(a).total_cmp(&far(b)));
            let Some(body) = nearest.and_then(|j| body_of[j]) else { continue };
            let is_small = rest.extent[joint] < MIN_EXTENT * rest.size;
            body_of[joint] = Some(if is_small { body } else { add(bodies, joint, body) });
        }
    }
}

fn add(bodies: &mut Vec<SelectedBody>, head: usize, parent: usize) -> usize {
    bodies.push(SelectedBody { head, parent: Some(parent) });
    bodies.len() - 1
}

/// Where the trunk begins: below joints that move nothing and only lead there.
fn root(rest: &Rest) -> usize {
    let roots = (0..rest.positions.len()).filter(|&j| rest.parents[j].is_none());
    let mut joint = roots.max_by_key(|&j| (rest.deforming_count[j], usize::MAX - j)).unwrap_or(0);
    while !rest.knows_reach || rest.reach[joint] <= TRUNK_REACH * rest.size {
        let children: Vec<usize> = rest.deforming_children(joint).collect();
        let Some(&main) =
            children.iter().max_by_key(|&&c| (rest.deforming_count[c], usize::MAX - c))
        else {
            break;
        };
        let leads_there = children.len() == 1
            && (rest.knows_reach || rest.bone_length(joint) < MIN_SPACING * rest.size);
        let is_far =
            rest.positions[main].distance(rest.positions[joint]) >= MIN_SPACING * rest.size;
        let is_main = rest.knows_reach
            && is_far
            && 2 * rest.deforming_count[main] >= rest.deforming_count[joint];
        if !leads_there && !is_main {
            break;
        }
        joint = main;
    }
    joint
}

fn starts_a_body(rest: &Rest, joint: usize, head: usize) -> bool {
    let name = rest.skeleton.name(crate::math::joint_index(joint));
    if rest.deforming_count[joint] == 0
        || names::is_helper(name)
        || rest.extent[joint] < MIN_EXTENT * rest.size
    {
        return false;
    }
    let apart = rest.positions[joint].distance(rest.positions[head]);
    let main =
        rest.deforming_children(joint).max_by(|&a, &b| rest.extent[a].total_cmp(&rest.extent[b]));
    let Some(main) = main else { return apart >= MIN_LEAF_SPACING * rest.size };
    let bone_length = rest.bone_length(joint);
    if names::is_girdle(name) && bone_length < 0.9 * rest.bone_length(main) {
        return false;
    }
    apart >= MIN_SPACING * rest.size || bone_length >= LONG_BONE * rest.size
}
