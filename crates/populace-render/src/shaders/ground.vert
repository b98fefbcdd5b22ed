// ground.vert - the ground plane: a square around the eye that extends past the far plane.
// Reads   gl_VertexID, from which it computes the corner; no attributes
// Writes  world position, shadow map position

out vec3 world_position;
out vec3 shadow_position;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 from_eye = 1.5 * eye.w * corner;
    world_position = vec3(eye.x + from_eye.x, line_color.w, eye.z - from_eye.y);
    shadow_position = (shadow_from_world * vec4(world_position, 1.0)).xyz * 0.5 + 0.5;
    gl_Position = clip_from_world * vec4(world_position, 1.0);
    gl_ClipDistance[0] = 1.0;
}
