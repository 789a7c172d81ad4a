// Depths as the sun sees them.

@vertex
fn transform_to_sun(@location(0) position: vec3f, @builtin(instance_index) object: u32) -> @builtin(position) vec4f {
    let world = rows_times(objects[object].now, vec4f(position, 1.0));
    let place = frame.shadow * vec4f(world, 1.0);
    return vec4f(place.x * 2.0 - 1.0, 1.0 - place.y * 2.0, place.z, 1.0);
}
