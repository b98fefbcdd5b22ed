// resolve.frag - averages the members' samples, to be blended over the surroundings.
// Reads   samples: linear colour times alpha, and alpha; 0 where there is no member
// Writes  linear colour and alpha; nothing where there is no member

layout(binding = 2) uniform sampler2D member_samples;

out vec4 color;

void main() {
    // Between the four samples on the pixel's edges.
    vec2 at = sample_at(gl_FragCoord.xy) / (picture.x + picture.y);
    vec4 mean = textureLod(member_samples, at, 0.0);
    if (mean.a == 0.0) discard;
    color = vec4(mean.rgb / mean.a, mean.a);
}
