// resolve.frag - averages the members' samples, to be blended over the surroundings.
// Reads   samples of one pixel: linear colour times alpha, and alpha; 0 where there is no member
// Writes  linear colour and alpha; nothing where there is no member

layout(binding = 2) uniform sampler2DMS member_samples;

out vec4 color;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(member_samples, at, 0);
    for (int i = 1; i < SAMPLES; ++i) sum += texelFetch(member_samples, at, i);
    if (sum.a == 0.0) discard;
    color = vec4(sum.rgb / sum.a, sum.a / float(SAMPLES));
}
