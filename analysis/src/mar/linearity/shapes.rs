//! The three shapes as families of curves that stay positive, their fits, and data simulated from the straight one.

use super::super::data::Data;
use super::super::goodness::binomial;
use super::super::maximum_likelihood::{Curves, LARGEST_LAPSE, LN_WIDTH, Maximum, maximise};
use experiments::mar::{WIDTH_SCALE, standard_normal_cdf};
use rand_chacha::ChaCha8Rng;

/// Fits of the three shapes to one data set.
pub(super) struct Fits {
    pub(super) line: Maximum,
    pub(super) quadratic: Maximum,
    pub(super) broken: Option<(f64, Maximum)>,
}

impl Fits {
    pub(super) fn bend(&self) -> f64 {
        (2.0 * (self.quadratic.ln_likelihood - self.line.ln_likelihood)).max(0.0)
    }

    pub(super) fn break_gain(&self) -> f64 {
        self.broken.as_ref().map_or(0.0, |(_, b)| (2.0 * (b.ln_likelihood - self.line.ln_likelihood)).max(0.0))
    }
}

/// What the three families share.
pub(super) struct Shape {
    pub(super) far_deg: f64,
    guess: f64,
    breaks: Vec<f64>,
    ends: [f64; 2],
}

impl Shape {
    pub(super) fn new(data: &Data, guess: f64, breaks: Vec<f64>) -> Self {
        let far_deg = data.rings.iter().rfind(|ring| !ring.counts.is_empty()).map_or(1.0, |ring| ring.eccentricity_deg);
        let levels = data.rings.iter().flat_map(|ring| &ring.counts).map(|count| count.ln_omega);
        let (low, high) = levels.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        // A factor of 1000 beyond every level that was shown.
        Self { far_deg, guess, breaks, ends: [(low - 6.9).max(-690.0), (high + 6.9).min(690.0)] }
    }

    pub(super) fn fit(&self, data: &Data) -> Fits {
        let groups = [data];
        let v = self.ends;
        let lapse = [0.0, LARGEST_LAPSE.min(0.9 * (1.0 - self.guess))];
        let family = |kind: Kind| {
            let bounds = match kind {
                Kind::Line => vec![v, v, LN_WIDTH, lapse],
                Kind::Quadratic | Kind::Broken(_) => vec![v, v, v, LN_WIDTH, lapse],
            };
            Family { kind, far_deg: self.far_deg, bounds }
        };
        // Starts: flat in the middle of the levels, and rising as MAR does.
        let middle = 0.5 * (v[0] + v[1]);
        let rising = self.rising_start(data);
        let starts = [vec![rising.0, rising.1, -0.2, 0.02], vec![middle, middle, 0.5, 0.02]];
        let line = maximise(&family(Kind::Line), &groups, self.guess, &starts);

        let [near, end, width, lapse] = [0, 1, 2, 3].map(|i| line.parameters.get(i).copied().unwrap_or(0.0));
        let at = |s: f64| (near.exp() * (1.0 - s) + end.exp() * s).ln();
        // ln(b1 + √(b0 b2)) of the line itself, and bent either way.
        let bent = (0.5 * (near.exp() + end.exp()) + (0.5 * (near + end)).exp()).ln();
        let starts: Vec<Vec<f64>> =
            [0.0, 0.4, -0.4].iter().map(|bend| vec![near, end, bent + bend, width, lapse]).collect();
        let quadratic = maximise(&family(Kind::Quadratic), &groups, self.guess, &starts);

        let mut broken: Option<(f64, Maximum)> = None;
        let mut before: Option<Vec<f64>> = None;
        for &break_deg in &self.breaks {
            let share = break_deg / self.far_deg;
            let mut starts = vec![vec![near, at(share), end, width, lapse]];
            starts.extend(before.take());
            let maximum = maximise(&family(Kind::Broken(break_deg)), &groups, self.guess, &starts);
            before = Some(maximum.parameters.clone());
            if broken.as_ref().is_none_or(|(_, best)| maximum.ln_likelihood > best.ln_likelihood) {
                broken = Some((break_deg, maximum));
            }
        }
        Fits { line, quadratic, broken }
    }

    /// ln MAR at 0 and at the far end, from the mean level of the nearest and the farthest ring.
    fn rising_start(&self, data: &Data) -> (f64, f64) {
        let mean = |counts: &[super::super::data::Count]| {
            counts.iter().map(|c| c.ln_omega).sum::<f64>() / counts.len().max(1) as f64
        };
        let mut shown = data.rings.iter().filter(|ring| !ring.counts.is_empty());
        let first = shown.next();
        let last = shown.next_back();
        match (first, last) {
            (Some(first), Some(last)) => (mean(&first.counts), mean(&last.counts)),
            _ => (0.5 * (self.ends[0] + self.ends[1]), 0.5 * (self.ends[0] + self.ends[1])),
        }
    }

    /// New answers at the same levels, from the fitted line.
    pub(super) fn simulated(&self, data: &Data, line: &Maximum, rng: &mut ChaCha8Rng) -> Data {
        let mut simulated = data.clone();
        let p = &line.parameters;
        for ring in &mut simulated.rings {
            let s = ring.eccentricity_deg / self.far_deg;
            let ln_threshold = (p[0].exp() * (1.0 - s) + p[1].exp() * s).ln();
            for count in &mut ring.counts {
                let t = WIDTH_SCALE * (count.ln_omega - ln_threshold) / p[2].exp();
                let probability = self.guess + (1.0 - self.guess - p[3]) * standard_normal_cdf(t);
                let n = count.correct + count.wrong;
                count.correct = f64::from(binomial(n as u32, probability, rng));
                count.wrong = n - count.correct;
            }
        }
        simulated
    }
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// ln MAR at 0 and at the far end.
    Line,
    /// The same, and ln(b1 + √(b0 b2)) of the Bernstein form b0 (1 − s)² + 2 b1 s (1 − s) + b2 s², which is positive on
    /// 0 … 1 exactly where that is.
    Quadratic,
    /// ln MAR at 0, at the break and at the far end.
    Broken(f64),
}

struct Family {
    kind: Kind,
    far_deg: f64,
    bounds: Vec<[f64; 2]>,
}

impl Curves for Family {
    fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    fn width_index(&self, _group: usize) -> usize {
        self.bounds.len() - 2
    }

    fn ln_threshold(&self, p: &[f64], _group: usize, eccentricity_deg: f64, gradient: &mut [f64]) -> f64 {
        let s = eccentricity_deg / self.far_deg;
        match self.kind {
            Kind::Line => {
                let (near, far) = (p[0].exp() * (1.0 - s), p[1].exp() * s);
                let value = near + far;
                (gradient[0], gradient[1]) = (near / value, far / value);
                value.ln()
            }
            Kind::Quadratic => {
                let (near, far, sum) = (p[0].exp(), p[1].exp(), p[2].exp());
                let mean = (0.5 * (p[0] + p[1])).exp();
                let across = 2.0 * s * (1.0 - s);
                // Written without a difference: (√b0 (1 − s) − √b2 s)² + across · sum.
                let root = (0.5 * p[0]).exp() * (1.0 - s) - (0.5 * p[1]).exp() * s;
                let value = (root * root + across * sum).max(f64::MIN_POSITIVE);
                gradient[0] = (near * (1.0 - s) * (1.0 - s) - 0.5 * across * mean) / value;
                gradient[1] = (far * s * s - 0.5 * across * mean) / value;
                gradient[2] = across * sum / value;
                value.ln()
            }
            Kind::Broken(break_deg) => {
                let below = eccentricity_deg <= break_deg;
                let (from, to, share) = if below {
                    (0, 1, eccentricity_deg / break_deg)
                } else {
                    (1, 2, (eccentricity_deg - break_deg) / (self.far_deg - break_deg))
                };
                let (a, b) = (p[from].exp() * (1.0 - share), p[to].exp() * share);
                let value = a + b;
                (gradient[from], gradient[to]) = (a / value, b / value);
                value.ln()
            }
        }
    }
}
