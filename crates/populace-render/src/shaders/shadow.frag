// shadow.frag - writes depth only. The MASKED variant discards fragments below the alpha cutoff.
// Reads   outputs of shadow.vert; base colour texture, for its alpha
// Writes  depth

#ifdef MASKED
layout(binding = 0) uniform sampler2D base_color_texture;

in vec2 texture_uv;
in float surface_alpha;
#endif

void main() {
#ifdef MASKED
    if (surface_alpha * texture(base_color_texture, texture_uv).a < alpha_cutoff) discard;
#endif
}
