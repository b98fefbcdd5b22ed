// interface.frag - triangles of the user interface.
// Reads   colour, and a texture in the same coding
// Writes  sRGB with premultiplied alpha, which is blended without being decoded

layout(binding = 0) uniform sampler2D sheet;

in vec4 tint;
in vec2 texel;
out vec4 color_out;

void main() {
    color_out = tint * texture(sheet, texel);
}
