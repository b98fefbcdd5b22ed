// sky.vert - the whole picture, behind everything.
// Writes  the sight line from the eye, not normalised; corners come from the vertex number

out vec3 sight;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec4 far = world_from_clip * vec4(corner, 1.0, 1.0);
    sight = far.xyz / far.w - eye.xyz;
    gl_Position = vec4(corner, 1.0, 1.0);
}
