// skin.glsl - the skinning equation, from palettes as the device wrote them.
// Reads   palette: three vec4 (rows of model_from_bind) for each entry of the bound page
// Gives   model_from_bind(): the blended matrix of this vertex; world_from_model(): the instance's;
//         turn_normal()
// A mat3x4 here holds the three rows of an affine transform as its columns: `vec4(p, 1) * m` is the image of p.

layout(std430, binding = 0) readonly buffer Palette { vec4 palette[]; };

mat3x4 palette_entry(uint entry) {
    uint row = (palette_first + entry) * 3u;
    return mat3x4(palette[row], palette[row + 1u], palette[row + 2u]);
}

mat3x4 blend(uvec4 entries, vec4 weights) {
    return weights.x * palette_entry(entries.x) + weights.y * palette_entry(entries.y)
         + weights.z * palette_entry(entries.z) + weights.w * palette_entry(entries.w);
}

mat3x4 model_from_bind() {
#ifdef EIGHT_INFLUENCES
    return blend(entries0, weights0) + blend(entries1, weights1);
#else
    return blend(entries0, weights0);
#endif
}

mat3x4 world_from_model() { return mat3x4(world_row0, world_row1, world_row2); }

// Turns a normal by the inverse transpose, as the matrix of cofactors with the sign of the determinant: right under
// any scale, mirroring too, and without a division that could fail. Zero where the matrix flattens the surface away.
vec3 turn_normal(mat3x4 m, vec3 normal) {
    vec3 a = m[0].xyz, b = m[1].xyz, c = m[2].xyz;
    vec3 bc = cross(b, c);
    vec3 turned = vec3(dot(bc, normal), dot(cross(c, a), normal), dot(cross(a, b), normal));
    turned *= dot(a, bc) < 0.0 ? -1.0 : 1.0;
    float squared = dot(turned, turned);
    return squared > 0.0 ? turned * inversesqrt(squared) : vec3(0.0);
}
