// resolve.vert - the whole picture.
// Reads   gl_VertexID, from which it computes the corner; no attributes

void main() {
    gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0, 0.0, 1.0);
    gl_ClipDistance[0] = 1.0;
}
