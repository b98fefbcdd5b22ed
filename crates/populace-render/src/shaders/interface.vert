// interface.vert - triangles of the user interface.
// Reads   corners in clip space, with sRGB colours and premultiplied alpha in 1/255
// Writes  colour and texture coordinates

out vec4 tint;
out vec2 texel;

void main() {
    gl_Position = vec4(position, 0.0, 1.0);
    tint = vec4(color) / 255.0;
    texel = uv;
}
