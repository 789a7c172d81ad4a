//! Practice: any protocol, with a word of feedback before the trial ends.

use super::{Input, Outcome, Phase, PhaseName, Presentation, Protocol, Step};

/// A protocol whose answered trials end with "Right." or "Wrong."; what has no right or wrong ends as it is.
#[derive(Debug)]
pub struct WithFeedback {
    inner: Box<dyn Protocol>,
    feedback_s: f64,
    /// The outcome while the word is shown.
    outcome: Option<Outcome>,
}

impl WithFeedback {
    /// `inner` with feedback of `feedback_s` seconds.
    #[must_use]
    pub fn new(inner: Box<dyn Protocol>, feedback_s: f64) -> Self {
        Self { inner, feedback_s, outcome: None }
    }

    fn show(&self, right: bool) -> Step {
        let word = if right { "Right." } else { "Wrong." };
        Step::Show(Phase::new(PhaseName::Feedback, Presentation::Text(word.to_owned()), Some(self.feedback_s)))
    }
}

impl Protocol for WithFeedback {
    fn next(&mut self, input: Option<&Input>) -> Step {
        if let Some(Outcome::Answered { correct: Some(right), .. }) = &self.outcome {
            let right = *right;
            return match (input, self.outcome.take()) {
                (Some(Input::Elapsed), Some(outcome)) => Step::End(outcome),
                // Anything else changes nothing.
                (_, outcome) => {
                    self.outcome = outcome;
                    self.show(right)
                }
            };
        }
        match self.inner.next(input) {
            Step::End(outcome @ Outcome::Answered { correct: Some(right), .. }) => {
                self.outcome = Some(outcome);
                self.show(right)
            }
            step => step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::{Answer, Found};

    /// Ends at once, in a given way.
    #[derive(Debug)]
    struct Ends(Outcome);

    impl Protocol for Ends {
        fn next(&mut self, _input: Option<&Input>) -> Step {
            Step::End(self.0.clone())
        }
    }

    fn answered(correct: Option<bool>) -> Outcome {
        Outcome::Answered { answer: Answer::First, correct, found: Found::new() }
    }

    #[test]
    fn a_right_or_wrong_answer_is_followed_by_its_word_and_then_the_end() {
        for (correct, word) in [(true, "Right."), (false, "Wrong.")] {
            let outcome = answered(Some(correct));
            let mut trial = WithFeedback::new(Box::new(Ends(outcome.clone())), 0.4);
            let Step::Show(phase) = trial.next(None) else { panic!("practice gives feedback") };
            assert_eq!(phase.presentation, Presentation::Text(word.to_owned()));
            assert_eq!(phase.duration_s, Some(0.4));
            // A key does not end it.
            let again = trial.next(Some(&Input::Answered { answer: Answer::Second }));
            assert_eq!(again, Step::Show(phase));
            assert_eq!(trial.next(Some(&Input::Elapsed)), Step::End(outcome));
        }
    }

    #[test]
    fn what_is_neither_right_nor_wrong_ends_without_a_word() {
        for outcome in [answered(None), Outcome::TimedOut] {
            let mut trial = WithFeedback::new(Box::new(Ends(outcome.clone())), 0.4);
            assert_eq!(trial.next(None), Step::End(outcome));
        }
    }
}
