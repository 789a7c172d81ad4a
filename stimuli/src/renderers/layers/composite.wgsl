// Eccentricity layers become one picture: each is magnified onto the display's pixels and blended into the next coarser one
// between 0.6 of its radius and its radius (Guenter et al. 2012, §4, Fig. 3).

struct Layers {
    geometry: Geometry,
    // Of the layers from the inside out; the outermost's is larger than any angle, and that of a layer which is out of view 0.
    radii_rad: vec4f,
    // Each layer's corner, in its own pixels from the display's, and in zw the display pixels per layer pixel.
    places: array<vec4f, 4>,
    // Layer pixels in use, in xy.
    sizes: array<vec4i, 4>,
    // Share of a layer's radius at which its blend begins.
    blend_from: f32,
    // Whether the nearest layer pixel is shown instead of a bilinear mixture.
    nearest: u32,
    reserved: vec2u,
}

@group(0) @binding(0) var<uniform> u: Layers;
@group(0) @binding(1) var inner: texture_2d<f32>;
@group(0) @binding(2) var second: texture_2d<f32>;
@group(0) @binding(3) var third: texture_2d<f32>;
@group(0) @binding(4) var fourth: texture_2d<f32>;

fn magnified(layer: texture_2d<f32>, place: vec4f, size: vec2i, px: vec2f) -> vec3f {
    // In this order a place is rounded the same wherever the layer's corner lies.
    let at = px / place.zw - place.xy;
    // The nearest layer pixel is a mixture in which it has all the share.
    let cell = select(at - 0.5, floor(at), u.nearest != 0u);
    let corner = floor(cell);
    let share = cell - corner;
    let low = clamp(vec2i(corner), vec2i(0), size - 1);
    let high = clamp(vec2i(corner) + 1, vec2i(0), size - 1);
    let top = mix(textureLoad(layer, low, 0).rgb, textureLoad(layer, vec2i(high.x, low.y), 0).rgb, share.x);
    let bottom = mix(textureLoad(layer, vec2i(low.x, high.y), 0).rgb, textureLoad(layer, high, 0).rgb, share.x);
    return mix(top, bottom, share.y);
}

// Share of what lies outside a layer at `e`: 0 inside its blend, 1 beyond its radius.
fn outside(radius_rad: f32, e: f32) -> f32 {
    let begin = u.blend_from * radius_rad;
    if e >= radius_rad {
        return 1.0;
    }
    if e <= begin {
        return 0.0;
    }
    return smoothstep(begin, radius_rad, e);
}

// Beyond the radius of every other layer: half the work of `blend`, or less, since software devices run every branch.
@fragment
fn outermost(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return half_colour(magnified(inner, u.places[0], u.sizes[0].xy, position.xy));
}

@fragment
fn blend(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = position.xy;
    let e = eccentricity_rad(u.geometry, plane_from_px(u.geometry, px));
    let beyond = vec3f(outside(u.radii_rad.x, e), outside(u.radii_rad.y, e), outside(u.radii_rad.z, e));
    var colour = vec3f(0.0);
    // Outside in, and only what shows.
    if beyond.z > 0.0 {
        colour = magnified(fourth, u.places[3], u.sizes[3].xy, px);
    }
    if beyond.y > 0.0 && beyond.z < 1.0 {
        colour = mix(magnified(third, u.places[2], u.sizes[2].xy, px), colour, beyond.z);
    }
    if beyond.x > 0.0 && beyond.y < 1.0 {
        colour = mix(magnified(second, u.places[1], u.sizes[1].xy, px), colour, beyond.y);
    }
    if beyond.x < 1.0 {
        // The innermost layer is on the display's own grid.
        let own = textureLoad(inner, vec2i(px - u.places[0].xy), 0).rgb;
        colour = mix(own, colour, beyond.x);
    }
    return half_colour(colour);
}
