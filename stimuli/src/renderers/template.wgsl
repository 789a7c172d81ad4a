// Full resolution within a radius of the gaze, every second pixel beyond.

struct Template {
    geometry: Geometry,
    radius_rad: f32,
    reserved: f32,
    reserved2: vec2f,
}

@group(0) @binding(0) var<uniform> u: Template;
@group(0) @binding(1) var fine: texture_2d<f32>;
@group(0) @binding(2) var coarse: texture_2d<f32>;

@fragment
fn fine_or_coarse(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = vec2i(floor(position.xy));
    let eccentricity = eccentricity_rad(u.geometry, plane_from_px(u.geometry, position.xy));
    let sharp = textureLoad(fine, px, 0).rgb;
    let blunt = textureLoad(coarse, px / 2, 0).rgb;
    return half_colour(select(blunt, sharp, eccentricity <= u.radius_rad));
}
