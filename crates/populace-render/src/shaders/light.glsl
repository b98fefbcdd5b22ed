// light.glsl - sun, sky, shadow and haze, the same for members and the ground. Colours are linear.

layout(binding = 1) uniform sampler2DShadow shadow_map;

// How much of the sun reaches a place, from 0 to 1; `at` is its place in the shadow map. Four taps, each blended from
// four texels by the sampler. Outside the map nothing is in the way.
float sunlit(vec3 at) {
    if (to_sun.w == 0.0) return 1.0;
    vec2 texel = 0.8 / vec2(textureSize(shadow_map, 0));
    float sum = texture(shadow_map, vec3(at.xy + texel * vec2(-1.0, -0.4), at.z))
              + texture(shadow_map, vec3(at.xy + texel * vec2(0.4, -1.0), at.z))
              + texture(shadow_map, vec3(at.xy + texel * vec2(1.0, 0.4), at.z))
              + texture(shadow_map, vec3(at.xy + texel * vec2(-0.4, 1.0), at.z));
    return 0.25 * sum;
}

// Lambert for the sun; for the rest, the sky above and the ground's reflection below.
vec3 light_on(vec3 normal, vec3 shadow_at) {
    float facing = dot(normal, to_sun.xyz);
    float sun = facing > 0.0 ? facing * sunlit(shadow_at) : 0.0;
    return mix(ground_light.rgb, sky_light.rgb, 0.5 + 0.5 * normal.y) + sun * sun_color.rgb;
}

// Hides where the world ends: nothing up to a tenth of the far plane's distance, all before it is reached.
vec3 hazed(vec3 color, vec3 world_position) {
    float share = smoothstep(0.1, 0.95, distance(world_position, eye.xyz) / eye.w);
    return mix(color, horizon_color.rgb, share);
}

// Tone mapping: linear up to a knee, then a shoulder that nears white without reaching it, so that sunlit white cloth
// keeps its folds. Value and slope are continuous at the knee; a knee of 1 cuts off at white.
vec3 tone_mapped(vec3 color) {
    float knee = sun_color.w;
    float room = 1.0 - knee;
    vec3 over = max(color - knee, 0.0) / max(room, 1e-3);
    return min(color, knee) + room * (1.0 - exp(-over));
}
