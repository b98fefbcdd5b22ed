// light.glsl - sun, ambient light, shadow and haze of members and ground. Colours are linear.

layout(binding = 1) uniform sampler2DShadow shadow_map;

// Fraction of the sun's light that arrives at a position in the shadow map, from 0 to 1. Averages
// four taps, each of which the sampler filters from four texels. 1 outside of the map.
float sunlit(vec3 at) {
    vec2 texel = 0.8 / vec2(textureSize(shadow_map, 0));
    float sum = texture(shadow_map, vec3(at.xy + texel * vec2(-1.0, -0.4), at.z))
              + texture(shadow_map, vec3(at.xy + texel * vec2(0.4, -1.0), at.z))
              + texture(shadow_map, vec3(at.xy + texel * vec2(1.0, 0.4), at.z))
              + texture(shadow_map, vec3(at.xy + texel * vec2(-0.4, 1.0), at.z));
    // Without a branch, which software rasterizers do not skip: they mask both sides.
    return to_sun.w > 0.0 ? 0.25 * sum : 1.0;
}

// Light on a surface with unit normal `normal`: Lambert's law for the sun, and ambient light
// interpolated between sky and ground.
vec3 light_on(vec3 normal, vec3 shadow_position) {
    float facing = dot(normal, to_sun.xyz);
    float sun = max(facing, 0.0) * sunlit(shadow_position);
    return mix(ground_light.rgb, sky_light.rgb, 0.5 + 0.5 * normal.y) + sun * sun_color.rgb;
}

// Fraction of haze, which hides the edge of the world: none up to a tenth of the far plane's
// distance, full before the far plane.
float haze_at(vec3 world_position) {
    return smoothstep(0.1, 0.95, distance(world_position, eye.xyz) / eye.w);
}

vec3 hazed(vec3 color, float haze) { return mix(color, horizon_color.rgb, haze); }

// Tone mapping: linear up to a knee, then a shoulder that approaches white, so that sunlit white
// cloth keeps its folds. Value and slope are continuous at the knee. A knee of 1 clips at white.
vec3 tone_mapped(vec3 color) {
    float knee = sun_color.w;
    float headroom = 1.0 - knee;
    vec3 over = max(color - knee, 0.0) / max(headroom, 1e-3);
    return min(color, knee) + headroom * (1.0 - exp(-over));
}
