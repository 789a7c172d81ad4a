// Quality levels blended around the gaze: the reference in the middle, coarser ones outside, each laid over the last with a
// smooth edge. A level that begins below 0 covers everything.

struct Frames {
    geometry: Geometry,
    // Display pixel of the frames' top left corner, and their size.
    corner: vec2i,
    size: vec2i,
    // Levels beside the reference, and the width of the edges in radians.
    count: i32,
    edge_rad: f32,
    reserved: vec2f,
    // Where the edge of each level begins, four to a row.
    radii_rad: array<vec4f, 4>,
}

@group(0) @binding(0) var<uniform> u: Frames;
// The reference at the display's pixels, and the levels at their own.
@group(0) @binding(1) var reference: texture_2d<f32>;
@group(0) @binding(2) var levels: texture_2d_array<f32>;

fn level_at(px: vec2i, level: i32) -> vec3f {
    let at = px - u.corner;
    if any(at < vec2i(0)) || any(at >= u.size) {
        return vec3f(0.0);
    }
    return textureLoad(levels, at, level, 0).rgb;
}

@fragment
fn foveated(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = vec2i(floor(position.xy));
    let eccentricity = eccentricity_rad(u.geometry, plane_from_px(u.geometry, position.xy));
    var colour = textureLoad(reference, px, 0).rgb;
    for (var level = 0; level < u.count; level++) {
        let beyond = eccentricity - u.radii_rad[level / 4][level % 4];
        if beyond >= 0.0 {
            let share = select(1.0, smoothstep(0.0, u.edge_rad, beyond), u.edge_rad > 0.0);
            colour = mix(colour, level_at(px, level), share);
        }
    }
    return half_colour(colour);
}
