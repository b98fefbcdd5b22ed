// member.vert - skins a vertex of a member and puts it into the picture.
// Reads   Vertex and Influences per vertex, InstanceData per instance, the palette of the bound page
// Writes  world position and normal, texture coordinates, colour of surface, vertex and tint together

out vec3 world_position;
out vec3 world_normal;
out vec3 shadow_position;
out vec2 texture_at;
out vec4 surface_color;

void main() {
    mat3x4 model_from_bind = model_from_bind();
    mat3x4 world_from_model = world_from_model();
    world_position = vec4(vec4(position, 1.0) * model_from_bind, 1.0) * world_from_model;
    world_normal = turn_normal(world_from_model, turn_normal(model_from_bind, normal));
    // Stepping off the surface by about a shadow texel keeps it from shading itself.
    vec3 off = world_position + world_normal * (1.5 * to_sun.w);
    shadow_position = (shadow_from_world * vec4(off, 1.0)).xyz * 0.5 + 0.5;
    texture_at = uv;
    surface_color = base_color * color * vec4(tint, 1.0);
    gl_Position = clip_from_world * vec4(world_position, 1.0);
}
