// The Gaussian that is round in visual angle, as `foveation/low_pass.rs` defines it. The shader that follows declares `u`, a
// uniform whose `gaussian` is this.

struct Gaussian {
    geometry: Geometry,
    display_size: vec2i,
    // Standard deviations after which the Gaussian ends.
    truncation: f32,
    reserved: f32,
    // Bounds of the table of `effective_sigma_px`.
    table_from_px: f32,
    table_to_px: f32,
    reserved2: vec2f,
    table: array<vec4f, 16>,
}

const TABLE_STEPS: f32 = 63.0;

fn table_entry(index: u32) -> f32 {
    return u.gaussian.table[index >> 2u][index & 3u];
}

// Factor on the standard deviation of a Gaussian that is sampled at the pixels.
fn sampled_gaussian_factor(sigma_px: f32) -> f32 {
    if sigma_px >= u.gaussian.table_to_px {
        return 1.0;
    }
    let from_px = u.gaussian.table_from_px;
    if sigma_px <= from_px {
        return table_entry(0u) / from_px;
    }
    let place = (sigma_px - from_px) / (u.gaussian.table_to_px - from_px) * TABLE_STEPS;
    let index = min(u32(place), u32(TABLE_STEPS) - 1u);
    return mix(table_entry(index), table_entry(index + 1u), place - f32(index)) / sigma_px;
}

// Covariance of the filter at a place of the display: xx, xy, yy in display pixels squared, y down.
fn covariance(sigma_rad: f32, px: vec2f) -> vec3f {
    let p = plane_from_px(u.gaussian.geometry, px);
    let pitch = u.gaussian.geometry.pitch_per_distance;
    let stretch = 1.0 + dot(p, p);
    let mean_px = sigma_rad * pow(stretch, 0.75) * inverseSqrt(pitch.x * pitch.y);
    let sigma = sigma_rad * sampled_gaussian_factor(mean_px);
    let in_plane = sigma * sigma * stretch * vec3f(1.0 + p.x * p.x, -p.x * p.y, 1.0 + p.y * p.y);
    return in_plane / vec3f(pitch.x * pitch.x, pitch.x * pitch.y, pitch.y * pitch.y);
}

// Samples on either side of the middle one within the Gaussian: those whose middle lies in it, and halves.
fn taps(variance: f32) -> i32 {
    return i32(u.gaussian.truncation * sqrt(variance) + 0.5);
}

// The whole filter at once around a pixel of `picture`, which has the display's pixels and is mirrored at its edges.
fn direct_sum(picture: texture_2d<f32>, here: vec2i, c: vec3f) -> vec3f {
    let size = u.gaussian.display_size;
    let inverse = vec3f(c.z, -c.y, c.x) / (c.x * c.z - c.y * c.y);
    let reach = vec2i(taps(c.x), taps(c.z));
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var y = -reach.y; y <= reach.y; y++) {
        let row = mirrored(here.y + y, size.y);
        for (var x = -reach.x; x <= reach.x; x++) {
            let d = vec2f(f32(x), f32(y));
            let weight = exp(-0.5 * (inverse.x * d.x * d.x + 2.0 * inverse.y * d.x * d.y + inverse.z * d.y * d.y));
            sum += weight * textureLoad(picture, vec2i(mirrored(here.x + x, size.x), row), 0).rgb;
            total += weight;
        }
    }
    return sum / total;
}
