#version 430
// Skins and places a vertex. A palette entry is three rows of a 3 x 4 matrix, `model_from_bind`. A
// shadow is the figure, pressed flat along the light.
struct Member { vec4 world_from_model[3]; vec3 shirt; uint palette_first; };
layout(std430, binding = 0) readonly buffer Palettes { vec4 palettes[]; };
layout(std430, binding = 1) readonly buffer Members { Member members[]; };
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uvec4 entries;
layout(location = 3) in vec4 weights;
layout(location = 0) uniform mat4 clip_from_world;
layout(location = 1) uniform vec4 part_color;
layout(location = 2) uniform bool shadow;
out vec3 color;
void main() {
    Member member = members[gl_InstanceID];
    vec3 p = vec3(0), n = vec3(0), world, up;
    for (int i = 0; i < 4; i++) {
        uint first = (member.palette_first + entries[i]) * 3;
        for (int row = 0; row < 3; row++) {
            p[row] += weights[i] * dot(palettes[first + row], vec4(position, 1));
            n[row] += weights[i] * dot(palettes[first + row], vec4(normal, 0));
        }
    }
    for (int row = 0; row < 3; row++) {
        world[row] = dot(member.world_from_model[row], vec4(p, 1));
        up[row] = dot(member.world_from_model[row], vec4(n, 0));
    }
    vec3 sun = normalize(vec3(0.5, 1, 0.6));
    float light = 0.35 + 0.75 * max(0, dot(normalize(up), sun));
    color = part_color.rgb * mix(vec3(1), member.shirt, part_color.a) * light;
    if (shadow) { world -= sun * world.y / sun.y; color = vec3(0.17, 0.18, 0.19); }
    gl_Position = clip_from_world * vec4(world, 1);
}
