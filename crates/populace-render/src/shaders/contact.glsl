// contact.glsl - contact shadows on the floor.
// Reads    contact map of the picture
// Defines  clear_sky(): part of the sky's light that bodies leave to the floor at this pixel

layout(binding = 8) uniform sampler2D contact_map;

float clear_sky() { return texelFetch(contact_map, ivec2(gl_FragCoord.xy), 0).r; }
