// What stands around a renderer that is written in WGSL alone: the picture, the place, and what one may ask of them. It
// follows the user's text, so that lines and columns are the user's own. `Parameters` is made from the file's head.

// A pixel of the display.
struct Place {
    // Its middle: display pixels from the top left corner, and the same as shares of the display, 0 to 1.
    px: vec2f,
    uv: vec2f,
    // Its true angle from the gaze in degrees.
    eccentricity_deg: f32,
    // Where the eye looks: degrees from the display's centre (x right, y up), and in pixels. May lie off the display.
    gaze_deg: vec2f,
    gaze_px: vec2f,
}

struct ParafoveaFrame {
    geometry: Geometry,
    gaze_deg: vec2f,
    size: vec2f,
}

@group(0) @binding(0) var<uniform> parafovea_frame: ParafoveaFrame;
@group(0) @binding(1) var<uniform> parafovea_parameters: Parameters;
// The scene at the display's full resolution, linear light, with its mip chain.
@group(0) @binding(2) var picture: texture_2d<f32>;
@group(0) @binding(3) var picture_sampler: sampler;

fn uv_from_px(px: vec2f) -> vec2f {
    return px / parafovea_frame.size;
}

fn px_from_uv(uv: vec2f) -> vec2f {
    return uv * parafovea_frame.size;
}

// Degrees from the display's centre, x right, y up.
fn deg_from_px(px: vec2f) -> vec2f {
    return degrees(atan(plane_from_px(parafovea_frame.geometry, px)));
}

fn px_from_deg(deg: vec2f) -> vec2f {
    let plane = tan(radians(clamp(deg, vec2f(-89.0), vec2f(89.0))));
    let px = plane / parafovea_frame.geometry.pitch_per_distance;
    return vec2f(parafovea_frame.geometry.centre_px.x + px.x, parafovea_frame.geometry.centre_px.y - px.y);
}

// True angle from the gaze to a place, degrees.
fn eccentricity_deg_at(px: vec2f) -> f32 {
    return degrees(eccentricity_rad(parafovea_frame.geometry, plane_from_px(parafovea_frame.geometry, px)));
}

// The largest angle that a pixel covers at a place, degrees.
fn pixel_deg_at(px: vec2f) -> f32 {
    let pitch = parafovea_frame.geometry.pitch_per_distance;
    let slant = length(vec3f(plane_from_px(parafovea_frame.geometry, px), 1.0));
    return degrees(atan(max(pitch.x, pitch.y) / slant));
}

// The picture's own pixel at a place, exactly; mirrored beyond the edges.
fn picture_at(px: vec2f) -> vec3f {
    let size = vec2i(parafovea_frame.size);
    let texel = vec2i(floor(px));
    return textureLoad(picture, vec2i(mirrored(texel.x, size.x), mirrored(texel.y, size.y)), 0).rgb;
}

// The picture at a level of its mip chain: 0 is full resolution, 1 has half the pixels across, and so on; in between the
// two levels are mixed. Bilinear, mirrored beyond the edges.
fn sample_level(px: vec2f, level: f32) -> vec3f {
    return textureSampleLevel(picture, picture_sampler, uv_from_px(px), level).rgb;
}

// A cubic B-spline through one level, from four bilinear samples.
fn parafovea_spline(px: vec2f, level: i32) -> vec3f {
    let size = vec2f(textureDimensions(picture, level));
    let place = uv_from_px(px) * size - 0.5;
    let corner = floor(place);
    let f = place - corner;
    let g = 1.0 - f;
    let w0 = g * g * g / 6.0;
    let w1 = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0;
    let w3 = f * f * f / 6.0;
    let low = w0 + w1;
    let high = 1.0 - low;
    let at_low = (corner + w1 / low - 0.5) / size;
    let at_high = (corner + w3 / high + 1.5) / size;
    let l = f32(level);
    let top = mix(
        textureSampleLevel(picture, picture_sampler, vec2f(at_high.x, at_low.y), l).rgb,
        textureSampleLevel(picture, picture_sampler, at_low, l).rgb,
        low.x,
    );
    let bottom = mix(
        textureSampleLevel(picture, picture_sampler, at_high, l).rgb,
        textureSampleLevel(picture, picture_sampler, vec2f(at_low.x, at_high.y), l).rgb,
        low.x,
    );
    return mix(bottom, top, low.y);
}

// Variance of the spline through a level together with the level's own averaging, pixels squared.
fn parafovea_variance(level: i32) -> f32 {
    let step2 = exp2(2.0 * f32(level));
    return step2 / 3.0 + (step2 - 1.0) / 12.0;
}

// The picture without fine detail: nearly a Gaussian of standard deviation `sigma_px` pixels, of exactly that variance
// where the display's sides are even at the levels that are read. 0 is the picture itself.
fn sample_sigma(px: vec2f, sigma_px: f32) -> vec3f {
    let wanted = sigma_px * sigma_px;
    let narrowest = parafovea_variance(0);
    if !(wanted > 0.0) {
        return picture_at(px);
    }
    if wanted <= narrowest {
        return mix(picture_at(px), parafovea_spline(px, 0), wanted / narrowest);
    }
    // The variance at level l is (5 · 4^l − 1) / 12.
    let last = i32(textureNumLevels(picture)) - 1;
    let level = clamp(i32(floor(0.5 * log2((12.0 * wanted + 1.0) / 5.0) + 1e-5)), 0, max(last - 1, 0));
    let next = min(level + 1, last);
    let below = parafovea_variance(level);
    let above = parafovea_variance(next);
    let share = select(0.0, clamp((wanted - below) / max(above - below, 1e-9), 0.0, 1.0), next > level);
    return mix(parafovea_spline(px, level), parafovea_spline(px, next), share);
}

// The picture at a place without detail finer than `mar_deg` degrees per cycle: gratings of that period keep half their
// amplitude, as in the renderer "ring".
fn sample_mar(px: vec2f, mar_deg: f32) -> vec3f {
    return sample_sigma(px, 0.18739063 * mar_deg / pixel_deg_at(px));
}

@fragment
fn parafovea_pixel(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = Place(
        position.xy,
        uv_from_px(position.xy),
        eccentricity_deg_at(position.xy),
        parafovea_frame.gaze_deg,
        px_from_deg(parafovea_frame.gaze_deg),
    );
    // What is no number becomes black; light beyond the largest half float becomes that.
    let found: vec3f = colour(place, parafovea_parameters);
    return half_colour(select(vec3f(0.0), min(found, vec3f(65504.0)), found > vec3f(0.0)));
}
