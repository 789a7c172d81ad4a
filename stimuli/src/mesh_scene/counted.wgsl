// The colours once more, counted; see `crate::tally`. Depth is tested before, as it is where nothing is counted.

@fragment
@early_depth_test(force)
fn colour_counted(covered: Covered) -> @location(0) vec4f {
    count_run(display_px(covered.clip));
    return seen(shade(surface_at(place_of(covered))));
}

@fragment
fn colour_with_holes_counted(covered: Covered) -> @location(0) vec4f {
    let place = place_of(covered);
    if cut_out(place) {
        discard;
    }
    count_run(display_px(covered.clip));
    return seen(shade(surface_at(place)));
}

@fragment
@early_depth_test(force)
fn sky_colour_counted(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    count_run(display_px(clip));
    return sky_light(clip);
}
