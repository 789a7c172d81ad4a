// Procedural patterns: how much of the second colour there is at a place, 0..1. Numbers as in `PatternKind`.

struct PatternPoint {
    // In the mesh's space and in the world's, metres.
    mesh: vec3f,
    world: vec3f,
    uv: vec2f,
    // The surface's normal in the world's space.
    normal: vec3f,
}

// The three-dimensional PCG hash of Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 9(3), 2020).
fn hash3(key: vec3u) -> vec3u {
    var v = key * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

fn random3(cell: vec3f) -> f32 {
    return f32(hash3(bitcast<vec3u>(vec3i(cell))).x >> 8u) / 16777216.0;
}

// Smooth noise in 0..1 with features of one unit.
fn noise3(p: vec3f) -> f32 {
    let i = floor(p);
    let f = p - i;
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let x = vec3f(1.0, 0.0, 0.0);
    let y = vec3f(0.0, 1.0, 0.0);
    let z = vec3f(0.0, 0.0, 1.0);
    let low = mix(mix(random3(i), random3(i + x), s.x), mix(random3(i + y), random3(i + x + y), s.x), s.y);
    let j = i + z;
    let high = mix(mix(random3(j), random3(j + x), s.x), mix(random3(j + y), random3(j + x + y), s.x), s.y);
    return mix(low, high, s.z);
}

// Noise of five octaves in 0..1; octaves finer than `width` (features per unit) fade out.
fn clouds(p: vec3f, width: f32) -> f32 {
    var sum = 0.0;
    var weight = 0.5;
    var q = p;
    var w = width;
    for (var octave = 0; octave < i32(frame.four) + 1; octave++) {
        let kept = 1.0 - smoothstep(0.5, 1.5, w);
        if kept > 0.0 {
            sum += weight * kept * (noise3(q) - 0.5);
        }
        // Turned between octaves, so that their grids do not line up.
        q = vec3f(1.6 * q.x + 1.2 * q.z, 2.0 * q.y, -1.2 * q.x + 1.6 * q.z) + 17.3;
        w *= 2.0;
        weight *= 0.5;
    }
    return 0.5 + sum;
}

// A line between cells of width 1, `half_width` wide to either side; 1 on the line.
fn joint(x: f32, half_width: f32) -> f32 {
    let d = 0.5 - abs(fract(x) - 0.5);
    return 1.0 - smoothstep(half_width, 1.6 * half_width, d);
}

// `width`: size of the pixel in repeats of the pattern.
fn pattern_at(kind: u32, at: PatternPoint, scale: f32, width: f32) -> f32 {
    let p = at.mesh * scale;
    let uv = at.uv * scale;
    switch kind {
        case 1u: {
            let cell = floor(p + 1e-4);
            let odd = cell.x + cell.y + cell.z;
            return odd - 2.0 * floor(0.5 * odd);
        }
        case 2u: {
            return smoothstep(0.35, 0.65, clouds(p, width));
        }
        case 3u: {
            let bent = p.x + p.y * 0.6 + 4.0 * (clouds(p * 0.7, width) - 0.5);
            return pow(0.5 + 0.5 * sin(bent * 2.0 * PI), 6.0);
        }
        case 4u: {
            let bent = p + 0.35 * vec3f(noise3(p * vec3f(0.8, 0.2, 0.8)), 0.0, noise3(p.zyx * 0.8 + 9.0));
            let rings = fract(length(bent.xz) * 2.0);
            let grain = noise3(p * vec3f(18.0, 1.0, 18.0));
            return clamp(0.75 * smoothstep(0.1, 0.9, rings) * (1.0 - smoothstep(0.9, 1.0, rings)) + 0.35 * grain, 0.0, 1.0);
        }
        case 5u: {
            // Bricks twice as long as high, each course shifted by half a brick.
            let row = floor(uv.y * 2.0);
            let shifted = vec2f(uv.x + 0.5 * (row - 2.0 * floor(0.5 * row)), uv.y * 2.0);
            let mortar = max(joint(shifted.x, 0.02), joint(shifted.y, 0.04));
            let brick = random3(vec3f(floor(shifted), 3.0));
            return max(mortar, 0.35 * brick * brick);
        }
        case 6u: {
            let gap = max(joint(uv.x, 0.012), joint(uv.y, 0.012));
            let tile = random3(vec3f(floor(uv), 5.0));
            return max(gap, 0.3 * tile);
        }
        case 7u: {
            let warp = 0.5 + 0.5 * sin(uv.x * 2.0 * PI) * sin(uv.y * 2.0 * PI);
            let fade = 1.0 - smoothstep(0.4, 1.2, width);
            return mix(0.5, warp, fade);
        }
        case 8u: {
            // How much rock: by slope and height.
            let rough = clouds(at.world * scale, width);
            let steep = 1.0 - at.normal.y;
            return clamp(smoothstep(0.12, 0.35, steep + 0.3 * (rough - 0.5)) + 0.5 * smoothstep(0.55, 0.7, rough), 0.0, 1.0);
        }
        case 9u: {
            let scratch = noise3(vec3f(p.x * 40.0, p.y * 1.5, p.z * 40.0));
            return clamp(0.6 * smoothstep(0.55, 0.7, clouds(p, width)) + 0.4 * scratch * scratch, 0.0, 1.0);
        }
        case 10u: {
            // One window in each unit of the map.
            let inside = abs(fract(uv) - 0.5);
            let pane = (1.0 - smoothstep(0.26, 0.29, inside.x)) * (1.0 - smoothstep(0.32, 0.35, inside.y));
            let bars = max(joint(uv.x + 0.5, 0.015), joint(uv.y * 2.0, 0.03));
            return pane * (1.0 - bars);
        }
        case 11u: {
            let d = abs(fract(uv.x) - 0.5);
            return smoothstep(0.24, 0.26, d);
        }
        case 12u: {
            let d = length(fract(uv) - 0.5);
            return 1.0 - smoothstep(0.28, 0.31, d);
        }
        default: {
            return 0.0;
        }
    }
}
