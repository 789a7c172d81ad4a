// What every shader of a mesh scene shares: the frame, objects, materials, lights, sky and shadow (group 0).

struct Frame {
    geometry: Geometry,
    // From the world to the clip space of the view.
    clip: mat4x4f,
    eye: vec4f,
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // The camera of the earlier picture, for motion.
    then_eye: vec4f,
    then_right: vec4f,
    then_up: vec4f,
    then_forward: vec4f,
    // Towards the light that casts shadows, and what a white matt surface that faces it sends out.
    sun: vec4f,
    sun_colour: vec4f,
    // Irradiance of the sky over pi: second-order spherical harmonics.
    ambient: array<vec4f, 9>,
    // From the world to places and depths on the shadow map, 0..1.
    shadow: mat4x4f,
    origin_px: vec2f,
    step_px: vec2f,
    // Lights from far, points, rectangles.
    light_counts: vec4u,
    // Width of a texel of the shadow map, metres.
    shadow_texel_m: f32,
    // Points of a procedural pattern that are averaged in each pixel.
    pattern_samples: u32,
    // Levels of the sky's pyramid.
    sky_levels: u32,
    // 4, where a compiler must not know it: it would write loops out, and then take seconds for each material.
    four: u32,
    // The least light that a display shows as white.
    white: f32,
    reserved0: f32,
    reserved1: f32,
    reserved2: f32,
}

struct Object {
    // Rows of the matrices from the mesh to the world, now and at the earlier picture.
    now: array<vec4f, 3>,
    then: array<vec4f, 3>,
    // Rows of the matrix of normals.
    normal: array<vec4f, 3>,
    material: u32,
    // Three single words: a vector of three would begin at the next sixteen bytes.
    reserved0: u32,
    reserved1: u32,
    reserved2: u32,
}

struct Material {
    albedo: vec3f,
    roughness: f32,
    emission: vec3f,
    metalness: f32,
    pattern_colour: vec3f,
    pattern_scale: f32,
    pattern: u32,
    pattern_strength: f32,
    pattern_roughness: f32,
    pattern_relief: f32,
    // -1 where there is none.
    albedo_map: i32,
    emission_map: i32,
    normal_map: i32,
    roughness_map: i32,
    normal_scale: f32,
    // Below this alpha there is nothing; negative where nothing is cut out.
    cutout: f32,
    reserved: vec2f,
}

struct Light {
    reach_m: f32,
    reserved0: f32,
    reserved1: f32,
    reserved2: f32,
    // Direction towards it, or its middle.
    at: vec4f,
    colour: vec4f,
    half_right: vec4f,
    half_up: vec4f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> objects: array<Object>;
@group(0) @binding(2) var<storage, read> materials: array<Material>;
@group(0) @binding(3) var<storage, read> lights: array<Light>;
@group(0) @binding(4) var sky_map: texture_2d<f32>;
@group(0) @binding(5) var sky_sampler: sampler;
@group(0) @binding(6) var colour_maps: texture_2d_array<f32>;
@group(0) @binding(7) var data_maps: texture_2d_array<f32>;
@group(0) @binding(8) var map_sampler: sampler;
@group(0) @binding(9) var shadow_map: texture_depth_2d;
@group(0) @binding(10) var shadow_sampler: sampler_comparison;

const PI: f32 = 3.14159265;

// What a pipeline need not ask at every pixel, because software devices run every branch for every pixel. Where a pipeline
// serves every material, the pattern is read from the material.
const ANY_PATTERN: u32 = 0xffu;
override PATTERN: u32 = 0xffu;
override HAS_MAPS: bool = true;
override HAS_RELIEF: bool = true;
override HAS_SHADOW: bool = true;
override HAS_POINT_LIGHTS: bool = true;
override HAS_AREA_LIGHTS: bool = true;

fn pattern_kind(m: Material) -> u32 {
    if PATTERN != ANY_PATTERN {
        return PATTERN;
    }
    return m.pattern;
}

fn rows_times(rows: array<vec4f, 3>, at: vec4f) -> vec3f {
    return vec3f(dot(rows[0], at), dot(rows[1], at), dot(rows[2], at));
}

// Direction of the ray through a display pixel, one unit deep.
fn ray_through(px: vec2f) -> vec3f {
    let plane = plane_from_px(frame.geometry, px);
    return frame.forward.xyz + frame.right.xyz * plane.x + frame.up.xyz * plane.y;
}

// Light as it leaves for a picture. What is brighter than white looks the same, but a filter would spread it over its
// surroundings as light that no display sends out.
fn seen(colour: vec3f) -> vec4f {
    return half_colour(min(colour, vec3f(min(frame.white, 6e4))));
}

// What `MotionRequest` asks for, of a place that is at `now` and was at `then`; of a direction where `at_infinity`.
fn motion_of(now: vec3f, then: vec3f, px: vec2f, at_infinity: bool) -> vec4f {
    let to_now = select(now - frame.eye.xyz, now, at_infinity);
    let to_then = select(then - frame.then_eye.xyz, then, at_infinity);
    let depth_now = dot(to_now, frame.forward.xyz);
    let depth_then = dot(to_then, frame.then_forward.xyz);
    let inverse = select(vec2f(1.0 / depth_then, 1.0 / depth_now), vec2f(0.0), at_infinity);
    if depth_then <= 1e-6 {
        // It was behind the camera: far off any picture.
        return vec4f(3e4, 3e4, inverse);
    }
    let plane = vec2f(dot(to_then, frame.then_right.xyz), dot(to_then, frame.then_up.xyz)) / depth_then;
    let scaled = plane / frame.geometry.pitch_per_distance;
    let px_then = vec2f(frame.geometry.centre_px.x + scaled.x, frame.geometry.centre_px.y - scaled.y);
    return vec4f(clamp(px_then - px, vec2f(-3e4), vec2f(3e4)), inverse);
}
