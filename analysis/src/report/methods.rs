//! The methods paragraphs: design, display, timing, observers, exclusions, model, priors and software, as prose that one
//! could paste into a paper.
//!
//! Every sentence stands on a fact that was given; what is not known is not mentioned.

use super::ReportInput;
use crate::gaze::{self, GazeSummary};
use crate::mar::{LogNormal, MarFitConfig};
use crate::text::{listed, percent, significant};
use crate::timing::{self, TimingSummary};
use experiments::Display;

/// What is known about how data came about and were analysed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MethodsFacts {
    /// Observers whose data were analysed.
    pub observers: Option<usize>,
    /// Observers who took part but were excluded, each with the reason.
    pub excluded_observers: Vec<(String, String)>,
    /// The observers were simulated, not people.
    pub simulated: bool,
    /// Design and task, as full sentences, for example `Trials were two-interval forced choices.`
    pub design: Vec<String>,
    /// Tested eccentricities, degrees.
    pub eccentricities_deg: Vec<f64>,
    /// Scene and renderer.
    pub stimulus: Option<String>,
    /// Analysed trials of each observer.
    pub trials: Vec<usize>,
    /// Trials left out, as (how many, why).
    pub excluded_trials: Vec<(usize, String)>,
    /// Trials aborted and repeated.
    pub repeated_trials: Option<usize>,
    /// The display, if all sessions had the same one.
    pub display: Option<Display>,
    /// Refresh rate as measured, hertz.
    pub measured_refresh_hz: Option<f64>,
    /// How the frames of all sessions ran.
    pub timing: Option<TimingSummary>,
    /// The sessions ran offscreen in virtual time.
    pub virtual_time: bool,
    /// Where gaze came from.
    pub gaze_source: Option<String>,
    /// Radius of the fixation gate, degrees.
    pub gate_deg: Option<f64>,
    /// Gaze during stimuli.
    pub gaze: Option<GazeSummary>,
    /// The model, as full sentences with its formula.
    pub model: Vec<String>,
    /// Priors, as (parameter, distribution).
    pub priors: Vec<(String, String)>,
    /// How estimates and intervals were taken, as full sentences.
    pub inference: Vec<String>,
    /// Programs with versions.
    pub software: Vec<(String, String)>,
}

/// The paragraphs: participants and design; apparatus; analysis; software. Those without facts are left out.
#[must_use]
pub fn methods_prose(facts: &MethodsFacts) -> Vec<String> {
    [participants(facts), apparatus(facts), analysis(facts), software(facts)]
        .into_iter()
        .map(|sentences| sentences.join(" "))
        .filter(|paragraph| !paragraph.is_empty())
        .collect()
}

fn plural(n: usize, one: &str) -> String {
    if n == 1 { format!("{n} {one}") } else { format!("{n} {one}s") }
}

fn participants(facts: &MethodsFacts) -> Vec<String> {
    let mut text = Vec::new();
    let what = if facts.simulated { "simulated observer" } else { "observer" };
    let excluded = facts.excluded_observers.len();
    match facts.observers {
        Some(n) if excluded > 0 => {
            let reasons: Vec<String> =
                facts.excluded_observers.iter().map(|(who, why)| format!("{who} ({why})")).collect();
            text.push(format!(
                "{} took part; {} {} excluded: {}.",
                capital(&plural(n + excluded, what)),
                excluded,
                if excluded == 1 { "was" } else { "were" },
                listed(&reasons)
            ));
        }
        Some(n) if n > 0 => text.push(format!("{} took part.", capital(&plural(n, what)))),
        _ => {}
    }
    text.extend(facts.design.iter().cloned());
    if let Some(stimulus) = facts.stimulus.as_ref().filter(|stimulus| !stimulus.is_empty()) {
        text.push(format!("Stimuli: {stimulus}."));
    }
    if !facts.eccentricities_deg.is_empty() {
        let names: Vec<String> = facts.eccentricities_deg.iter().map(|e| format!("{}°", significant(*e, 3))).collect();
        text.push(format!("Eccentricities were {}.", listed(&names)));
    }
    let most = facts.trials.iter().copied().max();
    let least = facts.trials.iter().copied().min();
    match (least, most) {
        (Some(a), Some(b)) if a == b && facts.trials.len() == 1 => {
            text.push(format!("{} were analysed.", capital(&plural(a, "trial"))));
        }
        (Some(a), Some(b)) if a == b => {
            text.push(format!("{} of each observer were analysed.", capital(&plural(a, "trial"))));
        }
        (Some(a), Some(b)) => {
            let total: usize = facts.trials.iter().sum();
            text.push(format!("{total} trials were analysed, {a} to {b} of each observer."));
        }
        _ => {}
    }
    let left_out: Vec<String> = facts
        .excluded_trials
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, why)| format!("{} ({why})", plural(*n, "trial")))
        .collect();
    if !left_out.is_empty() {
        text.push(format!("Left out were {}.", listed(&left_out)));
    }
    if let Some(n) = facts.repeated_trials.filter(|n| *n > 0) {
        let was = if n == 1 { "was" } else { "were" };
        text.push(format!("{} {was} aborted and repeated.", capital(&plural(n, "trial"))));
    }
    text
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

fn apparatus(facts: &MethodsFacts) -> Vec<String> {
    let mut text = Vec::new();
    if let Some(display) = &facts.display {
        text.push(format!("The display was {}.", super::sections::display_sentence(display)));
    }
    let refresh = facts.measured_refresh_hz.map(|hz| format!("{hz:.2} Hz (measured)"));
    let refresh = refresh.or_else(|| facts.display.as_ref().map(|d| format!("{:.0} Hz (declared)", d.refresh_hz())));
    if facts.virtual_time {
        text.push("Sessions ran offscreen in virtual time, so that their timing is that of the simulation.".to_owned());
    } else if let Some(refresh) = refresh {
        let missed = facts.timing.and_then(|timing| Some((timing.missed, timing.frames, timing.missed_share?)));
        let missed = missed.map_or_else(String::new, |(missed, frames, share)| {
            format!("; {missed} of {frames} frames were missed ({})", percent(share))
        });
        text.push(format!("It was refreshed at {refresh}{missed}."));
    }
    if let Some(source) = facts.gaze_source.as_ref().filter(|source| !source.is_empty()) {
        let rate = facts.gaze.and_then(|gaze| gaze.sampling_rate_hz);
        let rate =
            rate.map_or_else(String::new, |hz| format!(", its samples {:.1} ms apart in the median", 1000.0 / hz));
        text.push(format!("The gaze source was {source}{rate}."));
    }
    if let Some(gate) = facts.gate_deg {
        text.push(format!("Gaze was held to a circle of {}° around the fixation point.", significant(gate, 3)));
    }
    let distances = facts.gaze.and_then(|g| Some((g.median_deviation_deg?, g.p95_deviation_deg?, g.loss_share?)));
    if let Some((median, p95, lost)) = distances {
        text.push(format!(
            "While stimuli were shown, the median distance of gaze from the fixation point was {}° (95 % of samples within {}°); {} \
             of samples were lost.",
            significant(median, 2),
            significant(p95, 2),
            percent(lost)
        ));
    }
    let age = facts.timing.filter(|_| !facts.virtual_time);
    if let Some((median, p95)) = age.and_then(|t| Some((t.gaze_age_median_s?, t.gaze_age_p95_s?))) {
        text.push(format!(
            "When a frame was handed to the graphics driver its gaze sample was {:.1} ms old in the median and {:.1} ms in 95 % of \
             frames; light from the screen came later.",
            1000.0 * median,
            1000.0 * p95
        ));
    }
    text
}

fn analysis(facts: &MethodsFacts) -> Vec<String> {
    let mut text = facts.model.clone();
    if !facts.priors.is_empty() {
        let priors: Vec<String> = facts.priors.iter().map(|(name, prior)| format!("{prior} for {name}")).collect();
        text.push(format!("Priors were {}.", listed(&priors)));
    }
    text.extend(facts.inference.iter().cloned());
    text
}

fn software(facts: &MethodsFacts) -> Vec<String> {
    let programs: Vec<String> = facts
        .software
        .iter()
        .filter(|(_, version)| !version.is_empty())
        .map(|(name, version)| format!("{}: {version}", name.to_lowercase()))
        .collect();
    if programs.is_empty() { Vec::new() } else { vec![format!("Software: {}.", programs.join("; "))] }
}

/// Model and inference of a MAR fit, in sentences and with its priors.
pub(super) fn of_mar_fit(facts: &mut MethodsFacts, config: &MarFitConfig) {
    let prior = |p: LogNormal| {
        format!("log-normal (median {}, SD of the logarithm {})", significant(p.median, 3), significant(p.sd_ln, 2))
    };
    facts.design.push(format!(
        "Detail finer than a limit ω (degrees per cycle) was removed at one eccentricity around the gaze, and the observer said \
         which picture was degraded; the guess rate was {}.",
        significant(config.guess, 2)
    ));
    facts.model.push(
        "All trials of an observer entered one likelihood, ψ(e, ω) = γ + (1 − γ − λ) Φ(3.29 (ln ω − ln(m e + ω₀))/w), with the \
         guess rate γ, the lapse rate λ and a width w that spans 5 % to 95 % of the rise in ln ω."
            .to_owned(),
    );
    let [a, b] = config.priors.lapse_beta.map(|shape| significant(shape, 3));
    facts.priors = vec![
        ("m".to_owned(), prior(config.priors.m)),
        ("ω₀".to_owned(), prior(config.priors.omega0)),
        ("w".to_owned(), prior(config.priors.width)),
        ("λ".to_owned(), format!("Beta({a}, {b})")),
    ];
    facts.inference.push(
        "The posterior was integrated by adaptive importance sampling on quasi-random points; estimates are posterior medians \
         and intervals the central 95 %. The threshold of each eccentricity was fitted without the line, with width and lapse \
         rate shared. Trials whose limit the display could not show were left out, and thresholds below it are given as upper \
         limits."
            .to_owned(),
    );
}

impl MethodsFacts {
    /// What a report's sessions say by themselves. Design, exclusions and the like the caller may add.
    #[must_use]
    pub fn of(input: &ReportInput) -> Self {
        let sessions = &input.sessions;
        let mut facts =
            Self { software: vec![("Analysis".to_owned(), input.program_version.clone())], ..Self::default() };
        facts.software.extend(input.software.iter().cloned());
        let Some(first) = sessions.first() else { return facts };
        let same = |is: &dyn Fn(&super::SessionReport) -> bool| sessions.iter().all(is);
        let mut versions: Vec<String> = sessions.iter().map(|s| s.run_version.clone()).collect();
        versions.sort();
        versions.dedup();
        facts.software.insert(0, ("Sessions".to_owned(), versions.join(", ")));
        facts.observers = Some(sessions.len());
        facts.simulated = same(&|s| s.truth.is_some());
        // Trials that the display could not show are no part of the analysis.
        let not_shown = |s: &super::SessionReport| s.fit.as_ref().map_or(0, |fit| fit.trials_not_shown);
        facts.trials = sessions.iter().map(|s| s.trials().saturating_sub(not_shown(s))).collect();
        facts.repeated_trials = Some(sessions.iter().map(|s| s.aborted_trials).sum());
        facts.display = same(&|s| s.display == first.display).then(|| first.display.clone());
        facts.stimulus = same(&|s| s.stimulus == first.stimulus).then(|| first.stimulus.clone());
        facts.gaze_source = same(&|s| s.gaze_source == first.gaze_source).then(|| first.gaze_source.clone());
        facts.gate_deg =
            first.gaze_view.gate_deg.filter(|_| same(&|s| s.gaze_view.gate_deg == first.gaze_view.gate_deg));
        facts.virtual_time = same(&|s| s.virtual_time);
        // Sessions one after the other: the first frame of each follows a gap, and no sample of one precedes another's.
        if let [only] = sessions.as_slice() {
            facts.measured_refresh_hz = only.measured_refresh_hz;
            facts.timing = (!only.frames.is_empty()).then(|| timing::summarise(&only.frames));
            facts.gaze = (!only.gaze.is_empty()).then(|| gaze::summarise(&only.gaze));
        }
        if let Some(fit) = sessions.iter().find_map(|s| s.fit.as_ref()) {
            of_mar_fit(&mut facts, &fit.config);
            let mut tested: Vec<f64> = sessions
                .iter()
                .filter_map(|s| s.fit.as_ref())
                .flat_map(|f| &f.thresholds)
                .map(|t| t.eccentricity_deg)
                .collect();
            tested.sort_by(f64::total_cmp);
            tested.dedup();
            facts.eccentricities_deg = tested;
            facts
                .excluded_trials
                .push((sessions.iter().map(not_shown).sum(), "finer than the display could show".to_owned()));
        }
        facts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_unknown_is_not_mentioned() {
        assert!(methods_prose(&MethodsFacts::default()).is_empty());
        let facts = MethodsFacts { observers: Some(1), trials: vec![240], ..MethodsFacts::default() };
        assert_eq!(methods_prose(&facts), ["1 observer took part. 240 trials were analysed."]);
    }

    #[test]
    fn exclusions_are_told_with_their_reasons() {
        let facts = MethodsFacts {
            observers: Some(14),
            excluded_observers: vec![("P07".to_owned(), "tracker lost".to_owned())],
            trials: vec![200, 240],
            excluded_trials: vec![(3, "answered within 100 ms".to_owned()), (0, "never".to_owned())],
            repeated_trials: Some(1),
            ..MethodsFacts::default()
        };
        assert_eq!(
            methods_prose(&facts),
            [
                "15 observers took part; 1 was excluded: P07 (tracker lost). 440 trials were analysed, 200 to 240 of each observer. \
              Left out were 3 trials (answered within 100 ms). 1 trial was aborted and repeated."
            ]
        );
    }

    #[test]
    fn display_timing_and_model_are_prose() {
        let mut facts = MethodsFacts {
            display: Display::named("guenter-2012"),
            gaze_source: Some("recorded".to_owned()),
            gate_deg: Some(2.0),
            software: vec![("Analysis".to_owned(), "parafovea 0.1.0".to_owned())],
            ..MethodsFacts::default()
        };
        of_mar_fit(&mut facts, &MarFitConfig::default());
        let text = methods_prose(&facts).join("\n");
        for part in [
            "1920 × 1080",
            "Hz (declared)",
            "a circle of 2°",
            "Beta(1, 10) for λ",
            "Software: analysis: parafovea 0.1.0.",
        ] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
    }
}
