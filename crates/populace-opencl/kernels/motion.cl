// motion.cl - Root motion: clips move a member from frame to frame.
//
// Each clip gives the movement of its body between the last frame and this one, relative to its
// position in the clip. These moves are mixed as poses are, and the mix is applied to the member's
// position. A clip that played for a part of the frame moves the body for that part, by its mean
// weight then, so nothing is lost if it ends in the middle of a frame. During inertialization, the
// velocity of the previous frame blends into the velocity of what plays now, as poses do.
//
// Twin of populace-native/src/constraints/motion.rs: same arithmetic, same order of operations.

// A rotation about +Y, then a shift; s and c are sine and cosine.
typedef struct {
    float x, y, z, s, c;
} Move;

#define NO_MOVE { 0.0f, 0.0f, 0.0f, 0.0f, 1.0f }

INLINE Move move_of(float x, float y, float z, float s, float c)
{
    const float squared = s * s + c * c;
    const float k = squared > LEAST_SQUARE ? inverse_root(squared) : 0.0f;
    const bool turns = squared > LEAST_SQUARE;
    const Move move = { x, y, z, turns ? s * k : 0.0f, turns ? c * k : 1.0f };
    return move;
}

// Returns `next` applied first, then `first`.
INLINE Move move_then(Move first, Move next)
{
    return move_of(first.x + (first.c * next.x + first.s * next.z), first.y + next.y,
                   first.z + (first.c * next.z - first.s * next.x),
                   first.s * next.c + first.c * next.s, first.c * next.c - first.s * next.s);
}

INLINE Move move_undone(Move m)
{
    const Move back = { (m.c * m.x + -m.s * m.z) * -1.0f, m.y * -1.0f,
                        (m.c * m.z - -m.s * m.x) * -1.0f, -m.s, m.c };
    return back;
}

// Returns the move repeated `count` times.
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
    return move_of(between(a.x, b.x, part), between(a.y, b.y, part), between(a.z, b.z, part),
                   between(a.s, b.s, part), between(a.c, b.c, part));
}

INLINE Move motion_row(__global const float4 *motions, ClipRows clip, uint row)
{
    __global const float4 *at = motions + (clip.motion_first + row) * MOTION_ELEMENTS;
    const Move move = { at[0].x, at[0].y, at[0].z, at[1].x, at[1].y };
    return move;
}

// Returns the position of a clip's body at a time.
INLINE Move motion_at(__global const float4 *motions, ClipRows clip, float secs)
{
    const float last = (float)(clip.motion_count - 1),
                wanted = (secs - clip.start_secs) * clip.motion_rows_per_sec;
    const float place = wanted > 0.0f ? (wanted < last ? wanted : last) : 0.0f;
    const uint row = (uint)place, next = row + 1 < clip.motion_count ? row + 1 : row;
    return move_mix(motion_row(motions, clip, row), motion_row(motions, clip, next),
                    place - (float)row);
}

// From one clock tick to a later one. The span is empty if `until` is not later.
typedef struct {
    ulong from, until;
} Span;

// Returns when a slot plays within a span. A slot that was cut ends there.
INLINE Span span_of(Slot slot, Span within)
{
    const bool is_cut = slot.end_weight <= 0.0f && slot.weight_rate == 0.0f;
    const Span span = { max(within.from, slot.start_tick),
                        is_cut ? min(within.until, slot.weight_tick) : within.until };
    const Span none = { 0, 0 };
    return slot.bound_clip == NONE ? none : span;
}

INLINE float span_part(Span all, Span span)
{
    return (float)(span.until - span.from) / (float)(all.until - all.from);
}

// Returns how a slot's clip moves its own body within a span, relative to its position at the
// start.
INLINE Move move_of_slot(ConstraintTables tables, Slot slot, ClipRows clip, Span span)
{
    const Move none = NO_MOVE;
    const uint mode = slot_mode(slot);
    if (clip.motion_count == 0 || (mode != SLOT_LOOP && mode != SLOT_ONCE)) return none;
    const Move from = motion_at(tables.motions, clip, slot_time(slot, span.from, clip));
    const Move to = motion_at(tables.motions, clip, slot_time(slot, span.until, clip));
    const Move cycle = motion_at(tables.motions, clip, clip.start_secs + clip.duration_secs);
    const bool backwards = (slot.phase_rate >> 63) != 0;
    const Move whole = move_times(backwards ? move_undone(cycle) : cycle,
                                  slot_cycles(slot, span.from, span.until));
    return move_then(move_undone(from), move_then(whole, to));
}

// Weighted sum of moves: the weight of each while it played, the total of mean weights over the
// frame, and the span in which any played.
typedef struct {
    float x, y, z, sine, cosine, weight, total;
    Span span;
} Moves;

// Returns the move of a weighted sum. Moves that each played in a part of the frame follow each
// other, so their weights sum to more than the total; each turns from straight ahead.
INLINE Move moves_over(Moves sum, float total)
{
    const float k = 1.0f / total;
    return move_of(sum.x * k, sum.y * k, sum.z * k, sum.sine * k,
                   (sum.cosine + (total - sum.weight)) * k);
}

INLINE Moves moves_of_layer(ConstraintTables tables, uint owner, uint layer, Span within)
{
    Moves sum = { 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, { within.until, 0 } };
    for (uint i = 0; i < tables.slots_per_member; i++) {
        Slot slot = tables.slots[owner * tables.slots_per_member + i];
        Span span = span_of(slot, within);
        if (span.from < span.until && slot_mode(slot) == SLOT_MACHINE) {
            slot =
                machine_slot(slot, slot_mean_weight(slot, span.from, span.until), tables.machines);
            span = span_of(slot, span);
        }
        if (span.from >= span.until) continue;
        const float weight = slot_mean_weight(slot, span.from, span.until);
        if (weight <= 0.0f || slot_layer(slot) != layer) continue;
        const BoundClip bound = tables.bound_clips[slot.bound_clip];
        const Move move = move_of_slot(tables, slot, tables.clips[bound.rows], span);
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

// Returns a layer's weight at the first joint. Additive layers do not move it.
INLINE float weight_at_root(ConstraintTables tables, uint owner, uint l)
{
    if (l == 0) return 1.0f;
    if (l >= member_layers(tables.members[owner])) return 0.0f;
    const Layer layer = tables.layers[owner * LAYERS_PER_MEMBER + l];
    if ((layer.mask_and_mode & LAYER_ADDITIVE) != 0) return 0.0f;
    const uint mask = layer.mask_and_mode & LAYER_MASK;
    return mask == LAYER_MASK ? layer.weight : layer.weight * tables.masks[mask];
}

// Mixes the moves of all clips within a span, each for as long as it plays. Additive layers move
// nothing.
SELDOM Move move_within(ConstraintTables tables, uint owner, Span span)
{
    Move moved = NO_MOVE;
    const Moves lowest = moves_of_layer(tables, owner, 0, span);
    if (lowest.total > LEAST_TOTAL)
        moved = moves_over(lowest, lowest.total / span_part(span, lowest.span));
    const uint layer_count = member_layers(tables.members[owner]);
    for (uint l = 1; l < layer_count; l++) {
        const Moves above = moves_of_layer(tables, owner, l, span);
        const float weight = weight_at_root(tables, owner, l);
        if (above.total <= LEAST_WEIGHT || weight <= 0.0f) continue;
        moved = move_mix(moved, moves_over(above, above.total),
                         weight * (above.total < 1.0f ? above.total : 1.0f));
    }
    return moved;
}

// State after the previous frame: position, velocity (shift and sine of the turn, per tick), the
// velocity offset at the start of an inertialization, and the part of the position that rounding has
// left out.
typedef struct {
    Move place;
    float4 speed, excess, rest;
} Last;

// Adds a move to the position. Single precision alone would lose part of each of many small moves.
INLINE void move_followed_by(Last *last, Move next)
{
    const Move at = last->place;
    const float x = (at.c * next.x + at.s * next.z) + last->rest.x, y = next.y + last->rest.y,
                z = (at.c * next.z - at.s * next.x) + last->rest.z;
    Move now = move_then(at, next);
    now.x = at.x + x;
    now.y = at.y + y;
    now.z = at.z + z;
    last->rest = (float4)(x - (now.x - at.x), y - (now.y - at.y), z - (now.z - at.z), 0.0f);
    last->place = now;
}

INLINE float4 speed_of(Move m, uint ticks)
{
    return (float4)(m.x / (float)ticks, m.y / (float)ticks, m.z / (float)ticks, m.s / (float)ticks);
}

// Returns the integral, from 0, of the quintic by which inertialization fades out.
INLINE float still_until(float inertialized)
{
    const float s = inertialized < 1.0f ? inertialized : 1.0f;
    return s - s * s * s * s * (2.5f - 3.0f * s + s * s);
}

// Returns the member's last slot that began to inertialize before tick `before` and moves its root,
// or NONE.
INLINE uint newest_inertialization(ConstraintTables tables, uint owner, ulong before)
{
    uint newest = NONE;
    for (uint i = owner * tables.slots_per_member; i < (owner + 1) * tables.slots_per_member; i++) {
        const Slot slot = tables.slots[i];
        if (slot_mode(slot) != SLOT_INERTIALIZATION || slot.bound_clip == NONE
            || slot.start_tick >= before)
            continue;
        if (weight_at_root(tables, owner, slot_layer(slot)) <= 0.0f) continue;
        if (newest == NONE || slot.start_tick >= tables.slots[newest].start_tick) newest = i;
    }
    return newest;
}

// Returns the shift left from a velocity offset within a span, while it fades out as the slot
// inertializes.
INLINE Move inertialized_within(InertializationSlot slot, float4 excess, ulong from, ulong until)
{
    const float begin = still_until(inertialized_at(slot, from));
    const float4 on =
        excess * ((still_until(inertialized_at(slot, until)) - begin) / slot.per_tick);
    return move_of(on.x, on.y, on.z, on.w, 1.0f);
}

// Returns the member's position after this frame, and its velocity.
INLINE Last next_of(ConstraintTables tables, uint owner, Last last, bool has_last)
{
    if (tables.elapsed_ticks == 0) return last;
    const Span frame = { tables.tick > tables.elapsed_ticks ? tables.tick - tables.elapsed_ticks
                                                            : 0,
                         tables.tick };
    Move moved = move_within(tables, owner, frame);
    const uint newest = newest_inertialization(tables, owner, tables.tick);
    const bool begins = newest != NONE && tables.slots[newest].start_tick >= frame.from;
    // An inertialization in progress goes on until a new one begins.
    const uint inertialization =
        begins ? newest_inertialization(tables, owner, frame.from) : newest;
    const ulong until = begins ? tables.slots[newest].start_tick : tables.tick;
    if (inertialization != NONE)
        moved =
            move_then(moved, inertialized_within(as_inertialization(tables.slots[inertialization]),
                                                 last.excess, frame.from, until));
    if (begins && has_last) {
        const Span after = { until, until + tables.elapsed_ticks };
        last.excess =
            last.speed - speed_of(move_within(tables, owner, after), tables.elapsed_ticks);
        moved = move_then(moved, inertialized_within(as_inertialization(tables.slots[newest]),
                                                     last.excess, until, tables.tick));
    }
    if (newest == NONE || !slot_inertializes(tables.slots[newest], tables.tick))
        last.excess = (float4)(0.0f);
    last.speed = speed_of(moved, tables.elapsed_ticks);
    move_followed_by(&last, moved);
    return last;
}

// Applies the member's root motion to a root joint.
SELDOM float16 moves(const Solver *s, uint joint, float16 own)
{
    const uint first = s->index * STATES_PER_CONTROL + MOTION_STATE,
               epoch = s->control->motion_epoch;
    __global const float4 *before = s->tables->states_before + first;
    __global float4 *state = s->tables->states + first;
    const float4 place = before[0], heading = before[1];
    const Last none = { NO_MOVE, (float4)(0.0f), (float4)(0.0f), (float4)(0.0f) };
    const Last kept = { { place.x, place.y, place.z, heading.x, heading.y },
                        before[2],
                        before[3],
                        before[4] };
    const bool begun = as_uint(place.w) == epoch;
    const Last next = next_of(*s->tables, s->control->member, begun ? kept : none, begun);
    const Move now = next.place;
    if (joint == 0) {
        state[0] = (float4)(now.x, now.y, now.z, as_float(epoch));
        state[1] = (float4)(now.s, now.c, 0.0f, 0.0f);
        state[2] = next.speed;
        state[3] = next.excess;
        state[4] = next.rest;
    }
    const float4 row0 = (float4)(now.c, 0.0f, now.s, now.x);
    const float4 row1 = (float4)(0.0f, 1.0f, 0.0f, now.y);
    const float4 row2 = (float4)(-now.s, 0.0f, now.c, now.z);
    return affine_mul((float16)(row0, row1, row2, (float4)(0.0f)), own);
}
