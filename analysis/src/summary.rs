//! The JSON document of `parafovea analyze --json`.
//!
//! These are file types, kept apart from the domain's [`crate::mar::MarFit`] so that the fit may change while readers of
//! the document need not. Keys are only ever added; those of the MAR fit are there for observers that have one.

use crate::answers::BlockSummary;
use crate::answers::group::GroupRow;
use crate::mar::{Estimate, Goodness, MarFit, Support, Threshold};
use experiments::trial::form::Entries;
use serde::{Deserialize, Serialize};

/// The whole document.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Analysis {
    /// One entry per observer, in the order given.
    pub observers: Vec<ObserverSummary>,
    /// Means over observers, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub group: Vec<GroupRow>,
}

impl Analysis {
    /// The document of some observers, with their means.
    #[must_use]
    pub fn new(observers: Vec<ObserverSummary>) -> Self {
        let group = crate::answers::group::over_observers(observers.iter().map(|observer| observer.blocks.as_slice()));
        Self { observers, group }
    }
}

/// One observer's results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverSummary {
    /// The observer's code.
    pub observer: String,
    /// The data are from pilot runs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub pilot: bool,
    /// The fitted line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mar: Option<MarSummary>,
    /// Thresholds, ascending in eccentricity.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thresholds: Vec<ThresholdSummary>,
    /// Trials given to the MAR fit; without one, all answered trials.
    pub trials: usize,
    /// Trials left out of the MAR fit because the display could not show their level.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trials_not_shown: Option<usize>,
    /// Whether the data carry the MAR fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub support: Option<SupportSummary>,
    /// What to know beside the numbers.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Goodness of the MAR fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goodness: Option<Goodness>,
    /// Effective sample size behind the MAR fit's intervals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ess: Option<f64>,
    /// What the answers of each block come to.
    #[serde(default)]
    pub blocks: Vec<BlockSummary>,
    /// Forms that were filled in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forms: Vec<FormSummary>,
}

/// A form that was filled in: the participant's, or a block's questionnaire.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FormSummary {
    /// The session's name.
    pub session: String,
    /// `participant`, or the block whose questionnaire it is.
    pub form: String,
    /// What was entered, by item: a number or a text.
    pub entries: Entries,
}

/// The fitted line; MAR in degrees per cycle, m in degrees per cycle per degree.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MarSummary {
    /// Slope.
    pub m: Estimate,
    /// MAR at the fovea.
    pub omega0: Estimate,
    /// Width of the psychometric function in ln omega.
    pub width: Estimate,
    /// Lapse rate.
    pub lapse: Estimate,
    /// omega0 lies below what the display could show: it is extrapolated.
    pub display_limited: bool,
}

/// The threshold at one eccentricity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ThresholdSummary {
    /// Eccentricity, degrees.
    pub eccentricity_deg: f64,
    /// Threshold, degrees per cycle; an upper limit where `limited`.
    pub mar_deg: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// Below what the display could show.
    pub limited: bool,
    /// Trials at this eccentricity.
    pub trials: usize,
}

/// Whether a fit is supported, flat for readers in any language.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SupportSummary {
    /// False when the numbers are not a result.
    pub supported: bool,
    /// Why not, one sentence each.
    pub reasons: Vec<String>,
}

impl From<&Support> for SupportSummary {
    fn from(support: &Support) -> Self {
        Self { supported: support.is_supported(), reasons: support.reasons().to_vec() }
    }
}

impl ObserverSummary {
    /// The entry of one observer; without a MAR fit, `trials` counts the blocks' answers.
    #[must_use]
    pub fn new(observer: impl Into<String>, fit: Option<&MarFit>, blocks: Vec<BlockSummary>) -> Self {
        let threshold = |t: &Threshold| ThresholdSummary {
            eccentricity_deg: t.eccentricity_deg,
            mar_deg: t.mar_deg,
            ci95: t.ci95,
            limited: t.limited,
            trials: t.trials,
        };
        Self {
            observer: observer.into(),
            pilot: false,
            mar: fit.map(|fit| MarSummary {
                m: fit.m,
                omega0: fit.omega0,
                width: fit.width,
                lapse: fit.lapse,
                display_limited: fit.display_limited,
            }),
            thresholds: fit.map_or_else(Vec::new, |fit| fit.thresholds.iter().map(threshold).collect()),
            trials: fit.map_or_else(|| blocks.iter().map(|block| block.trials).sum(), |fit| fit.trials),
            trials_not_shown: fit.map(|fit| fit.trials_not_shown),
            support: fit.map(|fit| SupportSummary::from(&fit.support)),
            warnings: fit.map_or_else(Vec::new, |fit| fit.warnings.clone()),
            goodness: fit.map(|fit| fit.goodness),
            ess: fit.map(|fit| fit.ess),
            blocks,
            forms: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the first version of the document wrote it.
    const OLD: &str = r#"{"observers":[{"observer":"P01","mar":{"m":{"estimate":0.022,"ci95":[0.02,0.024]},
        "omega0":{"estimate":0.021,"ci95":[0.018,0.025]},"width":{"estimate":0.8,"ci95":[0.6,1.1]},
        "lapse":{"estimate":0.01,"ci95":[0.001,0.03]},"display_limited":false},
        "thresholds":[{"eccentricity_deg":5.0,"mar_deg":0.13,"ci95":[0.11,0.15],"limited":false,"trials":80}],
        "trials":80,"trials_not_shown":0,"support":{"supported":true,"reasons":[]},"warnings":[],
        "goodness":{"deviance":9.1,"pooled_levels":9,"p":0.4,"simulations":500},"ess":2100.0}]}"#;

    #[test]
    fn old_documents_are_read_and_their_keys_are_written() {
        let old: Analysis = serde_json::from_str(OLD).unwrap();
        let observer = &old.observers[0];
        assert!((observer.mar.unwrap().m.estimate - 0.022).abs() < 1e-12 && observer.blocks.is_empty());
        let written = serde_json::to_value(&old).unwrap();
        let read: serde_json::Value = serde_json::from_str(OLD).unwrap();
        for (key, value) in read["observers"][0].as_object().unwrap() {
            assert_eq!(&written["observers"][0][key], value, "{key}");
        }
    }

    #[test]
    fn an_observer_without_a_mar_fit_has_no_empty_keys_of_it() {
        let written = serde_json::to_value(ObserverSummary::new("P01", None, Vec::new())).unwrap();
        let keys: Vec<&String> = written.as_object().unwrap().keys().collect();
        assert_eq!(keys, ["observer", "trials", "warnings", "blocks"]);
    }
}
