//! What a plan will do, before anybody is asked to sit through it.
//!
//! [`describe`] computes, [`Description`] is the result as data (for `--json`) and as text of at most 100 columns (for
//! a terminal). Durations assume [`ANSWER_S`] for every answer and leave out pages, breaks and aborted trials.

mod design;
mod procedure;
mod protocol;
mod text;

use super::plan::{BlockPlan, NamedFile, Plan};
use super::validate::finest_mar_around;
use crate::display::Display;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The time a typical answer is taken to need, in seconds, where durations are foretold.
pub const ANSWER_S: f64 = 1.0;

/// What a study will do on its display.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Description {
    /// The study's short name.
    pub study: String,
    /// Its title.
    pub title: String,
    /// What it is for.
    pub about: String,
    /// The display and what it can show.
    pub display: DisplayDescription,
    /// Where observers look, degrees from the display's centre.
    pub fixation_deg: [f64; 2],
    /// Radius of the fixation gate in degrees, if there is one.
    pub gate_deg: Option<f64>,
    /// How long gaze may leave the gate, in seconds.
    pub gate_grace_s: Option<f64>,
    /// Whether consent is asked for.
    pub consent: bool,
    /// Items of the participant form.
    pub participant: Vec<String>,
    /// Pages of instructions before the first block.
    pub instruction_pages: usize,
    /// Scenes and renderers that the study brings along.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<NamedFile>,
    /// The blocks in order.
    pub blocks: Vec<BlockDescription>,
    /// All blocks together.
    pub total: Effort,
    /// The groups of a between-subject design, each with the blocks that it runs.
    pub groups: Vec<GroupDescription>,
    /// The sittings of one observer, each with its trials; empty for a study of one sitting.
    pub sittings: Vec<Effort>,
    /// Trials of a block in a pilot run, at most.
    pub pilot_trials: u32,
}

/// One group of a between-subject design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupDescription {
    /// Its name.
    pub name: String,
    /// Its blocks.
    pub blocks: Vec<String>,
    /// Its trials.
    #[serde(flatten)]
    pub effort: Effort,
}

/// A display in the units of vision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DisplayDescription {
    /// Its name.
    pub name: String,
    /// Width and height in pixels.
    pub resolution_px: [u32; 2],
    /// Width and height in millimetres.
    pub size_mm: [f64; 2],
    /// Distance to the eye in millimetres.
    pub distance_mm: f64,
    /// Refresh rate in hertz.
    pub refresh_hz: f64,
    /// Width and height of the field of view in degrees.
    pub size_deg: [f64; 2],
    /// Pixels per degree at the centre.
    pub px_per_deg: f64,
    /// The finest MAR at the centre, degrees per cycle.
    pub finest_mar_deg: f64,
}

/// Trials and minutes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Effort {
    /// The fewest completed trials.
    pub trials_min: u64,
    /// The most completed trials.
    pub trials_max: u64,
    /// Minutes for the fewest trials.
    pub minutes_min: f64,
    /// Minutes for the most trials.
    pub minutes_max: f64,
}

/// What one block will do.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlockDescription {
    /// Its name.
    pub name: String,
    /// Whether it is practice.
    pub practice: bool,
    /// The condition's name.
    pub condition: String,
    /// The factors that are crossed, each with its levels.
    pub factors: Vec<FactorDescription>,
    /// The cells of the design.
    pub cells: usize,
    /// Scene with its parameters, in words; of the first cell where factors vary it.
    pub scene: String,
    /// Renderer with its parameters, in words; those that levels set are left out.
    pub renderer: String,
    /// How observers look, in words.
    pub looks: String,
    /// The protocol with its timing, in words.
    pub protocol: String,
    /// One trial in seconds, with an answer after [`ANSWER_S`].
    pub trial_s: f64,
    /// The procedure, in words.
    pub procedure: String,
    /// Trials and minutes.
    #[serde(flatten)]
    pub effort: Effort,
    /// Which of reference and test comes first, in words.
    pub presentation: String,
    /// In which order the trials come, in words.
    pub order: String,
    /// Levels that may be shown.
    pub levels: usize,
    /// Whether any level between two limits may be shown; then `levels` counts the limits.
    pub continuous: bool,
    /// Renderer parameters that the levels set, with their ranges.
    pub parameters: Vec<ParameterRange>,
    /// Pairs of eccentricity and MAR left out because the display cannot show them.
    pub levels_beyond_display: usize,
    /// The finest and the coarsest MAR among the levels, degrees per cycle, if they set it.
    pub mar_deg: Option<[f64; 2]>,
    /// What each eccentricity can show, if levels set it.
    pub eccentricities: Vec<EccentricityDescription>,
    /// When the block ends, in words.
    pub stop: String,
    /// A break after so many trials.
    pub break_every_trials: Option<u32>,
    /// A break after so many minutes.
    pub break_every_minutes: Option<f64>,
    /// When practice has been passed, in words.
    pub criterion: Option<String>,
    /// Items of the questionnaire after the block.
    pub questionnaire: Vec<String>,
}

/// A factor and its levels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FactorDescription {
    /// Its name.
    pub name: String,
    /// Its levels.
    pub levels: Vec<String>,
}

/// What the levels of a block set a renderer parameter to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterRange {
    /// The parameter.
    pub name: String,
    /// Distinct values.
    pub values: usize,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

/// What the display shows at one eccentricity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EccentricityDescription {
    /// Eccentricity around the fixation mark, degrees.
    pub eccentricity_deg: f64,
    /// The share of the ring that is on the display, 0–1.
    pub visible_share: f64,
    /// The finest MAR that the display can show there, degrees per cycle.
    pub finest_mar_deg: f64,
    /// The levels at this eccentricity.
    pub levels: usize,
}

/// Says what a plan will do.
#[must_use]
pub fn describe(plan: &Plan) -> Description {
    let blocks: Vec<BlockDescription> = plan.blocks.iter().map(|block| describe_block(block, plan)).collect();
    Description {
        study: plan.name.clone(),
        title: plan.title.clone(),
        about: plan.about.clone(),
        display: describe_display(&plan.display),
        fixation_deg: plan.gaze.fixation_deg,
        gate_deg: plan.gaze.gate.map(|gate| gate.radius_deg),
        gate_grace_s: plan.gaze.gate.map(|gate| gate.grace_s),
        consent: plan.texts.consent.is_some(),
        participant: plan.participant.iter().map(|item| item.name.clone()).collect(),
        instruction_pages: plan.texts.instructions.len(),
        files: plan.files.clone(),
        total: total(blocks.iter()),
        groups: design::groups(plan, &blocks),
        sittings: design::sittings(plan),
        pilot_trials: plan.pilot.trials,
        blocks,
    }
}

/// Trials and minutes of some blocks together.
fn total<'b>(blocks: impl Iterator<Item = &'b BlockDescription>) -> Effort {
    blocks.fold(Effort::default(), |total, block| Effort {
        trials_min: total.trials_min + block.effort.trials_min,
        trials_max: total.trials_max + block.effort.trials_max,
        minutes_min: total.minutes_min + block.effort.minutes_min,
        minutes_max: total.minutes_max + block.effort.minutes_max,
    })
}

fn describe_display(display: &Display) -> DisplayDescription {
    DisplayDescription {
        name: display.name().to_owned(),
        resolution_px: display.resolution_px(),
        size_mm: display.size_mm(),
        distance_mm: display.distance_mm(),
        refresh_hz: display.refresh_hz(),
        size_deg: display.half_field_deg().map(|half| 2.0 * half),
        px_per_deg: 1.0 / display.pixel_deg([0.0, 0.0]),
        finest_mar_deg: display.finest_mar_deg([0.0, 0.0]),
    }
}

fn describe_block(block: &BlockPlan, plan: &Plan) -> BlockDescription {
    let has_feedback = block.practice && block.protocol.has_right_answers();
    let feedback_s = if has_feedback { block.feedback_s } else { 0.0 };
    let trial_s = block.protocol.trial_s(ANSWER_S) + feedback_s;
    let mut protocol = protocol::in_words(&block.protocol);
    if has_feedback {
        protocol.push_str(&format!(", feedback {} s", block.feedback_s));
    }
    let (procedure, stop, levels_beyond_display) = procedure::in_words(&block.procedure);
    let levels = block.procedure.levels();
    let condition = &block.cells[0].condition;
    let minutes = |trials: u32| f64::from(trials) * trial_s / 60.0;
    let (trials_min, trials_max) = (block.min_trials(), block.max_trials());
    BlockDescription {
        name: block.name.clone(),
        practice: block.practice,
        condition: condition.name.split(':').next().unwrap_or_default().to_owned(),
        factors: design::factors(block),
        cells: block.cells.len(),
        scene: with_parameters(&condition.scene, &condition.scene_parameters, |_| true),
        renderer: with_parameters(&condition.renderer, &condition.renderer_parameters, |name| {
            !levels.iter().any(|level| level.contains_key(name))
        }),
        looks: design::looks(block),
        protocol,
        trial_s,
        procedure,
        effort: Effort {
            trials_min: u64::from(trials_min),
            trials_max: u64::from(trials_max),
            minutes_min: minutes(trials_min),
            minutes_max: minutes(trials_max),
        },
        presentation: design::presentation(block),
        order: design::order(block),
        levels: levels.len(),
        continuous: block.procedure.is_continuous(),
        parameters: design::parameter_ranges(levels),
        levels_beyond_display,
        mar_deg: extent(levels.iter().filter_map(|level| condition.tested_at(level)[1])),
        eccentricities: describe_eccentricities(block, plan),
        stop,
        break_every_trials: block.breaks.every_trials,
        break_every_minutes: block.breaks.every_s.map(|seconds| seconds / 60.0),
        criterion: block.criterion.map(design::criterion),
        questionnaire: block.questionnaire.iter().map(|item| item.name.clone()).collect(),
    }
}

fn describe_eccentricities(block: &BlockPlan, plan: &Plan) -> Vec<EccentricityDescription> {
    let condition = &block.cells[0].condition;
    let levels = block.procedure.levels().iter();
    let mut eccentricities: Vec<f64> = levels.filter_map(|level| condition.tested_at(level)[0]).collect();
    eccentricities.sort_by(f64::total_cmp);
    eccentricities
        .chunk_by(|a, b| a.total_cmp(b).is_eq())
        .filter_map(|same| Some((*same.first()?, same.len())))
        .map(|(eccentricity_deg, levels)| EccentricityDescription {
            eccentricity_deg,
            visible_share: plan.display.visible_share(plan.gaze.fixation_deg, eccentricity_deg),
            finest_mar_deg: finest_mar_around(&plan.display, plan.gaze.fixation_deg, eccentricity_deg),
            levels,
        })
        .collect()
}

fn with_parameters<V: fmt::Display>(id: &str, parameters: &BTreeMap<String, V>, keep: impl Fn(&str) -> bool) -> String {
    let shown: Vec<String> =
        parameters.iter().filter(|(name, _)| keep(name)).map(|(name, value)| format!("{name} {value}")).collect();
    match shown.is_empty() {
        true => id.to_owned(),
        false => format!("{id} ({})", shown.join(", ")),
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |extent, value| match extent {
        None => Some([value, value]),
        Some([low, high]) => Some([value.min(low), value.max(high)]),
    })
}
