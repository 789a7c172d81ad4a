//! Light from all around: a panorama, and what it sends to matt surfaces as a sun and spherical harmonics.

use crate::contract::MakeError;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// What exceeds this radiance, in units of the mean, belongs to the sun and is taken out of the ambient light.
const SUN_THRESHOLD: f32 = 12.0;

/// Radiance by direction: longitude from left to right, colatitude from top to bottom; the middle is the +x direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panorama {
    pub(crate) size: [u32; 2],
    /// Linear, row by row.
    pub(crate) radiance: Vec<Vec3>,
}

impl Panorama {
    /// A panorama that shows the same everywhere.
    pub(crate) fn uniform(radiance: Vec3) -> Self {
        // So many pixels that the sky's integrals are good to a thousandth.
        Self { size: [32, 16], radiance: vec![radiance; 32 * 16] }
    }

    /// A panorama of `width` × `width`/2 pixels from the radiance in every direction.
    pub(crate) fn painted(width: u32, radiance_of: impl Fn(Vec3) -> Vec3) -> Self {
        let size = [width, (width / 2).max(1)];
        let pixels = (0..size[0] * size[1]).map(|i| radiance_of(direction(i, size).as_vec3()));
        Self { size, radiance: pixels.collect() }
    }

    /// One of the shipped panoramas (OpenEXR), with its mean radiance scaled to `mean`.
    ///
    /// # Errors
    /// When it does not decode, which would be a damaged program.
    pub(crate) fn shipped(name: &'static str, bytes: &[u8], mean: f32) -> Result<Self, MakeError> {
        let decoded = image::load_from_memory_with_format(bytes, image::ImageFormat::OpenExr)
            .map_err(|error| MakeError::Asset { name, reason: error.to_string() })?;
        Ok(Self::repaired(&decoded.into_rgb32f()).with_mean(mean))
    }

    /// A panorama from decoded pixels with its sun mended: the few pixels of the disc may hold broken values (far below
    /// zero, not a number, or thousands in one channel and nothing in the others); they take the radiance of the brightest
    /// intact pixel instead.
    pub(crate) fn repaired(decoded: &image::Rgb32FImage) -> Self {
        let intact =
            |c: Vec3| c.is_finite() && c.min_element() > -0.5 && c.max_element() < 1e3 * c.min_element().max(0.1);
        let pixels = || decoded.pixels().map(|p| Vec3::from_array(p.0));
        let brightest = pixels()
            .filter(|&c| intact(c))
            .max_by(|a, b| a.element_sum().total_cmp(&b.element_sum()))
            .unwrap_or(Vec3::ONE);
        let radiance = pixels().map(|c| if intact(c) { c.max(Vec3::ZERO) } else { brightest }).collect();
        Self { size: [decoded.width(), decoded.height()], radiance }
    }

    /// The same, scaled so that the mean of all values is `mean`; a black one stays black.
    #[must_use]
    pub(crate) fn with_mean(mut self, mean: f32) -> Self {
        let found =
            self.radiance.iter().map(|c| c.element_sum()).sum::<f32>() / (3 * self.radiance.len()).max(1) as f32;
        if found > 0.0 {
            self.radiance.iter_mut().for_each(|c| *c *= mean / found);
        }
        self
    }

    /// The panorama and ever smaller ones, each half as wide and high, down to one row: averages weighted by solid angle.
    pub(crate) fn pyramid(&self) -> Vec<Self> {
        let mut levels = vec![self.clone()];
        while let Some(last) = levels.last().filter(|last| last.size[1] > 1) {
            let [width, height] = last.size;
            let size = [(width / 2).max(1), height / 2];
            let weight = |row: u32| ((f64::from(row) + 0.5) / f64::from(height) * PI).sin() as f32;
            let at =
                |column: u32, row: u32| last.radiance[(row * width + column.min(width - 1)) as usize] * weight(row);
            let mut radiance = Vec::with_capacity((size[0] * size[1]) as usize);
            for row in 0..size[1] {
                for column in 0..size[0] {
                    let (x, y) = (2 * column, 2 * row);
                    let sum = at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1);
                    radiance.push(sum / (2.0 * (weight(y) + weight(y + 1))));
                }
            }
            levels.push(Self { size, radiance });
        }
        levels
    }
}

/// The direction of pixel `index`.
fn direction(index: u32, [width, height]: [u32; 2]) -> DVec3 {
    let (column, row) = (index % width, index / width);
    let theta = (f64::from(row) + 0.5) / f64::from(height) * PI;
    let phi = ((f64::from(column) + 0.5) / f64::from(width) - 0.5) * TAU;
    DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
}

/// A panorama with what it does to matt surfaces.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Environment {
    pub(crate) panorama: Panorama,
    pub(crate) sun: Option<Sun>,
    /// Irradiance over π without the sun, in the nine functions of [`harmonic_basis`] (Ramamoorthi and Hanrahan 2001,
    /// Eqs. 7–10).
    pub(crate) ambient: [Vec3; 9],
}

/// The brightest part of a panorama, as a light from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sun {
    /// Unit vector towards it.
    pub(crate) towards: Vec3,
    /// Its light on a surface that faces it, over π: what a white matt surface sends out.
    pub(crate) colour: Vec3,
}

impl Default for Environment {
    /// A grey sky without a sun.
    fn default() -> Self {
        Self::of(Panorama::uniform(Vec3::splat(0.5)))
    }
}

impl Environment {
    /// Integrates a panorama.
    pub(crate) fn of(panorama: Panorama) -> Self {
        let [width, height] = panorama.size;
        let count = (3 * panorama.radiance.len()).max(1) as f32;
        let mean = panorama.radiance.iter().map(|c| c.element_sum()).sum::<f32>() / count;
        let threshold = SUN_THRESHOLD * mean;
        let mut sun_direction = Vec3::ZERO;
        let mut sun_light = Vec3::ZERO;
        let mut harmonics = [Vec3::ZERO; 9];
        for (&light, i) in panorama.radiance.iter().zip(0..) {
            let d = direction(i, panorama.size);
            // That of the pixel exactly: the sphere's area between two colatitudes is the difference of their cosines.
            let row = f64::from(i / width);
            let [above, below] = [row, row + 1.0].map(|edge| (edge / f64::from(height) * PI).cos());
            let solid_angle = ((above - below) * TAU / f64::from(width)) as f32;
            let d = d.as_vec3();

            // What is brighter than the threshold shines as the sun.
            let ambient = light.min(Vec3::splat(threshold));
            let excess = light - ambient;
            sun_direction += d * excess.element_sum() * solid_angle;
            sun_light += excess * solid_angle / PI as f32;
            for (sum, basis) in harmonics.iter_mut().zip(harmonic_basis(d)) {
                *sum += ambient * basis * solid_angle;
            }
        }
        // Convolved with the clamped cosine (π, 2π/3, π/4 by order) and divided by π.
        let orders = [1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25];
        let normalisation =
            [0.282_095, 0.488_603, 0.488_603, 0.488_603, 1.092_548, 1.092_548, 0.315_392, 1.092_548, 0.546_274];
        let ambient = std::array::from_fn(|i| harmonics[i] * orders[i] * normalisation[i] * normalisation[i]);
        let has_sun = sun_direction.length() > 1e-6 && sun_direction.y > 0.0;
        let sun = has_sun.then(|| Sun { towards: sun_direction.normalize(), colour: sun_light });
        Self { panorama, sun, ambient }
    }

    /// What a white matt surface with this normal sends out under the sky without its sun.
    pub(crate) fn on_white(&self, normal: Vec3) -> Vec3 {
        harmonic_basis(normal).iter().zip(self.ambient).map(|(&basis, c)| c * basis).sum()
    }
}

/// The nine real spherical harmonics of order 0–2 without their factors.
fn harmonic_basis(d: Vec3) -> [f32; 9] {
    [1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.z * d.z - 1.0, d.x * d.z, d.x * d.x - d.y * d.y]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A white furnace stays white: E = π L, so that E/π = L on every normal.
    #[test]
    fn an_even_sky_lights_everything_alike() {
        let environment = Environment::of(Panorama { size: [64, 32], radiance: vec![Vec3::splat(0.7); 64 * 32] });
        assert_eq!(environment.sun, None);
        for normal in [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(1.0, -2.0, 0.5).normalize()] {
            let found = environment.on_white(normal);
            assert!((found - Vec3::splat(0.7)).abs().max_element() < 1e-3, "{normal}: {found}");
        }
    }

    /// Half a sky of radiance 1: E/π is 1 facing it, ½ sideways, 0 away (closed form (1 + cos θ)/2, which is linear in the
    /// normal and so exact up to order 2's ripple).
    #[test]
    fn half_a_sky_lights_by_the_cosine() {
        let environment = Environment::of(Panorama::painted(128, |d| Vec3::splat(f32::from(d.y > 0.0))));
        for degrees in [0.0_f32, 45.0, 90.0, 135.0, 180.0] {
            let normal = Vec3::new(degrees.to_radians().sin(), degrees.to_radians().cos(), 0.0);
            let expected = 0.5 * (1.0 + degrees.to_radians().cos());
            let found = environment.on_white(normal).x;
            println!("{degrees}°: {found:.4}, closed form {expected:.4}");
            assert!((found - expected).abs() < 0.02);
        }
    }

    #[test]
    fn a_bright_spot_becomes_the_sun() {
        let towards = Vec3::new(0.4, 0.8, -0.3).normalize();
        let panorama = Panorama::painted(256, |d| Vec3::splat(if d.dot(towards) > 0.999 { 2000.0 } else { 0.3 }));
        let sun = Environment::of(panorama).sun.expect("it is bright");
        assert!(sun.towards.angle_between(towards) < 0.01);
        // Solid angle 2π(1 − 0.999), less what stays in the sky.
        let expected = 2000.0 * 2.0 * PI as f32 * 0.001 / PI as f32;
        assert!((sun.colour.x / expected - 1.0).abs() < 0.1, "{} {expected}", sun.colour.x);
    }

    #[test]
    fn smaller_panoramas_keep_the_light() {
        let panorama = Panorama::painted(64, |d| Vec3::new(1.0 + d.x, 1.0 + d.y, 0.5));
        let flux = |p: &Panorama| {
            let sines: f64 = (0..p.size[0] * p.size[1]).map(|i| (1.0 - direction(i, p.size).y.powi(2)).sqrt()).sum();
            let sum =
                p.radiance.iter().zip(0..).map(|(c, i)| c.as_dvec3() * (1.0 - direction(i, p.size).y.powi(2)).sqrt());
            sum.sum::<DVec3>() / sines
        };
        for level in panorama.pyramid() {
            let off = (flux(&level) - flux(&panorama)).abs().max_element();
            assert!(off < 0.02, "{:?}: {off}", level.size);
        }
    }
}
