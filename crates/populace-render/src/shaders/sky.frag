// sky.frag - gradient from the horizon's colour to the zenith's, and the glow around the sun.
// Reads   view direction
// Writes  linear colour, which the framebuffer stores as sRGB

in vec3 view_direction;

out vec4 color;

void main() {
    vec3 direction = normalize(view_direction);
    float toward = max(dot(direction, to_sun.xyz), 0.0);
    float near_sun = toward * toward;
    vec3 sky = mix(zenith_color.rgb, horizon_color.rgb, exp(-5.0 * max(direction.y, 0.0)));
    sky += near_sun * near_sun * glow_color.rgb;
    // The sun is half a degree wide; the air brightens some degrees around it.
    float disc = smoothstep(0.99997, 0.99999, toward) + 0.05 * exp2(3000.0 * (toward - 1.0));
    sky += glow_color.w * disc * sun_color.rgb;
    color = vec4(tone_mapped(sky), 1.0);
}
