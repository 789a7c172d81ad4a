//! Basic shapes as meshes: boxes, surfaces over a grid, surfaces of revolution, tubes.

use super::mesh::{Mesh, MeshLevel, Vertex};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use std::f32::consts::{PI, TAU};

/// An axis-aligned box from `low` to `high`; the maps have one repeat per metre.
pub(crate) fn block(low: Vec3, high: Vec3) -> MeshLevel {
    let mut level = MeshLevel::default();
    let at = |x: f32, y: f32, z: f32| low + Vec3::new(x, y, z) * (high - low);
    let size = high - low;
    let faces = [
        ([at(0., 0., 1.), at(1., 0., 1.), at(1., 1., 1.), at(0., 1., 1.)], [size.x, size.y]),
        ([at(1., 0., 0.), at(0., 0., 0.), at(0., 1., 0.), at(1., 1., 0.)], [size.x, size.y]),
        ([at(1., 0., 1.), at(1., 0., 0.), at(1., 1., 0.), at(1., 1., 1.)], [size.z, size.y]),
        ([at(0., 0., 0.), at(0., 0., 1.), at(0., 1., 1.), at(0., 1., 0.)], [size.z, size.y]),
        ([at(0., 1., 1.), at(1., 1., 1.), at(1., 1., 0.), at(0., 1., 0.)], [size.x, size.z]),
        ([at(0., 0., 0.), at(1., 0., 0.), at(1., 0., 1.), at(0., 0., 1.)], [size.x, size.z]),
    ];
    for (corners, [across, along]) in faces {
        // Maps are upright: their y points down.
        level.quad(corners, [Vec2::new(0.0, along), Vec2::new(across, 0.0)]);
    }
    level
}

/// A surface over a grid of `columns` × `rows` cells: `place_of` gives the place for (u, v) in 0–1, u to the right and v
/// upwards when seen from outside. Normals come from neighbouring places, so that any smooth surface will do.
pub(crate) fn surface(columns: u32, rows: u32, place_of: impl Fn(Vec2) -> Vec3) -> MeshLevel {
    let (columns, rows) = (columns.max(1), rows.max(1));
    const H: f32 = 1e-3;
    let mut level = MeshLevel::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let uv = Vec2::new(i as f32 / columns as f32, j as f32 / rows as f32);
            // Differences to the inside at the borders and poles.
            let (low, high) = ((uv - H).max(Vec2::ZERO), (uv + H).min(Vec2::ONE));
            let along_u = place_of(Vec2::new(high.x, uv.y)) - place_of(Vec2::new(low.x, uv.y));
            let along_v = place_of(Vec2::new(uv.x, high.y)) - place_of(Vec2::new(uv.x, low.y));
            let mut normal = along_u.cross(along_v).normalize_or_zero();
            if along_u.length_squared().min(along_v.length_squared()) < 1e-9 {
                // A pole, but for rounding: the normal a little beside it.
                let beside = uv.lerp(Vec2::splat(0.5), 4.0 * H);
                let du = place_of(beside + Vec2::X * H) - place_of(beside - Vec2::X * H);
                let dv = place_of(beside + Vec2::Y * H) - place_of(beside - Vec2::Y * H);
                normal = du.cross(dv).normalize_or(Vec3::Y);
            }
            let tangent = along_u.normalize_or(normal.any_orthonormal_vector()).extend(1.0).into();
            let uv_map = Vec2::new(uv.x, 1.0 - uv.y);
            level.vertices.push(Vertex { tangent, ..Vertex::new(place_of(uv), normal, uv_map) });
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let corner = j * (columns + 1) + i;
            let above = corner + columns + 1;
            level.indices.extend([corner, corner + 1, above + 1, corner, above + 1, above]);
        }
    }
    level
}

/// A closed surface at many levels of detail, from 2·`most`² triangles down to 2·`fewest`²: each level has at most about
/// a tenth fewer triangles than the one before, or one row less.
pub(crate) fn graded_surface(fewest: u32, most: u32, place_of: impl Fn(Vec2) -> Vec3) -> Mesh {
    let mut levels = Vec::new();
    let mut cells = most.max(1);
    loop {
        levels.push(surface(cells, cells, &place_of));
        if cells <= fewest.max(1) {
            return Mesh { levels };
        }
        cells = (cells - 1).min((f64::from(cells) * 0.95).round() as u32).max(fewest.max(1));
    }
}

/// A sphere about the origin.
pub(crate) fn sphere(radius_m: f32, cells: u32) -> MeshLevel {
    surface(2 * cells, cells, |uv| {
        let (theta, phi) = ((1.0 - uv.y) * PI, uv.x * TAU);
        radius_m * Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos())
    })
}

/// A surface of revolution about the y axis through `profile`, pairs of radius and height from below; straight between
/// them, with hard edges where the profile bends by more than 30°.
pub(crate) fn lathe(profile: &[[f32; 2]], sides: u32) -> MeshLevel {
    let mut level = MeshLevel::default();
    let sides = sides.max(3);
    let normals: Vec<Vec2> = profile
        .windows(2)
        .map(|pair| {
            let along = Vec2::from(pair[1]) - Vec2::from(pair[0]);
            Vec2::new(along.y, -along.x).normalize_or(Vec2::X)
        })
        .collect();
    let smooth = |a: Vec2, b: Vec2| if a.dot(b) > 0.866 { (a + b).normalize_or(a) } else { a };
    let mut length = 0.0;
    for (i, pair) in profile.windows(2).enumerate() {
        let own = normals[i];
        let at_low = if i > 0 { smooth(own, normals[i - 1]) } else { own };
        let at_high = normals.get(i + 1).map_or(own, |&next| smooth(own, next));
        let step = Vec2::from(pair[0]).distance(Vec2::from(pair[1]));
        let first = level.vertices.len() as u32;
        for k in 0..=sides {
            let (sin, cos) = (k as f32 / sides as f32 * TAU).sin_cos();
            for ([radius, height], normal, along) in [(pair[0], at_low, length), (pair[1], at_high, length + step)] {
                let at = Vec3::new(radius * sin, height, radius * cos);
                let normal = Vec3::new(normal.x * sin, normal.y, normal.x * cos);
                let around = k as f32 / sides as f32 * TAU * pair[0][0].max(pair[1][0]);
                let tangent = Vec3::new(cos, 0.0, -sin).extend(1.0).into();
                level.vertices.push(Vertex { tangent, ..Vertex::new(at, normal, Vec2::new(around, -along)) });
            }
        }
        for k in 0..sides {
            let a = first + 2 * k;
            level.indices.extend([a, a + 2, a + 3, a, a + 3, a + 1]);
        }
        length += step;
    }
    level
}

/// A tube of round cross-section along `path`, open at its ends.
pub(crate) fn tube(path: &[Vec3], radius_m: f32, sides: u32) -> MeshLevel {
    let mut level = MeshLevel::default();
    let sides = sides.max(3);
    let mut length = 0.0;
    let mut across = Vec3::ZERO;
    for (i, &at) in path.iter().enumerate() {
        let before = path[i.saturating_sub(1)];
        let after = path[(i + 1).min(path.len() - 1)];
        let along = (after - before).normalize_or(Vec3::Y);
        // Carried along without twisting.
        across = (across - along * across.dot(along)).normalize_or(along.any_orthonormal_vector());
        let other = along.cross(across);
        length += at.distance(before);
        for k in 0..=sides {
            let (sin, cos) = (k as f32 / sides as f32 * TAU).sin_cos();
            let normal = across * cos + other * sin;
            let tangent = (other * cos - across * sin).extend(1.0).into();
            let uv = Vec2::new(k as f32 / sides as f32 * TAU * radius_m, length);
            level.vertices.push(Vertex { tangent, ..Vertex::new(at + radius_m * normal, normal, uv) });
        }
    }
    for i in 0..path.len().saturating_sub(1) as u32 {
        for k in 0..sides {
            let a = i * (sides + 1) + k;
            let b = a + sides + 1;
            level.indices.extend([a, a + 1, b + 1, a, b + 1, b]);
        }
    }
    level
}

/// A place with y turned to `up`.
pub(crate) fn upright(at: Vec3, up: Vec3) -> Affine3A {
    let up = Vec3A::from(up).normalize_or(Vec3A::Y);
    let right = if up.y.abs() > 0.999 { Vec3A::X } else { Vec3A::Y.cross(up).normalize() };
    Affine3A::from_mat3_translation(Mat3A::from_cols(right, up, right.cross(up)).into(), at)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every triangle of a closed shape faces away from its middle, and its normals agree with its winding.
    #[test]
    fn shapes_face_outwards() {
        let path: Vec<Vec3> = (0..20).map(|i| Vec3::new(0.0, 0.1 * i as f32, 0.0)).collect();
        let shapes = [
            ("block", block(-Vec3::ONE, Vec3::ONE)),
            ("sphere", sphere(1.0, 12)),
            (
                "cylinder",
                lathe(&[[0.0, 0.0], [0.7, 0.0], [0.7, 2.0], [0.0, 2.0]], 24)
                    .transformed(Affine3A::from_translation(Vec3::NEG_Y)),
            ),
            ("tube", tube(&path, 0.3, 12).transformed(Affine3A::from_translation(Vec3::NEG_Y))),
        ];
        for (name, shape) in shapes {
            for triangle in shape.indices.chunks_exact(3) {
                let corner = |i: usize| shape.vertices[triangle[i] as usize];
                let place = |i: usize| Vec3::from(corner(i).position);
                let facing = (place(1) - place(0)).cross(place(2) - place(0));
                if facing.length() < 1e-7 {
                    continue;
                }
                let middle = (place(0) + place(1) + place(2)) / 3.0;
                assert!(facing.dot(middle) > 0.0, "{name}: a triangle faces inwards");
                for i in 0..3 {
                    let normal = Vec3::from(corner(i).normal);
                    assert!((normal.length() - 1.0).abs() < 1e-4, "{name}: {normal}");
                    assert!(facing.normalize().dot(normal) > 0.5, "{name}: a normal looks aside");
                }
            }
        }
    }

    #[test]
    fn a_sphere_has_its_volume() {
        let shape = sphere(1.0, 48);
        let place = |i: u32| Vec3::from(shape.vertices[i as usize].position);
        let volume: f32 =
            shape.indices.chunks_exact(3).map(|t| place(t[0]).dot(place(t[1]).cross(place(t[2]))) / 6.0).sum();
        println!("volume {volume:.4}, 4π/3 = {:.4}", 4.0 * PI / 3.0);
        assert!((volume / (4.0 * PI / 3.0) - 1.0).abs() < 0.01);
    }

    #[test]
    fn graded_surfaces_have_small_steps() {
        let mesh = graded_surface(8, 100, |uv| Vec3::new(uv.x, uv.y, 0.0));
        let counts: Vec<usize> = mesh.levels.iter().map(MeshLevel::triangles).collect();
        assert_eq!((counts[0], counts[counts.len() - 1]), (20_000, 128));
        assert!(counts.windows(2).all(|w| w[0] > w[1] && (w[1] as f64 / w[0] as f64) > 0.76), "{counts:?}");
    }
}
