//! Shuffling with constraints: groups stay together, and no factor's level comes twice in a row where a study forbids it.

use crate::study::plan::{GroupOrder, OrderPlan};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Attempts at an order without repetition.
const ATTEMPTS: usize = 200;

/// What the order of a trial depends on: the levels of its factors.
pub(crate) type Factors<'a> = &'a BTreeMap<String, String>;

/// Indices into `trials`, in the order in which they come, and how often a level that must not be repeated is.
///
/// A study whose constraint cannot be met gives the order with the fewest repetitions that was found; `check` refuses it.
pub(crate) fn arrange(trials: &[Factors<'_>], plan: &OrderPlan, rng: &mut ChaCha8Rng) -> (Vec<usize>, usize) {
    let mut groups: Vec<(Vec<&str>, Vec<usize>)> = Vec::new();
    for (index, factors) in trials.iter().enumerate() {
        let key = group_key(factors, plan);
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, members)) => members.push(index),
            None => groups.push((key, vec![index])),
        }
    }
    if plan.groups == GroupOrder::Shuffled {
        shuffle_groups(&mut groups, rng);
    }
    let (mut arranged, mut repeats) = (Vec::with_capacity(trials.len()), 0);
    for (_, members) in groups {
        if !plan.shuffled {
            arranged.extend(members);
            continue;
        }
        let last = arranged.last().copied();
        let (members, found) = without_repeats(trials, members, last, plan, rng);
        arranged.extend(members);
        repeats += found;
    }
    (arranged, repeats)
}

/// The levels of the factors that a trial is grouped by.
pub(crate) fn group_key<'a>(factors: Factors<'a>, plan: &OrderPlan) -> Vec<&'a str> {
    plan.grouped_by.iter().map(|name| factors.get(name).map_or("", String::as_str)).collect()
}

/// Shuffles groups so that those of one outer level stay together.
fn shuffle_groups(groups: &mut [(Vec<&str>, Vec<usize>)], rng: &mut ChaCha8Rng) {
    let depth = groups.first().map_or(0, |(key, _)| key.len());
    // Each level gets a random rank among those of the same outer levels; sorting by ranks keeps outer levels together.
    let mut ranks: BTreeMap<Vec<&str>, u32> = BTreeMap::new();
    for level in 1..=depth {
        let mut prefixes: Vec<Vec<&str>> = groups.iter().map(|(key, _)| key[..level].to_vec()).collect();
        prefixes.sort();
        prefixes.dedup();
        prefixes.shuffle(rng);
        ranks.extend(prefixes.into_iter().zip(0..));
    }
    groups.sort_by_key(|(key, _)| (1..=depth).map(|level| ranks.get(&key[..level]).copied()).collect::<Vec<_>>());
}

/// Shuffles `members` so that no level of a `no_repeat` factor follows itself, as far as that can be done.
fn without_repeats(
    trials: &[Factors<'_>],
    mut members: Vec<usize>,
    before: Option<usize>,
    plan: &OrderPlan,
    rng: &mut ChaCha8Rng,
) -> (Vec<usize>, usize) {
    members.shuffle(rng);
    if plan.no_repeat.is_empty() {
        return (members, 0);
    }
    let mut best: Option<(Vec<usize>, usize)> = None;
    for _ in 0..ATTEMPTS {
        let (order, repeats) = greedy(trials, &members, before, &plan.no_repeat, rng);
        if best.as_ref().is_none_or(|(_, fewest)| repeats < *fewest) {
            best = Some((order, repeats));
        }
        if best.as_ref().is_some_and(|(_, fewest)| *fewest == 0) {
            break;
        }
        members.shuffle(rng);
    }
    best.unwrap_or((members, 0))
}

/// Takes one trial after the other at random among those that repeat nothing; a level of which more than every other
/// place is left has to come now.
fn greedy(
    trials: &[Factors<'_>],
    members: &[usize],
    before: Option<usize>,
    no_repeat: &[String],
    rng: &mut ChaCha8Rng,
) -> (Vec<usize>, usize) {
    let level = |trial: usize, factor: usize| trials[trial].get(&no_repeat[factor]).map(String::as_str);
    let mut counts: Vec<BTreeMap<Option<&str>, usize>> = vec![BTreeMap::new(); no_repeat.len()];
    for &trial in members {
        for (factor, counts) in counts.iter_mut().enumerate() {
            *counts.entry(level(trial, factor)).or_default() += 1;
        }
    }
    let mut left = members.to_vec();
    let mut order: Vec<usize> = Vec::with_capacity(members.len());
    let mut repeats = 0;
    while !left.is_empty() {
        let last = order.last().copied().or(before);
        let repeated = |trial: usize| {
            last.is_some_and(|last| (0..no_repeat.len()).any(|factor| level(last, factor) == level(trial, factor)))
        };
        let pressing = |trial: usize| {
            counts.iter().enumerate().any(|(factor, counts)| counts[&level(trial, factor)] > left.len() / 2)
        };
        let free: Vec<usize> = (0..left.len()).filter(|&at| !repeated(left[at])).collect();
        let urgent: Vec<usize> = free.iter().copied().filter(|&at| pressing(left[at])).collect();
        let among = if urgent.is_empty() { &free } else { &urgent };
        let at = match among.len() {
            0 => {
                repeats += 1;
                rng.random_range(0..left.len())
            }
            n => among[rng.random_range(0..n)],
        };
        let trial = left.swap_remove(at);
        for (factor, counts) in counts.iter_mut().enumerate() {
            if let Some(count) = counts.get_mut(&level(trial, factor)) {
                *count -= 1;
            }
        }
        order.push(trial);
    }
    (order, repeats)
}

/// An order of `trials` for after `before`, repeating as little as can be.
pub(crate) fn rearrange(
    trials: &[Factors<'_>],
    before: Option<Factors<'_>>,
    plan: &OrderPlan,
    rng: &mut ChaCha8Rng,
) -> Vec<usize> {
    let with_last: Vec<Factors<'_>> = trials.iter().copied().chain(before).collect();
    let last = before.map(|_| trials.len());
    without_repeats(&with_last, (0..trials.len()).collect(), last, plan, rng).0
}

/// Whether two trials may follow one another.
pub(crate) fn may_follow(a: Factors<'_>, b: Factors<'_>, plan: &OrderPlan) -> bool {
    plan.no_repeat.iter().all(|factor| a.get(factor) != b.get(factor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::Stream;
    use proptest::prelude::*;

    fn factors(levels: &[(&str, u32)]) -> BTreeMap<String, String> {
        levels.iter().map(|(name, level)| ((*name).to_owned(), level.to_string())).collect()
    }

    fn crossed(scenes: u32, regions: u32, repetitions: u32) -> Vec<BTreeMap<String, String>> {
        let mut trials = Vec::new();
        for _ in 0..repetitions {
            for scene in 0..scenes {
                trials.extend((0..regions).map(|region| factors(&[("scene", scene), ("region", region)])));
            }
        }
        trials
    }

    fn arranged(trials: &[BTreeMap<String, String>], plan: &OrderPlan, seed: u64) -> (Vec<usize>, usize) {
        arrange(&trials.iter().collect::<Vec<_>>(), plan, &mut Stream::Design.generator(seed))
    }

    proptest! {
        /// Every trial comes once, whatever the constraints; and where each level is at most every other trial, nothing is
        /// repeated.
        #[test]
        fn arrangements_are_permutations_that_keep_their_constraints(
            scenes in 2u32..6, regions in 1u32..5, repetitions in 1u32..4, seed in 0u64..1000,
            grouped in any::<bool>(), constrained in any::<bool>(),
        ) {
            let trials = crossed(scenes, regions, repetitions);
            let plan = OrderPlan {
                grouped_by: if grouped { vec!["region".to_owned()] } else { Vec::new() },
                no_repeat: if constrained { vec!["scene".to_owned()] } else { Vec::new() },
                ..OrderPlan::default()
            };
            let (order, repeats) = arranged(&trials, &plan, seed);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            prop_assert_eq!(sorted, (0..trials.len()).collect::<Vec<_>>());
            let followed = order.windows(2).filter(|pair| trials[pair[0]]["scene"] == trials[pair[1]]["scene"]).count();
            if constrained {
                prop_assert_eq!(followed, repeats);
                // Two scenes in groups of an odd number may have to repeat at a seam.
                if scenes > 2 || !grouped {
                    prop_assert_eq!(repeats, 0);
                }
            }
            if grouped {
                let changes = order.windows(2).filter(|p| trials[p[0]]["region"] != trials[p[1]]["region"]).count();
                prop_assert_eq!(changes, regions as usize - 1);
            }
        }
    }

    #[test]
    fn an_impossible_constraint_is_reported_by_its_repeats() {
        let trials: Vec<_> = [0, 0, 0, 0, 1].iter().map(|&scene| factors(&[("scene", scene)])).collect();
        let plan = OrderPlan { no_repeat: vec!["scene".to_owned()], ..OrderPlan::default() };
        let (_, repeats) = arranged(&trials, &plan, 1);
        assert_eq!(repeats, 2);
    }

    #[test]
    fn unshuffled_trials_come_as_listed() {
        let trials = crossed(3, 2, 2);
        let plan = OrderPlan { shuffled: false, groups: GroupOrder::Listed, ..OrderPlan::default() };
        assert_eq!(arranged(&trials, &plan, 5).0, (0..12).collect::<Vec<_>>());
    }

    /// With no constraint every place is equally likely for every trial (χ² of 24 places at 4800 shuffles).
    #[test]
    fn plain_shuffles_favour_no_place() {
        let trials = crossed(4, 1, 1);
        let mut counts = [[0_u32; 4]; 4];
        for seed in 0..4800 {
            for (place, &trial) in arranged(&trials, &OrderPlan::default(), seed).0.iter().enumerate() {
                counts[trial][place] += 1;
            }
        }
        let chi2: f64 = counts.iter().flatten().map(|&n| (f64::from(n) - 1200.0).powi(2) / 1200.0).sum();
        // 9 degrees of freedom; 99.9 % lie below 27.9.
        assert!(chi2 < 27.9, "{chi2}: {counts:?}");
    }

    #[test]
    fn nested_groups_stay_within_their_outer_group() {
        let trials = crossed(4, 3, 2);
        let plan = OrderPlan { grouped_by: vec!["scene".to_owned(), "region".to_owned()], ..OrderPlan::default() };
        for seed in 0..50 {
            let (order, _) = arranged(&trials, &plan, seed);
            let changes = |factor: &str| {
                order.windows(2).filter(|pair| trials[pair[0]][factor] != trials[pair[1]][factor]).count()
            };
            assert_eq!(changes("scene"), 3);
            let pairs = order.windows(2).filter(|pair| trials[pair[0]] != trials[pair[1]]).count();
            assert_eq!(pairs, 11);
        }
    }
}
