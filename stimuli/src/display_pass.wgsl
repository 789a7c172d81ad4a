// The display transform: a linear picture is exposed and tone mapped, or a flat colour clamped; discs and a text screen
// are laid over it in linear light; and all of it is encoded with the display's own transfer.

struct Pass {
    // Flat linear colour around and behind the picture.
    colour: vec4f,
    picture_size: vec2i,
    overlay_size: vec2i,
    target_size: vec2i,
    // Bit 0: there is a picture. 1: the overlay's colours are still sRGB.
    flags: u32,
    disc_count: u32,
    // What the picture's light is multiplied with.
    exposure: f32,
    // Where the filmic curve bends, what light it shows as 1, and that on the shoulder's own scale.
    knee: f32,
    white: f32,
    shoulder_end: f32,
    // Light of each channel at signal 0, where the table begins.
    black: vec4f,
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
// Constants, because software devices run every branch for every pixel.
override FILMIC: bool = false;
// Whether the display's transfer is a table instead of sRGB.
override TABLE: bool = false;

@group(0) @binding(0) var<uniform> u: Pass;
@group(0) @binding(1) var picture: texture_2d<f32>;
// The signal of each channel from its black to its peak, at even steps of the fourth root of the light above black.
@group(0) @binding(2) var signals: texture_2d<f32>;
@group(0) @binding(3) var overlay: texture_2d<f32>;

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

// As `ToneMap::shown` in `tone.rs`.
fn filmic(light: vec3f) -> vec3f {
    let t = max(clamp(light, vec3f(0.0), vec3f(u.white)) - u.knee, vec3f(0.0)) / (1.0 - u.knee);
    let shoulder = t * (1.0 + t / (u.shoulder_end * u.shoulder_end)) / (1.0 + t);
    return clamp(light, vec3f(0.0), vec3f(u.knee)) + (1.0 - u.knee) * shoulder;
}

// What to send to a display with a table: linear between its entries.
fn signal_from_light(light: vec3f) -> vec3f {
    let last = i32(textureDimensions(signals).x) - 1;
    let above_black = clamp((light - u.black.rgb) / (1.0 - u.black.rgb), vec3f(0.0), vec3f(1.0));
    let place = sqrt(sqrt(above_black)) * f32(last);
    let below = min(vec3i(place), vec3i(last - 1));
    let share = place - vec3f(below);
    let low = vec3f(entry(below.x).r, entry(below.y).g, entry(below.z).b);
    let high = vec3f(entry(below.x + 1).r, entry(below.y + 1).g, entry(below.z + 1).b);
    return mix(low, high, share);
}

fn entry(index: i32) -> vec3f {
    return textureLoad(signals, vec2i(index, 0), 0).rgb;
}

fn background_at(px: vec2i) -> vec3f {
    let in_picture = centred(px, u.picture_size);
    var colour = u.colour.rgb;
    if (u.flags & 1u) != 0u && inside(in_picture, u.picture_size) {
        colour = textureLoad(picture, in_picture, 0).rgb * u.exposure;
        if FILMIC {
            colour = filmic(colour);
        }
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
    if TABLE {
        let signal = signal_from_light(colour);
        // A target that encodes as sRGB by itself is given what it encodes into the signal.
        return vec4f(select(linear_from_srgb(signal), signal, ENCODES), 1.0);
    }
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
