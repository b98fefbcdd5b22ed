// member.vert - skins and projects a vertex of a member.
// Reads   Vertex and Influences per vertex, InstanceData per instance, palette of the bound page
// Writes  place on the grid of samples, texture coordinates, product of vertex colour and the
//         region's tint, and what light and haze need: position and normal in world space, the
//         position in the shadow map and the surface's substance (metallic, roughness, skin).
//         With VERTEX_LIT, the factor of the texture's colour and what is added to it instead, and
//         with TWO_SIDED also the back's factor; without a texture, the colours that are seen.
//         With FADED, the part that is not drawn

#ifdef VERTEX_LIT
out vec4 factor;
#ifdef TWO_SIDED
out vec3 back_factor;
#endif
#ifdef SAMPLED
out vec3 added;
#endif
#ifdef EMISSIVE_MAP
out float clearness;
#endif
#else
out vec3 world_position;
out vec3 world_normal;
out vec3 shadow_position;
out vec3 substance;
out vec4 surface_color;
#endif
out vec2 texture_uv;
#ifdef FADED
flat out float faded;
#endif

void main() {
    mat3x4 model_from_bind = model_from_bind();
    mat3x4 world_from_model = world_from_model();
#ifdef VERTEX_LIT
    vec3 world_position, world_normal, shadow_position, substance;
#endif
    world_position = vec4(vec4(position, 1.0) * model_from_bind, 1.0) * world_from_model;
    world_normal = transform_normal(world_from_model, transform_normal(model_from_bind, normal));
    // An offset along the normal by 1.5 shadow texels, or three errors of the level that throws
    // the shadow, prevents self-shadowing: poses add to errors, which are those at rest.
    float offset_m = max(1.5 * to_sun.w, 3.0 * caster_apart_m);
    vec3 offset_position = world_position + world_normal * offset_m;
    shadow_position = (shadow_from_world * vec4(offset_position, 1.0)).xyz * 0.5 + 0.5;
    substance = vec3(vec2(marks.zw) * (1.0 / 255.0), marks.x == 0u ? 1.0 : 0.0);
    vec4 tinted = color * vec4(region_tint(), 1.0);
#ifdef VERTEX_LIT
    float facing = dot(world_normal, to_sun.xyz);
    vec3 wrap = substance.z * SKIN_WRAP;
    vec3 light = above_floor(world_position.y, world_normal.y) * sky_light_on(world_normal, facing)
               + sunlight_on(facing, wrap, shadow_position);
    // Reflection of the sky: that of a rough and upright surface that is no metal.
    vec3 reflected = 0.05 * ambient_slope.w * ambient_base.rgb;
    vec4 haze = haze_at(world_position);
    vec3 clear = tinted.rgb * (1.0 - haze.a);
    vec3 constant = reflected;
#if defined(EMISSIVE) && !defined(EMISSIVE_MAP)
    constant += emissive.rgb;
#endif
    constant = hazed(constant, haze);
    factor = vec4(clear * (light - reflected), tinted.a);
#ifdef TWO_SIDED
    vec3 back_light = above_floor(world_position.y, -world_normal.y)
                    * sky_light_on(-world_normal, -facing)
                    + sunlight_on(-facing, wrap, shadow_position);
    back_factor = clear * (back_light - reflected);
#endif
#ifdef SAMPLED
    added = constant;
#ifdef EMISSIVE_MAP
    clearness = 1.0 - haze.a;
#endif
#else
    factor.rgb = tone_mapped(factor.rgb + constant);
#ifdef TWO_SIDED
    back_factor = tone_mapped(back_factor + constant);
#endif
#endif
#else
    surface_color = tinted;
#endif
    texture_uv = uv;
    gl_Position = on_grid(clip_from_world * vec4(world_position, 1.0));
    gl_ClipDistance[0] = above_ground(world_position, gl_Position.w);
#ifdef FADED
    faded = faded_out();
#endif
    if (is_hidden()) gl_Position = OUTSIDE;
}
