// shadow.vert - skins a vertex of a member as the sun sees it.
// Reads   what member.vert reads
// Writes  texture coordinates and alpha for masked surfaces

out vec2 texture_at;
out float surface_alpha;

void main() {
    vec3 model = vec4(position, 1.0) * model_from_bind();
    vec3 world = vec4(model, 1.0) * world_from_model();
    texture_at = uv;
    surface_alpha = base_color.a * color.a;
    gl_Position = shadow_from_world * vec4(world, 1.0);
}
