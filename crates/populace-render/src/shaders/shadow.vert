// shadow.vert - skins a vertex of a member and projects it into the shadow map.
// Reads   the inputs of member.vert
// Writes  texture coordinates and alpha, which masked surfaces need

out vec2 texture_uv;
out float surface_alpha;

void main() {
    vec3 model = vec4(position, 1.0) * model_from_bind();
    vec3 world = vec4(model, 1.0) * world_from_model();
    texture_uv = uv;
    surface_alpha = color.a;
    gl_Position = is_hidden() ? OUTSIDE : shadow_from_world * vec4(world, 1.0);
}
