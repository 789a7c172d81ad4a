//! Handing sessions on: tables that R, pandas and spreadsheets read without us.
//!
//! One file for each format. Every column of every table is described in [`columns`], and a test holds the description
//! against what is written.

pub mod columns;
pub mod csv;
