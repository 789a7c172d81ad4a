//! Questions with their own words: participant forms, questionnaires, Likert items, the answer of a task.

/// One question.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// Its name in the data.
    pub name: String,
    /// Its words.
    pub question: String,
    /// What is accepted.
    pub kind: ItemKind,
}

/// What an item accepts.
#[derive(Debug, Clone, PartialEq)]
pub enum ItemKind {
    /// A step of a scale of whole numbers, such as −3 (strongly disagree) to 3 (strongly agree) (Weier 2016, §4.2.1).
    Scale {
        /// The lowest step.
        low: i32,
        /// The highest step; at most nine steps, one for each digit key.
        high: i32,
        /// What the lowest step means.
        low_anchor: String,
        /// What the highest step means.
        high_anchor: String,
    },
    /// One of at most nine options.
    Choice {
        /// The options.
        options: Vec<String>,
    },
    /// A typed number.
    Number {
        /// The smallest.
        min: f64,
        /// The largest.
        max: f64,
        /// Unit, for people; may be empty.
        unit: String,
        /// Whether only whole numbers are accepted.
        whole: bool,
    },
    /// A typed text.
    Text {
        /// Characters at most.
        max_length: usize,
    },
}
