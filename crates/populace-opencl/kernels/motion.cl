/* motion.cl - root motion: where its clips move a member, frame after frame. Each clip says how far it moves the body between
 * the last frame and this one, seen from where it had it; these moves are mixed as poses are, and the mix goes on from where the
 * member was. A clip that played for a part of the frame moves the body for that part, by the mean of what it weighed then: so
 * nothing is lost of what is left in the midst of a frame. Where something inertializes, the speed of the frame before goes over into
 * that of what plays now, as poses do. Twin of populace-native controls/motion.rs. */

/* A turn about +Y, then a shift; s and c are sine and cosine. */
typedef struct { float x, y, z, s, c; } Move;

#define NO_MOVE { 0.0f, 0.0f, 0.0f, 0.0f, 1.0f }

INLINE Move move_of(float x, float y, float z, float s, float c)
{
    const float squared = s * s + c * c;
    const float k = squared > 1e-20f ? inverse_root(squared) : 0.0f;
    const Move move = { x, y, z, squared > 1e-20f ? s * k : 0.0f, squared > 1e-20f ? c * k : 1.0f };
    return move;
}

/* `next` first, then `first`. */
INLINE Move move_then(Move first, Move next)
{
    return move_of(first.x + (first.c * next.x + first.s * next.z), first.y + next.y,
                   first.z + (first.c * next.z - first.s * next.x), first.s * next.c + first.c * next.s,
                   first.c * next.c - first.s * next.s);
}

INLINE Move move_undone(Move m)
{
    const Move back = { (m.c * m.x + -m.s * m.z) * -1.0f, m.y * -1.0f, (m.c * m.z - -m.s * m.x) * -1.0f, -m.s, m.c };
    return back;
}

/* So many times. */
INLINE Move move_times(Move m, ulong count)
{
    Move all = NO_MOVE;
    for (; count > 0; count >>= 1) {
        if (count & 1) all = move_then(all, m);
        m = move_then(m, m);
    }
    return all;
}

INLINE float between(float from, float to, float part) { return from + (to - from) * part; }

INLINE Move move_mix(Move a, Move b, float part)
{
    return move_of(between(a.x, b.x, part), between(a.y, b.y, part), between(a.z, b.z, part), between(a.s, b.s, part),
                   between(a.c, b.c, part));
}

INLINE Move motion_row(__global const float4 *motions, ClipRows clip, uint row)
{
    __global const float4 *at = motions + (clip.motion_first + row) * MOTION_ELEMENTS;
    const Move move = { at[0].x, at[0].y, at[0].z, at[1].x, at[1].y };
    return move;
}

/* Where a clip has its body at a time. */
INLINE Move motion_at(__global const float4 *motions, ClipRows clip, float secs)
{
    const float last = (float)(clip.motion_count - 1), wanted = (secs - clip.start_secs) * clip.motion_rows_per_sec;
    const float place = wanted > 0.0f ? (wanted < last ? wanted : last) : 0.0f;
    const uint row = (uint)place, next = row + 1 < clip.motion_count ? row + 1 : row;
    return move_mix(motion_row(motions, clip, row), motion_row(motions, clip, next), place - (float)row);
}

/* From one time of the clock to a later one; to the same one or before it where there is nothing between. */
typedef struct { ulong from, until; } Span;

/* When a slot plays within a span; not once it was cut. */
INLINE Span span_of(Slot slot, Span within)
{
    const bool is_cut = slot.end_weight <= 0.0f && slot.weight_rate == 0.0f;
    const Span span = { max(within.from, slot.start_tick), is_cut ? min(within.until, slot.weight_tick) : within.until };
    const Span none = { 0, 0 };
    return slot.bound_clip == NONE ? none : span;
}

INLINE float span_part(Span all, Span span) { return (float)(span.until - span.from) / (float)(all.until - all.from); }

/* How far a slot's clip moves its own body within a span, seen from where it had it. */
INLINE Move move_of_slot(Controls of, Slot slot, ClipRows clip, Span span)
{
    const Move none = NO_MOVE;
    const uint mode = slot_mode(slot);
    if (clip.motion_count == 0 || (mode != SLOT_LOOP && mode != SLOT_ONCE)) return none;
    const Move from = motion_at(of.motions, clip, slot_time(slot, span.from, clip));
    const Move to = motion_at(of.motions, clip, slot_time(slot, span.until, clip));
    const Move cycle = motion_at(of.motions, clip, clip.start_secs + clip.duration_secs);
    const bool backwards = (slot.phase_rate >> 63) != 0;
    const Move whole = move_times(backwards ? move_undone(cycle) : cycle, slot_cycles(slot, span.from, span.until));
    return move_then(move_undone(from), move_then(whole, to));
}

/* A weighted sum of moves: what each weighed while it played, the mean over the frame of what all weighed, and when any
 * played. */
typedef struct { float x, y, z, sine, cosine, weight, total; Span span; } Moves;

/* Where moves that weighed so much in all go. Those that each played in a part of the frame come after each other, so that what
 * all weighed while they played is more: each turns from straight ahead. */
INLINE Move moves_over(Moves sum, float total)
{
    const float k = 1.0f / total;
    return move_of(sum.x * k, sum.y * k, sum.z * k, sum.sine * k, (sum.cosine + (total - sum.weight)) * k);
}

INLINE Moves moves_of_layer(Controls of, uint owner, uint layer, Span within)
{
    Moves sum = { 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, { within.until, 0 } };
    for (uint i = 0; i < of.slots_per_member; i++) {
        Slot slot = of.slots[owner * of.slots_per_member + i];
        Span span = span_of(slot, within);
        if (span.from < span.until && slot_mode(slot) == SLOT_MACHINE) {
            slot = machine_slot(slot, slot_mean_weight(slot, span.from, span.until), of.machines);
            span = span_of(slot, span);
        }
        if (span.from >= span.until) continue;
        const float weight = slot_mean_weight(slot, span.from, span.until);
        if (weight <= 0.0f || slot_layer(slot) != layer) continue;
        const BoundClip bound = of.bound_clips[slot.bound_clip];
        const Move move = move_of_slot(of, slot, of.clips[bound.clip], span);
        const float far = weight * bound.motion_scale;
        sum.x += move.x * far;
        sum.y += move.y * far;
        sum.z += move.z * far;
        sum.sine += move.s * weight;
        sum.cosine += move.c * weight;
        sum.weight += weight;
        sum.total += weight * span_part(within, span);
        sum.span.from = min(sum.span.from, span.from);
        sum.span.until = max(sum.span.until, span.until);
    }
    return sum;
}

/* How much a layer weighs at the first joint, where it moves that: one that adds does not. */
INLINE float weight_at_root(Controls of, uint owner, uint l)
{
    if (l == 0) return 1.0f;
    if (l >= member_layers(of.members[owner])) return 0.0f;
    const Layer layer = of.layers[owner * LAYERS_PER_MEMBER + l];
    if ((layer.mask_and_mode & LAYER_ADDITIVE) != 0) return 0.0f;
    const uint mask = layer.mask_and_mode & LAYER_MASK;
    return mask == LAYER_MASK ? layer.weight : layer.weight * of.masks[mask];
}

/* The mix of what all clips do within a span, each for as long as it plays. Layers that add to what lies beneath move
 * nobody. */
APART_STEP Move move_within(Controls of, uint owner, Span span)
{
    Move moved = NO_MOVE;
    const Moves lowest = moves_of_layer(of, owner, 0, span);
    if (lowest.total > 1e-3f) moved = moves_over(lowest, lowest.total / span_part(span, lowest.span));
    const uint layer_count = member_layers(of.members[owner]);
    for (uint l = 1; l < layer_count; l++) {
        const Moves above = moves_of_layer(of, owner, l, span);
        const float weight = weight_at_root(of, owner, l);
        if (above.total <= LEAST_WEIGHT || weight <= 0.0f) continue;
        moved = move_mix(moved, moves_over(above, above.total), weight * (above.total < 1.0f ? above.total : 1.0f));
    }
    return moved;
}

/* Where the frame before left a member, and how fast that moved it: shift and turn in a tick; and how much faster than what it
 * plays it was when something began to inertialize. */
typedef struct { Move place; float4 speed, excess; } Last;

INLINE float4 speed_of(Move m, uint ticks)
{
    return (float4)(m.x / (float)ticks, m.y / (float)ticks, m.z / (float)ticks, m.s / (float)ticks);
}

/* The integral of what is left of a difference that inertializes: of the quintic by which poses do. */
INLINE float still_until(float inertialized)
{
    const float s = inertialized < 1.0f ? inertialized : 1.0f;
    return s - s * s * s * s * (2.5f - 3.0f * s + s * s);
}

/* Of the member's slots that began to inertialize before a time of the clock, where they move its root, the last, or NONE. */
INLINE uint newest_inertialization(Controls of, uint owner, ulong before)
{
    uint newest = NONE;
    for (uint i = owner * of.slots_per_member; i < (owner + 1) * of.slots_per_member; i++) {
        const Slot slot = of.slots[i];
        if (slot_mode(slot) != SLOT_INERTIALIZATION || slot.bound_clip == NONE || slot.start_tick >= before) continue;
        if (weight_at_root(of, owner, slot_layer(slot)) <= 0.0f) continue;
        if (newest == NONE || slot.start_tick >= of.slots[newest].start_tick) newest = i;
    }
    return newest;
}

/* What is left of a difference in speed within a span, while it inertializes as a slot does. */
INLINE Move inertialized_within(Slot slot, float4 excess, ulong from, ulong until)
{
    const float begin = still_until(slot_inertialized(slot, from));
    const float4 on = excess * ((still_until(slot_inertialized(slot, until)) - begin) / slot.end_weight);
    return move_of(on.x, on.y, on.z, on.w, 1.0f);
}

/* Where the member is after this frame, and how fast it went. */
INLINE Last next_of(Controls of, uint owner, Last last, bool has_last)
{
    if (of.elapsed_ticks == 0) return last;
    const Span frame = { of.tick > of.elapsed_ticks ? of.tick - of.elapsed_ticks : 0, of.tick };
    Move moved = move_within(of, owner, frame);
    const uint newest = newest_inertialization(of, owner, of.tick);
    const bool begins = newest != NONE && of.slots[newest].start_tick >= frame.from;
    /* What inertializes already goes on until something else begins to. */
    const uint inertialization = begins ? newest_inertialization(of, owner, frame.from) : newest;
    const ulong until = begins ? of.slots[newest].start_tick : of.tick;
    if (inertialization != NONE) moved = move_then(moved, inertialized_within(of.slots[inertialization], last.excess, frame.from, until));
    if (begins && has_last) {
        const Span after = { until, until + of.elapsed_ticks };
        last.excess = last.speed - speed_of(move_within(of, owner, after), of.elapsed_ticks);
        moved = move_then(moved, inertialized_within(of.slots[newest], last.excess, until, of.tick));
    }
    if (newest == NONE || !slot_inertializes(of.slots[newest], of.tick)) last.excess = (float4)(0.0f);
    const Last next = { move_then(last.place, moved), speed_of(moved, of.elapsed_ticks), last.excess };
    return next;
}

/* Moves a root to where clips have moved the member. */
APART_STEP float16 moves(const Steering *s, Step step, float16 own)
{
    const uint state = s->index * STATES_PER_CONTROL + MOTION_STATE;
    const float4 place = s->of->states_before[state], heading = s->of->states_before[state + 1];
    const Last none = { NO_MOVE, (float4)(0.0f), (float4)(0.0f) };
    const Last kept = { { place.x, place.y, place.z, heading.x, heading.y }, s->of->states_before[state + 2],
                        s->of->states_before[state + 3] };
    const bool begun = as_uint(place.w) == step.turn;
    const Last next = next_of(*s->of, s->control.member, begun ? kept : none, begun);
    const Move now = next.place;
    if (step.joint == 0) {
        s->of->states[state] = (float4)(now.x, now.y, now.z, as_float(step.turn));
        s->of->states[state + 1] = (float4)(now.s, now.c, 0.0f, 0.0f);
        s->of->states[state + 2] = next.speed;
        s->of->states[state + 3] = next.excess;
    }
    const float16 carried = (float16)(now.c, 0.0f, now.s, now.x, 0.0f, 1.0f, 0.0f, now.y, -now.s, 0.0f, now.c, now.z, (float4)(0.0f));
    return affine_mul(carried, own);
}
