//! `nsrm calibrate`: what it judges, finds, writes and refuses.
#![cfg(feature = "command")]

mod common;

use std::process::Output;

use common::{Bench, done, refused};
use nsrm_codegen::with_confidence;
use serde_json::{Value, json};

const SENTENCE: &str = "put the red block on the blue block";

/// A line of the file: this sentence in the bench's scene.
fn case(sentence: &str, steps: &Value) -> String {
    json!({"scene": "scene.json", "sentence": sentence, "steps": steps}).to_string() + "\n"
}

/// What the sentence means in the bench's scene.
fn meant() -> Value {
    json!([{"action": "MoveOn", "object_id": 1, "reference_id": 3}])
}

fn calibrate(bench: &Bench, cases: &str, options: &[&str]) -> Output {
    std::fs::create_dir_all(bench.path("own")).expect("a folder");
    bench.write(
        "own/cases.jsonl",
        cases.replace("scene.json", "../scene.json"),
    );
    let arguments = [
        "calibrate",
        "own/cases.jsonl",
        "--model",
        "model.safetensors",
    ];
    bench.run(&[&arguments, options].concat())
}

#[test]
fn finds_the_confidence_and_writes_it_into_the_model() {
    let bench = Bench::new();
    let cases = case(SENTENCE, &meant()).repeat(55)
        + &case("put the green block on the blue block", &Value::Null)
        + "\n";
    let options = ["--risk", "0.1", "--out", "calibrated.safetensors"];
    let text = done(&calibrate(&bench, &cases, &options));
    assert!(text.starts_with("56 sentences, 55 planned\n"), "{text}");
    let last = "least confidence 0: of the accepted commands, at most 10 % are wrong, with a \
                probability of 95 %\n";
    assert!(text.ends_with(last), "{text}");
    let report = done(&calibrate(&bench, &cases, &["--risk", "0.1", "--json"]));
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["sentences"], 56);
    let found = &report["found"];
    assert_eq!(
        (&found["accepted"], &found["wrong"]),
        (&json!(55), &json!(0))
    );
    assert!(
        found["bound"].as_f64().is_some_and(|bound| bound <= 0.1),
        "{found}"
    );
    assert_eq!(report["thresholds"].as_array().map(Vec::len), Some(10));
    let info = done(&bench.run(&["info", "calibrated.safetensors", "--json"]));
    let info: Value = serde_json::from_str(&info).expect("JSON");
    assert_eq!(info["thresholds"]["confidence"], 0.0);
}

#[test]
fn a_plan_below_the_confidence_is_refused_and_still_judged() {
    let bench = Bench::new();
    let bytes = std::fs::read(bench.path("model.safetensors")).expect("a model");
    bench.write(
        "model.safetensors",
        with_confidence(&bytes, 1.0).expect("a model"),
    );
    let output = bench.plan(SENTENCE, &["--json"]);
    let json = refused(&output, &["not sure enough of the plan", "needed 1.0000"]);
    assert_eq!(json["refused"]["kind"], "low_confidence");
    assert_eq!(json["refused"]["threshold"], 1.0);
    let cases = case(SENTENCE, &meant()).repeat(55);
    let text = done(&calibrate(&bench, &cases, &["--risk", "0.1"]));
    assert!(text.starts_with("55 sentences, 55 planned\n"), "{text}");
}

#[test]
fn wrong_commands_and_too_few_are_told() {
    let bench = Bench::new();
    let few = case(SENTENCE, &meant()).repeat(50);
    let output = calibrate(&bench, &few, &["--risk", "0.1"]);
    refused(
        &output,
        &[
            "50 accepted plans are too few",
            "at least 51",
            "set a greater limit",
        ],
    );
    // Another reference than the planned one; another action; a sentence to be refused.
    let other = json!([{"action": "MoveOn", "object_id": 1, "reference_id": 2}]);
    let left = json!([{"action": "MoveLeft", "object_id": 1, "reference_id": 3}]);
    for steps in [other, left, json!([]), Value::Null] {
        let cases = few.clone() + &case(SENTENCE, &steps).repeat(60);
        let output = calibrate(&bench, &cases, &["--risk", "0.1"]);
        refused(
            &output,
            &["no threshold keeps the limit", "60 of 110 plans are wrong"],
        );
        let table = String::from_utf8_lossy(&output.stdout);
        assert_eq!(table.lines().count(), 11, "{table}");
    }
}

#[test]
fn bad_cases_are_told_with_their_line() {
    let bench = Bench::new();
    let good = case(SENTENCE, &meant());
    let of = |action: &str, object: u32| json!([{"action": action, "object_id": object, "reference_id": 3}]);
    for (line, parts) in [
        ("{}\n".to_owned(), vec!["missing field `scene` (column 2)"]),
        ("put it there\n".to_owned(), vec!["\"steps\": LIST or null"]),
        (
            json!({"scene": "scene.json", "sentence": SENTENCE}).to_string(),
            vec!["missing field `steps`"],
        ),
        (
            case(SENTENCE, &of("Throw", 1)),
            vec!["unknown action \"Throw\"", "MoveOn, MoveRight"],
        ),
        (
            case(SENTENCE, &of("MoveOn", 9)),
            vec!["the scene has no object 9"],
        ),
        (
            case(SENTENCE, &meant()).replace("scene.json", "nowhere.json"),
            vec!["nowhere.json", "cannot read it"],
        ),
    ] {
        let output = calibrate(&bench, &(good.clone() + &line), &[]);
        refused(&output, &[&["own/cases.jsonl:2: "], &parts[..]].concat());
    }
    let missing = bench.run(&["calibrate", "missing.jsonl"]);
    refused(&missing, &["missing.jsonl: "]);
    let output = calibrate(&bench, &good, &["--level", "2"]);
    refused(&output, &["got a limit of 0.001 and a level of 2"]);
    let alone = bench.run(&["calibrate", "cases.jsonl", "--out", "new.safetensors"]);
    assert_eq!(alone.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&alone.stderr).contains("--model <FILE>"));
}
