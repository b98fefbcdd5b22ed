// contact.vert - a rectangle on the ground around the contact shadow of a capsule of a member.
// Reads   Contact per vertex, InstanceData per instance, palette of the bound page
// Writes  ends of the capsule, with its radius and the shadow's reach; position on the floor, and the
//         part of the member that is drawn. Heights are those above the floor.

flat out vec4 low_end;
flat out vec4 high_end;
out vec2 ground_position;
flat out float opacity;

// Capsules that hide less of the sky than this are not drawn.
const float FAINTEST = 0.04;
// Reach of a shadow in radii of an upright capsule.
const float REACH = 6.0;

void main() {
    mat3x4 model_from_bind = model_from_bind();
    mat3x4 world_from_model = world_from_model();
    vec3 first = vec4(vec4(from.xyz, 1.0) * model_from_bind, 1.0) * world_from_model;
    vec3 last = vec4(vec4(to.xyz, 1.0) * model_from_bind, 1.0) * world_from_model;
    // The change of the radius: that of a length along x in bind space.
    vec3 side = vec4(vec4(1.0, 0.0, 0.0, 0.0) * model_from_bind, 0.0) * world_from_model;
    float radius = from.w * length(side);
    first.y -= ambient_glow.w;
    last.y -= ambient_glow.w;
    bool is_first_low = first.y < last.y;
    vec3 low = is_first_low ? first : last;
    vec3 high = is_first_low ? last : first;
    // A capsule that sinks into the ground lies on it.
    float height = max(low.y, 0.5 * radius);
    low.y = height;
    high.y = max(high.y, height);
    low_end = vec4(low, radius);
    float reach = REACH * radius + height;
    high_end = vec4(high, reach);
    vec2 along = high.xz - low.xz;
    float squared = dot(along, along);
    vec2 unit = squared > 1e-8 ? along * inversesqrt(squared) : vec2(1.0, 0.0);
    vec2 across = vec2(-unit.y, unit.x);
    vec2 end = corner.x < 0.0 ? low.xz : high.xz;
    ground_position = end + reach * (corner.x * unit + corner.y * across);
    vec3 at = vec3(ground_position.x, ambient_glow.w, ground_position.y);
    opacity = 1.0 - faded_out();
    bool is_faint = radius * radius < FAINTEST * height * height;
    gl_Position = is_faint ? vec4(2.0, 2.0, 2.0, 1.0) : clip_from_world * vec4(at, 1.0);
    gl_ClipDistance[0] = 1.0;
}
