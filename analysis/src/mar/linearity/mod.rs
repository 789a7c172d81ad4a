//! Is the MAR line a line? A straight line against one with a quadratic term and against two lines that meet at a break.
//!
//! All three are fitted by maximum likelihood (no priors) to the same trials, with one width and one lapse rate, and the
//! MAR is kept positive from the fovea to the largest eccentricity tested. This says whether the data bend; what the line
//! is, [`super::fit_mar`] says. The straight line here may also fall with eccentricity, so that it is not on the edge of
//! what it is held against.

mod shapes;

use super::data::{Data, FitError};
use super::maximum_likelihood::{ModelSize, chi_square_p};
use super::{MarFitConfig, MarTrial};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shapes::Shape;

/// How linearity is tested.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LinearityConfig {
    /// Probability of a correct answer by guessing.
    pub guess: f64,
    /// What the display could show, as in [`MarFitConfig::finest_mar`].
    pub finest_mar: Vec<(f64, f64)>,
    /// Where the break may lie, degrees; by default from the second to the last but one eccentricity tested.
    pub break_range_deg: Option<[f64; 2]>,
    /// Places in that range, evenly spaced with both ends, at which the break is tried, from 1 to 1000.
    pub breaks: usize,
    /// Data sets simulated from the fitted straight line for the p values, from 0 (none) to 100 000.
    pub simulations: usize,
    /// Seed of the simulation.
    pub seed: u64,
}

impl Default for LinearityConfig {
    fn default() -> Self {
        Self { guess: 0.5, finest_mar: Vec::new(), break_range_deg: None, breaks: 17, simulations: 499, seed: 0 }
    }
}

/// Why linearity was not tested.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LinearityError {
    /// Trials or configuration are at fault.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A bend cannot be told from a line.
    #[error("linearity needs at least 3 eccentricities with trials that the display could show, found {found}")]
    TooFewEccentricities {
        /// Eccentricities with shown trials.
        found: usize,
    },
    /// The configuration is impossible.
    #[error("linearity: {field} must be {expected}, found {found}")]
    BadConfig {
        /// The field at fault.
        field: &'static str,
        /// What would have been accepted.
        expected: &'static str,
        /// What was there.
        found: f64,
    },
}

/// A likelihood ratio of a larger model against the straight line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendTest {
    /// 2 (ln L of the larger model − ln L of the line), not below 0.
    pub deviance_difference: f64,
    /// Parameters that the larger model has more.
    pub df: usize,
    /// P(χ²(df) ≥ deviance difference). `None` for the broken line: under a straight line its break means nothing, so the
    /// difference is not χ² distributed (Davies 1987).
    pub p_chi_square: Option<f64>,
    /// Share of data sets simulated from the fitted line, at the same levels and with the same fits, whose difference is at
    /// least as large: (1 + exceeding)/(1 + simulations). `None` if none were simulated.
    pub p_simulated: Option<f64>,
}

/// The straight line omega = omega0 + m e.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StraightLine {
    /// Degrees per cycle.
    pub omega0: f64,
    /// Per degree of eccentricity; may be negative.
    pub m: f64,
    /// Width in ln omega.
    pub width: f64,
    /// Lapse rate.
    pub lapse: f64,
    /// Likelihood and criteria.
    pub size: ModelSize,
}

/// omega = omega0 + m e + q e².
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QuadraticLine {
    /// Degrees per cycle.
    pub omega0: f64,
    /// Slope at the fovea.
    pub m: f64,
    /// Quadratic term, degrees per cycle per degree².
    pub q: f64,
    /// Width in ln omega.
    pub width: f64,
    /// Lapse rate.
    pub lapse: f64,
    /// Likelihood and criteria.
    pub size: ModelSize,
    /// Against the straight line.
    pub test: BendTest,
}

/// Two lines that meet at a break.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BrokenLine {
    /// Degrees per cycle at the fovea.
    pub omega0: f64,
    /// Eccentricity of the break, the best of the places tried, degrees.
    pub break_deg: f64,
    /// Slopes below and above the break.
    pub slopes: [f64; 2],
    /// Width in ln omega.
    pub width: f64,
    /// Lapse rate.
    pub lapse: f64,
    /// Likelihood and criteria; the break counts as a parameter.
    pub size: ModelSize,
    /// Against the straight line.
    pub test: BendTest,
}

/// What the data say about the line's straightness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Linearity {
    /// The null.
    pub line: StraightLine,
    /// With a quadratic term.
    pub quadratic: QuadraticLine,
    /// With a break; needs four eccentricities, since with three it is the quadratic over again.
    pub broken: Option<BrokenLine>,
    /// Eccentricities with trials that the display could show, ascending, degrees.
    pub eccentricities_deg: Vec<f64>,
    /// All trials given.
    pub trials: usize,
    /// Trials at or below what the display could show, left out.
    pub trials_not_shown: usize,
    /// The configuration.
    pub config: LinearityConfig,
}

/// Test whether the MAR line bends.
///
/// The χ² p of the quadratic term is asymptotic; the simulated p values hold levels fixed as they were shown, also where a
/// procedure chose them.
///
/// # Errors
/// [`LinearityError`]: trials out of range, fewer than three eccentricities, an impossible configuration.
///
/// ```
/// use analysis::mar::{MarTrial, linearity::{LinearityConfig, test_linearity}};
/// let trials: Vec<MarTrial> = (0..480)
///     .map(|i| {
///         let eccentricity_deg = f64::from(5 * (i % 4));
///         let mar_deg = (0.022 * eccentricity_deg + 0.021) * 0.4 * 1.3f64.powi(i / 4 % 8);
///         MarTrial { eccentricity_deg, mar_deg, correct: i / 4 % 8 >= 4 || i / 32 % 2 == 0 }
///     })
///     .collect();
/// let linearity = test_linearity(&trials, &LinearityConfig { simulations: 19, ..LinearityConfig::default() })?;
/// assert!(linearity.quadratic.test.p_chi_square > Some(0.05));
/// # Ok::<(), analysis::mar::linearity::LinearityError>(())
/// ```
pub fn test_linearity(trials: &[MarTrial], config: &LinearityConfig) -> Result<Linearity, LinearityError> {
    let single = MarFitConfig { guess: config.guess, finest_mar: config.finest_mar.clone(), ..MarFitConfig::default() };
    let data = Data::new(trials, &single)?;
    let eccentricities_deg: Vec<f64> =
        data.rings.iter().filter(|ring| !ring.counts.is_empty()).map(|ring| ring.eccentricity_deg).collect();
    if eccentricities_deg.len() < 3 {
        return Err(LinearityError::TooFewEccentricities { found: eccentricities_deg.len() });
    }
    let breaks = breaks(&eccentricities_deg, config)?;
    let shape = Shape::new(&data, config.guess, breaks);
    let fits = shape.fit(&data);

    let line = &fits.line;
    let simulated: Vec<(f64, f64)> = (0..config.simulations)
        .into_par_iter()
        .map(|index| {
            let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
            rng.set_stream(index as u64);
            let fits = shape.fit(&shape.simulated(&data, line, &mut rng));
            (fits.bend(), fits.break_gain())
        })
        .collect();
    let p_simulated = |observed: f64, of: fn(&(f64, f64)) -> f64| {
        // A difference that is equal but for rounding exceeds.
        let exceeding = simulated.iter().filter(|s| of(s) >= observed - 1e-9).count();
        (config.simulations > 0).then(|| (1.0 + exceeding as f64) / (1.0 + config.simulations as f64))
    };

    let n = trials.len() - data.not_shown;
    let p = &line.parameters;
    let far = shape.far_deg;
    let (width, lapse) = (p[2].exp(), p[3]);
    let straight = StraightLine {
        omega0: p[0].exp(),
        m: (p[1].exp() - p[0].exp()) / far,
        width,
        lapse,
        size: ModelSize::new(line.ln_likelihood, 4, n),
    };
    let q = &fits.quadratic.parameters;
    let (near, end) = (q[0].exp(), q[1].exp());
    let middle = q[2].exp() - (near * end).sqrt();
    let quadratic = QuadraticLine {
        omega0: near,
        m: 2.0 * (middle - near) / far,
        q: (near - 2.0 * middle + end) / (far * far),
        width: q[3].exp(),
        lapse: q[4],
        size: ModelSize::new(fits.quadratic.ln_likelihood, 5, n),
        test: BendTest {
            deviance_difference: fits.bend(),
            df: 1,
            p_chi_square: Some(chi_square_p(fits.bend(), 1)),
            p_simulated: p_simulated(fits.bend(), |s| s.0),
        },
    };
    let broken = fits.broken.as_ref().map(|(break_deg, maximum)| {
        let b = &maximum.parameters;
        let (near, middle, end) = (b[0].exp(), b[1].exp(), b[2].exp());
        BrokenLine {
            omega0: near,
            break_deg: *break_deg,
            slopes: [(middle - near) / break_deg, (end - middle) / (far - break_deg)],
            width: b[3].exp(),
            lapse: b[4],
            size: ModelSize::new(maximum.ln_likelihood, 6, n),
            test: BendTest {
                deviance_difference: fits.break_gain(),
                df: 2,
                p_chi_square: None,
                p_simulated: p_simulated(fits.break_gain(), |s| s.1),
            },
        }
    });
    Ok(Linearity {
        line: straight,
        quadratic,
        broken,
        eccentricities_deg,
        trials: trials.len(),
        trials_not_shown: data.not_shown,
        config: config.clone(),
    })
}

/// The places at which a break is tried; none with fewer than four eccentricities.
fn breaks(eccentricities_deg: &[f64], config: &LinearityConfig) -> Result<Vec<f64>, LinearityError> {
    let bad = |field, expected, found| Err(LinearityError::BadConfig { field, expected, found });
    if !(1..=1000).contains(&config.breaks) {
        return bad("breaks", "from 1 to 1000", config.breaks as f64);
    }
    if config.simulations > 100_000 {
        return bad("simulations", "at most 100 000", config.simulations as f64);
    }
    let last = eccentricities_deg.len() - 1;
    let far = eccentricities_deg[last];
    if let Some([low, high]) = config.break_range_deg {
        for end in [low, high] {
            if !(end > 0.0 && end < far) {
                return bad("break_range_deg", "between 0 and the largest eccentricity tested", end);
            }
        }
        if low > high {
            return bad("break_range_deg", "in ascending order", low);
        }
    }
    if eccentricities_deg.len() < 4 {
        return Ok(Vec::new());
    }
    let [low, high] = config.break_range_deg.unwrap_or([eccentricities_deg[1], eccentricities_deg[last - 1]]);
    let steps = config.breaks.saturating_sub(1).max(1) as f64;
    Ok((0..config.breaks).map(|i| low + (high - low) * i as f64 / steps).collect())
}
