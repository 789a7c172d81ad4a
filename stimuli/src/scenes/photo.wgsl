// A photograph that covers the display in mirrored tiles.

struct Photo {
    origin_px: vec2f,
    step_px: vec2f,
    // Display pixel at which one unmirrored tile begins.
    tile_px: vec2f,
    // Display pixels per pixel of the photograph.
    scale: f32,
    reserved: f32,
}

// Whether the scale is 1. A constant, because software devices run both branches for every pixel.
override UNSCALED: bool = false;

@group(0) @binding(0) var<uniform> u: Photo;
@group(0) @binding(1) var photograph: texture_2d<f32>;

fn texel(index: vec2i) -> vec3f {
    let size = vec2i(textureDimensions(photograph));
    return textureLoad(photograph, vec2i(mirrored(index.x, size.x), mirrored(index.y, size.y)), 0).rgb;
}

// The photograph at a place of the display. Unscaled, a pixel is a texel; otherwise four are mixed.
fn photograph_at(px: vec2f) -> vec3f {
    let place = (px - u.tile_px) / u.scale;
    if UNSCALED {
        return texel(vec2i(floor(place)));
    }
    let corner = floor(place - 0.5);
    let share = place - 0.5 - corner;
    let index = vec2i(corner);
    let top = mix(texel(index), texel(index + vec2i(1, 0)), share.x);
    let bottom = mix(texel(index + vec2i(0, 1)), texel(index + vec2i(1, 1)), share.x);
    return mix(top, bottom, share.y);
}

// At the display's own pixels: one sample, as in `photo`, without its loops, which software devices pay for.
@fragment
fn photo_sampled(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return half_colour(photograph_at(u.origin_px + position.xy));
}

@fragment
fn photo(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // One sample for each texel under a pixel of the target, so that coarse targets hold averages.
    let samples = max(vec2i(ceil(u.step_px / min(u.scale, 1.0) - 1e-3)), vec2i(1));
    let corner = u.origin_px + (position.xy - 0.5) * u.step_px;
    var sum = vec3f(0.0);
    for (var j = 0; j < samples.y; j++) {
        for (var i = 0; i < samples.x; i++) {
            sum += photograph_at(corner + (vec2f(f32(i), f32(j)) + 0.5) / vec2f(samples) * u.step_px);
        }
    }
    return half_colour(sum / f32(samples.x * samples.y));
}
