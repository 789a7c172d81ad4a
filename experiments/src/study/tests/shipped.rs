//! The files that ship: studies that parse, schemas that are what the types say.

use super::catalogue;
use crate::study::draft::StudyDraft;
use crate::study::plan::ProcedurePlan;
use crate::study::{describe, display_schema, frames_schema, shipped, study_schema};
use std::path::PathBuf;

/// Set this to write the schema files anew: `UPDATE_SCHEMA=1 cargo test -p experiments schema`.
const UPDATE: &str = "UPDATE_SCHEMA";

fn studies() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("studies")
}

#[test]
fn the_committed_schemas_are_the_generated_ones() {
    let schemas = [
        ("study.schema.json", study_schema()),
        ("display.schema.json", display_schema()),
        ("frames.schema.json", frames_schema()),
    ];
    for (file, schema) in schemas {
        let path = studies().join(file);
        let generated = serde_json::to_string_pretty(&schema).expect("a schema") + "\n";
        if std::env::var_os(UPDATE).is_some() {
            std::fs::write(&path, &generated).expect("the studies folder is writable");
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            committed == generated,
            "{} is not what the types say; run {UPDATE}=1 cargo test -p experiments schema",
            path.display()
        );
    }
}

#[test]
fn the_schemas_are_schemas_and_accept_what_ships() {
    assert!(jsonschema::meta::is_valid(&study_schema()));
    assert!(jsonschema::meta::is_valid(&display_schema()));
    assert!(jsonschema::meta::is_valid(&frames_schema()));
    let validator = jsonschema::validator_for(&study_schema()).expect("a schema");
    for study in shipped() {
        let value = serde_json::from_str(study.json).expect("JSON");
        let errors: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{}: {errors:?}", study.name);
    }
}

#[test]
fn every_file_of_the_folder_ships_under_its_name() {
    for study in shipped() {
        let file = studies().join(format!("{}.json", study.name));
        assert_eq!(std::fs::read_to_string(file).expect("the file is named after the study"), study.json);
        let draft: StudyDraft = serde_json::from_str(study.json).expect("a study");
        assert_eq!(draft.name.as_deref(), Some(study.name));
        assert!(!study.about.is_empty() && draft.about.is_some_and(|about| !about.is_empty()));
    }
    let files = std::fs::read_dir(studies()).expect("the folder").filter_map(Result::ok);
    // What is in folders is there to start from and is not compiled in.
    let is_study = |name: &str| name.ends_with(".json") && !name.ends_with(".schema.json");
    let count = files.filter(|f| is_study(&f.file_name().to_string_lossy())).count();
    assert_eq!(count, shipped().len());
}

/// A typical observer (omega0 1/48°, m 0.022) must find their thresholds among the levels, with room above and, where the
/// display allows, below.
#[test]
fn the_calibrations_ask_around_a_typical_threshold() {
    for study in shipped().iter().filter(|study| study.name.starts_with("mar-")) {
        let plan = crate::study::parse_study(study.name, study.json, &catalogue(), None).expect("parses");
        let main = plan.blocks.iter().find(|block| !block.practice).expect("a main block");
        let ProcedurePlan::QuestPlus(quest) = &main.procedure else { panic!("QUEST+") };
        for row in describe(&plan).blocks.iter().filter(|b| !b.practice).flat_map(|b| &b.eccentricities) {
            let threshold = 0.022 * row.eccentricity_deg + 1.0 / 48.0;
            let at_e = || quest.levels.iter().filter(|l| (l["eccentricity_deg"] - row.eccentricity_deg).abs() < 1e-9);
            assert!(at_e().any(|l| l["mar_deg"] > 2.0 * threshold), "{} at {}", study.name, row.eccentricity_deg);
            assert!(at_e().any(|l| l["mar_deg"] < 1.01 * threshold), "{} at {}", study.name, row.eccentricity_deg);
            assert!(row.visible_share > 0.4, "{} at {}", study.name, row.eccentricity_deg);
        }
    }
}
