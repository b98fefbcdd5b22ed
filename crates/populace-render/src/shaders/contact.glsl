// contact.glsl - contact shadows on the floor.
// Reads    contact map of the picture
// Defines  darkened(): the light of a floor at a pixel without what bodies hide of the sky

layout(binding = 8) uniform sampler2D contact_map;

float clear_sky(vec2 pixel) {
    return textureLod(contact_map, pixel / picture.xy, 0.0).r;
}

// Returns the light of a floor without what bodies hide of the sky's. All of it is darker by that
// much and keeps its hue: without blue light of the sky the sun's would leave a brown stain, which
// light between bodies and the ground fills in nature.
vec3 darkened(vec3 light, vec3 of_sky, vec2 pixel) {
    const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
    float hidden = (1.0 - clear_sky(pixel)) * dot(LUMINANCE, of_sky);
    return light * clamp(1.0 - hidden / max(dot(LUMINANCE, light), 1e-6), 0.0, 1.0);
}
