//! A description of a model, as text or as JSON: domain, dimensions, memory and metrics.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use nsrm_codegen::{hexadecimal, memory_report};
use nsrm_core::dsl::{Extreme, Property, RelationKind};
use nsrm_core::model::{self, CompoundKind, LOCATION, Model};
use nsrm_core::planner::{MAX_POLLS, PLAN_BYTES, SCENE_BYTES, TASK_BYTES, UNIT_MULTIPLY_ADDS};
use nsrm_core::{
    Camera, MAX_CORRECTIONS, MAX_FILTERS, MAX_GROUPS, MAX_OBJECTS, MAX_READINGS, MAX_RELATIONS,
    MAX_SENTENCE_BYTES, MAX_SPLITS, MAX_STEP_TOKENS, MAX_STEPS, MAX_TOKENS,
};
use serde_json::{Value, json};

use crate::json::{decimal, decimals};
use crate::models::AnyModel;

/// The architecture's dimensions by name.
const DIMENSIONS: [(&str, usize); 12] = [
    ("word", model::WORD),
    ("encoder_hidden", model::ENCODER_HIDDEN),
    ("splitter_word", model::SPLITTER_WORD),
    ("splitter_hidden", model::SPLITTER_HIDDEN),
    ("crop", model::CROP),
    ("patch_channels", model::PATCH_CHANNELS),
    ("merge_channels", model::MERGE_CHANNELS),
    ("view_embedding", model::VIEW_EMBEDDING),
    ("operator_hidden", model::OPERATOR_HIDDEN),
    ("concept", model::CONCEPT),
    ("simulator_hidden", model::SIMULATOR_HIDDEN),
    ("location", LOCATION),
];

/// The capacities by name.
const CAPACITIES: [(&str, usize); 11] = [
    ("objects", MAX_OBJECTS),
    ("steps", MAX_STEPS),
    ("tokens", MAX_TOKENS),
    ("tokens_a_step", MAX_STEP_TOKENS),
    ("sentence_bytes", MAX_SENTENCE_BYTES),
    ("corrections", MAX_CORRECTIONS),
    ("readings", MAX_READINGS),
    ("splits", MAX_SPLITS),
    ("concepts_a_description", MAX_FILTERS),
    ("relations_a_description", MAX_RELATIONS),
    ("groups_a_step", MAX_GROUPS),
];

/// Sizes and work bounds that are constants of the build, by name.
const BOUNDS: [(&str, usize); 5] = [
    ("scratch_bytes", TASK_BYTES),
    ("plan_bytes", PLAN_BYTES),
    ("scene_bytes", SCENE_BYTES),
    ("polls", MAX_POLLS),
    ("multiply_adds_a_poll", UNIT_MULTIPLY_ADDS),
];

/// Domain, dimensions, capacities, sizes, thresholds, training and metrics.
pub fn info_json(any: &AnyModel) -> Value {
    let model = any.model();
    let header = &model.header;
    let report = memory_report(&model);
    let arrays = report
        .arrays
        .iter()
        .map(|array| json!({"path": array.path, "count": array.count, "bytes": array.bytes}));
    let about = any.about();
    json!({
        "schema": model::SCHEMA,
        "domain": header.domain,
        "identity": hexadecimal(&header.identity),
        "precision": model.embeddings.precision().name(),
        "attributes": attributes(&model),
        "actions": model.actions.iter().map(|action| action.name).collect::<Vec<_>>(),
        "compounds": compounds(&model),
        "relations": relations(&model),
        "extremes": extremes(&model),
        "ordinals": ordinals(&model),
        "words": model.words.iter().map(|word| word.text).collect::<Vec<_>>(),
        "pronouns": pronouns(&model),
        "arrangements": arrangements(&model),
        "lexicon": model.lexicon.iter().map(|entry| entry.text).collect::<Vec<_>>(),
        "dimensions": object(&DIMENSIONS),
        "capacities": object(&CAPACITIES),
        "thresholds": {
            "match_score": decimal(header.thresholds.match_score),
            "decision": decimal(header.thresholds.decision),
            "confidence": decimal(header.thresholds.confidence),
        },
        "work_space": {
            "min": decimals(&header.work_space.min),
            "max": decimals(&header.work_space.max),
        },
        "placed_orientation": decimals(&header.placed_orientation),
        "training_camera": camera(&header.training_camera),
        "bounds": object(&BOUNDS),
        "flash": {
            "arrays": arrays.collect::<Vec<_>>(),
            "texts": report.texts,
            "tables": report.tables,
            "total": report.total(),
        },
        "training": about["training"],
        "metrics": about["metrics"],
    })
}

/// Actions that are made of others, with all that means them.
fn compounds(model: &Model<'_>) -> Vec<Value> {
    let made = (0_u8..).zip(model.compounds.compounds);
    made.map(|(index, compound)| {
        let parts = compound.parts.iter();
        let parts = parts.filter_map(|part| model.action_name(*part));
        let said = model.compounds.said.iter();
        let said = said.filter(|said| said.compound == index);
        json!({
            "name": compound.name,
            "is": match compound.kind {
                CompoundKind::All => "all",
                CompoundKind::Between => "between",
                _ => "any",
            },
            "of": parts.collect::<Vec<_>>(),
            "said": said.map(|said| said.text).collect::<Vec<_>>(),
        })
    })
    .collect()
}

/// What can be counted from the extremes.
fn ordinals(model: &Model<'_>) -> Vec<Value> {
    let ranked = model.ordinals.ranked.iter();
    ranked
        .map(|ranked| {
            json!({
                "name": ranked.name,
                "extreme": ranked.extreme.name(model),
                "rank": ranked.rank,
            })
        })
        .collect()
}

fn camera(camera: &Camera) -> Value {
    json!({
        "width": camera.width,
        "height": camera.height,
        "fx": decimal(camera.fx),
        "fy": decimal(camera.fy),
        "cx": decimal(camera.cx),
        "cy": decimal(camera.cy),
        "position": decimals(&camera.position),
        "orientation": decimals(&camera.orientation),
    })
}

/// The relations that the model knows in descriptions: by the actions that bring them about, and
/// superlatives.
fn relations<'a>(model: &Model<'a>) -> Vec<&'a str> {
    let taught = model.actions.iter().filter(|action| action.is_relation());
    let mut names: Vec<&str> = taught.map(|action| action.name).collect();
    for (kind, rows) in [
        (RelationKind::Nearest, model.language.nearest),
        (RelationKind::Farthest, model.language.farthest),
    ] {
        if rows.is_relation() {
            names.push(kind.name(model));
        }
    }
    names
}

/// The extremes that descriptions may name: "leftmost", in the order of the actions, then by size.
fn extremes<'a>(model: &Model<'a>) -> Vec<&'a str> {
    let actions = (0..)
        .zip(model.actions)
        .map(|(index, _)| Extreme::Action(index));
    let every = actions.chain([Extreme::Largest, Extreme::Smallest]);
    every
        .filter(|extreme| {
            let property = Property::Extreme(*extreme);
            model.lexicon.iter().any(|entry| entry.property == property)
        })
        .map(|extreme| extreme.name(model))
        .collect()
}

/// The words that may stand for what the step before moved.
fn pronouns<'a>(model: &Model<'a>) -> Vec<&'a str> {
    let words = model
        .pronouns
        .iter()
        .filter_map(|pronoun| model.words.get(usize::from(pronoun.word)));
    words.map(|word| word.text).collect()
}

/// How towers and rows are said: the texts before and behind a list that go together.
fn arrangements(model: &Model<'_>) -> Vec<Value> {
    let said = model.arrangements;
    let patterns = said.closings.iter().map(|closing| closing.pattern);
    let patterns: BTreeSet<u8> = patterns.collect();
    let texts = |pattern| {
        let before = said
            .openings
            .iter()
            .filter(move |opening| opening.pattern == pattern);
        let behind = said
            .closings
            .iter()
            .filter(move |closing| closing.pattern == pattern);
        let before: Vec<&str> = before.map(|opening| opening.text).collect();
        let behind: Vec<&str> = behind.map(|closing| closing.text).collect();
        json!({"before": before, "behind": behind})
    };
    patterns.into_iter().map(texts).collect()
}

/// The same as text.
pub fn info_text(any: &AnyModel) -> String {
    let model = any.model();
    let header = &model.header;
    let about = any.about();
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<20} {value}");
    };
    line("domain", header.domain.into());
    line("identity", hexadecimal(&header.identity));
    line("schema", model::SCHEMA.to_string());
    line("weights", model.embeddings.precision().name().into());
    for attribute in model.attributes {
        let values = values(&model, attribute.name);
        line(attribute.name, values.join(", "));
    }
    let actions: Vec<&str> = model.actions.iter().map(|action| action.name).collect();
    line("actions", actions.join(", "));
    let made = model.compounds.compounds.iter().map(|made| made.name);
    let made: Vec<&str> = made.collect();
    let or_none = |names: Vec<&str>| match &*names {
        [] => "none".to_owned(),
        names => names.join(", "),
    };
    line("compounds", or_none(made));
    line("relations", or_none(relations(&model)));
    line("extremes", or_none(extremes(&model)));
    let ranked = model.ordinals.ranked.iter();
    line(
        "counted",
        or_none(ranked.map(|ranked| ranked.name).collect()),
    );
    line("pronouns", or_none(pronouns(&model)));
    let said = model.arrangements;
    let (before, behind) = (said.openings.len(), said.closings.len());
    line(
        "towers and rows",
        format!("{before} texts before a list, {behind} behind it; --json lists them"),
    );
    let words: Vec<&str> = model.words.iter().map(|word| word.text).collect();
    line("words", words.join(" "));
    line("dimensions", pairs(&DIMENSIONS));
    line("at most", pairs(&CAPACITIES));
    let thresholds = header.thresholds;
    line(
        "thresholds",
        format!(
            "match_score {}, decision {}, confidence {}",
            thresholds.match_score, thresholds.decision, thresholds.confidence
        ),
    );
    let space = header.work_space;
    line(
        "work space",
        format!("{:?} to {:?} m", space.min, space.max),
    );
    line("bounds", pairs(&BOUNDS));
    line("training", about["training"].to_string());
    line("metrics", about["metrics"].to_string());
    let _ = write!(text, "\nread-only memory\n{}", memory_report(&model));
    text
}

fn attributes(model: &Model<'_>) -> Value {
    model
        .attributes
        .iter()
        .map(|attribute| {
            let values = values(model, attribute.name);
            json!({"name": attribute.name, "values": values})
        })
        .collect()
}

fn values<'a>(model: &Model<'a>, attribute: &str) -> Vec<&'a str> {
    let index = model.attributes.iter().position(|a| a.name == attribute);
    let concepts = model.concepts.iter();
    concepts
        .filter(|concept| Some(usize::from(concept.attribute)) == index)
        .map(|concept| concept.name)
        .collect()
}

fn object(entries: &[(&str, usize)]) -> Value {
    let entries = entries.iter();
    Value::Object(
        entries
            .map(|&(name, value)| (name.to_owned(), value.into()))
            .collect(),
    )
}

fn pairs(entries: &[(&str, usize)]) -> String {
    let texts: Vec<String> = entries
        .iter()
        .map(|(name, value)| format!("{name} {value}"))
        .collect();
    texts.join(", ")
}
