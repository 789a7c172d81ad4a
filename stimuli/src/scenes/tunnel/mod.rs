//! One winding tunnel that closes on itself, made twice: [`geom`] displaces its walls in dense geometry, [`maps`] leaves
//! them smooth and covers them with pictures and patterns. What differs between them is where detail comes from.

pub(crate) mod geom;
pub(crate) mod maps;

use super::parts::camera;
use super::parts::forms::torus;
use crate::world::shapes::{lathe, sphere};
use crate::world::{CameraPath, MeshLevel};
use glam::{Affine3A, DVec3, Mat3A, Vec3};
use std::f32::consts::TAU;

/// Radius of the tunnel, metres.
const RADIUS: f32 = 3.2;
/// Length of the loop along its middle, rounded, metres.
const LENGTH: f32 = 283.0;
/// Lamps along the loop.
const LAMPS: u32 = 30;

/// A place on the tunnel's middle line with its directions.
#[derive(Debug, Clone, Copy)]
struct Station {
    at: Vec3,
    /// Unit vectors: along the tunnel, to the right, and upwards.
    along: Vec3,
    right: Vec3,
    up: Vec3,
}

/// The middle line at `turn`, 0–1 around the loop.
fn middle(turn: f32) -> Vec3 {
    let t = turn * TAU;
    let radius = 44.0 + 4.0 * (3.0 * t + 0.4).sin() + 0.9 * (5.0 * t).cos();
    Vec3::new(radius * t.cos(), 1.6 * (2.0 * t).sin() + 0.6 * (5.0 * t + 1.0).sin(), radius * t.sin())
}

fn station(turn: f32) -> Station {
    let along = (middle(turn + 5e-4) - middle(turn - 5e-4)).normalize_or(Vec3::Z);
    let right = along.cross(Vec3::Y).normalize_or(Vec3::X);
    Station { at: middle(turn), along, right, up: right.cross(along) }
}

impl Station {
    /// From a frame with x to the right, y up and −z along the tunnel.
    fn frame(&self) -> Affine3A {
        let [x, y, z] = [self.right, self.up, -self.along].map(glam::Vec3A::from);
        Affine3A::from_mat3_translation(Mat3A::from_cols(x, y, z).into(), self.at)
    }

    /// The direction across the tunnel at `around`, 0–1: from below, over the left, seen in flight.
    fn across(&self, around: f32) -> Vec3 {
        let (sin, cos) = (around * TAU).sin_cos();
        -self.right * sin - self.up * cos
    }
}

/// A lamp on the tunnel's ceiling, below the origin: its cage, and the glass in it.
fn lamp() -> (MeshLevel, MeshLevel) {
    let mut cage = lathe(&[[0.0, -0.06], [0.20, -0.06], [0.20, 0.0], [0.14, 0.16], [0.0, 0.16]], 20);
    for y in [-0.16, -0.26] {
        cage.append(&torus(0.15, 0.012, 20, 6).transformed(Affine3A::from_translation(Vec3::Y * y)));
    }
    for i in 0..6 {
        let (sin, cos) = (i as f32 / 6.0 * TAU).sin_cos();
        let bar = |radius: f32, y: f32| Vec3::new(radius * cos, y, radius * sin);
        cage.append(&super::parts::forms::rod(bar(0.15, -0.06), bar(0.15, -0.26), 0.010, 6));
        cage.append(&super::parts::forms::rod(bar(0.15, -0.26), bar(0.0, -0.34), 0.010, 6));
    }
    let glass = sphere(0.11, 10).transformed(Affine3A::from_translation(Vec3::Y * -0.18));
    (cage, glass)
}

/// Where the lamps hang, and whether each is warm or cold.
fn lamps() -> impl Iterator<Item = (Station, bool)> {
    (0..LAMPS).map(|i| (station((i as f32 + 0.5) / LAMPS as f32), i % 3 != 2))
}

/// What a lamp sends out: amber, or the green-blue of a discharge lamp.
fn lamp_colour(warm: bool) -> Vec3 {
    if warm { Vec3::new(1.0, 0.58, 0.24) } else { Vec3::new(0.25, 0.75, 0.95) }
}

/// Along the middle, a little below it, looking ahead.
fn path() -> CameraPath {
    let eyes: Vec<DVec3> = (0..80)
        .map(|i| {
            // It starts where the view ahead is long.
            let here = station((i + 18) as f32 / 80.0);
            (here.at - 0.5 * here.up).as_dvec3()
        })
        .collect();
    camera::ahead(&eyes, 9.0, 2.8, |along| along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_has_its_length_and_never_meets_itself() {
        let steps = 2000_u16;
        let at = |i: u16| middle(f32::from(i) / f32::from(steps));
        let length: f32 = (0..steps).map(|i| at(i).distance(at(i + 1))).sum();
        let mut nearest = f32::MAX;
        for i in (0..steps).step_by(8) {
            for j in (i..steps).step_by(8) {
                let apart = (j - i).min(steps - (j - i));
                if apart > steps / 12 {
                    nearest = nearest.min(at(i).distance(at(j)));
                }
            }
        }
        println!("{length:.1} m long, {nearest:.1} m from itself");
        assert!((length / LENGTH - 1.0).abs() < 0.05 && nearest > 4.0 * RADIUS);
    }
}
