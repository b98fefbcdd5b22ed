// marks.frag - says what a pixel shows. The MASKED variant discards fragments below the alpha
//              cutoff, and BLENDED those that hide less than half of what is behind them. FADED
//              leaves out the pixels that member.frag leaves out.
// Reads   outputs of marks.vert; base colour texture, for its alpha
// Writes  bits of the depth along the view in metres, and 1 plus the number of the instance

#ifdef TEXTURED
layout(binding = 0) uniform sampler2D base_color_texture;
#endif

flat in uint instance_number;
in float view_depth;
in vec2 texture_uv;
in float surface_alpha;

out uvec2 mark;

void main() {
#ifdef FADED
    if (is_faded_out()) discard;
#endif
#if defined(MASKED) || defined(BLENDED)
    float alpha = surface_alpha;
#ifdef TEXTURED
    alpha *= texture(base_color_texture, texture_uv).a;
#endif
#ifdef MASKED
    if (alpha < alpha_cutoff) discard;
#else
    if (alpha < 0.5) discard;
#endif
#endif
    mark = uvec2(floatBitsToUint(view_depth), instance_number + 1u);
}
