//! The foveal contrast sensitivity S'(f): four calibrated values and a monotone curve through them.

use super::Parameters;

/// A piecewise cubic through given points that never overshoots them (Fritsch & Butland 1984; "PCHIP").
#[derive(Debug, Clone, PartialEq)]
pub struct Pchip {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Pchip {
    /// The curve through points whose `x` ascend strictly. Nothing for fewer than two points, unequal lengths or an `x`
    /// that does not ascend.
    #[must_use]
    pub fn new(x: &[f64], y: &[f64]) -> Option<Self> {
        let ascending = x.windows(2).all(|pair| pair[0] < pair[1]);
        if x.len() < 2 || x.len() != y.len() || !ascending {
            return None;
        }
        let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let secant: Vec<f64> = y.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
        let n = x.len();
        let slope = (0..n)
            .map(|k| match k {
                _ if n == 2 => secant[0],
                0 => end_slope([h[0], h[1]], [secant[0], secant[1]]),
                k if k == n - 1 => end_slope([h[n - 2], h[n - 3]], [secant[n - 2], secant[n - 3]]),
                // An extremum stays one.
                k if secant[k - 1] * secant[k] <= 0.0 => 0.0,
                k => {
                    let (before, after) = (2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]);
                    (before + after) / (before / secant[k - 1] + after / secant[k])
                }
            })
            .collect();
        Some(Self { x: x.to_vec(), y: y.to_vec(), slope })
    }

    /// The curve at `x`; beyond its ends, the value there.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        let last = self.x.len() - 1;
        if x <= self.x[0] {
            return self.y[0];
        }
        if x >= self.x[last] {
            return self.y[last];
        }
        let k = self.x.partition_point(|&knot| knot <= x) - 1;
        let h = self.x[k + 1] - self.x[k];
        let t = (x - self.x[k]) / h;
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * self.y[k]
            + (t3 - 2.0 * t2 + t) * h * self.slope[k]
            + (3.0 * t2 - 2.0 * t3) * self.y[k + 1]
            + (t3 - t2) * h * self.slope[k + 1]
    }
}

/// The slope at an end: of the parabola through three points, held back where it would overshoot.
fn end_slope(h: [f64; 2], secant: [f64; 2]) -> f64 {
    let slope = ((2.0 * h[0] + h[1]) * secant[0] - h[0] * secant[1]) / (h[0] + h[1]);
    if slope * secant[0] <= 0.0 {
        0.0
    } else if secant[0] * secant[1] < 0.0 && slope.abs() > 3.0 * secant[0].abs() {
        3.0 * secant[0]
    } else {
        slope
    }
}

/// Frequencies at which the sensitivity is given, cycles per degree. Below the first calibrated one (4) it is flat, at 64
/// it is as good as nothing.
const KNOTS_CPD: [f64; 6] = [1e-32, 4.0, 8.0, 16.0, 32.0, 64.0];
/// The sensitivity at 64 cycles per degree.
const NOTHING: f64 = 1e-32;

/// S'(f), interpolated in ln sensitivity over ln frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Csf(Pchip);

impl Csf {
    /// The sensitivity of a calibration.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let [s4, s8, s16, s32] = parameters.log10_sensitivity.map(|log10| log10 * std::f64::consts::LN_10);
        let y = [s4, s4, s8, s16, s32, NOTHING.ln()];
        Self(Pchip::new(&KNOTS_CPD.map(f64::ln), &y).expect("the knots ascend"))
    }

    /// ln S' at a frequency in cycles per degree.
    #[must_use]
    pub fn ln_sensitivity(&self, cpd: f64) -> f64 {
        self.0.at(cpd.max(KNOTS_CPD[0]).ln())
    }
}

#[cfg(test)]
mod tests {
    use super::super::FULL_RESOLUTION;
    use super::*;

    include!("peer_numbers.in");

    #[test]
    fn curves_agree_with_scipy() {
        for (x, expected) in SCIPY_PCHIP {
            let curve = Pchip::new(&SCIPY_KNOTS.map(|(x, _)| x), &SCIPY_KNOTS.map(|(_, y)| y)).expect("ascending");
            assert!((curve.at(x) - expected).abs() < 1e-12 * expected.abs().max(1.0), "{x}: {}", curve.at(x));
        }
        let csf = Csf::new(&FULL_RESOLUTION);
        for (cpd, expected) in SCIPY_LN_SENSITIVITY {
            assert!((csf.ln_sensitivity(cpd) - expected).abs() < 1e-9, "{cpd}: {}", csf.ln_sensitivity(cpd));
        }
    }

    #[test]
    fn curves_never_leave_the_range_of_their_points() {
        let csf = Csf::new(&FULL_RESOLUTION);
        for step in 0..400_usize {
            let cpd = 4.0 * 2f64.powf(step as f64 / 100.0);
            let octave = step / 100;
            let knots: [f64; 5] = [6.2985, 5.5486, 7.4847, 7.9453, -32.0];
            let log10 = csf.ln_sensitivity(cpd) / std::f64::consts::LN_10;
            let (low, high) = (knots[octave].min(knots[octave + 1]), knots[octave].max(knots[octave + 1]));
            assert!((low - 1e-9..=high + 1e-9).contains(&log10), "{cpd}: {log10}");
        }
        assert!((csf.ln_sensitivity(0.5) - csf.ln_sensitivity(4.0)).abs() < 1e-12);
    }

    #[test]
    fn points_that_do_not_ascend_are_refused() {
        assert_eq!(Pchip::new(&[0.0, 0.0], &[1.0, 2.0]), None);
        assert_eq!(Pchip::new(&[0.0], &[1.0]), None);
        assert_eq!(Pchip::new(&[0.0, 1.0], &[1.0]), None);
    }
}
