#version 430
// A square of 80 m.
layout(location = 0) uniform mat4 clip_from_world;
out vec3 color;
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 80 - 40;
    color = vec3(0.36, 0.37, 0.36);
    gl_Position = clip_from_world * vec4(corner.x, 0, -corner.y, 1);
}
