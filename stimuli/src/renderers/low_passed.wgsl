// The picture without detail finer than omega: a Gaussian that is round in visual angle, an ellipse on the display.
// `gaussian.wgsl` holds its shape; `low_passed.rs` says which stages follow one another.

struct LowPass {
    gaussian: Gaussian,
    sigma_rad: f32,
    // Samples by which the output of `along_columns` reaches past the grid on every side.
    margin: f32,
    // Samples of the grid on which the wide filter works, and display pixels between them.
    grid_size: vec2i,
    grid_step: vec2f,
    // Variance of the low-pass before the grid, display pixels squared.
    shrink_variance: vec2f,
    // Variance of the low-pass before the grid and of the enlargement after it, display pixels squared.
    spent_variance: vec2f,
    reserved: vec2f,
}

// Whether the result goes into half floats.
override ROUNDS: bool = false;

@group(0) @binding(0) var<uniform> u: LowPass;
@group(0) @binding(1) var source: texture_2d<f32>;

// What the other stages leave to do at a place, in steps of the grid.
fn remaining_covariance(px: vec2f) -> vec3f {
    let left = covariance(u.sigma_rad, px) - vec3f(u.spent_variance.x, 0.0, u.spent_variance.y);
    let s = u.grid_step;
    return left / vec3f(s.x * s.x, s.x * s.y, s.y * s.y);
}

// The source at any column of a row that lies inside.
fn source_at(x: i32, row: i32, width: i32) -> vec3f {
    return textureLoad(source, vec2i(mirrored(x, width), row), 0).rgb;
}

fn result(colour: vec3f) -> vec4f {
    if ROUNDS {
        return half_colour(colour);
    }
    return vec4f(colour, 1.0);
}

// Onto the grid's columns, low-passed along x far enough not to alias.
@fragment
fn shrink_columns(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let row = i32(position.y);
    let centre = position.x * u.grid_step.x - 0.5;
    let variance = max(u.shrink_variance.x, 1e-6);
    let reach = u.gaussian.truncation * sqrt(variance);
    let factor = -0.5 / variance;
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var x = i32(ceil(centre - reach)); x <= i32(floor(centre + reach)); x++) {
        let dx = f32(x) - centre;
        let weight = exp(factor * dx * dx);
        sum += weight * source_at(x, row, u.gaussian.display_size.x);
        total += weight;
    }
    return vec4f(sum / total, 1.0);
}

// Onto the grid's rows, from a picture that has the grid's columns.
@fragment
fn shrink_rows(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let column = i32(position.x);
    let centre = position.y * u.grid_step.y - 0.5;
    let variance = max(u.shrink_variance.y, 1e-6);
    let reach = u.gaussian.truncation * sqrt(variance);
    let factor = -0.5 / variance;
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var y = i32(ceil(centre - reach)); y <= i32(floor(centre + reach)); y++) {
        let dy = f32(y) - centre;
        let weight = exp(factor * dy * dy);
        sum += weight * textureLoad(source, vec2i(column, mirrored(y, u.gaussian.display_size.y)), 0).rgb;
        total += weight;
    }
    return vec4f(sum / total, 1.0);
}

// Along x, with the variance that is left once `along_columns` has taken its slant along.
@fragment
fn along_rows(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = vec2i(position.xy);
    let c = remaining_covariance(position.xy * u.grid_step);
    let variance = c.x - c.y * c.y / c.z;
    let reach = taps(variance);
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

// Along the slanted column.
@fragment
fn along_columns(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = position.xy - u.margin;
    let c = remaining_covariance(place * u.grid_step);
    let slant = c.y / c.z;
    let column = floor(place.x);
    let row = i32(floor(place.y));
    let reach = taps(c.z);
    let factor = -0.5 / c.z;
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var k = -reach; k <= reach; k++) {
        let dy = f32(k);
        let weight = exp(factor * dy * dy);
        sum += weight * row_between(column + slant * dy, mirrored(row + k, u.grid_size.y));
        total += weight;
    }
    return result(sum / total);
}

// Weights of the uniform cubic B-spline, whose variance is 1/3 of a step squared.
fn spline_weights(t: f32) -> vec4f {
    let s = 1.0 - t;
    return vec4f(s * s * s, 4.0 + t * t * (3.0 * t - 6.0), 4.0 + s * s * (3.0 * s - 6.0), t * t * t) / 6.0;
}

// From the grid, with its margin, back to the display's pixels.
@fragment
fn enlarge(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = position.xy / u.grid_step - 0.5 + u.margin;
    let corner = floor(place);
    let across = spline_weights(place.x - corner.x);
    let down = spline_weights(place.y - corner.y);
    let first = vec2i(corner) - 1;
    var sum = vec3f(0.0);
    for (var j = 0; j < 4; j++) {
        var row = vec3f(0.0);
        for (var i = 0; i < 4; i++) {
            row += across[i] * textureLoad(source, first + vec2i(i, j), 0).rgb;
        }
        sum += down[j] * row;
    }
    return result(sum);
}

// The whole filter at once, from the full-resolution picture.
@fragment
fn direct(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return result(direct_sum(source, vec2i(position.xy), covariance(u.sigma_rad, position.xy)));
}
