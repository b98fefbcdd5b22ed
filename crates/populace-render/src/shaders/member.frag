// member.frag - colours a member. Variants: MASKED discards fragments, BLENDED writes alpha, and
//               without either the surface is opaque. TEXTURED samples a texture. VERTEX_LIT takes
//               the light from the vertices.
// Reads   outputs of member.vert; base colour texture (sRGB, sampled as linear)
// Writes  linear colour, which the framebuffer stores as sRGB

#ifdef TEXTURED
layout(binding = 0) uniform sampler2D base_color_texture;
#endif

#ifdef VERTEX_LIT
in vec3 light;
in float haze;
#else
in vec3 world_position;
in vec3 world_normal;
in vec3 shadow_position;
#endif
in vec2 texture_uv;
in vec4 surface_color;

out vec4 color;

void main() {
    vec4 base = surface_color;
#ifdef TEXTURED
    base *= texture(base_color_texture, texture_uv);
#endif
#ifdef MASKED
    if (base.a < alpha_cutoff) discard;
#endif
#ifndef VERTEX_LIT
    float squared = dot(world_normal, world_normal);
    vec3 normal = squared > 0.0 ? world_normal * inversesqrt(squared) : vec3(0.0, 1.0, 0.0);
    // Only double-sided surfaces have back faces that are not culled.
    if (!gl_FrontFacing) normal = -normal;
    vec3 light = light_on(normal, shadow_position);
    float haze = haze_at(world_position);
#endif
    vec3 lit = tone_mapped(hazed(base.rgb * light, haze));
#ifdef BLENDED
    color = vec4(lit, base.a);
#else
    color = vec4(lit, 1.0);
#endif
}
