//! Staircases: n-up-m-down (Levitt 1971) and weighted up-down (Kaernbach 1991), one track or several interleaved.
//!
//! After `n_down` right answers in a row at a level the next one is harder, after `n_up` wrong ones it is easier. Where the
//! run of steps turns round is a reversal, at the level that was being asked. With `initial_rule` every answer moves the
//! level until the first reversal, as in PsychoPy's `StairHandler`, whose sequences this gives.
//!
//! Where it converges (p is the probability of a right answer): 1-up-m-down at p^m = ½ (Levitt 1971, Table I), and a
//! weighted 1-up-1-down with upward steps r times the downward ones at p = r / (1 + r) (Kaernbach 1991, Eq. 1).

use super::{Belief, Estimate, Procedure};
use crate::study::plan::{Level, StaircasePlan, StepType};
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Interleaved staircases. Estimates the parameter that they move, by its own name, as the mean of their last reversals; its
/// SD is the reversals' own spread.
#[derive(Debug, Clone)]
pub struct Staircase {
    plan: StaircasePlan,
    tracks: Vec<Track>,
    /// Tracks still to come in this round, the next one last.
    round: Vec<usize>,
}

/// One staircase.
#[derive(Debug, Clone)]
struct Track {
    value: f64,
    /// Which way the last step went.
    direction: Option<Direction>,
    /// Answers alike in a row since the last step: right ones or wrong ones.
    run: u32,
    last_answer: Option<bool>,
    reversals: Vec<f64>,
    completed: u32,
    finished: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Direction {
    Harder,
    Easier,
}

impl Track {
    fn new(start: f64) -> Self {
        Self {
            value: start,
            direction: None,
            run: 0,
            last_answer: None,
            reversals: Vec::new(),
            completed: 0,
            finished: false,
        }
    }

    /// Takes in an answer to a trial at `shown`, and moves.
    fn answer(&mut self, shown: f64, correct: bool, plan: &StaircasePlan) {
        self.completed += 1;
        self.run = if self.last_answer == Some(correct) { self.run + 1 } else { 1 };
        self.last_answer = Some(correct);
        let initial = plan.initial_rule && self.reversals.is_empty();
        let wanted = match (initial, correct) {
            (true, _) => 1,
            (false, true) => plan.n_down,
            (false, false) => plan.n_up,
        };
        if self.run >= wanted {
            self.run = 0;
            let direction = if correct { Direction::Harder } else { Direction::Easier };
            if self.direction.replace(direction).is_some_and(|before| before != direction) {
                self.reversals.push(shown);
            }
            self.value = plan.place.clamped(stepped(shown, direction, self.reversals.len(), plan));
        }
        let reversals = u32::try_from(self.reversals.len()).unwrap_or(u32::MAX);
        self.finished = plan.stop.holds(self.completed, reversals, &estimate(std::slice::from_ref(self), plan));
    }
}

/// Where a step leads after so many reversals.
fn stepped(from: f64, direction: Direction, reversals: usize, plan: &StaircasePlan) -> f64 {
    let step = plan.steps.get(reversals).or(plan.steps.last()).copied().unwrap_or(0.0);
    let towards = match direction {
        Direction::Harder => step * plan.harder.sign(),
        Direction::Easier => -step * plan.harder.sign() * plan.up_down_ratio,
    };
    match plan.step_type {
        StepType::Linear => from + towards,
        StepType::Log => from * 10_f64.powf(towards),
        StepType::Db => from * 10_f64.powf(towards / 20.0),
    }
}

/// Mean and SD of the last reversals of each track; geometric where steps are factors. Nothing from fewer than two.
fn estimate(tracks: &[Track], plan: &StaircasePlan) -> Estimate {
    let last = |track: &Track| {
        let skipped = track.reversals.len().saturating_sub(plan.estimate_reversals as usize);
        track.reversals[skipped..].to_vec()
    };
    let geometric = plan.step_type != StepType::Linear;
    let values: Vec<f64> =
        tracks.iter().flat_map(last).map(|level| if geometric { level.ln() } else { level }).collect();
    if values.len() < 2 {
        return Estimate::new();
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let sd = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let belief = match geometric {
        true => Belief { mean: mean.exp(), sd: mean.exp() * sd },
        false => Belief { mean, sd },
    };
    Estimate::from([(plan.place.parameter().to_owned(), belief)])
}

impl Staircase {
    /// Starts every track at its start.
    #[must_use]
    pub fn new(plan: &StaircasePlan) -> Self {
        let tracks = plan.start.iter().map(|&start| Track::new(plan.place.clamped(start))).collect();
        Self { plan: plan.clone(), tracks, round: Vec::new() }
    }

    /// The reversals of each track so far, in the order in which they came.
    pub fn reversals(&self) -> impl Iterator<Item = &[f64]> {
        self.tracks.iter().map(|track| track.reversals.as_slice())
    }
}

impl Procedure for Staircase {
    fn level(&mut self, rng: &mut ChaCha8Rng) -> Level {
        if self.round.is_empty() {
            self.round = (0..self.tracks.len()).filter(|&track| !self.tracks[track].finished).collect();
            if self.round.len() > 1 {
                self.round.shuffle(rng);
            }
        }
        let track = self.round.last().and_then(|&track| self.tracks.get(track));
        track.map(|track| self.plan.place.level(track.value)).unwrap_or_default()
    }

    fn update(&mut self, level: &Level, correct: bool) {
        let track = self.round.pop().and_then(|track| self.tracks.get_mut(track));
        if let Some((track, &shown)) = track.zip(level.get(self.plan.place.parameter())) {
            track.answer(shown, correct, &self.plan);
        }
    }

    /// Nothing to do: the track has not moved, and is still the next.
    fn put_back(&mut self, _level: Level, _rng: &mut ChaCha8Rng) {}

    fn finished(&self) -> bool {
        self.tracks.iter().all(|track| track.finished)
    }

    fn estimate(&self) -> Estimate {
        estimate(&self.tracks, &self.plan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::psychometric::unscaled;
    use crate::streams::Stream;
    use crate::study::plan::{Function, Harder, Place, Stop};
    use rand::RngExt;

    fn plan() -> StaircasePlan {
        StaircasePlan {
            place: Place::new("x", Level::new(), [0.0, 1.0]),
            harder: Harder::Down,
            start: vec![0.8],
            steps: vec![0.1, 0.01, 0.001],
            step_type: StepType::Linear,
            up_down_ratio: 1.0,
            n_up: 1,
            n_down: 3,
            initial_rule: true,
            estimate_reversals: 6,
            stop: Stop::All(vec![Stop::Trials(20), Stop::Reversals(4)]),
        }
    }

    /// Levels and reversals for answers given as 1 and 0, until the procedure is finished.
    fn run(plan: &StaircasePlan, answers: &[u8]) -> (Vec<f64>, Vec<f64>) {
        let mut staircase = Staircase::new(plan);
        let mut rng = Stream::Procedure.generator(1);
        let mut levels = Vec::new();
        for answer in answers {
            if staircase.finished() {
                break;
            }
            let level = staircase.level(&mut rng);
            levels.push(level["x"]);
            staircase.update(&level, *answer == 1);
        }
        assert!(staircase.finished(), "{staircase:?}");
        let reversals = staircase.tracks[0].reversals.clone();
        (levels, reversals)
    }

    #[track_caller]
    fn assert_near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-8, "{found:?} {expected:?}");
        }
    }

    /// Four right, four wrong, …: `makeBasicResponseCycles` of PsychoPy's tests.
    const FOURS: [u8; 20] = [1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1];

    /// PsychoPy 2026.2.5, psychopy/tests/test_data/test_StairHandlers.py, test_StairHandlerLinear.
    #[test]
    fn linear_steps_are_psychopys() {
        let (levels, reversals) = run(&plan(), &FOURS);
        let expected = [
            0.8, 0.7, 0.6, 0.5, 0.4, 0.41, 0.42, 0.43, 0.44, 0.44, 0.44, 0.439, 0.439, 0.44, 0.441, 0.442, 0.443,
            0.443, 0.443, 0.442,
        ];
        assert_near(&levels, &expected);
        assert_near(&reversals, &[4, 10, 12, 18].map(|at| expected[at]));
    }

    /// PsychoPy 2026.2.5, test_StairHandlerLog and test_StairHandlerDb: the same levels from steps in either unit.
    #[test]
    fn log_and_db_steps_are_psychopys() {
        let expected = [
            0.8,
            0.763_994_069,
            0.729_608_671,
            0.696_770_872,
            0.665_411_017,
            0.680_910_431,
            0.696_770_872,
            0.713_000_751,
            0.729_608_671,
            0.729_608_671,
            0.729_608_671,
            0.713_000_751,
            0.713_000_751,
            0.721_256_91,
            0.729_608_671,
            0.738_057_142,
            0.746_603_441,
            0.746_603_441,
            0.746_603_441,
            0.738_057_142,
        ];
        let db = vec![0.4, 0.2, 0.2, 0.1];
        let log = db.iter().map(|step| step / 20.0).collect();
        for (step_type, steps) in [(StepType::Db, db), (StepType::Log, log)] {
            let (levels, reversals) = run(&StaircasePlan { steps, step_type, ..plan() }, &FOURS);
            assert_near(&levels, &expected);
            assert_near(&reversals, &[4, 10, 12, 18].map(|at| expected[at]));
        }
    }

    /// PsychoPy 2026.2.5, test_StairHandlerScalarStepSize and test_applyInitialRule_False.
    #[test]
    fn one_step_size_and_no_initial_rule_are_psychopys() {
        let stop = Stop::All(vec![Stop::Trials(10), Stop::Reversals(6)]);
        let one = StaircasePlan { steps: vec![0.1], n_down: 1, stop, ..plan() };
        let (levels, reversals) = run(&one, &[1, 1, 0, 1, 1, 0, 1, 1, 0, 1]);
        assert_near(&levels, &[0.8, 0.7, 0.6, 0.7, 0.6, 0.5, 0.6, 0.5, 0.4, 0.5]);
        assert_near(&reversals, &[2, 3, 5, 6, 8, 9].map(|at| levels[at]));

        let strict = StaircasePlan {
            place: Place::new("x", Level::new(), [0.0, 100.0]),
            start: vec![10.0],
            steps: vec![2.0],
            n_down: 2,
            initial_rule: false,
            stop: Stop::Reversals(2),
            ..plan()
        };
        let (levels, reversals) = run(&strict, &[0, 1, 1, 0]);
        assert_near(&levels, &[10.0, 12.0, 12.0, 10.0]);
        assert_near(&reversals, &[12.0, 10.0]);
    }

    /// Longer random sequences against PsychoPy 2026.2.5's `StairHandler`; made by tests/peers/psychopy_peer.py. The sum
    /// over trials of level × (trial number) notices any level out of place.
    #[test]
    fn random_answers_give_psychopys_levels() {
        for (n_up, n_down, initial_rule, step_type, sum, reversals, last) in PSYCHOPY_RANDOM {
            let plan = StaircasePlan {
                place: Place::new("x", Level::new(), [0.05, 4.0]),
                start: vec![2.0],
                steps: vec![0.3, 0.2, 0.1, 0.05],
                step_type,
                n_up,
                n_down,
                initial_rule,
                stop: Stop::Trials(120),
                ..plan()
            };
            // A linear congruential generator that any language can repeat.
            let mut state = 12345_u64;
            let answers: Vec<u8> = (0..120)
                .map(|_| {
                    state = (1_103_515_245 * state + 12345) % (1 << 31);
                    u8::from(state / 65536 % 100 < 72)
                })
                .collect();
            let (levels, turned) = run(&plan, &answers);
            let found: f64 = levels.iter().zip(1..).map(|(level, number)| level * f64::from(number)).sum();
            println!(
                "{n_up}-up-{n_down}-down {step_type:?}: {found:.9}, {} reversals, {:.9}",
                turned.len(),
                levels[119]
            );
            assert!((found - sum).abs() < 1e-6 && (levels[119] - last).abs() < 1e-8 && turned.len() == reversals);
        }
    }

    /// n_up, n_down, initial rule, step type, sum, number of reversals, last level.
    const PSYCHOPY_RANDOM: [(u32, u32, bool, StepType, f64, usize, f64); 7] = [
        (1, 2, true, StepType::Linear, 14_608.650_000_000, 38, 2.2),
        (1, 3, true, StepType::Log, 26_282.379_851_128, 23, 4.0),
        (2, 3, true, StepType::Db, 13_830.169_310_718, 15, 1.888_121_753),
        (1, 3, false, StepType::Log, 26_341.749_767_636, 22, 4.0),
        (2, 1, false, StepType::Linear, 462.5, 24, 0.05),
        (1, 1, true, StepType::Log, 966.918_390_474, 50, 0.056_100_923),
        (3, 4, false, StepType::Db, 12_905.572_530_648, 6, 1.751_983_435),
    ];

    /// Where it settles, by simulation of long tracks with small steps on a steep logistic observer, against the closed forms
    /// of Levitt 1971 (p^m = ½) and Kaernbach 1991 (p = r / (1 + r)); and the same where larger values are harder.
    #[test]
    fn it_converges_where_the_closed_forms_say() {
        let psi = |x: f64| 0.5 + 0.5 * unscaled(Function::Logistic, (x - 0.5) / 0.4);
        for (n_down, ratio, target) in [
            (2, 1.0, 0.5_f64.powf(0.5)),
            (3, 1.0, 0.5_f64.powf(1.0 / 3.0)),
            (1, 3.0, 0.75),
            (1, 0.6 / 0.4, 0.6),
            (1, 9.0, 0.9),
        ] {
            for harder in [Harder::Down, Harder::Up] {
                let plan = StaircasePlan {
                    place: Place::new("x", Level::new(), [-1.0, 2.0]),
                    harder,
                    start: vec![0.5],
                    steps: vec![0.004],
                    up_down_ratio: ratio,
                    n_down,
                    stop: Stop::Trials(60_000),
                    ..plan()
                };
                let mut staircase = Staircase::new(&plan);
                let mut rng = Stream::Observer.generator(u64::from(n_down) + 7);
                let (mut sum, mut n) = (0.0, 0);
                while !staircase.finished() {
                    let level = staircase.level(&mut rng);
                    let x = level["x"];
                    let p = psi(if harder == Harder::Down { x } else { 1.0 - x });
                    if staircase.tracks[0].completed > 2000 {
                        (sum, n) = (sum + p, n + 1);
                    }
                    staircase.update(&level, rng.random::<f64>() < p);
                }
                let settled = sum / f64::from(n);
                println!("1-up-{n_down}-down, ratio {ratio}, {harder:?}: {settled:.4}, closed form {target:.4}");
                assert!((settled - target).abs() < 0.006, "{settled} {target}");
            }
        }
    }

    #[test]
    fn tracks_take_turns_in_rounds_and_end_each_on_its_own() {
        let plan = StaircasePlan {
            start: vec![0.2, 0.8, 0.5],
            stop: Stop::Any(vec![Stop::Trials(40), Stop::Reversals(3)]),
            ..plan()
        };
        let mut staircase = Staircase::new(&plan);
        let mut rng = Stream::Procedure.generator(5);
        let mut counts = [0; 3];
        let mut orders = std::collections::BTreeSet::new();
        for trial in 0.. {
            if staircase.finished() {
                break;
            }
            let level = staircase.level(&mut rng);
            if trial % 5 == 4 {
                staircase.put_back(level, &mut rng);
                continue;
            }
            if counts.iter().all(|&n| n == counts[0]) {
                orders.insert(staircase.round.clone());
            }
            let track = *staircase.round.last().expect("a round");
            counts[track] += 1;
            // The first track is wrong after every three right answers, turns there and ends early; the others never turn.
            staircase.update(&level, track > 0 || counts[0] % 4 > 0);
        }
        assert!(counts[0] < 15 && counts[1..] == [40, 40], "{counts:?}");
        assert!(orders.len() > 1, "rounds are shuffled: {orders:?}");
    }

    #[test]
    fn the_estimate_is_the_mean_of_the_last_reversals() {
        let mut staircase = Staircase::new(&StaircasePlan { estimate_reversals: 3, ..plan() });
        assert!(staircase.estimate().is_empty());
        staircase.tracks[0].reversals = vec![0.4];
        assert!(staircase.estimate().is_empty(), "one reversal has no spread");
        staircase.tracks[0].reversals = vec![0.9, 0.1, 0.2, 0.4];
        let belief = staircase.estimate()["x"];
        assert!((belief.mean - 0.7 / 3.0).abs() < 1e-12 && (belief.sd - 0.152_752_523).abs() < 1e-9);
        staircase.plan.step_type = StepType::Log;
        let belief = staircase.estimate()["x"];
        // 0.1, 0.2, 0.4: geometric mean 0.2, SD of the logarithm ln 2.
        assert!((belief.mean - 0.2).abs() < 1e-12 && (belief.sd - 0.2 * 2_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn the_fewest_trials_for_reversals_are_reached_and_never_beaten() {
        use proptest::prelude::*;
        let config = ProptestConfig::with_cases(200);
        proptest!(config, |(n_up in 1u32..4, n_down in 1u32..4, initial_rule: bool, n in 1u32..6, bits: u64)| {
            let plan = StaircasePlan { n_up, n_down, initial_rule, stop: Stop::Reversals(n), ..plan() };
            let fewest = plan.fewest_trials(n);
            // The quickest: right and wrong runs of just the needed length, beginning either way.
            let mut best = u32::MAX;
            for first in [false, true] {
                let mut staircase = Staircase::new(&plan);
                let mut rng = Stream::Procedure.generator(1);
                let mut right = first;
                while !staircase.finished() {
                    let before = staircase.tracks[0].direction;
                    let level = staircase.level(&mut rng);
                    staircase.update(&level, right);
                    let wanted = if right { Direction::Harder } else { Direction::Easier };
                    if before != Some(wanted) && staircase.tracks[0].direction == Some(wanted) {
                        right = !right;
                    }
                }
                best = best.min(staircase.tracks[0].completed);
            }
            prop_assert_eq!(best, fewest);
            let mut staircase = Staircase::new(&plan);
            let mut rng = Stream::Procedure.generator(1);
            let mut trials = 0;
            while !staircase.finished() && trials < 64 {
                let level = staircase.level(&mut rng);
                staircase.update(&level, bits >> trials & 1 == 1);
                trials += 1;
            }
            prop_assert!(trials >= fewest);
        });
    }
}
