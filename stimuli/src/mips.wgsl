// One level of a mip chain: every texel is the average of the area under it. Where both sides of the level before are even
// these are 2×2 texels; of an odd side, three with the outer ones in part.

struct Mips {
    source: vec2i,
    target_size: vec2i,
}

@group(0) @binding(0) var<uniform> u: Mips;
@group(0) @binding(1) var finer: texture_2d<f32>;

// How much of texel `index` lies between `low` and `high`.
fn covered(index: i32, low: f32, high: f32) -> f32 {
    return max(min(f32(index + 1), high) - max(f32(index), low), 0.0);
}

@fragment
fn shrink(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let ratio = vec2f(u.source) / vec2f(u.target_size);
    let low = floor(position.xy) * ratio;
    let high = low + ratio;
    let first = vec2i(floor(low));
    let last = min(vec2i(ceil(high - 1e-4)), u.source) - 1;
    var sum = vec3f(0.0);
    var area = 0.0;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let share = covered(x, low.x, high.x) * covered(y, low.y, high.y);
            sum += share * textureLoad(finer, vec2i(x, y), 0).rgb;
            area += share;
        }
    }
    return half_colour(sum / area);
}
