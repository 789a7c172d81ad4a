//! The blocks of an analysis as tables for a terminal, one kind for every family of protocols.

use analysis::answers::group::GroupRow;
use analysis::answers::{BlockSummary, Detection, Matches, Ratings, Summary, Tasks, part_name};
use analysis::shares::{Mean, Share};
use analysis::summary::FormSummary;
use experiments::trial::form::Entry;
use std::fmt::Write as _;

/// Rows of a table at most; `--json` has all.
const MOST_ROWS: usize = 40;

/// A block's results.
pub(super) fn table(block: &BlockSummary) -> String {
    let protocol = block.protocol.map_or("unknown protocol", |protocol| protocol.as_str());
    let mut text = format!("\n  block {} ({protocol}), {} trials\n\n", block.block, block.trials);
    match &block.summary {
        Summary::Detection(summary) => detection(&mut text, summary),
        Summary::Matches(summary) => matches(&mut text, summary),
        Summary::Ratings(summary) => ratings(&mut text, summary),
        Summary::Tasks(summary) => tasks(&mut text, summary),
        Summary::Nothing { reason } => {
            let _ = writeln!(text, "  nothing to report: {reason}");
        }
    }
    text
}

/// Means over observers.
pub(super) fn group(rows: &[GroupRow]) -> String {
    let mut table = vec![row(["block", "quantity", "trials", "observers", "mean", "SD", "95 % interval"])];
    table.extend(rows.iter().map(|row| {
        let mut cells = vec![row.block.clone(), row.quantity.clone(), part_name(&row.by)];
        cells.extend(mean(&row.over_observers));
        cells
    }));
    format!("over observers, each counted once\n\n{}", aligned(table))
}

/// What was entered in forms.
pub(super) fn forms(forms: &[FormSummary]) -> String {
    if forms.is_empty() {
        return String::new();
    }
    let mut table = vec![row(["form", "item", "entry"])];
    for form in forms {
        table.extend(form.entries.iter().map(|(item, entry)| {
            let entry = match entry {
                Entry::Number(number) => number.to_string(),
                Entry::Text(text) => text.clone(),
            };
            vec![form.form.clone(), item.clone(), entry]
        }));
    }
    format!("\n{}", aligned(table))
}

fn detection(text: &mut String, detection: &Detection) {
    let parameter = detection.parameter().unwrap_or("level");
    let mut table = vec![row(["trials", "n", "right", "95 % (Wilson)", "threshold", "95 % interval", "unnoticed"])];
    let mut notes = Vec::new();
    for part in &detection.parts {
        let name = part_name(&part.by);
        // A pair test's third answer has a fit of its own, which allows for it.
        let function = match &part.comparison {
            Some(fit) => Some((fit.threshold, &fit.support)),
            None => part.fit.as_ref().map(|fit| (fit.threshold, &fit.support)),
        };
        let [threshold, ends] = function.map_or([None, None], |(threshold, support)| {
            let mark = if support.is_supported() { "" } else { " *" };
            [Some(number(threshold.estimate) + mark), Some(interval(threshold.ci95))]
        });
        let dash = || "–".to_owned();
        let mut cells = vec![name.clone(), part.right.n.to_string()];
        cells.extend(share(&part.right));
        cells.extend([threshold.unwrap_or_else(dash), ends.unwrap_or_else(dash)]);
        cells.push(part.coarsest_unnoticed.map_or_else(dash, number));
        table.push(cells);
        if let Some(reason) = &part.no_fit {
            notes.push(format!("no function for {name}: {reason}"));
        }
        let reasons = function.into_iter().flat_map(|(_, support)| support.reasons());
        notes.extend(reasons.map(|reason| format!("* THE DATA DO NOT SUPPORT the function for {name}: {reason}")));
    }
    text.push_str(&aligned(table));
    let _ = writeln!(text, "\n  right: {}; threshold and unnoticed are values of {parameter}", detection.right_means);
    if detection.parts.iter().any(|part| part.coarsest_unnoticed.is_some()) {
        let _ = writeln!(
            text,
            "  unnoticed: the coarsest {parameter} that was once not told apart (Guenter 2012); it has no interval"
        );
    }
    for note in notes {
        let _ = writeln!(text, "  {note}");
    }
    if let Some(all) = detection.parts.first() {
        let mut head: Vec<String> = detection.parameters.clone();
        head.extend(row(["n", "right", "95 % (Wilson)"]));
        let mut table = vec![head];
        table.extend(all.cells.iter().map(|cell| {
            let value = |name: &String| cell.level.get(name).map_or_else(|| "–".to_owned(), ToString::to_string);
            let mut cells: Vec<String> = detection.parameters.iter().map(value).collect();
            cells.push(cell.right.n.to_string());
            cells.extend(share(&cell.right));
            cells
        }));
        let _ = write!(text, "\n{}", aligned(table));
    }
}

fn matches(text: &mut String, matches: &Matches) {
    let mut table = vec![row(["quantity", "trials", "n", "mean", "SD", "95 % interval", "median"])];
    for part in &matches.parts {
        for quantity in &part.quantities {
            let mut cells = vec![quantity.quantity.clone(), part_name(&part.by)];
            cells.extend(mean(&quantity.mean));
            cells.push(number(quantity.median));
            table.push(cells);
        }
    }
    text.push_str(&aligned(table));
}

fn ratings(text: &mut String, ratings: &Ratings) {
    for item in &ratings.items {
        let mut head = row(["trials", "n", "mean", "SD", "95 % interval"]);
        head.extend((item.steps[0]..=item.steps[1]).map(|step| step.to_string()));
        let mut table = vec![head];
        for part in &ratings.parts {
            for rating in part.items.iter().filter(|rating| rating.item == item.item) {
                let mut cells = vec![part_name(&part.by)];
                cells.extend(mean(&rating.mean));
                cells.extend(rating.counts.iter().map(|count| count.n.to_string()));
                table.push(cells);
            }
        }
        let _ = write!(text, "  {}\n{}", item.item, aligned(table));
    }
}

fn tasks(text: &mut String, tasks: &Tasks) {
    let head = [
        "trials",
        "n",
        "recognised",
        "95 % (Wilson)",
        "95 % (exact)",
        "equal",
        "test better",
        "counts exact",
        "off by",
    ];
    let mut table = vec![row(head)];
    for part in &tasks.parts {
        let mut cells = vec![part_name(&part.by), part.recognised.n.to_string()];
        cells.extend(share(&part.recognised));
        cells.push(interval(part.recognised.exact95));
        cells.extend([&part.equal, &part.test_better].map(|share| number(share.share)));
        let counting = part.counting.as_ref();
        cells.push(counting.map_or_else(|| "–".to_owned(), |c| format!("{}/{}", c.exact.k, c.exact.n)));
        cells.push(counting.map_or_else(|| "–".to_owned(), |c| number(c.absolute_error.mean)));
        table.push(cells);
    }
    text.push_str(&aligned(table));
    text.push_str("\n  recognised: the reference was named as the better one\n");
}

fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.iter().map(|cell| (*cell).to_owned()).collect()
}

/// Three significant digits or more, never fewer than the whole part.
fn number(value: f64) -> String {
    let digits = if value.abs() >= 100.0 {
        0
    } else if value.abs() >= 1.0 {
        2
    } else {
        4
    };
    format!("{value:.digits$}")
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("{} – {}", number(low), number(high))
}

fn share(share: &Share) -> [String; 2] {
    [format!("{}/{} = {:.3}", share.k, share.n, share.share), interval(share.wilson95)]
}

fn mean(mean: &Mean) -> [String; 4] {
    let dash = || "–".to_owned();
    [mean.n.to_string(), number(mean.mean), mean.sd.map_or_else(dash, number), mean.ci95.map_or_else(dash, interval)]
}

/// Columns as wide as their widest cell, the first ones to the left; rows beyond the most are counted.
fn aligned(mut table: Vec<Vec<String>>) -> String {
    let left_out = table.len().saturating_sub(MOST_ROWS + 1);
    table.truncate(MOST_ROWS + 1);
    let columns = table.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|column| {
            table.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
        })
        .collect();
    let mut text = String::new();
    for row in &table {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(text, "  {}", cells.join("   ").trim_end());
    }
    if left_out > 0 {
        let _ = writeln!(text, "  … and {left_out} more rows in --json");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_and_long_tables_say_what_they_leave_out() {
        let mut table = vec![row(["name", "n"]), row(["ω", "12"])];
        assert_eq!(aligned(table.clone()), "  name   n\n  ω      12\n");
        table.extend((0..50).map(|i| vec!["x".to_owned(), i.to_string()]));
        assert!(aligned(table).ends_with("… and 11 more rows in --json\n"));
    }

    #[test]
    fn numbers_keep_their_digits() {
        assert_eq!([0.00352, 14.9, 128.4, -2.5].map(number), ["0.0035", "14.90", "128", "-2.50"]);
    }
}
