//! The camera of the procedural scenes: the parameters that all of them have, and closed paths gone along at an even pace.

use crate::contract::MakeError;
use crate::parameters::{number, text};
use crate::world::CameraPath;
use crate::world::camera::CameraMotion;
use experiments::catalogue::{ParameterSchema, Parameters};
use glam::DVec3;

/// How fast a panning camera turns in the middle of its sweep at a speed of 1, degrees per second.
const PAN_DEG_S: f64 = 10.0;

/// What can be set of every procedural scene's camera. The study of Guenter et al. 2012, §5, flew at six speeds, stopped
/// and panned, and stood still.
pub(crate) fn schemas() -> Vec<ParameterSchema> {
    vec![
        ParameterSchema::choice(
            "camera",
            &["fly", "pan", "static"],
            "The camera's motion: it flies along its closed path, or stops where it starts and looks left and right, or \
             stands still.",
        ),
        ParameterSchema::number(
            "camera_speed",
            "",
            0.1..=8.0,
            1.0,
            "How many times as fast as the path's own pace the camera flies; panning, how many times 10 degrees per \
             second it turns at most.",
        ),
        ParameterSchema::number(
            "camera_start_s",
            "s",
            0.0..=1000.0,
            0.0,
            "Where on its path the camera starts: seconds at the path's own pace; the path begins anew at its end.",
        ),
    ]
}

/// `path` with the motion, speed and start that were asked for.
///
/// # Errors
/// When a parameter is absent, which would be a mistake in [`schemas`].
pub(crate) fn set(mut path: CameraPath, parameters: &Parameters) -> Result<CameraPath, MakeError> {
    let speed = number(parameters, "camera_speed")?;
    path.motion = match text(parameters, "camera")? {
        "static" => CameraMotion::Still,
        "pan" => CameraMotion::Pan(PAN_DEG_S * speed),
        _ => CameraMotion::Fly(speed),
    };
    path.start_s = number(parameters, "camera_start_s")?;
    Ok(path)
}

/// A closed path through `places` of eye and target at `speed_m_s`, smooth and everywhere as fast.
pub(crate) fn round(places: &[(DVec3, DVec3)], speed_m_s: f64) -> CameraPath {
    /// Samples of the curve between two places.
    const FINE: usize = 64;
    /// Metres between the keys that are kept.
    const KEY_M: f64 = 1.0;
    let curve = CameraPath::round(places, 1.0);
    let count = places.len() * FINE;
    let at = |i: usize| curve.pose(curve.span_s() * i as f64 / count as f64);
    // Length of the curve up to every sample.
    let mut lengths_m = vec![0.0];
    let mut before = at(0).eye;
    for i in 1..=count {
        let eye = at(i).eye;
        lengths_m.push(lengths_m[i - 1] + eye.distance(before));
        before = eye;
    }
    let length_m = lengths_m[count];
    let keys = (length_m / KEY_M).ceil().max(1.0) as usize;
    let even: Vec<(DVec3, DVec3)> = (0..keys)
        .map(|k| {
            let wanted = length_m * k as f64 / keys as f64;
            let after = lengths_m.partition_point(|&m| m <= wanted).clamp(1, count);
            let within = (wanted - lengths_m[after - 1]) / (lengths_m[after] - lengths_m[after - 1]).max(1e-12);
            let pose = curve.pose(curve.span_s() * (after as f64 - 1.0 + within) / count as f64);
            (pose.eye, pose.eye + pose.forward)
        })
        .collect();
    CameraPath::round(&even, length_m / keys as f64 / speed_m_s)
}

/// A closed path through `eyes` at `speed_m_s` that looks to where it will be `ahead_m` further on, with that direction, a
/// unit vector, changed by `look`.
pub(crate) fn ahead(eyes: &[DVec3], ahead_m: f64, speed_m_s: f64, look: impl Fn(DVec3) -> DVec3) -> CameraPath {
    let still: Vec<_> = eyes.iter().map(|&eye| (eye, eye)).collect();
    let path = round(&still, speed_m_s);
    let ahead_s = ahead_m / speed_m_s;
    let keys = path.keys.len().saturating_sub(1);
    let places: Vec<_> = path.keys[..keys]
        .iter()
        .map(|key| (key.eye, path.pose(key.time_s + ahead_s).eye))
        .map(|(eye, target)| (eye, eye + look((target - eye).normalize_or(DVec3::NEG_Z))))
        .collect();
    CameraPath::round(&places, path.span_s() / keys.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pace_is_even() {
        let places = [(0.0, 0.0), (30.0, 0.0), (33.0, 12.0), (-5.0, 20.0)].map(|(x, z)| DVec3::new(x, 2.0, z));
        let path = ahead(&places, 5.0, 1.5, |along| along);
        let step_s = 0.05;
        let speeds: Vec<f64> = (0..(path.span_s() / step_s) as usize)
            .map(|i| {
                let t = i as f64 * step_s;
                path.pose(t).eye.distance(path.pose(t + step_s).eye) / step_s
            })
            .collect();
        let (low, high) = speeds.iter().fold((f64::MAX, 0.0_f64), |(l, h), &s| (l.min(s), h.max(s)));
        println!("{low:.3} to {high:.3} m/s over {:.0} s", path.span_s());
        assert!(low > 1.35 && high < 1.65);
        // It looks where it goes.
        for i in 0..20 {
            let pose = path.pose(f64::from(i));
            let there = path.pose(f64::from(i) + 5.0 / 1.5).eye;
            assert!(pose.forward.dot((there - pose.eye).normalize()) > 0.99);
        }
    }
}
