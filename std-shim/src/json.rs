//! Programs, plans and refusals as JSON: what `nsrm --json` prints and what the
//! Python module's exceptions carry.
//!
//! Names are those of the domain file. Steps count from 0. Spans are bytes of the
//! sentence. Numbers have the shortest decimal notation of their `f32`.

use nsrm_core::calibration::Cause;
use nsrm_core::dsl::{Description, Filters, Step};
use nsrm_core::language::{Correction, Parsed, Span};
use nsrm_core::model::Model;
use nsrm_core::planner::{Confidence, Plan, PlannedStep};
use nsrm_core::refusal::{Candidate, Refusal};
use serde_json::{Map, Value, json};

use crate::dialogue::{Choice, Question};

/// `{"steps": [{"action": "MoveOn", "object": ["red"], "reference": ["blue"]}], "corrections": […]}`,
/// with a `distance_mm` of the steps that name one,
/// these as in [`corrections`], and descriptions as in [`description`].
pub fn parsed(model: &Model<'_>, parsed: &Parsed, sentence: &str) -> Value {
    let steps = parsed.program().steps().iter().map(|s| step(model, s));
    let steps: Vec<Value> = steps.collect();
    let corrections = corrections(model, parsed.corrections(), sentence);
    json!({"steps": steps, "corrections": corrections})
}

/// `[{"words": {"text": "yelow", "start": 8, "end": 13}, "read_as": "yellow"}]`: misspelt words, and
/// what they were read as.
pub fn corrections(model: &Model<'_>, corrections: &[Correction], sentence: &str) -> Value {
    corrections
        .iter()
        .map(|each| json!({"words": words(each.span(), sentence), "read_as": each.read_as(model)}))
        .collect()
}

/// The planned steps, each with `step` (its place in the program; a plan of the rest of a program
/// starts after 0), `object_id`, `reference_id`, `confidence` (all parts multiplied), `confidences`
/// (the parts), `sub_goal` (`position` in metres and `orientation` x, y, z, w, both in the world's
/// frame), `location` (predicted box and depth) and `explanation`; the program in the paper's
/// `notation`; the whole plan's `confidence`; and `corrections` as [`corrections`] gives them.
///
/// * `sentence`: the planned one
pub fn plan(model: &Model<'_>, plan: &Plan, sentence: &str) -> Value {
    let steps: Vec<Value> = plan
        .numbered()
        .map(|(number, understood, planned)| {
            let explanation = plan.explain_step(model, number).to_string();
            let mut object = planned_step(planned);
            if let Value::Object(names) = step(model, understood) {
                object.extend(names);
            }
            object.insert("step".into(), number.into());
            object.insert("explanation".into(), explanation.into());
            Value::Object(object)
        })
        .collect();
    let notation = plan.program().notation(model).to_string();
    let confidence = decimal(plan.confidence());
    let corrections = corrections(model, plan.corrections(), sentence);
    json!({
        "steps": steps,
        "notation": notation,
        "confidence": confidence,
        "corrections": corrections,
    })
}

/// `{"refused": {"kind": "ambiguous", "message": "…", …}}` with what
/// [`refusal_details`] gives.
pub fn refusal(model: &Model<'_>, refusal: &Refusal, sentence: &str) -> Value {
    let mut object = refusal_details(model, refusal, sentence);
    let message = refusal.in_context(model, sentence).to_string();
    object.insert("kind".into(), refusal.kind().into());
    object.insert("message".into(), message.into());
    json!({"refused": object})
}

/// `{"text": "which …?", "options": [{"answer": "the small one", "sentence": "…"}]}`: what is asked
/// back after a refusal, and the sentences that the answers lead to.
pub fn question(question: &Question) -> Value {
    let options = question.options().iter();
    let options: Vec<Value> = options
        .map(|Choice { answer, sentence }| json!({"answer": answer, "sentence": sentence}))
        .collect();
    json!({"text": question.to_string(), "options": options})
}

/// `{"error": {"message": "…"}}`, for input that could not be read.
pub fn error(message: &str) -> Value {
    json!({"error": {"message": message}})
}

/// The details of a refusal, by name, in words where possible.
pub fn refusal_details(model: &Model<'_>, refusal: &Refusal, sentence: &str) -> Map<String, Value> {
    let details = sentence_details(model, refusal, sentence)
        .or_else(|| step_details(refusal, sentence))
        .or_else(|| scene_details(model, refusal))
        .or_else(|| model_details(refusal));
    match details {
        Some(Value::Object(details)) => details,
        // A kind without details, or one whose details this version doesn't know.
        _ => Map::new(),
    }
}

/// The details where the words of the sentence are at fault, or their number.
fn sentence_details(model: &Model<'_>, refusal: &Refusal, sentence: &str) -> Option<Value> {
    Some(match refusal {
        Refusal::UnknownWord { span } => json!({
            "words": words(*span, sentence),
            "suggestion": refusal.suggestion(model, sentence),
        }),
        Refusal::SentenceTooLong { limit, unit } => json!({"limit": limit, "unit": unit.name()}),
        Refusal::ConflictingValues {
            span,
            first,
            second,
        } => {
            let (first, second) = (first.name(model), second.name(model));
            json!({"words": words(*span, sentence), "first": first, "second": second})
        }
        Refusal::TooManyConcepts { span, limit } => {
            json!({"words": words(*span, sentence), "limit": limit})
        }
        Refusal::TooManySteps { limit } => json!({"limit": limit}),
        _ => return None,
    })
}

/// The details where what one step says is at fault, or the parser is not sure of it.
fn step_details(refusal: &Refusal, sentence: &str) -> Option<Value> {
    Some(match refusal {
        Refusal::TooManyReferences { step, span, limit } => {
            json!({"step": step, "words": words(*span, sentence), "limit": limit})
        }
        Refusal::TooManyRelations { step, span, limit } => {
            json!({"step": step, "words": words(*span, sentence), "limit": limit})
        }
        Refusal::IncompleteStep {
            step,
            references,
            span,
        } => json!({"step": step, "words": words(*span, sentence), "references": references}),
        Refusal::SameReference { step, span }
        | Refusal::SeveralReferences { step, span }
        | Refusal::OnlyOnTable { step, span }
        | Refusal::UnclearPronoun { step, span } => {
            json!({"step": step, "words": words(*span, sentence)})
        }
        Refusal::UnclearWords {
            step,
            span,
            probability,
            threshold,
        } => json!({
            "step": step,
            "words": words(*span, sentence),
            "probability": decimal(*probability),
            "threshold": decimal(*threshold),
        }),
        Refusal::Unsure {
            step,
            decision,
            probability,
            threshold,
        } => json!({
            "step": step,
            "decision": decision.name(),
            "probability": decimal(*probability),
            "threshold": decimal(*threshold),
        }),
        Refusal::LowConfidence {
            confidence,
            threshold,
        } => json!({
            "confidence": decimal(*confidence),
            "threshold": decimal(*threshold),
        }),
        _ => return None,
    })
}

/// The details where objects of the scene are at fault, or where they would be moved.
fn scene_details(model: &Model<'_>, refusal: &Refusal) -> Option<Value> {
    Some(match refusal {
        Refusal::NoSuchObject {
            step,
            argument,
            description,
            best,
            threshold,
        } => json!({
            "step": step,
            "argument": argument.name(),
            "description": self::description(model, description),
            "best": best.as_ref().map(candidate),
            "threshold": decimal(*threshold),
        }),
        Refusal::OtherNumber {
            step,
            description,
            expected,
            got,
        } => json!({
            "step": step,
            "argument": "object",
            "description": self::description(model, description),
            "expected": expected,
            "got": got,
        }),
        Refusal::Ambiguous {
            step,
            argument,
            description,
            candidates,
        } => json!({
            "step": step,
            "argument": argument.name(),
            "description": self::description(model, description),
            "candidates": candidates.listed().iter().map(candidate).collect::<Vec<Value>>(),
            "count": candidates.count(),
        }),
        Refusal::SameObject { step, object }
        | Refusal::AlreadyOnTable { step, object }
        | Refusal::NoRoomOnTable { step, object }
        | Refusal::HiddenReference { step, object }
        | Refusal::NotOnTable { step, object } => {
            json!({"step": step, "object_id": object})
        }
        Refusal::OutsideTrainingView {
            step,
            argument,
            object,
        } => json!({"step": step, "argument": argument.name(), "object_id": object}),
        Refusal::OutsideWorkSpace {
            step,
            object,
            position,
            bounds,
        } => json!({
            "step": step,
            "object_id": object,
            "position": decimals(position),
            "bounds": {"min": decimals(&bounds.min), "max": decimals(&bounds.max)},
        }),
        Refusal::Calibration(fault) => json!({
            "object_id": fault.object,
            "quantity": fault.quantity.name(),
            "measured_m": decimal(fault.measured_m),
            "expected_m": decimal(fault.expected_m),
            "disagreeing": fault.disagreeing,
            "whole": fault.whole,
            "cause": fault.cause.map(Cause::name),
        }),
        _ => return None,
    })
}

/// The details where the model is at fault, or scene and program belong to another one.
fn model_details(refusal: &Refusal) -> Option<Value> {
    Some(match refusal {
        Refusal::NotFinite { step, quantity } => {
            json!({"step": step, "quantity": quantity.name()})
        }
        Refusal::OtherModel { expected, got } | Refusal::ParsedByOtherModel { expected, got } => {
            json!({
                "expected": format!("{expected:016x}"),
                "got": format!("{got:016x}"),
            })
        }
        _ => return None,
    })
}

/// A description: the names of its concepts, `["small", "red"]`; with an extreme or of several objects
/// `{"concepts": ["red"], "which": "leftmost"}`, where `which` may also be `second leftmost`, `all`, `both` and, in plans,
/// `each`; without some of them `{"concepts": [], "which": "all", "except": ["red"]}`; the table `{"concepts": [], "which": "table"}`, and in the same way the moved object, or each other one of several, `itself`; with relations
/// `{"concepts": ["red"], "relation": {"name": "MoveLeft", "to": ["yellow"]}}`, where `to` is a description again.
pub fn description(model: &Model<'_>, description: &Description) -> Value {
    let relations = description.relations();
    let innermost = relations.last().map(|relation| &relation.to);
    // From the innermost anchor outwards: what each relation belongs to stands before it.
    let except = |index| {
        if index == 0 {
            description.except()
        } else {
            None
        }
    };
    let own = innermost.unwrap_or(description.filters());
    let mut value = filtered(model, own, except(relations.len()), None);
    for (index, relation) in relations.iter().enumerate().rev() {
        let before = index
            .checked_sub(1)
            .and_then(|before| relations.get(before));
        let own = before.map_or(description.filters(), |before| &before.to);
        let name = relation.kind.name(model);
        let relation = Some(json!({"name": name, "to": value}));
        value = filtered(model, own, except(index), relation);
    }
    value
}

/// Filters, with what is left out, and the relation of what they describe.
fn filtered(
    model: &Model<'_>,
    filters: &Filters,
    except: Option<&Filters>,
    relation: Option<Value>,
) -> Value {
    let concepts = json!(names(model, filters));
    let which = filters.choice();
    if which.is_none() && except.is_none() && relation.is_none() {
        return concepts;
    }
    let mut value = json!({"concepts": concepts});
    if let Some(which) = which {
        value["which"] = json!(which.name(model));
    }
    if let Some(except) = except {
        value["except"] = filtered(model, except, None, None);
    }
    if let Some(relation) = relation {
        value["relation"] = relation;
    }
    value
}

/// The names of the concepts of filters, in the order of the sentence.
pub fn names<'a>(model: &Model<'a>, filters: &Filters) -> Vec<&'a str> {
    let concepts = filters.concepts().iter();
    concepts
        .filter_map(|&concept| model.concepts.get(usize::from(concept)))
        .map(|concept| concept.name)
        .collect()
}

/// The name of an action or a compound; `"?"` if the model has no such index.
pub fn action_name<'a>(model: &Model<'a>, action: u8) -> &'a str {
    model.action_name(action).unwrap_or("?")
}

/// The `f64` whose shortest notation is that of `value`, so that 0.1 stays 0.1.
pub fn decimal(value: f32) -> f64 {
    // Always a number: `f32` writes `NaN` and `inf` as `f64` reads them.
    value.to_string().parse().unwrap_or(f64::NAN)
}

/// [`decimal`] of each.
pub fn decimals(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(decimal).collect()
}

fn words(span: Span, sentence: &str) -> Value {
    json!({"text": span.of(sentence), "start": span.start, "end": span.end})
}

fn step(model: &Model<'_>, step: &Step) -> Value {
    let mut said = json!({
        "action": action_name(model, step.action),
        "object": description(model, &step.object),
        "reference": description(model, &step.reference),
    });
    if let Some(mm) = step.distance_mm {
        said["distance_mm"] = mm.get().into();
    }
    said
}

fn planned_step(step: &PlannedStep) -> Map<String, Value> {
    let pose = &step.sub_goal.pose;
    let position: [f32; 3] = pose.translation.vector.into();
    let orientation: [f32; 4] = pose.rotation.coords.into();
    let Confidence {
        split,
        words,
        action,
        relations,
        object,
        reference,
        object_unique,
        reference_unique,
        ..
    } = step.confidence;
    let mut map = Map::new();
    map.insert("object_id".into(), step.object.object.into());
    map.insert("reference_id".into(), step.reference.object.into());
    for (name, grounding) in [
        ("object_anchor_ids", &step.object),
        ("reference_anchor_ids", &step.reference),
    ] {
        if !grounding.anchors().is_empty() {
            map.insert(name.into(), grounding.anchors().into());
        }
    }
    map.insert("confidence".into(), decimal(step.confidence.joint()).into());
    map.insert(
        "confidences".into(),
        json!({
            "split": decimal(split),
            "words": decimal(words),
            "action": decimal(action),
            "relations": decimal(relations),
            "object": decimal(object),
            "reference": decimal(reference),
            "object_unique": decimal(object_unique),
            "reference_unique": decimal(reference_unique),
        }),
    );
    map.insert(
        "sub_goal".into(),
        json!({"position": decimals(&position), "orientation": decimals(&orientation)}),
    );
    map.insert("location".into(), decimals(&step.location).into());
    map
}

fn candidate(candidate: &Candidate) -> Value {
    json!({"object_id": candidate.object, "score": decimal(candidate.score)})
}
