// The world as rays meet it (group 1): one hierarchy over the objects, and one over the triangles of each mesh.

struct Node {
    low: vec3f,
    first: u32,
    high: vec3f,
    count: u32,
}

// A mesh in an object's place: rows of the matrix from the world to the mesh, and where the mesh's nodes begin.
struct Traced {
    inverse: array<vec4f, 3>,
    root: u32,
    object: u32,
    reserved0: u32,
    reserved1: u32,
}

// Positions are the first three words of a vertex, normals the next three, then tangents and map coordinates.
const VERTEX_WORDS: u32 = 12u;

@group(1) @binding(0) var<storage, read> object_nodes: array<Node>;
@group(1) @binding(1) var<storage, read> traced: array<Traced>;
@group(1) @binding(2) var<storage, read> mesh_nodes: array<Node>;
// Three vertices of each triangle, in the order in which leaves hold them.
@group(1) @binding(3) var<storage, read> triangles: array<u32>;
@group(1) @binding(4) var<storage, read> vertices: array<f32>;

struct Hit {
    // Along the direction, in its lengths; negative where nothing was met.
    distance: f32,
    object: u32,
    triangle: u32,
    // Shares of the second and third corner.
    shares: vec2f,
}

fn vertex_word3(vertex: u32, word: u32) -> vec3f {
    let at = vertex * VERTEX_WORDS + word;
    return vec3f(vertices[at], vertices[at + 1u], vertices[at + 2u]);
}

// Where a ray enters a box; beyond `farthest` where it does not. Slabs as Kay and Kajiya (1986).
fn entry(node: Node, origin: vec3f, inverse: vec3f, farthest: f32) -> f32 {
    let a = (node.low - origin) * inverse;
    let b = (node.high - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(max(near.x, near.y), near.z), 0.0);
    let leave = min(min(min(far.x, far.y), far.z), farthest);
    // Rounding never loses a box that is touched.
    return select(3e38, enter, enter <= leave * 1.0000004);
}

fn inverse_of(d: vec3f) -> vec3f {
    return 1.0 / select(d, select(vec3f(-1e-20), vec3f(1e-20), d >= vec3f(0.0)), abs(d) < vec3f(1e-20));
}

// The nearest triangle of one mesh, nearer than `best` (Möller and Trumbore 1997). With `any`, the first that is found.
fn trace_mesh(root: u32, origin: vec3f, direction: vec3f, best: Hit, object: u32, any: bool) -> Hit {
    var hit = best;
    let inverse = inverse_of(direction);
    var stack: array<u32, 32>;
    stack[0] = root;
    var open = 1u;
    while open > 0u {
        open--;
        let node = mesh_nodes[stack[open]];
        if entry(node, origin, inverse, hit.distance) > 1e38 {
            continue;
        }
        if node.count == 0u {
            // The nearer child is taken first, so it goes on top.
            let left = entry(mesh_nodes[node.first], origin, inverse, hit.distance);
            let right = entry(mesh_nodes[node.first + 1u], origin, inverse, hit.distance);
            let swap = u32(left < right);
            if max(left, right) < 1e38 {
                stack[open] = node.first + swap;
                open++;
            }
            if min(left, right) < 1e38 {
                stack[open] = node.first + 1u - swap;
                open++;
            }
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let a = vertex_word3(triangles[3u * i], 0u);
            let ab = vertex_word3(triangles[3u * i + 1u], 0u) - a;
            let ac = vertex_word3(triangles[3u * i + 2u], 0u) - a;
            let p = cross(direction, ac);
            let determinant = dot(ab, p);
            let scale = 1.0 / determinant;
            let to = origin - a;
            let u = dot(to, p) * scale;
            let q = cross(to, ab);
            let v = dot(direction, q) * scale;
            let t = dot(ac, q) * scale;
            if determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < hit.distance {
                hit = Hit(t, object, i, vec2f(u, v));
                if any {
                    return hit;
                }
            }
        }
    }
    return hit;
}

// The nearest surface along a ray, up to `farthest` lengths of its direction. With `any`, whichever is found first: enough
// to know that something is in the way.
fn trace(origin: vec3f, direction: vec3f, farthest: f32, any: bool) -> Hit {
    var hit = Hit(farthest, 0u, 0u, vec2f(0.0));
    let inverse = inverse_of(direction);
    var stack: array<u32, 32>;
    var open = select(0u, 1u, arrayLength(&traced) > 0u && traced[0].root != 0xffffffffu);
    stack[0] = 0u;
    while open > 0u {
        open--;
        let node = object_nodes[stack[open]];
        if entry(node, origin, inverse, hit.distance) > 1e38 {
            continue;
        }
        if node.count == 0u {
            let left = entry(object_nodes[node.first], origin, inverse, hit.distance);
            let right = entry(object_nodes[node.first + 1u], origin, inverse, hit.distance);
            let swap = u32(left < right);
            if max(left, right) < 1e38 {
                stack[open] = node.first + swap;
                open++;
            }
            if min(left, right) < 1e38 {
                stack[open] = node.first + 1u - swap;
                open++;
            }
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let t = traced[i];
            let own_origin = rows_times(t.inverse, vec4f(origin, 1.0));
            let own_direction = rows_times(t.inverse, vec4f(direction, 0.0));
            hit = trace_mesh(t.root, own_origin, own_direction, hit, t.object, any);
            if any && hit.distance < farthest {
                return hit;
            }
        }
    }
    if hit.distance >= farthest {
        hit.distance = -1.0;
    }
    return hit;
}

fn blend3(a: vec3f, b: vec3f, c: vec3f, shares: vec2f) -> vec3f {
    return a * (1.0 - shares.x - shares.y) + b * shares.x + c * shares.y;
}

// What `surface_at` needs to know of a hit. `footprint` is the width of a pixel at the hit, across the ray, metres.
fn place_of_hit(hit: Hit, origin: vec3f, direction: vec3f, footprint: f32) -> Place {
    let o = objects[hit.object];
    let corners = vec3u(triangles[3u * hit.triangle], triangles[3u * hit.triangle + 1u], triangles[3u * hit.triangle + 2u]);
    var place: Place;
    place.material = o.material;
    let a = vertex_word3(corners.x, 0u);
    let b = vertex_word3(corners.y, 0u);
    let c = vertex_word3(corners.z, 0u);
    place.mesh = blend3(a, b, c, hit.shares);
    place.world = rows_times(o.now, vec4f(place.mesh, 1.0));
    let own_normal = blend3(vertex_word3(corners.x, 3u), vertex_word3(corners.y, 3u), vertex_word3(corners.z, 3u), hit.shares);
    let normal = normalize(rows_times(o.normal, vec4f(own_normal, 0.0)));
    let flat_normal = rows_times(o.normal, vec4f(cross(b - a, c - a), 0.0));
    let outwards = select(-1.0, 1.0, dot(flat_normal, normal) * dot(flat_normal, -direction) >= 0.0);
    place.normal = normal * outwards;
    let own_tangent = blend3(vertex_word3(corners.x, 6u), vertex_word3(corners.y, 6u), vertex_word3(corners.z, 6u), hit.shares);
    let signs = vec3f(
        vertices[corners.x * VERTEX_WORDS + 9u], vertices[corners.y * VERTEX_WORDS + 9u], vertices[corners.z * VERTEX_WORDS + 9u],
    );
    let sign_and_openness = dot(signs, vec3f(1.0 - hit.shares.x - hit.shares.y, hit.shares));
    place.tangent = vec4f(rows_times(o.now, vec4f(own_tangent, 0.0)), sign_and_openness);
    let uv_a = vec2f(vertices[corners.x * VERTEX_WORDS + 10u], vertices[corners.x * VERTEX_WORDS + 11u]);
    let uv_b = vec2f(vertices[corners.y * VERTEX_WORDS + 10u], vertices[corners.y * VERTEX_WORDS + 11u]);
    let uv_c = vec2f(vertices[corners.z * VERTEX_WORDS + 10u], vertices[corners.z * VERTEX_WORDS + 11u]);
    place.uv = uv_a * (1.0 - hit.shares.x - hit.shares.y) + uv_b * hit.shares.x + uv_c * hit.shares.y;

    // Two steps of a pixel on the plane of the triangle, as the next pixels' rays would meet it.
    let face = normalize(flat_normal);
    let forward = normalize(direction);
    let right = normalize(cross(forward, select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(forward.y) > 0.99)));
    let down = cross(forward, right);
    let grazing = dot(face, forward);
    let safe = select(min(grazing, -0.02), max(grazing, 0.02), grazing >= 0.0);
    place.world_dx = footprint * (right - forward * (dot(face, right) / safe));
    place.world_dy = footprint * (down - forward * (dot(face, down) / safe));
    // Back to the mesh by its two edges.
    let ab = rows_times(o.now, vec4f(b - a, 0.0));
    let ac = rows_times(o.now, vec4f(c - a, 0.0));
    let g = vec3f(dot(ab, ab), dot(ab, ac), dot(ac, ac));
    let scale = 1.0 / max(g.x * g.z - g.y * g.y, 1e-30);
    let dx = vec2f(dot(ab, place.world_dx), dot(ac, place.world_dx));
    let dy = vec2f(dot(ab, place.world_dy), dot(ac, place.world_dy));
    let shares_dx = vec2f(g.z * dx.x - g.y * dx.y, g.x * dx.y - g.y * dx.x) * scale;
    let shares_dy = vec2f(g.z * dy.x - g.y * dy.y, g.x * dy.y - g.y * dy.x) * scale;
    place.mesh_dx = (b - a) * shares_dx.x + (c - a) * shares_dx.y;
    place.mesh_dy = (b - a) * shares_dy.x + (c - a) * shares_dy.y;
    place.uv_dx = (uv_b - uv_a) * shares_dx.x + (uv_c - uv_a) * shares_dx.y;
    place.uv_dy = (uv_b - uv_a) * shares_dy.x + (uv_c - uv_a) * shares_dy.y;
    return place;
}

// The light along a ray of the camera, as the rasterised picture shows it.
fn radiance_along(origin: vec3f, direction: vec3f, pixel_rad: f32) -> vec3f {
    let hit = trace(origin, direction, 1e30, false);
    if hit.distance < 0.0 {
        let texel_rad = PI / f32(textureDimensions(sky_map).y);
        return seen(sky_in_direction(normalize(direction), max(log2(pixel_rad / texel_rad), 0.0))).rgb;
    }
    let footprint = pixel_rad * hit.distance * length(direction);
    return seen(shade(surface_at(place_of_hit(hit, origin, direction, footprint)))).rgb;
}
