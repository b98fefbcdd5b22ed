// contact.frag - darkens the ground beneath a capsule of a member: the part of the sky that it
// hides. By the view factor of a small surface, an element ds of a thin cylinder of radius r hides
// 2 r sin(a) h ds / (pi d^3) of the sky's light on the ground, where h is its height, d its
// distance and a the angle between the axis and the line of sight. Over the length of the axis,
// this has a closed form. A sphere hides (h / d) (r / d)^2; it stands for the capsule's nearer end.
// Reads   outputs of contact.vert
// Writes  0, with the fraction of the sky's light that is taken away as alpha

flat in vec4 low_end;
flat in vec4 high_end;
in vec2 ground_position;
flat in float opacity;

out vec4 color;

// Factor by choice. Eyes expect more than the sky's share: what the ground would reflect to the body
// and back is missing too.
const float EMPHASIS = 2.0;

// Integral from 0 to `s` of the height over the fourth power of the distance. The axis is `p` away
// at s = 0, where its height is `height`, and rises by `slope`.
float hidden_until(float s, float p, float height, float slope) {
    float squared = p * p + s * s;
    float level = (s / squared + atan(s, p) / p) / (p * p);
    float rise = s * s / (p * p * squared);
    return 0.5 * (height * level + slope * rise);
}

void main() {
    vec3 at = vec3(ground_position.x, 0.0, ground_position.y);
    vec3 axis = high_end.xyz - low_end.xyz;
    float radius = low_end.w;
    float length_m = max(length(axis), 1e-4);
    vec3 unit = axis / length_m;
    vec3 from_low = at - low_end.xyz;
    float foot = dot(from_low, unit);
    float p = max(length(from_low - foot * unit), radius);
    float height = low_end.y + foot * unit.y;
    float line = (2.0 / 3.14159265) * radius * p
               * (hidden_until(length_m - foot, p, height, unit.y)
                  - hidden_until(-foot, p, height, unit.y));
    vec3 to_sphere = clamp(foot, 0.0, length_m) * unit - from_low;
    float squared = dot(to_sphere, to_sphere);
    float ball = to_sphere.y * radius * radius * inversesqrt(squared) / squared;
    // Fades towards the edge of the rectangle, in which the whole shadow does not fit.
    float inside = max(1.0 - dot(to_sphere.xz, to_sphere.xz) / (high_end.w * high_end.w), 0.0);
    float hidden = clamp(EMPHASIS * max(line, ball), 0.0, 1.0) * inside * inside;
    color = vec4(vec3(0.0), ambient_base.w * opacity * hidden);
}
