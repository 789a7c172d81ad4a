//! Gaussian and Laplacian pyramids (Burt & Adelson 1983) with the filter [.05 .25 .4 .25 .05] and mirrored edges.

/// Light, or anything else, on a grid: `data[y * width + x]`, from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values, row by row.
    pub data: Vec<f32>,
}

/// Burt's generating kernel with a = 0.4.
const FILTER: [f32; 5] = [0.05, 0.25, 0.4, 0.25, 0.05];

impl Plane {
    /// A plane whose value at column x and row y is `f(x, y)`.
    #[must_use]
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> f32) -> Self {
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            data.extend((0..width).map(|x| f(x, y)));
        }
        Self { width, height, data }
    }

    /// The next coarser level: filtered, and every second sample of every second row. Odd sizes are rounded up.
    #[must_use]
    pub fn reduced(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut narrow = vec![0.0_f32; width * self.height];
        for (row, out) in self.data.chunks_exact(self.width).zip(narrow.chunks_exact_mut(width)) {
            for (j, out) in out.iter_mut().enumerate() {
                let centre = 2 * j;
                *out = if centre >= 2 && centre + 2 < self.width {
                    let taps = &row[centre - 2..centre + 3];
                    FILTER[0] * (taps[0] + taps[4]) + FILTER[1] * (taps[1] + taps[3]) + FILTER[2] * taps[2]
                } else {
                    (0..5).map(|k| FILTER[k] * row[mirrored(centre + k, self.width)]).sum()
                };
            }
        }
        let mut data = vec![0.0_f32; width * height];
        for (j, out) in data.chunks_exact_mut(width).enumerate() {
            for (k, weight) in FILTER.into_iter().enumerate() {
                let from = mirrored(2 * j + k, self.height) * width;
                for (out, value) in out.iter_mut().zip(&narrow[from..from + width]) {
                    *out += weight * value;
                }
            }
        }
        Self { width, height, data }
    }

    /// The next finer level of the given size: samples apart, nothing between them, filtered with gain four.
    #[must_use]
    pub fn expanded(&self, width: usize, height: usize) -> Self {
        // Rows first, as long as there are few of them.
        let mut wide = vec![0.0_f32; width * self.height];
        for (row, out) in self.data.chunks_exact(self.width).zip(wide.chunks_exact_mut(width)) {
            for (x, out) in out.iter_mut().enumerate() {
                let j = x / 2;
                *out = if x < 2 || x + 2 >= width {
                    expanded_at(x, width, |j| row[j])
                } else if x.is_multiple_of(2) {
                    2.0 * (FILTER[0] * (row[j - 1] + row[j + 1]) + FILTER[2] * row[j])
                } else {
                    2.0 * FILTER[1] * (row[j] + row[j + 1])
                };
            }
        }
        let mut data = vec![0.0_f32; width * height];
        // Between samples lies nothing, except where there is one sample only.
        let gain = if height == 1 { 1.0 } else { 2.0 };
        for (y, out) in data.chunks_exact_mut(width).enumerate() {
            for (k, weight) in FILTER.into_iter().enumerate() {
                let from = mirrored(y + k, height);
                if from.is_multiple_of(2) {
                    let from = from / 2 * width;
                    for (out, value) in out.iter_mut().zip(&wide[from..from + width]) {
                        *out += gain * weight * value;
                    }
                }
            }
        }
        Self { width, height, data }
    }
}

/// One sample of an expanded row, at its edges.
fn expanded_at(x: usize, width: usize, value: impl Fn(usize) -> f32) -> f32 {
    let gain = if width == 1 { 1.0 } else { 2.0 };
    let taps = (0..5).map(|k| (FILTER[k], mirrored(x + k, width)));
    taps.filter(|(_, from)| from.is_multiple_of(2)).map(|(weight, from)| gain * weight * value(from / 2)).sum()
}

/// The sample that stands at `at - 2` when a row of `length` samples is mirrored at its first and last sample, which are
/// not repeated.
fn mirrored(at: usize, length: usize) -> usize {
    let last = length - 1;
    if last == 0 {
        return 0;
    }
    let inner = at.abs_diff(2);
    let folded = inner % (2 * last);
    if folded > last { 2 * last - folded } else { folded }
}

/// The Gaussian pyramid: the plane itself and `levels` coarser ones.
#[must_use]
pub fn gaussian(plane: Plane, levels: usize) -> Vec<Plane> {
    let mut pyramid = vec![plane];
    for _ in 0..levels {
        if let Some(next) = pyramid.last().map(Plane::reduced) {
            pyramid.push(next);
        }
    }
    pyramid
}

/// The Laplacian band between two neighbouring levels of a Gaussian pyramid: the finer less the expanded coarser one.
#[must_use]
pub fn laplacian(finer: &Plane, coarser: &Plane) -> Plane {
    let mut band = coarser.expanded(finer.width, finer.height);
    for (value, fine) in band.data.iter_mut().zip(&finer.data) {
        *value = fine - *value;
    }
    band
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noisy(width: usize, height: usize) -> Plane {
        let mut state = 12345_u64;
        Plane::from_fn(width, height, |_, _| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / 16_777_216.0
        })
    }

    #[test]
    fn bands_and_the_coarsest_level_give_the_picture_back() {
        for (width, height) in [(64, 48), (37, 21), (5, 1), (2, 3)] {
            let plane = noisy(width, height);
            let levels = gaussian(plane.clone(), 3);
            let mut sum = levels[3].clone();
            for k in (0..3).rev() {
                let band = laplacian(&levels[k], &levels[k + 1]);
                sum = sum.expanded(levels[k].width, levels[k].height);
                sum.data.iter_mut().zip(&band.data).for_each(|(value, band)| *value += band);
            }
            for (back, value) in sum.data.iter().zip(&plane.data) {
                assert!((back - value).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_uniform_picture_stays_uniform_at_every_level_and_edge() {
        for (width, height) in [(64, 64), (33, 18), (7, 2), (1, 1)] {
            let plane = Plane::from_fn(width, height, |_, _| 3.5);
            let coarse = plane.reduced();
            assert!(coarse.data.iter().all(|value| (value - 3.5).abs() < 1e-5));
            assert!(coarse.expanded(width, height).data.iter().all(|value| (value - 3.5).abs() < 1e-5));
        }
    }

    /// A cosine through the filter loses by the filter's transfer function, 0.4 + 0.5 cos ω + 0.1 cos 2ω.
    #[test]
    fn a_sinusoid_is_attenuated_by_the_transfer_function() {
        let omega = std::f64::consts::TAU / 16.0;
        let plane = Plane::from_fn(128, 8, |x, _| (omega * x as f64).cos() as f32);
        let gain = 0.4 + 0.5 * omega.cos() + 0.1 * (2.0 * omega).cos();
        let coarse = plane.reduced();
        for x in 4..60 {
            let expected = gain * (omega * 2.0 * x as f64).cos();
            assert!((f64::from(coarse.data[2 * coarse.width + x]) - expected).abs() < 1e-5);
        }
    }

    #[test]
    fn edges_are_mirrored_without_repeating_them() {
        let indices = |length| (0..length + 4).map(|at| mirrored(at, length)).collect::<Vec<_>>();
        assert_eq!(indices(4), [2, 1, 0, 1, 2, 3, 2, 1]);
        assert_eq!(indices(2), [0, 1, 0, 1, 0, 1]);
        assert_eq!(indices(1), [0; 5]);
    }
}
