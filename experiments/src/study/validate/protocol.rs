//! Protocols against renderer and display: does a phase last a frame, do the parameters exist?

use super::DEFAULT_QUESTION;
use crate::catalogue::RendererInfo;
use crate::study::draft::{ProtocolDraft, TwoIntervalDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{Condition, ProtocolPlan, TwoIntervalPlan, Wanted};
use crate::study::source::Field;

/// What a protocol's parameters are set on.
pub(super) type Target<'a> = Option<(&'a Condition, &'a RendererInfo)>;

/// A protocol with every default filled in.
pub(super) fn checked(
    draft: &ProtocolDraft,
    _target: Target<'_>,
    refresh_hz: Option<f64>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<ProtocolPlan> {
    match draft {
        ProtocolDraft::TwoInterval(draft) => two_interval(draft, refresh_hz, field, report),
    }
}

fn two_interval(
    draft: &TwoIntervalDraft,
    refresh_hz: Option<f64>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<ProtocolPlan> {
    let phases = [
        ("fixation_s", draft.fixation_s),
        ("interval_s", draft.interval_s),
        ("gap_s", draft.gap_s),
        ("feedback_s", draft.feedback_s),
    ];
    report_short_phases(&phases, refresh_hz, field, report);
    Some(ProtocolPlan::TwoInterval(TwoIntervalPlan {
        fixation_s: draft.fixation_s?,
        interval_s: draft.interval_s?,
        gap_s: draft.gap_s?,
        answer_timeout_s: draft.answer_timeout_s,
        question: draft.question.clone().unwrap_or_else(|| DEFAULT_QUESTION.to_owned()),
        wanted: Wanted::Degraded,
    }))
}

/// What is shorter than a frame is not shown.
fn report_short_phases(
    phases: &[(&str, Option<f64>)],
    refresh_hz: Option<f64>,
    field: &Field,
    report: &mut Report<'_>,
) {
    let Some(refresh_hz) = refresh_hz else { return };
    for (name, duration_s) in phases {
        // A duration written to four digits counts as the frame that it means.
        if let Some(duration_s) = duration_s.filter(|duration_s| duration_s * refresh_hz < 0.99) {
            report.at(
                &field.key(name),
                format!(
                    "expected at least one frame ({:.4} s at {refresh_hz} Hz), found {duration_s}",
                    1.0 / refresh_hz
                ),
            );
        }
    }
}
