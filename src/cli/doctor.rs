//! `parafovea doctor`: what is wrong with sessions, and repaired copies.

use super::{print, print_json, say};
use crate::doctor::repair::repair;
use crate::doctor::{Diagnosis, Finding, Severity, State, examine};
use crate::error::LabError;
use clap::Args;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct DoctorArgs {
    /// Session folders.
    #[arg(required = true)]
    sessions: Vec<PathBuf>,
    /// Write a copy of each session that is not complete, ending where it is sound; the session stays as it is.
    #[arg(long)]
    repair: bool,
    /// Where the repaired copy of a single session goes; SESSION-repaired if not given.
    #[arg(long, value_name = "DIR", requires = "repair")]
    out: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DoctorArgs) -> Result<(), LabError> {
    if args.out.is_some() && args.sessions.len() > 1 {
        return Err(LabError::BadInput("--out: expected one session with it, found several".to_owned()));
    }
    let all: Vec<Diagnosis> = args.sessions.iter().map(|path| examine(path)).collect::<Result<_, _>>()?;
    if args.json {
        print_json(&all)?;
    } else {
        print(&all.iter().map(in_words).collect::<Vec<_>>().join("\n"))?;
    }
    if args.repair {
        for diagnosis in all.iter().filter(|diagnosis| diagnosis.state != State::Complete) {
            let copy = repair(&diagnosis.session, args.out.as_deref())?;
            say(&format!(
                "{}: a repaired copy is in {}; analyse one of the two, not both",
                diagnosis.session.display(),
                copy.display()
            ));
        }
        return Ok(());
    }
    match all.iter().filter(|diagnosis| diagnosis.state >= State::Damaged).count() {
        0 => Ok(()),
        bad => {
            Err(LabError::Failed(format!("{bad} of {} sessions are damaged; --repair writes sound copies", all.len())))
        }
    }
}

fn in_words(diagnosis: &Diagnosis) -> String {
    let mut text = format!("{}: {}", diagnosis.session.display(), diagnosis.state.in_words());
    if let (Some(study), Some(observer), Some(program), Some(format)) =
        (&diagnosis.study, &diagnosis.observer, &diagnosis.program, diagnosis.format)
    {
        let _ = write!(text, "\n  study {study}, observer {observer}; format {format}, {program}");
        let counts = &diagnosis.counts;
        let _ = write!(
            text,
            "\n  {} events; {} trials, {} answered; {}",
            counts.events,
            counts.trials,
            counts.answered,
            if counts.parts == 1 { "in one go".to_owned() } else { format!("in {} parts", counts.parts) }
        );
        let rate = counts.gaze_rate_hz.map_or_else(String::new, |rate| format!(" at {rate:.1} Hz"));
        let lost = counts.gaze_lost.map_or_else(String::new, |lost| format!(", eye not seen in {:.1} %", 100.0 * lost));
        let _ = write!(
            text,
            "\n  {} gaze samples{rate}{lost}, {} gaps; {} frames, {} late",
            counts.gaze_samples, counts.gaze_gaps, counts.frames, counts.missed_frames
        );
    }
    for Finding { severity, file, what } in &diagnosis.findings {
        let word = match severity {
            Severity::Note => "note",
            Severity::Warning => "look at",
            Severity::Damage => "damage",
        };
        let file = file.as_ref().map_or_else(String::new, |file| format!("{file}: "));
        let _ = write!(text, "\n  {word}: {file}{what}");
    }
    text
}
