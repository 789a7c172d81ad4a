//! Painted surroundings: a sky with a sun, clouds and mountains at the horizon, as a panorama that both is seen and
//! lights a world.

use super::noise::{clouds, ridges, smoothstep};
use crate::world::Panorama;
use glam::Vec3;

/// What a sky looks like. Colours are linear radiances.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sky {
    /// Towards the sun; need not be a unit vector.
    pub(crate) sun_towards: Vec3,
    /// What a white matt surface that faces the sun sends out of its light.
    pub(crate) sun_colour: Vec3,
    pub(crate) zenith: Vec3,
    pub(crate) horizon: Vec3,
    /// Below the horizon.
    pub(crate) ground: Vec3,
    /// Share of the sky under clouds, 0–1.
    pub(crate) clouds: f32,
    /// How high the mountains rise over the horizon, as a tangent; none at 0.
    pub(crate) mountains: f32,
    pub(crate) seed: u32,
}

/// Cosine of the radius of the sun's disc, which is larger than the true sun's so that small panoramas hold it.
const SUN_COS: f32 = 0.9996;

impl Sky {
    /// The panorama, `width` pixels wide.
    pub(crate) fn paint(&self, width: u32) -> Panorama {
        let towards = self.sun_towards.normalize_or(Vec3::Y);
        Panorama::painted(width, |d| self.radiance(d, towards))
    }

    fn radiance(&self, d: Vec3, sun: Vec3) -> Vec3 {
        let flat = Vec3::new(d.x, 0.0, d.z).normalize_or(Vec3::X);
        let slope = d.y / (1.0 - d.y * d.y).max(1e-6).sqrt();
        if slope < -0.02 || (slope < 0.0 && self.mountains <= 0.0) {
            return self.ground.lerp(self.horizon, (1.0 + 12.0 * slope).max(0.0) * 0.6);
        }
        let mut colour = self.open(d, sun);
        if slope > 1.3 * self.mountains {
            return colour;
        }
        // Three ranges from far to near, the farther the paler and the higher; their crests are as soft as a pixel.
        for (range, reach) in [(2, 1.0), (1, 0.75), (0, 0.45)] {
            let seed = self.seed.wrapping_add(71 * range);
            let line = self.mountains * reach * (0.25 + 0.75 * ridges(3.0 * flat, 4, seed).powf(1.4));
            let cover = smoothstep(line + 0.003, line - 0.003, slope);
            if cover > 0.0 {
                colour = colour.lerp(self.mountain(d, slope / line.max(1e-6), range, sun), cover);
            }
        }
        colour
    }

    /// Rock below and snow above, lit from the sun's side, and paled by the air before it.
    fn mountain(&self, d: Vec3, height: f32, range: u32, sun: Vec3) -> Vec3 {
        let seed = self.seed.wrapping_add(71 * range);
        let at = Vec3::new(14.0 * d.x, 30.0 * d.y, 14.0 * d.z);
        let rough = ridges(at, 3, seed.wrapping_add(9));
        // The slope towards the light from the change of the relief along the horizon to the sun.
        let across = Vec3::new(sun.x, 0.4, sun.z).normalize_or(Vec3::X);
        let light = 0.55 + 2.2 * (rough - ridges(at + 0.12 * across, 3, seed.wrapping_add(9)));
        let snow = smoothstep(0.45, 0.7, height + 0.5 * (rough - 0.5)) * f32::from(range > 0);
        let rock = Vec3::new(0.13, 0.14, 0.13).lerp(Vec3::new(0.10, 0.16, 0.06), 1.0 - height.clamp(0.0, 1.0));
        let lit = rock.lerp(Vec3::splat(0.85), snow) * light.clamp(0.15, 1.1) * self.sun_colour.max(Vec3::splat(0.3));
        let air = [0.18, 0.42, 0.62][range.min(2) as usize];
        lit.lerp(self.horizon, air).lerp(self.horizon, 0.35 * (1.0 - height.clamp(0.0, 1.0)))
    }

    fn open(&self, d: Vec3, sun: Vec3) -> Vec3 {
        let up = d.y.max(0.0);
        let cos = d.dot(sun);
        let mut sky = self.zenith.lerp(self.horizon, (1.0 - up).powi(4));
        // Forward scattering about the sun.
        let glow = 0.10 * cos.max(0.0).powi(8) + 0.35 * cos.max(0.0).powi(90);
        sky += glow * self.sun_colour;
        let cover = if self.clouds > 0.0 && up > 0.01 {
            // Clouds lie on a flat layer: smaller and denser towards the horizon.
            let layer = Vec3::new(d.x, 0.0, d.z) / (up + 0.12);
            let n = 0.5 + 0.6 * clouds(1.1 * layer, 4, self.seed) + 0.15 * clouds(0.35 * layer, 2, self.seed ^ 5);
            let amount = smoothstep(1.0 - self.clouds, 1.35 - self.clouds, n) * smoothstep(0.01, 0.12, up);
            // Their undersides are darker where they are thick, and their rims shine towards the sun.
            let thick = smoothstep(1.0 - self.clouds, 1.9 - self.clouds, n);
            let white = self.horizon.max_element().max(0.2);
            let rim = 1.0 + 0.6 * cos.max(0.0).powi(6);
            let shade = Vec3::new(1.25, 1.25, 1.27).lerp(Vec3::new(0.62, 0.67, 0.76), thick) * white * rim;
            sky = sky.lerp(shade, 0.92 * amount);
            amount
        } else {
            0.0
        };
        if cos > SUN_COS {
            // The disc's solid angle over π makes of its radiance the light on a surface.
            sky += self.sun_colour / (2.0 * (1.0 - SUN_COS)) * (1.0 - 0.5 * cover);
        }
        sky
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Environment;

    #[test]
    fn the_painted_sun_shines_as_asked() {
        let towards = Vec3::new(0.5, 0.6, -0.3);
        let sky = Sky {
            sun_towards: towards,
            sun_colour: Vec3::new(2.0, 1.8, 1.5),
            zenith: Vec3::new(0.15, 0.3, 0.7),
            horizon: Vec3::new(0.6, 0.7, 0.85),
            ground: Vec3::splat(0.2),
            clouds: 0.0,
            mountains: 0.2,
            seed: 4,
        };
        let environment = Environment::of(sky.paint(512));
        let sun = environment.sun.expect("there is one");
        println!("{:.2}° off, colour {}", sun.towards.angle_between(towards.normalize()).to_degrees(), sun.colour);
        assert!(sun.towards.angle_between(towards.normalize()) < 0.01);
        assert!((sun.colour / sky.sun_colour - Vec3::ONE).abs().max_element() < 0.15);
    }
}
