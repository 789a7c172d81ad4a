// A small courtyard, ray-cast: columns around a paved floor, spheres and plinths among them, under an environment map.
// The camera's rays go through the display's own pixels, so a degree here is a degree on the display.

struct Orbit {
    geometry: Geometry,
    origin_px: vec2f,
    step_px: vec2f,
    eye: vec4f,
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // Towards the sun, and its light on a surface that faces it.
    sun: vec4f,
    sun_light: vec4f,
    // Irradiance of the environment without its sun, over pi: second-order spherical harmonics.
    ambient: array<vec4f, 9>,
    // Centre and radius.
    spheres: array<vec4f, 7>,
    // Colour, and the share that is mirrored at normal incidence.
    sphere_colours: array<vec4f, 7>,
    // Where the columns stand, x and z.
    columns: array<vec4f, 8>,
    // Middle of a block, and half its size.
    block_middles: array<vec4f, 5>,
    block_halves: array<vec4f, 5>,
    // From the earlier camera to this one, and the earlier one's axes.
    come: vec4f,
    earlier_right: vec4f,
    earlier_up: vec4f,
    earlier_forward: vec4f,
}

@group(0) @binding(0) var<uniform> u: Orbit;
@group(0) @binding(1) var environment: texture_2d<f32>;

const FAR: f32 = 1e9;
const FLOOR: i32 = 0;
const SPHERES: i32 = 7;
const COLUMNS: i32 = 8;
const PI: f32 = 3.14159265;

const COLUMN_RADIUS: f32 = 0.42;
const COLUMN_HEIGHT: f32 = 4.4;

struct Hit {
    distance: f32,
    // -1 nothing, 0 floor, then spheres, columns, blocks.
    id: i32,
}

fn hit_sphere(o: vec3f, d: vec3f, s: vec4f) -> f32 {
    let to = o - s.xyz;
    let b = dot(to, d);
    // Distance from the centre to the ray, which keeps its digits far away.
    let off = to - b * d;
    let discriminant = s.w * s.w - dot(off, off);
    if discriminant < 0.0 {
        return FAR;
    }
    let root = sqrt(discriminant);
    let near = -b - root;
    return select(select(FAR, -b + root, -b + root > 1e-3), near, near > 1e-3);
}

fn hit_column(o: vec3f, d: vec3f, middle: vec2f) -> f32 {
    let to = o.xz - middle;
    let a = dot(d.xz, d.xz);
    let b = dot(to, d.xz);
    let c = dot(to, to) - COLUMN_RADIUS * COLUMN_RADIUS;
    let discriminant = b * b - a * c;
    if discriminant < 0.0 || a < 1e-9 {
        return FAR;
    }
    let t = (-b - sqrt(discriminant)) / a;
    let y = o.y + t * d.y;
    return select(FAR, t, t > 1e-3 && y >= 0.0 && y <= COLUMN_HEIGHT);
}

fn hit_box(o: vec3f, inverse_d: vec3f, middle: vec3f, half_size: vec3f) -> f32 {
    let a = (middle - half_size - o) * inverse_d;
    let b = (middle + half_size - o) * inverse_d;
    let low = min(a, b);
    let high = max(a, b);
    let enter = max(max(low.x, low.y), low.z);
    let leave = min(min(high.x, high.y), high.z);
    return select(FAR, enter, enter <= leave && enter > 1e-3);
}

fn safe_inverse(d: vec3f) -> vec3f {
    return 1.0 / select(d, vec3f(1e-7), abs(d) < vec3f(1e-7));
}

fn nearer(hit: Hit, distance: f32, id: i32) -> Hit {
    if distance < hit.distance {
        return Hit(distance, id);
    }
    return hit;
}

// Written out, because software devices fetch an indexed uniform once for every pixel.
fn hit_scene(o: vec3f, d: vec3f) -> Hit {
    var hit = Hit(FAR, -1);
    if d.y < 0.0 {
        hit = Hit(-o.y / d.y, FLOOR);
    }
    let inverse_d = safe_inverse(d);
    hit = nearer(hit, hit_sphere(o, d, u.spheres[0]), 1);
    hit = nearer(hit, hit_sphere(o, d, u.spheres[1]), 2);
    hit = nearer(hit, hit_sphere(o, d, u.spheres[2]), 3);
    hit = nearer(hit, hit_sphere(o, d, u.spheres[3]), 4);
    hit = nearer(hit, hit_sphere(o, d, u.spheres[4]), 5);
    hit = nearer(hit, hit_sphere(o, d, u.spheres[5]), 6);
    hit = nearer(hit, hit_sphere(o, d, u.spheres[6]), 7);
    hit = nearer(hit, hit_column(o, d, u.columns[0].xy), 8);
    hit = nearer(hit, hit_column(o, d, u.columns[1].xy), 9);
    hit = nearer(hit, hit_column(o, d, u.columns[2].xy), 10);
    hit = nearer(hit, hit_column(o, d, u.columns[3].xy), 11);
    hit = nearer(hit, hit_column(o, d, u.columns[4].xy), 12);
    hit = nearer(hit, hit_column(o, d, u.columns[5].xy), 13);
    hit = nearer(hit, hit_column(o, d, u.columns[6].xy), 14);
    hit = nearer(hit, hit_column(o, d, u.columns[7].xy), 15);
    hit = nearer(hit, hit_box(o, inverse_d, u.block_middles[0].xyz, u.block_halves[0].xyz), 16);
    hit = nearer(hit, hit_box(o, inverse_d, u.block_middles[1].xyz, u.block_halves[1].xyz), 17);
    hit = nearer(hit, hit_box(o, inverse_d, u.block_middles[2].xyz, u.block_halves[2].xyz), 18);
    hit = nearer(hit, hit_box(o, inverse_d, u.block_middles[3].xyz, u.block_halves[3].xyz), 19);
    hit = nearer(hit, hit_box(o, inverse_d, u.block_middles[4].xyz, u.block_halves[4].xyz), 20);
    return hit;
}

fn hash(p: vec2f) -> f32 {
    let q = vec2u(vec2i(p));
    var h = q.x * 1664525u + q.y * 22695477u + 1013904223u;
    h ^= h >> 15u;
    h *= 2246822519u;
    h ^= h >> 13u;
    h *= 3266489917u;
    h ^= h >> 16u;
    return f32(h >> 8u) / 16777216.0;
}

fn value_noise(p: vec2f) -> f32 {
    let i = floor(p);
    let f = p - i;
    let s = f * f * (3.0 - 2.0 * f);
    let low = mix(hash(i), hash(i + vec2f(1.0, 0.0)), s.x);
    let high = mix(hash(i + vec2f(0.0, 1.0)), hash(i + vec2f(1.0, 1.0)), s.x);
    return mix(low, high, s.y);
}

// Grain of stone around 0, in octaves that fade out before they are finer than a pixel (`footprint`, metres).
fn grain(p: vec2f, footprint: f32) -> f32 {
    var sum = 0.0;
    var scale = 6.0;
    for (var octave = 0; octave < 4; octave++) {
        let shown = 1.0 - smoothstep(0.25, 0.6, footprint * scale);
        if shown <= 0.0 {
            break;
        }
        sum += shown * (value_noise(p * scale) - 0.5);
        scale *= 2.7;
    }
    return sum;
}

// Colour of a slab of the floor, and in w how much of a joint is under the pixel.
fn paving(p: vec2f, footprint: f32) -> vec4f {
    let row = floor(p.y / 0.5);
    let x = p.x + 0.37 * row;
    let cell = vec2f(floor(x / 0.75), row);
    let in_cell = vec2f(x - cell.x * 0.75, p.y - row * 0.5);
    let to_joint = min(min(in_cell.x, 0.75 - in_cell.x), min(in_cell.y, 0.5 - in_cell.y));
    // A joint thinner than a pixel darkens it by its share.
    let soft = max(footprint, 0.004);
    let joint = (1.0 - smoothstep(0.012 - soft, 0.012 + soft, to_joint)) * min(1.0, 0.03 / soft);
    return vec4f(mix(vec3f(0.42, 0.35, 0.28), vec3f(0.66, 0.60, 0.52), hash(cell + 57.0)), joint);
}

struct Surface {
    normal: vec3f,
    colour: vec3f,
    // Share that is reflected at normal incidence.
    gloss: f32,
}

// One place for all kinds, so that a device that runs every branch pays for the grain once.
fn surface(p: vec3f, id: i32, footprint: f32) -> Surface {
    var s = Surface(vec3f(0.0, 1.0, 0.0), vec3f(0.0), 0.03);
    var place = p.xz + 40.0;
    var roughness = 0.5;
    var joint = 0.0;
    if id == FLOOR {
        let slab = paving(place, footprint);
        s.colour = slab.rgb;
        joint = slab.w;
    } else if id <= SPHERES {
        let sphere = u.spheres[id - 1];
        s.normal = (p - sphere.xyz) / sphere.w;
        // Glazed stripes.
        let bands = sin(s.normal.y * 22.0 + 1.7 * sin(atan2(s.normal.z, s.normal.x) * 6.0));
        s.colour = mix(u.sphere_colours[id - 1].rgb, vec3f(0.86, 0.82, 0.74), smoothstep(0.72, 0.86, bands));
        s.gloss = 0.06;
        roughness = 0.0;
    } else if id <= SPHERES + COLUMNS {
        // Flutes: the normal sways with the angle and the valleys are darker; plain drums at the foot and the top.
        let away = p.xz - u.columns[id - SPHERES - 1].xy;
        let around = atan2(away.y, away.x);
        let drum = step(abs(p.y - 0.5 * COLUMN_HEIGHT), 0.5 * COLUMN_HEIGHT - 0.35);
        let depth = drum * (1.0 - smoothstep(0.02, 0.06, footprint));
        let turn = around + 0.35 * depth * sin(around * 14.0);
        s.normal = vec3f(cos(turn), 0.0, sin(turn));
        s.colour = vec3f(0.66, 0.60, 0.52) * (1.0 - 0.22 * depth * (0.5 - 0.5 * cos(around * 14.0)));
        place = vec2f(around * 0.5, p.y) + 20.0;
    } else {
        let block = id - SPHERES - COLUMNS - 1;
        let q = (p - u.block_middles[block].xyz) / u.block_halves[block].xyz;
        let a = abs(q);
        s.normal = vec3f(0.0, sign(q.y), 0.0);
        if a.x >= a.y && a.x >= a.z {
            s.normal = vec3f(sign(q.x), 0.0, 0.0);
            place = p.zy + 11.0;
        } else if a.z >= a.y {
            s.normal = vec3f(0.0, 0.0, sign(q.z));
            place = p.xy + 11.0;
        }
        s.colour = mix(vec3f(0.62, 0.57, 0.50), vec3f(0.46, 0.42, 0.39), f32(block & 1));
    }
    let worn = s.colour * (1.0 + roughness * grain(place, footprint));
    s.colour = mix(worn, vec3f(0.13, 0.12, 0.10), 0.8 * joint);
    return s;
}

fn environment_light(d: vec3f) -> vec3f {
    let size = vec2f(textureDimensions(environment));
    let at = vec2f(atan2(d.z, d.x) / (2.0 * PI) + 0.5, acos(clamp(d.y, -1.0, 1.0)) / PI) * size - 0.5;
    let corner = floor(at);
    let share = at - corner;
    let wide = vec2i(size);
    let x0 = (i32(corner.x) + wide.x) % wide.x;
    let x1 = (x0 + 1) % wide.x;
    let y0 = clamp(i32(corner.y), 0, wide.y - 1);
    let y1 = min(y0 + 1, wide.y - 1);
    let top = mix(textureLoad(environment, vec2i(x0, y0), 0).rgb, textureLoad(environment, vec2i(x1, y0), 0).rgb, share.x);
    let bottom = mix(textureLoad(environment, vec2i(x0, y1), 0).rgb, textureLoad(environment, vec2i(x1, y1), 0).rgb, share.x);
    return mix(top, bottom, share.y);
}

fn ambient_light(n: vec3f) -> vec3f {
    let light = u.ambient[0].rgb
        + u.ambient[1].rgb * n.y + u.ambient[2].rgb * n.z + u.ambient[3].rgb * n.x
        + u.ambient[4].rgb * (n.x * n.y) + u.ambient[5].rgb * (n.y * n.z)
        + u.ambient[6].rgb * (3.0 * n.z * n.z - 1.0)
        + u.ambient[7].rgb * (n.x * n.z) + u.ambient[8].rgb * (n.x * n.x - n.y * n.y);
    return max(light, vec3f(0.02));
}

// Share of the sky that a sphere leaves open to a point.
fn beside(p: vec3f, n: vec3f, sphere: vec4f) -> f32 {
    let to = sphere.xyz - p;
    let distance2 = dot(to, to);
    let r2 = sphere.w * sphere.w;
    let hidden = max(dot(n, to), 0.0) * inverseSqrt(distance2) * r2 / distance2;
    // Not for the sphere that the point itself is on, and not far away.
    return 1.0 - select(0.0, hidden, distance2 > 1.001 * r2 && distance2 < 9.0 * r2);
}

fn openness(p: vec3f, n: vec3f) -> f32 {
    return beside(p, n, u.spheres[0]) * beside(p, n, u.spheres[1]) * beside(p, n, u.spheres[2])
        * beside(p, n, u.spheres[3]) * beside(p, n, u.spheres[4]) * beside(p, n, u.spheres[5])
        * beside(p, n, u.spheres[6]);
}

struct Seen {
    light: vec3f,
    // What the ray met first.
    id: i32,
}

// Light along a ray whose pixel is `cone` radians wide: through up to two mirrors, then one surface or the sky.
fn light_along(o_first: vec3f, d_first: vec3f, cone: f32) -> Seen {
    var o = o_first;
    var d = d_first;
    var tint = vec3f(1.0);
    var travelled = 0.0;
    var hit = Hit(FAR, -1);
    var first = -2;
    for (var mirrors = 0; mirrors < 3; mirrors++) {
        hit = hit_scene(o, d);
        first = select(first, hit.id, first == -2);
        if hit.id < 1 || hit.id > SPHERES {
            break;
        }
        let sphere = u.spheres[hit.id - 1];
        let metal = u.sphere_colours[hit.id - 1];
        if metal.w < 0.5 {
            break;
        }
        let p = o + hit.distance * d;
        let normal = (p - sphere.xyz) / sphere.w;
        let grazing = 1.0 - clamp(dot(normal, -d), 0.0, 1.0);
        tint *= metal.w * mix(metal.rgb, vec3f(1.0), grazing * grazing * grazing * grazing * grazing);
        travelled += hit.distance;
        o = p + normal * 2e-3;
        d = reflect(d, normal);
        // After the last mirror only the sky is left.
        hit.id = -1;
    }
    if hit.id < 0 {
        return Seen(tint * environment_light(d), first);
    }

    // What the surface scatters: the sky's light where it is open, the sun's where it is not shadowed.
    let p = o + hit.distance * d;
    let slope = select(1.0, max(-d.y, 0.05), hit.id == FLOOR);
    let s = surface(p, hit.id, (travelled + hit.distance) * cone * inverseSqrt(slope));
    var light = ambient_light(s.normal) * openness(p, s.normal);
    let facing = dot(s.normal, u.sun.xyz);
    if facing > 0.0 && hit_scene(p + s.normal * 2e-3, u.sun.xyz).id < 0 {
        light += facing * u.sun_light.rgb;
    }

    // What it mirrors, of the sky alone.
    let grazing = 1.0 - clamp(dot(s.normal, -d), 0.0, 1.0);
    let fresnel = s.gloss + (0.5 - s.gloss) * grazing * grazing * grazing * grazing * grazing;
    let up = reflect(d, s.normal);
    let sky = select(ambient_light(up), min(environment_light(up), vec3f(4.0)), s.gloss > 0.05);
    return Seen(tint * mix(s.colour * light, sky, fresnel), first);
}

fn ray(px: vec2f) -> vec3f {
    let p = plane_from_px(u.geometry, px);
    return normalize(u.forward.xyz + p.x * u.right.xyz + p.y * u.up.xyz);
}

// Into the display's range: linear up to 0.6, then ever more slowly towards 1.
fn displayable(light: vec3f) -> vec3f {
    let high = 0.6 + 0.4 * (1.0 - exp(-(light - 0.6) / 0.4));
    return select(high, light, light <= vec3f(0.6));
}

@fragment
fn orbit(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let px = u.origin_px + position.xy * u.step_px;
    let cone = u.geometry.pitch_per_distance.x * u.step_px.x;
    let eye = u.eye.xyz;

    // The centre; where something else lies to one side of it, a point on either side as well.
    let aside = vec2f(0.36, 0.24) * u.step_px;
    let low = hit_scene(eye, ray(px - aside)).id;
    let high = hit_scene(eye, ray(px + aside)).id;
    var sum = vec3f(0.0);
    var samples = 1;
    for (var i = 0; i < samples; i++) {
        let seen = light_along(eye, ray(px + select(select(0.0, 1.0, i == 1), -1.0, i == 2) * aside), cone);
        sum += displayable(seen.light);
        samples = select(samples, 3, i == 0 && (seen.id != low || seen.id != high));
    }
    return half_colour(sum / f32(samples));
}
