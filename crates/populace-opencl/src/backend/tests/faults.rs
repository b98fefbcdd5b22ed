//! Single faults in the kernels' text, each of which a named check of the conformance suite must
//! catch. A check that passes with its fault does not exercise what it claims to.
//!
//! Each fault costs a build of a program, so all are ignored by default:
//! `cargo test -p populace-opencl --lib faults -- --ignored`.

use std::panic::{AssertUnwindSafe, catch_unwind};

use populace_testkit::conformance::*;

use super::*;
use crate::program::GroupShape;

/// Fails unless `check` notices that `right`, which the text of the form holds once, reads `wrong`.
fn caught(form: Form, right: &str, wrong: &str, check: fn(&mut dyn Backend)) {
    let source = form.source("");
    assert_eq!(source.matches(right).count(), 1, "the kernels' text holds this once: {right}");
    // A device of its own, since devices keep their programs.
    let device = OpenClDevice::open(0).unwrap();
    let program = device.build(&source.replacen(right, wrong, 1)).unwrap();
    device.programs.lock().unwrap().insert((form, String::new()), program);
    let (schedule, lanes) = match form {
        Form::Wide { lanes } => (Schedule::FusedWide, lanes),
        Form::Grouped(_) => (Schedule::FusedGrouped, GPU_SHAPE.lanes),
        _ => (Schedule::Staged, GPU_SHAPE.lanes),
    };
    let shape = DispatchShape { lanes, ..DispatchShape::of(&device).unwrap() };
    let mut backend = OpenClBackend::with_shape(&device, schedule, shape).unwrap();
    let result = catch_unwind(AssertUnwindSafe(|| check(&mut backend)));
    let cause = result.expect_err("the check must notice the fault");
    let said = cause.downcast_ref::<String>().map_or("", String::as_str);
    assert!(said.contains("off by"), "it failed for another reason: {said}");
}

macro_rules! faults {
    (
        $form:expr, $texts:ident;
        $($check:ident { $($name:ident: $right:literal => $wrong:literal;)* })*
    ) => {
        /// The text of each fault is where the kernels have it.
        #[test]
        fn $texts() {
            let source = $form.source("");
            let faults = [$($((stringify!($name), $right),)*)*];
            for (fault, right) in faults {
                assert_eq!(source.matches(right).count(), 1, "{fault}: {right}");
            }
        }

        $($(
            #[ignore = "a build of the kernels for each fault; make test-long runs all"]
            #[test]
            fn $name() {
                caught($form, $right, $wrong, $check);
            }
        )*)*
    };
}

faults! {
    Form::Staged, staged_kernels_have_the_text_of_each_fault;
    check_clock {
        loops_ignore_their_phase:
            "((ulong)slot.start_phase << 32) + elapsed * slot.phase_rate" =>
            "elapsed * slot.phase_rate";
        clips_that_play_once_go_on: "if (mul_hi(elapsed, rate) != 0)" => "if (false)";
    }
    check_weights {
        ramps_do_not_end: "(rising && weight > end)" => "(rising && weight > 1e9f)";
        ramps_do_not_begin: "start + rate * ((float)elapsed_ticks * TICK_SECS)" => "end";
    }
    check_sampling_between_keys {
        rows_change_their_weights:
            "((uint)ROW_PARTS - second) | second << 16" =>
            "second | ((uint)ROW_PARTS - second) << 16";
        odd_components_read_the_low_half:
            "((int)from >> 16) * (int)(weights & 0xffffu)" =>
            "((int)(from << 16) >> 16) * (int)(weights & 0xffffu)";
    }
    check_blends {
        means_are_not_divided:
            "sum.terms.unweighted ? 1.0f : 1.0f / sum.terms.total" => "1.0f";
        translations_are_not_weighted:
            "vec3_scale(trs.t, weight)" => "trs.t";
        scales_are_not_weighted: "vec3_scale(trs.s, weight)" => "trs.s";
    }
    check_small_totals {
        small_totals_are_divided:
            "sum.terms.total > least ? mean_of(sum, rest) : rest" => "mean_of(sum, rest)";
    }
    check_override_layers {
        masks_do_not_count:
            "layer.weight * LOAD(tables->masks + mask + joint)" => "(Real)(layer.weight)";
        weak_layers_cover_all: "layer_weight * (total < 1.0f ? total : 1.0f)" => "layer_weight";
    }
    check_far_rotations {
        layers_turn_the_long_way: "quat_hemisphere(beneath, rest)" => "beneath";
    }
    check_additive_layers {
        differences_are_reversed:
            "quotient(normalized(sample, rest), first," =>
            "quotient(first, normalized(sample, rest),";
        additions_turn_in_the_parent:
            "quat_mul(beneath, quat_normalize_or(changed, quat_identity()))" =>
            "quat_mul(quat_normalize_or(changed, quat_identity()), beneath)";
        scales_are_added:
            "beneath.y * (1.0f + sum.y * layer_weight)" =>
            "beneath.y + sum.y * layer_weight";
        differences_turn_in_the_parent:
            "quat_mul(quat_conjugate(reference.r), value.r)" =>
            "quat_mul(value.r, quat_conjugate(reference.r))";
        ratios_are_not_divided: "return divides ? value / reference" => "return divides ? value";
    }
    check_inertialization {
        velocities_take_the_near_row: "at - (float)row >= 0.5f" => "at - (float)row < 0.5f";
        poses_decay_too_fast:
            "6.0f * inertialized * inertialized" =>
            "5.0f * inertialized * inertialized";
        velocities_decay_too_fast:
            "inertialized * cube * (1.0f + 3.0f * inertialized)" => "inertialized * cube";
        shares_do_not_change: "moving * slot.share_change" => "0.0f";
        velocities_turn_beneath: "far = after(far, at);" => "far = after(at, far);";
        incoming_velocities_stay: "local_add(sum, local_less(outgoing, left))" =>
            "local_add(sum, outgoing)";
    }
    check_transform_alone {
        rotations_are_transposed:
            "m[1] = (2.0f * (x * y - w * z))" => "m[1] = (2.0f * (x * y + w * z))";
        scales_stretch_rows: "(2.0f * (x * z + w * y)) * trs.s.z" =>
            "(2.0f * (x * z + w * y)) * trs.s.x";
    }
    check_write_back_alone {
        bind_rows_are_swapped:
            "affine_mul_rows(model_from_joint, entry.row0, entry.row1, entry.row2)" =>
            "affine_mul_rows(model_from_joint, entry.row0, entry.row2, entry.row1)";
    }
    check_gaze {
        pitch_is_not_relative:
            "start.level * height - start.up * level" => "start.level * height + start.up * level";
        left_is_taken_for_right: "yaw < (Real)(0.0f) ? -kept : kept" => "kept";
        gaze_does_not_return_from_behind:
            "behind = 0.5f * (limit + HALF_TURN)" => "behind = HALF_TURN";
        steep_targets_turn_sideways: "seen.level * (1.0f / GAZE_STEEP)" => "(Real)(1.0f)";
        gaze_has_no_lower_limit: "(raised < least ? least : raised)" => "raised";
        gaze_has_no_upper_limit: "raised = up > most ? most : up" => "raised = up";
        last_target_alone_counts:
            "yaw += counts ? to_side : none" =>
            "yaw = counts ? to_side : yaw";
        angles_are_not_divided: "const Real k = 1.0f / total;\n    sin_cos" =>
            "const Real k = 1.0f;\n    sin_cos";
        gaze_ignores_weights:
            "*weight = total < (Real)(1.0f) ? total : (Real)(1.0f);" => "*weight = 1.0f;";
        shares_do_not_add_up: "shared += takes_part ? share : (Real)(0.0f);" => "shared = share;";
        eyes_stay_behind: "aim(&g, place, &weight_there)" =>
            "aim(&g, g.end, &weight_there)";
        necks_do_not_carry: "quat_rotated(so_far, vec3_add_scaled(next, posed, -1.0f))" =>
            "vec3_add_scaled(next, posed, -1.0f)";
        gaze_forgets_its_carrier:
            "matrix_transform_vector(&parent, above)" => "above";
        yaw_is_reversed: "start.front * to.left - start.left * to.front" =>
            "start.left * to.front - start.front * to.left";
        headings_are_reversed:
            "vec(cosine * d.x - sine * d.z, d.y, sine * d.x + cosine * d.z)" =>
            "vec(cosine * d.x + sine * d.z, d.y, cosine * d.z - sine * d.x)";
        targets_do_not_ease: "w * w * (3.0f - 2.0f * w)" => "w";
        targets_begin_early: "tick > target.weight_tick ? tick - target.weight_tick : 0" =>
            "tick - target.weight_tick";
    }
    check_limbs {
        limbs_straighten_at_once: "far = length - length * soft" => "far = length";
        limbs_fold_at_once: "near = least + (length - least) * soft" => "near = least";
        limbs_ease_by_a_clamp: "room * over / (room + over)" => "over < room ? over : room";
        limbs_fold_to_nothing:
            "soft_distance(distance, a + b, longer - shorter, soft)" =>
            "soft_distance(distance, a + b, 0.0f, soft)";
        limbs_have_no_preferred_bend: "LIMB_OWN_BEND), chain)" => "0.0f), chain)";
        limbs_bend_the_other_way: "const Real s = square_root((1.0f - c)" =>
            "const Real s = -square_root((1.0f - c)";
        limbs_forget_the_hinge: "* 0.5f * nn - still) * k" => "* 0.5f * nn) * k";
        poles_are_not_across: "vec3_across(pole, ahead)" => "pole";
        poles_do_not_count:
            "quat_choose(has_pole, quat_mul(pole_rotation(limb, first, axis, pole), first), first)"
            => "first";
        middles_bend_about_the_old_axis:
            "vec3_scale(quat_rotated(first, axis), x * half_unit)" =>
            "vec3_scale(axis, x * half_unit)";
        ends_do_not_keep: "PUT(keeps_end, lane, reach->keeps_end ? 1.0f : 0.0f);" => "";
        ends_are_undone_in_the_wrong_order: "quat_conjugate(quat_mul(second, first))" =>
            "quat_conjugate(quat_mul(first, second))";
        limbs_ignore_weights: "quat_choose(partly, quat_part(rotation, weight), rotation)" =>
            "rotation";
        places_have_no_scale: "direction_to_model(control, d) * (1.0f / control->place.w)" =>
            "direction_to_model(control, d)";
        goals_are_not_weighted: "sum = add_scaled(sum, place, own);" =>
            "sum = add_scaled(sum, place, 1.0f);";
    }
    check_chains {
        rotations_move_joints: "    result.s7 = m.s7;\n" => "";
        chains_stop_early: "pass < CHAIN_PASSES" => "pass < 1u";
        chains_leave_their_root: "        point = start;\n" => "";
        chains_turn_twice: "rotation_mul(rotation, rotated_by)" =>
            "rotation_mul(rotated_by, rotation)";
        chains_ignore_weights: "part_of(rotation_between(was, is, any_across(is)), weight)" =>
            "rotation_between(was, is, any_across(is))";
        chains_are_not_soft: "soft_distance(distance, total, 0.0f, c.constraint->limits.x)" =>
            "distance";
        directions_end_near: "direction_to_model(s->control, point), TARGET_FAR_M)" =>
            "direction_to_model(s->control, point), 1.0f)";
    }
    check_machines {
        transitions_are_taken_in_fades: "bool taken = elapsed < at.fade_ticks;" =>
            "bool taken = false;";
        last_transitions_are_taken: "i < state.transition_count && !taken; i++" =>
            "i < state.transition_count; i++";
        last_conditions_decide: "c < transition.condition_count && taken; c++" =>
            "c < transition.condition_count; c++";
        limits_count_as_above: "parameters[condition.parameter] > condition.value" =>
            "parameters[condition.parameter] >= condition.value";
        limits_count_as_below: "parameters[condition.parameter] < condition.value" =>
            "parameters[condition.parameter] <= condition.value";
        times_end_a_tick_late: "return elapsed >= condition.ticks;" =>
            "return elapsed > condition.ticks;";
        machines_keep_earlier_owners: "if (at.epoch != machine_instance.epoch)" =>
            "if (at.epoch == 0)";
        states_forget_when_they_were_entered: "at.previous_tick = at.entry_tick;" =>
            "at.previous_tick = tick;";
        states_that_fade_out_start_again:
            "is_current ? at.entry_tick : at.previous_tick;" => "at.entry_tick;";
        states_ignore_their_phase: "now.start_phase = state.start_phase;" =>
            "now.start_phase = 0;";
        states_fade_at_the_machine_rate: "rate = whole * at.fade_rate;" => "rate = at.fade_rate;";
        machines_have_half_their_weight: "whole = 2.0f * weight," => "whole = weight,";
        cuts_begin_at_nothing: "is_current && rate > 0.0f ? 0.0f : whole" =>
            "is_current ? 0.0f : whole";
    }
    check_feet {
        feet_do_not_lock: "lock.planted = stands & !lets_go;" => "lock.planted = stands & 0;";
        feet_never_let_go: "const Choice lets_go = is_behind |" => "const Choice lets_go = 0 &";
        feet_lock_again_at_once: "const Real relock = FOOT_RELOCK * most;" =>
            "const Real relock = most;";
        feet_sink_pelvises: "| (with_offset > leg - above * above);" => "| 0;";
        feet_never_settle: "(in->stood_secs >= (Real)(FOOT_SETTLE_SECS)) &" => "0 &";
        feet_that_settle_slide: "? lift : none);" => "? none : none);";
        feet_stay_behind_their_clips: "state->x - pivot.x : state->x * decay" =>
            "state->x - pivot.x : state->x";
        offsets_have_no_limit: "vec3_choose(far > most * most, shorter, vector)" => "vector";
        members_never_go_elsewhere: "*elsewhere = far > 4.0f * most * most;" => "*elsewhere = 0;";
        feet_keep_their_first_pivot: "(stepped->ankle.y + kept_arm.y <=" =>
            "(-1e9f + kept_arm.y <=";
        feet_do_not_keep_their_heading: "cross / (1.0f + dot) : none" => "none : none";
        strides_have_no_direction: "at.x + stride * with.x" => "at.x";
        strides_do_not_turn: "turn_of(with.z * stride)" => "turn_of(0.0f * stride)";
        feet_come_down_at_once: "part * part * (3.0f - 2.0f * part)" => "part";
        feet_in_the_air_drag: "clearance * (1.0f - near) : none" => "none : none";
        feet_do_not_lean: "quat_part(quat_normalize_or(tilt, quat_identity()), near)" =>
            "quat_identity()";
        soles_lie_in_the_ground: "under->level = larger(under->level, ground - above);" => "";
        soles_tilt_over_edges: "under->on_edge | (off * off > edge * edge)" =>
            "under->on_edge";
        feet_do_not_look_ahead: "return ground + rise * (1.0f - near);" => "return ground;";
        feet_climb_at_any_speed: "stopping < fastest ? stopping : fastest" => "stopping";
        climbs_do_not_end_at_rest: "square_root(2.0f * FOOT_CLIMB_GAIN * far)" =>
            "square_root(4.0f * FOOT_CLIMB_GAIN * far)";
        feet_that_stand_rise_with_the_ground: "const Choice stays = planted & stood &" =>
            "const Choice stays = 0 &";
        contacts_do_not_wrap: "away = away > 0.5f * cycle_secs ? fabs(cycle_secs - away) : away;" =>
            "";
        contacts_have_no_weight: "stands[foot] ? none : weight * near;" =>
            "stands[foot] ? none : near;";
        stands_count_as_steps: "CONTACT_WHOLE * duration_secs" => "2.0f * duration_secs";
        pelvises_rise_at_once: "elapsed_secs / (elapsed_secs + PELVIS_RISE_SECS)" => "1.0f";
        pelvises_sink_too_far: "length * (1.0f - legs->soft), most = length * MAX_PELVIS_SINK" =>
            "length * (0.99f - legs->soft), most = length * MAX_PELVIS_SINK";
    }
    check_live_clips {
        streams_have_no_delay: "shown = tick > delay ? tick - delay : 0" => "shown = tick";
        rings_wrap_a_row_early: "(behind > clip.newest_row ? clip.ring_rows : 0)" =>
            "(behind > clip.newest_row ? clip.ring_rows - 1 : 0)";
        newest_rows_are_a_step_away: "older > 0 ? clip.per_row_tick : clip.per_newest_tick" =>
            "clip.per_row_tick";
        streams_show_what_was_overwritten: "if (behind > oldest || behind == 0)" =>
            "if (behind > oldest + 1 || behind == 0)";
        streams_jump_from_row_to_row: "*between = (float)(uint)past *" =>
            "*between = 0.0f *";
        streams_play_backwards: "(behind - 1) * clip.row_ticks - older :" =>
            "older % clip.row_ticks :";
        streams_stop_late: "behind == 0 ? 0 : oldest" => "oldest";
    }
    check_overrides {
        overrides_have_no_weight: "weight >= 1.0f ? to : part_of_the_way(own, to, weight)" => "to";
        overrides_do_not_scale: "1.0f + (new / old - 1.0f) * k" => "1.0f";
        overrides_move_at_once: "m.s7 = from.s7 + (to.s7 - from.s7) * k;" => "m.s7 = to.s7;";
        overrides_turn_one_axis: "part_of(rotation_mul(second, first), k)" => "part_of(first, k)";
        local_overrides_turn_the_long_way: "quat_hemisphere(there.r, trs.r), t4.w)" =>
            "there.r, t4.w)";
    }
    check_attachments {
        attachments_have_no_offset:
            "affine_mul(parent, given_transform(s->tables->overrides[step.operand]))" => "parent";
        carried_joints_are_in_the_world:
            "case STEP_CARRY: keep_watched(s, step.index, own);" =>
            "case STEP_CARRY: keep_watched(s, step.index, affine_mul(world_from_model(s), own));";
        watched_joints_have_no_offset:
            "vec(a.w + point.x, rows[1].w + point.y, rows[2].w + point.z)" =>
            "vec(a.w, rows[1].w, rows[2].w)";
        watched_joints_have_no_scale: "const float sine = s->control->sine * place.w, cosine" =>
            "const float sine = s->control->sine, cosine";
    }
}

faults! {
    Form::Wide { lanes: 8 }, wide_kernels_have_the_text_of_each_fault;
    check_growth {
        small_groups_write_one_palette:
            "to[lane] + first, streamed" => "to[0] + first, streamed";
    }
    check_override_layers {
        palettes_do_not_wait: "entries[e].joint < joint_end" => "true";
        layers_at_rest_do_not_cover:
            "own : own & *at_rest" => "own : own";
        lone_layers_have_whole_weight: "shown->terms.total = slots.total" =>
            "shown->terms.total = 1.0f";
        lone_layers_scale_as_they_move: "shown->own.s = vector_alone(tables, slot, SCALE)" =>
            "shown->own.s = vector_alone(tables, slot, TRANSLATION)";
    }
    check_additive_layers {
        additions_do_not_move: "*at_rest &= kept;" => "";
        changes_in_lanes_are_reversed:
            "quat_mul(quat_conjugate(first.r), unit_rotation(tables, slot, rest))" =>
            "quat_mul(quat_conjugate(unit_rotation(tables, slot, rest)), first.r)";
        turns_in_lanes_are_not_weighted: "quat_scale(change.r, slot.weight)" => "change.r";
        scales_in_lanes_are_not_weighted: "vec3_scale(s, slot.weight)" => "s";
        changes_begin_at_rest:
            "stored_pose(slot.planes, FIRST_POSE_PLANE)" => "stored_pose(rest, 0)";
    }
    check_small_totals {
        small_totals_are_mixed: "sum.terms.total > LEAST_TOTAL" => "sum.terms.total > 0.5f";
        lone_slots_need_no_weight: "0.0f && weight > LEAST_TOTAL" => "0.0f && weight > 0.0f";
    }
    check_far_rotations {
        far_rotations_count_as_near: "return flags & NEAR_REST ? near_unit_of(q)" =>
            "return true ? near_unit_of(q)";
        poses_beneath_count_as_near: "laid_rotation(beneath.r, *at_rest & NEAR_REST" =>
            "laid_rotation(beneath.r, true";
    }
    check_sampling_between_keys {
        lone_scales_are_translations: "first->s = vector_alone(tables, slot, SCALE)" =>
            "first->s = vector_alone(tables, slot, TRANSLATION)";
        lone_slots_do_not_move: "return flags;" =>
            "return REST_TRANSLATION | REST_SCALE;";
    }
    check_blends {
        full_groups_write_one_palette: "to[lane] + first, true" => "to[0] + first, true";
        lines_repeat_a_number: "lines[i] = numbers[i]" => "lines[i] = numbers[i & 7]";
        second_spans_have_the_rows_of_the_first: "slot.columns.lane += LANES;" => "";
        second_spans_have_the_planes_of_the_first: "slot.planes += LANES;" => "";
        rotations_are_not_weighted: "factor * playing.at.weight" => "factor";
        vectors_of_spans_are_not_weighted: "vec3_scale(v, weight)" => "v";
        second_spans_are_not_mixed: "rotation_of(tables, next_span(slot))" =>
            "rotation_of(tables, slot)";
    }
    check_inertialization {
        inertialized_layers_stay_at_rest: "shown->terms.at_rest = 0;" => "";
        inertialized_poses_stay_at_rest:
            "posed[lane] = pose;\n        at_rest[lane] = 0;\n    }\n    for" =>
            "posed[lane] = pose;\n    }\n    for";
    }
    check_overrides {
        overrides_stay_at_rest:
            "posed[lane] = pose;\n        at_rest[lane] = 0;\n    }\n}" =>
            "posed[lane] = pose;\n    }\n}";
    }
    check_live_clips {
        floats_are_read_as_halves:
            "playback.has_floats || stored->has_floats" => "false";
        layers_read_floats_as_halves:
            "return show_layer(all, posing, lane, l, first, false, rest, shown);" =>
            "return show_layer(all, posing, lane, l, first, true, rest, shown);";
    }
}

faults! {
    Form::Grouped(GroupShape::of(GPU_SHAPE.fused_group)),
    grouped_kernels_have_the_text_of_each_fault;
    check_blends {
        several_slots_count_as_one: "any & ~several & ~weak" => "any & ~weak";
        parents_are_those_of_the_level_before: "parent = next_parent;" => "";
    }
    check_live_clips {
        rotations_of_floats_are_read_as_halves:
            "turn.floats ? " => "false ? ";
        translations_of_floats_are_read_as_halves:
            "shift.floats ? " => "false ? ";
    }
}
