//! The parts of the page, in the order in which they are read.

use super::{Cell, MethodsFacts, ReportInput, SessionReport, Table, methods_prose};
use crate::mar::MarFit;
use crate::svg::escape;
use crate::text::{degrees, facts, figure, listed, milliseconds, percent, significant, with_interval};
use crate::{figures, gaze, timing};
use experiments::Display;

pub(super) fn header(input: &ReportInput) -> String {
    let observers: Vec<String> = input.sessions.iter().map(|s| s.observer.clone()).collect();
    let trials: usize = input.sessions.iter().map(SessionReport::trials).sum();
    let mut line = match observers.len() {
        0 => "No sessions".to_owned(),
        1 => format!("Observer {}, {trials} trials", observers[0]),
        n => format!("{n} observers, {trials} trials"),
    };
    if let Some(generated) = &input.generated {
        line = format!("{line} · {generated}");
    }
    format!("<header>\n<h1>{}</h1>\n<p class=\"byline\">{}</p>\n</header>\n", escape(&input.title), escape(&line))
}

/// Says that data are from a pilot, before anything else.
pub(super) fn pilot(input: &ReportInput) -> String {
    let pilots: Vec<String> = input.sessions.iter().filter(|s| s.pilot).map(|s| s.observer.clone()).collect();
    if pilots.is_empty() {
        return String::new();
    }
    format!(
        "<aside class=\"unsupported\" role=\"note\">\n<p><strong>PILOT DATA.</strong> The sessions of {} were pilot runs, which \
         are shortened: these numbers are no results.</p>\n</aside>\n",
        escape(&listed(&pilots))
    )
}

/// One sentence per result, and a table where there are several observers.
pub(super) fn overview(input: &ReportInput) -> String {
    let fitted: Vec<(&SessionReport, &MarFit)> =
        input.sessions.iter().filter_map(|session| Some((session, session.fit.as_ref()?))).collect();
    match (input.sessions.as_slice(), fitted.as_slice()) {
        ([], _) => "<p>There is nothing to report: no session was given.</p>\n".to_owned(),
        (_, []) => String::new(),
        ([_], [(_, fit)]) => format!("{}<p class=\"lead\">{}</p>\n", notice(fit), result_sentence(fit)),
        (_, many) => {
            let mut table = Table::new(
                "Fitted MAR line of every observer, with 95 % intervals. m in degrees per cycle per degree, ω₀ in degrees per cycle.",
                &["Observer", "m", "2.5 %", "97.5 %", "ω₀", "2.5 %", "97.5 %", "Trials", "Remarks"],
            );
            for (s, fit) in many {
                let mut row = vec![Cell::from(s.observer.as_str())];
                row.extend(Cell::estimate(&fit.m));
                row.extend(Cell::estimate(&fit.omega0));
                let mut remarks = Vec::new();
                if fit.display_limited {
                    remarks.push("ω₀ extrapolated †");
                }
                if !fit.support.is_supported() {
                    remarks.push("not supported by the data");
                }
                row.extend([fit.trials.into(), remarks.join("; ").into()]);
                table.push(row);
            }
            let mut html = table.html();
            if many.iter().any(|(_, fit)| fit.display_limited) {
                html.push_str("<p class=\"note\">† extrapolated: finer than the display could show.</p>\n");
            }
            html
        }
    }
}

fn result_sentence(fit: &MarFit) -> String {
    format!(
        "The coarsest detail limit that goes unnoticed grew with eccentricity by <strong><var>m</var> = {}</strong> degrees per \
         cycle per degree, from <strong><var>ω</var><sub>0</sub> = {}</strong> degrees per cycle at the fovea{}.",
        escape(&with_interval(&fit.m)),
        escape(&with_interval(&fit.omega0)),
        if fit.display_limited { " (extrapolated: the display cannot show so fine a detail)" } else { "" }
    )
}

/// Reasons against the fit, then warnings.
fn notice(fit: &MarFit) -> String {
    let list = |items: &[String]| items.iter().map(|i| format!("<li>{}</li>\n", escape(i))).collect::<String>();
    let mut html = String::new();
    if !fit.support.is_supported() {
        html.push_str(&format!(
            "<aside class=\"unsupported\" role=\"note\">\n<p><strong>The data do not support this fit.</strong> The numbers \
             below are shown with their intervals, but they are not a result:</p>\n<ul>\n{}</ul>\n</aside>\n",
            list(fit.support.reasons())
        ));
    }
    if !fit.warnings.is_empty() {
        html.push_str(&format!(
            "<aside class=\"caution\" role=\"note\">\n<p><strong>To bear in mind</strong></p>\n<ul>\n{}</ul>\n</aside>\n",
            list(&fit.warnings)
        ));
    }
    html
}

/// The methods as prose to paste, and what the numbers do and do not measure.
pub(super) fn methods(input: &ReportInput, facts: &MethodsFacts) -> String {
    let prose = methods_prose(facts);
    if prose.is_empty() {
        return String::new();
    }
    let paragraphs: String = prose.iter().map(|text| format!("<p>{}</p>\n", escape(text))).collect();
    let displays =
        input.sessions.first().is_some_and(|first| input.sessions.iter().all(|s| s.display == first.display));
    let mut html = format!("<section>\n<h2>Methods</h2>\n{paragraphs}");
    if !displays {
        html.push_str("<p>Displays differed between sessions and are given with each.</p>\n");
    }
    if input.sessions.iter().any(|session| session.fit.is_some()) {
        html.push_str(
            "<p><strong>What this measures.</strong> The coarsest detail limit that goes unnoticed in this content, at this \
             eccentricity, on this display, by this observer’s criterion. It is not clinical acuity: letters, gratings, luminance and \
             contrast would give other numbers, and a degraded ring can be betrayed by its edge or its motion. The fit assumes that \
             MAR grows in proportion to eccentricity and that an observer answers alike throughout a session.</p>\n",
        );
    }
    html + "</section>\n"
}

pub(super) fn display_sentence(display: &Display) -> String {
    let [columns, rows] = display.resolution_px();
    let [w, h] = display.size_mm();
    let field = display.half_field_deg();
    let peak = display.peak_cd_m2().map_or_else(String::new, |l| format!(", {l:.0} cd/m² peak"));
    format!(
        "{} ({columns} × {rows} pixels on {:.1} × {:.1} cm, seen from {:.1} cm: {:.1}° × {:.1}°{peak}), whose finest MAR is {} \
         degrees per cycle at its centre",
        display.name(),
        w / 10.0,
        h / 10.0,
        display.distance_mm() / 10.0,
        2.0 * field[0],
        2.0 * field[1],
        significant(display.finest_mar_deg([0.0, 0.0]), 3)
    )
}

/// One observer; `alone` leaves out what the head of the page has already said.
pub(super) fn session(session: &SessionReport, alone: bool) -> String {
    let mut html = format!("<section class=\"observer\">\n<h2>Observer {}</h2>\n", escape(&session.observer));
    html.push_str(&facts(&run_facts(session)));
    if let Some(fit) = &session.fit {
        html.push_str(&acuity(session, fit, alone));
    }
    for block in session.blocks.iter().filter(|block| !block.in_mar_fit) {
        html.push_str(&super::blocks::block(block));
    }
    html.push_str(&super::blocks::forms(&session.forms));
    if !session.track.is_empty() {
        html.push_str("<h3>Course of the session</h3>\n");
        html.push_str(&figure(
            &figures::adaptive_track(&session.track),
            "Level of each trial, and the procedure’s running estimates with 95 % intervals. The fit above uses all trials \
             afresh and does not depend on these estimates.",
        ));
    }
    html.push_str(&gaze_section(session));
    html.push_str(&timing_section(session));
    html.push_str("</section>\n");
    html
}

fn acuity(session: &SessionReport, fit: &MarFit, alone: bool) -> String {
    let mut html = String::new();
    if !alone {
        html.push_str(&notice(fit));
    }
    html.push_str("<h3>Acuity</h3>\n");
    if !alone {
        html.push_str(&format!("<p>{}</p>\n", result_sentence(fit)));
    }
    html.push_str(&parameters(session, fit));
    html.push_str(&figure(
        &figures::mar_line(fit),
        "MAR by eccentricity. Points: threshold of each eccentricity, fitted without the line, with 95 % intervals. Line and \
         band: joint fit over all trials; dashed where no eccentricity was tested.",
    ));
    html.push_str(&thresholds(fit));
    html.push_str(&figure(
        &figures::psychometric_curves(fit),
        "Share of correct answers by detail limit at each eccentricity. The curve is the joint fit; the vertical line is the \
         eccentricity’s own threshold, half-way between guessing and lapsing.",
    ));
    html.push_str(&format!(
        "<p>Goodness of fit: deviance {} over {} pooled levels; {} of data sets simulated from the posterior deviate as much \
         (posterior predictive <var>p</var> = {}). Effective sample size {:.0} of {} posterior evaluations.</p>\n",
        significant(fit.goodness.deviance, 3),
        fit.goodness.pooled_levels,
        percent(fit.goodness.p),
        significant(fit.goodness.p, 2),
        fit.ess,
        fit.evaluations
    ));
    html
}

fn run_facts(session: &SessionReport) -> Vec<(String, String)> {
    let mut rows = vec![("Study", session.study.clone()), ("Session", session.session.clone())];
    if let Some(started) = &session.started {
        rows.push(("Started", started.clone()));
    }
    rows.push(("Display", display_sentence(&session.display)));
    rows.push(("Stimulus", session.stimulus.clone()));
    rows.push(("Gaze", session.gaze_source.clone()));
    rows.push(("Graphics", session.adapter.clone()));
    rows.push(("Run by", session.run_version.clone()));
    rows.push(("Seed", session.seed.to_string()));
    let mut rows: Vec<(String, String)> = rows.into_iter().map(|(label, value)| (label.to_owned(), value)).collect();
    rows.extend(session.facts.iter().cloned());
    rows.retain(|(_, value)| !value.is_empty());
    rows
}

fn parameters(session: &SessionReport, fit: &MarFit) -> String {
    let truth = session.truth.as_ref();
    let mut header = vec!["Parameter", "Estimate", "2.5 %", "97.5 %"];
    if truth.is_some() {
        header.push("Simulated observer");
    }
    let mut table = Table::new("The fitted model, with 95 % intervals.", &header);
    for (name, estimate, truth) in [
        ("Slope m (degrees per cycle per degree)", &fit.m, truth.map(|t| t.m)),
        ("Intercept ω₀ (degrees per cycle)", &fit.omega0, truth.map(|t| t.omega0_deg)),
        ("Width w (ln ω, 5 % to 95 %)", &fit.width, truth.map(|t| t.width)),
        ("Lapse rate λ", &fit.lapse, truth.map(|t| t.lapse)),
    ] {
        let mut row = vec![Cell::from(name)];
        row.extend(Cell::estimate(estimate));
        row.extend(truth.map(Cell::from));
        table.push(row);
    }
    table.html()
}

fn thresholds(fit: &MarFit) -> String {
    let mut table = Table::new(
        "Threshold of each eccentricity, degrees per cycle, with 95 % intervals. An upper limit is set by the display.",
        &["Eccentricity (°)", "Threshold", "2.5 %", "97.5 %", "Line", "Display’s finest", "Trials", "Remark"],
    );
    for t in &fit.thresholds {
        let mut row = vec![Cell::from(t.eccentricity_deg), t.mar_deg.into()];
        row.extend(Cell::interval(Some(t.ci95)));
        row.extend([fit.line_at(t.eccentricity_deg).estimate.into(), Cell::maybe(t.finest_mar_deg), t.trials.into()]);
        row.push(if t.limited { "upper limit".into() } else { Cell::Missing });
        table.push(row);
    }
    table.html()
}

fn gaze_section(session: &SessionReport) -> String {
    if session.gaze.is_empty() {
        return format!(
            "<h3>Gaze</h3>\n<p>No gaze samples were recorded during stimulus phases; {} trials were aborted and repeated.</p>\n",
            session.aborted_trials
        );
    }
    let summary = gaze::summarise(&session.gaze);
    let rows = [
        ("Samples during stimulus phases", summary.samples.to_string()),
        ("Sampling rate", summary.sampling_rate_hz.map_or_else(|| "–".to_owned(), |hz| format!("{hz:.0} Hz"))),
        ("Valid", summary.valid_share.map_or_else(|| "–".to_owned(), percent)),
        ("Lost", summary.loss_share.map_or_else(|| "–".to_owned(), percent)),
        ("RMS deviation from fixation", degrees(summary.rms_deviation_deg)),
        (
            "Median (95 %)",
            format!("{} ({})", degrees(summary.median_deviation_deg), degrees(summary.p95_deviation_deg)),
        ),
        ("Trials aborted and repeated", session.aborted_trials.to_string()),
    ]
    .map(|(label, value)| (label.to_owned(), value));
    format!(
        "<h3>Gaze</h3>\n{}{}",
        facts(&rows),
        figure(
            &figures::gaze_density(&session.gaze, &session.gaze_view),
            "Where the gaze was while stimuli were shown, with the share of valid samples that each panel holds. Darker cells hold \
             more samples (square root of the count)."
        )
    )
}

fn timing_section(session: &SessionReport) -> String {
    if session.frames.is_empty() {
        return "<h3>Frames</h3>\n<p>No frames were logged.</p>\n".to_owned();
    }
    let summary = timing::summarise(&session.frames);
    let refresh_hz = session.measured_refresh_hz.unwrap_or_else(|| session.display.refresh_hz());
    let refresh =
        format!("{refresh_hz:.2} Hz ({})", if session.measured_refresh_hz.is_some() { "measured" } else { "declared" });
    let rows = [
        ("Refresh rate", refresh),
        ("Frames", summary.frames.to_string()),
        ("Missed", format!("{} ({})", summary.missed, summary.missed_share.map_or_else(|| "–".to_owned(), percent))),
        (
            "Interval, mean (SD)",
            format!("{} ({})", milliseconds(summary.interval_mean_s), milliseconds(summary.interval_sd_s)),
        ),
        ("Longest interval", milliseconds(summary.interval_max_s)),
        (
            "Age of the gaze, median (95 %)",
            format!("{} ({})", milliseconds(summary.gaze_age_median_s), milliseconds(summary.gaze_age_p95_s)),
        ),
    ]
    .map(|(label, value)| (label.to_owned(), value));
    let virtual_note = if session.virtual_time {
        "<p class=\"note\">This session ran offscreen in virtual time; these figures describe the simulation and no display.</p>\n"
    } else {
        ""
    };
    format!(
        "<h3>Frames</h3>\n{virtual_note}{}{}",
        facts(&rows),
        figure(
            &figures::frame_timing(&session.frames, Some(refresh_hz)),
            "Intervals between frames within a phase, and missed frames over the session."
        )
    )
}

pub(super) fn software(input: &ReportInput) -> String {
    let mut rows = vec![("Analysis".to_owned(), input.program_version.clone())];
    rows.extend(input.software.iter().cloned());
    format!(
        "<section>\n<h2>Software and data</h2>\n{}<p class=\"note\">The numbers of this page are embedded in it as JSON (element \
         <code>parafovea-analysis</code>).</p>\n</section>\n",
        facts(&rows)
    )
}
