//! What observers come to together, as tables for a terminal.

use crate::results::over_observers::{BlockAnova, BlockRule, OverObservers};
use analysis::mar::hierarchical::HierarchicalFit;
use analysis::rules::{self, RuleResult};
use std::fmt::Write as _;

/// One text for everything that there is.
pub(super) fn text(together: &OverObservers) -> Vec<String> {
    let mut texts = Vec::new();
    texts.extend(together.group_mar.as_ref().map(pooled));
    texts.extend(together.no_group_mar.as_ref().map(|reason| format!("no pooled MAR line: {reason}\n")));
    texts.extend(together.anovas.iter().map(variance));
    texts.extend(together.rules.iter().filter_map(rule));
    texts
}

fn pooled(fit: &HierarchicalFit) -> String {
    let mut text = format!("{} observers pooled: the typical observer\n\n", fit.observers.len());
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  quantity   typical    95 % interval         SD of ln   95 % interval     new observer");
    for (name, parameter) in [("m", &fit.m), ("omega0", &fit.omega0), ("width", &fit.width)] {
        let ([low, high], [least, most]) = (parameter.median.ci95, parameter.sd_ln.ci95);
        let [new_low, new_high] = parameter.new_observer.ci95;
        let _ = writeln!(
            text,
            "  {name:<8}   {:<8.5}   {low:.5} – {high:<9.5}   {:<8.3}   {least:.3} – {most:<7.3}   {new_low:.5} – {new_high:.5}",
            parameter.median.estimate, parameter.sd_ln.estimate
        );
    }
    let _ = writeln!(text, "\n  observer    m alone    within the group   shrunk by");
    for observer in &fit.observers {
        let _ = writeln!(
            text,
            "  {:<10}  {:<8.5}   {:<16.5}   {:.0} %",
            observer.id,
            observer.m.alone.estimate,
            observer.m.pooled.estimate,
            100.0 * observer.m.shrinkage
        );
    }
    for warning in &fit.warnings {
        let _ = writeln!(text, "  note: {warning}");
    }
    text
}

fn variance(one: &BlockAnova) -> String {
    let title = format!("analysis of variance of {} (block {})", one.measure, one.block);
    let Some(anova) = &one.anova else {
        return format!("no {title}: {}\n", one.refused.as_deref().unwrap_or("there were no values"));
    };
    let mut text = format!("{title}, {} observers\n\n", anova.table.subjects().len());
    let widest = anova.effects.iter().map(|effect| effect.name().chars().count()).max().unwrap_or(6).max(6);
    let _ = writeln!(
        text,
        "  {:<widest$}   {:>9}   {:>9}   {:>9}   {:>7}   {:>9}   {:>9}   {:>6}",
        "effect", "df", "F", "p", "ε (GG)", "p (GG)", "p (Holm)", "gen η²"
    );
    for (index, effect) in anova.effects.iter().enumerate() {
        let df = format!("{}, {}", effect.df, effect.df_error);
        let Some(test) = &effect.test else {
            let _ = writeln!(text, "  {:<widest$}   {df:>9}   no error to test against", effect.name());
            continue;
        };
        let holm = one.p_holm.get(index).copied().flatten().map_or_else(|| "–".to_owned(), p_value);
        let eta = effect.generalised_eta_squared.map_or_else(|| "–".to_owned(), |eta| format!("{eta:.3}"));
        let _ = writeln!(
            text,
            "  {:<widest$}   {df:>9}   {:>9.4}   {:>9}   {:>7.4}   {:>9}   {holm:>9}   {eta:>6}",
            effect.name(),
            test.f,
            p_value(test.p),
            test.greenhouse_geisser.epsilon,
            p_value(test.greenhouse_geisser.p)
        );
    }
    text
}

fn p_value(p: f64) -> String {
    if p < 1e-4 { format!("{p:.1e}") } else { format!("{p:.4}") }
}

/// The rule's main number beside the published one; nothing for rules whose numbers are tables.
fn rule(one: &BlockRule) -> Option<String> {
    let over = |over: &rules::OverObservers| {
        let interval = over.ci95.map_or_else(
            || over.no_interval.clone().unwrap_or_default(),
            |[low, high]| format!("95 % {low:.3} – {high:.3}"),
        );
        let sd = over.sd.map_or_else(String::new, |sd| format!(" ± {sd:.3}"));
        format!("{:.3}{sd} over {} observer(s), {interval}", over.mean, over.n)
    };
    let beside = |published: Option<&rules::Published>| {
        published.map_or_else(String::new, |published| {
            let sd = published.sd.map_or_else(String::new, |sd| format!(" ± {sd}"));
            format!("; published {}{sd} ({})", published.value, published.source)
        })
    };
    let line = match &one.result {
        RuleResult::Guenter(thresholds) => format!(
            "{}: {}{}",
            thresholds.rule.name,
            thresholds.over_observers.as_ref().map_or_else(|| "nobody has a threshold".to_owned(), over),
            beside(thresholds.published.as_ref())
        ),
        RuleResult::StengelTask(task) => format!(
            "{}: {}{}",
            task.rule.name,
            task.over_observers.as_ref().map_or_else(|| "no comparison".to_owned(), over),
            beside(task.published.as_ref())
        ),
        RuleResult::StengelSettings(settings) => settings
            .settings
            .iter()
            .filter(|setting| setting.by.is_empty())
            .map(|setting| format!("{}: {}", setting.parameter, over(&setting.over_observers)))
            .collect::<Vec<_>>()
            .join("\n  "),
        RuleResult::Tursun(_) | RuleResult::Weier(_) => return None,
    };
    Some(format!("by the paper's own rule (block {})\n\n  {line}\n", one.block))
}
