mod between;
mod compounds;
mod distances;
mod exceptions;
mod extremes;
mod ordinals;
mod relations;
mod several;
mod sight;
mod table;

use core::task::Poll;
use std::string::{String, ToString};

use super::*;
use crate::capacity::MAX_STEP_TOKENS;
use crate::dsl::Argument;
use crate::fixture;
use crate::model::Thresholds;
use crate::nn::Dense;
use crate::refusal::{Candidate, Decision, LengthUnit, Quantity};

fn plan(sentence: &str) -> Result<Plan, Refusal> {
    let model = fixture::model();
    Planner::new(&model).plan(&fixture::scene(&model), sentence)
}

fn refusal(sentence: &str) -> Refusal {
    plan(sentence).unwrap_err()
}

/// The refusal as a person reads it.
fn message(sentence: &str) -> String {
    let model = fixture::model();
    refusal(sentence).in_context(&model, sentence).to_string()
}

fn close(left: &[f32], right: &[f32]) -> bool {
    left.len() == right.len() && left.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn a_plan_names_objects_and_where_they_will_be() {
    let model = fixture::model();
    let plan = plan("Put the small RED right the green").unwrap();
    assert_eq!(
        plan.program().notation(&model).to_string(),
        "Action(MoveRight, Unique(Filter(small, Filter(red, Scene()))), \
         Unique(Filter(green, Scene())))"
    );
    let [step] = plan.steps() else {
        panic!("{plan:?}");
    };
    assert_eq!((step.object.object, step.reference.object), (11, 12));
    // The reference's centre (0.5, 0.25) and 0.125 to the right; the object's own size.
    assert!(close(
        &step.location,
        &[0.5625, 0.1875, 0.6875, 0.3125, 0.5]
    ));
    // 0.125 of the image right of its centre, 0.25 above it, on the table.
    let goal = step.sub_goal;
    assert_eq!(goal.object, 11);
    let position: [f32; 3] = goal.pose.translation.vector.into();
    assert!(
        close(&position, &[0.5 + 0.125, -0.0625, fixture::EDGE_M / 2.0]),
        "{position:?}"
    );
    assert_eq!(goal.pose.rotation.coords.as_slice(), [0.0, 0.0, 0.0, 1.0]);
    // One of three fits: 1 / (1 + 2·e^-10), when the others' cosine is 0.
    assert!((step.object.probability - 0.999_909_2).abs() < 1e-6);
    assert_eq!(step.object.score, 1.0);
    let joint = step.confidence.joint();
    assert!(joint > 0.999 && joint < 1.0, "{joint}");
    assert_eq!(plan.confidence(), joint);
    assert_eq!(plan.sub_goals().len(), 1);
    assert_eq!(
        plan.explain(&model).to_string(),
        "Step 1: move the small red object (id 11, score 1.00) to the right of the green \
         object (id 12, score 1.00); confidence 1.00."
    );
}

#[test]
fn later_steps_see_what_earlier_ones_have_moved() {
    let plan = plan("put small red on green then put lego right small red").unwrap();
    let [first, second] = plan.steps() else {
        panic!("{plan:?}");
    };
    assert!(close(&first.location, &[0.4375, 0.125, 0.5625, 0.25, 0.5]));
    assert_eq!((second.object.object, second.reference.object), (13, 11));
    assert!(close(&second.location, &[0.5625, 0.125, 0.6875, 0.25, 0.5]));
    let both = first.confidence.joint() * second.confidence.joint();
    assert!(both < first.confidence.joint());
    assert_eq!(plan.confidence(), both);
}

#[test]
fn polling_takes_bounded_steps_and_gives_the_same_plan() {
    let model = fixture::model();
    let scene = fixture::scene(&model);
    let planner = Planner::new(&model);
    let sentence = "put small red on green , then put lego right small red.";
    let mut task = planner.begin(&scene, sentence);
    let mut polls = 1;
    let polled = loop {
        match task.poll() {
            Poll::Pending => polls += 1,
            Poll::Ready(plan) => break plan.cloned(),
        }
    };
    assert_eq!(polled, planner.plan(&scene, sentence));
    assert_eq!(task.poll().map(|plan| plan.cloned()), Poll::Ready(polled));
    // 12 words and the end read, 10 tokens split, 20 encoded, the end of the parser,
    // the check of the scene, and for each step its begin, three decoders, two groups' roles,
    // 2·(3 scores and a choice) and the action.
    assert_eq!(polls, 13 + 10 + 20 + 1 + 1 + 2 * (1 + 3 + 2 + 8 + 1));
}

/// What is left of a program is planned in the scene as it is, with the steps
/// counted as in the sentence.
#[test]
fn the_rest_of_a_program_is_grounded_in_another_scene() {
    let model = fixture::model();
    let scene = fixture::scene(&model);
    let planner = Planner::new(&model);
    let sentence = "put small red on green then put lego right small red";
    let parsed = planner.parse(sentence).unwrap();
    let ground = |scene: Scene, first| {
        let mut task = planner.begin_grounding(scene, &parsed, first);
        loop {
            if let Poll::Ready(plan) = task.poll() {
                let plan = plan.cloned();
                assert_eq!(
                    task.poll(),
                    Poll::Ready(plan.as_ref().map_err(|refusal| *refusal))
                );
                break plan;
            }
        }
    };
    let whole = planner.plan(&scene, sentence).unwrap();
    assert_eq!(ground(scene, 0).as_ref(), Ok(&whole));

    // The first step was carried out: small red stands where it was to be.
    let mut raw = *scene.raw();
    raw.objects[0].location = whole.steps()[0].location;
    let rest = ground(Scene::new(raw, &model).unwrap(), 1).unwrap();
    assert_eq!((rest.first(), rest.program()), (1, parsed.program()));
    // It is told as it would be of the whole.
    let told = |plan: &Plan, step| plan.explain_step(&model, step).to_string();
    assert!(told(&rest, 1).starts_with("Step 2: move the lego "));
    assert_eq!(rest.explain(&model).to_string(), told(&rest, 1));
    assert_eq!((told(&rest, 0), told(&rest, 2)), Default::default());
    assert_eq!(rest.steps(), &whole.steps()[1..]);
    for first in [2, 3, usize::MAX] {
        let nothing = ground(scene, first).unwrap();
        assert_eq!((nothing.first(), nothing.steps()), (2, &[][..]));
    }

    // Without the lego block the second step has no object.
    raw.count = 2;
    let refusal = ground(Scene::new(raw, &model).unwrap(), 1).unwrap_err();
    assert!(matches!(refusal, Refusal::NoSuchObject { step: 1, .. }));
}

#[test]
fn a_task_may_own_what_it_works_on() {
    let model = fixture::model();
    let sentence = "put small red on green";
    let scene = fixture::scene(&model);
    let mut task = Planner::new(&model).begin(scene, String::from(sentence));
    let plan = loop {
        if let Poll::Ready(plan) = task.poll() {
            break plan.cloned();
        }
    };
    assert_eq!(plan, Planner::new(&model).plan(&scene, sentence));
}

#[test]
fn the_longest_sentence_stays_within_the_bound_of_polls() {
    let model = fixture::model();
    let objects: std::vec::Vec<_> = (1..=16)
        .map(|id| {
            let (color, size) = match id {
                1 => (fixture::RED, fixture::SMALL),
                2 => (fixture::GREEN, fixture::LEGO),
                _ => (fixture::RED + 2, fixture::SMALL + 2),
            };
            fixture::object(id, color, size, 0.5, 0.5)
        })
        .collect();
    let scene = Scene::new(fixture::raw_scene(&model, &objects), &model).unwrap();
    // 8 steps of 16 tokens: full in steps, tokens and concepts.
    let step = "then put the the red red red small on the the the the the the the \
                green green green lego the";
    let sentence = std::vec![step; MAX_STEPS].join(" ");
    let mut task = Planner::new(&model).begin(&scene, &sentence);
    let mut polls = 1;
    let plan = loop {
        match task.poll() {
            Poll::Pending => polls += 1,
            Poll::Ready(plan) => break plan,
        }
    };
    assert_eq!(plan.map(|plan| plan.steps().len()), Ok(MAX_STEPS));
    assert!(polls <= MAX_POLLS, "{polls}");
}

#[test]
fn what_is_no_sentence_is_refused() {
    for sentence in ["", "  \n", " ?!"] {
        assert_eq!(refusal(sentence), Refusal::NoWords);
    }
    assert_eq!(
        message("put the pink on green"),
        "\"pink\" is not a word that the model knows; use another one"
    );
    assert_eq!(
        message("put red. put green"),
        "\".\" is not a word that the model knows; use another one"
    );
    assert_eq!(
        refusal("put the ro\u{15f}u"),
        Refusal::UnknownWord {
            span: crate::language::Span { start: 8, end: 13 }
        }
    );
    assert_eq!(
        refusal(&"the ".repeat(MAX_TOKENS + 1)),
        Refusal::SentenceTooLong {
            limit: 128,
            unit: LengthUnit::Tokens
        }
    );
    assert_eq!(
        refusal(&" ".repeat(crate::MAX_SENTENCE_BYTES + 1)),
        Refusal::SentenceTooLong {
            limit: 4096,
            unit: LengthUnit::Bytes
        }
    );
    let step = std::format!(
        "put the red on {} the green",
        "the ".repeat(MAX_STEP_TOKENS)
    );
    assert_eq!(
        message(&step),
        "the sentence is too long: at most 64 words of one step are read; give it in parts"
    );
    assert_eq!(
        message("put red red small RED red on green"),
        "\"red red small RED red\" are too many words for one object: at most 4 are read"
    );
}

#[test]
fn two_values_of_one_attribute_are_refused() {
    let sentence = "put red on green small RED";
    let refused = refusal(sentence);
    assert!(matches!(
        refused,
        Refusal::ConflictingValues {
            span: crate::language::Span { start: 11, end: 26 },
            ..
        }
    ));
    assert_eq!(refused.kind(), "conflicting_values");
    assert_eq!(
        message(sentence),
        "\"green small RED\" describes one object as both green and red; name one of them"
    );
    // Said twice it is one value.
    let model = fixture::model();
    assert!(Planner::new(&model).parse("put red on green GREEN").is_ok());
}

#[test]
fn what_is_no_program_is_refused() {
    assert_eq!(
        message("put red on green then put small"),
        "step 2, \"then put small\", describes 1 of the two objects that it needs; \
         say what to move, and on or beside what"
    );
    let nine = std::vec!["put red on green"; MAX_STEPS + 1].join(" then ");
    assert_eq!(refusal(&nine), Refusal::TooManySteps { limit: 8 });
    let groups = "put red on small the green";
    assert!(matches!(
        refusal(groups),
        Refusal::TooManyReferences {
            step: 0,
            limit: 2,
            ..
        }
    ));
    assert_eq!(
        message(groups),
        "step 1, \"put red on small the green\", describes more than 2 objects; say one thing to \
         move and one place, and describe each by attribute words that stand together"
    );
    // `on` stands on both sides of red and is taken back in front of green.
    assert_eq!(
        message("on small red on not green"),
        "step 1: \"small red\" was understood as both what to move and where to; \
         say it in other words"
    );
}

#[test]
fn what_the_parser_is_not_sure_of_is_refused() {
    let unsure = |sentence| match refusal(sentence) {
        Refusal::Unsure {
            step,
            decision,
            probability,
            threshold,
        } => {
            assert_eq!(threshold, 0.6);
            assert!((0.4999..0.52).contains(&probability), "{probability}");
            (step, decision)
        }
        refusal => panic!("{refusal:?}"),
    };
    let (object, reference) = (Argument::Object, Argument::Reference);
    // Neither one step nor two.
    assert_eq!(
        unsure("put red on green perhaps put green"),
        (0, Decision::Split)
    );
    assert_eq!(unsure("put red near green"), (0, Decision::Action));
    assert_eq!(
        unsure("put red the lego on"),
        (0, Decision::Argument(object))
    );
    assert_eq!(
        unsure("put red on green then on red on lego"),
        (1, Decision::Argument(reference))
    );
}

#[test]
fn what_fits_no_object_or_several_is_refused() {
    assert_eq!(
        message("put the lego green on small red"),
        "step 1: the object \"lego green\" fits no object in the scene: the best is object \
         11 with a score of 0.00, needed 0.60"
    );
    assert_eq!(
        message("put green on red"),
        "step 1: the reference \"red\" fits 2 objects: 11 (score 1.00), 13 (score 1.00); \
         describe it more closely"
    );
    assert_eq!(
        refusal("put small red on lego then put lego on lego red"),
        Refusal::SameObject {
            step: 1,
            object: 13
        }
    );
    let model = fixture::model();
    let empty = Scene::new(fixture::raw_scene(&model, &[]), &model).unwrap();
    let refusal = Planner::new(&model)
        .plan(&empty, "put red on green")
        .unwrap_err();
    assert!(matches!(refusal, Refusal::NoSuchObject { best: None, .. }));
    assert_eq!(
        refusal.to_string(),
        "step 1: the object's description fits no object in the scene: it is empty"
    );
}

/// The least score that will do is included, and candidates come best first.
#[test]
fn a_score_at_the_threshold_fits() {
    let mut model = fixture::model();
    let mut dull = fixture::object(2, fixture::RED, fixture::LEGO, 0.5, 0.5);
    // cos = 3 / 5
    (dull.embedding[0], dull.embedding[5]) = (3.0, 4.0);
    let green = fixture::object(3, fixture::GREEN, fixture::SMALL, 0.25, 0.25);
    let one = Scene::new(fixture::raw_scene(&model, &[dull, green]), &model).unwrap();
    // Elements that the operator passes on reach concept space up to its 16th.
    let plan = Planner::new(&model).plan(&one, "put red on green").unwrap();
    assert!((plan.steps()[0].object.score - 0.6).abs() < 1e-6);
    let red = fixture::object(1, fixture::RED, fixture::SMALL, 0.75, 0.25);
    let two = Scene::new(fixture::raw_scene(&model, &[dull, green, red]), &model).unwrap();
    let refusal = Planner::new(&model)
        .plan(&two, "put red on green")
        .unwrap_err();
    let Refusal::Ambiguous { candidates, .. } = refusal else {
        panic!("{refusal:?}");
    };
    let ids: std::vec::Vec<_> = candidates.listed().iter().map(|c| c.object).collect();
    assert_eq!(ids, [1, 2]);
    model.header.thresholds = Thresholds {
        match_score: 0.61,
        ..model.header.thresholds
    };
    let chosen = Planner::new(&model).plan(&two, "put red on green").unwrap();
    assert_eq!(chosen.steps()[0].object.object, 1);
    let none = Planner::new(&model)
        .plan(&one, "put red on green")
        .unwrap_err();
    let Refusal::NoSuchObject {
        best: Some(Candidate { object: 2, score }),
        ..
    } = none
    else {
        panic!("{none:?}");
    };
    assert!((score - 0.6).abs() < 1e-6);
}

#[test]
fn a_sub_goal_outside_the_work_space_is_refused() {
    let mut model = fixture::model();
    model.header.work_space.max[0] = 0.53;
    let far = fixture::object(1, fixture::GREEN, fixture::SMALL, 0.6, 0.5);
    let near = fixture::object(2, fixture::RED, fixture::SMALL, 0.25, 0.25);
    let scene = Scene::new(fixture::raw_scene(&model, &[far, near]), &model).unwrap();
    let planner = Planner::new(&model);
    let refusal = planner.plan(&scene, "put red on green").unwrap_err();
    assert_eq!(refusal.kind(), "outside_work_space");
    assert_eq!(
        refusal.to_string(),
        "step 1: object 2 would be moved to (0.531, -0.050, 0.031) m, outside the work \
         space: x 0 to 0.53, y -0.5 to 0.5, z 0 to 0.6 m"
    );
}

#[test]
fn a_scene_of_another_model_is_refused() {
    let model = fixture::model();
    let scene = fixture::scene(&model);
    let mut other = model;
    other.header.identity[0] = 8;
    let planner = Planner::new(&other);
    let (expected, got) = (other.tag(), model.tag());
    let refusal = Err(Refusal::OtherModel { expected, got });
    // Of no sentence, not even a bad one.
    assert_eq!(planner.plan(&scene, "put red on blurp"), refusal);
    let mut task = planner.begin_grounding(&scene, &Parsed::empty(&other), 0);
    assert_eq!(task.poll().map(|plan| plan.cloned()), Poll::Ready(refusal));
    assert_eq!(got, 0x0100_0000_0000_0007);
}

#[test]
fn results_that_are_not_finite_are_refused() {
    let model = fixture::model();
    let sentence = "put small red on green";
    let quantity = |model: &Model<'_>| {
        let scene = fixture::scene(model);
        match Planner::new(model).plan(&scene, sentence) {
            Err(Refusal::NotFinite { step: 0, quantity }) => quantity,
            other => panic!("{other:?}"),
        }
    };
    let mut hazard = *model.language.hazard;
    hazard.bias = [f32::NAN];
    let mut broken = model;
    broken.language.hazard = &hazard;
    assert_eq!(quantity(&broken), Quantity::Split);

    let mut actions = [model.actions[0], model.actions[1]];
    actions[1].decoder_bias = f32::NAN;
    let broken = Model {
        actions: &actions,
        ..model
    };
    assert_eq!(quantity(&broken), Quantity::Action);

    let mut decoder = *model.language.reference_decoder.as_f32().unwrap();
    decoder.bias[1] = f32::INFINITY;
    let mut broken = model;
    broken.language.reference_decoder = Dense::F32(&decoder);
    assert_eq!(quantity(&broken), Quantity::Argument(Argument::Reference));

    let mut attributes = [model.attributes[0], model.attributes[1]];
    attributes[1].output.bias[3] = f32::MAX;
    let broken = Model {
        attributes: &attributes,
        ..model
    };
    assert_eq!(quantity(&broken), Quantity::Score(Argument::Object));

    let mut simulator = *model.simulator;
    simulator.output.bias[4] = f32::INFINITY;
    let broken = Model {
        simulator: &simulator,
        ..model
    };
    assert_eq!(quantity(&broken), Quantity::Location);

    // A location may still be finite where the point in the world is not.
    simulator.output.bias[4] = f32::MAX;
    let broken = Model {
        simulator: &simulator,
        ..model
    };
    assert_eq!(quantity(&broken), Quantity::Pose);
}

/// A model that [`Model::check`] refuses is refused here too, not a panic.
#[test]
fn indices_that_point_at_nothing_are_refused() {
    let model = fixture::model();
    let scene = fixture::scene(&model);
    let no_concepts = Model {
        concepts: &[],
        ..model
    };
    let no_attributes = Model {
        attributes: &[],
        ..model
    };
    let sizeless: std::vec::Vec<_> = model
        .concepts
        .iter()
        .map(|concept| crate::model::Concept {
            edges_m: None,
            ..*concept
        })
        .collect();
    let no_sizes = Model {
        concepts: &sizeless,
        ..model
    };
    for broken in [no_concepts, no_attributes, no_sizes] {
        assert!(broken.check().is_err());
        let refusal = Planner::new(&broken).plan(&scene, "put red on green");
        assert_eq!(refusal, Err(Refusal::InvalidModel));
    }
}
