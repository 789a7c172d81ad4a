//! Schedules as a whole: every trial of a design is completed exactly once, however trials are interrupted.

use super::*;
use crate::catalogue::DetailLaw;
use crate::streams::Stream;
use crate::study::plan::*;
use crate::study::tests::{STUDY, parse};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// A block of `scenes` × `regions` cells with `levels` levels.
fn block(scenes: u32, regions: u32, levels: u32, repetitions: u32) -> BlockPlan {
    let cell = |scene: u32, region: u32| Cell {
        factors: BTreeMap::from([("scene".to_owned(), scene.to_string()), ("region".to_owned(), region.to_string())]),
        condition: Condition {
            name: format!("{scene}-{region}"),
            scene: "photo".to_owned(),
            scene_parameters: BTreeMap::new(),
            renderer: "ring".to_owned(),
            renderer_parameters: BTreeMap::new(),
            detail: DetailLaw::Full,
            fixation: Fixation::Cross,
            foveation: FoveationCentre::Gaze,
        },
    };
    let level = |value: u32| Level::from([("mar_deg".to_owned(), f64::from(value))]);
    BlockPlan {
        name: "main".to_owned(),
        practice: false,
        criterion: None,
        instructions: None,
        cells: (0..scenes).flat_map(|scene| (0..regions).map(move |region| cell(scene, region))).collect(),
        protocol: ProtocolPlan::TwoInterval(TwoIntervalPlan {
            fixation_s: 0.5,
            interval_s: 0.3,
            gap_s: 0.2,
            answer_timeout_s: None,
            question: "Which?".to_owned(),
            wanted: Wanted::Degraded,
        }),
        feedback_s: 0.3,
        procedure: ProcedurePlan::Constant(ConstantPlan { levels: (1..=levels).map(level).collect(), repetitions }),
        presentation_order: PresentationOrder::Random,
        order: OrderPlan::default(),
        breaks: BreakPlan::default(),
        at_most_trials: None,
        questionnaire: Vec::new(),
    }
}

/// Runs a schedule to its end; every trial for which `interrupted` says so is taken back. Returns completed trials in
/// their order.
fn run(block: &BlockPlan, seed: u64, interrupted: impl FnMut(u64) -> bool) -> Vec<Planned> {
    run_watched(block, seed, interrupted, |_| {})
}

/// As [`run`], with every trial that is shown told to `watch`.
fn run_watched(
    block: &BlockPlan,
    seed: u64,
    mut interrupted: impl FnMut(u64) -> bool,
    mut watch: impl FnMut(&Planned),
) -> Vec<Planned> {
    let mut design = Stream::Design.generator(seed);
    let mut choice = Stream::Procedure.generator(seed);
    let mut schedule = Schedule::new(block, &mut design);
    let mut completed = Vec::new();
    for shown in 0..100_000 {
        if schedule.finished() {
            return completed;
        }
        let planned = schedule.next(&mut design, &mut choice).expect("unfinished");
        watch(&planned);
        if interrupted(shown) {
            schedule.put_back(planned, &mut design);
        } else {
            schedule.complete(&planned, Some(shown % 3 > 0));
            completed.push(planned);
        }
    }
    panic!("the schedule does not end");
}

fn key(planned: &Planned) -> String {
    format!("{} {:?} {:?}", planned.cell, planned.level, planned.order)
}

proptest! {
    #[test]
    fn every_trial_of_a_list_is_completed_exactly_once(
        scenes in 1u32..4, regions in 1u32..4, levels in 1u32..4, repetitions in 1u32..4,
        seed in 0u64..500, every in 2u64..6, both in any::<bool>(), grouped in any::<bool>(),
    ) {
        let mut block = block(scenes, regions, levels, repetitions);
        if both {
            block.presentation_order = PresentationOrder::Both;
        }
        if grouped {
            block.order.grouped_by = vec!["scene".to_owned()];
        }
        let completed = run(&block, seed, |shown| shown % every == 1);
        prop_assert_eq!(completed.len() as u32, block.max_trials());
        let mut counts: BTreeMap<(usize, String), u32> = BTreeMap::new();
        for planned in &completed {
            *counts.entry((planned.cell, format!("{:?}", planned.level))).or_default() += 1;
        }
        let each = repetitions * block.orders();
        prop_assert!(counts.values().all(|&count| count == each), "{:?}", counts);
        if both {
            let firsts = completed.iter().filter(|planned| planned.order == TEST_FIRST).count();
            prop_assert_eq!(2 * firsts, completed.len());
        }
        if grouped {
            let scene = |planned: &Planned| block.cells[planned.cell].factors["scene"].clone();
            let changes = completed.windows(2).filter(|pair| scene(&pair[0]) != scene(&pair[1])).count();
            prop_assert_eq!(changes as u32, scenes - 1);
        }
    }

    /// The same seed and the same course give the same trials; paths are another for every cell and level, and the same in
    /// repetitions.
    #[test]
    fn schedules_are_functions_of_their_seed(seed in 0u64..500, every in 2u64..6) {
        let block = block(3, 2, 2, 3);
        let keys = |seed| run(&block, seed, |shown| shown % every == 0).iter().map(key).collect::<Vec<_>>();
        prop_assert_eq!(keys(seed), keys(seed));
        let mut seeds: BTreeMap<(usize, String), Vec<u64>> = BTreeMap::new();
        for planned in run(&block, seed, |_| false) {
            seeds.entry((planned.cell, format!("{:?}", planned.level))).or_default().push(planned.path_seed);
        }
        prop_assert!(seeds.values().all(|own| own.len() == 3 && own.iter().all(|path| *path == own[0])));
        let mut distinct: Vec<u64> = seeds.values().map(|own| own[0]).collect();
        distinct.sort_unstable();
        distinct.dedup();
        prop_assert_eq!(distinct.len(), seeds.len());
    }
}

/// A trial that is put back may land anywhere, but not where what is shown would repeat a level that must not be
/// repeated.
#[test]
fn interrupted_trials_come_back_without_breaking_the_constraint() {
    let mut block = block(4, 2, 1, 3);
    block.order.no_repeat = vec!["scene".to_owned()];
    let (mut repeats, mut trials) = (0, 0);
    for seed in 0..200 {
        let mut shown = Vec::new();
        run_watched(
            &block,
            seed,
            |index| index % 7 == 3,
            |planned| {
                shown.push(block.cells[planned.cell].factors["scene"].clone());
            },
        );
        trials += shown.len();
        repeats += shown.windows(2).filter(|pair| pair[0] == pair[1]).count();
    }
    // Near a block's end there may be no order left that keeps it: A, A and B cannot follow A.
    println!("{repeats} repeats in {trials} trials");
    assert!(repeats * 50 <= trials, "{repeats} repeats in {trials} trials");
}

/// QUEST+ with so many trials in each cell.
fn quest_plus(max_trials: u32) -> ProcedurePlan {
    let stop = format!("\"max_trials\": {max_trials}, \"min_trials\": {max_trials}");
    let text = STUDY.replace("\"max_trials\": 240, \"min_trials\": 80, \"m_relative_sd\": 0.08", &stop);
    parse(&text).expect("valid").blocks.remove(1).procedure
}

#[test]
fn adaptive_cells_are_interleaved_in_rounds_or_run_one_after_the_other() {
    let mut block = block(3, 1, 1, 1);
    block.procedure = quest_plus(10);
    let cells = |block: &BlockPlan| run(block, 4, |shown| shown % 5 == 2).iter().map(|p| p.cell).collect::<Vec<_>>();
    let interleaved = cells(&block);
    assert_eq!(interleaved.len(), 30);
    assert!(interleaved.chunks(3).all(|round| (0..3).all(|cell| round.contains(&cell))), "{interleaved:?}");

    block.order.shuffled = false;
    block.order.groups = GroupOrder::Listed;
    let mut one_by_one = cells(&block);
    one_by_one.dedup();
    assert_eq!(one_by_one, [0, 1, 2]);
}

/// Where both orders are wanted, the two of a pair follow one another in each cell, though trials are interrupted.
#[test]
fn adaptive_trials_come_in_both_orders() {
    let mut block = block(2, 1, 1, 1);
    block.procedure = quest_plus(10);
    block.presentation_order = PresentationOrder::Both;
    for seed in 0..20 {
        let completed = run(&block, seed, |shown| shown % 4 == 1);
        for cell in 0..2 {
            let orders: Vec<_> = completed.iter().filter(|p| p.cell == cell).map(|p| p.order).collect();
            assert!(orders.chunks(2).all(|pair| pair[0] != pair[1]), "seed {seed}: {orders:?}");
        }
    }
}

mod assignments {
    use super::super::assignment::{Assignment, Earlier, next_assignment};
    use super::*;
    use crate::study::Plan;

    fn plan(extra: &str) -> Plan {
        parse(&STUDY.replace("\"blocks\": [", &format!("{extra}\n  \"blocks\": ["))).expect("valid")
    }

    const GROUPS: &str = r#""groups": [ { "name": "a", "blocks": ["practice", "main"] }, { "name": "b", "blocks": ["practice", "main"] } ],"#;

    /// Whoever comes, and whoever leaves early: groups never differ by more than one observer.
    #[test]
    fn groups_stay_balanced_over_the_sessions_that_are_there() {
        let plan = plan(GROUPS);
        let mut earlier = Vec::new();
        for person in 0..20 {
            let observer = format!("P{person:02}");
            let assignment = next_assignment(&plan, &observer, &earlier, false);
            assert_eq!(assignment.number, person);
            earlier.push(Earlier { observer, assignment, finished: person % 3 > 0 });
            let count = |name: &str| earlier.iter().filter(|e| e.assignment.group.as_deref() == Some(name)).count();
            assert!(count("a").abs_diff(count("b")) <= 1, "after {person}");
        }
        // Somebody who comes again keeps number and group.
        for known in &earlier {
            let again = next_assignment(&plan, &known.observer, &earlier, false);
            assert_eq!((again.number, &again.group), (known.assignment.number, &known.assignment.group));
        }
    }

    #[test]
    fn pilot_runs_count_for_nobody_else() {
        let plan = plan(GROUPS);
        let pilot = |name: &str| Earlier {
            observer: name.to_owned(),
            assignment: Assignment { number: 0, group: Some("a".to_owned()), sitting: 1, pilot: true },
            finished: true,
        };
        let earlier = [pilot("X1"), pilot("X2")];
        let first = next_assignment(&plan, "P01", &earlier, false);
        assert_eq!((first.number, first.group.as_deref()), (0, Some("a")));
    }

    #[test]
    fn sittings_follow_one_another_and_an_unfinished_one_comes_again() {
        let text = STUDY.replace("\"repetitions\": 4", "\"repetitions\": 6");
        let main = text.find("\"quest-plus\"").expect("there");
        let from = text[..main].rfind("\"procedure\"").expect("there");
        let text = format!(
            "{}\"procedure\": {{ \"kind\": \"constant\", \"levels\": {{ \"mar_deg\": [1] }}, \"repetitions\": 6 }} }} ],\n\
             \"sittings\": {{ \"count\": 3 }} }}",
            &text[..from]
        );
        let plan = parse(&text).expect("valid");
        let session = |sitting, finished| Earlier {
            observer: "P01".to_owned(),
            assignment: Assignment { sitting, ..Assignment::default() },
            finished,
        };
        let next = |earlier: &[Earlier]| next_assignment(&plan, "P01", earlier, false).sitting;
        assert_eq!(next(&[]), 1);
        assert_eq!(next(&[session(1, true)]), 2);
        assert_eq!(next(&[session(1, true), session(2, false)]), 2);
        let all = [session(1, true), session(2, true), session(3, true)];
        assert_eq!(next(&all), 4);
        assert!(plan.assigned(&next_assignment(&plan, "P01", &all, false)).is_err());
    }
}
