// shadow.frag - leaves depth behind; where MASKED, only of what is drawn.

#ifdef MASKED
layout(binding = 0) uniform sampler2D base_color_texture;

in vec2 texture_at;
in float surface_alpha;
#endif

void main() {
#ifdef MASKED
    if (surface_alpha * texture(base_color_texture, texture_at).a < alpha_cutoff) discard;
#endif
}
