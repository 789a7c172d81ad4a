//! Where in a log one looks, and how that place moves: playing at a speed, stepping, seeking. No clock and no window.
//!
//! Places are seconds on the timeline's axis ([`super::timeline::Axis`]), on which hours without a frame take a second.

use std::sync::Arc;

/// The speeds there are, times real time.
pub const SPEEDS: [f64; 8] = [0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 4.0, 8.0];
/// The place of real time among them.
const REAL_TIME: usize = 3;

/// A place in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Player {
    /// When each frame was presented, on the axis, not decreasing.
    frames: Arc<[f64]>,
    /// The first frame of each trial, in order.
    trials: Arc<[usize]>,
    frame: usize,
    place: f64,
    playing: bool,
    speed: usize,
}

impl Player {
    /// A player at the first of frames that were presented at these places.
    #[must_use]
    pub fn new(frames: Arc<[f64]>, trials: Arc<[usize]>) -> Self {
        let place = frames.first().copied().unwrap_or(0.0);
        Self { frames, trials, frame: 0, place, playing: false, speed: REAL_TIME }
    }

    /// The frame that is looked at, counted from 0 among the logged ones.
    #[must_use]
    pub fn frame(&self) -> usize {
        self.frame
    }

    /// The place on the axis, seconds.
    #[must_use]
    pub fn place(&self) -> f64 {
        self.place
    }

    /// Whether it plays.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// How fast it plays, times real time.
    #[must_use]
    pub fn speed(&self) -> f64 {
        SPEEDS[self.speed]
    }

    /// Plays, or stops. At the end it plays from the beginning.
    pub fn toggle(&mut self) {
        if !self.playing && self.frame + 1 >= self.frames.len() {
            self.go_to(0);
        }
        self.playing = !self.playing && self.frames.len() > 1;
    }

    /// The next speed up or down.
    pub fn change_speed(&mut self, faster: bool) {
        self.speed = if faster { (self.speed + 1).min(SPEEDS.len() - 1) } else { self.speed.saturating_sub(1) };
    }

    /// Lets time pass while it plays; it stops at the last frame.
    pub fn advance(&mut self, seconds: f64) {
        if !self.playing || !seconds.is_finite() || seconds < 0.0 {
            return;
        }
        let last = self.frames.last().copied().unwrap_or(0.0);
        self.place = (self.place + seconds * self.speed()).min(last);
        self.frame = self.frame_at(self.place);
        if self.frame + 1 >= self.frames.len() {
            self.playing = false;
        }
    }

    /// Moves by a number of frames and stops.
    pub fn step(&mut self, frames: isize) {
        let last = self.frames.len().saturating_sub(1);
        self.go_to(self.frame.saturating_add_signed(frames).min(last));
        self.playing = false;
    }

    /// Goes to the frame that was seen at a place.
    pub fn seek(&mut self, place: f64) {
        if place.is_finite() {
            self.go_to(self.frame_at(place));
        }
    }

    /// Goes to the first frame of the next trial, or of this one and then the ones before.
    pub fn step_trial(&mut self, forward: bool) {
        let next = self.trials.partition_point(|&first| first <= self.frame);
        let target = if forward {
            self.trials.get(next)
        } else {
            let before = self.trials.partition_point(|&first| first < self.frame);
            before.checked_sub(1).and_then(|at| self.trials.get(at))
        };
        if let Some(&target) = target {
            self.go_to(target);
        }
    }

    /// Goes to a frame; beyond the last one to the last one.
    pub fn go_to(&mut self, frame: usize) {
        self.frame = frame.min(self.frames.len().saturating_sub(1));
        self.place = self.frames.get(self.frame).copied().unwrap_or(0.0);
    }

    fn frame_at(&self, place: f64) -> usize {
        self.frames.partition_point(|&presented| presented <= place).saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten frames a second; trials begin with frames 2, 5 and 8.
    fn player() -> Player {
        let frames: Vec<f64> = (0..10).map(|frame| 0.1 * f64::from(frame)).collect();
        Player::new(frames.into(), [2, 5, 8].into())
    }

    #[test]
    fn it_plays_in_real_time_and_stops_at_the_end() {
        let mut player = player();
        player.advance(5.0);
        assert_eq!(player.frame(), 0, "it does not play yet");
        player.toggle();
        player.advance(0.25);
        assert_eq!((player.frame(), player.is_playing()), (2, true));
        player.change_speed(true);
        player.change_speed(true);
        assert!((player.speed() - 2.0).abs() < 1e-12);
        player.advance(0.1);
        assert_eq!(player.frame(), 4);
        player.advance(100.0);
        assert_eq!((player.frame(), player.is_playing()), (9, false));
        // At the end it begins anew.
        player.toggle();
        assert_eq!((player.frame(), player.is_playing()), (0, true));
        player.advance(f64::NAN);
        player.advance(-1.0);
        assert_eq!(player.frame(), 0);
    }

    #[test]
    fn speeds_end_at_a_tenth_and_at_eight() {
        let mut player = player();
        (0..20).for_each(|_| player.change_speed(false));
        assert!((player.speed() - 0.1).abs() < 1e-12);
        (0..20).for_each(|_| player.change_speed(true));
        assert!((player.speed() - 8.0).abs() < 1e-12);
    }

    #[test]
    fn a_step_is_one_frame_and_stops_it() {
        let mut player = player();
        player.toggle();
        player.step(1);
        assert_eq!((player.frame(), player.is_playing()), (1, false));
        player.step(-5);
        assert_eq!(player.frame(), 0);
        player.step(100);
        assert_eq!(player.frame(), 9);
    }

    #[test]
    fn seeking_finds_the_frame_that_was_seen() {
        let mut player = player();
        for (place, frame) in [(0.45, 4), (-3.0, 0), (99.0, 9), (0.0, 0)] {
            player.seek(place);
            assert_eq!(player.frame(), frame, "{place}");
        }
        player.seek(f64::NAN);
        assert_eq!(player.frame(), 0);
    }

    #[test]
    fn trials_are_found_from_anywhere() {
        let mut player = player();
        let forward: Vec<usize> = (0..4)
            .map(|_| {
                player.step_trial(true);
                player.frame()
            })
            .collect();
        assert_eq!(forward, [2, 5, 8, 8]);
        player.go_to(7);
        let back: Vec<usize> = (0..3)
            .map(|_| {
                player.step_trial(false);
                player.frame()
            })
            .collect();
        assert_eq!(back, [5, 2, 2]);
    }

    #[test]
    fn a_log_without_frames_stays_where_it_is() {
        let mut player = Player::new([].into(), [].into());
        player.toggle();
        player.advance(1.0);
        player.step(1);
        player.step_trial(true);
        player.seek(1.0);
        assert_eq!((player.frame(), player.is_playing()), (0, false));
    }
}
