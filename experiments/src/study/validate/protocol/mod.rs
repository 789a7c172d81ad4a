//! Protocols against renderer and display: does a phase last a frame, do the parameters exist?
//!
//! `compared` holds the protocols that show reference and test one after the other, `moved` those that move a parameter
//! within a trial; a rated sequence is here.

mod compared;
mod moved;

use super::form;
use crate::catalogue::RendererInfo;
use crate::study::draft::{ItemDraft, LikertDraft, ProtocolDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{Condition, LikertPlan, ProtocolPlan};
use crate::study::source::Field;

/// What a protocol's parameters are set on.
pub(super) type Target<'a> = Option<(&'a Condition, &'a RendererInfo)>;

/// What a protocol is checked against.
#[derive(Debug, Clone, Copy)]
struct Context<'a> {
    target: Target<'a>,
    refresh_hz: Option<f64>,
    field: &'a Field,
}

/// A protocol with every default filled in.
pub(super) fn checked(
    draft: &ProtocolDraft,
    target: Target<'_>,
    refresh_hz: Option<f64>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<ProtocolPlan> {
    let context = Context { target, refresh_hz, field };
    match draft {
        ProtocolDraft::TwoInterval(draft) => {
            compared::two_interval(draft, context, report).map(ProtocolPlan::TwoInterval)
        }
        ProtocolDraft::Toggle(draft) => compared::toggle(draft, context, report).map(ProtocolPlan::Toggle),
        ProtocolDraft::Pair(draft) => compared::pair(draft, context, report).map(ProtocolPlan::Pair),
        ProtocolDraft::Ramp(draft) => moved::ramp(draft, context, report).map(ProtocolPlan::Ramp),
        ProtocolDraft::Slider(draft) => moved::slider(draft, context, report).map(ProtocolPlan::Slider),
        ProtocolDraft::Likert(draft) => likert(draft, context, report).map(ProtocolPlan::Likert),
        ProtocolDraft::Adjustment(draft) => moved::adjustment(draft, context, report).map(ProtocolPlan::Adjustment),
        ProtocolDraft::PairedTask(draft) => compared::paired_task(draft, context, report).map(ProtocolPlan::PairedTask),
    }
}

fn likert(draft: &LikertDraft, context: Context<'_>, report: &mut Report<'_>) -> Option<LikertPlan> {
    context.report_short_phases(&[("fixation_s", draft.fixation_s), ("sequence_s", draft.sequence_s)], report);
    let field = context.field.key("items");
    let before = report.count();
    let items = draft.items.as_ref().map(|drafts| {
        if drafts.is_empty() {
            report.at(&field, "expected at least one item, found an empty list");
        }
        for (index, _) in drafts.iter().enumerate().filter(|(_, draft)| matches!(draft, Some(ItemDraft::Text(_)))) {
            let kind = field.item(index).key("kind");
            report.at(&kind, "expected \"scale\", \"choice\" or \"number\", whose answers are numbers, found \"text\"");
        }
        form::checked(drafts, &field, report)
    });
    let items = items.filter(|_| report.count() == before);
    Some(LikertPlan {
        fixation_s: draft.fixation_s,
        sequence_s: draft.sequence_s?,
        items: items?,
        on_gaze_left: draft.on_gaze_left.unwrap_or_default().into(),
    })
}

impl Context<'_> {
    /// What is shorter than a frame is not shown.
    fn report_short_phases(&self, phases: &[(&str, Option<f64>)], report: &mut Report<'_>) {
        let Some(refresh_hz) = self.refresh_hz else { return };
        for (name, duration_s) in phases {
            // A duration written to four digits counts as the frame that it means.
            if let Some(duration_s) = duration_s.filter(|duration_s| duration_s * refresh_hz < 0.99) {
                report.at(
                    &self.field.key(name),
                    format!(
                        "expected at least one frame ({:.4} s at {refresh_hz} Hz), found {duration_s}",
                        1.0 / refresh_hz
                    ),
                );
            }
        }
    }
}
