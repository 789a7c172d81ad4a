//! Typed entries: one character a phase, then Continue.
//!
//! A count is what the observer has seen; anything else is a number that the page asks for, or a word. An entry that comes
//! back has been refused, and another is tried.

use crate::trial::{Answer, Asked, Phase, Presentation, Typing};

/// What is typed where words are asked for.
const WORDS: &str = "simulated";
/// What is tried when nothing better is known.
const NUMBERS: [&str; 8] = ["1", "0", "10", "30", "50", "100", "0.5", "1000"];

/// An entry that is being typed.
#[derive(Debug, Clone, Default)]
pub(super) struct Entering {
    /// The question that is being answered; none before the first.
    question: Option<String>,
    attempt: usize,
    entry: Vec<char>,
    typed: usize,
}

impl Entering {
    /// The next key. `known` is the count of what was seen, if anything was.
    pub(super) fn key(&mut self, phase: &Phase, asked: Asked, known: Option<u32>, in_trial: bool) -> Answer {
        let text = match &phase.presentation {
            Presentation::Text(text) => text.as_str(),
            Presentation::Scale(scale) => scale.question.as_str(),
            _ => "",
        };
        let question = format!("{in_trial} {asked:?} {}", text.split("\n\n").next().unwrap_or_default());
        if self.question.as_ref() != Some(&question) {
            *self = Self { question: Some(question), ..Self::default() };
            self.entry = entry(phase, text, asked, known, 0);
        } else if self.typed > self.entry.len() {
            // Continue was said, and the same is asked again.
            self.attempt += 1;
            self.typed = 0;
            self.entry = entry(phase, text, asked, known, self.attempt);
        }
        let key = self.entry.get(self.typed).map_or(Answer::Continue, |&character| Answer::Typed(character));
        self.typed += 1;
        key
    }
}

/// What is typed at an attempt.
fn entry(phase: &Phase, text: &str, asked: Asked, known: Option<u32>, attempt: usize) -> Vec<char> {
    let takes = |character: &char| phase.typing.is_some_and(|typing| typing.takes(*character));
    let mut tries: Vec<String> = Vec::new();
    if phase.typing == Some(Typing::Text) {
        tries.push(WORDS.to_owned());
    } else {
        tries.extend(known.map(|count| count.to_string()));
        tries.extend(middle(text, asked));
        tries.extend(NUMBERS.map(str::to_owned));
    }
    tries[attempt % tries.len()].chars().filter(takes).collect()
}

/// The middle of the range that the page's last paragraph names ("a number from 18 to 99 years").
fn middle(text: &str, asked: Asked) -> Option<String> {
    let numbers: Vec<f64> = text
        .rsplit("\n\n")
        .next()?
        .split_whitespace()
        .filter_map(|word| word.trim_end_matches(['.', ',', ';']).parse().ok())
        .collect();
    let [low, high] = numbers.get(..2)?.try_into().ok()?;
    let middle: f64 = 0.5 * (low + high);
    let whole = middle.round();
    Some(if asked == Asked::Count || (low..=high).contains(&whole) {
        format!("{whole}")
    } else {
        format!("{middle:.4}")
    })
}
