// White noise: one independent grey for every pixel of the display, also beyond its edges; or a tile of coloured noise,
// again and again.

struct Noise {
    origin_px: vec2f,
    step_px: vec2f,
    seed: u32,
    contrast: f32,
    reserved: vec2f,
}

@group(0) @binding(0) var<uniform> u: Noise;
// As wide and high as a power of two.
@group(0) @binding(1) var tile: texture_2d<f32>;

// The three-dimensional PCG hash of Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 9(3), 2020).
fn pcg3d(key: vec3u) -> vec3u {
    var v = key * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Uniform in 0..1 with 24 bits, never at either end.
fn value(px: vec2i) -> f32 {
    let bits = pcg3d(vec3u(bitcast<vec2u>(px), u.seed)).x;
    return (f32(bits >> 8u) + 0.5) / 16777216.0;
}

@fragment
fn noise(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // Averages what falls under a pixel that is larger than the display's.
    let samples = max(vec2i(ceil(u.step_px - 1e-3)), vec2i(1));
    let corner = u.origin_px + (position.xy - 0.5) * u.step_px;
    var sum = 0.0;
    for (var j = 0; j < samples.y; j++) {
        for (var i = 0; i < samples.x; i++) {
            let place = corner + (vec2f(f32(i), f32(j)) + 0.5) / vec2f(samples) * u.step_px;
            sum += value(vec2i(floor(place)));
        }
    }
    let mean = sum / f32(samples.x * samples.y);
    return half_colour(vec3f(0.5 + u.contrast * (mean - 0.5)));
}

@fragment
fn coloured(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let samples = max(vec2i(ceil(u.step_px - 1e-3)), vec2i(1));
    let corner = u.origin_px + (position.xy - 0.5) * u.step_px;
    let wrap = vec2i(textureDimensions(tile)) - 1;
    var sum = 0.0;
    for (var j = 0; j < samples.y; j++) {
        for (var i = 0; i < samples.x; i++) {
            let place = corner + (vec2f(f32(i), f32(j)) + 0.5) / vec2f(samples) * u.step_px;
            sum += textureLoad(tile, vec2i(floor(place)) & wrap, 0).r;
        }
    }
    return half_colour(vec3f(sum / f32(samples.x * samples.y)));
}
