// sunk.glsl - what lies beyond the ground, which is drawn without depth.
// Reads    Frame
// Defines  above_ground(): distance to the clipping plane, negative for what the ground hides

// Soles on the ground stay visible: members may sink into it by the size of a pixel.
float above_ground(vec3 world_position, float depth_m) {
    float sunk_m = ground_color.w * depth_m;
    float ground_m = line_color.w;
    float above_m = sign(eye.y - ground_m) * (world_position.y - ground_m);
    return ground_color.w > 0.0 ? above_m + sunk_m : 1.0;
}
