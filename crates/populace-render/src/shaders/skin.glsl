// skin.glsl - linear blend skinning from the matrix palette that a device wrote.
// Reads    palette: three vectors (rows of model_from_bind) for each entry of the bound page
// Defines  model_from_bind(): blended matrix of this vertex
//          world_from_model(): matrix of this instance
//          transform_normal(): image of a normal under a matrix
// The columns of a mat3x4 are the three rows of an affine transform: `vec4(p, 1) * m` transforms
// the point p.

layout(binding = 7) uniform samplerBuffer palette;

mat3x4 palette_entry(uint entry) {
    int row = int((entry_and_number.x + entry) * 3u);
    return mat3x4(texelFetch(palette, row), texelFetch(palette, row + 1),
                  texelFetch(palette, row + 2));
}

mat3x4 blend(uvec4 entries, vec4 weights) {
    return weights.x * palette_entry(entries.x) + weights.y * palette_entry(entries.y)
         + weights.z * palette_entry(entries.z) + weights.w * palette_entry(entries.w);
}

mat3x4 model_from_bind() {
#if INFLUENCES == 8
    return blend(entries0, weights0) + blend(entries1, weights1);
#elif INFLUENCES == 4
    return blend(entries0, weights0);
#elif INFLUENCES == 2
    return weights0.x * palette_entry(entries0.x) + weights0.y * palette_entry(entries0.y);
#else
    return palette_entry(entries0.x);
#endif
}

mat3x4 world_from_model() { return mat3x4(world_row0, world_row1, world_row2); }

// Transforms a normal by the inverse transpose of `m`, computed as the cofactor matrix times the
// sign of the determinant. This is correct for any scale, including mirroring, and does not divide
// by the determinant. Returns a unit vector, or zero if `m` collapses the surface.
vec3 transform_normal(mat3x4 m, vec3 normal) {
    vec3 a = m[0].xyz, b = m[1].xyz, c = m[2].xyz;
    vec3 bc = cross(b, c);
    vec3 image = vec3(dot(bc, normal), dot(cross(c, a), normal), dot(cross(a, b), normal));
    image *= dot(a, bc) < 0.0 ? -1.0 : 1.0;
    float squared = dot(image, image);
    return squared > 0.0 ? image * inversesqrt(squared) : vec3(0.0);
}
