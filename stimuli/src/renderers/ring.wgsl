// The calibration ring: a Gaussian that is round in visual angle, applied where a ring around the gaze says so.
// `foveation/low_pass.rs` defines the shape and the mask. A wide Gaussian is taken in three passes: `shrink` onto a
// coarser grid, `along_rows` in x, `ring` along a slanted column; a narrow one in `ring_direct`, in two dimensions at once.

struct Ring {
    geometry: Geometry,
    sigma_rad: f32,
    ring_rad: f32,
    half_width_rad: f32,
    edge_rad: f32,
    display_size: vec2i,
    // Samples of the grid on which the wide filter works, and display pixels between them.
    grid_size: vec2i,
    grid_step: vec2f,
    // Variance that `shrink` has already applied on each axis, display pixels squared.
    shrink_variance: vec2f,
    // Standard deviations after which the Gaussian ends.
    truncation: f32,
    // Bounds of the table of `effective_sigma_px`.
    table_from_px: f32,
    table_to_px: f32,
    reserved: f32,
    table: array<vec4f, 16>,
}

@group(0) @binding(0) var<uniform> u: Ring;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var reference: texture_2d<f32>;

const TABLE_STEPS: f32 = 63.0;

fn table_entry(index: u32) -> f32 {
    return u.table[index >> 2u][index & 3u];
}

// Factor on the standard deviation of a Gaussian that is sampled at the pixels.
fn sampled_gaussian_factor(sigma_px: f32) -> f32 {
    if sigma_px >= u.table_to_px {
        return 1.0;
    }
    if sigma_px <= u.table_from_px {
        return table_entry(0u) / u.table_from_px;
    }
    let place = (sigma_px - u.table_from_px) / (u.table_to_px - u.table_from_px) * TABLE_STEPS;
    let index = min(u32(place), u32(TABLE_STEPS) - 1u);
    return mix(table_entry(index), table_entry(index + 1u), place - f32(index)) / sigma_px;
}

// Covariance of the filter at a place of the display: xx, xy, yy in display pixels squared, y down.
fn covariance(px: vec2f) -> vec3f {
    let p = plane_from_px(u.geometry, px);
    let pitch = u.geometry.pitch_per_distance;
    let stretch = 1.0 + dot(p, p);
    let mean_px = u.sigma_rad * pow(stretch, 0.75) * inverseSqrt(pitch.x * pitch.y);
    let sigma = u.sigma_rad * sampled_gaussian_factor(mean_px);
    let in_plane = sigma * sigma * stretch * vec3f(1.0 + p.x * p.x, -p.x * p.y, 1.0 + p.y * p.y);
    return in_plane / vec3f(pitch.x * pitch.x, pitch.x * pitch.y, pitch.y * pitch.y);
}

// What `shrink` has left to do, in steps of the grid.
fn remaining_covariance(px: vec2f) -> vec3f {
    let left = covariance(px) - vec3f(u.shrink_variance.x, 0.0, u.shrink_variance.y);
    let s = u.grid_step;
    return left / vec3f(s.x * s.x, s.x * s.y, s.y * s.y);
}

fn ring_mask(px: vec2f) -> f32 {
    let e = eccentricity_rad(u.geometry, plane_from_px(u.geometry, px));
    let beyond = abs(e - u.ring_rad) - u.half_width_rad;
    let t = 1.0 - clamp(beyond / u.edge_rad, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// The source at any column of a row that lies inside.
fn source_at(x: i32, row: i32, width: i32) -> vec3f {
    return textureLoad(source, vec2i(mirrored(x, width), row), 0).rgb;
}

// The full-resolution picture on the coarser grid, low-passed far enough not to alias.
@fragment
fn shrink(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let centre = position.xy * u.grid_step - 0.5;
    let variance = max(u.shrink_variance, vec2f(1e-6));
    let reach = u.truncation * sqrt(variance);
    let first = vec2i(ceil(centre - reach));
    let last = vec2i(floor(centre + reach));
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var y = first.y; y <= last.y; y++) {
        let dy = f32(y) - centre.y;
        let row = mirrored(y, u.display_size.y);
        for (var x = first.x; x <= last.x; x++) {
            let dx = f32(x) - centre.x;
            let weight = exp(-0.5 * (dx * dx / variance.x + dy * dy / variance.y));
            sum += weight * source_at(x, row, u.display_size.x);
            total += weight;
        }
    }
    return vec4f(sum / total, 1.0);
}

// First pass: along x, with the variance that is left once the second pass has taken its slant along.
@fragment
fn along_rows(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = vec2i(position.xy);
    let c = remaining_covariance(position.xy * u.grid_step);
    let variance = c.x - c.y * c.y / c.z;
    let reach = i32(ceil(u.truncation * sqrt(variance)));
    let factor = -0.5 / variance;
    var sum = source_at(here.x, here.y, u.grid_size.x);
    var total = 1.0;
    for (var k = 1; k <= reach; k++) {
        let weight = exp(factor * f32(k * k));
        sum += weight * (source_at(here.x - k, here.y, u.grid_size.x) + source_at(here.x + k, here.y, u.grid_size.x));
        total += 2.0 * weight;
    }
    return vec4f(sum / total, 1.0);
}

// A row between its samples: cubic convolution (Keys 1981, a = −½), since a straight line would blur.
fn row_between(x: f32, row: i32) -> vec3f {
    let corner = floor(x);
    let t = x - corner;
    let i = i32(corner);
    let w0 = t * (-0.5 + t * (1.0 - 0.5 * t));
    let w1 = 1.0 + t * t * (-2.5 + 1.5 * t);
    let w2 = t * (0.5 + t * (2.0 - 1.5 * t));
    let w3 = t * t * (-0.5 + 0.5 * t);
    return w0 * source_at(i - 1, row, u.grid_size.x) + w1 * source_at(i, row, u.grid_size.x)
        + w2 * source_at(i + 1, row, u.grid_size.x) + w3 * source_at(i + 2, row, u.grid_size.x);
}

// Second pass: along the slanted column, and into the reference by the mask.
@fragment
fn ring(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let mask = ring_mask(position.xy);
    if mask <= 0.0 {
        discard;
    }
    let c = remaining_covariance(position.xy);
    let slant = c.y / c.z;
    let centre = position.xy / u.grid_step - 0.5;
    let reach = u.truncation * sqrt(c.z);
    let factor = -0.5 / c.z;
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var y = i32(ceil(centre.y - reach)); y <= i32(floor(centre.y + reach)); y++) {
        let dy = f32(y) - centre.y;
        let weight = exp(factor * dy * dy);
        sum += weight * row_between(centre.x + slant * dy, mirrored(y, u.grid_size.y));
        total += weight;
    }
    let sharp = textureLoad(reference, vec2i(position.xy), 0).rgb;
    return half_colour(mix(sharp, sum / total, mask));
}

// The whole filter at once, from the full-resolution picture.
@fragment
fn ring_direct(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let mask = ring_mask(position.xy);
    if mask <= 0.0 {
        discard;
    }
    let here = vec2i(position.xy);
    let c = covariance(position.xy);
    let inverse = vec3f(c.z, -c.y, c.x) / (c.x * c.z - c.y * c.y);
    let reach = vec2i(ceil(u.truncation * sqrt(vec2f(c.x, c.z))));
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var y = -reach.y; y <= reach.y; y++) {
        let row = mirrored(here.y + y, u.display_size.y);
        for (var x = -reach.x; x <= reach.x; x++) {
            let d = vec2f(f32(x), f32(y));
            let weight = exp(-0.5 * (inverse.x * d.x * d.x + 2.0 * inverse.y * d.x * d.y + inverse.z * d.y * d.y));
            sum += weight * source_at(here.x + x, row, u.display_size.x);
            total += weight;
        }
    }
    let sharp = source_at(here.x, here.y, u.display_size.x);
    return half_colour(mix(sharp, sum / total, mask));
}
