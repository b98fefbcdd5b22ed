// member.frag - colours a member. Variants: MASKED discards fragments, BLENDED writes alpha, and
//               without either the surface is opaque. VERTEX_LIT takes light and haze from the
//               vertices, with TWO_SIDED those of the side which is seen, and without SAMPLED
//               the whole colour.
//               TEXTURED samples the base colour; SUBSTANCE_MAP, NORMAL_MAP, OCCLUSION_MAP and
//               EMISSIVE_MAP sample their textures, and EMISSIVE adds light. FADED leaves out a
//               part of the pixels. With CONTACTS, bodies near a floor darken it.
// Reads   outputs of member.vert; textures
// Writes  linear colour, which the framebuffer stores as sRGB

#ifdef TEXTURED
layout(binding = 0) uniform sampler2D base_color_texture;
#endif
#ifdef SUBSTANCE_MAP
layout(binding = 3) uniform sampler2D substance_texture;
#endif
#ifdef NORMAL_MAP
layout(binding = 4) uniform sampler2D normal_texture;
#endif
#ifdef OCCLUSION_MAP
layout(binding = 5) uniform sampler2D occlusion_texture;
#endif
#ifdef EMISSIVE_MAP
layout(binding = 6) uniform sampler2D emissive_texture;
#endif

#ifdef VERTEX_LIT
in vec4 factor;
#ifdef TWO_SIDED
in vec3 back_factor;
#endif
#ifdef SAMPLED
in vec3 added;
#endif
#ifdef EMISSIVE_MAP
in float clearness;
#endif
#else
in vec3 world_position;
in vec3 world_normal;
in vec3 shadow_position;
in vec3 substance;
in vec4 surface_color;
#endif
in vec2 texture_uv;

out vec4 color;

#ifdef NORMAL_MAP
// Returns the normal of the texture in world space. The tangents follow from the change of position
// and texture coordinates over the picture (Schüler, "Normal Mapping Without Precomputed Tangents",
// ShaderX5, 2006).
vec3 mapped_normal(vec3 normal) {
    vec3 position_x = dFdx(world_position), position_y = dFdy(world_position);
    vec2 uv_x = dFdx(texture_uv), uv_y = dFdy(texture_uv);
    vec3 across_y = cross(position_y, normal), across_x = cross(normal, position_x);
    vec3 along_u = across_y * uv_x.x + across_x * uv_y.x;
    // v grows downwards in the texture, and green upwards.
    vec3 along_v = -(across_y * uv_x.y + across_x * uv_y.y);
    float longest = max(dot(along_u, along_u), dot(along_v, along_v));
    float scale = longest > 0.0 ? inversesqrt(longest) : 0.0;
    vec3 at = texture(normal_texture, texture_uv).xyz * 2.0 - 1.0;
    at.xy *= normal_scale * scale;
    return normalize(along_u * at.x + along_v * at.y + normal * max(at.z, 1e-3));
}
#endif

// Colour of the base colour texture; white without one.
vec4 sampled_color() {
#ifdef TEXTURED
    return texture(base_color_texture, texture_uv);
#else
    return vec4(1.0);
#endif
}

#ifdef EMISSIVE
vec3 emitted() {
#ifdef EMISSIVE_MAP
    return emissive.rgb * texture(emissive_texture, texture_uv).rgb;
#else
    return emissive.rgb;
#endif
}
#endif

#ifdef VERTEX_LIT
vec4 surface() {
    vec4 side = factor;
#ifdef TWO_SIDED
    if (!gl_FrontFacing) side.rgb = back_factor;
#endif
#ifdef SAMPLED
    side *= sampled_color();
    side.rgb += added;
#ifdef EMISSIVE_MAP
    side.rgb += clearness * emitted();
#endif
    side.rgb = tone_mapped(side.rgb);
#endif
    return side;
}
#else
#ifdef CONTACTS
// Greatest height in metres of a surface above the floor on which contact shadows lie. Lower ones,
// such as a road beside a pavement, have the shadows of the pavement's height too.
const float ON_FLOOR_M = 0.02;
#endif

vec3 lit_surface(vec3 base) {
    float squared = dot(world_normal, world_normal);
    vec3 normal = squared > 0.0 ? world_normal * inversesqrt(squared) : vec3(0.0, 1.0, 0.0);
    // Only double-sided surfaces have back faces that are not culled.
    if (!gl_FrontFacing) normal = -normal;
#ifdef NORMAL_MAP
    normal = mapped_normal(normal);
#endif
    float occlusion = above_floor(world_position.y, normal.y);
#ifdef OCCLUSION_MAP
    occlusion *= 1.0 + occlusion_strength * (texture(occlusion_texture, texture_uv).r - 1.0);
#endif
    vec2 metallic_roughness = substance.xy;
#ifdef SUBSTANCE_MAP
    metallic_roughness *= texture(substance_texture, texture_uv).bg;
#endif
    Surfel at = Surfel(base, normal, metallic_roughness.x, metallic_roughness.y, occlusion,
                       substance.z);
    vec3 lit = shaded(at, normalize(eye.xyz - world_position), shadow_position);
#ifdef CONTACTS
    bool is_floor = world_position.y - ambient_glow.w < ON_FLOOR_M && normal.y > 0.5;
    if (is_floor) {
        vec3 of_sky = occlusion * base * sky_light_on(normal, dot(normal, to_sun.xyz));
        lit = darkened(lit, of_sky, pixel_at(gl_FragCoord.xy));
    }
#endif
    return lit;
}

vec4 surface() {
    vec4 base = surface_color * sampled_color();
    vec3 lit = lit_surface(base.rgb);
#ifdef EMISSIVE
    lit += emitted();
#endif
    // Triangles of a ground are so large that haze does not vary evenly over them.
    return vec4(tone_mapped(hazed(lit, haze_at(world_position))), base.a);
}
#endif

void main() {
#ifdef FADED
    if (is_faded_out()) discard;
#endif
    color = surface();
#ifdef MASKED
    if (color.a < alpha_cutoff) discard;
#endif
#ifndef BLENDED
    color.a = 1.0;
#endif
}
