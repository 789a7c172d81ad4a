// Counts every pixel of a view once, for scenes whose shading function runs once in each of them.

struct View {
    origin_px: vec2f,
    step_px: vec2f,
    // Whether each pixel also counts as a run.
    runs: u32,
    reserved: vec3u,
}

@group(0) @binding(0) var<uniform> u: View;

@fragment
fn count(@builtin(position) position: vec4f) -> @location(0) vec4f {
    count_pixel();
    if u.runs != 0u {
        count_run(u.origin_px + position.xy * u.step_px);
    }
    return vec4f(0.0);
}
