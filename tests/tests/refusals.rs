//! Every refusal, by sentence and scene, with the model whose weights were set by hand: its exact
//! fields, and its message.

use core::task::Poll;
use nsrm_core::calibration::{CalibrationFault, Measured};
use nsrm_core::dsl::{Argument, Description, Property};
use nsrm_core::language::Span;
use nsrm_core::refusal::{Candidate, Decision, LengthUnit, Quantity};
use nsrm_core::{MAX_FILTERS, MAX_RELATIONS, MAX_SENTENCE_BYTES, MAX_STEPS, MAX_TOKENS};
use nsrm_core::{Planner, RawScene, Refusal, Scene};
use nsrm_tests::by_hand::{Block, EDGES_M, Parts, block, raw_scene, scene};

/// One case: sentence, objects, fault and expected refusal.
struct Case {
    sentence: String,
    blocks: Vec<Block>,
    /// Changes the model before the scene is made.
    spoil: fn(&mut Parts),
    /// Changes the scene before it is checked.
    disturb: fn(&mut RawScene),
    /// Whether this is the expected refusal, with all its fields.
    expected: fn(&Refusal) -> bool,
    /// A part of its message.
    message: &'static str,
}

const fn span(start: u16, end: u16) -> Span {
    Span { start, end }
}

fn describes(description: &Description, concepts: &[u8]) -> bool {
    description.concepts() == concepts
}

/// Blocks, model and scene are valid; only the sentence is at fault.
fn said(
    sentence: impl Into<String>,
    expected: fn(&Refusal) -> bool,
    message: &'static str,
) -> Case {
    Case {
        sentence: sentence.into(),
        blocks: vec![
            block("small", "red"),
            block("lego", "red"),
            block("lego", "blue"),
        ],
        spoil: |_| {},
        disturb: |_| {},
        expected,
        message,
    }
}

/// A valid sentence, with a fault in the model.
fn spoilt(spoil: fn(&mut Parts), expected: fn(&Refusal) -> bool, message: &'static str) -> Case {
    Case {
        spoil,
        ..said(GOOD, expected, message)
    }
}

const GOOD: &str = "put the small red block on the blue block";

fn sentence_cases() -> Vec<Case> {
    vec![
        said(
            " .  ",
            |refusal| matches!(refusal, Refusal::NoWords),
            "no words",
        ),
        said(
            "put the crimson block on the blue block",
            |refusal| *refusal == Refusal::UnknownWord { span: span(8, 15) },
            "\"crimson\" is not a word that the model knows; use another one",
        ),
        said(
            "put the small rde block on the blue block",
            |refusal| *refusal == Refusal::UnknownWord { span: span(14, 17) },
            "\"rde\" is not a word that the model knows; did you mean \"red\"?",
        ),
        said(
            "x".repeat(MAX_SENTENCE_BYTES + 1),
            |refusal| {
                let (limit, unit) = (MAX_SENTENCE_BYTES as u16, LengthUnit::Bytes);
                *refusal == Refusal::SentenceTooLong { limit, unit }
            },
            "at most 4096 bytes",
        ),
        said(
            "the ".repeat(MAX_TOKENS + 1),
            |refusal| {
                let (limit, unit) = (MAX_TOKENS as u16, LengthUnit::Tokens);
                *refusal == Refusal::SentenceTooLong { limit, unit }
            },
            "at most 128 words",
        ),
        said(
            "put the red red red red red block on the blue block",
            |refusal| {
                let limit = MAX_FILTERS as u8;
                matches!(*refusal, Refusal::TooManyConcepts { span, limit: l } if l == limit && span.start == 8)
            },
            "too many words for one object: at most 4",
        ),
        said(
            "put the small red block on the blue small green block",
            |refusal| {
                let span = span(31, 47);
                matches!(*refusal, Refusal::ConflictingValues { span: s, .. } if s == span)
            },
            "\"blue small green\" describes one object as both blue and green",
        ),
        said(
            format!("{GOOD} then ").repeat(MAX_STEPS) + GOOD,
            |refusal| {
                let limit = MAX_STEPS as u8;
                *refusal == Refusal::TooManySteps { limit }
            },
            "more than 8 steps",
        ),
    ]
}

fn step_cases() -> Vec<Case> {
    vec![
        said(
            "put the red and small block on the blue block",
            |refusal| {
                matches!(
                    *refusal,
                    Refusal::TooManyReferences {
                        step: 0,
                        limit: 2,
                        ..
                    }
                )
            },
            "describes more than 2 objects",
        ),
        said(
            "put on the small red block behind the blue block",
            |refusal| {
                matches!(
                    refusal,
                    Refusal::IncompleteStep {
                        step: 0,
                        references: 1,
                        ..
                    }
                )
            },
            "describes 1 of the two objects",
        ),
        said(
            "put the red block behind the red behind the red behind the red on the blue block",
            |refusal| {
                let (step, span, limit) = (0, span(8, 62), MAX_RELATIONS as u8);
                *refusal == Refusal::TooManyRelations { step, span, limit }
            },
            "describes one object by more than 2 others",
        ),
        said(
            "put the small red block on the block",
            |refusal| {
                let (step, references, span) = (0, 1, span(0, 36));
                *refusal
                    == Refusal::IncompleteStep {
                        step,
                        references,
                        span,
                    }
            },
            "describes 1 of the two objects",
        ),
        said(
            format!("{GOOD} then put the red lego"),
            |refusal| {
                matches!(
                    refusal,
                    Refusal::IncompleteStep {
                        step: 1,
                        references: 1,
                        ..
                    }
                )
            },
            "step 2",
        ),
        said(
            "put the small red block on it the blue block",
            |refusal| {
                let (step, span) = (0, span(34, 38));
                *refusal == Refusal::SameReference { step, span }
            },
            "\"blue\" was understood as both",
        ),
        said(
            format!("{GOOD} then put this on the small red block"),
            |refusal| {
                let (step, span) = (1, span(51, 55));
                *refusal == Refusal::UnclearPronoun { step, span }
            },
            "step 2: it is not clear which object \"this\" means",
        ),
        said(
            "put the small red block on both blue block",
            |refusal| {
                let (step, span) = (0, span(27, 36));
                *refusal == Refusal::SeveralReferences { step, span }
            },
            "\"both blue\" describes several objects where a single one is needed",
        ),
        said(
            "put the small red block sideways on the blue block",
            |refusal| {
                matches!(
                    *refusal,
                    Refusal::UnclearWords { step: 0, span: word, .. } if word == span(24, 32)
                )
            },
            "step 1 is not clear at \"sideways\"",
        ),
    ]
}

fn doubt_cases() -> Vec<Case> {
    fn unsure(refusal: &Refusal, expected: Decision, about: f32) -> bool {
        matches!(
            *refusal,
            Refusal::Unsure { step: 0, decision, probability, threshold: 0.6 }
                if decision == expected && (probability - about).abs() < 0.01
        )
    }
    vec![
        said(
            // Neither one step nor two.
            format!("{GOOD} maybe put the small red block"),
            |refusal| unsure(refusal, Decision::Split, 0.57),
            "not sure where the step ends: probability 0.57, needed 0.60",
        ),
        said(
            "put the small red block and the blue block",
            |refusal| unsure(refusal, Decision::Action, 0.5),
            "not sure what is to be done",
        ),
        said(
            "on the blue block put the small red block",
            |refusal| unsure(refusal, Decision::Argument(Argument::Object), 0.5),
            "not sure which words name the object",
        ),
        spoilt(
            |parts| parts.actions[0].relation_bias[1] = 0.0,
            |refusal| unsure(refusal, Decision::Relation, 0.5),
            "not sure how the described objects are related",
        ),
        spoilt(
            |parts| parts.reference_decoder.bias.fill(0.0),
            |refusal| unsure(refusal, Decision::Argument(Argument::Reference), 0.5),
            "not sure which words name the reference",
        ),
    ]
}

fn object_cases() -> Vec<Case> {
    vec![
        Case {
            spoil: Parts::add_table,
            ..said(
                "put the desk on the blue block",
                |refusal| {
                    let span = span(8, 12);
                    *refusal == Refusal::OnlyOnTable { step: 0, span }
                },
                "\"desk\" can only be what objects are put on, or stand on",
            )
        },
        said(
            "put the green block on the blue block",
            |refusal| {
                matches!(
                    refusal,
                    Refusal::NoSuchObject {
                        step: 0,
                        argument: Argument::Object,
                        description,
                        best: Some(Candidate { score, .. }),
                        threshold: 0.5,
                    } if describes(description, &[1]) && score.abs() < 1e-3
                )
            },
            "the object \"green\" fits no object in the scene: the best is object 1",
        ),
        Case {
            blocks: Vec::new(),
            ..said(
                GOOD,
                |refusal| matches!(refusal, Refusal::NoSuchObject { best: None, .. }),
                "it is empty",
            )
        },
        said(
            "put both blue block on the small red block",
            |refusal| {
                matches!(
                    refusal,
                    Refusal::OtherNumber { step: 0, description, expected: 2, got: 1 }
                        if describes(description, &[2])
                )
            },
            "the object \"both blue\" means 2 objects, but fits 1",
        ),
        Case {
            spoil: Parts::add_table,
            ..said(
                "put the small red block on the desk",
                |refusal| *refusal == Refusal::AlreadyOnTable { step: 0, object: 1 },
                "object 1 stands on the table already",
            )
        },
        Case {
            spoil: |parts| {
                parts.add_table();
                // Above the table.
                parts.header.work_space.min[2] = 0.1;
            },
            // As if the first block stood on another one.
            disturb: |scene| scene.objects[0].location[4] -= EDGES_M[2],
            ..said(
                "put the small red block on the desk",
                |refusal| *refusal == Refusal::NoRoomOnTable { step: 0, object: 1 },
                "no free place on the table is in sight for object 1",
            )
        },
        Case {
            spoil: Parts::add_distances,
            // On the blue one.
            disturb: |scene| {
                scene.objects[1].location = scene.objects[2].location;
                scene.objects[1].location[4] -= EDGES_M[2];
            },
            ..said(
                "put the small red block 20 mm beside the blue block",
                |refusal| *refusal == Refusal::HiddenReference { step: 0, object: 3 },
                "hide too much of object 3 to tell exactly where it is",
            )
        },
        Case {
            spoil: Parts::add_distances,
            // As if it stood on another one.
            disturb: |scene| scene.objects[0].location[4] -= EDGES_M[2],
            ..said(
                "put the small red block 20 mm aside",
                |refusal| *refusal == Refusal::NotOnTable { step: 0, object: 1 },
                "object 1 does not stand on the table",
            )
        },
        said(
            "put the blue block on the red block",
            |refusal| {
                matches!(
                    refusal,
                    Refusal::Ambiguous {
                        step: 0,
                        argument: Argument::Reference,
                        description,
                        candidates,
                    } if describes(description, &[0])
                        && candidates.count() == 2
                        && candidates.listed().iter().map(|c| c.object).eq([1, 2])
                )
            },
            "the reference \"red\" fits 2 objects: 1 (score 1.00), 2 (score 1.00)",
        ),
        Case {
            blocks: vec![block("small", "red"); 16],
            ..said(
                GOOD,
                |refusal| {
                    matches!(refusal, Refusal::Ambiguous { candidates, .. }
                        if candidates.count() == 16 && candidates.listed().len() == 8)
                },
                "and others",
            )
        },
        said(
            "put the small red block on the small block",
            |refusal| {
                let (step, object) = (0, 1);
                *refusal == Refusal::SameObject { step, object }
            },
            "both descriptions fit object 1",
        ),
    ]
}

fn place_cases() -> Vec<Case> {
    vec![
        Case {
            // So far to the left of the image that the sub-goal is outside the work space.
            disturb: |scene| {
                scene.objects[2].location[0] = 0.0;
                scene.objects[2].location[2] = 0.01;
            },
            ..said(
                GOOD,
                |refusal| {
                    matches!(
                        refusal,
                        Refusal::OutsideWorkSpace { step: 0, object: 1, position: [x, ..], bounds }
                            if *x < bounds.min[0]
                    )
                },
                "outside the work space: x 0.3 to 0.7",
            )
        },
        Case {
            // All blocks half a metre farther to the side than the training's camera sees.
            disturb: |scene| scene.camera.position[1] += 0.5,
            ..said(
                GOOD,
                |refusal| {
                    matches!(
                        refusal,
                        Refusal::OutsideTrainingView {
                            step: 0,
                            argument: Argument::Object,
                            object: 1,
                        }
                    )
                },
                "step 1: the object, object 1, is farther out, or seen by a lower camera, than in training",
            )
        },
        Case {
            disturb: |scene| scene.camera.position[2] += 0.05,
            ..said(
                GOOD,
                |refusal| {
                    matches!(
                        refusal,
                        Refusal::Calibration(CalibrationFault {
                            object: 1,
                            quantity: Measured::Height,
                            measured_m,
                            expected_m,
                            disagreeing: 3,
                            whole: 3,
                            cause: None,
                            ..
                        }) if (measured_m - 0.075).abs() < 1e-5 && (expected_m - 0.025).abs() < 1e-5
                    )
                },
                "object 1 is seen at a height of 0.075 m, but would rest at 0.025 m (3 of 3 objects \
                 disagree); the camera's pose may be too high, or depths too short",
            )
        },
    ]
}

fn confidence_cases() -> Vec<Case> {
    vec![spoilt(
        |parts| parts.header.thresholds.confidence = 1.0,
        |refusal| {
            matches!(*refusal, Refusal::LowConfidence { confidence, threshold: 1.0 }
                if (0.99..1.0).contains(&confidence))
        },
        "not sure enough of the plan: confidence 0.9",
    )]
}

fn model_cases() -> Vec<Case> {
    fn of(refusal: &Refusal, quantity: Quantity) -> bool {
        *refusal == Refusal::NotFinite { step: 0, quantity }
    }
    vec![
        spoilt(
            |parts| parts.lexicon[0].property = Property::Concept(200),
            |refusal| matches!(refusal, Refusal::InvalidModel),
            "the model is damaged",
        ),
        spoilt(
            |parts| parts.hazard.bias = [f32::NAN],
            |refusal| of(refusal, Quantity::Split),
            "the splitter's hazard is not a finite number",
        ),
        spoilt(
            |parts| parts.actions[1].decoder_bias = f32::INFINITY,
            |refusal| of(refusal, Quantity::Action),
            "the action decoder's result",
        ),
        spoilt(
            |parts| parts.actions[1].relation_bias[0] = f32::NAN,
            |refusal| of(refusal, Quantity::Relation),
            "the relation decoder's result",
        ),
        spoilt(
            |parts| parts.object_decoder.bias[3] = f32::NAN,
            |refusal| of(refusal, Quantity::Argument(Argument::Object)),
            "the object decoder's result",
        ),
        spoilt(
            |parts| parts.reference_decoder.bias[3] = f32::NAN,
            |refusal| of(refusal, Quantity::Argument(Argument::Reference)),
            "the reference decoder's result",
        ),
        spoilt(
            |parts| parts.attributes[1].output.bias[5] = f32::NAN,
            |refusal| of(refusal, Quantity::Score(Argument::Object)),
            "a score for the object",
        ),
        Case {
            sentence: "put the red lego on the blue block".into(),
            ..spoilt(
                |parts| parts.concepts[2].embedding[0] = f32::NAN,
                |refusal| of(refusal, Quantity::Score(Argument::Reference)),
                "a score for the reference",
            )
        },
        spoilt(
            |parts| parts.simulator.output.bias[4] = f32::NAN,
            |refusal| of(refusal, Quantity::Location),
            "the predicted location",
        ),
        spoilt(
            |parts| parts.simulator.output.bias[4] = f32::MAX,
            |refusal| of(refusal, Quantity::Pose),
            "the sub-goal's pose",
        ),
    ]
}

fn cases() -> Vec<Case> {
    let mut cases = sentence_cases();
    cases.extend(step_cases());
    cases.extend(doubt_cases());
    cases.extend(object_cases());
    cases.extend(place_cases());
    cases.extend(confidence_cases());
    cases.extend(model_cases());
    cases
}

impl Case {
    fn refusal(&self) -> (Refusal, String) {
        let mut parts = Parts::new();
        (self.spoil)(&mut parts);
        let model = parts.model();
        let mut raw = raw_scene(&model, &self.blocks);
        (self.disturb)(&mut raw);
        let scene = Scene::new(raw, &model).expect("the scene itself is in order");
        let refusal = Planner::new(&model)
            .plan(&scene, &self.sentence)
            .expect_err(self.message);
        let message = refusal.in_context(&model, &self.sentence).to_string();
        (refusal, message)
    }
}

#[test]
fn each_case_is_refused_for_its_reason_and_says_so() {
    for case in cases() {
        let (refusal, message) = case.refusal();
        let start: String = case.sentence.chars().take(60).collect();
        assert!((case.expected)(&refusal), "{start:?}: {refusal:?}");
        assert!(message.contains(case.message), "{start:?}: {message}");
        assert!(!refusal.to_string().is_empty());
    }
}

#[test]
fn a_scene_of_another_model_is_refused() {
    let parts = Parts::new();
    let model = parts.model();
    let mut other = Parts::new();
    other.header.identity = [9; 32];
    let other = other.model();
    let scene = Scene::new(raw_scene(&other, &[block("small", "red")]), &other).unwrap();
    let refusal = Planner::new(&model).plan(&scene, GOOD).unwrap_err();
    let (expected, got) = (model.tag(), other.tag());
    assert_eq!(refusal, Refusal::OtherModel { expected, got });
    let message = refusal.in_context(&model, GOOD).to_string();
    assert!(message.contains("observe it again with this model"));
}

/// Its actions and concepts may differ: the planner would report a damaged model or, worse, move
/// the wrong object.
#[test]
fn what_another_model_has_parsed_is_refused() {
    let parts = Parts::new();
    let model = parts.model();
    let mut other = Parts::new();
    other.header.identity = [9; 32];
    // The same words, but some have another meaning.
    for entry in &mut other.lexicon {
        entry.property = match entry.property {
            Property::Concept(0) => Property::Concept(1),
            Property::Concept(1) => Property::Concept(0),
            other => other,
        };
    }
    let other = other.model();
    let scene = scene(&model, &said(GOOD, |_| false, "").blocks);
    let parsed = Planner::new(&other).parse(GOOD).unwrap();
    let mut task = Planner::new(&model).begin_grounding(&scene, &parsed, 0);
    let (expected, got) = (model.tag(), other.tag());
    let refusal = Refusal::ParsedByOtherModel { expected, got };
    assert_eq!(task.poll(), Poll::Ready(Err(refusal)));
    let message = refusal.in_context(&model, GOOD).to_string();
    assert!(message.contains("parse it again with this model"));
    // A program that the same model has parsed is accepted.
    let parsed = Planner::new(&model).parse(GOOD).unwrap();
    let mut task = Planner::new(&model).begin_grounding(&scene, &parsed, 0);
    assert_eq!(task.poll(), Poll::Pending);
}

/// A kind that is not in `REASONS` would reach other processes without its reason.
#[test]
fn every_kind_is_a_reason_of_a_reply() {
    for kind in Refusal::KINDS {
        assert!(nsrm_ipc::message::REASONS.contains(kind), "{kind}");
    }
}

#[test]
fn the_cases_cover_every_kind() {
    // These have their own tests, with two models.
    let mut covered = vec!["other_model", "parsed_by_other_model"];
    covered.extend(cases().iter().map(|case| case.refusal().0.kind()));
    for kind in Refusal::KINDS {
        assert!(covered.contains(kind), "no case is refused as {kind}");
    }
    assert!(covered.iter().all(|kind| Refusal::KINDS.contains(kind)));
}

#[test]
fn without_a_fault_nothing_is_refused() {
    let parts = Parts::new();
    let model = parts.model();
    let blocks = said(GOOD, |_| false, "").blocks;
    let scene = Scene::new(raw_scene(&model, &blocks), &model).unwrap();
    assert!(Planner::new(&model).plan(&scene, GOOD).is_ok());
}
