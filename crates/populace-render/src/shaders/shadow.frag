// shadow.frag - writes depth only. The MASKED variant discards fragments below the alpha cutoff.
// Reads   outputs of shadow.vert; base colour texture, for its alpha
// Writes  depth

#ifdef MASKED
#ifdef TEXTURED
layout(binding = 0) uniform sampler2D base_color_texture;
#endif

in vec2 texture_uv;
in float surface_alpha;
#endif

void main() {
#ifdef MASKED
    float alpha = surface_alpha;
#ifdef TEXTURED
    alpha *= texture(base_color_texture, texture_uv).a;
#endif
    if (alpha < alpha_cutoff) discard;
#endif
}
