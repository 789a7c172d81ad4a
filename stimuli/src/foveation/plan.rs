//! Guenter's eccentricity layers: the radii and sampling factors that follow an acuity line with the fewest pixels
//! (Guenter et al. 2012, §4.3, Eqs. 2–8). Pure arithmetic; the renderer is `renderers::layers`.

use experiments::display::Display;

pub use experiments::mar::{quality_index_from_slope, slope_from_quality_index};

/// A display as Eqs. 2–8 see it. [`LayerGeometry::of`] takes it from a real one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerGeometry {
    /// D*: pixels along the longer axis (not whole where a display is only imagined).
    pub resolution_px: f64,
    /// α*: the shorter axis over the longer, at most 1.
    pub aspect: f64,
    /// e*: half the field of view along the longer axis, degrees (Eq. 6).
    pub e_star_deg: f64,
    /// omega*: the display's sharpness, degrees per cycle (Eq. 7).
    pub omega_star_deg: f64,
}

impl LayerGeometry {
    /// The figures of `display`, along its longer axis (footnote 8).
    #[must_use]
    pub fn of(display: &Display) -> Self {
        let resolution = display.resolution_px().map(f64::from);
        let longer = usize::from(resolution[1] > resolution[0]);
        let (width_mm, distance_mm) = (display.size_mm()[longer], display.distance_mm());
        Self {
            resolution_px: resolution[longer],
            aspect: resolution[1 - longer] / resolution[longer],
            e_star_deg: (width_mm / (2.0 * distance_mm)).atan().to_degrees(),
            omega_star_deg: (2.0 * width_mm / (distance_mm * resolution[longer])).atan().to_degrees(),
        }
    }

    /// An imagined display of field `2 · e_star_deg` and sharpness `omega_star_deg`, whose resolution follows as
    /// D* = 4 tan e* / tan omega* (Eqs. 6 and 7; Eq. 9 prints this with omega0, see the first form's misprint).
    #[must_use]
    pub fn imagined(e_star_deg: f64, omega_star_deg: f64, aspect: f64) -> Self {
        Self {
            resolution_px: 4.0 * e_star_deg.to_radians().tan() / omega_star_deg.to_radians().tan(),
            aspect,
            e_star_deg,
            omega_star_deg,
        }
    }

    /// s_{i+1} = max(1, (m e_i + omega0) / omega*) (Eq. 2; the maximum is unprinted but needed near the gaze).
    #[must_use]
    pub fn sampling_factor(&self, m: f64, omega0_deg: f64, radius_deg: f64) -> f64 {
        ((m * radius_deg + omega0_deg) / self.omega_star_deg).max(1.0)
    }

    /// Pixels of a square inner layer (Eqs. 3 and 4): D_i = 2 (D*/s) tan(e) V*/W*, with V*/W* = 1 / (2 tan e*).
    fn inner_pixels(&self, radius_deg: f64, sampling_factor: f64) -> f64 {
        let diameter_px =
            self.resolution_px / sampling_factor * radius_deg.to_radians().tan() / self.e_star_deg.to_radians().tan();
        diameter_px * diameter_px
    }

    /// Pixels of the outermost layer, which covers the whole display (Eqs. 3 and 4).
    fn outer_pixels(&self, sampling_factor: f64) -> f64 {
        self.aspect * (self.resolution_px / sampling_factor).powi(2)
    }

    /// P*: pixels of the display (Eq. 8).
    #[must_use]
    pub fn display_pixels(&self) -> f64 {
        self.outer_pixels(1.0)
    }
}

/// One eccentricity layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// e_i: angular radius in degrees; the outermost layer's is e*.
    pub radius_deg: f64,
    /// s_i: display pixels per layer pixel, at least 1.
    pub sampling_factor: f64,
    /// P_i: pixels of the layer with the gaze at the display's centre (Eq. 4).
    pub pixels: f64,
}

/// A set of layers, innermost first.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerPlan {
    /// The display for which it was made.
    pub geometry: LayerGeometry,
    /// The layers, innermost first.
    pub layers: Vec<Layer>,
    /// The acuity line's slope.
    pub m: f64,
    /// The acuity line's intercept, degrees per cycle.
    pub omega0_deg: f64,
}

impl LayerPlan {
    /// P with every weight 1 (Eq. 5), the quantity that was minimised.
    #[must_use]
    pub fn pixels(&self) -> f64 {
        self.layers.iter().map(|layer| layer.pixels).sum()
    }

    /// P with weights 1, ½, ½, …: the outer layers at half rate. Evaluated at the unweighted optimum, as the paper did.
    #[must_use]
    pub fn pixels_half_rate(&self) -> f64 {
        let inner = self.layers.first().map_or(0.0, |layer| layer.pixels);
        inner + 0.5 * (self.pixels() - inner)
    }

    /// P* / P.
    #[must_use]
    pub fn speedup(&self) -> f64 {
        self.geometry.display_pixels() / self.pixels()
    }

    /// P* / P at half rate; the paper measured 13.3 and 9.8 where this gives 13.81 and 10.19 (its layers are padded).
    #[must_use]
    pub fn speedup_half_rate(&self) -> f64 {
        self.geometry.display_pixels() / self.pixels_half_rate()
    }
}

/// The layers that follow `omega = m e + omega0` on `display` with the fewest pixels. See [`optimise_geometry`].
#[must_use]
pub fn optimise(display: &Display, m: f64, omega0_deg: f64, layers: usize, restrict_s2: Option<f64>) -> LayerPlan {
    optimise_geometry(&LayerGeometry::of(display), m, omega0_deg, layers, restrict_s2)
}

/// Fractions of e* between which every free radius stays; a layer of no size at all would have no sampling grid.
const RADIUS_BOUNDS: [f64; 2] = [1e-4, 1.0 - 1e-4];
/// Radii tried per variable in the first, global search and in each refinement.
const COARSE_STEPS: usize = 400;
const FINE_STEPS: usize = 40;

/// Minimises P over the radii e_1 < … < e_{n−1} < e* with all weights 1 (§4.3 and §5).
///
/// `layers` is held to 2–4, `m` (degrees per cycle per degree) and `omega0_deg` (degrees per cycle) to at least 0.
/// `restrict_s2` fixes the second layer's sampling factor, as the user study did with 2, and with it e_1.
///
/// Brute force, as in the paper, but each layer's cost depends only on its own radius and the one inside it, so that the
/// best outer radii for each inner one are tabulated from the outside in; the search is then repeated in windows that
/// shrink around the optimum to 1e-9 of e*.
#[must_use]
pub fn optimise_geometry(
    geometry: &LayerGeometry,
    m: f64,
    omega0_deg: f64,
    layers: usize,
    restrict_s2: Option<f64>,
) -> LayerPlan {
    let (m, omega0_deg, layers) = (m.max(0.0), omega0_deg.max(0.0), layers.clamp(2, 4));
    let bounds = RADIUS_BOUNDS.map(|share| share * geometry.e_star_deg);

    // The windows of the radii: the whole display, or one value where the sampling factor is fixed.
    let mut windows = vec![bounds; layers - 1];
    if let Some(s2) = restrict_s2 {
        let e1 = (s2.max(1.0) * geometry.omega_star_deg - omega0_deg) / m.max(f64::MIN_POSITIVE);
        windows[0] = [e1.clamp(bounds[0], bounds[1]); 2];
    }

    // Search, then search again around what was found.
    let mut radii = best_radii(geometry, m, omega0_deg, &windows, COARSE_STEPS);
    let mut half_width = 2.0 * geometry.e_star_deg / COARSE_STEPS as f64;
    while half_width > 1e-9 * geometry.e_star_deg {
        for (window, &radius) in windows.iter_mut().zip(&radii) {
            if window[0] < window[1] {
                *window = [(radius - half_width).max(bounds[0]), (radius + half_width).min(bounds[1])];
            }
        }
        radii = best_radii(geometry, m, omega0_deg, &windows, FINE_STEPS);
        half_width *= 4.0 / FINE_STEPS as f64;
    }

    // Eq. 2 for the sampling factors, Eqs. 3 and 4 for the pixels.
    radii.push(geometry.e_star_deg);
    let mut sampling_factor = 1.0;
    let planned = radii.iter().enumerate().map(|(i, &radius_deg)| {
        let pixels = if i + 1 == layers {
            geometry.outer_pixels(sampling_factor)
        } else {
            geometry.inner_pixels(radius_deg, sampling_factor)
        };
        let layer = Layer { radius_deg, sampling_factor, pixels };
        sampling_factor = geometry.sampling_factor(m, omega0_deg, radius_deg);
        if i == 0
            && let Some(s2) = restrict_s2
            && m > 0.0
        {
            sampling_factor = sampling_factor.min(s2.max(1.0));
        }
        layer
    });
    LayerPlan { geometry: *geometry, layers: planned.collect(), m, omega0_deg }
}

/// The best of `steps + 1` radii in each window, by dynamic programming from the outermost layer inwards.
fn best_radii(geometry: &LayerGeometry, m: f64, omega0_deg: f64, windows: &[[f64; 2]], steps: usize) -> Vec<f64> {
    let grids: Vec<Vec<f64>> = windows
        .iter()
        .map(|&[low, high]| {
            let steps = if low < high { steps } else { 0 };
            (0..=steps).map(|i| low + (high - low) * i as f64 / steps.max(1) as f64).collect()
        })
        .collect();
    let factor = |radius: f64| geometry.sampling_factor(m, omega0_deg, radius);

    // `cost[i]`: fewest pixels of all layers outside the radius grid[i]; `next[layer][i]`: where the next radius lies.
    let last = grids.len() - 1;
    let mut cost: Vec<f64> = grids[last].iter().map(|&e| geometry.outer_pixels(factor(e))).collect();
    let mut next: Vec<Vec<usize>> = Vec::new();
    for layer in (0..last).rev() {
        let outer_cost = cost;
        let choices = grids[layer].iter().map(|&inner| {
            let s = factor(inner);
            let candidates = grids[layer + 1].iter().enumerate().filter(|&(_, &outer)| outer > inner);
            candidates
                .map(|(j, &outer)| (j, geometry.inner_pixels(outer, s) + outer_cost[j]))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((grids[layer + 1].len() - 1, f64::INFINITY))
        });
        let (choice, best): (Vec<usize>, Vec<f64>) = choices.unzip();
        cost = best;
        next.insert(0, choice);
    }

    // The innermost layer has the display's own sampling; then follow the choices outwards.
    let total = |i: usize| geometry.inner_pixels(grids[0][i], 1.0) + cost[i];
    let mut index = (0..grids[0].len()).min_by(|&a, &b| total(a).total_cmp(&total(b))).unwrap_or(0);
    let mut radii = vec![grids[0][index]];
    for (choice, grid) in next.iter().zip(&grids[1..]) {
        index = choice[index];
        radii.push(grid[index]);
    }
    radii
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA0: f64 = 1.0 / 48.0;

    fn guenter(m: f64, restrict_s2: Option<f64>) -> LayerPlan {
        optimise(&Display::named("guenter-2012").expect("ships"), m, OMEGA0, 3, restrict_s2)
    }

    fn close(actual: f64, expected: f64, tolerance: f64) {
        assert!((actual / expected - 1.0).abs() < tolerance, "{actual} is not {expected}");
    }

    /// Guenter 2012, §5 and our reading of it: count at half rate for the study's s2 = 2, and for a free s2.
    #[test]
    fn predicted_savings_are_the_published_ones() {
        for (m, restricted, free, unweighted) in [(0.0275, 13.81, 13.29, 8.50), (0.0220, 10.19, 10.11, 6.43)] {
            println!(
                "m {m}: restricted {:.3}, free {:.3}, unweighted {:.3}",
                guenter(m, Some(2.0)).speedup_half_rate(),
                guenter(m, None).speedup_half_rate(),
                guenter(m, None).speedup()
            );
            close(guenter(m, Some(2.0)).speedup_half_rate(), restricted, 1e-3);
            close(guenter(m, None).speedup_half_rate(), free, 1e-3);
            close(guenter(m, None).speedup(), unweighted, 1e-3);
        }
    }

    #[test]
    fn free_optimum_has_the_published_radii_and_factors() {
        for (m, e1, e2, s2, s3) in [(0.0275, 3.358, 8.123, 2.194, 4.734), (0.0220, 3.822, 8.637, 2.034, 4.087)] {
            let layers = guenter(m, None).layers;
            println!("m {m}: {layers:?}");
            close(layers[0].radius_deg, e1, 1e-3);
            close(layers[1].radius_deg, e2, 1e-3);
            close(layers[1].sampling_factor, s2, 1e-3);
            close(layers[2].sampling_factor, s3, 1e-3);
        }
    }

    /// "A factor of 100 at a 70° field" (Guenter 2012, §6): n = 4 layers, aspect ¾, omega* = omega0, all weights 1.
    #[test]
    fn savings_at_seventy_degrees() {
        let geometry = LayerGeometry::imagined(35.0, OMEGA0, 0.75);
        for (layers, expected) in [(4, 102.98), (3, 69.2), (2, 26.6)] {
            let speedup = optimise_geometry(&geometry, 0.0275, OMEGA0, layers, None).speedup();
            println!("{layers} layers: {speedup:.3}");
            close(speedup, expected, 2e-3);
        }
    }

    #[test]
    fn the_optimum_is_a_minimum() {
        let plan = guenter(0.0275, None);
        let g = plan.geometry;
        let total = |e1: f64, e2: f64| {
            g.inner_pixels(e1, 1.0)
                + g.inner_pixels(e2, g.sampling_factor(plan.m, OMEGA0, e1))
                + g.outer_pixels(g.sampling_factor(plan.m, OMEGA0, e2))
        };
        let (e1, e2) = (plan.layers[0].radius_deg, plan.layers[1].radius_deg);
        close(total(e1, e2), plan.pixels(), 1e-12);
        for (d1, d2) in [(1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3), (0.1, 0.1), (-0.5, 0.7)] {
            assert!(total(e1 + d1, e2 + d2) > plan.pixels());
        }
    }

    #[test]
    fn quality_indices_are_the_published_pairs() {
        close(slope_from_quality_index(12.0), 0.0275, 1e-12);
        close(slope_from_quality_index(15.0), 0.0220, 1e-12);
        close(quality_index_from_slope(0.0275), 12.0, 1e-12);
    }

    #[test]
    fn odd_input_still_gives_layers_in_order() {
        let display = Display::new("small", [16, 16], [10.0, 10.0], 5000.0).expect("in range");
        for m in [0.0, 1e-6, 0.02, 5.0] {
            for layers in [0, 2, 3, 4, 9] {
                for restrict in [None, Some(2.0), Some(0.0)] {
                    let plan = optimise(&display, m, 0.02, layers, restrict);
                    assert!((2..=4).contains(&plan.layers.len()));
                    assert!(plan.layers.windows(2).all(|w| w[0].radius_deg <= w[1].radius_deg));
                    assert!(plan.layers.iter().all(|l| l.sampling_factor >= 1.0 && l.pixels.is_finite()), "{plan:?}");
                }
            }
        }
    }
}
