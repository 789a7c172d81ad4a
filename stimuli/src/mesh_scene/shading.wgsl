// The one shading function: what a surface sends to the eye. Rasterised, deferred and traced pictures all call `shade`.
// Metal and roughness as in Burley 2012; Trowbridge–Reitz facets with Smith's shadowing (Walter et al. 2007).

struct Surface {
    at: vec3f,
    normal: vec3f,
    // Towards the eye.
    view: vec3f,
    albedo: vec3f,
    roughness: f32,
    metalness: f32,
    emission: vec3f,
    // Share of the sky that reaches it.
    open: f32,
}

// A place on a mesh, as rasterised or hit.
struct Place {
    material: u32,
    mesh: vec3f,
    world: vec3f,
    // World, unit length; towards the eye's side.
    normal: vec3f,
    tangent: vec4f,
    uv: vec2f,
    // What one pixel further right and down adds to them.
    mesh_dx: vec3f,
    mesh_dy: vec3f,
    world_dx: vec3f,
    world_dy: vec3f,
    uv_dx: vec2f,
    uv_dy: vec2f,
}

fn map_level(place: Place, size: vec2u) -> f32 {
    let dx = place.uv_dx * vec2f(size);
    let dy = place.uv_dy * vec2f(size);
    return 0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-12));
}

fn colour_of_map(map: i32, place: Place) -> vec4f {
    let level = map_level(place, textureDimensions(colour_maps));
    return textureSampleLevel(colour_maps, map_sampler, place.uv, map, level);
}

fn data_of_map(map: i32, place: Place) -> vec4f {
    let level = map_level(place, textureDimensions(data_maps));
    return textureSampleLevel(data_maps, map_sampler, place.uv, map, level);
}

// A pattern in a pixel, and how it changes to the right and down: averages over points spread in the pixel's footprint.
// The changes are wanted for relief only. One place calls `pattern_at`, because compilers copy it to each.
fn pattern_in_pixel(m: Material, place: Place, relief: bool) -> vec3f {
    let samples = max(frame.pattern_samples, 1u);
    let footprint = max(length(place.mesh_dx), length(place.mesh_dy));
    let width = footprint * m.pattern_scale / sqrt(f32(samples));
    var sums = vec3f(0.0);
    let count = samples * select(1u, 3u, relief);
    for (var i = 0u; i < count; i++) {
        // The additive recurrence of Roberts (2018), which fills the square evenly; one sample is the middle.
        let part = i / samples;
        var offset = fract(0.5 + vec2f(0.75487767, 0.56984029) * f32(i - part * samples)) - 0.5;
        offset += vec2f(f32(part == 1u), f32(part == 2u));
        let at = PatternPoint(
            place.mesh + offset.x * place.mesh_dx + offset.y * place.mesh_dy,
            place.world + offset.x * place.world_dx + offset.y * place.world_dy,
            place.uv + offset.x * place.uv_dx + offset.y * place.uv_dy,
            place.normal,
        );
        let share = pattern_at(pattern_kind(m), at, m.pattern_scale, width) / f32(samples);
        sums += select(vec3f(0.0), vec3f(share), vec3u(part) == vec3u(0u, 1u, 2u));
    }
    return sums;
}

// The normal tilted by a pattern's relief, from the heights one pixel further right and down (Mikkelsen, "Bump Mapping
// Unparametrized Surfaces on the GPU", 2010). The second colour lies deeper.
fn relief_normal(m: Material, place: Place, shares: vec3f) -> vec3f {
    let width = max(length(place.mesh_dx), length(place.mesh_dy)) * m.pattern_scale;
    let fade = 1.0 - smoothstep(0.1, 0.5, width);
    let slope = (shares.x - shares.yz) * fade * m.pattern_relief / m.pattern_scale;
    let across = cross(place.world_dy, place.normal);
    let along = cross(place.normal, place.world_dx);
    let area = dot(place.world_dx, across);
    let tilt = sign(area) * (slope.x * across + slope.y * along);
    // No steeper than 45 degrees: a step in the pattern is not a cliff.
    let steep = abs(area) / max(length(tilt), 1e-20);
    return normalize(abs(area) * place.normal - tilt * min(steep, 1.0));
}

// The surface with its maps.
fn with_maps(plain: Surface, m: Material, place: Place) -> Surface {
    var s = plain;
    if m.albedo_map >= 0 {
        s.albedo *= colour_of_map(m.albedo_map, place).rgb;
    }
    if m.emission_map >= 0 {
        s.emission *= colour_of_map(m.emission_map, place).rgb;
    }
    if m.roughness_map >= 0 {
        let values = data_of_map(m.roughness_map, place);
        s.roughness *= values.g;
        s.metalness *= values.b;
    }
    if m.normal_map >= 0 {
        let tilt = (data_of_map(m.normal_map, place).xyz * 2.0 - 1.0) * vec3f(m.normal_scale, m.normal_scale, 1.0);
        let tangent = normalize(place.tangent.xyz);
        let bitangent = cross(place.normal, tangent) * sign(place.tangent.w);
        s.normal = normalize(tilt.x * tangent + tilt.y * bitangent + max(tilt.z, 1e-3) * place.normal);
    }
    return s;
}

// What the material is at a place.
fn surface_at(place: Place) -> Surface {
    let m = materials[place.material];
    var s: Surface;
    s.at = place.world;
    s.normal = place.normal;
    s.view = normalize(frame.eye.xyz - place.world);
    s.albedo = m.albedo;
    s.roughness = m.roughness;
    s.metalness = m.metalness;
    s.emission = m.emission;
    // Beyond a triangle's edge it may come out above 1.
    s.open = min(abs(place.tangent.w), 1.0);
    if HAS_MAPS {
        s = with_maps(s, m, place);
    }
    if pattern_kind(m) != 0u {
        let relief = HAS_RELIEF && m.pattern_relief != 0.0;
        let shares = pattern_in_pixel(m, place, relief);
        s.albedo = mix(s.albedo, m.pattern_colour, m.pattern_strength * shares.x);
        s.roughness = clamp(s.roughness + m.pattern_roughness * shares.x, 0.0, 1.0);
        if relief {
            s.normal = relief_normal(m, place, shares);
        }
    }
    s.roughness = clamp(s.roughness, 0.03, 1.0);
    return s;
}

fn sky_uv(d: vec3f) -> vec2f {
    return vec2f(atan2(d.z, d.x) / (2.0 * PI) + 0.5, acos(clamp(d.y, -1.0, 1.0)) / PI);
}

fn sky_in_direction(d: vec3f, level: f32) -> vec3f {
    return textureSampleLevel(sky_map, sky_sampler, sky_uv(d), level).rgb;
}

fn ambient_light(n: vec3f) -> vec3f {
    let a = frame.ambient;
    return max(
        a[0].rgb + a[1].rgb * n.y + a[2].rgb * n.z + a[3].rgb * n.x + a[4].rgb * n.x * n.y + a[5].rgb * n.y * n.z
            + a[6].rgb * (3.0 * n.z * n.z - 1.0) + a[7].rgb * n.x * n.z + a[8].rgb * (n.x * n.x - n.y * n.y),
        vec3f(0.0),
    );
}

// Share of the sun that arrives, 0..1: four interpolated comparisons, which smooth over three texels.
fn sunlit(at: vec3f, normal: vec3f) -> f32 {
    let facing = dot(normal, frame.sun.xyz);
    if !HAS_SHADOW {
        return 1.0;
    }
    if facing <= 0.0 {
        return 0.0;
    }
    // Off the surface by more than a texel, the more the flatter the light falls.
    let lifted = at + normal * frame.shadow_texel_m * (1.0 + 2.0 * sqrt(1.0 - facing * facing));
    let place = frame.shadow * vec4f(lifted, 1.0);
    if any(place.xyz < vec3f(0.0)) || any(place.xyz > vec3f(1.0)) {
        return 1.0;
    }
    let texel = 1.0 / f32(textureDimensions(shadow_map).x);
    var sum = 0.0;
    for (var i = 0u; i < frame.four; i++) {
        let corner = place.xy + (vec2f(f32(i & 1u), f32(i >> 1u)) - 0.5) * texel;
        sum += textureSampleCompareLevel(shadow_map, shadow_sampler, corner, place.z);
    }
    return 0.25 * sum;
}

// Reflectance of facets times the cosine, for light from `l`, over pi: white matt surfaces give the cosine.
fn reflected(s: Surface, l: vec3f) -> vec3f {
    let n_l = dot(s.normal, l);
    if n_l <= 0.0 {
        return vec3f(0.0);
    }
    let h = normalize(l + s.view);
    let n_v = max(dot(s.normal, s.view), 1e-3);
    let n_h = max(dot(s.normal, h), 0.0);
    let alpha = s.roughness * s.roughness;
    let a2 = alpha * alpha;
    let lobe = n_h * n_h * (a2 - 1.0) + 1.0;
    let facets = a2 / max(lobe * lobe, 1e-9);
    let visible = 0.5 / (n_l * sqrt(n_v * n_v * (1.0 - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0 - a2) + a2));
    let f0 = mix(vec3f(0.04), s.albedo, s.metalness);
    let fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(s.view, h), 0.0), 5.0);
    let matt = s.albedo * (1.0 - s.metalness) * (1.0 - fresnel);
    return (matt + fresnel * facets * visible) * n_l;
}

// The mirror image of the sky in rough facets: share of f0 and what is added to it (fit of Karis, "Physically Based Shading
// on Mobile", 2014).
fn sky_reflectance(roughness: f32, n_v: f32) -> vec2f {
    let c = vec4f(-1.0, -0.0275, -0.572, 0.022) * roughness + vec4f(1.0, 0.0425, 1.04, -0.04);
    let a = min(c.x * c.x, exp2(-9.28 * n_v)) * c.x + c.y;
    return vec2f(-1.04, 1.04) * a + c.zw;
}

fn from_area(s: Surface, light: Light) -> vec3f {
    let right = light.half_right.xyz;
    let up = light.half_up.xyz;
    let facing = cross(right, up);
    let area = 4.0 * length(facing);
    let outwards = normalize(facing);
    // Matt: four points of the rectangle.
    var sum = vec3f(0.0);
    var matt = s;
    matt.roughness = max(s.roughness, 0.5);
    for (var i = 0u; i < frame.four; i++) {
        let corner = vec2f(f32(i & 1u), f32(i >> 1u)) - 0.5;
        let to = light.at.xyz + corner.x * right + corner.y * up - s.at;
        let d2 = max(dot(to, to), 1e-4);
        let l = to * inverseSqrt(d2);
        sum += reflected(matt, l) * max(-dot(outwards, l), 0.0) * area / (4.0 * PI * d2);
    }
    if s.roughness < 0.5 {
        // Smooth: the point of the rectangle nearest to the mirrored ray (Karis 2013).
        let r = reflect(-s.view, s.normal);
        let away = dot(outwards, r);
        let t = dot(light.at.xyz - s.at, outwards) / min(away, -1e-3);
        let hit = s.at + r * max(t, 0.0) - light.at.xyz;
        let inside = vec2f(dot(hit, right) / dot(right, right), dot(hit, up) / dot(up, up));
        let nearest = light.at.xyz + right * clamp(inside.x, -1.0, 1.0) + up * clamp(inside.y, -1.0, 1.0);
        let l = normalize(nearest - s.at);
        let d2 = max(dot(nearest - s.at, nearest - s.at), 1e-4);
        let alpha = s.roughness * s.roughness;
        // A wider lobe, so that the energy stays.
        let spread = alpha / clamp(alpha + 0.25 * sqrt(area) / sqrt(d2), alpha, 1.0);
        var mirror = s;
        mirror.albedo = mix(vec3f(0.04), s.albedo, s.metalness);
        mirror.metalness = 1.0;
        let lit = max(-dot(outwards, l), 0.0) * area / (PI * d2);
        sum += (1.0 - smoothstep(0.3, 0.5, s.roughness)) * reflected(mirror, l) * spread * spread * min(lit, 4.0);
    }
    return sum * light.colour.rgb;
}

fn from_point(s: Surface, light: Light) -> vec3f {
    let to = light.at.xyz - s.at;
    let d2 = max(dot(to, to), 1e-4);
    let share = d2 / (light.reach_m * light.reach_m);
    let fade = max(1.0 - share * share, 0.0);
    return light.colour.rgb * fade * fade / d2 * reflected(s, to * inverseSqrt(d2));
}

fn shade(s: Surface) -> vec3f {
    var colour = s.emission;
    colour += sunlit(s.at, s.normal) * frame.sun_colour.rgb * reflected(s, frame.sun.xyz);
    // Lights are sorted by kind.
    for (var i = 0u; i < frame.light_counts.x; i++) {
        colour += lights[i].colour.rgb * reflected(s, lights[i].at.xyz);
    }
    if HAS_POINT_LIGHTS {
        let end = frame.light_counts.x + frame.light_counts.y;
        for (var i = frame.light_counts.x; i < end; i++) {
            colour += from_point(s, lights[i]);
        }
    }
    if HAS_AREA_LIGHTS {
        let first = frame.light_counts.x + frame.light_counts.y;
        for (var i = first; i < first + frame.light_counts.z; i++) {
            colour += from_area(s, lights[i]);
        }
    }
    // The sky, matt and mirrored.
    let n_v = max(dot(s.normal, s.view), 1e-3);
    let f0 = mix(vec3f(0.04), s.albedo, s.metalness);
    let mirrored = f0 * sky_reflectance(s.roughness, n_v).x + sky_reflectance(s.roughness, n_v).y;
    let level = f32(frame.sky_levels - 1u) * clamp(1.15 * sqrt(s.roughness) - 0.1, 0.0, 0.92);
    colour += s.open * ambient_light(s.normal) * s.albedo * (1.0 - s.metalness) * (1.0 - mirrored);
    colour += s.open * sky_in_direction(reflect(-s.view, s.normal), level) * mirrored;
    return colour;
}
