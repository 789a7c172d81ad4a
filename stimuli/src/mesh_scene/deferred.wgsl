// The colour of a pixel of a G-buffer; `px` is its place on the display.
fn shade_texels(normal_roughness: vec4f, albedo_metalness: vec4f, emission: vec4f, inverse_depth: f32, px: vec2f) -> vec3f {
    if emission.a < 0.25 {
        return emission.rgb;
    }
    var s: Surface;
    s.at = frame.eye.xyz + ray_through(px) / inverse_depth;
    s.normal = normalize(normal_roughness.xyz);
    s.view = normalize(frame.eye.xyz - s.at);
    s.albedo = albedo_metalness.rgb;
    s.roughness = normal_roughness.w;
    s.metalness = albedo_metalness.w;
    s.emission = emission.rgb;
    s.open = clamp(2.0 * emission.a - 1.0, 0.0, 1.0);
    return seen(shade(s)).rgb;
}
