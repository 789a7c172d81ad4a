//! Noise with a chosen amplitude spectrum, made once on the CPU: the Fourier transform of white noise keeps its phases and
//! is given the amplitudes 1/f^β, f in cycles per pixel. The amplitudes are exact, not only expected, and the picture
//! joins itself at its edges.

use std::f64::consts::PI;

/// Width and height of the tile, pixels: a power of two. The noise repeats after as many.
pub(super) const TILE_PX: usize = 1024;
/// How many standard deviations lie between the mean and black, or white, at full contrast.
const DEVIATIONS: f64 = 3.0;

/// Grey values of a tile, row by row: mean ½, standard deviation `contrast` / 6, so that at full contrast the RMS contrast
/// (standard deviation over mean) is a third. What lies beyond 3 standard deviations, a few pixels in a thousand, is held
/// there, so that everything stays within 0–1.
pub(super) fn tile(seed: u32, exponent: f64, contrast: f64) -> Vec<f32> {
    let n = TILE_PX;
    let white = |i: usize| {
        let value = (f64::from(pcg3d([(i % n) as u32, (i / n) as u32, seed]) >> 8) + 0.5) / 16_777_216.0;
        Complex { re: value - 0.5, im: 0.0 }
    };
    let mut plane: Vec<Complex> = (0..n * n).map(white).collect();
    transform(&mut plane, n, -1.0);
    for (i, value) in plane.iter_mut().enumerate() {
        // Frequencies above half the tile are the negative ones.
        let [fx, fy] = [i % n, i / n].map(|k| k.min(n - k) as f64 / n as f64);
        let f = fx.hypot(fy);
        let amplitude = value.re.hypot(value.im);
        let scale = if f > 0.0 && amplitude > 0.0 { f.powf(-exponent) / amplitude } else { 0.0 };
        *value = Complex { re: value.re * scale, im: value.im * scale };
    }
    transform(&mut plane, n, 1.0);
    let deviation = (plane.iter().map(|value| value.re * value.re).sum::<f64>() / (n * n) as f64).sqrt().max(1e-300);
    plane
        .iter()
        .map(|value| {
            let score = (value.re / deviation).clamp(-DEVIATIONS, DEVIATIONS);
            (0.5 + 0.5 * contrast / DEVIATIONS * score) as f32
        })
        .collect()
}

/// As in `noise.wgsl`: the three-dimensional PCG hash of Jarzynski and Olano (JCGT 9(3), 2020), its first word.
fn pcg3d(key: [u32; 3]) -> u32 {
    let mut v = key.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 3]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[2]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
    };
    mix(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    mix(&mut v);
    v[0]
}

#[derive(Debug, Clone, Copy)]
struct Complex {
    re: f64,
    im: f64,
}

/// The two-dimensional discrete Fourier transform of `n` × `n` values, exp(`sign` · 2πi …), without normalisation.
fn transform(plane: &mut [Complex], n: usize, sign: f64) {
    let turns: Vec<Complex> = (0..n / 2)
        .map(|k| {
            let (im, re) = (sign * 2.0 * PI * k as f64 / n as f64).sin_cos();
            Complex { re, im }
        })
        .collect();
    for _ in 0..2 {
        for row in plane.chunks_exact_mut(n) {
            transform_row(row, &turns);
        }
        transpose(plane, n);
    }
}

fn transpose(plane: &mut [Complex], n: usize) {
    for y in 0..n {
        for x in 0..y {
            plane.swap(y * n + x, x * n + y);
        }
    }
}

/// Cooley and Tukey's transform of one row, a power of two long; `turns` are the roots of unity of the first half turn.
fn transform_row(row: &mut [Complex], turns: &[Complex]) {
    let n = row.len();
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = if bits == 0 { 0 } else { i.reverse_bits() >> (usize::BITS - bits) };
        if i < j {
            row.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        let stride = n / (2 * half);
        for block in row.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let turn = turns[k * stride];
                let turned = Complex { re: b.re * turn.re - b.im * turn.im, im: b.re * turn.im + b.im * turn.re };
                *b = Complex { re: a.re - turned.re, im: a.im - turned.im };
                *a = Complex { re: a.re + turned.re, im: a.im + turned.im };
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_sum_that_defines_it() {
        let n = 8;
        let plane: Vec<Complex> =
            (0..n * n).map(|i| Complex { re: ((i * 37) % 23) as f64, im: ((i * 11) % 7) as f64 }).collect();
        let mut fast = plane.clone();
        transform(&mut fast, n, -1.0);
        for (v, u) in [(0, 0), (1, 0), (0, 3), (5, 2), (7, 7)] {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, value) in plane.iter().enumerate() {
                let (sin, cos) = (-2.0 * PI * (u * (i % n) + v * (i / n)) as f64 / n as f64).sin_cos();
                re += value.re * cos - value.im * sin;
                im += value.re * sin + value.im * cos;
            }
            let found = fast[v * n + u];
            assert!((found.re - re).abs() < 1e-9 && (found.im - im).abs() < 1e-9, "({u}, {v})");
        }
    }

    #[test]
    fn a_tile_has_the_stated_mean_and_contrast() {
        for exponent in [0.5, 1.0, 2.0] {
            let values = tile(3, exponent, 0.9);
            let n = values.len() as f64;
            let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
            let deviation = (values.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>() / n).sqrt();
            println!("exponent {exponent}: mean {mean:.5}, standard deviation {deviation:.5}");
            assert!((mean - 0.5).abs() < 2e-3 && (deviation / 0.15 - 1.0).abs() < 0.01);
            assert!(values.iter().all(|x| (0.0499..=0.9501).contains(x)));
        }
    }
}
