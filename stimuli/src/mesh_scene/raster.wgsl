// The rasterised view: vertices of objects, and the colour or motion of what they cover.

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
}

// Places are taken in the pixel's middle, so that their differences between pixels are exact at the edges of triangles, too;
// directions within the triangle.
struct Covered {
    @builtin(position) clip: vec4f,
    @location(0) mesh: vec3f,
    @location(1) world: vec3f,
    @location(2) @interpolate(perspective, centroid) normal: vec3f,
    @location(3) tangent: vec4f,
    @location(4) uv: vec2f,
    @location(5) @interpolate(flat) object: u32,
}

@vertex
fn transform(corner: Corner, @builtin(instance_index) object: u32) -> Covered {
    let o = objects[object];
    let world = rows_times(o.now, vec4f(corner.position, 1.0));
    var covered: Covered;
    covered.clip = frame.clip * vec4f(world, 1.0);
    covered.mesh = corner.position;
    covered.world = world;
    covered.normal = rows_times(o.normal, vec4f(corner.normal, 0.0));
    covered.tangent = vec4f(rows_times(o.now, vec4f(corner.tangent.xyz, 0.0)), corner.tangent.w);
    covered.uv = corner.uv;
    covered.object = object;
    return covered;
}

fn place_of(covered: Covered) -> Place {
    var place: Place;
    place.material = objects[covered.object].material;
    place.mesh = covered.mesh;
    place.world = covered.world;
    let to_eye = frame.eye.xyz - covered.world;
    let normal = normalize(covered.normal);
    place.tangent = covered.tangent;
    place.uv = covered.uv;
    place.mesh_dx = dpdx(covered.mesh);
    place.mesh_dy = dpdy(covered.mesh);
    place.world_dx = dpdx(covered.world);
    place.world_dy = dpdy(covered.world);
    place.uv_dx = dpdx(covered.uv);
    place.uv_dy = dpdy(covered.uv);
    // Which side is seen follows from the triangle itself: a smooth normal may look away at a rim.
    let flat_normal = cross(place.world_dy, place.world_dx);
    let outwards = select(-1.0, 1.0, dot(flat_normal, normal) * dot(flat_normal, to_eye) >= 0.0);
    place.normal = normal * outwards;
    return place;
}

fn cut_out(place: Place) -> bool {
    let m = materials[place.material];
    return m.albedo_map >= 0 && colour_of_map(m.albedo_map, place).a < m.cutout;
}

fn display_px(clip: vec4f) -> vec2f {
    return frame.origin_px + clip.xy * frame.step_px;
}

@fragment
fn colour(covered: Covered) -> @location(0) vec4f {
    return seen(shade(surface_at(place_of(covered))));
}

@fragment
fn colour_with_holes(covered: Covered) -> @location(0) vec4f {
    let place = place_of(covered);
    if cut_out(place) {
        discard;
    }
    return seen(shade(surface_at(place)));
}

// What motion needs of a vertex, and no more: software devices take their time over each number of each.
struct Moved {
    @builtin(position) clip: vec4f,
    @location(0) mesh: vec3f,
    @location(1) world: vec3f,
    @location(2) @interpolate(flat) object: u32,
}

@vertex
fn transform_for_motion(@location(0) position: vec3f, @builtin(instance_index) object: u32) -> Moved {
    let world = rows_times(objects[object].now, vec4f(position, 1.0));
    return Moved(frame.clip * vec4f(world, 1.0), position, world, object);
}

@fragment
fn motion(moved: Moved) -> @location(0) vec4f {
    let then = rows_times(objects[moved.object].then, vec4f(moved.mesh, 1.0));
    return motion_of(moved.world, then, display_px(moved.clip), false);
}

@fragment
fn motion_with_holes(covered: Covered) -> @location(0) vec4f {
    if cut_out(place_of(covered)) {
        discard;
    }
    let then = rows_times(objects[covered.object].then, vec4f(covered.mesh, 1.0));
    return motion_of(covered.world, then, display_px(covered.clip), false);
}

// Infinitely far: depth 0.
@vertex
fn cover_far(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

fn sky_light(clip: vec4f) -> vec4f {
    let ray = ray_through(display_px(clip));
    // The level whose texels are about as large as the pixel.
    let pixel_rad = length(frame.geometry.pitch_per_distance * frame.step_px) * 0.7 / length(ray);
    let texel_rad = PI / f32(textureDimensions(sky_map).y);
    return seen(sky_in_direction(normalize(ray), max(log2(pixel_rad / texel_rad), 0.0)));
}

@fragment
fn sky_colour(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    return sky_light(clip);
}

@fragment
fn sky_motion(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let px = display_px(clip);
    let ray = ray_through(px);
    return motion_of(ray, ray, px, true);
}
