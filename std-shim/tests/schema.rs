//! `docs/schema/parse.schema.json` describes what `nsrm parse --json` prints.

use std::collections::BTreeSet;
use std::path::Path;

use boon::{Compiler, SchemaIndex, Schemas};
use nsrm::dialogue::Question;
use nsrm::json;
use nsrm_core::model::Model;
use nsrm_core::{MAX_CORRECTIONS, MAX_FILTERS, MAX_SENTENCE_BYTES, MAX_STEPS, MAX_TOKENS, Planner};
use nsrm_tests::by_hand::Parts;
use serde_json::{Value, json};

fn schema() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/schema/parse.schema.json");
    let text = std::fs::read_to_string(path).expect("the schema");
    serde_json::from_str(&text).expect("JSON")
}

struct Validator {
    schemas: Schemas,
    root: SchemaIndex,
}

impl Validator {
    fn new() -> Self {
        let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
        let name = "parse.schema.json";
        compiler.add_resource(name, schema()).expect("a schema");
        let root = compiler.compile(name, &mut schemas).expect("a schema");
        Self { schemas, root }
    }

    fn is_valid(&self, value: &Value) -> bool {
        self.schemas.validate(value, self.root).is_ok()
    }

    #[track_caller]
    fn check(&self, value: &Value) {
        if let Err(error) = self.schemas.validate(value, self.root) {
            panic!("{value}: {error:#}");
        }
    }
}

/// What the command prints; see `main.rs`.
fn printed(model: &Model<'_>, sentence: &str) -> Value {
    match Planner::new(model).parse(sentence) {
        Ok(parsed) => json::parsed(model, &parsed, sentence),
        Err(refusal) => {
            let mut value = json::refusal(model, &refusal, sentence);
            if let Some(question) = Question::after(model, None, &refusal, sentence) {
                value["refused"]["question"] = json::question(&question);
            }
            value
        }
    }
}

const GOOD: &str = "put the small red block on the blue block";

#[test]
fn programs_and_refusals_are_as_the_schema_says() {
    let validator = Validator::new();
    let mut kinds = BTreeSet::new();
    let mut check = |spoil: fn(&mut Parts), sentence: &str| {
        let mut parts = Parts::new();
        spoil(&mut parts);
        let value = printed(&parts.model(), sentence);
        validator.check(&value);
        let kind = value["refused"]["kind"].as_str().unwrap_or("none");
        kinds.insert(kind.to_owned());
        value
    };
    let sound: fn(&mut Parts) = |_| {};
    for sentence in [
        GOOD,
        "put the red block behind the blue block behind the lego block on the green block",
        " .",
        "put the crimson block on the blue block",
        "put the small rde block on the blue block",
        "put the red red red red red block on the blue block",
        "put the small red block on the blue small green block",
        "put the red and small block on the blue block",
        "put the red behind the red behind the red behind the red on the blue block",
        "put the small red block on the block",
        "put the small red block on it the blue block",
        "put the small red block sideways on the blue block",
        "put the small red block and the blue block",
        "put the red block on the blue block then put this on the red block",
        "put the red block on both blue block",
    ] {
        check(sound, sentence);
    }
    let related = check(sound, "put opposite the red block on the small blue block");
    assert_eq!(
        related["steps"][0],
        json!({
            "action": "MoveOn",
            "object": {"concepts": [], "relation": {"name": "MoveBeside", "to": ["red"]}},
            "reference": ["small", "blue"],
        })
    );
    let farthest = check(
        sound,
        "put the small furthest the red block on the blue block",
    );
    assert_eq!(
        farthest["steps"][0]["object"],
        json!({"concepts": ["small"], "relation": {"name": "Farthest", "to": ["red"]}})
    );
    let sentence = "put the outermost block on the outermost blue behind the red outermost block";
    let extreme = check(sound, sentence);
    let to = json!({"concepts": ["red"], "which": "outermost"});
    assert_eq!(
        extreme["steps"][0],
        json!({
            "action": "MoveOn",
            "object": {"concepts": [], "which": "outermost"},
            "reference": {
                "concepts": ["blue"],
                "which": "outermost",
                "relation": {"name": "MoveBeside", "to": to},
            },
        })
    );
    let several = check(sound, "put both red block on the small blue block");
    assert_eq!(
        several["steps"][0]["object"],
        json!({"concepts": ["red"], "which": "both"})
    );
    check(sound, &"x".repeat(MAX_SENTENCE_BYTES + 1));
    check(sound, &"the ".repeat(MAX_TOKENS + 1));
    check(sound, &(format!("{GOOD} then ").repeat(MAX_STEPS) + GOOD));
    check(|parts| parts.hazard.bias = [f32::NAN], GOOD);
    check(|parts| parts.actions[1].relation_bias[0] = f32::NAN, GOOD);
    assert_eq!(
        kinds.iter().map(String::as_str).collect::<Vec<_>>(),
        [
            "conflicting_values",
            "incomplete_step",
            "no_words",
            "none",
            "not_finite",
            "same_reference",
            "sentence_too_long",
            "several_references",
            "too_many_concepts",
            "too_many_references",
            "too_many_relations",
            "too_many_steps",
            "unclear_pronoun",
            "unclear_words",
            "unknown_word",
            "unsure",
        ]
    );
}

#[test]
fn what_the_built_in_model_understands_is_as_the_schema_says() {
    let validator = Validator::new();
    for (sentence, argument, expected) in [
        (
            "slide the red block 5 cm to the left",
            "reference",
            json!({"concepts": [], "which": "itself"}),
        ),
        (
            "put the red block between the blue and the green one",
            "reference",
            json!({"concepts": ["blue"], "relation": {"name": "And", "to": ["green"]}}),
        ),
        (
            "put the red block between the two small ones",
            "reference",
            json!({"concepts": ["small"], "which": "both"}),
        ),
        (
            "stack all the small blocks",
            "reference",
            json!({"concepts": [], "which": "itself"}),
        ),
        (
            "put the red block on the table",
            "reference",
            json!({"concepts": [], "which": "table"}),
        ),
        (
            "put all the small blocks except the red one on the blue one",
            "object",
            json!({"concepts": ["small"], "which": "all", "except": ["red"]}),
        ),
        (
            "put the red block on the block that is not blue",
            "reference",
            json!({"concepts": [], "except": {"concepts": ["blue"], "which": "all"}}),
        ),
        (
            "put the second red block from the left on the blue one",
            "object",
            json!({"concepts": ["red"], "which": "second leftmost"}),
        ),
    ] {
        let value = printed(&nsrm_tabletop::TABLETOP, sentence);
        validator.check(&value);
        assert_eq!(value["steps"][0][argument], expected, "{sentence}");
    }
}

#[test]
fn corrections_and_errors_are_as_the_schema_says() {
    let validator = Validator::new();
    let sentence = "plase put the yelow block on the read one";
    let value = printed(&nsrm_tabletop::TABLETOP, sentence);
    assert_eq!(value["corrections"].as_array().map(Vec::len), Some(3));
    validator.check(&value);
    validator.check(&json::error("no such file"));
}

#[test]
fn what_is_never_printed_is_not_described() {
    let validator = Validator::new();
    let step = json!({"action": "MoveOn", "object": ["red"], "reference": ["blue"]});
    let with = |change: fn(&mut Value)| {
        let mut step = step.clone();
        change(&mut step);
        json!({"steps": [step], "corrections": []})
    };
    assert!(validator.is_valid(&with(|_| {})));
    for wrong in [
        with(|step| step["object"] = json!([])),
        with(|step| step["object"] = json!({"concepts": ["red"]})),
        with(|step| step["more"] = json!(1)),
        json!({"steps": [], "corrections": []}),
        json!({"refused": {"kind": "no_words"}}),
        json!({"refused": {"kind": "no_words", "message": "no", "step": 1}}),
        json!({"refused": {"kind": "unheard_of", "message": "no"}}),
        json!({"refused": {"kind": "too_many_steps", "message": "no"}}),
    ] {
        assert!(!validator.is_valid(&wrong), "{wrong}");
    }
    // Capacities stand in it.
    let schema = schema();
    let parsed = &schema["$defs"]["parsed"]["properties"];
    assert_eq!(parsed["steps"]["maxItems"], MAX_STEPS);
    assert_eq!(parsed["corrections"]["maxItems"], MAX_CORRECTIONS);
    assert_eq!(schema["$defs"]["concepts"]["maxItems"], MAX_FILTERS);
    let end = &schema["$defs"]["words"]["properties"]["end"];
    assert_eq!(end["maximum"], MAX_SENTENCE_BYTES);
}
