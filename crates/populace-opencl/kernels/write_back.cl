// write_back.cl - Write-Back stage (Lister & Day 2012, section 3, fig. 1): the matrix palette,
// model_from_bind = model_from_joint * joint_from_bind.
//
// NDRange  (palette entries of one page, padded to whole work-groups)
// Reads    row0, row1, row2 of model_from_joint; entries
// Writes   palette[3 * entry ..] of one page: each member's entries once, padding untouched
// Oracle   populace-testkit/src/oracle/write_back.rs
// Twin of populace-native/src/write_back.rs: same arithmetic, same order of operations.

__kernel void write_back(
    // Members and their palettes.
    __global const Member *members, __global const uint *palette_blocks,
    __global const Body *bodies, __global const Entry *entries,
    // Model transforms.
    __global const float4 *row0, __global const float4 *row1, __global const float4 *row2,
    // Ranges.
    uint page_first, uint entry_count, uint member_first, uint member_end,
    // Output.
    __global float4 *palette)
{
    const uint in_page = (uint)get_global_id(0);
    if (in_page >= entry_count) return;
    const uint place = page_first + in_page, owner = palette_blocks[place / PALETTE_BLOCK];
    if (owner == NONE || owner < member_first || owner >= member_end) return;
    const Member member = members[owner];
    const uint index = place - member.palette_first;
    if (index >= bodies[member.posed].entry_count) return;

    const Entry entry = entries[bodies[member.posed].entry_first + index];
    const uint joint = member.joint_first + entry.joint;
    const float16 model_from_joint =
        (float16)(row0[joint], row1[joint], row2[joint], (float4)(0.0f));
    const float16 model_from_bind =
        affine_mul_rows(model_from_joint, entry.row0, entry.row1, entry.row2);
    __global float4 *to = palette + 3 * (size_t)in_page;
    to[0] = model_from_bind.s0123;
    to[1] = model_from_bind.s4567;
    to[2] = model_from_bind.s89ab;
}
