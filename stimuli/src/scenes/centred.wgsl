// A flat picture in the display's middle, a pixel of it on each of the display's, black around it.

struct Centred {
    origin_px: vec2f,
    step_px: vec2f,
    // Display pixel of the picture's top left corner.
    corner: vec2i,
    size: vec2i,
}

@group(0) @binding(0) var<uniform> u: Centred;
@group(0) @binding(1) var flat_picture: texture_2d<f32>;

fn texel(px: vec2f) -> vec3f {
    let at = vec2i(floor(px)) - u.corner;
    if any(at < vec2i(0)) || any(at >= u.size) {
        return vec3f(0.0);
    }
    return textureLoad(flat_picture, at, 0).rgb;
}

@fragment
fn centred(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // One sample for each texel under a pixel of the target, so that coarse targets hold averages.
    let samples = max(vec2i(ceil(u.step_px - 1e-3)), vec2i(1));
    let corner = u.origin_px + (position.xy - 0.5) * u.step_px;
    var sum = vec3f(0.0);
    for (var j = 0; j < samples.y; j++) {
        for (var i = 0; i < samples.x; i++) {
            sum += texel(corner + (vec2f(f32(i), f32(j)) + 0.5) / vec2f(samples) * u.step_px);
        }
    }
    return half_colour(sum / f32(samples.x * samples.y));
}
