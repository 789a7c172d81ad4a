//! What each block's answers come to: a table and a figure for every family of protocols, means over observers, forms.

use super::{Cell, ReportInput, Table, analysis};
use crate::answers::group::GroupRow;
use crate::answers::{BlockSummary, Detection, Matches, Ratings, Summary, Tasks, part_name};
use crate::figures;
use crate::psychometric::{Guess, PsychometricFit};
use crate::shares::{Mean, Share};
use crate::summary::FormSummary;
use crate::svg::escape;
use crate::text::{figure, significant};
use experiments::trial::form::Entry;

/// Rows of a table at most; the page's JSON holds all.
const MOST_ROWS: usize = 60;

/// One block of an observer.
pub(super) fn block(block: &BlockSummary) -> String {
    let protocol = block.protocol.map_or("unknown protocol", |protocol| protocol.as_str());
    let mut html = format!(
        "<h3>Block {}</h3>\n<p>{} of study {}: {} answered trials{}.</p>\n",
        escape(&block.block),
        escape(protocol),
        escape(&block.study),
        block.trials,
        block
            .response_time_s
            .map_or_else(String::new, |time| format!(", answered in {} s on average", significant(time.mean, 3)))
    );
    html.push_str(&match &block.summary {
        Summary::Detection(summary) => detection(summary),
        Summary::Matches(summary) => matches(summary),
        Summary::Ratings(summary) => ratings(summary),
        Summary::Tasks(summary) => tasks(summary),
        Summary::Nothing { reason } => format!("<p class=\"note\">Nothing to report: {}.</p>\n", escape(reason)),
    });
    html
}

/// Share and Wilson interval, in percent: three cells.
fn share(share: &Share) -> [Cell; 3] {
    let [low, high] = share.wilson95;
    [share.share, low, high].map(|value| Cell::percent(Some(value)))
}

/// n, mean, SD, and the ends of the interval: five cells.
fn mean(mean: &Mean) -> [Cell; 5] {
    let [low, high] = Cell::interval(mean.ci95);
    [mean.n.into(), mean.mean.into(), Cell::maybe(mean.sd), low, high]
}

/// The table's HTML, with a note where rows are left out.
fn cut(mut table: Table) -> String {
    let left_out = table.rows.len().saturating_sub(MOST_ROWS);
    table.rows.truncate(MOST_ROWS);
    let note = if left_out == 0 {
        String::new()
    } else {
        format!("<p class=\"note\">{left_out} further rows are in the page’s data.</p>\n")
    };
    table.html() + &note
}

fn detection(detection: &Detection) -> String {
    let parameter = detection.parameter().unwrap_or("level");
    let mut table = Table::new(
        format!(
            "Right answers ({}), with 95 % Wilson intervals; threshold of {parameter} with its 95 % interval; and the coarsest \
             {parameter} that went unnoticed once, which has no interval.",
            detection.right_means
        ),
        &["Trials", "n", "Right (%)", "2.5 %", "97.5 %", "Threshold", "2.5 %", "97.5 %", "Supported", "Unnoticed"],
    );
    for part in &detection.parts {
        let mut row = vec![part_name(&part.by).into(), part.right.n.into()];
        row.extend(share(&part.right));
        row.extend(Cell::maybe_estimate(part.fit.as_ref().map(|fit| &fit.threshold)));
        row.push(
            part.fit.as_ref().map_or(Cell::Missing, |fit| if fit.support.is_supported() { "yes" } else { "no" }.into()),
        );
        row.push(Cell::maybe(part.coarsest_unnoticed));
        table.push(row);
    }
    let mut html = table.html();
    for part in &detection.parts {
        let name = escape(&part_name(&part.by));
        if let Some(reason) = &part.no_fit {
            html.push_str(&format!("<p class=\"note\">No function for {name}: {}.</p>\n", escape(reason)));
        }
        if let Some(fit) = &part.fit {
            for reason in fit.support.reasons() {
                html.push_str(&format!(
                    "<p class=\"note\">The data do not support the function for {name}. {}</p>\n",
                    escape(reason)
                ));
            }
        }
    }
    html.push_str(&figure(
        &figures::detection(detection),
        "Share of right answers by level with 95 % Wilson intervals. Where one parameter varies, the curve is the fitted \
         function (dashed if the data do not support it), and the line its threshold.",
    ));
    if let Some(all) = detection.parts.first() {
        let mut header: Vec<&str> = detection.parameters.iter().map(String::as_str).collect();
        header.extend(["Right", "n", "Share (%)", "2.5 %", "97.5 %"]);
        let mut table = Table::new("Right answers at each level, all trials, with 95 % Wilson intervals.", &header);
        for cell in &all.cells {
            let mut row: Vec<Cell> =
                detection.parameters.iter().map(|name| Cell::maybe(cell.level.get(name).copied())).collect();
            row.extend([cell.right.k.into(), cell.right.n.into()]);
            row.extend(share(&cell.right));
            table.push(row);
        }
        html.push_str(&cut(table));
    }
    html
}

fn matches(matches: &Matches) -> String {
    let mut table = Table::new(
        "What was set, in the unit of each parameter; the 95 % interval of the mean is Student’s.",
        &["Quantity", "Trials", "n", "Mean", "SD", "2.5 %", "97.5 %", "Median"],
    );
    let mut rows: Vec<(&str, Vec<Cell>)> = Vec::new();
    for part in &matches.parts {
        for quantity in &part.quantities {
            let mut row = vec![quantity.quantity.as_str().into(), part_name(&part.by).into()];
            row.extend(mean(&quantity.mean));
            row.push(quantity.median.into());
            rows.push((&quantity.quantity, row));
        }
    }
    rows.sort_by_key(|(quantity, _)| *quantity);
    rows.into_iter().for_each(|(_, row)| table.push(row));
    let mut html = cut(table);
    if let Some(all) = matches.parts.first() {
        for quantity in all.quantities.iter().filter(|quantity| quantity.is_setting()) {
            html.push_str(&figure(
                &figures::settings(matches, &quantity.quantity),
                &format!("Settings of {}: every trial, and means with 95 % intervals.", quantity.quantity),
            ));
        }
    }
    html
}

fn ratings(ratings: &Ratings) -> String {
    let mut html = String::new();
    for item in &ratings.items {
        let steps: Vec<i32> = (item.steps[0]..=item.steps[1]).collect();
        let names: Vec<String> = steps.iter().map(ToString::to_string).collect();
        let mut header = vec!["Trials"];
        header.extend(names.iter().map(String::as_str));
        header.extend(["Mean", "SD"]);
        let mut table = Table::new("How often each step was chosen.", &header);
        for part in &ratings.parts {
            if let Some(rating) = part.items.iter().find(|rating| rating.item == item.item) {
                let mut row = vec![Cell::from(part_name(&part.by))];
                row.extend(steps.iter().map(|step| Cell::from(rating.count(*step))));
                row.extend([rating.mean.mean.into(), Cell::maybe(rating.mean.sd)]);
                table.push(row);
            }
        }
        html.push_str(&format!("<h4>{}</h4>\n", escape(&item.item)));
        html.push_str(&figure(
            &figures::ratings(ratings, item),
            &format!("Ratings of {} by factor level; neutral ratings lie half on either side of zero.", item.item),
        ));
        html.push_str(&cut(table));
    }
    html
}

fn tasks(tasks: &Tasks) -> String {
    let mut table = Table::new(
        "Comparisons after a task. The reference was recognised: share with Wilson’s and with Clopper and Pearson’s 95 % interval.",
        &[
            "Trials",
            "n",
            "Recognised (%)",
            "2.5 %",
            "97.5 %",
            "exact 2.5 %",
            "exact 97.5 %",
            "Equal (%)",
            "Test better (%)",
            "Exact counts (%)",
            "Counts off by",
        ],
    );
    for part in &tasks.parts {
        let mut row = vec![part_name(&part.by).into(), part.recognised.n.into()];
        row.extend(share(&part.recognised));
        row.extend(part.recognised.exact95.map(|end| Cell::percent(Some(end))));
        row.extend([part.equal.share, part.test_better.share].map(|share| Cell::percent(Some(share))));
        let counting = part.counting.as_ref();
        row.push(Cell::percent(counting.map(|counting| counting.exact.share)));
        row.push(Cell::maybe(counting.map(|counting| counting.absolute_error.mean)));
        table.push(row);
    }
    cut(table)
        + &figure(
            &figures::tasks(tasks),
            "How often the reference was named as the better one, both were called equal, and the test was named, with 95 % \
             Wilson intervals.",
        )
}

/// Means over observers.
pub(super) fn group(input: &ReportInput) -> String {
    let document = analysis(input);
    if document.group.is_empty() {
        return String::new();
    }
    // Single cells and how much was done are in the page's data.
    let shown = |row: &&GroupRow| row.by.len() < 2 && !matches!(row.quantity.as_str(), "moves" | "comparisons");
    let mut table = Table::new(
        "Over observers, each of whom counts once, with Student’s 95 % interval. Thresholds that an observer’s data do not support \
         are left out.",
        &["Block", "Quantity", "Trials", "Observers", "Mean", "SD", "2.5 %", "97.5 %"],
    );
    for GroupRow { block, quantity, by, over_observers, .. } in document.group.iter().filter(shown) {
        let mut row = vec![block.as_str().into(), quantity.as_str().into(), part_name(by).into()];
        row.extend(mean(over_observers));
        table.push(row);
    }
    cut(table)
}

/// How the blocks outside the MAR fit were analysed.
pub(super) fn methods(input: &ReportInput) -> String {
    let blocks = || input.sessions.iter().flat_map(|session| &session.blocks).filter(|block| !block.in_mar_fit);
    let any = |is: &dyn Fn(&Summary) -> bool| blocks().any(|block| is(&block.summary));
    let mut html = String::new();
    let fits: Vec<&PsychometricFit> = blocks()
        .filter_map(|block| match &block.summary {
            Summary::Detection(detection) => Some(detection.parts.iter().filter_map(|part| part.fit.as_ref())),
            _ => None,
        })
        .flatten()
        .collect();
    if !fits.is_empty() {
        let free = fits.iter().any(|fit| fit.config.guess == Guess::Free);
        html.push_str(&format!(
            "<p>Right answers by level were fitted with ψ(<var>x</var>) = γ + (1 − γ − λ) Φ(±3.29 (<var>x</var> − threshold)/width), \
             on a logarithmic axis where levels are spaced evenly in their logarithm. γ is ½ where one of two must be named{}. \
             Priors are psignifit’s (Schütt et al. 2016): threshold flat over the levels and falling to 0 within half their range on \
             either side, width flat between twice the smallest step and the range and falling to 0 at three ranges, λ Beta(1, 10). \
             Answers are taken as binomial, without overdispersion. The posterior was integrated on a grid; estimates are \
             medians, intervals the central 95 %.</p>\n",
            if free { ", and fitted with prior Beta(1, 10) where “the same” may be said" } else { "" }
        ));
    }
    if any(&|summary| matches!(summary, Summary::Ratings(_))) {
        html.push_str(
            "<p>Means of ratings take the steps of a scale for equal distances, which they need not be.</p>\n",
        );
    }
    if any(&|summary| !matches!(summary, Summary::Nothing { .. })) {
        html.push_str(
            "<p>Trials of one observer are taken as independent. Intervals describe the trials that were run with this observer; \
             means over observers come from observers’ own numbers.</p>\n",
        );
    }
    if html.is_empty() { html } else { format!("<section>\n<h2>Methods of the blocks</h2>\n{html}</section>\n") }
}

/// What was entered in forms.
pub(super) fn forms(forms: &[FormSummary]) -> String {
    if forms.is_empty() {
        return String::new();
    }
    let mut table = Table::new("What the participant entered.", &["Form", "Item", "Entry", "Session"]);
    for form in forms {
        for (item, entry) in &form.entries {
            let entry = match entry {
                Entry::Number(number) => Cell::from(*number),
                Entry::Text(text) => text.as_str().into(),
            };
            table.push([form.form.as_str().into(), item.as_str().into(), entry, form.session.as_str().into()]);
        }
    }
    format!("<h3>Forms</h3>\n{}", table.html())
}
