// sky.vert - the picture beyond where the ground ends, or all of it without ground.
// Reads   gl_VertexID, from which it computes the corner; no attributes
// Writes  view direction in world space, not normalised

out vec3 view_direction;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec4 far = world_from_clip * vec4(corner, 1.0, 1.0);
    view_direction = far.xyz / far.w - eye.xyz;
    gl_Position = vec4(corner, 1.0, 1.0);
    // On the far plane, the ground is as far below the eye as the eye is above the ground. An eye
    // under the ground sees the sky below it.
    float above_m = eye.y - line_color.w;
    float beyond_m = sign(above_m) * view_direction.y + 1.05 * abs(above_m);
    gl_ClipDistance[0] = ground_color.w > 0.0 ? beyond_m : 1.0;
}
