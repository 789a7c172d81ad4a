//! A quieter periphery: colour fades and fine detail goes with the angle from the gaze.
//! source: an example; write your own beside it
//! parameter radius_deg [°] 0..60 = 3: Radius of the part that stays as it is.
//! parameter blur_rate [°/°] 0..0.1 = 0.01: By how many degrees the blur's standard deviation grows with each degree beyond.
//! parameter grey [] 0..1 = 0.5: How much of the colour is gone far out.
//! parameter fade_deg [°] 0.5..60 = 15: Over how many degrees beyond the radius the colour goes.
//! detail: gaussian radius_deg blur_rate

// What the eye sees of a colour when it sees no hue: its luminance (ITU-R BT.709).
fn luminance(light: vec3f) -> f32 {
    return dot(light, vec3f(0.2126, 0.7152, 0.0722));
}

// The colour of one pixel of the display, in linear light. `at` says where it is, `given` holds the parameters.
fn colour(at: Place, given: Parameters) -> vec3f {
    let beyond_deg = at.eccentricity_deg - given.radius_deg;
    if beyond_deg <= 0.0 {
        // The scene's own pixel, exactly.
        return picture_at(at.px);
    }
    let sigma_px = given.blur_rate * beyond_deg / pixel_deg_at(at.px);
    let blurred = sample_sigma(at.px, sigma_px);
    let share = given.grey * smoothstep(0.0, given.fade_deg, beyond_deg);
    return mix(blurred, vec3f(luminance(blurred)), share);
}
