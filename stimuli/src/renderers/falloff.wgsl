// A Gaussian blur that grows with eccentricity: sigma = rate (e - radius) beyond the radius (Tursun et al. 2019, Eq. 14).
// `falloff.rs` says where it is summed and where it is interpolated between low-passed pictures.

struct Falloff {
    gaussian: Gaussian,
    radius_rad: f32,
    // Radians per radian.
    rate: f32,
    // Standard deviations between which this draw paints.
    from_rad: f32,
    to_rad: f32,
    // ln of the ratio of neighbouring low-passed pictures' standard deviations.
    ln_step: f32,
    reserved: f32,
    reserved2: vec2f,
}

@group(0) @binding(0) var<uniform> u: Falloff;
@group(0) @binding(1) var narrow: texture_2d<f32>;
@group(0) @binding(2) var middle: texture_2d<f32>;
@group(0) @binding(3) var wide: texture_2d<f32>;

const FARTHEST_RAD: f32 = 1.5707963;

fn sigma_rad(px: vec2f) -> f32 {
    let e = eccentricity_rad(u.gaussian.geometry, plane_from_px(u.gaussian.geometry, px));
    return max(u.rate * (min(e, FARTHEST_RAD) - u.radius_rad), 0.0);
}

// Summed over the reference, which is `narrow`.
@fragment
fn summed(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let sigma = sigma_rad(position.xy);
    // A little further than where interpolation takes over, so that no rounding leaves a pixel out.
    if sigma > u.to_rad * 1.0001 {
        discard;
    }
    let here = vec2i(position.xy);
    let c = covariance(sigma, position.xy);
    if taps(max(c.x, c.z)) == 0 {
        return textureLoad(narrow, here, 0);
    }
    return half_colour(direct_sum(narrow, here, c));
}

// Between three low-passed pictures: a parabola in ln sigma.
@fragment
fn interpolated(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let sigma = sigma_rad(position.xy);
    if sigma < u.from_rad || sigma >= u.to_rad {
        discard;
    }
    let t = log(sigma / u.from_rad) / u.ln_step;
    let here = vec2i(position.xy);
    let a = textureLoad(narrow, here, 0).rgb;
    let b = textureLoad(middle, here, 0).rgb;
    let c = textureLoad(wide, here, 0).rgb;
    let between = 0.5 * (t - 1.0) * (t - 2.0) * a - t * (t - 2.0) * b + 0.5 * t * (t - 1.0) * c;
    // A weighted mean of the picture leaves its range no more than the three do.
    return half_colour(clamp(between, vec3f(0.0), max(max(a, b), c)));
}
