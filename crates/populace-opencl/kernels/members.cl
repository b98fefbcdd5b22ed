// members.cl - Bit fields of a member. Twin of populace-native/src/members.rs.

INLINE uint member_layers(Member member)
{
    return member.layers_and_phase & ((1u << MEMBER_LAYER_BITS) - 1u);
}

INLINE uint member_phase(Member member) { return member.layers_and_phase >> MEMBER_LAYER_BITS; }
