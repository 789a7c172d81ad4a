//! The rules of Psych-DS 1.5.0, as far as they concern what we write: names of files, headers, rows, and that data and metadata
//! name the same variables.

use crate::error::LabError;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Everything in the data set at `root` that breaks a rule.
///
/// # Errors
/// When a folder or file cannot be read.
pub fn problems(root: &Path) -> Result<Vec<String>, LabError> {
    let mut problems = Vec::new();
    let variables = description(root, &mut problems)?;
    let files = data_files(&root.join("data"))?;
    if files.is_empty() {
        problems.push("data/ has no data file".to_owned());
    }
    let mut columns = BTreeSet::new();
    for file in files {
        let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        if !is_data_name(&name) {
            problems.push(format!("{name}: no name of a data file"));
        }
        columns.extend(table(&file, &name, &mut problems)?);
    }
    problems.extend(columns.difference(&variables).map(|name| format!("variableMeasured lacks the column {name}")));
    problems.extend(variables.difference(&columns).map(|name| format!("no file has the variable {name}")));
    Ok(problems)
}

/// Whether a name is `key-value_key-value…_data.csv`, keys of small letters and values of letters and digits.
#[must_use]
pub fn is_data_name(name: &str) -> bool {
    let Some(keywords) = name.strip_suffix("_data.csv") else { return false };
    keywords.split('_').all(|keyword| {
        keyword.split_once('-').is_some_and(|(key, value)| {
            !key.is_empty()
                && key.bytes().all(|byte| byte.is_ascii_lowercase())
                && !value.is_empty()
                && value.bytes().all(|byte| byte.is_ascii_alphanumeric())
        })
    })
}

/// The names of `variableMeasured`.
fn description(root: &Path, problems: &mut Vec<String>) -> Result<BTreeSet<String>, LabError> {
    let path = root.join("dataset_description.json");
    if !path.exists() {
        problems.push("dataset_description.json is missing".to_owned());
        return Ok(BTreeSet::new());
    }
    let bytes = fs::read(&path).map_err(|error| LabError::io("read", &path, &error))?;
    let Ok(json) = serde_json::from_slice::<Value>(&bytes) else {
        problems.push("dataset_description.json is no JSON".to_owned());
        return Ok(BTreeSet::new());
    };
    for key in ["name", "description"] {
        if json[key].as_str().is_none_or(str::is_empty) {
            problems.push(format!("dataset_description.json lacks {key}"));
        }
    }
    if json["@type"] != "Dataset" {
        problems.push("dataset_description.json is not of @type Dataset".to_owned());
    }
    if json["@context"].as_str().is_none_or(|context| context.trim_end_matches('/') != "https://schema.org") {
        problems.push("dataset_description.json has not the @context of schema.org".to_owned());
    }
    let Some(list) = json["variableMeasured"].as_array() else {
        problems.push("dataset_description.json lacks variableMeasured".to_owned());
        return Ok(BTreeSet::new());
    };
    let mut names = BTreeSet::new();
    for variable in list {
        match variable.as_str().or_else(|| variable["name"].as_str()) {
            Some(name) if names.insert(name.to_owned()) => {}
            Some(name) => problems.push(format!("variableMeasured has {name} twice")),
            None => problems.push("variableMeasured has an entry without a name".to_owned()),
        }
    }
    Ok(names)
}

/// Every CSV file below a folder; none where there is no folder.
fn data_files(folder: &Path) -> Result<Vec<PathBuf>, LabError> {
    let mut files = Vec::new();
    let mut left = if folder.is_dir() { vec![folder.to_owned()] } else { Vec::new() };
    while let Some(folder) = left.pop() {
        let entries = fs::read_dir(&folder).map_err(|error| LabError::io("read", &folder, &error))?;
        for entry in entries {
            let path = entry.map_err(|error| LabError::io("read", &folder, &error))?.path();
            if path.is_dir() {
                left.push(path);
            } else if path.extension().is_some_and(|extension| extension == "csv") {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// The columns of a file; checks its header and rows.
fn table(path: &Path, name: &str, problems: &mut Vec<String>) -> Result<BTreeSet<String>, LabError> {
    let file = fs::File::open(path).map_err(|error| LabError::io("read", path, &error))?;
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(file);
    let mut record = csv::StringRecord::new();
    let mut header: Vec<String> = Vec::new();
    let (mut row_id, mut last_id) = (None, None);
    let mut row = 0_usize;
    loop {
        match reader.read_record(&mut record) {
            Ok(false) => break,
            Err(error) => {
                problems.push(format!("{name}: {error}"));
                break;
            }
            Ok(true) if header.is_empty() => {
                header = record.iter().map(str::to_owned).collect();
                row_id = header.iter().position(|column| column == "row_id");
                let unique: BTreeSet<&String> = header.iter().collect();
                if unique.len() < header.len() {
                    problems.push(format!("{name}: a column's name is there twice"));
                }
                if header.iter().any(String::is_empty) {
                    problems.push(format!("{name}: a column has no name"));
                }
            }
            Ok(true) => {
                row += 1;
                if record.len() != header.len() {
                    problems.push(format!("{name}: row {row} has {} cells, the header {}", record.len(), header.len()));
                }
                // Our numbers rise, so that none is there twice, and nothing need be remembered of a long file.
                let id = row_id.and_then(|column| record.get(column)).map(|id| id.parse::<u64>().ok());
                if id.is_some_and(|id| id <= last_id) {
                    problems.push(format!("{name}: row_id of row {row} is not above the one before"));
                }
                last_id = id.flatten().max(last_id);
            }
        }
    }
    if header.is_empty() {
        problems.push(format!("{name}: no header"));
    }
    Ok(header.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// The examples of the standard's own page on data files, good and bad.
    #[test]
    fn names_of_data_files() {
        for good in ["subject-XYZ_session-2_data.csv", "study-ExampleStudy_data.csv", "study-A_condition-2_data.csv"] {
            assert!(is_data_name(good), "{good}");
        }
        for bad in [
            "data.csv",
            "subject-XYZ_data2.csv",
            "condition1-A_condition2-C_data.csv",
            "subject-XYZ.csv",
            "subject-X-Y_data.csv",
            "Subject-X_data.csv",
            "_data.csv",
        ] {
            assert!(!is_data_name(bad), "{bad}");
        }
    }

    fn said(file: &str, rows: &str, description: &Value) -> Vec<String> {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("data")).expect("made");
        fs::write(folder.path().join("data").join(file), rows).expect("written");
        fs::write(folder.path().join("dataset_description.json"), description.to_string()).expect("written");
        problems(folder.path()).expect("read")
    }

    #[test]
    fn every_rule_is_held() {
        let good = json!({ "@context": "https://schema.org", "@type": "Dataset", "name": "n", "description": "d",
            "variableMeasured": [{ "@type": "PropertyValue", "name": "row_id" }, "a"] });
        let without = |key: &str| {
            let mut value = good.clone();
            value.as_object_mut().expect("an object").remove(key);
            value
        };
        assert_eq!(said("study-x_data.csv", "row_id,a\n1,2\n2,2\n", &good), Vec::<String>::new());
        for (file, rows, description, expected) in [
            ("x.csv", "row_id,a\n", good.clone(), "no name of a data file"),
            ("study-x_data.csv", "row_id,a\n1,2\n1,3\n", good.clone(), "row_id of row 2"),
            ("study-x_data.csv", "row_id,a\n1,2,3\n", good.clone(), "row 1 has 3 cells"),
            ("study-x_data.csv", "row_id,a,a\n1,2,3\n", good.clone(), "twice"),
            ("study-x_data.csv", "row_id,a,b\n1,2,3\n", good.clone(), "lacks the column b"),
            ("study-x_data.csv", "row_id\n1\n", good.clone(), "no file has the variable a"),
            ("study-x_data.csv", "", good.clone(), "no header"),
            ("study-x_data.csv", "row_id,a\n", without("name"), "lacks name"),
            ("study-x_data.csv", "row_id,a\n", without("description"), "lacks description"),
            ("study-x_data.csv", "row_id,a\n", without("@type"), "@type"),
            ("study-x_data.csv", "row_id,a\n", without("@context"), "@context"),
            ("study-x_data.csv", "row_id,a\n", without("variableMeasured"), "lacks variableMeasured"),
        ] {
            let problems = said(file, rows, &description);
            assert!(problems.iter().any(|problem| problem.contains(expected)), "{expected}: {problems:?}");
        }
    }
}
