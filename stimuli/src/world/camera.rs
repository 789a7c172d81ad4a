//! The eye's path through a world: flying along keys, stopping to look left and right, or standing still (the camera
//! motions of Guenter et al. 2012, §5).

use super::Motion;
use glam::{Affine3A, DVec3};

/// Where the camera is and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    /// Metres.
    pub(crate) eye: DVec3,
    /// Unit vectors.
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) forward: DVec3,
}

impl Pose {
    /// At `eye`, looking towards `target`, with y up.
    pub(crate) fn looking(eye: DVec3, target: DVec3) -> Self {
        let forward = (target - eye).try_normalize().unwrap_or(DVec3::NEG_Z);
        let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        Self { eye, right, up: right.cross(forward), forward }
    }

    /// Looking along the −z axis of `at`, with its y axis up; scale and skew do not count.
    pub(crate) fn carried(at: &Affine3A) -> Self {
        let axes = at.matrix3;
        let forward = (-axes.z_axis.as_dvec3()).try_normalize().unwrap_or(DVec3::NEG_Z);
        let up = axes.y_axis.as_dvec3().reject_from_normalized(forward);
        let up = up.try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        Self { eye: at.translation.as_dvec3(), right: forward.cross(up), up, forward }
    }

    /// Turned about its own vertical, to the left for positive angles.
    #[must_use]
    fn turned(self, angle_deg: f64) -> Self {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        Self { forward: self.forward * cos - self.right * sin, right: self.right * cos + self.forward * sin, ..self }
    }
}

/// Places that the camera passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CameraKey {
    /// Seconds at the path's own pace; rising.
    pub(crate) time_s: f64,
    pub(crate) eye: DVec3,
    /// What it looks at.
    pub(crate) target: DVec3,
}

/// What the camera does on its path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum CameraMotion {
    /// Flies, this many times as fast as the path's own pace.
    Fly(f64),
    /// Stands and looks to both sides; so many degrees per second in the middle of the sweep.
    Pan(f64),
    /// Stands.
    Still,
}

/// How far a panning camera looks to either side, degrees.
const PAN_DEG: f64 = 15.0;

/// A path and how it is gone along.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CameraPath {
    /// The keys; after the last one the camera returns to the first, smoothly if they are the same place.
    pub(crate) keys: Vec<CameraKey>,
    /// What carries the camera instead of the keys, as a node of a file does: it looks along the carrier's −z axis, with
    /// its y axis up.
    pub(crate) carrier: Option<Motion>,
    pub(crate) motion: CameraMotion,
    /// Where on the path it starts, seconds at the path's own pace.
    pub(crate) start_s: f64,
}

impl Default for CameraPath {
    fn default() -> Self {
        let key = CameraKey { time_s: 0.0, eye: DVec3::ZERO, target: DVec3::NEG_Z };
        Self { keys: vec![key], carrier: None, motion: CameraMotion::Still, start_s: 0.0 }
    }
}

impl CameraPath {
    /// Flying through `places` of eye and target, one after the other, `pace_s` apart, and back to the first.
    pub(crate) fn round(places: &[(DVec3, DVec3)], pace_s: f64) -> Self {
        let closed = places.iter().chain(places.first());
        let keys = closed.zip(0..).map(|(&(eye, target), i)| CameraKey { time_s: f64::from(i) * pace_s, eye, target });
        Self { keys: keys.collect(), carrier: None, motion: CameraMotion::Fly(1.0), start_s: 0.0 }
    }

    /// Seconds that one round takes at the path's own pace.
    pub(crate) fn span_s(&self) -> f64 {
        match (self.keys.first(), self.keys.last()) {
            (Some(first), Some(last)) => last.time_s - first.time_s,
            _ => 0.0,
        }
    }

    /// Whether the camera is elsewhere, or looks elsewhere, at another time.
    pub(crate) fn moves(&self) -> bool {
        match self.motion {
            CameraMotion::Fly(pace) => {
                let leads_elsewhere = self.carrier.as_ref().map_or(self.keys.len() > 1, Motion::moves);
                pace.abs() > 0.0 && leads_elsewhere
            }
            CameraMotion::Pan(speed_deg_s) => speed_deg_s.abs() > 0.0,
            CameraMotion::Still => false,
        }
    }

    /// The pose at `animation_s`.
    pub(crate) fn pose(&self, animation_s: f64) -> Pose {
        match self.motion {
            CameraMotion::Fly(pace) => self.along(self.start_s + pace * animation_s),
            CameraMotion::Pan(speed_deg_s) => {
                self.along(self.start_s).turned(PAN_DEG * (speed_deg_s / PAN_DEG * animation_s).sin())
            }
            CameraMotion::Still => self.along(self.start_s),
        }
    }

    /// The pose on the path, by cubic curves through the keys (Catmull–Rom), whose speed has no jumps.
    fn along(&self, time_s: f64) -> Pose {
        if let Some(carrier) = &self.carrier {
            return Pose::carried(&carrier.at(time_s));
        }
        let count = self.keys.len();
        let (Some(first), span_s) = (self.keys.first(), self.span_s()) else {
            return Pose::looking(DVec3::ZERO, DVec3::NEG_Z);
        };
        if count < 2 || span_s <= 0.0 {
            return Pose::looking(first.eye, first.target);
        }
        let time_s = first.time_s + (time_s - first.time_s).rem_euclid(span_s);
        let next = self.keys.partition_point(|key| key.time_s <= time_s).clamp(1, count - 1);
        // The keys around, over the seam of a closed path.
        let at = |index: isize| &self.keys[index.rem_euclid(count as isize - 1) as usize];
        let near = [-2, -1, 0, 1].map(|offset| at(next as isize + offset));
        let (from_s, to_s) = (self.keys[next - 1].time_s, self.keys[next].time_s);
        let s = (time_s - from_s) / (to_s - from_s).max(1e-12);
        let curve = |of: fn(&CameraKey) -> DVec3| {
            let [a, b, c, d] = near.map(of);
            0.5 * (2.0 * b + s * ((c - a) + s * ((2.0 * a - 5.0 * b + 4.0 * c - d) + s * (3.0 * b - 3.0 * c + d - a))))
        };
        Pose::looking(curve(|key| key.eye), curve(|key| key.target))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> CameraPath {
        let places = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
            .map(|(x, z)| (DVec3::new(x, 1.0, z), DVec3::new(2.0, 1.0, 2.0)));
        CameraPath::round(&places, 2.0)
    }

    #[test]
    fn the_path_passes_its_keys_and_closes() {
        let path = square();
        for (i, key) in path.keys.iter().enumerate() {
            let pose = path.pose(2.0 * i as f64);
            assert!(pose.eye.distance(key.eye) < 1e-9, "key {i}: {:?}", pose.eye);
        }
        assert!(path.pose(-1.0).eye.distance(path.pose(7.0).eye) < 1e-9);
    }

    /// Position and speed change little over every thousandth of a second, the seam included.
    #[test]
    fn the_path_has_no_jumps() {
        let path = square();
        let step = 1e-3;
        let at = |i: i32| path.pose(f64::from(i) * step).eye;
        let worst = (0..8000).map(|i| (at(i + 1) - 2.0 * at(i) + at(i - 1)).length()).fold(0.0, f64::max);
        println!("largest second difference over 1 ms: {worst:.2e} m");
        assert!(worst < 2e-5);
    }

    /// A carrier that is turned by 90° about y, rolled by 30° and scaled: looks along −x, leaning by 30°.
    #[test]
    fn a_carried_camera_takes_its_carriers_place_and_roll() {
        use glam::{Quat, Vec3};
        let turn = Quat::from_rotation_y(90_f32.to_radians()) * Quat::from_rotation_z(30_f32.to_radians());
        let at = Affine3A::from_scale_rotation_translation(Vec3::new(2.0, 3.0, 0.5), turn, Vec3::new(1.0, 2.0, 3.0));
        let path =
            CameraPath { carrier: Some(Motion::Still(at)), motion: CameraMotion::Fly(1.0), ..CameraPath::default() };
        assert!(!path.moves());
        let pose = path.pose(3.0);
        assert!(pose.eye.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-6);
        assert!(pose.forward.distance(DVec3::NEG_X) < 1e-6, "{}", pose.forward);
        assert!(
            (pose.up.y - 30_f64.to_radians().cos()).abs() < 1e-6
                && pose.right.cross(pose.forward).distance(pose.up) < 1e-6
        );
    }

    #[test]
    fn a_panning_camera_sweeps_fifteen_degrees_and_stays_upright() {
        let path = CameraPath { motion: CameraMotion::Pan(30.0), ..square() };
        let straight = path.pose(0.0);
        let mut widest: f64 = 0.0;
        for i in 0..400 {
            let pose = path.pose(f64::from(i) * 0.01);
            widest = widest.max(pose.forward.angle_between(straight.forward).to_degrees());
            assert!(pose.forward.cross(pose.up).distance(pose.right) < 1e-9);
            assert!(pose.eye.distance(straight.eye) < 1e-12);
        }
        assert!((widest - 15.0).abs() < 0.01, "{widest}");
    }
}
