//! Repeatable randomness in space: a hash of whole numbers, gradient noise on a lattice (Perlin 2002) and sums of it.
//! The same everywhere, whatever the machine.

use glam::{IVec3, Vec3};

/// A number in 0–1 for every triple of whole numbers and seed (the finaliser of MurmurHash3 over their mixture).
pub(crate) fn hash(at: IVec3, seed: u32) -> f32 {
    bits(at, seed) as f32 / u32::MAX as f32
}

/// One of `count` for every triple of whole numbers and seed.
pub(crate) fn pick(at: IVec3, seed: u32, count: usize) -> usize {
    bits(at, seed) as usize % count.max(1)
}

fn bits(at: IVec3, seed: u32) -> u32 {
    let mut h = seed.wrapping_mul(0x9e37_79b1);
    for part in [at.x, at.y, at.z] {
        h = (h ^ part as u32).wrapping_mul(0x85eb_ca6b).rotate_left(13);
    }
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Gradient noise, about −1 to 1, with a feature a unit.
pub(crate) fn noise(at: Vec3, seed: u32) -> f32 {
    let floor = at.floor();
    let (cell, f) = (floor.as_ivec3(), at - floor);
    // Perlin's fade, whose second derivative vanishes at the lattice.
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |x: i32, y: i32, z: i32| {
        let offset = IVec3::new(x, y, z);
        let h = bits(cell + offset, seed);
        let d = f - offset.as_vec3();
        // The twelve edges of a cube, four of them twice.
        let (u, v) = match h & 15 {
            0..=3 => (d.x, d.y),
            4..=7 => (d.x, d.z),
            8..=11 => (d.y, d.z),
            12 | 13 => (d.x, d.y),
            _ => (d.y, d.z),
        };
        (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
    };
    let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
    let plane = |z: i32| {
        mix(mix(corner(0, 0, z), corner(1, 0, z), fade.x), mix(corner(0, 1, z), corner(1, 1, z), fade.x), fade.y)
    };
    mix(plane(0), plane(1), fade.z)
}

/// Noise of several octaves, each twice as fine and half as strong; about −1 to 1.
pub(crate) fn clouds(at: Vec3, octaves: u32, seed: u32) -> f32 {
    octave_sum(at, octaves, seed, |n| n)
}

/// Ridges: sharp crests where the noise changes its sign; 0 to about 1.
pub(crate) fn ridges(at: Vec3, octaves: u32, seed: u32) -> f32 {
    octave_sum(at, octaves, seed, |n| (1.0 - n.abs()).powi(2)) / 2.0
}

fn octave_sum(at: Vec3, octaves: u32, seed: u32, of: impl Fn(f32) -> f32) -> f32 {
    let (mut sum, mut weight, mut place) = (0.0, 1.0, at);
    for octave in 0..octaves {
        sum += weight * of(noise(place, seed.wrapping_add(octave)));
        weight *= 0.5;
        // Shifted, so that the lattices of two octaves do not meet.
        place = 2.0 * place + Vec3::splat(17.3);
    }
    sum
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(crate) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gradient noise is 0 on its lattice, has no mean, and is smooth.
    #[test]
    fn noise_is_smooth_and_centred() {
        let mut sum = 0.0;
        let mut steepest: f32 = 0.0;
        let count = 4000;
        for i in 0..count {
            let cell = IVec3::new(i % 20, i / 20 % 20, i / 400);
            assert!(noise(cell.as_vec3(), 5).abs() < 1e-6);
            let at = cell.as_vec3() + Vec3::new(hash(cell, 1), hash(cell, 2), hash(cell, 3));
            sum += noise(at, 5);
            steepest = steepest.max((noise(at + 1e-3 * Vec3::X, 5) - noise(at, 5)).abs() / 1e-3);
        }
        let mean = sum / count as f32;
        println!("mean {mean:.4}, steepest {steepest:.2}");
        assert!(mean.abs() < 0.03 && steepest < 4.0);
    }

    /// The hash is even: 4096 values in 16 bins, chi-square with 15 degrees of freedom below its 99.9 % point of 37.7.
    #[test]
    fn hashes_are_even() {
        let mut bins = [0.0_f64; 16];
        for i in 0..4096 {
            bins[pick(IVec3::new(i % 16, i / 16 % 16, i / 256), 3, 16)] += 1.0;
        }
        let chi_square: f64 = bins.iter().map(|n| (n - 256.0).powi(2) / 256.0).sum();
        println!("chi-square {chi_square:.1}");
        assert!(chi_square < 37.7);
    }
}
