//! The mouse as an eye tracker: the cursor is where the observer looks.
//!
//! The window feeds it its cursor events. A still mouse sends none, so each poll repeats the last position: the gaze
//! stays valid, and its age stays true.

use super::{GazeSample, GazeSource};
use experiments::Display;
use serde_json::json;
use std::collections::VecDeque;

/// Events kept between two polls; a 1000 Hz mouse fills this in a minute without a single frame.
const MAX_WAITING: usize = 65_536;

/// A gaze source fed by cursor events.
#[derive(Debug)]
pub struct Mouse {
    waiting: VecDeque<GazeSample>,
    last_event_s: f64,
    last: GazeSample,
    discarded: u64,
}

impl Mouse {
    /// A mouse whose cursor has not been seen yet: its samples are invalid, at the display's centre, until it moves.
    #[must_use]
    pub fn new(display: &Display) -> Self {
        let last = GazeSample {
            t_s: f64::NEG_INFINITY,
            arrived_s: f64::NEG_INFINITY,
            t_device_s: f64::NEG_INFINITY,
            px: display.resolution_px().map(|extent| 0.5 * f64::from(extent)),
            valid: false,
            pupil_mm: None,
            left: None,
            right: None,
        };
        Self { waiting: VecDeque::new(), last_event_s: f64::NEG_INFINITY, last, discarded: 0 }
    }

    /// The cursor is at `px` (display pixels) at `now_s` (session seconds). Values that are not finite are ignored.
    pub fn moved(&mut self, now_s: f64, px: [f64; 2]) {
        if px.iter().all(|x| x.is_finite()) {
            self.event(now_s, px, true);
        }
    }

    /// The cursor has left the window at `now_s` (session seconds): samples are invalid until it moves again.
    pub fn left(&mut self, now_s: f64) {
        let px = self.waiting.back().unwrap_or(&self.last).px;
        self.event(now_s, px, false);
    }

    /// How many events were discarded, oldest first, because nothing polled for a very long time.
    #[must_use]
    pub fn discarded(&self) -> u64 {
        self.discarded
    }

    fn event(&mut self, now_s: f64, px: [f64; 2], valid: bool) {
        if !now_s.is_finite() {
            return;
        }
        // Window events may be stamped after a poll of the same instant; time never runs backwards here.
        let t_s = now_s.max(self.last_event_s).max(self.last.t_s);
        self.last_event_s = t_s;
        if self.waiting.len() == MAX_WAITING {
            self.waiting.pop_front();
            self.discarded += 1;
        }
        self.waiting.push_back(at(self.last, t_s, px, valid));
    }
}

fn at(sample: GazeSample, t_s: f64, px: [f64; 2], valid: bool) -> GazeSample {
    GazeSample { t_s, arrived_s: t_s, t_device_s: t_s, px, valid, ..sample }
}

impl GazeSource for Mouse {
    fn id(&self) -> &'static str {
        "mouse"
    }

    fn describe(&self) -> serde_json::Value {
        json!({
            "id": self.id(),
            "about": "cursor events, and the last position again at each poll",
            "device_clock": "session clock",
        })
    }

    fn poll(&mut self, now_s: f64, out: &mut Vec<GazeSample>) {
        if !now_s.is_finite() {
            return;
        }
        while let Some(sample) = self.waiting.pop_front_if(|sample| sample.arrived_s <= now_s) {
            self.last = sample;
            out.push(sample);
        }
        if self.last.t_s < now_s {
            self.last = at(self.last, now_s, self.last.px, self.last.valid);
            out.push(self.last);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mouse() -> Mouse {
        Mouse::new(&Display::named("demo-540p").expect("ships"))
    }

    fn polled(mouse: &mut Mouse, now_s: f64) -> Vec<GazeSample> {
        let mut out = Vec::new();
        mouse.poll(now_s, &mut out);
        out
    }

    #[test]
    fn before_the_first_event_samples_are_invalid_and_at_the_centre() {
        let samples = polled(&mut mouse(), 0.5);
        assert_eq!(samples.len(), 1);
        assert!(!samples[0].valid);
        assert_eq!(samples[0].px, [480.0, 270.0]);
    }

    #[test]
    fn each_event_is_one_sample_and_a_still_mouse_stays_valid() {
        let mut mouse = mouse();
        mouse.moved(0.010, [1.0, 2.0]);
        mouse.moved(0.012, [3.0, 4.0]);
        mouse.moved(0.050, [5.0, 6.0]);
        let first = polled(&mut mouse, 0.020);
        assert_eq!(first.iter().map(|s| s.t_s).collect::<Vec<_>>(), [0.010, 0.012, 0.020]);
        assert_eq!(first[2].px, [3.0, 4.0]);
        assert!(first.iter().all(|s| s.valid));
        assert!(polled(&mut mouse, 0.020).is_empty(), "nothing twice");
        let later = polled(&mut mouse, 0.050);
        assert_eq!(later.len(), 1, "an event at the instant of the poll is not repeated");
        assert_eq!(later[0].px, [5.0, 6.0]);
    }

    #[test]
    fn leaving_the_window_is_a_loss() {
        let mut mouse = mouse();
        mouse.moved(0.1, [1.0, 2.0]);
        mouse.left(0.2);
        let samples = polled(&mut mouse, 0.3);
        assert_eq!(samples.iter().map(|s| s.valid).collect::<Vec<_>>(), [true, false, false]);
        assert_eq!(samples[2].px, [1.0, 2.0]);
        mouse.moved(0.4, [7.0, 8.0]);
        assert!(polled(&mut mouse, 0.4)[0].valid);
    }

    #[test]
    fn impossible_events_and_clocks_change_nothing() {
        let mut mouse = mouse();
        mouse.moved(f64::NAN, [1.0, 2.0]);
        mouse.moved(0.1, [f64::INFINITY, 2.0]);
        assert!(polled(&mut mouse, f64::NAN).is_empty());
        assert!(!polled(&mut mouse, 1.0)[0].valid);
        mouse.moved(0.5, [1.0, 2.0]);
        assert_eq!(polled(&mut mouse, 1.0)[0].t_s, 1.0, "a late stamp is moved to the last poll");
    }

    #[test]
    fn memory_is_bounded_and_what_it_costs_is_counted() {
        let mut mouse = mouse();
        for i in 0..MAX_WAITING + 10 {
            mouse.moved(i as f64 * 1e-3, [1.0, 2.0]);
        }
        assert_eq!(mouse.discarded(), 10);
        assert_eq!(polled(&mut mouse, 1.0)[0].t_s, 0.010);
    }
}
