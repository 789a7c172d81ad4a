// A zone plate: rings whose spatial frequency grows with the angle from the display's centre.

struct ZonePlate {
    geometry: Geometry,
    origin_px: vec2f,
    step_px: vec2f,
    // Cycles per radian at and beyond the radius, and the radius, radians.
    highest: f32,
    radius: f32,
    contrast: f32,
    // Cycles by which the rings have moved outward, 0–1.
    moved: f32,
}

@group(0) @binding(0) var<uniform> u: ZonePlate;

const TAU: f32 = 6.2831853;

// The angle whose tangent is q. One step of Newton's after the built-in function, which on some devices is good to five
// digits only: a phase of hundreds of cycles needs more.
fn angle(q: f32) -> f32 {
    let first = atan(q);
    let s = sin(first);
    let c = cos(first);
    return first + (q * c - s) / (c + q * s);
}

// What is left of a wave of `cycles` for each display pixel when the display pixels under a target pixel are averaged.
fn averaged(cycles: f32, step: f32) -> f32 {
    let samples = max(ceil(step - 1e-3), 1.0);
    let below = samples * sin(0.5 * TAU * cycles * step / samples);
    return select(sin(0.5 * TAU * cycles * step) / below, 1.0, abs(below) < 1e-4);
}

@fragment
fn zone_plate(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let plane = plane_from_px(u.geometry, u.origin_px + position.xy * u.step_px);
    let q = length(plane);
    let r = angle(q);
    let inside = min(r, u.radius);
    let cycles = u.highest * (0.5 * inside * inside / u.radius + (r - inside));
    // Cycles for each display pixel along both axes.
    let across = u.highest * inside / u.radius * plane / max(q, 1e-9) / (1.0 + q * q) * u.geometry.pitch_per_distance;
    var contrast = u.contrast * averaged(across.x, u.step_px.x) * averaged(across.y, u.step_px.y);
    if any(abs(across) >= vec2f(0.5)) {
        contrast = 0.0;
    }
    return half_colour(vec3f(0.5 + 0.5 * contrast * cos(TAU * (fract(cycles) - u.moved))));
}
