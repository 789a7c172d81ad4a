// How the court has moved since an earlier camera: nothing in it moves by itself. What a mirror shows is taken to lie on it.

// Farther than any display: where the earlier camera did not see the place.
const NOWHERE: f32 = 6e4;

@fragment
fn motion(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = u.origin_px + position.xy * u.step_px;
    let plane = plane_from_px(u.geometry, px);
    // As `ray`, but one unit long along the viewing axis.
    let along = u.forward.xyz + plane.x * u.right.xyz + plane.y * u.up.xyz;
    let hit = hit_scene(u.eye.xyz, normalize(along));

    // From the earlier camera to the place; only the direction of the sky counts. Divided by the depth now.
    let sky = hit.id < 0;
    let inverse_depth = select(length(along) / hit.distance, 0.0, sky);
    let from_earlier = along + inverse_depth * u.come.xyz;
    let depths_then = dot(from_earlier, u.earlier_forward.xyz);
    if depths_then <= 1e-3 {
        return vec4f(NOWHERE, NOWHERE, 0.0, inverse_depth);
    }
    let then = vec2f(dot(from_earlier, u.earlier_right.xyz), dot(from_earlier, u.earlier_up.xyz)) / depths_then;
    let moved = (then - plane) / u.geometry.pitch_per_distance * vec2f(1.0, -1.0);
    return vec4f(clamp(moved, vec2f(-NOWHERE), vec2f(NOWHERE)), inverse_depth / depths_then, inverse_depth);
}
