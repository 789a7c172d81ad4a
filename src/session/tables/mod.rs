//! `gaze.csv` and `frames.csv`: plain tables, written and read by one definition of each row.
//!
//! Numbers are written with as many digits as it takes to read the same value back, so a replay starts from exactly what
//! the run had. Empty cells mean "not known".
//!
//! Since format 2 the last column, `crc`, is the CRC-32 of the last cell of the line before (for the first row, of the
//! header line's CRC-32), as text, followed by the row's own text up to its last comma. So a row that was changed, left
//! out or moved is found, at its line. In Python: `zlib.crc32(f"{previous}{row}".encode())`.

pub mod cells;
mod frames;
mod gaze;
#[cfg(test)]
mod tests;

pub use frames::{FRAME_COLUMNS, FrameRow};
pub use gaze::{GAZE_COLUMNS, GazeRow};

use cells::{Cells, Line};
use rayon::prelude::*;
use std::marker::PhantomData;

/// The name of the column that seals each row.
const CRC: &str = "crc";
/// Bytes that are read by one thread at a time.
const CHUNK_BYTES: usize = 1 << 20;

/// A row of a table.
pub trait Row: Sized + Send {
    /// The columns, in their order, without the CRC.
    const COLUMNS: &'static [&'static str];
    /// With how many of them the oldest tables end.
    const FEWEST: usize;

    /// Writes its cells, in the order of its columns.
    fn write(&self, line: &mut Line);

    /// Reads its cells.
    ///
    /// # Errors
    /// What is wrong with a cell.
    fn read(cells: &mut Cells<'_>) -> Result<Self, String>;
}

/// How a table's lines look, and what the next one follows on.
#[derive(Debug, PartialEq, Eq)]
pub struct Layout<R> {
    /// Columns that the table has, without the CRC.
    columns: usize,
    /// The CRC of the line before; nothing in format 1.
    crc: Option<u32>,
    row: PhantomData<fn() -> R>,
}

impl<R> Copy for Layout<R> {}

impl<R> Clone for Layout<R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Row> Layout<R> {
    /// A new table in a session format. Returns its first line too, with its newline.
    #[must_use]
    pub fn new(format: u32) -> (Self, String) {
        let mut line = R::COLUMNS.join(",");
        if format >= 2 {
            line.push(',');
            line.push_str(CRC);
        }
        let crc = (format >= 2).then(|| crc32fast::hash(line.as_bytes()));
        line.push('\n');
        (Self { columns: R::COLUMNS.len(), crc, row: PhantomData }, line)
    }

    /// The same columns from the first line on, which is returned too.
    #[must_use]
    pub fn from_the_start(&self, format: u32) -> (Self, String) {
        let (whole, line) = Self::new(format);
        if self.columns == whole.columns {
            return (whole, line);
        }
        (Self { columns: self.columns, ..whole }, R::COLUMNS[..self.columns].join(",") + "\n")
    }

    /// Writes a row as a line, with its newline.
    #[must_use]
    pub fn line(&mut self, row: &R) -> String {
        let mut line = Line::default();
        row.write(&mut line);
        let mut text = line.into_text();
        if self.columns < R::COLUMNS.len() {
            // A table of an earlier version goes on as it was begun.
            let end = text.match_indices(',').nth(self.columns - 1).map_or(text.len(), |(at, _)| at);
            text.truncate(end);
        }
        if let Some(before) = self.crc {
            let crc = crc_after(before, text.as_bytes());
            self.crc = Some(crc);
            text.push(',');
            text.push_str(&crc.to_string());
        }
        text.push('\n');
        text
    }

    /// What a table's first line says of it.
    fn of_first_line(line: &str, format: u32) -> Result<Self, String> {
        let sealed = format >= 2;
        let names = if sealed { line.strip_suffix(&format!(",{CRC}")) } else { Some(line) };
        let columns = names.map(|names| names.split(',').collect::<Vec<_>>()).unwrap_or_default();
        let fewest = if sealed { R::COLUMNS.len() } else { R::FEWEST };
        if columns.len() < fewest || !R::COLUMNS.starts_with(&columns) {
            let end = if sealed { "crc" } else { "no more" };
            return Err(format!("line 1: expected the columns {}, {end}", R::COLUMNS.join(", ")));
        }
        let crc = sealed.then(|| crc32fast::hash(line.as_bytes()));
        Ok(Self { columns: columns.len(), crc, row: PhantomData })
    }
}

/// The CRC of a row after a line with the CRC `before`.
fn crc_after(before: u32, row: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(digits(before, &mut [0; 10]));
    hasher.update(row);
    hasher.finalize()
}

/// A number's decimal digits, without an allocation for every row.
fn digits(mut value: u32, buffer: &mut [u8; 10]) -> &[u8] {
    let mut at = buffer.len();
    loop {
        at -= 1;
        buffer[at] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            return &buffer[at..];
        }
    }
}

/// A table that was read: its sound rows, and a sentence for the rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Table<R> {
    /// Rows before the first damage.
    pub rows: Vec<R>,
    /// The length, in bytes, of the part that holds them, with the first line.
    pub sound_bytes: usize,
    /// How to go on after them; nothing if there is no first line.
    pub layout: Option<Layout<R>>,
    /// What was wrong after them.
    pub damage: Option<TableDamage>,
}

/// What is wrong with a table.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TableDamage {
    /// The last line is incomplete, as after a kill.
    #[error("the last line ({0} bytes) is torn")]
    Torn(usize),
    /// A whole line cannot be read; the text names it.
    #[error("{0}; the table was changed or the disk failed")]
    Corrupt(String),
    /// The journal says that more rows were on disk.
    #[error("{found} rows are left of at least {expected} that were on disk; the table was cut")]
    Missing {
        /// Rows that the journal knows of.
        expected: u64,
        /// Rows that there are.
        found: u64,
    },
}

/// Reads a table in a session format up to its first damage. A last line without newline is torn, as after a kill, and is
/// left out. Large tables are read by all processors.
#[must_use]
pub fn read_rows<R: Row>(bytes: &[u8], format: u32) -> Table<R> {
    let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    let torn = (whole < bytes.len()).then(|| TableDamage::Torn(bytes.len() - whole));
    let nothing = |damage| Table { rows: Vec::new(), sound_bytes: 0, layout: None, damage };
    let Some(first) = bytes[..whole].iter().position(|&byte| byte == b'\n') else {
        return nothing(Some(torn.unwrap_or(TableDamage::Torn(0))));
    };
    let layout = std::str::from_utf8(&bytes[..first])
        .map_err(|_| "line 1: expected UTF-8".to_owned())
        .and_then(|line| Layout::<R>::of_first_line(line, format));
    let mut layout = match layout {
        Ok(layout) => layout,
        Err(problem) => return nothing(Some(TableDamage::Corrupt(problem))),
    };

    let chunks = chunks(&bytes[first + 1..whole]);
    let parts: Vec<Part<R>> = chunks
        .par_iter()
        .map(|&(from, to)| {
            // A chunk follows on the CRC that the line before it claims; whether that was true is for the chunk before.
            let before = if from == 0 { layout.crc } else { claimed_crc(&bytes[first + 1..first + 1 + from]) };
            read_chunk(&bytes[first + 1 + from..first + 1 + to], Layout { crc: layout.crc.and(before), ..layout })
        })
        .collect();

    let mut rows = Vec::with_capacity(parts.iter().map(|part| part.rows.len()).sum());
    let mut sound_bytes = first + 1;
    let mut damage = torn;
    for part in parts {
        rows.extend(part.rows);
        sound_bytes += part.sound_bytes;
        layout.crc = part.crc;
        if let Some(problem) = part.problem {
            damage = Some(TableDamage::Corrupt(format!("line {}: {problem}", rows.len() + 2)));
            break;
        }
    }
    Table { rows, sound_bytes, layout: Some(layout), damage }
}

/// What one thread has read.
struct Part<R> {
    rows: Vec<R>,
    sound_bytes: usize,
    crc: Option<u32>,
    problem: Option<String>,
}

fn read_chunk<R: Row>(bytes: &[u8], layout: Layout<R>) -> Part<R> {
    let mut part = Part { rows: Vec::new(), sound_bytes: 0, crc: layout.crc, problem: None };
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let text = &line[..line.len() - 1];
        match read_line(text, layout.columns, part.crc) {
            Ok((row, crc)) => {
                part.rows.push(row);
                part.sound_bytes += line.len();
                part.crc = crc;
            }
            Err(problem) => {
                part.problem = Some(problem);
                break;
            }
        }
    }
    part
}

fn read_line<R: Row>(line: &[u8], columns: usize, before: Option<u32>) -> Result<(R, Option<u32>), String> {
    let text = std::str::from_utf8(line).map_err(|_| "expected UTF-8".to_owned())?;
    let (row, crc) = match before {
        None => (text, None),
        Some(before) => {
            let (row, said) = text.rsplit_once(',').ok_or_else(|| "expected a row with its CRC".to_owned())?;
            let found = crc_after(before, row.as_bytes());
            // As text, so that no other way to write the same number passes.
            if digits(found, &mut [0; 10]) != said.as_bytes() {
                return Err(format!("expected CRC {said}, found {found}"));
            }
            (row, Some(found))
        }
    };
    let mut cells = Cells::new(row, R::COLUMNS, columns);
    let value = R::read(&mut cells)?;
    cells.end()?;
    Ok((value, crc))
}

/// The last cell of the last line, as a number; 0, which no line then follows on, if it is none.
fn claimed_crc(bytes: &[u8]) -> Option<u32> {
    let end = bytes.len().checked_sub(1)?;
    let start = bytes[..end].iter().rposition(|&byte| byte == b',' || byte == b'\n').map_or(0, |at| at + 1);
    Some(std::str::from_utf8(&bytes[start..end]).ok().and_then(|text| text.parse().ok()).unwrap_or(0))
}

/// Cuts whole lines into chunks: where each begins and ends.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut chunks = Vec::new();
    let mut from = 0;
    while from < bytes.len() {
        let least = (from + CHUNK_BYTES).min(bytes.len()) - 1;
        let to = bytes[least..].iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |at| least + at + 1);
        chunks.push((from, to));
        from = to;
    }
    chunks
}
