//! What each block's answers come to: a table and a figure for every family of protocols, means over observers, forms.

use super::{ReportInput, analysis};
use crate::answers::group::GroupRow;
use crate::answers::{BlockSummary, Detection, Matches, Ratings, Summary, Tasks, part_name};
use crate::figures;
use crate::psychometric::{Guess, PsychometricFit};
use crate::shares::{Mean, Share};
use crate::summary::FormSummary;
use crate::svg::escape;
use crate::text::{figure, interval, percent, significant, table, with_interval};
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

fn share(share: &Share) -> String {
    let [low, high] = share.wilson95;
    format!("{} [{} – {}]", percent(share.share), percent(low), percent(high))
}

fn mean(mean: &Mean) -> Vec<String> {
    vec![
        mean.n.to_string(),
        significant(mean.mean, 3),
        mean.sd.map_or_else(|| "–".to_owned(), |sd| significant(sd, 3)),
        mean.ci95.map_or_else(|| "–".to_owned(), interval),
    ]
}

fn cut(rows: &mut Vec<Vec<String>>) -> String {
    if rows.len() <= MOST_ROWS {
        return String::new();
    }
    let left_out = rows.len() - MOST_ROWS;
    rows.truncate(MOST_ROWS);
    format!("<p class=\"note\">{left_out} further rows are in the page’s data.</p>\n")
}

fn detection(detection: &Detection) -> String {
    let parameter = detection.parameter().unwrap_or("level");
    let rows: Vec<Vec<String>> = detection
        .parts
        .iter()
        .map(|part| {
            let threshold = match &part.fit {
                Some(fit) if fit.support.is_supported() => with_interval(&fit.threshold),
                Some(fit) => format!("{} (not supported)", with_interval(&fit.threshold)),
                None => "–".to_owned(),
            };
            vec![
                part_name(&part.by),
                part.right.n.to_string(),
                share(&part.right),
                threshold,
                part.coarsest_unnoticed.map_or_else(|| "–".to_owned(), |level| significant(level, 3)),
            ]
        })
        .collect();
    let mut html = table(
        &format!(
            "Right answers ({}), with 95 % Wilson intervals; threshold of {parameter}; and the coarsest {parameter} that went \
             unnoticed once, which has no interval.",
            detection.right_means
        ),
        &["Trials", "n", "Right", "Threshold", "Unnoticed"],
        &rows,
    );
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
        let mut rows: Vec<Vec<String>> = all
            .cells
            .iter()
            .map(|cell| {
                let mut row: Vec<String> = detection
                    .parameters
                    .iter()
                    .map(|name| cell.level.get(name).map_or_else(|| "–".to_owned(), ToString::to_string))
                    .collect();
                row.extend([format!("{}/{}", cell.right.k, cell.right.n), share(&cell.right)]);
                row
            })
            .collect();
        let note = cut(&mut rows);
        let mut header: Vec<&str> = detection.parameters.iter().map(String::as_str).collect();
        header.extend(["Right/n", "Share"]);
        html.push_str(&table("Right answers at each level, all trials.", &header, &rows));
        html.push_str(&note);
    }
    html
}

fn matches(matches: &Matches) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for part in &matches.parts {
        for quantity in &part.quantities {
            let mut row = vec![quantity.quantity.clone(), part_name(&part.by)];
            row.extend(mean(&quantity.mean));
            row.push(significant(quantity.median, 3));
            rows.push(row);
        }
    }
    rows.sort_by(|a, b| a[0].cmp(&b[0]));
    let note = cut(&mut rows);
    let header = ["Quantity", "Trials", "n", "Mean", "SD", "95 % CI", "Median"];
    let mut html = table("What was set, in the unit of each parameter; the interval is Student’s.", &header, &rows);
    html.push_str(&note);
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
        let mut rows: Vec<Vec<String>> = Vec::new();
        for part in &ratings.parts {
            if let Some(rating) = part.items.iter().find(|rating| rating.item == item.item) {
                let mut row = vec![part_name(&part.by)];
                row.extend(steps.iter().map(|step| rating.count(*step).to_string()));
                row.extend(mean(&rating.mean).into_iter().skip(1).take(2));
                rows.push(row);
            }
        }
        let note = cut(&mut rows);
        let names: Vec<String> = steps.iter().map(|step| step.to_string().replace('-', "−")).collect();
        let mut header = vec!["Trials"];
        header.extend(names.iter().map(String::as_str));
        header.extend(["Mean", "SD"]);
        html.push_str(&format!("<h4>{}</h4>\n", escape(&item.item)));
        html.push_str(&figure(
            &figures::ratings(ratings, item),
            &format!("Ratings of {} by factor level; neutral ratings lie half on either side of zero.", item.item),
        ));
        html.push_str(&table("How often each step was chosen.", &header, &rows));
        html.push_str(&note);
    }
    html
}

fn tasks(tasks: &Tasks) -> String {
    let mut rows: Vec<Vec<String>> = tasks
        .parts
        .iter()
        .map(|part| {
            let [low, high] = part.recognised.exact95;
            let counting = part.counting.as_ref();
            vec![
                part_name(&part.by),
                part.recognised.n.to_string(),
                share(&part.recognised),
                format!("{} – {}", percent(low), percent(high)),
                percent(part.equal.share),
                percent(part.test_better.share),
                counting.map_or_else(|| "–".to_owned(), |counting| percent(counting.exact.share)),
                counting.map_or_else(|| "–".to_owned(), |counting| significant(counting.absolute_error.mean, 3)),
            ]
        })
        .collect();
    let note = cut(&mut rows);
    let header = [
        "Trials",
        "n",
        "Reference recognised [Wilson]",
        "Clopper–Pearson",
        "Equal",
        "Test better",
        "Exact counts",
        "Counts off by",
    ];
    let html = table("Comparisons after a task, with 95 % intervals.", &header, &rows);
    html + &note
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
    let mut rows: Vec<Vec<String>> = document
        .group
        .iter()
        .filter(shown)
        .map(|GroupRow { block, quantity, by, over_observers, .. }| {
            let mut row = vec![block.clone(), quantity.clone(), part_name(by)];
            row.extend(mean(over_observers));
            row
        })
        .collect();
    let note = cut(&mut rows);
    table(
        "Over observers, each of whom counts once. Thresholds that an observer’s data do not support are left out.",
        &["Block", "Quantity", "Trials", "Observers", "Mean", "SD", "95 % CI"],
        &rows,
    ) + &note
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
    let rows: Vec<Vec<String>> = forms
        .iter()
        .flat_map(|form| {
            form.entries.iter().map(|(item, entry)| {
                let entry = match entry {
                    Entry::Number(number) => number.to_string(),
                    Entry::Text(text) => text.clone(),
                };
                vec![form.form.clone(), item.clone(), entry, form.session.clone()]
            })
        })
        .collect();
    format!("<h3>Forms</h3>\n{}", table("What the participant entered.", &["Form", "Item", "Entry", "Session"], &rows))
}
