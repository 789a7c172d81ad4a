//! The parametric objects above the terrain: ten closed surfaces of (u, v), each finely and coarsely divided.

use crate::world::Mesh;
use crate::world::shapes::graded_surface;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use std::sync::OnceLock;

/// Most cells on a side: 2 · 100² = 20,000 triangles (Guenter et al. 2012, §6).
pub(super) const MOST: u32 = 100;
/// Fewest cells on a side: 200 triangles.
pub(super) const FEWEST: u32 = 10;
/// No shape reaches farther from its middle, metres.
#[cfg(test)]
pub(super) const REACH_M: f32 = 1.7;

/// A place for (u, v) in 0–1, u to the right and v upwards when seen from outside.
type Surface = fn(Vec2) -> Vec3;

/// All shapes by name.
pub(super) const SHAPES: [(&str, Surface); 10] = [
    ("cube", rounded_cube),
    ("octahedron", octahedron),
    ("torus", |uv| ring(uv, 1.05, |_, _| 0.46)),
    ("cable", |uv| ring(uv, 1.08, |around, across| 0.40 + 0.07 * (6.0 * across + 9.0 * around).cos())),
    ("knot", knot),
    ("shell", shell),
    ("urchin", urchin),
    ("drop", drop),
    ("screw", screw),
    ("beehive", beehive),
];

/// The meshes of [`SHAPES`], each at all its levels; made once in a process.
pub(super) fn meshes() -> Vec<Mesh> {
    static MESHES: OnceLock<Vec<Mesh>> = OnceLock::new();
    let made = MESHES.get_or_init(|| {
        let mut meshes = vec![Mesh::default(); SHAPES.len()];
        std::thread::scope(|scope| {
            for (mesh, (_, place_of)) in meshes.iter_mut().zip(SHAPES) {
                scope.spawn(move || *mesh = graded_surface(FEWEST, MOST, place_of));
            }
        });
        meshes
    });
    made.clone()
}

/// A direction by longitude and height, so that u runs to the right and v upwards.
fn direction(uv: Vec2) -> Vec3 {
    let (theta, phi) = ((1.0 - uv.y) * PI, uv.x * TAU);
    Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos())
}

/// A superquadric, |x|ⁿ + |y|ⁿ + |z|ⁿ = 1, along its rays.
fn superquadric(uv: Vec2, power: f32) -> Vec3 {
    let d = direction(uv);
    let sum: f32 = d.abs().to_array().map(|x| x.powf(power)).iter().sum();
    d * sum.powf(-1.0 / power)
}

fn rounded_cube(uv: Vec2) -> Vec3 {
    1.08 * superquadric(uv, 7.0)
}

fn octahedron(uv: Vec2) -> Vec3 {
    1.6 * superquadric(uv, 1.25)
}

/// A ring about y whose rod has a radius by the angles around the ring and across the rod.
fn ring(uv: Vec2, radius_m: f32, rod_m: impl Fn(f32, f32) -> f32) -> Vec3 {
    let (around, across) = (uv.x * TAU, uv.y * TAU);
    let rod = rod_m(around, across);
    let radius = radius_m - rod * across.cos();
    // Upright, so that one looks through it.
    Vec3::new(radius * around.sin(), radius * around.cos(), rod * across.sin())
}

/// A tube around a trefoil.
fn knot(uv: Vec2) -> Vec3 {
    let middle = |t: f32| {
        let radius = 2.0 + (3.0 * t).cos();
        0.40 * Vec3::new(radius * (2.0 * t).cos(), radius * (2.0 * t).sin(), 1.2 * (3.0 * t).sin())
    };
    let t = uv.x * TAU;
    let along = (middle(t + 0.01) - middle(t - 0.01)).normalize_or(Vec3::X);
    // The frame that looks away from the axis of the knot never twists all the way round.
    let out = Vec3::new((2.0 * t).cos(), (2.0 * t).sin(), 0.0);
    let side = (out - along * out.dot(along)).normalize_or(Vec3::Z);
    let (sin, cos) = (-uv.y * TAU).sin_cos();
    middle(t) + 0.26 * (side * cos + along.cross(side) * sin)
}

/// A snail's shell: a tube along a spiral that grows by a constant factor a turn.
fn shell(uv: Vec2) -> Vec3 {
    const TURNS: f32 = 3.4;
    let turn = TURNS * TAU * uv.x;
    let size = (0.62 * (uv.x - 1.0) * TURNS).exp();
    // Closed at its mouth by a rounded end.
    let close = (1.0 - uv.x.powi(24)).max(0.0).sqrt();
    let ribs = 1.0 + 0.05 * (9.0 * turn).cos();
    let (sin, cos) = (-uv.y * TAU).sin_cos();
    let radius = size * (0.80 + 0.62 * close * ribs * cos);
    let height = 1.15 - 2.1 * size + size * 0.62 * close * ribs * sin;
    Vec3::new(radius * turn.cos(), height + 0.25, radius * turn.sin())
}

/// A ball with spikes in directions that are even on the sphere (a golden spiral).
fn urchin(uv: Vec2) -> Vec3 {
    const COUNT: usize = 34;
    static SPIKES: OnceLock<[Vec3; COUNT]> = OnceLock::new();
    let spikes = SPIKES.get_or_init(|| {
        std::array::from_fn(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / COUNT as f32;
            let (sin, cos) = (i as f32 * PI * (3.0 - 5.0_f32.sqrt())).sin_cos();
            let flat = (1.0 - y * y).sqrt();
            Vec3::new(flat * cos, y, flat * sin)
        })
    });
    let d = direction(uv);
    let nearest = spikes.iter().map(|spike| d.dot(*spike)).fold(-1.0, f32::max);
    d * (0.86 + 0.80 * (-38.0 * (1.0 - nearest)).exp())
}

fn drop(uv: Vec2) -> Vec3 {
    let (theta, phi) = ((1.0 - uv.y) * PI, uv.x * TAU);
    let radius = 1.45 * theta.sin() * (0.5 * theta).sin().max(0.0).powf(1.6);
    Vec3::new(radius * phi.sin(), 1.45 * theta.cos() + 0.15, radius * phi.cos())
}

/// A ball with five ridges that wind around it.
fn screw(uv: Vec2) -> Vec3 {
    let (theta, phi) = ((1.0 - uv.y) * PI, uv.x * TAU);
    let swing = theta.sin().max(0.0);
    let ridge = 1.0 + 0.24 * swing * (5.0 * (phi - 1.3 * theta.cos())).cos();
    let radius = 1.12 * swing.powf(0.8) * ridge;
    Vec3::new(radius * phi.sin(), 1.45 * theta.cos(), radius * phi.cos())
}

/// A ball in rings.
fn beehive(uv: Vec2) -> Vec3 {
    let theta = (1.0 - uv.y) * PI;
    direction(uv) * (1.22 + 0.16 * (12.0 * theta).cos() * theta.sin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::MeshLevel;

    fn volume(level: &MeshLevel) -> f32 {
        let place = |i: u32| Vec3::from(level.vertices[i as usize].position);
        level.indices.chunks_exact(3).map(|t| place(t[0]).dot(place(t[1]).cross(place(t[2]))) / 6.0).sum()
    }

    /// A closed surface that faces outwards holds a positive volume, which hardly depends on how finely it is divided, and
    /// the same from wherever it is measured.
    #[test]
    fn shapes_are_closed_and_face_outwards() {
        for ((name, _), mesh) in SHAPES.iter().zip(meshes()) {
            let (fine, coarse) = (&mesh.levels[0], &mesh.levels[mesh.levels.len() - 1]);
            assert_eq!((fine.triangles(), coarse.triangles()), (20_000, 200), "{name}");
            let moved = fine.clone().transformed(glam::Affine3A::from_translation(Vec3::new(5.0, -3.0, 2.0)));
            let [whole, far, few] = [fine, &moved, coarse].map(volume);
            let reach = fine.vertices.iter().map(|v| Vec3::from(v.position).length()).fold(0.0, f32::max);
            println!("{name}: {whole:.3} m³, moved {far:.3}, 200 triangles {few:.3}, reach {reach:.2} m");
            assert!(whole > 0.5 && (far / whole - 1.0).abs() < 0.01 && few > 0.25 * whole, "{name}");
            assert!(reach <= REACH_M, "{name}");
            for vertex in &fine.vertices {
                assert!((Vec3::from(vertex.normal).length() - 1.0).abs() < 1e-3, "{name}");
            }
        }
    }
}
