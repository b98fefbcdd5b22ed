// grid.glsl - the grid of samples, on which members are drawn: the picture turned by 45 degrees. Its
//             samples lie in the middle of the edges of pixels.
// Reads    Frame
// Defines  on_grid(): a position in the picture's clip space in that of the grid
//          sample_at(): the place on the grid, in samples, of a place in the picture, in pixels
//          pixel_at(): the inverse

vec4 on_grid(vec4 clip) {
    vec2 share = picture.zw * clip.xy;
    return vec4(share.x + share.y, share.y - share.x, clip.zw);
}

vec2 sample_at(vec2 pixel) {
    return vec2(pixel.x + pixel.y, pixel.y - pixel.x + picture.x);
}

vec2 pixel_at(vec2 at) {
    return 0.5 * vec2(at.x - at.y + picture.x, at.x + at.y - picture.x);
}
