// The calibration ring: the low-passed picture laid over the full-resolution one where a ring around the gaze says so.
// `foveation/low_pass.rs` defines the mask, `low_passed.wgsl` the filter.

struct Ring {
    geometry: Geometry,
    ring_rad: f32,
    half_width_rad: f32,
    edge_rad: f32,
    reserved: f32,
}

@group(0) @binding(0) var<uniform> u: Ring;
@group(0) @binding(1) var low_passed: texture_2d<f32>;
@group(0) @binding(2) var reference: texture_2d<f32>;

@fragment
fn ring(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let e = eccentricity_rad(u.geometry, plane_from_px(u.geometry, position.xy));
    let beyond = abs(e - u.ring_rad) - u.half_width_rad;
    let t = 1.0 - clamp(beyond / u.edge_rad, 0.0, 1.0);
    let mask = t * t * (3.0 - 2.0 * t);
    if mask <= 0.0 {
        discard;
    }
    let here = vec2i(position.xy);
    let sharp = textureLoad(reference, here, 0).rgb;
    return half_colour(mix(sharp, textureLoad(low_passed, here, 0).rgb, mask));
}
