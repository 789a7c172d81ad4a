//! Stop rules: exactly one rule a place, quantities that exist, and an end that comes whatever is answered.

use crate::study::draft::{MarStopDraft, StopDraft};
use crate::study::mistakes::{Report, suggestion};
use crate::study::plan::{Precision, Stop};
use crate::study::source::Field;

/// What a procedure offers to stop by.
#[derive(Clone, Copy)]
pub(super) struct Offered<'a> {
    /// The procedure's name, as in messages.
    pub(super) procedure: &'a str,
    /// The quantities that it estimates.
    pub(super) quantities: &'a [&'a str],
    pub(super) reversals: bool,
}

/// A rule with an upper limit on the trials.
pub(super) fn bounded(draft: &StopDraft, offered: Offered<'_>, field: &Field, report: &mut Report<'_>) -> Option<Stop> {
    let stop = rule(draft, offered, field, report)?;
    if stop.max_trials().is_none() {
        report.at(
            field,
            "expected a rule that ends the block whatever is answered, as {\"any\": [{\"trials\": 100}, …]} does; found \
             one that may never hold",
        );
        return None;
    }
    Some(stop)
}

fn rule(draft: &StopDraft, offered: Offered<'_>, field: &Field, report: &mut Report<'_>) -> Option<Stop> {
    let before = report.count();
    let given = [
        ("trials", draft.trials.is_some()),
        ("reversals", draft.reversals.is_some()),
        ("quantity", draft.quantity.is_some()),
        ("all", draft.all.is_some()),
        ("any", draft.any.is_some()),
    ];
    // A value that could not be read has been reported, and counts as one.
    let given: Vec<&str> =
        given.into_iter().filter(|(key, is)| *is || report.has(&field.key(key))).map(|(key, _)| key).collect();
    if given.len() != 1 {
        let found = if given.is_empty() { "none".to_owned() } else { given.join(" and ") };
        report.at(field, format!("expected one of trials, reversals, quantity, all or any, found {found}"));
    }
    if draft.reversals.is_some() && !offered.reversals {
        report.at_key(
            &field.key("reversals"),
            format!("expected a rule for {}, which has no reversals, found reversals", offered.procedure),
        );
    }
    let limit = precision(draft, field, report);
    if let Some(quantity) = draft.quantity.as_deref().filter(|name| !offered.quantities.contains(name)) {
        let hint = suggestion(quantity, offered.quantities.iter().copied());
        let known = offered.quantities.join(", ");
        let estimates = format!("expected a quantity that {} estimates ({known})", offered.procedure);
        report.at(&field.key("quantity"), format!("{estimates}, found {quantity:?}{hint}"));
    }
    let all = draft.all.as_deref().map(|list| rules(list, offered, &field.key("all"), report));
    let any = draft.any.as_deref().map(|list| rules(list, offered, &field.key("any"), report));
    if report.count() > before {
        return None;
    }
    if let Some(trials) = draft.trials {
        return Some(Stop::Trials(trials));
    }
    if let Some(reversals) = draft.reversals {
        return Some(Stop::Reversals(reversals));
    }
    if let Some(quantity) = draft.quantity.clone() {
        return Some(Stop::Narrow { quantity, limit: limit? });
    }
    all.map(|rules| rules.map(Stop::All)).or_else(|| any.map(|rules| rules.map(Stop::Any)))?
}

fn rules(
    drafts: &[Option<StopDraft>],
    offered: Offered<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Vec<Stop>> {
    if drafts.is_empty() {
        report.at(field, "expected at least one rule, found an empty list");
        return None;
    }
    let rules: Vec<Option<Stop>> = drafts
        .iter()
        .enumerate()
        .map(|(index, draft)| rule(draft.as_ref()?, offered, &field.item(index), report))
        .collect();
    rules.into_iter().collect()
}

/// How well the quantity must be known.
fn precision(draft: &StopDraft, field: &Field, report: &mut Report<'_>) -> Option<Precision> {
    let unread = report.has(&field.key("sd")) || report.has(&field.key("relative_sd"));
    match (draft.sd, draft.relative_sd) {
        _ if unread => None,
        (Some(_), Some(_)) => {
            report.at_key(&field.key("relative_sd"), "expected sd or relative_sd, found both");
            None
        }
        (None, None) if draft.quantity.is_some() => {
            report.at(field, "expected sd or relative_sd beside the quantity, found neither");
            None
        }
        (sd, relative_sd) => {
            let key = if sd.is_some() { "sd" } else { "relative_sd" };
            let limit = sd.map(Precision::Sd).or(relative_sd.map(Precision::RelativeSd))?;
            if draft.quantity.is_none() && !report.has(&field.key("quantity")) {
                report.at_key(&field.key(key), format!("expected a quantity beside it, found {key} alone"));
            }
            Some(limit)
        }
    }
}

/// The rule of QUEST+ over the MAR model, which may be written in short.
pub(super) fn of_mar(draft: &MarStopDraft, field: &Field, report: &mut Report<'_>) -> Option<Stop> {
    let short = [
        ("max_trials", draft.max_trials.is_some()),
        ("min_trials", draft.min_trials.is_some()),
        ("m_relative_sd", draft.m_relative_sd.is_some()),
        ("omega0_relative_sd", draft.omega0_relative_sd.is_some()),
    ];
    let rule = draft.rule();
    let long = [
        rule.trials.is_some(),
        rule.reversals.is_some(),
        rule.quantity.is_some(),
        rule.sd.is_some(),
        rule.relative_sd.is_some(),
        rule.all.is_some(),
        rule.any.is_some(),
    ];
    let offered = Offered {
        procedure: "QUEST+ over the MAR model",
        quantities: &["m", "omega0_deg", "width", "lapse"],
        reversals: false,
    };
    if long.contains(&true) {
        if let Some((key, _)) = short.into_iter().find(|(_, is)| *is) {
            report.at_key(
                &field.key(key),
                format!("expected either {key} or one of trials, quantity, all and any; found both"),
            );
        }
        return bounded(&rule, offered, field, report);
    }
    let Some(max_trials) = draft.max_trials else {
        if !report.has(field) {
            report.at(&field.key("max_trials"), "expected a whole number from 1 to 100000, found no such key");
        }
        return None;
    };
    let min_trials = draft.min_trials.unwrap_or_else(|| max_trials.div_ceil(4));
    if min_trials > max_trials {
        report.at(&field.key("min_trials"), format!("expected at most max_trials ({max_trials}), found {min_trials}"));
        return None;
    }
    let relative = [("m", draft.m_relative_sd), ("omega0_deg", draft.omega0_relative_sd)];
    let relative: Vec<(&str, f64)> = relative.into_iter().filter_map(|(name, sd)| Some((name, sd?))).collect();
    Some(Stop::at_most(max_trials, min_trials, &relative))
}
