//! Questions with their own words, as a study writes them: participant forms, questionnaires, rated items.

use schemars::JsonSchema;
use serde::Deserialize;

/// One question.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ItemDraft {
    /// A step on a scale of whole numbers.
    Scale(ScaleDraft),
    /// One of several options.
    Choice(ChoiceDraft),
    /// A typed number.
    Number(NumberDraft),
    /// A typed text.
    Text(TextDraft),
}

/// A step on a scale of whole numbers, chosen with a digit.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaleDraft {
    /// Its name in the data: a-z, 0-9, hyphens and underscores, a letter first.
    #[schemars(required)]
    pub name: Option<String>,
    /// The statement or question.
    #[schemars(required, length(min = 1))]
    pub question: Option<String>,
    /// The lowest step; -3 when absent.
    #[schemars(range(min = -1000, max = 1000))]
    pub low: Option<i32>,
    /// The highest step; 3 when absent. There are at most nine steps, one for each digit key.
    #[schemars(range(min = -1000, max = 1000))]
    pub high: Option<i32>,
    /// What the lowest step means; "strongly disagree" when absent.
    pub low_anchor: Option<String>,
    /// What the highest step means; "strongly agree" when absent.
    pub high_anchor: Option<String>,
}

/// One of several options, chosen with a digit.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChoiceDraft {
    /// Its name in the data: a-z, 0-9, hyphens and underscores, a letter first.
    #[schemars(required)]
    pub name: Option<String>,
    /// The question.
    #[schemars(required, length(min = 1))]
    pub question: Option<String>,
    /// The options, two to nine; the data hold their number, from 1.
    #[schemars(required)]
    pub options: Option<Vec<Option<String>>>,
}

/// A typed number.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumberDraft {
    /// Its name in the data: a-z, 0-9, hyphens and underscores, a letter first.
    #[schemars(required)]
    pub name: Option<String>,
    /// The question.
    #[schemars(required, length(min = 1))]
    pub question: Option<String>,
    /// The smallest number that is taken.
    #[schemars(required, range(min = -1e9, max = 1e9))]
    pub min: Option<f64>,
    /// The largest number that is taken.
    #[schemars(required, range(min = -1e9, max = 1e9))]
    pub max: Option<f64>,
    /// Its unit, shown beside the range; none when absent.
    pub unit: Option<String>,
    /// Whether only whole numbers are taken; false when absent.
    pub whole: Option<bool>,
}

/// A typed text.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TextDraft {
    /// Its name in the data: a-z, 0-9, hyphens and underscores, a letter first.
    #[schemars(required)]
    pub name: Option<String>,
    /// The question.
    #[schemars(required, length(min = 1))]
    pub question: Option<String>,
    /// Characters at most; 200 when absent.
    #[schemars(range(min = 1, max = 2000))]
    pub max_length: Option<u32>,
}

impl ItemDraft {
    /// Name and question, which every kind has.
    pub(in crate::study) fn words(&self) -> [Option<&str>; 2] {
        let (name, question) = match self {
            Self::Scale(draft) => (&draft.name, &draft.question),
            Self::Choice(draft) => (&draft.name, &draft.question),
            Self::Number(draft) => (&draft.name, &draft.question),
            Self::Text(draft) => (&draft.name, &draft.question),
        };
        [name.as_deref(), question.as_deref()]
    }
}
