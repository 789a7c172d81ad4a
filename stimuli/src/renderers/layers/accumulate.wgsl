// A layer's new drawing is averaged with its accumulated picture, each pixel with the place where its surface was.
//
// In alpha the accumulated picture holds two things: before the point the number n of samples in its average, behind it
// z / (1 + z), where z is the inverse depth averaged just as the colour was. What z says is thus what the colour is made of.

struct Accumulate {
    // Display pixels per layer pixel.
    step_px: vec2f,
    // The newest sample never weighs less.
    least_weight: f32,
    // Relative, of inverse depth.
    tolerance: f32,
    // From a pixel of this view to the same place in the earlier one.
    offset: vec2i,
    // Pixels in use; none in the earlier view where there is no earlier picture.
    size: vec2i,
    earlier_size: vec2i,
    reserved: vec2i,
}

@group(0) @binding(0) var<uniform> u: Accumulate;
@group(0) @binding(1) var drawn: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var earlier: texture_2d<f32>;

// Inverse depths that are nearer to each other than this are as good as the sky.
const SKY: f32 = 1e-4;
// Farther than any display.
const AWAY: f32 = 6e4;

// By its bits, since a shader may take for granted that there are no others.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn all_finite(v: vec4f) -> bool {
    return is_finite(v.x) && is_finite(v.y) && is_finite(v.z) && is_finite(v.w);
}

fn packed(n: f32, z: f32) -> f32 {
    return n + z / (1.0 + z);
}

fn motion_at(at: vec2i) -> vec4f {
    let found = textureLoad(motion, clamp(at, vec2i(0), u.size - 1), 0);
    // What cannot be followed has come from nowhere.
    return select(vec4f(AWAY, AWAY, 0.0, 0.0), found, all_finite(found));
}

struct Past {
    // Colour, and inverse depth.
    picture: vec4f,
    samples: f32,
    // Share of the place that is the same surface and in view.
    share: f32,
}

// What was at `at`, in pixels of the earlier picture, as far as its inverse depth lies in `depths`.
fn past(at: vec2f, depths: vec2f) -> Past {
    var sum = Past(vec4f(0.0), 0.0, 0.0);
    let corner = floor(at);
    let high = at - corner;
    for (var tap = 0; tap < 4; tap++) {
        let aside = vec2i(tap & 1, tap >> 1u);
        let place = vec2i(corner) + aside;
        if any(place < vec2i(0)) || any(place >= u.earlier_size) {
            continue;
        }
        let weights = select(1.0 - high, high, aside == vec2i(1));
        let weight = weights.x * weights.y;
        let found = textureLoad(earlier, place, 0);
        let n = floor(found.w);
        let part = found.w - n;
        let z = part / (1.0 - part);
        if n >= 1.0 && z >= depths.x && z <= depths.y {
            sum.picture += weight * vec4f(found.rgb, z);
            sum.samples += weight * n;
            sum.share += weight;
        }
    }
    return sum;
}

@fragment
fn accumulate(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = vec2i(position.xy);
    let now = textureLoad(drawn, here, 0);
    let moved = motion_at(here);

    // The surfaces in this pixel and at its sides, as deep as they were then: where an edge goes through the pixel, jitter
    // shows now one and now the other, and both belong to it. How far they part is how much of it may be new.
    var nearest = moved.z;
    var farthest = moved.z;
    var parting = 0.0;
    for (var dy = -1; dy <= 1; dy++) {
        for (var dx = -1; dx <= 1; dx++) {
            let beside = motion_at(here + vec2i(dx, dy));
            nearest = max(nearest, beside.z);
            farthest = min(farthest, beside.z);
            parting = max(parting, length((beside.xy - moved.xy) / u.step_px));
        }
    }
    let depths = vec2f(farthest * (1.0 - u.tolerance) - SKY, nearest * (1.0 + u.tolerance) + SKY);

    // A jittered sample belongs to its pixel's middle, so the middle is what is followed.
    var found = Past(vec4f(0.0), 0.0, 0.0);
    if u.earlier_size.x > 0 && all(abs(moved.xy) < vec2f(0.5 * AWAY)) {
        found = past(vec2f(here + u.offset) + moved.xy / u.step_px, depths);
    }
    let usable = found.share > 0.2;
    let colour = found.picture.rgb / max(found.share, 1e-6);
    let depth = max(found.picture.w / max(found.share, 1e-6) + moved.w - moved.z, 0.0);
    let samples = round(found.samples / max(found.share, 1e-6));

    if !all_finite(now) {
        // A value that is none must not live on.
        return select(vec4f(0.0), vec4f(colour, packed(samples, depth)), usable);
    }
    if !usable {
        return vec4f(now.rgb, packed(1.0, max(moved.w, 0.0)));
    }
    let weight = clamp(max(1.0 / (samples + 1.0), parting), u.least_weight, 1.0);
    return vec4f(mix(colour, now.rgb, weight), packed(max(round(1.0 / weight), 1.0), mix(depth, max(moved.w, 0.0), weight)));
}
