//! Stretches of a session with one study and one display each. There is one, unless the session was gone on with by force
//! after a change of either.

use crate::error::LabError;
use crate::resources::Resources;
use crate::session::SessionFolder;
use crate::session::header::DisplayRecord;
use experiments::Display;
use experiments::study::{self, Plan};
use std::sync::Arc;

/// One stretch.
#[derive(Debug)]
pub(super) struct Segment {
    /// Number of the first event that is part of it.
    pub(super) from_seq: u64,
    /// What was run.
    pub(super) plan: Arc<Plan>,
    /// The graphics adapter that the session began with.
    pub(super) gpu: Option<String>,
}

/// The one stretch of a session that ran one plan from its beginning to its end.
pub(super) fn only(session: &SessionFolder, plan: Plan) -> Vec<Segment> {
    vec![Segment { from_seq: 0, plan: Arc::new(plan), gpu: session.header.stage.gpu.clone() }]
}

/// The stretches of a session, in order; never none.
pub(super) fn of(session: &SessionFolder, resources: &Resources) -> Result<Vec<Segment>, LabError> {
    let header = &session.header;
    let plan = |where_: &str, text: &str, display: &Display| {
        let file = format!("{} ({where_})", session.path.join(crate::session::names::HEADER).display());
        let plan = resources.plan(&file, text, Some(display))?;
        let plan = plan.assigned(&header.assignment);
        plan.map(Arc::new).map_err(|error| LabError::BadInput(format!("{file}: {error}")))
    };
    let (mut text, mut display) = (header.study.text.clone(), session.display.clone());
    let first = plan("study", &text, &display)?;
    let mut segments = vec![Segment { from_seq: 0, plan: first, gpu: header.stage.gpu.clone() }];
    for seam in &session.record.seams {
        if seam.seam.study.is_none() && seam.seam.display.is_none() {
            continue;
        }
        let where_ = format!("from event {} on", seam.seq);
        if let Some(changed) = &seam.seam.study {
            text.clone_from(changed);
        }
        if let Some(changed) = &seam.seam.display {
            display = display_from(&where_, changed)?;
        }
        let plan = plan(&where_, &text, &display)?;
        segments.push(Segment { from_seq: seam.seq, plan, gpu: header.stage.gpu.clone() });
    }
    Ok(segments)
}

/// The display that a seam names.
fn display_from(where_: &str, value: &serde_json::Value) -> Result<Display, LabError> {
    match serde_json::from_value::<DisplayRecord>(value.clone()) {
        Ok(record) => record.display().map_err(|problem| LabError::BadInput(format!("display {where_}: {problem}"))),
        // The form of a display file leaves out what has a default.
        Err(_) => Ok(study::parse_display(&format!("display {where_}"), &value.to_string())?),
    }
}

/// The number of the stretch that an event is part of.
pub(super) fn index(segments: &[Segment], seq: u64) -> usize {
    segments.partition_point(|segment| segment.from_seq <= seq).saturating_sub(1)
}

/// The stretch that an event is part of.
pub(super) fn in_force(segments: &[Segment], seq: u64) -> &Segment {
    &segments[index(segments, seq)]
}
