// beyond.vert - the corners of the grid of samples, outside of the picture. They have the least depth
//               and hide members there.
// Reads   gl_VertexID: corners of the picture and of the grid in turn; no attributes

void main() {
    int corner = gl_VertexID >> 1 & 3;
    vec2 side = vec2(corner == 1 || corner == 2, corner >= 2) * 2.0 - 1.0;
    // A quarter of a pixel outside of the edges, on which samples lie.
    vec4 picture_corner = on_grid(vec4(side * (1.0 + 0.5 / picture.xy), -1.0, 1.0));
    gl_Position = (gl_VertexID & 1) == 0 ? picture_corner : vec4(side, -1.0, 1.0);
    gl_ClipDistance[0] = 1.0;
}
