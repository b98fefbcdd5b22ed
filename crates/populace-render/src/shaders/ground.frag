// ground.frag - paving that gives scale: a line every metre, a wider one every five metres. With
//               CONTACTS, bodies near it darken it.
// Reads   world position, shadow map position; contact map
// Writes  linear colour, which the framebuffer stores as sRGB

in vec3 world_position;
in vec3 shadow_position;

out vec4 color;

// Integral from 0 to `at` of a row of pulses of width `width`, one after each integer.
vec2 pulses_until(vec2 at, float width) { return floor(at) * width + min(fract(at), width); }

// Fraction of the pixel's footprint that lines around integers cover. The average over the
// footprint makes lines fade with distance instead of flickering.
float lines(vec2 at, float width) {
    vec2 footprint = max(fwidth(at), 1e-4);
    vec2 middle = at + 0.5 * width;
    vec2 share = pulses_until(middle + 0.5 * footprint, width)
               - pulses_until(middle - 0.5 * footprint, width);
    share = clamp(share / footprint, 0.0, 1.0);
    return 1.0 - (1.0 - share.x) * (1.0 - share.y);
}

void main() {
    vec2 at = world_position.xz;
    float coverage = max(0.6 * lines(at, 0.03), lines(at / 5.0, 0.016));
    vec3 base = mix(ground_color.rgb, line_color.rgb, coverage);
    vec3 sun = sunlight_on(to_sun.y, vec3(0.0), shadow_position);
    vec3 sky = sky_light_on(vec3(0.0, 1.0, 0.0), to_sun.y);
    vec3 light = sky + sun;
#ifdef CONTACTS
    light = darkened(light, sky, gl_FragCoord.xy);
#endif
    vec3 lit = base * light;
    color = vec4(tone_mapped(hazed(lit, haze_at(world_position))), 1.0);
}
