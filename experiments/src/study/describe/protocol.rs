//! Protocols in words.

use crate::study::plan::ProtocolPlan;

/// The protocol with its timing.
pub(super) fn in_words(plan: &ProtocolPlan) -> String {
    match plan {
        ProtocolPlan::TwoInterval(timing) => format!(
            "two intervals: fixation {} s, {} s each, gap {} s, answer {}",
            timing.fixation_s,
            timing.interval_s,
            timing.gap_s,
            within(timing.answer_timeout_s)
        ),
    }
}

fn within(timeout_s: Option<f64>) -> String {
    timeout_s.map_or_else(|| "without limit".to_owned(), |timeout_s| format!("within {timeout_s} s"))
}
