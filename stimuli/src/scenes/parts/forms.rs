//! Forms that the scenes are put together from, beyond the basic shapes: surfaces over a lattice that is evaluated once,
//! rings, bent pipes, and flat outlines made thick.

use crate::world::shapes::{lathe, surface, tube};
use crate::world::{MeshLevel, Vertex};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// A surface over a lattice of `columns` × `rows` cells with `place_of` evaluated once a corner, for places that are
/// costly to find: normals come from the neighbours in the lattice, beyond the borders too. As for
/// [`surface`], columns run to the right and rows upwards when seen from outside; `uv_of` gives the map coordinates.
pub(crate) fn lattice(
    columns: u32,
    rows: u32,
    place_of: impl Fn(i32, i32) -> Vec3,
    uv_of: impl Fn(i32, i32) -> Vec2,
) -> MeshLevel {
    let (width, height) = (columns as i32 + 1, rows as i32 + 1);
    let stride = width + 2;
    let places: Vec<Vec3> =
        (-1..=height).flat_map(|j| (-1..=width).map(move |i| (i, j))).map(|(i, j)| place_of(i, j)).collect();
    let at = |i: i32, j: i32| places[((j + 1) * stride + i + 1) as usize];
    let mut level = MeshLevel::default();
    for j in 0..height {
        for i in 0..width {
            let (along, up) = (at(i + 1, j) - at(i - 1, j), at(i, j + 1) - at(i, j - 1));
            let normal = along.cross(up).normalize_or(Vec3::Y);
            let tangent = (along - normal * along.dot(normal)).normalize_or(normal.any_orthonormal_vector());
            level
                .vertices
                .push(Vertex { tangent: tangent.extend(1.0).into(), ..Vertex::new(at(i, j), normal, uv_of(i, j)) });
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

/// A ring about the y axis: `radius_m` to the middle of a round rod of `rod_m`.
pub(crate) fn torus(radius_m: f32, rod_m: f32, around: u32, across: u32) -> MeshLevel {
    surface(around, across, |uv| {
        let ((sin, cos), (up, out)) = ((uv.x * TAU).sin_cos(), (uv.y * TAU).sin_cos());
        let radius = radius_m - rod_m * out;
        Vec3::new(radius * sin, -rod_m * up, radius * cos)
    })
}

/// `corners` with every bend rounded by a circular arc of at most `radius_m`, as many points a bend as `steps` + 1.
pub(crate) fn bent(corners: &[Vec3], radius_m: f32, steps: u32) -> Vec<Vec3> {
    let mut path: Vec<Vec3> = corners.first().copied().into_iter().collect();
    for triple in corners.windows(3) {
        let [before, at, after] = [triple[0], triple[1], triple[2]];
        let (come, go) = ((at - before).normalize_or_zero(), (after - at).normalize_or_zero());
        let half_angle = 0.5 * come.angle_between(go);
        let most = 0.49 * at.distance(before).min(at.distance(after));
        let cut = (radius_m * half_angle.tan()).min(most);
        if half_angle < 1e-3 || cut < 1e-4 {
            path.push(at);
            continue;
        }
        // A rational quadratic curve with this weight is an arc of a circle.
        let weight = half_angle.cos();
        let (first, last) = (at - cut * come, at + cut * go);
        for step in 0..=steps {
            let t = step as f32 / steps as f32;
            let [a, b, c] = [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t) * weight, t * t];
            path.push((a * first + b * at + c * last) / (a + b + c));
        }
    }
    path.extend(corners.get(1..).and_then(<[Vec3]>::last));
    path
}

/// A pipe along `corners` with round elbows, open at its ends.
pub(crate) fn pipe(corners: &[Vec3], radius_m: f32, elbow_m: f32, sides: u32) -> MeshLevel {
    tube(&bent(corners, elbow_m, 8), radius_m, sides)
}

/// A rope or cable that hangs from `a` to `b`, `sag_m` below the straight line in its middle (a parabola).
pub(crate) fn hanging(a: Vec3, b: Vec3, sag_m: f32, radius_m: f32, sides: u32) -> MeshLevel {
    let steps = 24;
    let path: Vec<Vec3> = (0..=steps)
        .map(|i| i as f32 / steps as f32)
        .map(|t| a.lerp(b, t) - Vec3::Y * (4.0 * sag_m * t * (1.0 - t)))
        .collect();
    tube(&path, radius_m, sides)
}

/// A flat body between two closed outlines of as many points, counter-clockwise in the plane of x and y, from
/// z = −`half_m` to `half_m`, with hard edges. The inner outline may be a point.
pub(crate) fn plate(outer: &[Vec2], inner: &[Vec2], half_m: f32) -> MeshLevel {
    let mut level = MeshLevel::default();
    let count = outer.len().min(inner.len());
    for i in 0..count {
        let next = (i + 1) % count;
        let [a, b] = [outer[i], outer[next]];
        let [c, d] = [inner[i], inner[next]];
        let (front, back) = (|p: Vec2| p.extend(half_m), |p: Vec2| p.extend(-half_m));
        let long = a.distance(b);
        flat(&mut level, [c, a, b, d].map(front), [c, a, b, d]);
        flat(&mut level, [d, b, a, c].map(back), [d, b, a, c]);
        level.quad([back(a), back(b), front(b), front(a)], [Vec2::ZERO, Vec2::new(long, 2.0 * half_m)]);
        if c.distance(d) > 1e-6 {
            level.quad([back(d), back(c), front(c), front(d)], [Vec2::ZERO, Vec2::new(c.distance(d), 2.0 * half_m)]);
        }
    }
    level
}

/// A quadrilateral with map coordinates of its own, as two triangles, the empty ones left out.
fn flat(level: &mut MeshLevel, corners: [Vec3; 4], uvs: [Vec2; 4]) {
    let facing = |i: usize, j: usize, k: usize| (corners[j] - corners[i]).cross(corners[k] - corners[i]);
    let normal = (facing(0, 1, 2) + facing(0, 2, 3)).normalize_or(Vec3::Z);
    let first = level.vertices.len() as u32;
    level.vertices.extend(corners.iter().zip(uvs).map(|(&at, uv)| Vertex::new(at, normal, uv)));
    for [i, j, k] in [[0, 1, 2], [0, 2, 3]] {
        if facing(i, j, k).length() > 1e-9 {
            level.indices.extend([i, j, k].map(|index| first + index as u32));
        }
    }
}

/// The outline of a circle.
pub(crate) fn circle(radius_m: f32, points: u32) -> Vec<Vec2> {
    (0..points).map(|i| Vec2::from_angle(i as f32 / points as f32 * TAU) * radius_m).collect()
}

/// A flat round disc in the plane of x and z, facing up; the map's 0–1 covers it.
pub(crate) fn disc(radius_m: f32, sides: u32) -> MeshLevel {
    let mut level = MeshLevel::default();
    let corner = |at: Vec2| Vertex {
        tangent: Vec3::X.extend(1.0).into(),
        ..Vertex::new(radius_m * Vec3::new(at.x, 0.0, at.y), Vec3::Y, 0.5 + 0.5 * at)
    };
    level.vertices.push(corner(Vec2::ZERO));
    for i in 0..sides {
        level.vertices.push(corner(Vec2::from_angle(i as f32 / sides as f32 * TAU)));
        level.indices.extend([0, 1 + (i + 1) % sides, 1 + i]);
    }
    level
}

/// A capsule-like rod between two points, closed at its ends.
pub(crate) fn rod(a: Vec3, b: Vec3, radius_m: f32, sides: u32) -> MeshLevel {
    let length = a.distance(b);
    let level = lathe(&[[0.0, 0.0], [radius_m, 0.0], [radius_m, length], [0.0, length]], sides);
    level.transformed(crate::world::shapes::upright(a, b - a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::shapes::block;
    use std::f32::consts::PI;

    /// The volume that a closed body holds, by the divergence theorem: positive where every face looks outwards.
    fn volume(level: &MeshLevel) -> f32 {
        let place = |i: u32| Vec3::from(level.vertices[i as usize].position);
        level.indices.chunks_exact(3).map(|t| place(t[0]).dot(place(t[1]).cross(place(t[2]))) / 6.0).sum()
    }

    #[test]
    fn bodies_have_their_volumes() {
        let ring = plate(&circle(2.0, 64), &circle(1.0, 64), 0.25);
        let full = plate(&circle(1.0, 64), &[Vec2::ZERO; 64], 0.5);
        let cases = [
            ("block", volume(&block(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0))), 6.0),
            ("cylinder", volume(&lathe(&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]], 96)), 2.0 * PI),
            ("torus", volume(&torus(2.0, 0.5, 96, 48)), 2.0 * PI * PI * 2.0 * 0.25),
            ("ring plate", volume(&ring), PI * 3.0 * 0.5),
            ("full plate", volume(&full), PI),
            ("rod", volume(&rod(Vec3::X, Vec3::new(1.0, 3.0, 4.0), 0.2, 64)), PI * 0.04 * 5.0),
        ];
        for (name, found, expected) in cases {
            println!("{name}: {found:.4}, closed form {expected:.4}");
            assert!((found / expected - 1.0).abs() < 0.01, "{name}");
        }
    }

    /// Every point of a rounded right angle lies on a circle of the radius.
    #[test]
    fn bends_are_arcs() {
        let path = bent(&[Vec3::ZERO, Vec3::X * 3.0, Vec3::new(3.0, 3.0, 0.0)], 1.0, 8);
        let middle = Vec3::new(2.0, 1.0, 0.0);
        for at in &path[1..path.len() - 1] {
            assert!((at.distance(middle) - 1.0).abs() < 1e-5, "{at}");
        }
        assert_eq!((path[0], path[path.len() - 1]), (Vec3::ZERO, Vec3::new(3.0, 3.0, 0.0)));
    }

    #[test]
    fn a_lattice_agrees_with_a_surface() {
        let place = |x: f32, y: f32| Vec3::new(x, y, 0.3 * (2.0 * x).sin() * y);
        let fine = surface(32, 32, |uv| place(uv.x, uv.y));
        let level = lattice(32, 32, |i, j| place(i as f32 / 32.0, j as f32 / 32.0), |_, _| Vec2::ZERO);
        for (a, b) in fine.vertices.iter().zip(&level.vertices) {
            assert!(Vec3::from(a.position).distance(b.position.into()) < 1e-5);
            assert!(Vec3::from(a.normal).dot(b.normal.into()) > 0.999);
        }
        assert_eq!(fine.indices, level.indices);
    }
}
