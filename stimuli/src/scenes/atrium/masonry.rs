//! The atrium's stonework: columns turned on a lathe, walls with round arches, vaults and balustrades. Everything stands
//! on the plane y = 0 and faces ±z until it is placed.

use crate::scenes::parts::forms::lattice;
use crate::world::MeshLevel;
use crate::world::shapes::{block, lathe};
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::PI;

/// A round column: a square plinth, a base of two rounds, a shaft that swells and narrows (entasis), and a capital with a
/// square slab on it.
pub(super) fn column(radius_m: f32, height_m: f32) -> MeshLevel {
    let r = radius_m;
    let (plinth, slab) = (0.5 * r, 0.42 * r);
    let mut profile = vec![[0.0, plinth], [1.36 * r, plinth]];
    // A half round from below to above.
    let round = |profile: &mut Vec<[f32; 2]>, inner: f32, bulge: f32, low: f32, high: f32| {
        for i in 0..=6 {
            let (sin, cos) = (PI * i as f32 / 6.0).sin_cos();
            profile.push([inner + bulge * sin, 0.5 * (low + high) - 0.5 * (high - low) * cos]);
        }
    };
    round(&mut profile, 1.2 * r, 0.16 * r, plinth, plinth + 0.34 * r);
    profile.push([1.08 * r, plinth + 0.40 * r]);
    round(&mut profile, 1.06 * r, 0.12 * r, plinth + 0.46 * r, plinth + 0.70 * r);
    let (foot, top) = (plinth + 0.78 * r, height_m - slab - 1.5 * r);
    for i in 0..=12 {
        let t = i as f32 / 12.0;
        let swell = 1.0 - 0.17 * t * t + 0.03 * (PI * t).sin();
        profile.push([r * swell, foot + t * (top - foot)]);
    }
    round(&mut profile, 0.84 * r, 0.12 * r, top + 0.05 * r, top + 0.25 * r);
    // The capital widens in a hollow curve to carry the slab.
    for i in 0..=8 {
        let t = i as f32 / 8.0;
        profile.push([r * (0.84 + 0.46 * t.powf(2.2)), top + 0.30 * r + t * 1.05 * r]);
    }
    profile.push([1.3 * r, height_m - slab]);
    profile.push([0.0, height_m - slab]);
    let mut level = lathe(&profile, 28);
    let square = |half: f32, low: f32, high: f32| block(Vec3::new(-half, low, -half), Vec3::new(half, high, half));
    level.append(&square(1.42 * r, 0.0, plinth));
    level.append(&square(1.40 * r, height_m - slab, height_m));
    level
}

/// A wall `span_m` wide about x = 0 with a round arch in it, from the arch's springing at y = 0 up to `height_m`.
pub(super) struct ArchWall {
    pub(super) span_m: f32,
    pub(super) height_m: f32,
    /// Of the arch.
    pub(super) radius_m: f32,
    pub(super) thickness_m: f32,
}

impl ArchWall {
    const STEPS: u32 = 24;

    fn at(&self, step: u32, radius_m: f32) -> Vec2 {
        let (sin, cos) = (PI * (1.0 - step as f32 / Self::STEPS as f32)).sin_cos();
        radius_m * Vec2::new(cos, sin)
    }

    /// The wall: both faces, the underside of the arch, and the undersides beside it.
    pub(super) fn wall(&self) -> MeshLevel {
        let mut level = MeshLevel::default();
        let (half, z) = (0.5 * self.span_m, 0.5 * self.thickness_m);
        let r = self.radius_m;
        // One face, and its mirror image behind.
        let mut face = MeshLevel::default();
        let mut part = |x0: f32, y0: f32, x1: f32, y1: f32| {
            let corner = |x: f32, y: f32| Vec3::new(x, y, z);
            let corners = [corner(x0, y0), corner(x1, y1), corner(x1, self.height_m), corner(x0, self.height_m)];
            let first = face.vertices.len() as u32;
            face.quad(corners, [Vec2::ZERO; 2]);
            // The lower edge is aslant, so each corner has its own place on the map: metres, y downwards.
            for vertex in &mut face.vertices[first as usize..] {
                vertex.uv = [vertex.position[0], -vertex.position[1]];
                vertex.tangent = [1.0, 0.0, 0.0, 1.0];
                vertex.normal = [0.0, 0.0, 1.0];
            }
        };
        part(-half, 0.0, -r, 0.0);
        for step in 0..Self::STEPS {
            let (a, b) = (self.at(step, r), self.at(step + 1, r));
            part(a.x, a.y, b.x, b.y);
        }
        part(r, 0.0, half, 0.0);
        level.append(&face);
        level.append(&face.transformed(Affine3A::from_rotation_y(PI)));
        // The soffit, seen from below.
        for step in 0..Self::STEPS {
            let (a, b) = (self.at(step, r), self.at(step + 1, r));
            let along = PI * r * step as f32 / Self::STEPS as f32;
            let next = PI * r * (step + 1) as f32 / Self::STEPS as f32;
            let corners = [a.extend(-z), b.extend(-z), b.extend(z), a.extend(z)];
            level.quad(corners, [Vec2::new(along, 0.0), Vec2::new(next, self.thickness_m)]);
        }
        for (x0, x1) in [(-half, -r), (r, half)] {
            let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
            level.quad(
                [corner(x0, -z), corner(x1, -z), corner(x1, z), corner(x0, z)],
                [Vec2::new(x0, -z), Vec2::new(x1, z)],
            );
        }
        level
    }

    /// A moulding around the arch on both faces, `width_m` wide, that stands out by `depth_m`.
    pub(super) fn archivolt(&self, width_m: f32, depth_m: f32) -> MeshLevel {
        let mut level = MeshLevel::default();
        let z0 = 0.5 * self.thickness_m;
        // A little inside the opening, so that it covers the wall's edge.
        let (inner, outer) = (self.radius_m - 0.02, self.radius_m + width_m);
        for step in 0..Self::STEPS {
            let z = z0 + depth_m;
            let [a, b, c, d] =
                [self.at(step, inner), self.at(step, outer), self.at(step + 1, outer), self.at(step + 1, inner)];
            let map = [Vec2::ZERO, Vec2::new(width_m, a.distance(d))];
            level.quad([d.extend(z), c.extend(z), b.extend(z), a.extend(z)].map(mirrored), map);
            level.quad([a.extend(z0), a.extend(z), d.extend(z), d.extend(z0)].map(mirrored), map);
            level.quad([c.extend(z0), c.extend(z), b.extend(z), b.extend(z0)].map(mirrored), map);
        }
        let behind = level.clone().transformed(Affine3A::from_rotation_y(PI));
        level.append(&behind);
        level
    }
}

/// Left and right exchanged, which turns a face around.
fn mirrored(at: Vec3) -> Vec3 {
    Vec3::new(-at.x, at.y, at.z)
}

/// A groin vault over a bay of `width_m` (x) by `depth_m` (z): two barrels that cross, with their springing at y = 0,
/// seen from below.
pub(super) fn vault(width_m: f32, depth_m: f32, rise_m: f32) -> MeshLevel {
    const CELLS: u32 = 24;
    let place = |i: i32, j: i32| {
        let along = |i: i32| (2.0 * i as f32 / CELLS as f32 - 1.0).clamp(-1.0, 1.0);
        let (x, z) = (along(i), along(j));
        // Each barrel is a half ellipse; the higher of the two is seen. Sampled by angle, so that the springing is smooth.
        let (x, z) = ((0.5 * PI * x).sin(), (0.5 * PI * z).sin());
        let barrel = |t: f32| (1.0 - t * t).max(0.0).sqrt();
        Vec3::new(0.5 * width_m * x, rise_m * barrel(x).max(barrel(z)), 0.5 * depth_m * z)
    };
    lattice(CELLS, CELLS, place, |i, j| Vec2::new(i as f32, -j as f32) * (width_m / CELLS as f32))
}

/// A balustrade `span_m` long about x = 0: small turned posts under a rail.
pub(super) fn balustrade(span_m: f32) -> MeshLevel {
    let profile = [
        [0.085, 0.10],
        [0.085, 0.16],
        [0.05, 0.20],
        [0.045, 0.24],
        [0.085, 0.36],
        [0.09, 0.42],
        [0.06, 0.56],
        [0.04, 0.68],
        [0.065, 0.72],
        [0.075, 0.78],
        [0.075, 0.84],
    ];
    let post = lathe(&profile, 10);
    let mut level = block(Vec3::new(-0.5 * span_m, 0.0, -0.12), Vec3::new(0.5 * span_m, 0.10, 0.12));
    level.append(&block(Vec3::new(-0.5 * span_m, 0.84, -0.14), Vec3::new(0.5 * span_m, 0.98, 0.14)));
    let count = (span_m / 0.30).floor().max(1.0);
    for i in 0..count as u32 {
        let x = span_m * ((i as f32 + 0.5) / count - 0.5);
        level.append(&post.clone().transformed(Affine3A::from_translation(Vec3::X * x)));
    }
    level
}

/// A cornice `span_m` long about x = 0, standing out to +z from the plane z = 0, of two steps over a row of dentils.
pub(super) fn cornice(span_m: f32) -> MeshLevel {
    let half = 0.5 * span_m;
    let bar = |low: f32, high: f32, out: f32| block(Vec3::new(-half, low, -0.02), Vec3::new(half, high, out));
    let mut level = bar(0.14, 0.24, 0.20);
    level.append(&bar(0.24, 0.36, 0.28));
    let count = (span_m / 0.25).round().max(1.0);
    for i in 0..count as u32 {
        let x = span_m * ((i as f32 + 0.5) / count - 0.5);
        level.append(&block(Vec3::new(x - 0.06, 0.0, -0.02), Vec3::new(x + 0.06, 0.14, 0.14)));
    }
    level
}
