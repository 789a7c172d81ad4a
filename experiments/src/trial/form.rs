//! Forms: questions with their own words, one after the other, answered by digit or typed.
//!
//! A participant form, a questionnaire, the items of a Likert trial and the answer of a task are all this machine.

use super::{Answer, Asked, Phase, PhaseName, Presentation, Scale, Typing};
use crate::study::plan::{Item, ItemKind};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What was entered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Entry {
    /// A number; an option's value on a scale, its number from 1 in a choice.
    Number(f64),
    /// A text.
    Text(String),
}

/// Entries by item name.
pub type Entries = BTreeMap<String, Entry>;

/// Characters that may be typed for a number.
const NUMBER_LENGTH: usize = 12;

/// A form that is being filled in.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    items: Vec<Item>,
    /// The item that is asked now.
    at: usize,
    typed: String,
    /// Whether what was typed last was refused.
    refused: bool,
    entries: Entries,
}

impl Form {
    /// A form with nothing entered.
    #[must_use]
    pub fn new(items: &[Item]) -> Self {
        Self { items: items.to_vec(), at: 0, typed: String::new(), refused: false, entries: Entries::new() }
    }

    /// The item that is asked now; nothing once the form is complete.
    #[must_use]
    pub fn phase(&self) -> Option<Phase> {
        let item = self.items.get(self.at)?;
        Some(match &item.kind {
            ItemKind::Scale { low, high, low_anchor, high_anchor } => {
                let scale = Scale {
                    question: item.question.clone(),
                    steps: (*low..=*high).map(|value| value.to_string()).collect(),
                    low: low_anchor.clone(),
                    high: high_anchor.clone(),
                };
                Phase::new(PhaseName::Form, Presentation::Scale(scale), None)
                    .asking(Asked::Agreement, (*low..=*high).map(Answer::Option).collect())
            }
            ItemKind::Choice { options } => {
                let lines: Vec<String> =
                    options.iter().zip(1..).map(|(option, number)| format!("{number}   {option}")).collect();
                let text = format!("{}\n\n{}", item.question, lines.join("\n"));
                let accepts = (1..).take(options.len()).map(Answer::Option).collect();
                Phase::new(PhaseName::Form, Presentation::Text(text), None).asking(Asked::Choice, accepts)
            }
            ItemKind::Number { min, max, unit, whole } => {
                let what = if *whole { "a whole number" } else { "a number" };
                let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
                let expected = format!("Type {what} from {min} to {max}{unit}, then Enter.");
                let asked = if *whole { Asked::Count } else { Asked::Entry };
                self.entry(item, asked, Typing::Number, &expected)
            }
            ItemKind::Text { max_length } => {
                let expected = format!("Type up to {max_length} characters, then Enter.");
                self.entry(item, Asked::Entry, Typing::Text, &expected)
            }
        })
    }

    fn entry(&self, item: &Item, asked: Asked, typing: Typing, expected: &str) -> Phase {
        let again = if self.refused { "That does not fit. " } else { "" };
        let text = format!("{}\n\n{}_\n\n{again}{expected}", item.question, self.typed);
        let phase = Phase::new(PhaseName::Form, Presentation::Text(text), None);
        Phase { typing: Some(typing), ..phase.asking(asked, vec![Answer::Continue]) }
    }

    /// Takes in an answer that the present phase accepts; any other changes nothing.
    pub fn take(&mut self, answer: Answer) {
        let Some(item) = self.items.get(self.at) else { return };
        match (&item.kind, answer) {
            (ItemKind::Scale { .. } | ItemKind::Choice { .. }, Answer::Option(value)) => {
                self.enter(Entry::Number(f64::from(value)));
            }
            (ItemKind::Number { .. } | ItemKind::Text { .. }, Answer::Typed(character)) => {
                let most = if let ItemKind::Text { max_length } = item.kind { max_length } else { NUMBER_LENGTH };
                if self.typed.chars().count() < most {
                    self.typed.push(character);
                }
            }
            (ItemKind::Number { .. } | ItemKind::Text { .. }, Answer::Erase) => {
                self.typed.pop();
            }
            (ItemKind::Number { min, max, whole, .. }, Answer::Continue) => {
                let fits = |value: &f64| (*min..=*max).contains(value) && (!whole || value.fract().abs() <= 0.0);
                match self.typed.parse::<f64>().ok().filter(fits) {
                    Some(value) => self.enter(Entry::Number(value)),
                    None => self.refuse(),
                }
            }
            (ItemKind::Text { .. }, Answer::Continue) => match self.typed.trim() {
                "" => self.refuse(),
                text => self.enter(Entry::Text(text.to_owned())),
            },
            _ => {}
        }
    }

    fn enter(&mut self, entry: Entry) {
        if let Some(item) = self.items.get(self.at) {
            self.entries.insert(item.name.clone(), entry);
            self.at += 1;
            self.typed.clear();
            self.refused = false;
        }
    }

    fn refuse(&mut self) {
        self.typed.clear();
        self.refused = true;
    }

    /// What has been entered so far.
    #[must_use]
    pub fn entries(&self) -> &Entries {
        &self.entries
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(kind: ItemKind) -> Item {
        Item { name: "item".to_owned(), question: "How much?".to_owned(), kind }
    }

    fn scale() -> ItemKind {
        ItemKind::Scale {
            low: -3,
            high: 3,
            low_anchor: "strongly disagree".to_owned(),
            high_anchor: "strongly agree".to_owned(),
        }
    }

    fn number(whole: bool) -> ItemKind {
        ItemKind::Number { min: 1.0, max: 120.0, unit: "years".to_owned(), whole }
    }

    fn typed(form: &mut Form, text: &str) {
        text.chars().for_each(|character| form.take(Answer::Typed(character)));
    }

    #[test]
    fn digits_stand_for_the_steps_of_a_scale_in_order() {
        let mut form = Form::new(&[item(scale())]);
        let phase = form.phase().expect("asked");
        assert_eq!(phase.accepts, (-3..=3).map(Answer::Option).collect::<Vec<_>>());
        assert_eq!(phase.asked, Some(Asked::Agreement));
        form.take(Answer::Option(-2));
        assert_eq!(form.entries()["item"], Entry::Number(-2.0));
        assert_eq!(form.phase(), None);
    }

    #[test]
    fn a_typed_number_is_taken_when_it_fits_and_asked_again_when_it_does_not() {
        let mut form = Form::new(&[item(number(true))]);
        for refused in ["", "abc", "0", "121", "3.5", "-", "1-2"] {
            typed(&mut form, refused);
            form.take(Answer::Continue);
            let Some(Phase { presentation: Presentation::Text(text), .. }) = form.phase() else {
                panic!("asked again")
            };
            assert!(text.contains("does not fit"), "{refused:?}: {text}");
        }
        typed(&mut form, "349");
        form.take(Answer::Erase);
        form.take(Answer::Continue);
        assert_eq!(form.entries()["item"], Entry::Number(34.0));
    }

    #[test]
    fn fractions_are_taken_where_whole_numbers_are_not_demanded() {
        let mut form = Form::new(&[item(number(false))]);
        typed(&mut form, "3.5");
        form.take(Answer::Continue);
        assert_eq!(form.entries()["item"], Entry::Number(3.5));
    }

    #[test]
    fn texts_are_cut_at_their_length_and_never_empty() {
        let mut form = Form::new(&[item(ItemKind::Text { max_length: 4 })]);
        form.take(Answer::Continue);
        assert!(form.phase().is_some());
        typed(&mut form, "lefthanded");
        form.take(Answer::Continue);
        assert_eq!(form.entries()["item"], Entry::Text("left".to_owned()));
    }

    #[test]
    fn answers_that_do_not_belong_to_the_item_change_nothing() {
        let mut form = Form::new(&[item(scale())]);
        let before = form.clone();
        for answer in [Answer::First, Answer::Continue, Answer::Typed('3'), Answer::Erase, Answer::Switch] {
            form.take(answer);
        }
        assert_eq!(form, before);
    }

    #[test]
    fn choices_count_from_one() {
        let options = vec!["no".to_owned(), "glasses".to_owned(), "contact lenses".to_owned()];
        let mut form = Form::new(&[item(ItemKind::Choice { options })]);
        let phase = form.phase().expect("asked");
        assert_eq!(phase.accepts, vec![Answer::Option(1), Answer::Option(2), Answer::Option(3)]);
        form.take(Answer::Option(2));
        assert_eq!(form.entries()["item"], Entry::Number(2.0));
    }
}
