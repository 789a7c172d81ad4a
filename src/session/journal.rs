//! The journal's line format: one JSON object a line, numbered, timed, chained to the line before and closed by a CRC.
//!
//! A line is the event's JSON with two more members at its end: `"chain"`, the first 16 bytes of the SHA-256 of the line
//! before's chain and this event's JSON, in hex; and `"crc"`, the CRC-32 of all that stands before it. The CRC finds what
//! a disk did, the chain a line that was changed, left out or moved by someone who made the CRC right again. Readers other
//! than ours may ignore both. Journals of format 1 have the CRC alone.
//!
//! A kill can only tear the last line, so damage anywhere else is corruption and is said to be.

use experiments::session::Stamped;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// Length of `,"crc":"xxxxxxxx"}`.
const SEAL_BYTES: usize = 18;
/// Length of `,"chain":"…"}` with its 32 digits.
const CHAIN_BYTES: usize = 44;

/// What ties a line to all lines before it; nothing in format 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chain(Option<[u8; 16]>);

impl Chain {
    /// The chain before the first line of a journal in a format.
    #[must_use]
    pub fn start(format: u32) -> Self {
        Self((format >= 2).then_some([0; 16]))
    }

    /// The chain after a line with this JSON; nothing in format 1.
    fn after(self, json: &str) -> Option<[u8; 16]> {
        let before = self.0?;
        let digest = Sha256::new().chain_update(before).chain_update(json.as_bytes()).finalize();
        let mut first = [0; 16];
        first.copy_from_slice(&digest[..16]);
        Some(first)
    }
}

/// What a journal held.
#[derive(Debug, Clone, PartialEq)]
pub struct Journal {
    /// The events before the first damage, in order.
    pub events: Vec<Stamped>,
    /// The length, in bytes, of the part that holds them.
    pub sound_bytes: usize,
    /// The chain after them.
    pub chain: Chain,
    /// What was wrong after that, if anything.
    pub damage: Option<Damage>,
}

impl Journal {
    /// A journal that was never on a disk.
    #[must_use]
    pub fn in_memory(events: Vec<Stamped>) -> Self {
        Self { events, sound_bytes: 0, chain: Chain::start(super::header::FORMAT), damage: None }
    }
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

/// Writes one event as a chained and sealed line, with its newline, and moves the chain on.
#[must_use]
pub fn line_from_event(event: &Stamped, chain: &mut Chain) -> String {
    // The event types hold only strings, numbers and maps with string keys, which always serialise.
    let mut line = serde_json::to_string(event).unwrap_or_else(|_| "{}".to_owned());
    // Writing to a string cannot fail.
    if let Some(after) = chain.after(&line) {
        line.pop();
        let _ = write!(line, ",\"chain\":\"{}\"}}", hex(after));
        chain.0 = Some(after);
    }
    let crc = crc32fast::hash(line.as_bytes());
    line.pop();
    let _ = writeln!(line, ",\"crc\":\"{crc:08x}\"}}");
    line
}

fn hex(bytes: [u8; 16]) -> String {
    format!("{:032x}", u128::from_be_bytes(bytes))
}

/// Cuts `,"name":"value"}` of so many bytes from a line's end. Returns what stood before it, closed, and the value.
fn member_at_end(line: &str, bytes: usize, name: &str) -> Option<(String, String)> {
    let at = line.len().checked_sub(bytes)?;
    let (before, member) = line.is_char_boundary(at).then(|| line.split_at(at))?;
    let value = member.strip_prefix(",\"")?.strip_prefix(name)?.strip_prefix("\":\"")?.strip_suffix("\"}")?;
    Some((format!("{before}}}"), value.to_owned()))
}

fn event_from_line(line: &str, expected_seq: u64, chain: &mut Chain) -> Result<Stamped, String> {
    let (mut json, crc) =
        member_at_end(line, SEAL_BYTES, "crc").ok_or_else(|| "expected a line that ends with its CRC".to_owned())?;
    let found = format!("{:08x}", crc32fast::hash(json.as_bytes()));
    if found != crc {
        return Err(format!("expected CRC {crc}, found {found}"));
    }
    let mut said = None;
    if chain.0.is_some() {
        let (body, chained) = member_at_end(&json, CHAIN_BYTES, "chain")
            .ok_or_else(|| "expected a line with its chained hash".to_owned())?;
        (json, said) = (body, Some(chained));
    }
    let event: Stamped = serde_json::from_str(&json).map_err(|error| format!("expected a known event: {error}"))?;
    if event.seq != expected_seq {
        return Err(format!("expected event number {expected_seq}, found {}", event.seq));
    }
    if !event.t_s.is_finite() {
        return Err("expected a finite time".to_owned());
    }
    let after = chain.after(&json);
    if after.map(hex) != said {
        return Err("the chained hash does not follow from the lines before".to_owned());
    }
    chain.0 = after;
    Ok(event)
}

/// Reads a journal in a format up to its first damage.
#[must_use]
pub fn read(bytes: &[u8], format: u32) -> Journal {
    let mut journal = Journal { events: Vec::new(), sound_bytes: 0, chain: Chain::start(format), damage: None };
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
            .and_then(|line| event_from_line(line, journal.events.len() as u64, &mut journal.chain));
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

    fn sample(count: u64, format: u32) -> (Vec<Stamped>, Vec<u8>) {
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
        let mut chain = Chain::start(format);
        let bytes = events.iter().flat_map(|event| line_from_event(event, &mut chain).into_bytes()).collect();
        (events, bytes)
    }

    #[test]
    fn what_is_written_is_read() {
        for format in [1, 2] {
            let (events, bytes) = sample(5, format);
            let journal = read(&bytes, format);
            assert_eq!(journal.events, events);
            assert_eq!(journal.damage, None);
            assert_eq!(journal.sound_bytes, bytes.len());
            assert_eq!(read(b"", format).damage, None);
        }
    }

    /// A reader that knows nothing of chain and CRC reads the same events.
    #[test]
    fn lines_are_plain_json() {
        let (events, bytes) = sample(3, 2);
        for (line, event) in std::str::from_utf8(&bytes).expect("text").lines().zip(&events) {
            let value: serde_json::Value = serde_json::from_str(line).expect("JSON");
            assert_eq!(value["seq"], event.seq);
            assert_eq!(value["chain"].as_str().map(str::len), Some(32));
        }
    }

    #[test]
    fn every_cut_keeps_every_whole_line() {
        let (events, bytes) = sample(4, 2);
        for cut in 0..bytes.len() {
            let journal = read(&bytes[..cut], 2);
            let whole = bytes[..cut].iter().filter(|&&byte| byte == b'\n').count();
            assert_eq!(journal.events, events[..whole]);
            let at_line_end = cut == 0 || bytes[cut - 1] == b'\n';
            assert_eq!(journal.damage.is_none(), at_line_end, "cut at {cut}");
        }
    }

    #[test]
    fn every_flipped_bit_is_found() {
        for format in [1, 2] {
            let (events, bytes) = sample(3, format);
            let first_line = bytes.iter().position(|&byte| byte == b'\n').expect("lines") + 1;
            for at in 0..first_line {
                for bit in 0..8 {
                    let mut damaged = bytes.clone();
                    damaged[at] ^= 1 << bit;
                    let journal = read(&damaged, format);
                    assert!(journal.damage.is_some(), "byte {at} bit {bit}");
                    assert!(journal.events.len() < events.len());
                }
            }
        }
    }

    #[test]
    fn swapped_and_missing_lines_are_found() {
        for format in [1, 2] {
            let (_, bytes) = sample(3, format);
            let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
            for order in [[1, 0, 2].as_slice(), &[0, 2, 1], &[0, 2], &[1, 2]] {
                let mixed: Vec<u8> = order.iter().flat_map(|&i| lines[i].to_vec()).collect();
                assert!(matches!(read(&mixed, format).damage, Some(Damage::Corrupt { .. })), "{order:?}");
            }
        }
    }

    /// A line that is changed with its CRC made right again is found at that line when its chain was left, and at the next
    /// one when it was made right too.
    #[test]
    fn a_changed_line_with_a_right_crc_breaks_the_chain() {
        let (events, bytes) = sample(4, 2);
        let lines: Vec<&str> = std::str::from_utf8(&bytes).expect("text").split_inclusive('\n').collect();
        let reseal = |line: &str| {
            let json = format!("{}}}", &line[..line.len() - SEAL_BYTES - 1]);
            format!("{},\"crc\":\"{:08x}\"}}\n", &json[..json.len() - 1], crc32fast::hash(json.as_bytes()))
        };
        assert_eq!(reseal(lines[1]), lines[1]);
        let changed = reseal(&lines[1].replace("\"trial\":3", "\"trial\":4"));
        let journal = read([lines[0], &changed, lines[2], lines[3]].concat().as_bytes(), 2);
        assert!(matches!(journal.damage, Some(Damage::Corrupt { line: 2, .. })), "{:?}", journal.damage);

        let mut chain = Chain::start(2);
        let first = line_from_event(&events[0], &mut chain);
        let other = Stamped { t_s: 9.0, ..events[1].clone() };
        let second = line_from_event(&other, &mut chain);
        let journal = read([&first, second.as_str(), lines[2]].concat().as_bytes(), 2);
        assert!(matches!(journal.damage, Some(Damage::Corrupt { line: 3, .. })), "{:?}", journal.damage);
    }
}
