// marks.vert - skins and projects a vertex of a member, for the depth and number of what is seen.
// Reads   the inputs of member.vert
// Writes  number of the instance, depth along the view in metres, texture coordinates and alpha.
//         With FADED, the part that is not drawn

flat out uint instance_number;
out float view_depth;
out vec2 texture_uv;
out float surface_alpha;
#ifdef FADED
flat out float faded;
#endif

void main() {
    vec3 model = vec4(position, 1.0) * model_from_bind();
    vec3 world = vec4(model, 1.0) * world_from_model();
    instance_number = entry_and_number.y;
    texture_uv = uv;
    surface_alpha = color.a;
    gl_Position = clip_from_world * vec4(world, 1.0);
    view_depth = gl_Position.w;
    gl_ClipDistance[0] = above_ground(world, gl_Position.w);
#ifdef FADED
    faded = faded_out();
#endif
    if (is_hidden()) gl_Position = OUTSIDE;
}
