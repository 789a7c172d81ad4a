//! What is wrong with a file, and what was left out of it: each tied to an element by its place in the JSON.

use std::fmt;
use std::path::{Path, PathBuf};

/// How many mistakes are printed before the rest is only counted.
const MOST_PRINTED: usize = 20;
/// How many mistakes are kept of one file.
const MOST_KEPT: usize = 1000;

/// Why a file cannot be shown: every mistake that was found.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", printed(.file, .mistakes, *.left_out))]
pub struct WorldError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it; never empty.
    pub mistakes: Vec<Mistake>,
    /// How many more mistakes there are than are kept here.
    pub left_out: usize,
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// The element, such as `meshes[3].primitives[0].attributes.POSITION`; empty where it is the file itself.
    pub place: String,
    /// What is wrong there, and what was expected.
    pub message: String,
}

/// Something in a file that is left out or shown otherwise than the file asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    /// The first element of which this is so.
    pub place: String,
    /// What is done instead.
    pub message: String,
    /// Of how many elements it is so.
    pub count: usize,
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place.as_str() {
            "" => f.write_str(&self.message),
            place => write!(f, "{place}: {}", self.message),
        }
    }
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            1 => write!(f, "{}: {}", self.place, self.message),
            count => write!(f, "{} and {} more: {}", self.place, count - 1, self.message),
        }
    }
}

fn printed(file: &Path, mistakes: &[Mistake], left_out: usize) -> String {
    let file = file.display();
    if let ([only], 0) = (mistakes, left_out) {
        return format!("{file}: {only}");
    }
    let mut text = format!("{file}: {} mistakes", mistakes.len() + left_out);
    for mistake in mistakes.iter().take(MOST_PRINTED) {
        text.push_str(&format!("\n  {mistake}"));
    }
    let more = left_out + mistakes.len().saturating_sub(MOST_PRINTED);
    if more > 0 {
        text.push_str(&format!("\n  and {more} more"));
    }
    text
}

/// Collects what is wrong and what is left out while a file is read.
#[derive(Debug)]
pub(crate) struct Findings {
    file: PathBuf,
    mistakes: Vec<Mistake>,
    left_out: usize,
    notices: Vec<Notice>,
}

impl Findings {
    pub(crate) fn new(file: &Path) -> Self {
        Self { file: file.to_owned(), mistakes: Vec::new(), left_out: 0, notices: Vec::new() }
    }

    /// Adds a mistake.
    pub(crate) fn wrong(&mut self, place: impl Into<String>, message: impl Into<String>) {
        if self.mistakes.len() < MOST_KEPT {
            self.mistakes.push(Mistake { place: place.into(), message: message.into() });
        } else {
            self.left_out += 1;
        }
    }

    /// Adds a notice; the same one of another element is counted with the first.
    pub(crate) fn note(&mut self, place: impl Into<String>, message: impl Into<String>) {
        let message = message.into();
        match self.notices.iter_mut().find(|notice| notice.message == message) {
            Some(notice) => notice.count += 1,
            None => self.notices.push(Notice { place: place.into(), message, count: 1 }),
        }
    }

    /// Whether anything has been found wrong so far.
    pub(crate) fn any(&self) -> bool {
        !self.mistakes.is_empty()
    }

    /// What has been left out so far, as one sentence.
    pub(crate) fn left_out(&self) -> String {
        let all: Vec<String> = self.notices.iter().map(ToString::to_string).collect();
        all.join("; ")
    }

    /// An error, if anything has been found wrong so far.
    pub(crate) fn check(&mut self) -> Result<(), WorldError> {
        if self.mistakes.is_empty() {
            return Ok(());
        }
        let mistakes = std::mem::take(&mut self.mistakes);
        Err(WorldError { file: self.file.clone(), mistakes, left_out: self.left_out })
    }

    /// An error with one more mistake.
    pub(crate) fn refuse(&mut self, place: impl Into<String>, message: impl Into<String>) -> WorldError {
        self.wrong(place, message);
        let mistakes = std::mem::take(&mut self.mistakes);
        WorldError { file: self.file.clone(), mistakes, left_out: self.left_out }
    }

    /// The notices, if nothing is wrong.
    pub(crate) fn finish(mut self) -> Result<Vec<Notice>, WorldError> {
        self.check()?;
        Ok(self.notices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mistakes_are_printed_at_their_places_and_counted() {
        let mut findings = Findings::new(Path::new("a.gltf"));
        findings.wrong("nodes[1].mesh", "there is no mesh 7");
        assert_eq!(findings.check().unwrap_err().to_string(), "a.gltf: nodes[1].mesh: there is no mesh 7");
        for i in 0..1030 {
            findings.wrong(format!("nodes[{i}]"), "x");
        }
        let text = findings.check().unwrap_err().to_string();
        assert!(
            text.starts_with("a.gltf: 1030 mistakes\n  nodes[0]: x\n")
                && text.ends_with("nodes[19]: x\n  and 1010 more")
        );
    }

    #[test]
    fn equal_notices_are_counted() {
        let mut findings = Findings::new(Path::new("a.gltf"));
        findings.note("meshes[0]", "points are left out");
        findings.note("meshes[4]", "points are left out");
        let notices = findings.finish().unwrap();
        assert_eq!(notices.len(), 1);
        assert_eq!(notices[0].to_string(), "meshes[0] and 1 more: points are left out");
    }
}
