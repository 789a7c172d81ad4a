//! The journal's line format: one JSON object a line, numbered, timed, closed by the CRC-32 of what stands before it.
//!
//! A line is the event's JSON with `"crc":"xxxxxxxx"` as its last member; the CRC covers the JSON without that member.
//! Readers other than ours may ignore it. A kill can only tear the last line, so damage anywhere else is corruption and
//! is said to be.

use experiments::session::Stamped;
use std::fmt::Write as _;

/// Length of `,"crc":"xxxxxxxx"}`.
const SEAL_BYTES: usize = 18;

/// What a journal held.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Journal {
    /// The events before the first damage, in order.
    pub events: Vec<Stamped>,
    /// The length, in bytes, of the part that holds them.
    pub sound_bytes: usize,
    /// What was wrong after that, if anything.
    pub damage: Option<Damage>,
}

/// What is wrong with a journal, and from where on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// The last line is incomplete, as after a kill: it was never acknowledged and can be cut.
    #[error("the last line (line {line}, {bytes} bytes) is torn, as after a kill; it was never acknowledged")]
    TornTail {
        /// Its number, from 1.
        line: usize,
        /// Its length.
        bytes: usize,
    },
    /// A line in the middle fails its check, or the last line does though it was complete.
    #[error("line {line}: {problem}; the journal was changed or the disk failed")]
    Corrupt {
        /// Its number, from 1.
        line: usize,
        /// What the line should have been.
        problem: String,
    },
}

/// Writes one event as a sealed line, with its newline.
#[must_use]
pub fn line_from_event(event: &Stamped) -> String {
    // The event types hold only strings, numbers and maps with string keys, which always serialise.
    let mut line = serde_json::to_string(event).unwrap_or_else(|_| "{}".to_owned());
    let crc = crc32fast::hash(line.as_bytes());
    line.pop();
    // Writing to a string cannot fail.
    let _ = writeln!(line, ",\"crc\":\"{crc:08x}\"}}");
    line
}

fn event_from_line(line: &str, expected_seq: u64) -> Result<Stamped, String> {
    let seal = line.len().checked_sub(SEAL_BYTES).and_then(|at| line.is_char_boundary(at).then(|| line.split_at(at)));
    let Some((body, seal)) = seal else {
        return Err("expected an event with its CRC".to_owned());
    };
    let crc = seal.strip_prefix(",\"crc\":\"").and_then(|rest| rest.strip_suffix("\"}"));
    let Some(crc) = crc else {
        return Err("expected a line that ends with its CRC".to_owned());
    };
    let json = format!("{body}}}");
    let found = format!("{:08x}", crc32fast::hash(json.as_bytes()));
    if found != crc {
        return Err(format!("expected CRC {crc}, found {found}"));
    }
    let event: Stamped = serde_json::from_str(&json).map_err(|error| format!("expected a known event: {error}"))?;
    if event.seq != expected_seq {
        return Err(format!("expected event number {expected_seq}, found {}", event.seq));
    }
    if !event.t_s.is_finite() {
        return Err("expected a finite time".to_owned());
    }
    Ok(event)
}

/// Reads a journal up to its first damage.
#[must_use]
pub fn read(bytes: &[u8]) -> Journal {
    let mut journal = Journal::default();
    let mut number = 0;
    while journal.sound_bytes < bytes.len() {
        number += 1;
        let rest = &bytes[journal.sound_bytes..];
        let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
            journal.damage = Some(Damage::TornTail { line: number, bytes: rest.len() });
            break;
        };
        let parsed = std::str::from_utf8(&rest[..end])
            .map_err(|_| "expected UTF-8".to_owned())
            .and_then(|line| event_from_line(line, journal.events.len() as u64));
        match parsed {
            Ok(event) => {
                journal.events.push(event);
                journal.sound_bytes += end + 1;
            }
            Err(problem) => {
                journal.damage = Some(Damage::Corrupt { line: number, problem });
                break;
            }
        }
    }
    journal
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::session::Event;
    use experiments::trial::PhaseName;

    fn sample(count: u64) -> (Vec<Stamped>, Vec<u8>) {
        let events: Vec<Stamped> = (0..count)
            .map(|seq| Stamped {
                seq,
                t_s: 0.1 * seq as f64 + 1.0 / 3.0,
                event: Event::PhaseBegan {
                    trial: Some(3),
                    phase: PhaseName::Interval1,
                    shown: None,
                    at: Default::default(),
                },
            })
            .collect();
        let bytes = events.iter().flat_map(|event| line_from_event(event).into_bytes()).collect();
        (events, bytes)
    }

    #[test]
    fn what_is_written_is_read() {
        let (events, bytes) = sample(5);
        let journal = read(&bytes);
        assert_eq!(journal.events, events);
        assert_eq!(journal.damage, None);
        assert_eq!(journal.sound_bytes, bytes.len());
        assert_eq!(read(b""), Journal::default());
    }

    #[test]
    fn every_cut_keeps_every_whole_line() {
        let (events, bytes) = sample(4);
        for cut in 0..bytes.len() {
            let journal = read(&bytes[..cut]);
            let whole = bytes[..cut].iter().filter(|&&byte| byte == b'\n').count();
            assert_eq!(journal.events, events[..whole]);
            let at_line_end = cut == 0 || bytes[cut - 1] == b'\n';
            assert_eq!(journal.damage.is_none(), at_line_end, "cut at {cut}");
        }
    }

    #[test]
    fn every_flipped_bit_is_found() {
        let (events, bytes) = sample(3);
        let first_line = bytes.iter().position(|&byte| byte == b'\n').expect("lines") + 1;
        for at in 0..first_line {
            for bit in 0..8 {
                let mut damaged = bytes.clone();
                damaged[at] ^= 1 << bit;
                let journal = read(&damaged);
                assert!(journal.damage.is_some(), "byte {at} bit {bit}");
                assert!(journal.events.len() < events.len());
            }
        }
    }

    #[test]
    fn swapped_and_missing_lines_are_found() {
        let (_, bytes) = sample(3);
        let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
        for order in [[1, 0, 2].as_slice(), &[0, 2, 1], &[0, 2], &[1, 2]] {
            let mixed: Vec<u8> = order.iter().flat_map(|&i| lines[i].to_vec()).collect();
            assert!(matches!(read(&mixed).damage, Some(Damage::Corrupt { .. })), "{order:?}");
        }
    }
}
