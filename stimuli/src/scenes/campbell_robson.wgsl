// The contrast sensitivity chart: a grating whose contrast each row states and whose wave each column states.

struct Chart {
    // The light around which the grating swings.
    mean: vec4f,
}

@group(0) @binding(0) var<uniform> u: Chart;
// One texel for each column of the target: the wave there, −1 to 1.
@group(0) @binding(1) var wave: texture_2d<f32>;
// One texel for each row of the target: the contrast there, 0–1.
@group(0) @binding(2) var contrast: texture_2d<f32>;

@fragment
fn campbell_robson(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = vec2i(position.xy);
    let modulation = textureLoad(contrast, vec2i(px.y, 0), 0).r * textureLoad(wave, vec2i(px.x, 0), 0).r;
    return half_colour(u.mean.rgb * (1.0 + modulation));
}
