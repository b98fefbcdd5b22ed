// sky.frag - from the horizon's colour up to the zenith's.

in vec3 sight;

out vec4 color;

void main() {
    float height = max(normalize(sight).y, 0.0);
    color = vec4(tone_mapped(mix(zenith_color.rgb, horizon_color.rgb, exp(-5.0 * height))), 1.0);
}
