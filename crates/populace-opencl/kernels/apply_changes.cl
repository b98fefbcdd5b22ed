// apply_changes.cl - Scatters changed elements, uploaded together, into one table.
//
// NDRange  (words of all changed elements, padded to whole work-groups)
// Reads    changes: from index_first on the index of each changed element; from value_first on
//          their values, one after the other
// Writes   table: each changed element once, as 32-bit words
// Oracle   the host's table (src/upload/tests.rs)

__kernel void apply_changes(
    // Changes, and where they begin.
    __global const uint *changes, uint index_first, uint value_first, uint element_words,
    uint word_count,
    // Output.
    __global uint *table)
{
    const uint word = (uint)get_global_id(0);
    if (word >= word_count) return;
    const uint element = changes[index_first + word / element_words];
    table[(size_t)element * element_words + word % element_words] = changes[value_first + word];
}
