// The surfaces that a view shows, unshaded.

struct Surfaces {
    // World normal; roughness.
    @location(0) normal_roughness: vec4f,
    // Metalness in alpha.
    @location(1) albedo_metalness: vec4f,
    // Alpha is 0 where there is the sky, whose light is the colour; of a surface ½ and half of how open it is.
    @location(2) emission: vec4f,
    // One over the distance along the viewing axis; 0 for the sky.
    @location(3) inverse_depth: f32,
}

fn surfaces_of(place: Place) -> Surfaces {
    let s = surface_at(place);
    let depth = dot(place.world - frame.eye.xyz, frame.forward.xyz);
    return Surfaces(vec4f(s.normal, s.roughness), vec4f(s.albedo, s.metalness), vec4f(s.emission, 0.5 + 0.5 * s.open), 1.0 / depth);
}

@fragment
fn surfaces(covered: Covered) -> Surfaces {
    return surfaces_of(place_of(covered));
}

@fragment
fn surfaces_with_holes(covered: Covered) -> Surfaces {
    let place = place_of(covered);
    if cut_out(place) {
        discard;
    }
    return surfaces_of(place);
}

@fragment
fn sky_surfaces(@builtin(position) clip: vec4f) -> Surfaces {
    return Surfaces(vec4f(0.0), vec4f(0.0), vec4f(sky_light(clip).rgb, 0.0), 0.0);
}
