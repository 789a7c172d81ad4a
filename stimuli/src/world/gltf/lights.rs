//! Lights of a file (KHR_lights_punctual), brought to the sky's scale: the file's are in lux and candela, and say nothing
//! of the exposure with which they are to be seen.

use super::document;
use super::errors::Findings;
use crate::world::Light;
use glam::{Affine3A, Vec3};
use std::f32::consts::PI;

/// A light fades to nothing where a white surface sends out less than this.
const FAINT: f32 = 1e-3;
/// What a white surface in the middle of the world may send out in all lights together before they are scaled.
const USUAL: std::ops::RangeInclusive<f32> = 0.1..=4.0;
/// What they are scaled to.
const SCALED_TO: f32 = 1.0;
/// The greatest intensity that is taken.
const MOST_INTENSITY: f32 = 1e12;

/// The light that the node at `at` carries.
pub(crate) fn light(light: &document::Light, at: &Affine3A, place: &str, findings: &mut Findings) -> Option<Light> {
    let colour = Vec3::from(light.color) * light.intensity;
    if !(colour.is_finite() && colour.min_element() >= 0.0 && colour.max_element() <= MOST_INTENSITY) {
        findings.wrong(place, format!("its light of {colour} is out of range; expected 0 to {MOST_INTENSITY}"));
        return None;
    }
    if let Some(range) = light.range.filter(|range| !(f32::MIN_POSITIVE..).contains(range)) {
        findings.wrong(format!("{place}.range"), format!("it is {range}; expected more than 0 metres"));
        return None;
    }
    // A white surface that faces a light of E lux sends out E/π.
    let colour = colour / PI;
    match light.kind.as_str() {
        "directional" => {
            let towards = Vec3::from(at.matrix3.z_axis).try_normalize().unwrap_or(Vec3::Z);
            Some(Light::Directional { towards, colour })
        }
        "point" | "spot" => {
            if light.kind == "spot" {
                findings.note(place, "a spot light shines to all sides here");
            }
            let reach_m = light.range.unwrap_or(f32::INFINITY);
            Some(Light::Point { at: at.translation.into(), colour, reach_m })
        }
        kind => {
            let kind = super::accessors::shown(kind);
            findings.wrong(format!("{place}.type"), format!("\"{kind}\" is none of directional, point, spot"));
            None
        }
    }
}

/// Scales lights that would leave the world dark or blind, all by one factor, and gives those without a range one.
pub(crate) fn scale(lights: &mut [Light], bounds: Option<[Vec3; 2]>, findings: &mut Findings) {
    let [low, high] = bounds.unwrap_or([Vec3::ZERO; 2]);
    let (middle, radius) = (0.5 * (low + high), 0.5 * low.distance(high));
    let there = |light: &Light| match light {
        Light::Directional { colour, .. } => colour.max_element(),
        Light::Point { at, colour, .. } => {
            colour.max_element() / at.distance(middle).max(0.3 * radius).max(1e-3).powi(2)
        }
        Light::Area { .. } => 0.0,
    };
    let found: f32 = lights.iter().map(there).sum();
    let factor = if found > 0.0 && found.is_finite() && !USUAL.contains(&found) { SCALED_TO / found } else { 1.0 };
    if factor != 1.0 {
        findings.note(
            "extensions.KHR_lights_punctual",
            format!("the lights are made {factor:.3e} times as bright, to suit the sky's"),
        );
    }
    for light in lights {
        match light {
            Light::Directional { colour, .. } | Light::Area { colour, .. } => *colour *= factor,
            Light::Point { colour, reach_m, .. } => {
                *colour *= factor;
                *reach_m = reach_m.min((colour.max_element() / FAINT).sqrt()).max(1e-3);
            }
        }
    }
}
