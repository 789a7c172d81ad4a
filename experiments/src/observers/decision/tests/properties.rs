//! Whatever happens, an answer comes.

use super::*;
use proptest::prelude::*;

const ALL: [Answer; 13] = [
    Answer::First,
    Answer::Second,
    Answer::Same,
    Answer::Increased,
    Answer::Decreased,
    Answer::Continue,
    Answer::Up,
    Answer::Down,
    Answer::Compare,
    Answer::Switch,
    Answer::Select,
    Answer::Option(1),
    Answer::Option(2),
];
const ASKED: [Asked; 11] = [
    Asked::WhichDegraded,
    Asked::WhichReference,
    Asked::WhichBetter,
    Asked::Direction,
    Asked::ToggleDegraded,
    Asked::ToggleReference,
    Asked::Match,
    Asked::Adjust,
    Asked::Agreement,
    Asked::Choice,
    Asked::Consent,
];

proptest! {
    /// Whatever is asked, whatever is accepted, in whatever order: an answer comes, and it is one that is accepted.
    #[test]
    fn every_question_gets_an_answer_that_it_accepts(
        phases in prop::collection::vec((0..ASKED.len(), 1u16..(1 << 13), 0u8..6, -1.0..12.0f64), 1..60),
        seed in 0u64..1000,
    ) {
        let mut driven = Driven::new(Options::default(), seed);
        for (asked, mask, shown, delta) in phases {
            let accepts: Vec<Answer> =
                ALL.into_iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1).map(|(_, answer)| answer).collect();
            let phase = match shown {
                0 => ask(ASKED[asked], &accepts),
                1 => show(PhaseName::AlternativeA, Alternative::Test).asking(ASKED[asked], accepts),
                2 => show(PhaseName::AlternativeB, Alternative::Reference).asking(ASKED[asked], accepts),
                3 => show(PhaseName::Reference, Alternative::Reference).asking(ASKED[asked], accepts),
                _ => at(PhaseName::Adjust, &[("a", delta), ("b", 1.0)]).asking(ASKED[asked], accepts),
            };
            driven.say(&phase, delta.max(0.0));
        }
    }
}
