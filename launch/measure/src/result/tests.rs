use super::RunResult;
use super::stay::StayResult;
use schemars::generate::SchemaSettings;
use serde_json::Value;
use std::path::Path;

/// Real results: a lockstep run and trials in real time.
const RESULTS: [&str; 2] = [
    include_str!("../../tests/data/result_lockstep.json"),
    include_str!("../../tests/data/result_trials.json"),
];

/// That of a stack that stayed up.
const STAY: &str = include_str!("../../tests/data/result_up.json");

/// What `result.json` holds.
#[derive(serde::Serialize, schemars::JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "its schema is what is needed")]
enum ResultFile {
    /// Of `zeronav run`.
    Run(Box<RunResult>),
    /// Of `zeronav up`.
    Stay(Box<StayResult>),
}

fn schema_file() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../result.schema.json")
}

fn schema() -> Value {
    let text = std::fs::read_to_string(schema_file()).expect("the schema");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn the_schema_is_that_of_the_types() {
    let generator = SchemaSettings::draft2020_12().for_serialize();
    let generated = generator
        .into_generator()
        .into_root_schema_for::<ResultFile>();
    let generated = serde_json::to_string_pretty(&generated).expect("JSON") + "\n";
    let stored = std::fs::read_to_string(schema_file()).unwrap_or_default();
    if generated == stored {
        return;
    }
    let made = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/result.schema.json");
    std::fs::write(&made, generated).expect("written");
    panic!(
        "the types of a result have changed: compare {} with {} and copy it",
        made.display(),
        schema_file().display()
    );
}

#[test]
fn a_real_result_is_read_and_written_back_unchanged() {
    for text in RESULTS {
        let result: RunResult = serde_json::from_str(text).expect("a result");
        let again = serde_json::to_string_pretty(&result).expect("JSON") + "\n";
        assert!(
            again == text,
            "{}: written back differently",
            result.scenario
        );
    }
}

/// What the schema has against a result; nothing when it is valid.
fn problems(result: &Value) -> Option<String> {
    const SCHEMA: &str = "result.schema.json";
    let mut schemas = boon::Schemas::new();
    let mut compiler = boon::Compiler::new();
    compiler.add_resource(SCHEMA, schema()).expect("a resource");
    let of = compiler.compile(SCHEMA, &mut schemas).expect("a schema");
    let problems = schemas.validate(result, of);
    problems.err().map(|problem| problem.to_string())
}

#[test]
fn a_real_result_is_valid_and_a_changed_one_is_not() {
    let texts = RESULTS.map(|text| (text, "verdict"));
    for (text, needed) in texts.into_iter().chain([(STAY, "contacts")]) {
        let mut result: Value = serde_json::from_str(text).expect("JSON");
        assert_eq!(problems(&result), None);
        result["time_s"] = "12".into();
        assert!(problems(&result).is_some(), "a time that is text");
        result["time_s"] = 12.into();
        assert_eq!(problems(&result), None);
        let fields = result.as_object_mut().expect("an object");
        fields.remove(needed);
        assert!(problems(&result).is_some(), "no {needed}");
    }
}
