// The last step to a display: a linear picture or a flat colour, a text screen over it, clamped and encoded as sRGB.

struct Pass {
    // Flat linear colour around and behind the picture.
    colour: vec4f,
    picture_size: vec2i,
    overlay_size: vec2i,
    target_size: vec2i,
    // Bit 0: there is a picture. 1: the overlay's colours are still sRGB.
    flags: u32,
    reserved: u32,
}

// Whether the target's own format does not encode as sRGB, so that the shader must.
override ENCODES: bool = true;

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

fn background_at(px: vec2i) -> vec3f {
    let in_picture = centred(px, u.picture_size);
    var colour = u.colour.rgb;
    if (u.flags & 1u) != 0u && inside(in_picture, u.picture_size) {
        colour = textureLoad(picture, in_picture, 0).rgb;
    }
    return clamp(colour, vec3f(0.0), vec3f(1.0));
}

fn encoded(colour: vec3f) -> vec4f {
    if ENCODES {
        return vec4f(srgb_from_linear(colour), 1.0);
    }
    return vec4f(colour, 1.0);
}

// Where there is no overlay. Apart, because software devices run every branch for every pixel.
@fragment
fn show(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return encoded(background_at(vec2i(position.xy)));
}

@fragment
fn show_overlay(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = vec2i(position.xy);
    let over = textureLoad(overlay, centred(px, u.overlay_size), 0);
    let over_linear = select(over.rgb, linear_from_srgb(over.rgb), (u.flags & 2u) != 0u);
    return encoded(mix(background_at(px), over_linear, over.a));
}
