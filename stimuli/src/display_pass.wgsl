// The last step to a display: a linear picture or a flat colour, a text screen over it, clamped and encoded as sRGB.

struct Pass {
    // Flat linear colour around and behind the picture.
    colour: vec4f,
    picture_size: vec2i,
    overlay_size: vec2i,
    target_size: vec2i,
    // Bit 0: there is a picture. 1: the overlay's colours are still sRGB.
    flags: u32,
    disc_count: u32,
    discs: array<Disc, 16>,
}

struct Disc {
    // Centre in target pixels, radius, nothing.
    place: vec4f,
    // Linear.
    colour: vec4f,
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

// Towards the light of the discs, from above on the left: x right, y up, z out of the display.
const LIGHT: vec3f = vec3f(-0.4, 0.6, 0.6928203);
// Halfway between the light and an observer straight in front.
const HALFWAY: vec3f = vec3f(-0.2173900, 0.3260850, 0.9200055);
// Share of the colour that shows where no light falls.
const SHADE: f32 = 0.3;
const HIGHLIGHT: f32 = 0.4;

// A disc shaded as a ball: Lambert's law and a white highlight (Blinn 1977), linear light.
fn ball(colour: vec3f, from_centre: vec2f) -> vec3f {
    let across = vec2f(from_centre.x, -from_centre.y) * min(1.0, inverseSqrt(max(dot(from_centre, from_centre), 1e-12)));
    let normal = vec3f(across, sqrt(max(1.0 - dot(across, across), 0.0)));
    let lit = SHADE + (1.0 - SHADE) * max(dot(normal, LIGHT), 0.0);
    let highlight = HIGHLIGHT * pow(max(dot(normal, HALFWAY), 0.0), 48.0);
    return clamp(mix(colour * lit, vec3f(1.0), highlight), vec3f(0.0), vec3f(1.0));
}

// The background with the discs over it, the later ones on top. Their edges are one pixel soft.
fn with_discs(px: vec2i) -> vec3f {
    var colour = background_at(px);
    for (var i = 0u; i < u.disc_count; i++) {
        let disc = u.discs[i];
        let from_centre = vec2f(px) + 0.5 - disc.place.xy;
        let coverage = clamp(disc.place.z - length(from_centre) + 0.5, 0.0, 1.0);
        colour = mix(colour, ball(disc.colour.rgb, from_centre / disc.place.z), coverage);
    }
    return colour;
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
fn show_discs(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return encoded(with_discs(vec2i(position.xy)));
}

@fragment
fn show_overlay_on_discs(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = vec2i(position.xy);
    let over = textureLoad(overlay, centred(px, u.overlay_size), 0);
    let over_linear = select(over.rgb, linear_from_srgb(over.rgb), (u.flags & 2u) != 0u);
    return encoded(mix(with_discs(px), over_linear, over.a));
}

@fragment
fn show_overlay(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = vec2i(position.xy);
    let over = textureLoad(overlay, centred(px, u.overlay_size), 0);
    let over_linear = select(over.rgb, linear_from_srgb(over.rgb), (u.flags & 2u) != 0u);
    return encoded(mix(background_at(px), over_linear, over.a));
}
