// light.glsl - sun, sky, shadow and haze of members and ground. Colours are linear.

layout(binding = 1) uniform sampler2DShadow shadow_map;

// Fraction of the sun's light that arrives at a position in the shadow map, from 0 to 1: the average
// of four taps, each of which the sampler filters from four texels, or one with VERTEX_LIT. 1 outside
// of the map, and on surfaces that are turned away from the sun, where `facing` is at most 0.
float sunlit(vec3 at, float facing) {
    vec2 texel = 1.0 / vec2(textureSize(shadow_map, 0));
    vec2 inside = 0.5 - 2.0 * texel - abs(at.xy - 0.5);
    bool is_tapped = min(facing, min(inside.x, inside.y)) > 0.0 && to_sun.w > 0.0;
#ifdef VERTEX_LIT
    // Triangles blend the light of their corners, so one tap is enough.
    return is_tapped ? textureLod(shadow_map, at, 0.0) : 1.0;
#else
    // A loop, since software rasterizers mask branches, but leave loops that no pixel is in.
    int taps = is_tapped ? 4 : 0;
    vec2 offset = vec2(-0.8, -0.32);
    float sum = 0.0;
    for (int tap = 0; tap < taps; ++tap) {
        sum += textureLod(shadow_map, vec3(at.xy + texel * offset, at.z), 0.0);
        offset = vec2(-offset.y, offset.x);
    }
    return is_tapped ? 0.25 * sum : 1.0;
#endif
}

// Light of the whole sky on a surface with unit normal `normal`, of which `facing` is the component
// towards the sun: a parabola of the normal's height, and more from the sun's side.
vec3 sky_light_on(vec3 normal, float facing) {
    vec3 by_height = ambient_slope.rgb + normal.y * ambient_bow.rgb;
    return max(ambient_base.rgb + normal.y * by_height + facing * ambient_glow.rgb, 0.0);
}

// Light of the sun on a matt surface, which Lambert's law gives. `wrap` lets light scatter under the
// surface, as in skin: it reaches beyond where the sun stands on the surface's horizon. `at` is a
// position in the shadow map.
vec3 sunlight_on(float facing, vec3 wrap, vec3 at) {
    vec3 wrapped = max(facing + wrap, 0.0) / ((1.0 + wrap) * (1.0 + wrap));
    return sunlit(at, facing + wrap.r) * wrapped * sun_color.rgb;
}

// What haze adds, and the fraction that it hides, at a world position: none at the eye, all before
// the far plane. Its colour is that of the horizon behind.
vec4 haze_at(vec3 world_position) {
    vec3 from_eye = world_position - eye.xyz;
    float far_m = length(from_eye);
    float air = 1.0 - exp2(-horizon_color.w * far_m);
    float amount = max(air, smoothstep(0.1, 0.95, far_m / eye.w));
    float toward = max(dot(from_eye, to_sun.xyz) / max(far_m, 1e-3), 0.0);
    toward *= toward;
    return vec4(amount * (horizon_color.rgb + toward * toward * glow_color.rgb), amount);
}

vec3 hazed(vec3 color, vec4 haze) { return color * (1.0 - haze.a) + haze.rgb; }

// Tone mapping by a ratio of parabolas: see `Highlights` in scene.rs.
vec3 tone_mapped(vec3 color) {
    return color * (tone.x * color + tone.y) / (color * (tone.z * color + tone.w) + 1.0);
}

// How far red, green and blue light scatter in skin, as a cosine beyond the sun's horizon.
const vec3 SKIN_WRAP = vec3(0.25, 0.1, 0.06);

// Fraction of the sky's light that the floor leaves to a surface near it, such as the underside of
// a shoe.
float above_floor(float height_m, float normal_y) {
    float near = 0.1 / (0.1 + max(height_m - ambient_glow.w, 0.0));
    return 1.0 - ambient_base.w * near * (0.5 - 0.5 * normal_y);
}
