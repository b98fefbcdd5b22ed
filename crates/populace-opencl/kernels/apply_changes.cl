/* apply_changes.cl - puts changed elements of one table, sent together, each into its place.
 * NDRange  (words of all changed elements, padded to whole work-groups)
 * Reads    changes: at index_first the index of each changed element, at value_first their values one after the other
 * Writes   table: the changed elements, each once, in 32-bit words
 * Oracle   the host's table */

__kernel void apply_changes(__global const uint *changes, uint index_first, uint value_first, uint element_words,
                            uint word_count, __global uint *table)
{
    const uint word = (uint)get_global_id(0);
    if (word >= word_count) return;
    const uint element = changes[index_first + word / element_words];
    table[(size_t)element * element_words + word % element_words] = changes[value_first + word];
}
