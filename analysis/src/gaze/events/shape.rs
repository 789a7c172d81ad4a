//! A run of samples measured as a saccade or as a fixation.

use super::segments::Track;
use super::{Fixation, Saccade};
use crate::gaze::direction::{Plane, angle_deg, deg_from_direction, mean_direction, squared_angle_deg2};
use std::ops::Range;

/// A run of fast samples, measured. `speed_deg_s` tells the velocity of a sample.
pub(super) fn saccade(
    track: &Track,
    segment: &Range<usize>,
    run: &Range<usize>,
    speed_deg_s: impl Fn(usize) -> f64,
) -> Saccade {
    let last = run.end - 1;
    let complete = run.start > segment.start && run.end < segment.end;
    // The samples next to it are the eye at rest; where there is none, the run's own end has to do.
    let before = if run.start > segment.start { run.start - 1 } else { run.start };
    let after = if run.end < segment.end { run.end } else { last };
    let (from, to) = (track.direction[before], track.direction[after]);
    let plane = Plane::new(from);
    let way_deg = plane.step_deg(to);
    Saccade {
        onset_s: track.t_s[run.start],
        offset_s: track.t_s[last],
        duration_s: track.duration_s(run),
        amplitude_deg: angle_deg(from, to),
        excursion_deg: {
            let [right, up] = extent_deg(track, run, &plane);
            right.hypot(up)
        },
        peak_velocity_deg_s: run.clone().map(speed_deg_s).fold(0.0, f64::max),
        direction_deg: way_deg[1].atan2(way_deg[0]).to_degrees(),
        from_deg: deg_from_direction(from),
        to_deg: deg_from_direction(to),
        complete,
    }
}

/// A run of slow samples, measured; `None` for no samples.
pub(super) fn fixation(track: &Track, segment: &Range<usize>, run: &Range<usize>) -> Option<Fixation> {
    let centroid = mean_direction(track.direction[run.clone()].iter().copied())?;
    let plane = Plane::new(centroid);
    let [right, up] = extent_deg(track, run, &plane);
    let squares: f64 = track.direction[run.clone()].iter().map(|&d| squared_angle_deg2(centroid, d)).sum();
    Some(Fixation {
        onset_s: track.t_s[run.start],
        offset_s: track.t_s[run.end - 1],
        duration_s: track.duration_s(run),
        centroid_deg: deg_from_direction(centroid),
        dispersion_deg: right + up,
        sd_deg: (squares / run.len() as f64).sqrt(),
        samples: run.len(),
        complete: run.start > segment.start && run.end < segment.end,
    })
}

/// How far a run's samples reach from left to right and from bottom to top of a plane, degrees.
fn extent_deg(track: &Track, run: &Range<usize>, plane: &Plane) -> [f64; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for &direction in &track.direction[run.clone()] {
        let step = plane.step_deg(direction);
        for axis in 0..2 {
            low[axis] = low[axis].min(step[axis]);
            high[axis] = high[axis].max(step[axis]);
        }
    }
    [0, 1].map(|axis| (high[axis] - low[axis]).max(0.0))
}
