//! Calibration by simulation, at full length: are the intervals as wide as they say?
//!
//!     cargo run --release -p analysis --example calibration -- psychometric 2000
//!     cargo run --release -p analysis --example calibration -- mar 2000
//!     cargo run --release -p analysis --example calibration -- mar-group 400 12
//!
//! prints the tables that `analysis/CALIBRATION.md` holds. The tests run the same simulations, shorter.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod mar;
mod psychometric;
mod ranks;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |index: usize, default: usize| arguments.get(index).and_then(|a| a.parse().ok()).unwrap_or(default);
    match arguments.first().map(String::as_str) {
        Some("psychometric") => psychometric::print(number(1, 2000)),
        Some("mar") => mar::print(number(1, 2000), number(2, mar::SEED as usize) as u64),
        Some("mar-group") => mar::print_groups(number(1, 400), number(2, 12), number(3, mar::SEED as usize) as u64),
        _ => {
            eprintln!("calibration psychometric [FITS] | mar [FITS] [SEED] | mar-group [GROUPS] [OBSERVERS] [SEED]");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}
