// shading.glsl - light that leaves a surface: metal or not, smooth or rough.
// The sun's reflection has the distribution of Trowbridge and Reitz (GGX) and Fresnel's factor by
// Schlick; visibility is the fit of Karis, "Optimizing PBR for Mobile" (SIGGRAPH 2015). The
// reflection of the sky is the sky's light on a surface that faces the mirrored direction, weighted
// by Schlick's factor with the roughness as its upper bound. Under equal light from everywhere, a
// white surface stays white whatever its roughness.

struct Surfel {
    vec3 base;
    vec3 normal;
    float metallic;
    float roughness;
    // Fraction of the sky's light that arrives.
    float occlusion;
    // 1 for skin.
    float skin;
};

// Returns the light from a surface to the eye. `to_eye` is a unit vector, and `shadow_position` a
// position in the shadow map.
vec3 shaded(Surfel at, vec3 to_eye, vec3 shadow_position) {
    float roughness = max(at.roughness, 0.15);
    vec3 albedo = at.base * (1.0 - at.metallic);
    vec3 mirror = mix(vec3(0.04), at.base, at.metallic);
    float grazing = 1.0 - clamp(dot(at.normal, to_eye), 0.0, 1.0);
    float grazing2 = grazing * grazing;
    vec3 rise = max(vec3(1.0 - roughness), mirror) - mirror;
    vec3 reflected = ambient_slope.w * (mirror + rise * (grazing2 * grazing2 * grazing));
    vec3 mirrored = reflect(-to_eye, at.normal);
    float facing = dot(at.normal, to_sun.xyz);
    vec3 sky = sky_light_on(at.normal, facing) * albedo * (1.0 - reflected)
             + sky_light_on(mirrored, dot(mirrored, to_sun.xyz)) * reflected;
    vec3 half_way = normalize(to_eye + to_sun.xyz);
    float aligned = max(dot(at.normal, half_way), 0.0);
    float along = max(dot(to_sun.xyz, half_way), 0.1);
    float alpha2 = roughness * roughness;
    alpha2 *= alpha2;
    float spread = aligned * aligned * (alpha2 - 1.0) + 1.0;
    float lobe = alpha2 / (spread * spread * 4.0 * along * along * (roughness + 0.5));
    vec3 wrap = at.skin * SKIN_WRAP;
    float sun = sunlit(shadow_position, facing + wrap.r);
    vec3 matt = albedo * max(facing + wrap, 0.0) / ((1.0 + wrap) * (1.0 + wrap));
    vec3 glossy = ambient_slope.w * lobe * max(facing, 0.0) * mirror;
    return at.occlusion * sky + sun * sun_color.rgb * (matt + glossy);
}
