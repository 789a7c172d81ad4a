// Three eccentricity layers become one picture: each is magnified bilinearly onto the display's pixels and blended into
// the next coarser one between 0.6 of its radius and its radius (Guenter et al. 2012, §4.2).

struct Layers {
    geometry: Geometry,
    inner_rad: f32,
    middle_rad: f32,
    // Share of a layer's radius at which its blend begins.
    blend_from: f32,
    reserved: f32,
    // Display pixel of each layer's corner, in zw the display pixels per layer pixel.
    inner: vec4f,
    middle: vec4f,
    outer: vec4f,
    // Layer pixels in use.
    inner_size: vec2i,
    middle_size: vec2i,
    outer_size: vec2i,
    reserved2: vec2i,
}

@group(0) @binding(0) var<uniform> u: Layers;
@group(0) @binding(1) var inner: texture_2d<f32>;
@group(0) @binding(2) var middle: texture_2d<f32>;
@group(0) @binding(3) var outer: texture_2d<f32>;

fn magnified(layer: texture_2d<f32>, place: vec4f, size: vec2i, px: vec2f) -> vec3f {
    let at = (px - place.xy) / place.zw - 0.5;
    let corner = floor(at);
    let share = at - corner;
    let low = clamp(vec2i(corner), vec2i(0), size - 1);
    let high = clamp(vec2i(corner) + 1, vec2i(0), size - 1);
    let top = mix(textureLoad(layer, low, 0).rgb, textureLoad(layer, vec2i(high.x, low.y), 0).rgb, share.x);
    let bottom = mix(textureLoad(layer, vec2i(low.x, high.y), 0).rgb, textureLoad(layer, high, 0).rgb, share.x);
    return mix(top, bottom, share.y);
}

@fragment
fn blend(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let e = eccentricity_rad(u.geometry, plane_from_px(u.geometry, position.xy));
    let to_middle = smoothstep(u.blend_from * u.inner_rad, u.inner_rad, e);
    let to_outer = smoothstep(u.blend_from * u.middle_rad, u.middle_rad, e);
    var colour = vec3f(0.0);
    // Outside in, and only what shows.
    if to_outer > 0.0 {
        colour = magnified(outer, u.outer, u.outer_size, position.xy);
    }
    if to_outer < 1.0 && to_middle > 0.0 {
        colour = mix(magnified(middle, u.middle, u.middle_size, position.xy), colour, to_outer);
    }
    if to_middle < 1.0 {
        // The innermost layer is on the display's own grid.
        let own = textureLoad(inner, vec2i(position.xy - u.inner.xy), 0).rgb;
        colour = mix(own, colour, to_middle);
    }
    return half_colour(colour);
}
