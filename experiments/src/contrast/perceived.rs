//! From luminance to perceived contrast, band by band (Tursun 2019, Eqs. 1, 2 and 4).

use super::{Parameters, Plane, Sensitivity, pyramid};

/// ε of Eq. 1, cd/m²: far below what any display shows as black.
const EPSILON_CD_M2: f32 = 1e-3;

/// One band of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// |C_n|: contrast in multiples of its detection threshold (Eq. 2).
    pub normalised: Plane,
    /// The mean of |C_n|^β over the 5×5 samples around each, without itself (the sum of Eq. 4's denominator).
    pub masking: Plane,
    /// C_t: perceived contrast in just noticeable differences, signed (Eq. 4).
    pub perceived: Plane,
}

/// The bands of a luminance picture in cd/m², the finest first: as many as the sensitivity has.
///
/// Eq. 1's L_a is the Gaussian level two below the band, brought up by the pyramid's own filter as in the authors' program
/// (the paper says "linear"). The Laplacian band i is taken 2^{i−1} times, L_a is not, which is how the parameters were
/// calibrated.
#[must_use]
pub fn bands(luminance: Plane, parameters: &Parameters, sensitivity: &Sensitivity) -> Vec<Band> {
    let bands = sensitivity.bands();
    let levels = pyramid::gaussian(luminance, bands + 1);
    (0..bands)
        .map(|band| {
            let (fine, coarse) = (&levels[band], &levels[band + 1]);
            let difference = pyramid::laplacian(fine, coarse);
            let adaptation = levels[band + 2].expanded(coarse.width, coarse.height).expanded(fine.width, fine.height);
            let scale = (1_u32 << band) as f32;
            masked(&difference, &adaptation, scale, parameters, |sample| sensitivity.ln_at(band, sample))
        })
        .collect()
}

/// Eqs. 1, 2 and 4 for one band.
fn masked(
    difference: &Plane,
    adaptation: &Plane,
    scale: f32,
    parameters: &Parameters,
    ln_sensitivity: impl Fn(usize) -> f32,
) -> Band {
    let (width, height) = (difference.width, difference.height);
    let (alpha, beta) = (parameters.alpha as f32, parameters.beta as f32);
    let samples = width * height;
    let (mut normalised, mut own, mut around) =
        (Vec::with_capacity(samples), Vec::with_capacity(samples), Vec::with_capacity(samples));
    for (sample, (delta, adapted)) in difference.data.iter().zip(&adaptation.data).enumerate() {
        // In logarithms, a product is a sum and a power a product; nothing at all is negative infinity.
        let adapted = adapted.max(0.0);
        let ln_contrast = ((scale * delta).abs() / (adapted + EPSILON_CD_M2)).ln();
        let ln_adaptation = -0.2 * (1.0 + 0.7 / adapted).ln();
        let ln = ln_contrast + ln_adaptation + ln_sensitivity(sample);
        normalised.push(ln.exp());
        own.push((alpha * ln).exp());
        around.push((beta * ln).exp());
    }
    let around = Plane { width, height, data: around };
    let masking = neighbourhood_mean(&around);
    let perceived = own
        .iter()
        .zip(&masking.data)
        .zip(&difference.data)
        .map(|((own, masking), delta)| if *delta < 0.0 { -own } else { *own } / (1.0 + masking))
        .collect();
    Band {
        normalised: Plane { width, height, data: normalised },
        masking,
        perceived: Plane { width, height, data: perceived },
    }
}

/// The mean over the 5×5 neighbourhood without its centre; edges are mirrored with the edge repeated.
fn neighbourhood_mean(plane: &Plane) -> Plane {
    let (width, height) = (plane.width, plane.height);
    let mut rows = vec![0.0_f32; width * height];
    for (row, out) in plane.data.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        for (x, out) in out.iter_mut().enumerate() {
            *out = if x >= 2 && x + 2 < width {
                row[x - 2..x + 3].iter().sum()
            } else {
                (0..5).map(|k| row[symmetric(x + k, width)]).sum()
            };
        }
    }
    let mut data = vec![0.0_f32; width * height];
    for (y, out) in data.chunks_exact_mut(width).enumerate() {
        for k in 0..5 {
            let from = symmetric(y + k, height) * width;
            for (out, value) in out.iter_mut().zip(&rows[from..from + width]) {
                *out += value;
            }
        }
        for (out, centre) in out.iter_mut().zip(&plane.data[y * width..]) {
            *out = ((*out - centre) / 24.0).max(0.0);
        }
    }
    Plane { width, height, data }
}

/// The sample at `at - 2` when a row is mirrored so that its first and last sample come twice.
fn symmetric(at: usize, length: usize) -> usize {
    let period = 2 * length;
    let folded = (at + period * 2 - 2) % period;
    if folded >= length { period - 1 - folded } else { folded }
}

#[cfg(test)]
mod tests {
    use super::super::{BANDS, FULL_RESOLUTION};
    use super::*;

    fn uniform(e: f64) -> Sensitivity {
        Sensitivity::uniform(&FULL_RESOLUTION, e, 24.9, BANDS)
    }

    #[test]
    fn a_uniform_picture_has_no_contrast() {
        let bands = bands(Plane::from_fn(96, 64, |_, _| 80.0), &FULL_RESOLUTION, &uniform(5.0));
        for band in &bands {
            // Rounding leaves 1e-7 of the light, of which the calibrated sensitivity of 10^7.9 makes a little.
            assert!(band.perceived.data.iter().all(|c| c.abs() < 2.0), "{:?}", band.perceived.data[0]);
        }
        // Powers of two add up without rounding: then nothing is left at all.
        let black = super::bands(Plane::from_fn(96, 64, |_, _| 0.0), &FULL_RESOLUTION, &uniform(5.0));
        assert!(black.iter().all(|band| band.perceived.data.iter().all(|c| c.abs() < 1e-12)));
    }

    /// A grating of known contrast: away from the edges band 1 holds it times one less what reduce and expand let through,
    /// over the mean luminance.
    #[test]
    fn a_grating_has_the_contrast_of_its_definition() {
        let period = 8.0;
        let omega = std::f64::consts::TAU / period;
        let grating = Plane::from_fn(256, 64, |x, _| (100.0 + 20.0 * (omega * x as f64).cos()) as f32);
        let sensitivity = uniform(0.0);
        let bands = bands(grating, &FULL_RESOLUTION, &sensitivity);
        let gain = |w: f64| 0.4 + 0.5 * w.cos() + 0.1 * (2.0 * w).cos();
        // Expanding after reducing lets the wave through with gain² and adds its alias at π − ω with gain(ω) gain(π − ω).
        let alias = gain(omega) * gain(std::f64::consts::PI - omega);
        let own = 1.0 - gain(omega).powi(2);
        let at = 128;
        // Two levels down every fourth sample alternates; expanding that twice leaves 0.6 and then 0.8 of it at a crest.
        let adapted = 100.0 + 20.0 * gain(omega) * gain(2.0 * omega) * 0.6 * 0.8;
        let contrast = 20.0 * (own - alias) / adapted;
        let ln = contrast.ln() - 0.2 * (1.0_f64 + 0.7 / adapted).ln() + f64::from(sensitivity.ln_at(0, 0));
        let found = f64::from(bands[0].normalised.data[32 * 256 + at]);
        assert!((found / ln.exp() - 1.0).abs() < 1e-3, "{found} {}", ln.exp());
        let c_t = f64::from(bands[0].perceived.data[32 * 256 + at]);
        let masking = f64::from(bands[0].masking.data[32 * 256 + at]);
        assert!((c_t - found.powf(0.612_33) / (1.0 + masking)).abs() < 1e-3 * c_t);
    }

    #[test]
    fn the_same_detail_is_felt_less_farther_out() {
        let noise = Plane::from_fn(64, 64, |x, y| 100.0 + 10.0 * ((x * 7919 + y * 104_729) % 17) as f32);
        let total = |e| {
            let bands = bands(noise.clone(), &FULL_RESOLUTION, &uniform(e));
            bands.iter().flat_map(|band| &band.perceived.data).map(|c| f64::from(c.abs())).sum::<f64>()
        };
        let felt = [0.0, 5.0, 10.0, 20.0, 30.0].map(total);
        assert!(felt.windows(2).all(|pair| pair[0] > pair[1]), "{felt:?}");
    }

    #[test]
    fn the_neighbourhood_leaves_its_centre_out() {
        let spot = Plane::from_fn(9, 9, |x, y| if (x, y) == (4, 4) { 24.0 } else { 0.0 });
        let mean = neighbourhood_mean(&spot);
        for y in 0..9_usize {
            for x in 0..9_usize {
                let near = x.abs_diff(4) <= 2 && y.abs_diff(4) <= 2 && (x, y) != (4, 4);
                assert!((mean.data[y * 9 + x] - if near { 1.0 } else { 0.0 }).abs() < 1e-6, "{x} {y}");
            }
        }
        // Mirrored with the edge repeated, a corner counts itself three more times.
        let corner = neighbourhood_mean(&Plane::from_fn(9, 9, |x, y| if (x, y) == (0, 0) { 24.0 } else { 0.0 }));
        assert!((corner.data[0] - 3.0).abs() < 1e-6);
    }
}
