//! Where the eye looks while frames are measured: at the centre, over the display in a fixed order of fixations and
//! saccades, or where a recorded eye looked.

use crate::gaze::{GazeSample, GazeSource, Recorded};
use experiments::Display;

/// How long each place of the sweep is fixated, seconds.
const FIXATION_S: f64 = 0.2;
/// Duration of a saccade: 2.2 ms for each degree and 21 ms (Carpenter 1988, Movements of the Eyes, ch. 4).
const SACCADE_S: [f64; 2] = [0.021, 0.0022];
/// Places that the sweep visits, as shares of half the field, so that every layer moves, small steps and large ones occur,
/// and the outermost places bring the foveal layer to the display's edge.
const PLACES: [[f64; 2]; 8] =
    [[0.0, 0.0], [0.3, 0.2], [-0.6, 0.3], [-0.5, -0.5], [0.9, 0.0], [0.7, 0.8], [0.0, -0.4], [-0.9, 0.9]];

/// A gaze as a function of time.
#[derive(Debug, Clone, PartialEq)]
pub struct GazePath {
    name: String,
    path: Path,
}

#[derive(Debug, Clone, PartialEq)]
enum Path {
    Centre,
    /// Places in degrees; after the last comes the first.
    Sweep(Vec<[f64; 2]>),
    /// When the program could know of a place, and the place in degrees.
    Recorded(Vec<(f64, [f64; 2])>),
}

impl GazePath {
    /// An eye that stays at the display's centre.
    #[must_use]
    pub fn centre() -> Self {
        Self { name: "centre".to_owned(), path: Path::Centre }
    }

    /// An eye that fixates eight places of the display for 0.2 s each, again and again, with saccades in between.
    #[must_use]
    pub fn sweep(display: &Display) -> Self {
        let half_deg = display.half_field_deg();
        let places = PLACES.iter().map(|place| [0, 1].map(|axis| place[axis] * half_deg[axis])).collect();
        Self { name: "sweep".to_owned(), path: Path::Sweep(places) }
    }

    /// The eye of the gaze file `file` with the content `text`, of which the first `needed_s` seconds are used. While it
    /// is lost it stays where it was seen last.
    ///
    /// # Errors
    /// Every mistake of the file, one line each, or that it is too short.
    pub fn recorded(file: &str, text: &str, display: &Display, needed_s: f64) -> Result<Self, Vec<String>> {
        let source = Recorded::parse(file, text, display)
            .map_err(|mistakes| mistakes.iter().map(ToString::to_string).collect::<Vec<_>>())?;
        Self::played_back(file, source, display, needed_s)
    }

    /// The eye of a recording named `file`, as [`Self::recorded`].
    ///
    /// # Errors
    /// That it is too short, or that the eye was never seen.
    pub fn played_back(
        file: &str,
        mut source: Recorded,
        display: &Display,
        needed_s: f64,
    ) -> Result<Self, Vec<String>> {
        let mut samples: Vec<GazeSample> = Vec::new();
        source.poll(f64::MAX, &mut samples);
        let duration_s = samples.last().map_or(0.0, |sample| sample.t_s);
        if duration_s < needed_s {
            return Err(vec![format!(
                "{file}: expected gaze for the {needed_s:.2} s that are rendered, found {duration_s:.2} s"
            )]);
        }
        let seen = samples.iter().filter(|sample| sample.valid);
        let places: Vec<_> = seen.map(|sample| (sample.arrived_s, display.deg_from_px(sample.px))).collect();
        if places.is_empty() {
            return Err(vec![format!("{file}: expected gaze, found that the eye was never seen")]);
        }
        Ok(Self { name: format!("recorded:{file}"), path: Path::Recorded(places) })
    }

    /// Its name, as the command line has it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The place at `t_s` seconds, degrees from the display's centre, x right, y up.
    #[must_use]
    pub fn at(&self, t_s: f64) -> [f64; 2] {
        match &self.path {
            Path::Centre => [0.0; 2],
            Path::Sweep(places) => swept(places, t_s),
            // What has arrived by now; before the first sample, that one.
            Path::Recorded(samples) => {
                let arrived = samples.partition_point(|(arrived_s, _)| *arrived_s <= t_s);
                samples.get(arrived.saturating_sub(1)).map_or([0.0; 2], |(_, place)| *place)
            }
        }
    }
}

/// Where the sweep over `places` is at `t_s`.
fn swept(places: &[[f64; 2]], t_s: f64) -> [f64; 2] {
    let legs =
        || places.iter().zip(places.iter().cycle().skip(1)).map(|(from, to)| (*from, *to, saccade_s(*from, *to)));
    let round_s: f64 = legs().map(|(_, _, saccade_s)| FIXATION_S + saccade_s).sum();
    let mut left_s = t_s.rem_euclid(round_s);
    for (from, to, saccade_s) in legs() {
        if left_s < FIXATION_S {
            return from;
        }
        left_s -= FIXATION_S;
        if left_s < saccade_s {
            // The smoothest way from rest to rest (Flash and Hogan 1985).
            let u = left_s / saccade_s;
            let share = u * u * u * (10.0 + u * (6.0 * u - 15.0));
            return [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        }
        left_s -= saccade_s;
    }
    places.first().copied().unwrap_or_default()
}

fn saccade_s(from: [f64; 2], to: [f64; 2]) -> f64 {
    SACCADE_S[0] + SACCADE_S[1] * (to[0] - from[0]).hypot(to[1] - from[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn display() -> Display {
        Display::new("test", [160, 90], [100.0, 56.0], 300.0).unwrap()
    }

    #[test]
    fn the_sweep_rests_moves_smoothly_and_comes_round() {
        let path = GazePath::sweep(&display());
        assert_eq!(path.at(0.0), [0.0; 2]);
        assert_eq!(path.at(0.199), [0.0; 2]);
        // No step of a millisecond is faster than a saccade's peak, 1.875 times its mean speed, and some are fast.
        let speeds: Vec<f64> = (0..3000)
            .map(|ms| {
                let [a, b] = [ms, ms + 1].map(|ms| path.at(f64::from(ms) * 1e-3));
                (b[0] - a[0]).hypot(b[1] - a[1]) * 1e3
            })
            .collect();
        let fastest = speeds.iter().copied().fold(0.0, f64::max);
        let resting = speeds.iter().filter(|speed| **speed == 0.0).count();
        println!("fastest {fastest:.0}°/s, at rest {resting} of 3000 ms");
        assert!((200.0..1.875 / SACCADE_S[1]).contains(&fastest), "{fastest}");
        assert!((2000..2900).contains(&resting), "{resting}");
        // Everything is on the display, and every place is visited.
        let half = display().half_field_deg();
        for place in PLACES {
            let at = [place[0] * half[0], place[1] * half[1]];
            assert!((0..3000).any(|ms| path.at(f64::from(ms) * 1e-3) == at), "{place:?}");
        }
    }

    #[test]
    fn a_recorded_gaze_is_known_when_it_arrives_and_kept_while_it_is_lost() {
        let text = "t_s,arrived_s,x_deg,y_deg,valid\n5.0,5.1,1,2,1\n5.2,5.3,3,4,1\n5.4,5.5,,,0\n6.0,6.0,5,6,1\n";
        let path = GazePath::recorded("eye.csv", text, &display(), 1.0).unwrap();
        for (t_s, expected) in
            [(0.0, [1.0, 2.0]), (0.29, [1.0, 2.0]), (0.31, [3.0, 4.0]), (0.6, [3.0, 4.0]), (1.01, [5.0, 6.0])]
        {
            let found = path.at(t_s);
            assert!((0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-9), "{t_s}: {found:?}");
        }
        let short = GazePath::recorded("eye.csv", text, &display(), 9.0).unwrap_err();
        assert!(short[0].contains("expected gaze for the 9.00 s"), "{short:?}");
        let wrong = GazePath::recorded("eye.csv", "t_s,x_deg,y_deg\n0,a,1\n1,b,2\n", &display(), 0.5).unwrap_err();
        assert_eq!(wrong.len(), 2, "{wrong:?}");
    }
}
