// sky.frag - gradient from the horizon's colour to the zenith's.
// Reads   view direction
// Writes  linear colour, which the framebuffer stores as sRGB

in vec3 view_direction;

out vec4 color;

void main() {
    float height = max(normalize(view_direction).y, 0.0);
    color = vec4(tone_mapped(mix(zenith_color.rgb, horizon_color.rgb, exp(-5.0 * height))), 1.0);
}
