//! Right and wrong by level: shares with their intervals, a psychometric function where one parameter varies, and
//! Guenter's rule.

use super::strata::{Parts, strata};
use super::{Protocol, Row};
use crate::comparison::{Compared, ComparisonFit, fit_comparison};
use crate::psychometric::{Count, Direction, Guess, PsychometricConfig, PsychometricFit, Scale, fit_psychometric};
use crate::rules::guenter;
use crate::shares::Share;
use experiments::trial::Answer;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// A function is not fitted to fewer answers.
const FEWEST_ANSWERS: usize = 12;
/// Nor to fewer levels, whose width would be the prior's.
const FEWEST_LEVELS: usize = 3;

/// Right and wrong by level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// The parameters of the level that vary, by name.
    pub parameters: Vec<String>,
    /// What "right" means, for people.
    pub right_means: String,
    /// All trials, then the trials of each level of each factor.
    pub parts: Vec<DetectionPart>,
}

/// Right and wrong by level in a part of a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DetectionPart {
    /// The factor levels that the part is about; empty for all trials.
    pub by: BTreeMap<String, String>,
    /// Right answers over all levels.
    pub right: Share,
    /// How often each answer was given.
    pub answers: BTreeMap<String, usize>,
    /// Right answers at each level, ascending in the parameters' values.
    pub cells: Vec<LevelCell>,
    /// The psychometric function, where one parameter varies and there are answers enough.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<PsychometricFit>,
    /// Why there is no function, if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_fit: Option<String>,
    /// The threshold from all three answers of a pair test, which allows for the observer's zone of indifference; the
    /// function above only describes how often the reference was called better.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub comparison: Option<ComparisonFit>,
    /// Guenter's threshold, for pair and ramp ([`guenter::coarsest_unnoticed`]); nothing if every level was always
    /// noticed. It has no interval: a single slip of the finger moves it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coarsest_unnoticed: Option<f64>,
}

/// Right answers at one level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LevelCell {
    /// The varying parameters' values.
    pub level: BTreeMap<String, f64>,
    /// Right answers.
    pub right: Share,
}

impl Detection {
    /// Nothing if no answer is right or wrong.
    pub(super) fn new(protocol: Option<Protocol>, rows: &[Row]) -> Option<Self> {
        let rows: Vec<Row> = rows.iter().filter(|row| row.correct.is_some()).cloned().collect();
        let names: BTreeSet<&String> = rows.iter().flat_map(|row| row.level.keys()).collect();
        let values = |name: &str| -> BTreeSet<u64> {
            rows.iter().filter_map(|row| row.level.get(name)).map(|value| value.to_bits()).collect()
        };
        let parameters: Vec<String> = names.into_iter().filter(|name| values(name).len() > 1).cloned().collect();
        let parts: Vec<DetectionPart> = strata(&rows, Parts::default())
            .into_iter()
            .filter_map(|stratum| part(protocol, &parameters, stratum.by, &stratum.rows))
            .collect();
        let right_means = match protocol {
            Some(Protocol::Pair) => "the reference was named as the better one",
            Some(Protocol::Ramp) => "the ramp's direction was named",
            _ => "the picture asked for was named",
        };
        (!parts.is_empty()).then(|| Self { parameters, right_means: right_means.to_owned(), parts })
    }

    /// The one parameter that varies, if it is one.
    #[must_use]
    pub fn parameter(&self) -> Option<&str> {
        match self.parameters.as_slice() {
            [one] => Some(one),
            _ => None,
        }
    }
}

fn part(
    protocol: Option<Protocol>,
    parameters: &[String],
    by: BTreeMap<String, String>,
    rows: &[&Row],
) -> Option<DetectionPart> {
    let right = Share::of(rows, |row| row.correct == Some(true))?;
    let mut answers = BTreeMap::new();
    for row in rows {
        *answers.entry(answer_name(row.answer)).or_insert(0) += 1;
    }
    let cells = cells(parameters, rows);
    let (mut fit, mut no_fit, mut comparison, mut coarsest_unnoticed) = (None, None, None, None);
    match parameters {
        [parameter] => {
            // A ramp that stays where it is has no direction to name, and "the same" is right there for another reason.
            let changing: Vec<&Row> = rows.iter().copied().filter(|row| !guenter::is_without_change(row)).collect();
            let counts: Vec<Count> = self::cells(parameters, &changing)
                .iter()
                .filter_map(|cell| {
                    let (n, k) = (u32::try_from(cell.right.n).ok()?, u32::try_from(cell.right.k).ok()?);
                    Some(Count { level: *cell.level.get(parameter)?, n, k })
                })
                .collect();
            let direction = direction(parameter, &counts);
            if matches!(protocol, Some(Protocol::Pair | Protocol::Ramp)) {
                coarsest_unnoticed = guenter::coarsest_unnoticed(parameter, direction, rows.iter().copied());
            }
            if protocol == Some(Protocol::Pair) && rows.len() >= FEWEST_ANSWERS {
                comparison = compared(parameter, direction, rows);
            }
            match function(protocol, direction, &counts) {
                Ok(function) => fit = Some(function),
                Err(reason) => no_fit = Some(reason),
            }
        }
        [] => no_fit = Some("the level does not vary".to_owned()),
        several => no_fit = Some(format!("{} vary together, and a function is fitted to one", several.join(", "))),
    }
    Some(DetectionPart { by, right, answers, cells, fit, no_fit, comparison, coarsest_unnoticed })
}

/// Right answers at each combination of the varying parameters.
fn cells(parameters: &[String], rows: &[&Row]) -> Vec<LevelCell> {
    let mut groups: Vec<(BTreeMap<String, f64>, Vec<&Row>)> = Vec::new();
    for &row in rows {
        let level: BTreeMap<String, f64> =
            parameters.iter().filter_map(|name| row.level.get(name).map(|&value| (name.clone(), value))).collect();
        match groups.iter_mut().find(|(known, _)| *known == level) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((level, vec![row])),
        }
    }
    groups.sort_by(|(a, _), (b, _)| {
        let by_value = a.values().zip(b.values()).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        by_value.unwrap_or_else(|| a.len().cmp(&b.len()))
    });
    groups
        .into_iter()
        .filter_map(|(level, rows)| Some(LevelCell { level, right: Share::of(rows, |row| row.correct == Some(true))? }))
        .collect()
}

/// A larger quality index is finer (Guenter 2012, §5); of any other parameter the answers must tell.
fn direction(parameter: &str, counts: &[Count]) -> Direction {
    if parameter == "quality_index" { Direction::Falls } else { Direction::of_counts(counts) }
}

/// The three answers of a pair test by level, and what they say.
fn compared(parameter: &str, direction: Direction, rows: &[&Row]) -> Option<ComparisonFit> {
    let mut counts: Vec<Compared> = Vec::new();
    for row in rows {
        let level = *row.level.get(parameter)?;
        let at = counts.iter().position(|count| count.level.total_cmp(&level).is_eq()).unwrap_or_else(|| {
            counts.push(Compared { level, reference: 0, same: 0, test: 0 });
            counts.len() - 1
        });
        match (row.answer, row.correct) {
            (Answer::Same, _) => counts[at].same += 1,
            (_, Some(true)) => counts[at].reference += 1,
            _ => counts[at].test += 1,
        }
    }
    counts.sort_by(|a, b| a.level.total_cmp(&b.level));
    let levels: Vec<f64> = counts.iter().map(|count| count.level).collect();
    fit_comparison(&counts, Scale::of_levels(&levels), direction)
}

fn function(protocol: Option<Protocol>, direction: Direction, counts: &[Count]) -> Result<PsychometricFit, String> {
    let answers: u32 = counts.iter().map(|count| count.n).sum();
    if (answers as usize) < FEWEST_ANSWERS {
        return Err(format!("{answers} answers, and a function is fitted to {FEWEST_ANSWERS} or more"));
    }
    let levels: Vec<f64> = counts.iter().map(|count| count.level).collect();
    // Counts are one for each level.
    if levels.len() < FEWEST_LEVELS {
        return Err(format!("answers at {} level(s), and a function needs at least {FEWEST_LEVELS}", levels.len()));
    }
    let guess = if protocol.is_none_or(Protocol::is_forced_choice) { Guess::Fixed(0.5) } else { Guess::Free };
    let config = PsychometricConfig {
        scale: Scale::of_levels(&levels),
        direction,
        guess,
        ..PsychometricConfig::TWO_ALTERNATIVES
    };
    fit_psychometric(counts, &config).map_err(|error| error.to_string())
}

/// An answer as it is written to logs; an option by its number.
fn answer_name(answer: Answer) -> String {
    match answer {
        Answer::Option(number) => number.to_string(),
        answer => serde_json::to_value(answer)
            .ok()
            .and_then(|value| value.as_str().map(str::to_owned))
            .unwrap_or_else(|| "other".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::*;

    /// Two orders at each of eight quality indices; once fooled at 14, always from 18 on.
    fn pair_rows() -> Vec<Row> {
        (4..12)
            .flat_map(|half| [0, 1].map(|order| (f64::from(2 * half), order)))
            .map(|(j, order)| {
                let fooled = j >= 18.0 || (j > 13.0 && order == 0);
                let answer = if fooled { Answer::Same } else { Answer::First };
                row(answer, Some(!fooled)).at("quality_index", j).at("alpha", 0.5)
            })
            .collect()
    }

    #[test]
    fn a_pair_block_has_guenters_threshold_and_a_falling_function() {
        let detection = Detection::new(Some(Protocol::Pair), &pair_rows()).unwrap();
        assert_eq!(detection.parameter(), Some("quality_index"));
        let [part] = detection.parts.as_slice() else { panic!("{:?}", detection.parts) };
        assert_eq!((part.right.k, part.right.n, part.cells.len()), (8, 16, 8));
        assert_eq!(part.coarsest_unnoticed, Some(14.0));
        assert_eq!(part.answers, BTreeMap::from([("first".to_owned(), 8), ("same".to_owned(), 8)]));
        let fit = part.fit.as_ref().unwrap();
        assert_eq!((fit.config.direction, fit.config.guess), (Direction::Falls, Guess::Free));
        // Shares 1, 1, 1, ½, ½, 0, 0, 0 at 8 … 22 are symmetric about 15.
        assert!((fit.threshold.estimate - 15.0).abs() < 0.5, "{:?}", fit.threshold);
        assert!(fit.support.is_supported());
    }

    #[test]
    fn a_level_that_was_always_noticed_gives_no_threshold() {
        let named = |row| Row { answer: Answer::Decreased, correct: Some(true), ..row };
        let rows: Vec<Row> = pair_rows().into_iter().map(named).collect();
        let detection = Detection::new(Some(Protocol::Ramp), &rows).unwrap();
        assert_eq!(detection.parts[0].coarsest_unnoticed, None);
        assert!(!detection.parts[0].fit.as_ref().unwrap().support.is_supported());
    }

    #[test]
    fn a_ramp_without_change_is_in_the_table_and_not_in_the_function() {
        let ramp = |j: f64, answer, correct| {
            row(answer, Some(correct)).at("quality_index", j).found("from", 22.0).found("to", j)
        };
        let mut rows: Vec<Row> = [4.0, 5.0, 7.0, 10.0, 12.0, 15.0, 17.0]
            .into_iter()
            .flat_map(|j| {
                let second = if j < 11.0 { ramp(j, Answer::Decreased, true) } else { ramp(j, Answer::Same, false) };
                [ramp(j, Answer::Decreased, true), second]
            })
            .collect();
        rows.extend([ramp(22.0, Answer::Same, true), ramp(22.0, Answer::Same, true)]);
        let detection = Detection::new(Some(Protocol::Ramp), &rows).unwrap();
        let part = &detection.parts[0];
        assert_eq!((part.cells.len(), part.cells[7].right.k), (8, 2));
        let fitted = &part.fit.as_ref().unwrap().counts;
        assert_eq!((fitted.len(), fitted[6].level), (7, 17.0));
    }

    #[test]
    fn two_parameters_give_a_table_for_each_patch_and_no_function() {
        let mut rows = Vec::new();
        for patch in ["forest", "tiles"] {
            for radius in [4.0, 7.0, 11.0] {
                for rate in [0.0017, 0.0035, 0.0052] {
                    for repetition in 0..10 {
                        let correct = repetition < if rate > 0.003 { 9 } else { 5 };
                        let row = row(Answer::First, Some(correct)).at("radius_deg", radius).at("rate", rate);
                        rows.push(row.in_cell("patch", patch));
                    }
                }
            }
        }
        let detection = Detection::new(Some(Protocol::Toggle), &rows).unwrap();
        assert_eq!((detection.parts.len(), detection.parameter()), (3, None));
        for (part, n) in detection.parts.iter().zip([20, 10, 10]) {
            assert_eq!(part.cells.len(), 9);
            assert!(part.cells.iter().all(|cell| cell.right.n == n && cell.level.len() == 2));
            assert!(part.fit.is_none() && part.no_fit.as_ref().unwrap().contains("vary together"));
        }
        assert!((detection.parts[1].cells[1].right.share - 0.9).abs() < 1e-12);
        assert_eq!(detection.parts[1].by["patch"], "forest");
    }

    #[test]
    fn too_few_answers_and_levels_say_so() {
        let few = Detection::new(Some(Protocol::Pair), &pair_rows()[..10]).unwrap();
        assert!(few.parts[0].no_fit.as_ref().unwrap().contains("10 answers"), "{few:?}");
        let two: Vec<Row> =
            (0..20).map(|i| row(Answer::First, Some(i % 3 == 0)).at("mar_deg", f64::from(i % 2 + 1))).collect();
        let two = Detection::new(Some(Protocol::TwoInterval), &two).unwrap();
        assert!(two.parts[0].no_fit.as_ref().unwrap().contains("at least 3"), "{two:?}");
        let one: Vec<Row> = (0..20).map(|_| row(Answer::First, Some(true)).at("mar_deg", 1.0)).collect();
        let one = Detection::new(Some(Protocol::TwoInterval), &one).unwrap();
        assert_eq!(one.parts[0].no_fit.as_deref(), Some("the level does not vary"));
    }
}
