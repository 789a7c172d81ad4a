//! Keys: which answer a key stands for in a phase, and the line that tells observers so.
//!
//! Pure: a window translates its events into [`Key`]s and hands the answers to the session machine, which decides whether
//! they are taken. A key that means nothing where it is pressed is still an answer, so that logs show it.

use super::{Answer, Asked, Phase, PhaseName, Presentation};

/// A key, as far as answers are made of keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// The left arrow.
    Left,
    /// The right arrow.
    Right,
    /// The up arrow.
    Up,
    /// The down arrow.
    Down,
    /// The space bar.
    Space,
    /// Enter.
    Enter,
    /// Tab.
    Tab,
    /// Backspace.
    Backspace,
    /// A key with a character.
    Character(char),
}

/// What a key says in a phase; nothing if it says nothing anywhere.
///
/// An answer that the phase takes comes first. Otherwise it is what the key commonly means, which the session logs and
/// does not take.
///
/// Digit n stands for the n-th choice that the phase accepts, whatever it is: the first of two, a step of a scale, an
/// option. Where something is typed, characters are characters.
#[must_use]
pub fn answer_for(key: Key, phase: &Phase) -> Option<Answer> {
    if phase.typing.is_some() {
        return match key {
            Key::Character(character) => Some(Answer::Typed(character)),
            Key::Space => Some(Answer::Typed(' ')),
            Key::Backspace => Some(Answer::Erase),
            Key::Enter => Some(Answer::Continue),
            Key::Left | Key::Right | Key::Up | Key::Down | Key::Tab => None,
        };
    }
    match key {
        Key::Left => taken(phase, &[Answer::First, Answer::Decreased]),
        Key::Right => taken(phase, &[Answer::Second, Answer::Increased]),
        Key::Up => taken(phase, &[Answer::Up, Answer::Increased]),
        Key::Down => taken(phase, &[Answer::Down, Answer::Decreased, Answer::Same]),
        // Where there is something to switch to or to compare with, going on is Enter's.
        Key::Space => taken(phase, &[Answer::Continue, Answer::Switch, Answer::Compare, Answer::Same])
            .map(|answer| if phase.takes(Answer::Compare) { Answer::Compare } else { answer }),
        Key::Enter => taken(phase, &[Answer::Continue]),
        Key::Tab => taken(phase, &[Answer::Select]),
        Key::Backspace => Some(Answer::Erase),
        Key::Character(character) => answer_for_character(character, phase),
    }
}

/// The first of `meanings` that the phase takes, or else the first.
fn taken(phase: &Phase, meanings: &[Answer]) -> Option<Answer> {
    meanings.iter().find(|&&answer| phase.takes(answer)).or(meanings.first()).copied()
}

fn answer_for_character(character: char, phase: &Phase) -> Option<Answer> {
    if let Some(digit @ 1..) = character.to_digit(10) {
        let common = match digit {
            1 => Answer::First,
            2 => Answer::Second,
            3 => Answer::Same,
            _ => Answer::Option(i32::try_from(digit).unwrap_or_default()),
        };
        return Some(choices(phase).nth(digit as usize - 1).unwrap_or(common));
    }
    // A letter names one of two only where the two are called by letters, or agrees where agreement is asked.
    let toggled = matches!(phase.asked, None | Some(Asked::ToggleDegraded | Asked::ToggleReference));
    let consent = phase.asked == Some(Asked::Consent);
    match character.to_ascii_lowercase() {
        'a' if toggled => Some(Answer::First),
        'b' if toggled => Some(Answer::Second),
        'y' if consent => Some(Answer::First),
        'n' if consent => Some(Answer::Second),
        '=' => Some(Answer::Same),
        _ => None,
    }
}

/// The accepted answers that digits stand for, in order.
fn choices(phase: &Phase) -> impl Iterator<Item = Answer> + '_ {
    phase.accepts.iter().copied().filter(|answer| {
        matches!(
            answer,
            Answer::First | Answer::Second | Answer::Same | Answer::Increased | Answer::Decreased | Answer::Option(_)
        )
    })
}

/// One line that names the keys of a phase; empty where none does anything.
#[must_use]
pub fn hint(phase: &Phase) -> String {
    let options = choices(phase).filter(|answer| matches!(answer, Answer::Option(_))).count();
    let mut parts: Vec<String> = Vec::new();
    match options {
        0 => {}
        1 => parts.push("1: choose".to_owned()),
        most => parts.push(format!("1–{most}: choose")),
    }
    for (digit, answer) in (1..).zip(choices(phase)) {
        if let Some((keys, meaning)) = choice_in_words(answer, phase) {
            parts.push(format!("{digit}{keys}: {meaning}"));
        }
    }
    if phase.takes(Answer::Switch) {
        parts.push("space: switch".to_owned());
    }
    match (phase.takes(Answer::Up), phase.takes(Answer::Down)) {
        (true, true) => parts.push("↑ ↓: change".to_owned()),
        (true, false) => parts.push("↑: up".to_owned()),
        (false, true) => parts.push("↓: down".to_owned()),
        (false, false) => {}
    }
    if phase.takes(Answer::Select) {
        parts.push("Tab: next parameter".to_owned());
    }
    if phase.takes(Answer::Compare) {
        parts.push("space: compare".to_owned());
    }
    if phase.typing.is_some() {
        parts.push("Backspace: take back".to_owned());
    }
    if phase.takes(Answer::Continue) {
        let space = phase.typing.is_none() && answer_for(Key::Space, phase) == Some(Answer::Continue);
        parts.push(if space { "space or Enter: go on" } else { "Enter: done" }.to_owned());
    }
    parts.join("     ")
}

/// The other keys and the meaning of a choice that is no option.
fn choice_in_words(answer: Answer, phase: &Phase) -> Option<(&'static str, &'static str)> {
    let toggled = matches!(phase.asked, Some(Asked::ToggleDegraded | Asked::ToggleReference));
    Some(match answer {
        Answer::First if toggled => (", A or ←", "A"),
        Answer::Second if toggled => (", B or →", "B"),
        Answer::First if phase.asked == Some(Asked::Consent) => (" or Y", "I agree"),
        Answer::Second if phase.asked == Some(Asked::Consent) => (" or N", "I do not agree"),
        Answer::First => (" or ←", "the first"),
        Answer::Second => (" or →", "the second"),
        Answer::Same => (" or space", "the same"),
        Answer::Increased => (" or ↑", "increased"),
        Answer::Decreased => (" or ↓", "decreased"),
        _ => return None,
    })
}

/// The hint that is shown with a phase: where a question stands on the display, and never over a stimulus.
#[must_use]
pub fn shown_hint(phase: &Phase) -> Option<String> {
    let asks = matches!(phase.name, PhaseName::Ask | PhaseName::Form | PhaseName::Task | PhaseName::Consent);
    let on_grey = matches!(phase.presentation, Presentation::Text(_) | Presentation::Scale(_));
    (asks && on_grey).then(|| hint(phase)).filter(|hint| !hint.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::{Alternative, Typing};

    fn phase(name: PhaseName, asked: Option<Asked>, accepts: &[Answer]) -> Phase {
        let phase = Phase::new(name, Presentation::Text("?".to_owned()), None);
        Phase { asked, accepts: accepts.to_vec(), ..phase }
    }

    fn asking(asked: Asked, accepts: &[Answer]) -> Phase {
        phase(PhaseName::Ask, Some(asked), accepts)
    }

    fn typing(asked: Asked, typing: Typing) -> Phase {
        Phase { typing: Some(typing), ..asking(asked, &[Answer::Continue]) }
    }

    /// Every question with the answers that it takes.
    fn questions() -> Vec<Phase> {
        use Answer::*;
        vec![
            asking(Asked::WhichDegraded, &[First, Second]),
            asking(Asked::WhichReference, &[First, Second]),
            asking(Asked::WhichBetter, &[First, Second, Same]),
            asking(Asked::Direction, &[Increased, Decreased, Same]),
            asking(Asked::ToggleDegraded, &[Switch, First, Second]),
            asking(Asked::ToggleReference, &[Switch, First, Second]),
            asking(Asked::Match, &[Up, Down, Compare, Continue]),
            asking(Asked::Adjust, &[Up, Down, Select, Compare, Continue]),
            asking(Asked::Agreement, &(-3..=3).map(Option).collect::<Vec<_>>()),
            asking(Asked::Choice, &(1..=9).map(Option).collect::<Vec<_>>()),
            typing(Asked::Entry, Typing::Text),
            typing(Asked::Count, Typing::Number),
            asking(Asked::Consent, &[First, Second]),
        ]
    }

    fn keys() -> Vec<Key> {
        let mut keys =
            vec![Key::Left, Key::Right, Key::Up, Key::Down, Key::Space, Key::Enter, Key::Tab, Key::Backspace];
        keys.extend((' '..='~').map(Key::Character));
        keys
    }

    #[test]
    fn every_answer_of_every_question_has_a_key_and_a_hint() {
        for phase in questions() {
            let said: Vec<Answer> = keys().into_iter().filter_map(|key| answer_for(key, &phase)).collect();
            for answer in &phase.accepts {
                assert!(said.contains(answer), "{:?}: no key says {answer:?}", phase.asked);
            }
            let hint = shown_hint(&phase).expect("a question has keys");
            assert!(!hint.contains('\n') && hint.chars().count() < 90, "{hint}");
        }
    }

    fn assert_keys(phase: &Phase, expected: &[(Key, Answer)]) {
        for (key, answer) in expected {
            assert_eq!(answer_for(*key, phase), Some(*answer), "{key:?} in {:?}", phase.asked);
        }
    }

    const fn c(character: char) -> Key {
        Key::Character(character)
    }

    #[test]
    fn the_obvious_keys_work() {
        use Answer::*;
        let all = questions();
        let question = |asked| all.iter().find(|phase| phase.asked == Some(asked)).expect("listed");
        for asked in [Asked::WhichDegraded, Asked::WhichReference, Asked::WhichBetter] {
            let expected = [(Key::Left, First), (c('1'), First), (Key::Right, Second), (c('2'), Second)];
            assert_keys(question(asked), &expected);
        }
        let same = [(Key::Down, Same), (c('3'), Same), (Key::Space, Same), (c('='), Same)];
        assert_keys(question(Asked::WhichBetter), &same);
        let direction = [
            (Key::Up, Increased),
            (c('1'), Increased),
            (Key::Right, Increased),
            (Key::Down, Decreased),
            (c('2'), Decreased),
            (Key::Left, Decreased),
            (Key::Space, Same),
            (c('='), Same),
            (c('3'), Same),
        ];
        assert_keys(question(Asked::Direction), &direction);
        for asked in [Asked::ToggleDegraded, Asked::ToggleReference] {
            let toggle = [
                (Key::Space, Switch),
                (c('a'), First),
                (c('A'), First),
                (c('1'), First),
                (Key::Left, First),
                (c('b'), Second),
                (c('2'), Second),
                (Key::Right, Second),
            ];
            assert_keys(question(asked), &toggle);
        }
        for asked in [Asked::Match, Asked::Adjust] {
            let moves = [(Key::Up, Up), (Key::Down, Down), (Key::Space, Compare), (Key::Enter, Continue)];
            assert_keys(question(asked), &moves);
        }
        assert_keys(question(Asked::Adjust), &[(Key::Tab, Select)]);
        assert_keys(question(Asked::Agreement), &[(c('1'), Option(-3)), (c('4'), Option(0)), (c('7'), Option(3))]);
        assert_keys(question(Asked::Choice), &[(c('1'), Option(1)), (c('9'), Option(9))]);
        assert_keys(question(Asked::Consent), &[(c('1'), First), (c('y'), First), (c('N'), Second), (c('2'), Second)]);
    }

    #[test]
    fn typed_characters_are_characters_also_spaces_and_digits() {
        for phase in [typing(Asked::Entry, Typing::Text), typing(Asked::Count, Typing::Number)] {
            assert_keys(
                &phase,
                &[
                    (Key::Space, Answer::Typed(' ')),
                    (c('1'), Answer::Typed('1')),
                    (c('y'), Answer::Typed('y')),
                    (c('é'), Answer::Typed('é')),
                    (Key::Backspace, Answer::Erase),
                    (Key::Enter, Answer::Continue),
                ],
            );
            assert_eq!(answer_for(Key::Left, &phase), None);
        }
    }

    #[test]
    fn pages_go_on_with_space_and_enter() {
        for name in [PhaseName::Page, PhaseName::Task, PhaseName::Paused] {
            let page = phase(name, None, &[Answer::Continue]);
            assert_keys(&page, &[(Key::Space, Answer::Continue), (Key::Enter, Answer::Continue)]);
            assert_eq!(hint(&page), "space or Enter: go on");
        }
        // While the reference is shown for comparison, space goes back and Enter may end the trial.
        let comparing = phase(PhaseName::Reference, Some(Asked::Match), &[Answer::Continue, Answer::Compare]);
        assert_keys(&comparing, &[(Key::Space, Answer::Compare), (Key::Enter, Answer::Continue)]);
    }

    #[test]
    fn keys_that_are_not_taken_say_what_they_commonly_mean() {
        let stimulus = Phase::new(PhaseName::Interval1, Presentation::stimulus(Alternative::Test), Some(1.0));
        let common = [
            (Key::Left, Answer::First),
            (Key::Right, Answer::Second),
            (c('1'), Answer::First),
            (c('2'), Answer::Second),
            (c('a'), Answer::First),
            (Key::Up, Answer::Up),
            (Key::Down, Answer::Down),
            (Key::Space, Answer::Continue),
            (Key::Enter, Answer::Continue),
            (Key::Tab, Answer::Select),
            (Key::Backspace, Answer::Erase),
            (c('5'), Answer::Option(5)),
        ];
        assert_keys(&stimulus, &common);
        for (key, _) in common {
            assert!(answer_for(key, &stimulus).is_some_and(|answer| !stimulus.takes(answer)));
        }
        assert_eq!((answer_for(c('x'), &stimulus), answer_for(c('0'), &stimulus)), (None, None));
        assert_eq!(shown_hint(&stimulus), None);
    }

    /// A letter that names one of two toggled pictures must not answer another question by accident.
    #[test]
    fn letters_answer_only_where_letters_are_asked_for() {
        let which = asking(Asked::WhichDegraded, &[Answer::First, Answer::Second]);
        for letter in ['a', 'b', 'y', 'n'] {
            assert_eq!(answer_for(c(letter), &which), None);
        }
        let toggle = asking(Asked::ToggleDegraded, &[Answer::Switch, Answer::First, Answer::Second]);
        assert_eq!(answer_for(c('y'), &toggle), None);
    }

    #[test]
    fn hints_name_the_keys_that_work() {
        let better = asking(Asked::WhichBetter, &[Answer::First, Answer::Same, Answer::Second]);
        assert_eq!(hint(&better), "1 or ←: the first     2 or space: the same     3 or →: the second");
        assert_eq!(answer_for(c('2'), &better), Some(Answer::Same));
        let scale = asking(Asked::Agreement, &(-3..=3).map(Answer::Option).collect::<Vec<_>>());
        assert_eq!(hint(&scale), "1–7: choose");
        let number = typing(Asked::Count, Typing::Number);
        assert_eq!(hint(&number), "Backspace: take back     Enter: done");
        // Over a stimulus nothing is written, whatever may be pressed.
        let adjust = Phase {
            presentation: Presentation::stimulus(Alternative::Test),
            ..asking(Asked::Adjust, &[Answer::Up, Answer::Down, Answer::Compare, Answer::Continue])
        };
        assert_eq!(hint(&adjust), "↑ ↓: change     space: compare     Enter: done");
        assert_eq!(shown_hint(&adjust), None);
    }
}
