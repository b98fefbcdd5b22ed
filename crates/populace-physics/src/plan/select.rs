//! Selection of the joints that start bodies, and assignment of all other joints to bodies.

use super::names;
use super::rest::Rest;

/// Least distance of a joint from the head of the parent body, relative to the body size, to start
/// a body of its own.
const MIN_SPACING: f32 = 0.1;
/// Like [`MIN_SPACING`], for joints without children.
const MIN_LEAF_SPACING: f32 = 0.12;
/// Length of a bone, relative to the body size, from which it always is a body. Thighs need this,
/// since they start near the joint of the hips.
const LONG_BONE: f32 = 0.18;
/// Least extent of a subtree, relative to the body size, to become a body.
const MIN_EXTENT: f32 = 0.06;
/// Reach of a joint's vertices, relative to the body size, above which it belongs to the trunk.
const TRUNK_REACH: f32 = 0.03;

/// A selected body: its head joint and its parent body.
pub(super) struct SelectedBody {
    pub(super) head: usize,
    pub(super) parent: Option<usize>,
}

/// Returns the bodies, parents first, and the body of each joint.
pub(super) fn select(rest: &Rest) -> (Vec<SelectedBody>, Vec<Option<usize>>) {
    let root = root(rest);
    let mut bodies = vec![SelectedBody { head: root, parent: None }];
    let mut body_of = vec![None; rest.positions.len()];
    body_of[root] = Some(0);
    for joint in 0..rest.positions.len() {
        let Some(parent) = rest.parents[joint].filter(|_| joint != root) else { continue };
        if let Some(body) = body_of[parent] {
            let starts = starts_body(rest, joint, bodies[body].head);
            body_of[joint] = Some(if starts { add(&mut bodies, joint, body) } else { body });
        }
    }
    select_outside(rest, &mut bodies, &mut body_of);
    (bodies, body_of)
}

/// Assigns deforming joints outside the trunk's subtree to the nearest body. Examples are feet that
/// are tied to their legs only by constraints of the modelling program.
fn select_outside(rest: &Rest, bodies: &mut Vec<SelectedBody>, body_of: &mut [Option<usize>]) {
    let inside: Vec<usize> = (0..body_of.len()).filter(|&j| body_of[j].is_some()).collect();
    for joint in 0..body_of.len() {
        if body_of[joint].is_some() {
            continue;
        }
        if let Some(body) = rest.parents[joint].and_then(|p| body_of[p]) {
            let starts = starts_body(rest, joint, bodies[body].head);
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

/// Returns the joint where the trunk starts, skipping joints above it that move no vertices.
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

/// Returns whether a joint starts a body below the one with the head joint `head`.
fn starts_body(rest: &Rest, joint: usize, head: usize) -> bool {
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
