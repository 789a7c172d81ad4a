// Shared by every shader: the triangle that covers a target, and where a pixel of the display is seen from the eye.
// Spaces as in `experiments::display`: px from the top left, directions with x right, y up, z into the display.

struct Geometry {
    // Where display pixel coordinates are zero in millimetres: the display's centre.
    centre_px: vec2f,
    // Width and height of a pixel over the viewing distance.
    pitch_per_distance: vec2f,
    // Unit vector of the gaze.
    gaze: vec3f,
    reserved: f32,
}

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

// Where a pixel is on the plane one unit in front of the eye (gnomonic coordinates, x right, y up).
fn plane_from_px(g: Geometry, px: vec2f) -> vec2f {
    return vec2f(px.x - g.centre_px.x, g.centre_px.y - px.y) * g.pitch_per_distance;
}

// True angle between the gaze and a place on the plane, in radians.
fn eccentricity_rad(g: Geometry, plane: vec2f) -> f32 {
    let direction = vec3f(plane, 1.0);
    return atan2(length(cross(direction, g.gaze)), dot(direction, g.gaze));
}

// Index into 0..n of a sample of a picture that is mirrored at its edges, however far outside. In floats, because
// integer remainders are slow; exact for indices below 2^22.
fn mirrored(index: i32, n: i32) -> i32 {
    let period = 2 * n;
    let turns = i32(floor((f32(index) + 0.5) / f32(period)));
    let wrapped = index - turns * period;
    return min(wrapped, period - 1 - wrapped);
}

// A colour for a target of half floats, rounded to the nearest one (ties to even) here: drivers differ, and one that cuts
// the digits off would darken every picture a little. Values below 6.1e-5 keep what the driver does.
fn half_colour(colour: vec3f) -> vec4f {
    let bits = bitcast<vec3u>(colour);
    let odd = (bits >> vec3u(13u)) & vec3u(1u);
    return vec4f(bitcast<vec3f>((bits + 0xfffu + odd) & vec3u(0xffffe000u)), 1.0);
}
