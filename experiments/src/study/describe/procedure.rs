//! Procedures in words.

use crate::study::plan::{ProcedurePlan, StopRule};

/// The procedure, when it ends, and how many levels were left out because the display cannot show them.
pub(super) fn in_words(plan: &ProcedurePlan) -> (String, String, usize) {
    match plan {
        ProcedurePlan::Constant(constant) => {
            let procedure = format!("constant stimuli, {} × each level", constant.repetitions);
            (procedure, "after every level has had its repetitions".to_owned(), 0)
        }
        ProcedurePlan::QuestPlus(quest) => {
            let points = quest.m.len() * quest.omega0_deg.len() * quest.width.len() * quest.lapse.len();
            (
                format!(
                    "QUEST+ over the MAR model, {points} grid points, {}",
                    if quest.balanced { "every eccentricity equally often" } else { "any eccentricity" }
                ),
                stop_in_words(&quest.stop),
                quest.levels_beyond_display,
            )
        }
    }
}

fn stop_in_words(stop: &StopRule) -> String {
    let rules: Vec<String> = [("m", stop.m_relative_sd), ("omega0", stop.omega0_relative_sd)]
        .into_iter()
        .filter_map(|(name, sd)| Some(format!("{name} is known to {:.3} %", 100.0 * sd?)))
        .map(|rule| rule.replace(".000", ""))
        .collect();
    match rules.is_empty() {
        true => format!("after {} trials", stop.max_trials),
        false => format!(
            "after {} trials, or from {} on when {} (posterior SD / mean)",
            stop.max_trials,
            stop.min_trials,
            rules.join(" and ")
        ),
    }
}
