// look.glsl - the look of a member: tints of regions and hidden options.
// Reads    marks of the vertex: region, option plus 1; MemberLook of the instance
// Defines  region_tint(): linear factors of this vertex's colour
//          is_hidden(): whether the member does not show this vertex's option
//          OUTSIDE: a position outside of any picture. All corners of a triangle have one option,
//                   so a hidden triangle lies outside as a whole.

const vec4 OUTSIDE = vec4(2.0, 2.0, 2.0, 1.0);

vec3 region_tint() {
    uint region = marks.x;
    uint packed_tint = region < 4u ? look0[region] : look1[region - 4u];
    uvec3 channels = uvec3(packed_tint, packed_tint >> 10u, packed_tint >> 20u) & 1023u;
    vec3 roots = vec3(channels) * (1.0 / 128.0);
    return roots * roots;
}

bool is_hidden() { return marks.y != 0u && (look1.w >> (marks.y - 1u) & 1u) != 0u; }
