//! Labels: what BIDS and Psych-DS call observers, sessions and studies in file names, where only letters and digits are allowed.

use crate::error::LabError;
use crate::session::SessionFolder;
use std::collections::{BTreeMap, BTreeSet};

/// What one session is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    /// Its observer.
    pub subject: String,
    /// Its number among the observer's sessions, `01`, `02` …, in the order in which they were begun.
    pub session: String,
    /// Its study.
    pub task: String,
}

/// The letters and digits of a text.
#[must_use]
pub fn label(text: &str) -> String {
    text.chars().filter(char::is_ascii_alphanumeric).collect()
}

/// Labels for sessions, in their order.
///
/// # Errors
/// When an observer or a study has no letter or digit, or two would be called the same (upper and lower case are the same to
/// many file systems).
pub fn labels(sessions: &[SessionFolder]) -> Result<Vec<Labels>, LabError> {
    let mut problems = Vec::new();
    for (what, names) in [
        ("observers", names(sessions, |session| &session.header.observer)),
        ("studies", names(sessions, |session| &session.header.study.name)),
    ] {
        let mut by_label: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for name in &names {
            by_label.entry(label(name).to_lowercase()).or_default().push(name);
        }
        for (label, names) in by_label {
            if label.is_empty() {
                problems.push(format!("{what}: \"{}\" has no letter or digit to be called by", names.join("\", \"")));
            } else if names.len() > 1 {
                problems.push(format!("{what}: \"{}\" would all be called \"{label}\"", names.join("\", \"")));
            }
        }
    }
    if !problems.is_empty() {
        return Err(LabError::BadInput(format!(
            "file names of this format have only letters and digits. {}. Export them apart.",
            problems.join("; ")
        )));
    }

    let mut labels: Vec<Labels> = sessions
        .iter()
        .map(|session| Labels {
            subject: label(&session.header.observer),
            session: String::new(),
            task: label(&session.header.study.name),
        })
        .collect();
    let mut order: Vec<usize> = (0..sessions.len()).collect();
    order.sort_by_key(|&index| begun(&sessions[index]));
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    for index in order {
        let number = count.entry(labels[index].subject.clone()).or_default();
        *number += 1;
        labels[index].session = format!("{number:02}");
    }
    Ok(labels)
}

fn names<'a>(sessions: &'a [SessionFolder], name: impl Fn(&'a SessionFolder) -> &'a String) -> BTreeSet<&'a str> {
    sessions.iter().map(|session| name(session).as_str()).collect()
}

/// When a session was begun, for sorting; by its own text if that is no time.
fn begun(session: &SessionFolder) -> (Option<chrono::DateTime<chrono::Utc>>, String, String) {
    (begun_utc(session), session.header.started.clone(), session.name())
}

/// When a session was begun, if its header says so in RFC 3339.
pub(super) fn begun_utc(session: &SessionFolder) -> Option<chrono::DateTime<chrono::Utc>> {
    chrono::DateTime::parse_from_rfc3339(&session.header.started).ok().map(|time| time.to_utc())
}

#[cfg(test)]
mod tests {
    use super::label;

    #[test]
    fn labels_are_letters_and_digits() {
        assert_eq!(label("P-01_ä b"), "P01b");
        assert_eq!(label("--"), "");
    }
}
