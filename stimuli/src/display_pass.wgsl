// The last step to a display: a linear picture or a flat colour, a text screen over it, clamped and encoded as sRGB.

struct Pass {
    // Flat linear colour around and behind the picture.
    colour: vec4f,
    picture_size: vec2i,
    overlay_size: vec2i,
    target_size: vec2i,
    // Bit 0: there is a picture. 1: there is an overlay. 2: the overlay's colours are still sRGB. 3: encode as sRGB.
    flags: u32,
    reserved: u32,
}

@group(0) @binding(0) var<uniform> u: Pass;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var overlay: texture_2d<f32>;

fn linear_from_srgb(c: vec3f) -> vec3f {
    let high = pow((c + 0.055) / 1.055, vec3f(2.4));
    return select(high, c / 12.92, c <= vec3f(0.04045));
}

fn srgb_from_linear(c: vec3f) -> vec3f {
    let high = 1.055 * pow(max(c, vec3f(1e-8)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, c * 12.92, c <= vec3f(0.0031308));
}

// Where a target pixel falls in something of `size` pixels that stands in the target's middle, unscaled.
fn centred(px: vec2i, size: vec2i) -> vec2i {
    return px - ((u.target_size - size) >> vec2u(1u));
}

fn inside(px: vec2i, size: vec2i) -> bool {
    return all(px >= vec2i(0)) && all(px < size);
}

@fragment
fn show(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = vec2i(position.xy);
    var colour = u.colour.rgb;
    let in_picture = centred(px, u.picture_size);
    if (u.flags & 1u) != 0u && inside(in_picture, u.picture_size) {
        colour = textureLoad(picture, in_picture, 0).rgb;
    }
    colour = clamp(colour, vec3f(0.0), vec3f(1.0));
    let in_overlay = centred(px, u.overlay_size);
    if (u.flags & 2u) != 0u && inside(in_overlay, u.overlay_size) {
        let over = textureLoad(overlay, in_overlay, 0);
        let over_linear = select(over.rgb, linear_from_srgb(over.rgb), (u.flags & 4u) != 0u);
        colour = mix(colour, over_linear, over.a);
    }
    return vec4f(select(colour, srgb_from_linear(colour), (u.flags & 8u) != 0u), 1.0);
}
