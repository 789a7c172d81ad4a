//! Handing sessions on: files that R, pandas, spreadsheets and the tools of the field read without us.
//!
//! [`tables`] says once what every table holds, as typed cells; [`mod@csv`] and [`mod@parquet`] write the same cells in two ways,
//! and [`psych_ds`] arranges them as that standard asks. [`bids`] has tables of its own. Every column is described in
//! [`columns`]. [`find`] looks for sessions, [`staging`] makes an export whole or not there.

pub mod bids;
pub mod cells;
pub mod columns;
pub mod csv;
pub mod find;
pub mod labels;
pub mod parquet;
pub mod psych_ds;
pub mod staging;
pub mod tables;

use std::path::PathBuf;

/// Files that were written, each with its number of rows (without a header line).
pub type Written = Vec<(PathBuf, usize)>;
