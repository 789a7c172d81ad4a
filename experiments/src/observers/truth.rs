//! What a parametric observer can see: the visibility F of what a phase shows, from its parameters alone.

use crate::catalogue::{DetailLaw, ParameterValue};
use crate::display::Display;
use crate::mar::{MarModel, WIDTH_SCALE, standard_normal_cdf};
use crate::study::plan::{Condition, Level};
use serde::{Deserialize, Serialize};

/// Eccentricities at which a picture's detail is held against a MAR line.
const ECCENTRICITIES: u32 = 40;
/// Beyond this eccentricity nothing is on a flat display, degrees.
const FARTHEST_DEG: f64 = 85.0;

/// What an observer can see.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Truth {
    /// A MAR line: F = Φ(3.2897 (ln ω − ln(m e + ω0))/w) for a detail limit ω at eccentricity e, where the display could
    /// have shown finer detail; 0 where it could not.
    ///
    /// A ring counts at its own eccentricity. Limits that grow over the whole field count where they are seen best. A
    /// renderer that cannot say what it removes is as good as the reference to this observer.
    Mar(MarModel),
    /// A threshold of one renderer parameter, whatever it does.
    Parameter(ParameterTruth),
}

/// A threshold of one renderer parameter.
///
/// F = Φ(3.2897 (t − x)/w) where larger values are finer, Φ(3.2897 (x − t)/w) where they are coarser: ½ at the threshold t,
/// from 5 % to 95 % within the width w. On a logarithmic axis x and t are replaced by their natural logarithms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterTruth {
    /// The parameter's name.
    pub parameter: String,
    /// The value at which F is ½.
    pub threshold: f64,
    /// From 5 % to 95 %, in the parameter's unit, or in its natural logarithm.
    pub width: f64,
    /// Whether larger values are finer, as those of a quality index.
    pub finer_up: bool,
    /// Whether the axis is logarithmic.
    pub log: bool,
    /// Lapse rate λ.
    pub lapse: f64,
}

impl ParameterTruth {
    /// The argument of Φ at a value; negative infinity where the value cannot be placed on the axis.
    fn excess(&self, value: f64) -> f64 {
        let distance = if self.log { value.ln() - self.threshold.ln() } else { value - self.threshold };
        let distance = if distance.is_nan() { f64::NEG_INFINITY } else { distance };
        let sign = if self.finer_up { -1.0 } else { 1.0 };
        sign * WIDTH_SCALE * distance / self.width
    }
}

/// Where on the display a truth is asked about.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The display.
    pub display: &'a Display,
    /// Where the observer looks, degrees.
    pub fixation_deg: [f64; 2],
}

impl Truth {
    /// The lapse rate.
    #[must_use]
    pub fn lapse(&self) -> f64 {
        match self {
            Self::Mar(model) => model.lapse,
            Self::Parameter(truth) => truth.lapse,
        }
    }

    /// F: the visibility of a condition's degradation at a level, 0–1; nothing if this truth cannot say.
    #[must_use]
    pub fn visibility(&self, condition: &Condition, level: &Level, view: View<'_>) -> Option<f64> {
        self.excess(condition, level, view).map(standard_normal_cdf)
    }

    /// The argument of Φ, which still orders levels where F is as good as 0 or 1; negative infinity where nothing that the
    /// display could show is removed.
    pub(super) fn excess(&self, condition: &Condition, level: &Level, view: View<'_>) -> Option<f64> {
        match self {
            Self::Parameter(truth) => match condition.parameters_at(level).get(&truth.parameter) {
                Some(ParameterValue::Number(value)) => Some(truth.excess(*value)),
                _ => None,
            },
            Self::Mar(model) => match &condition.detail {
                DetailLaw::Full => Some(f64::NEG_INFINITY),
                DetailLaw::Unknown => None,
                DetailLaw::Ring { .. } => {
                    let [Some(e), Some(omega)] = condition.tested_at(level) else { return None };
                    Some(excess_over_line(model, e, omega, view))
                }
                DetailLaw::Line { .. } | DetailLaw::Gaussian { .. } | DetailLaw::Levels { .. } => {
                    let parameters = condition.parameters_at(level);
                    let farthest_deg = farthest_deg(view);
                    let mut largest = f64::NEG_INFINITY;
                    for step in 0..ECCENTRICITIES {
                        let e = farthest_deg * f64::from(step) / f64::from(ECCENTRICITIES - 1);
                        let omega = condition.detail.mar_deg(&parameters, e)?;
                        largest = largest.max(excess_over_line(model, e, omega, view));
                    }
                    Some(largest)
                }
            },
        }
    }
}

/// The argument of Φ for a detail limit at an eccentricity.
fn excess_over_line(model: &MarModel, eccentricity_deg: f64, mar_deg: f64, view: View<'_>) -> f64 {
    let shown_deg = view.display.finest_mar_deg(towards_farthest_corner(view, eccentricity_deg));
    if mar_deg <= shown_deg {
        return f64::NEG_INFINITY;
    }
    WIDTH_SCALE * (mar_deg.ln() - model.threshold_deg(eccentricity_deg).ln()) / model.width
}

/// The display's corner that is farthest from where the observer looks, millimetres.
fn farthest_corner_mm(view: View<'_>) -> [f64; 2] {
    let fixation_mm = view.display.mm_from_deg(view.fixation_deg);
    let size_mm = view.display.size_mm();
    std::array::from_fn(|axis| if fixation_mm[axis] > 0.0 { -0.5 * size_mm[axis] } else { 0.5 * size_mm[axis] })
}

/// The largest eccentricity on the display, degrees.
fn farthest_deg(view: View<'_>) -> f64 {
    let corner_deg = view.display.deg_from_mm(farthest_corner_mm(view));
    view.display.eccentricity_deg(view.fixation_deg, corner_deg)
}

/// The place at an eccentricity on the line from fixation to the farthest corner, degrees.
fn towards_farthest_corner(view: View<'_>, eccentricity_deg: f64) -> [f64; 2] {
    let display = view.display;
    let unit = |mm: [f64; 2]| {
        let direction = display.direction_from_mm(mm);
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        direction.map(|x| x / length)
    };
    let gaze = unit(display.mm_from_deg(view.fixation_deg));
    let corner = unit(farthest_corner_mm(view));
    let along: f64 = gaze.iter().zip(corner).map(|(a, b)| a * b).sum();
    let across: [f64; 3] = std::array::from_fn(|axis| corner[axis] - along * gaze[axis]);
    let length = across.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (sin, cos) = eccentricity_deg.min(FARTHEST_DEG).to_radians().sin_cos();
    let direction: [f64; 3] = std::array::from_fn(|axis| gaze[axis] * cos + across[axis] / length * sin);
    // A ring may be planned beyond the display's edge, but not behind the eye.
    let forward = direction[2].max(1e-3);
    display.deg_from_mm([direction[0], direction[1]].map(|x| x / forward * display.distance_mm()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Parameters;
    use crate::observers::decision::tests::condition;

    const MODEL: MarModel = MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.02 };

    fn view(display: &Display) -> View<'_> {
        View { display, fixation_deg: [0.0, 0.0] }
    }

    fn level(entries: &[(&str, f64)]) -> Level {
        entries.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    fn line() -> DetailLaw {
        DetailLaw::Line {
            m: "m".to_owned(),
            omega0: "omega0_deg".to_owned(),
            quality_index: Some("quality_index".to_owned()),
        }
    }

    #[test]
    fn the_place_at_an_eccentricity_is_at_that_eccentricity() {
        let display = Display::named("tursun-2019-27in").expect("ships");
        for fixation_deg in [[0.0, 0.0], [7.0, -3.0], [-20.0, 10.0]] {
            let view = View { display: &display, fixation_deg };
            for e in [0.0, 1.0, 12.0, 25.0] {
                let at_deg = towards_farthest_corner(view, e);
                assert!((display.eccentricity_deg(fixation_deg, at_deg) - e).abs() < 1e-9, "{fixation_deg:?} {e}");
            }
            let corner_deg = towards_farthest_corner(view, farthest_deg(view));
            let [x, y] = display.mm_from_deg(corner_deg).map(f64::abs);
            assert!((x - 0.5 * 596.74).abs() < 1e-6 && (y - 0.5 * display.size_mm()[1]).abs() < 1e-6);
        }
    }

    /// On a line the excess over another line is largest at one of its ends, and can be computed by hand.
    #[test]
    fn a_line_is_seen_best_where_it_exceeds_the_observers_own_most() {
        let display = Display::named("tursun-2019-32in").expect("ships");
        let condition = condition(line());
        let level = level(&[("m", 0.044), ("omega0_deg", 0.021)]);
        let farthest = farthest_deg(view(&display));
        let expected = WIDTH_SCALE * ((0.044 * farthest + 0.021) / (0.022 * farthest + 0.021)).ln() / 0.6;
        let found = Truth::Mar(MODEL).excess(&condition, &level, view(&display)).expect("known");
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        // The observer's own line is at threshold: F = ½ wherever the display is fine enough.
        let own = self::level(&[("quality_index", 15.0), ("m", 0.0), ("omega0_deg", 0.021)]);
        let at_own = Truth::Mar(MODEL).visibility(&condition, &own, view(&display)).expect("known");
        assert!((at_own - 0.5).abs() < 1e-9, "{at_own}");
    }

    #[test]
    fn detail_that_the_display_cannot_show_is_not_missed() {
        // 0.065 degrees per cycle at the centre of this display: a limit of 0.05 removes nothing.
        let display = Display::named("demo-540p").expect("ships");
        let ring = DetailLaw::Ring {
            eccentricity: "eccentricity_deg".to_owned(),
            width: "width_deg".to_owned(),
            mar: "mar_deg".to_owned(),
        };
        let condition = condition(ring);
        let at = |mar| {
            let level = level(&[("eccentricity_deg", 0.0), ("mar_deg", mar)]);
            Truth::Mar(MODEL).visibility(&condition, &level, view(&display)).expect("known")
        };
        assert!(at(0.05) < 1e-12);
        assert!(at(0.07) > 0.99, "{}", at(0.07));
    }

    #[test]
    fn a_gaussian_touches_nothing_within_its_radius() {
        let display = Display::named("tursun-2019-27in").expect("ships");
        let law = DetailLaw::Gaussian { radius: "radius_deg".to_owned(), rate: "rate".to_owned() };
        let condition = condition(law);
        let at = |radius, rate| {
            let level = level(&[("radius_deg", radius), ("rate", rate)]);
            Truth::Mar(MODEL).excess(&condition, &level, view(&display)).expect("known")
        };
        assert!(at(40.0, 0.01).is_infinite());
        assert!(at(4.0, 0.0052) > at(4.0, 0.0035) && at(4.0, 0.0035) > at(11.0, 0.0035));
    }

    #[test]
    fn a_parameters_threshold_has_half_the_visibility_and_its_width() {
        let display = Display::named("demo-540p").expect("ships");
        let mut truth = ParameterTruth {
            parameter: "quality_index".to_owned(),
            threshold: 14.0,
            width: 3.0,
            finer_up: true,
            log: false,
            lapse: 0.0,
        };
        let condition = condition(DetailLaw::Unknown);
        let at = |truth: &ParameterTruth, x| {
            let level = level(&[("quality_index", x)]);
            Truth::Parameter(truth.clone()).visibility(&condition, &level, view(&display)).expect("known")
        };
        for (x, f) in [(14.0, 0.5), (12.5, 0.95), (15.5, 0.05)] {
            assert!((at(&truth, x) - f).abs() < 1e-9);
        }
        truth = ParameterTruth { log: true, width: 0.5, finer_up: false, ..truth };
        assert!((at(&truth, 14.0 * 0.25_f64.exp()) - 0.95).abs() < 1e-9);
        // A value that no logarithm has is invisible or plain, but never a panic.
        assert!(at(&truth, -1.0) < 1e-12);
        assert!(Truth::Parameter(truth).visibility(&condition, &Level::new(), view(&display)).is_none());
        let unknown = Truth::Mar(MODEL).visibility(&condition, &Level::new(), view(&display));
        assert_eq!(unknown, None, "a law that is unknown has no visibility");
        let full = super::super::decision::tests::condition(DetailLaw::Full);
        assert!(Truth::Mar(MODEL).visibility(&full, &Level::new(), view(&display)).expect("known") < 1e-12);
        assert_eq!(full.renderer_parameters, Parameters::new());
    }
}
