// floor.cl - Lower bound of every schedule's time: writes palettes with a constant and computes
// nothing. Measured by benchmarks only.
//
// Twin of populace-native/src/floor.rs.
//
// NDRange  (palette divided by what one work-item writes, padded to whole work-groups)
// Writes   palette[0 .. count] of one page; count is in float4s

// Three variants: each work-item writes one float4, one matrix, or a run of sixteen matrices.
__kernel void floor_float4(__global float4 *palette, uint count)
{
    if (get_global_id(0) < count) palette[get_global_id(0)] = (float4)(1.0f, 2.0f, 3.0f, 4.0f);
}

__kernel void floor_matrix(__global float4 *palette, uint count)
{
    const size_t first = get_global_id(0) * 3;
    if (first >= count) return;
    for (size_t i = first; i < first + 3; i++) palette[i] = (float4)(1.0f, 2.0f, 3.0f, 4.0f);
}

__kernel void floor_run(__global float4 *palette, uint count)
{
    const size_t first = get_global_id(0) * 48;
    for (size_t i = first; i < min(first + 48, (size_t)count); i++)
        palette[i] = (float4)(1.0f, 2.0f, 3.0f, 4.0f);
}
