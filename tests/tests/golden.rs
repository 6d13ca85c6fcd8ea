//! Golden vectors of the trainer: each layer, each module and the whole chain, on
//! the static model and on the model file loaded at run time.

use core::task::Poll;
use nsrm_core::action::simulate;
use nsrm_core::language::{
    Encoder, ParsingTask, Reader, SPLIT_HAZARD, Splitter, Token, choose_action, choose_group,
    choose_role,
};
use nsrm_core::model::{LOCATION, Model, OBJECT_EMBEDDING};
use nsrm_core::nn::{Choice, Gru, Linear, MergeConv, PatchConv};
use nsrm_core::relation::{direction, distance, relate};
use nsrm_core::scene::ObservedObject;
use nsrm_core::viewpoint::Viewpoint;
use nsrm_core::vision::{Crop, RgbImage, encode, similarity};
use nsrm_core::{MAX_GROUPS, Planner, Program, RawScene, Refusal, Scene};
use nsrm_tabletop::TABLETOP;
use nsrm_tests::golden::{Array, Golden, camera, fixed, numbers};
use serde_json::Value;

/// Runs a test on the model of the golden vectors, static and loaded.
fn on_both(test: impl Fn(&Golden, &Model<'_>)) {
    let golden = Golden::read();
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../weights-codegen/tabletop/tabletop.safetensors"
    );
    let loaded = nsrm::load_model(path).expect("the model file can be loaded");
    let of = golden.cases["model_identity"]
        .as_str()
        .expect("model_identity");
    for (form, model) in [("static", TABLETOP), ("loaded", loaded.as_model())] {
        let identity = model.header.identity.map(|byte| format!("{byte:02x}"));
        assert_eq!(
            identity.concat(),
            of,
            "the vectors are of another model than the {form} one; cargo harness golden"
        );
        println!("on the {form} model");
        test(&golden, &model);
    }
}

#[test]
fn golden_linear() {
    let golden = Golden::read();
    let layer = Linear::<7, 5>::new()
        .with_weight(golden.array("layer.linear.weight").columns())
        .with_bias(golden.array("layer.linear.bias").fixed());
    let (inputs, outputs) = (
        golden.array("layer.linear.input"),
        golden.array("layer.linear.output"),
    );
    for (input, output) in inputs.rows().zip(outputs.rows()) {
        golden.close("layer", &layer.apply(&fixed(input)), output, "linear");
    }
}

/// Patches of a picture, and squares of the patches.
#[test]
fn golden_convolutions() {
    let golden = Golden::read();
    let patch = kernels(&golden, "layer.patch.weight", [8, 2, 4, 4]);
    let patch = PatchConv::<2, 8>::new()
        .with_weight(array4(|[input, row, column, output]| {
            patch([output, input, row, column])
        }))
        .with_bias(golden.array("layer.patch.bias").fixed());
    let mut patches = [[[0.0; 8]; 4]; 4];
    let input: [[[f32; 16]; 16]; 2] = maps(&golden.array("layer.patch.input").values);
    patch.apply(&input, &mut patches);
    close_maps(&golden, "layer.patch.output", &patches);

    let merge = kernels(&golden, "layer.merge.weight", [3, 8, 2, 2]);
    let merge = MergeConv::<8, 3>::new()
        .with_weight(array4(|[row, column, input, output]| {
            merge([output, input, row, column])
        }))
        .with_bias(golden.array("layer.merge.bias").fixed());
    let mut merged = [[[0.0; 3]; 2]; 2];
    merge.apply(&patches, &mut merged);
    close_maps(&golden, "layer.merge.output", &merged);
}

/// The weights of a convolution, by output, input, row and column.
fn kernels(golden: &Golden, name: &str, shape: [usize; 4]) -> impl Fn([usize; 4]) -> f32 {
    let weight = golden.array(name);
    assert_eq!(weight.shape, shape);
    move |index| {
        let flat = index
            .iter()
            .zip(shape)
            .fold(0, |flat, (at, size)| flat * size + at);
        weight.values[flat]
    }
}

/// Panics unless a map by row, column and channel is the expected one by channel, row and column.
fn close_maps<const CHANNELS: usize, const SIDE: usize>(
    golden: &Golden,
    name: &str,
    got: &[[[f32; CHANNELS]; SIDE]; SIDE],
) {
    let expected: [[[f32; SIDE]; SIDE]; CHANNELS] = maps(&golden.array(name).values);
    let by_pixel: [[[f32; CHANNELS]; SIDE]; SIDE] = std::array::from_fn(|row| {
        std::array::from_fn(|column| expected.map(|map| map[row][column]))
    });
    let [got, expected] = [got, &by_pixel].map(|maps| maps.as_flattened().as_flattened());
    golden.close("layer", got, expected, name);
}

/// An array of four dimensions, by index.
fn array4<const A: usize, const B: usize, const C: usize, const D: usize>(
    at: impl Fn([usize; 4]) -> f32,
) -> [[[[f32; D]; C]; B]; A] {
    use std::array::from_fn;
    from_fn(|a| from_fn(|b| from_fn(|c| from_fn(|d| at([a, b, c, d])))))
}

/// Columns of a GRU's matrix, each divided into its three gates.
fn by_gate<const COLUMNS: usize>(columns: &[[f32; 12]; COLUMNS]) -> [[[f32; 4]; 3]; COLUMNS] {
    columns.map(|column| std::array::from_fn(|gate| fixed(&column[4 * gate..][..4])))
}

#[test]
fn golden_gru() {
    let golden = Golden::read();
    let weight_ih = golden.array("layer.gru.weight_ih");
    let weight_hh = golden.array("layer.gru.weight_hh");
    assert_eq!(weight_ih.shape, [12, 6]);
    assert_eq!(weight_hh.shape, [12, 4]);
    let bias: [f32; 12] = golden.array("layer.gru.bias").fixed();
    let cell = Gru::<6, 4>::new()
        .with_weight_ih(by_gate::<6>(&weight_ih.columns()))
        .with_bias(std::array::from_fn(|gate| fixed(&bias[4 * gate..][..4])))
        .with_weight_hh(by_gate::<4>(&weight_hh.columns()))
        .with_bias_n(golden.array("layer.gru.bias_n").fixed());
    for kind in ["calm", "saturated"] {
        let array = |part: &str| golden.array(&format!("layer.gru.{kind}.{part}"));
        let (inputs, states) = (array("input"), array("states"));
        assert!(inputs.rows().len() > 1);
        let mut state = [0.0; 4];
        for (input, expected) in inputs.rows().zip(states.rows()) {
            state = cell.step(&fixed(input), &state);
            golden.close("layer", &state, expected, &states.name);
        }
    }
}

#[test]
fn golden_crops() {
    let golden = Golden::read();
    let image = golden.array("crop.image");
    let [height, width, 3] = image.shape[..] else {
        panic!("crop.image: {:?}", image.shape);
    };
    let pixels: Vec<u8> = image.values.iter().map(|value| *value as u8).collect();
    let image = RgbImage::new(&pixels, width as u32, height as u32, 3 * width).unwrap();
    let (boxes, outputs) = (golden.array("crop.boxes"), golden.array("crop.output"));
    assert!(boxes.rows().len() > 0);
    for (bounds, expected) in boxes.rows().zip(outputs.rows()) {
        let crop = Crop::from_rgb(&image, &fixed(bounds)).unwrap();
        let got = crop.channels.as_flattened().as_flattened();
        golden.close("crop", got, expected, &format!("crop of {bounds:?}"));
    }
}

#[test]
fn golden_vision() {
    on_both(|golden, model| {
        let crops = golden.array("vision.crops");
        let embeddings = golden.array("vision.embeddings");
        let cosines = golden.array("vision.similarities");
        assert!(crops.rows().len() > 0);
        let expected = embeddings.rows().zip(cosines.rows());
        for (index, (crop, (embedding, cosines))) in crops.rows().zip(expected).enumerate() {
            let got = encode(model, &crop_of(crop));
            golden.close("embedding", &got, embedding, &format!("crop {index}"));
            // From the trainer's embedding, so that errors don't add up.
            let embedding = fixed(embedding);
            let got: Vec<_> = (0..model.concepts.len())
                .map(|concept| similarity(model, &embedding, concept as u8).unwrap())
                .collect();
            golden.close("cosine", &got, cosines, &format!("cosines of crop {index}"));
        }
    });
}

#[test]
fn golden_simulator_and_camera() {
    on_both(|golden, model| {
        let array = |part: &str| golden.array(&format!("simulator.{part}"));
        let (moved, reference) = (array("moved"), array("reference"));
        let (actions, outputs) = (array("action"), array("output"));
        let positions = golden.array("camera.position");
        let camera = camera(&golden.cases["scenes"][0]["camera"]);
        assert!(!actions.values.is_empty());
        let arguments = moved.rows().zip(reference.rows());
        let expected = outputs.rows().zip(positions.rows());
        for ((action, arguments), (output, position)) in
            actions.values.iter().zip(arguments).zip(expected)
        {
            let action = &model.actions[*action as usize];
            let (moved, reference) = (fixed(arguments.0), fixed(arguments.1));
            let got = simulate(model.simulator, action, &moved, &reference);
            golden.close("location", &got, output, action.name);
            let place = camera.locate(model.camera, &fixed(output));
            golden.close("position_m", place.coords.as_slice(), position, "camera");
        }
    });
}

#[test]
fn golden_sentences() {
    on_both(|golden, model| {
        let sentences = golden.cases["sentences"].as_array().expect("sentences");
        assert!(!sentences.is_empty());
        for (number, case) in sentences.iter().enumerate() {
            check_sentence(golden, model, number, case);
        }
    });
}

#[test]
fn golden_padding_changes_nothing() {
    // The trainer pads and core does not: the trainer's logits are the same with and without padding.
    let golden = Golden::read();
    let padded = golden.array("padding.action_logits");
    let exact = golden.array("sentence.0.step.0.action_logits");
    golden.close("logit", &exact.values, &padded.values, "padding");
}

/// Checks that each token has its row of the trainer's embeddings.
fn check_tokens(tokens: &[Token], sentence: &str, case: &Value) {
    let rows = numbers(&case["rows"]);
    let row = |token: &Token| token.embedding().expect("a row of the trainer's") as f64;
    let got: Vec<f64> = tokens.iter().map(row).collect();
    assert_eq!(got, rows, "{sentence}");
}

fn check_sentence(golden: &Golden, model: &Model<'_>, number: usize, case: &Value) {
    let sentence = text(&case["sentence"]);
    let mut reader = Reader::new(sentence).unwrap();
    while reader.advance(model, sentence).unwrap() {}
    let tokens = reader.tokens();
    check_tokens(tokens, sentence, case);

    let mut end = 0;
    for (index, step) in array(&case["steps"]).iter().enumerate() {
        let part = |part: &str| golden.array(&format!("sentence.{number}.step.{index}.{part}"));
        let first = step["first"].as_u64().expect("first") as usize;
        assert_eq!(first, end);
        end = step["end"].as_u64().expect("end") as usize;

        let hazards = part("hazards");
        let mut splitter = Splitter::new();
        let mut decided = None;
        for (offset, expected) in hazards.values.iter().enumerate() {
            let at = first + offset;
            let word = |token: &Token| token.embeddings(model).unwrap().splitter;
            let ahead = tokens[at + 1..].iter().map(word);
            let hazard = splitter.hazard(&model.language, &word(&tokens[at]), ahead);
            golden.close("probability", &[hazard], &[*expected], &hazards.name);
            assert_eq!(hazard > SPLIT_HAZARD, at + 1 == end && end < tokens.len());
            decided = splitter.decide(hazard);
        }
        let split = decided.unwrap_or(splitter.survival());
        let expected = step["split"].as_f64().expect("split") as f32;
        golden.close("probability", &[split], &[expected], "split");

        let tokens = &tokens[first..end];
        let groups = tokens.iter().filter(|token| token.filters().is_some());
        if groups.count() > MAX_GROUPS {
            // More than core encodes; the refusal is checked below.
            continue;
        }
        let encoder = encoded(model, tokens);
        let instruction = encoder.instruction();
        golden.close("state", &instruction, &part("instruction").values, sentence);
        let states = part("states");
        let at_groups = tokens.iter().zip(states.rows());
        let at_groups: Vec<_> = at_groups
            .filter_map(|(token, state)| token.filters().map(|_| state))
            .collect();
        assert_eq!(encoder.groups().len(), at_groups.len());
        for (got, expected) in encoder.groups().iter().zip(at_groups) {
            golden.close("state", got, expected, &states.name);
        }

        let action = choose_action(model.actions, &instruction);
        check_choice(golden, &action, &part("action_logits"));
        let language = &model.language;
        for (decoder, logits) in [
            (language.object_decoder, "object_logits"),
            (language.reference_decoder, "reference_logits"),
        ] {
            let choice = choose_group(&decoder, &instruction, encoder.groups());
            check_choice(golden, &choice, &part(logits));
        }
        let roles = part("role_logits");
        for (group, (state, logits)) in encoder.groups().iter().zip(roles.rows()).enumerate() {
            let is_first = group == 0;
            let choice = choose_role(model, state, is_first);
            let mut logits = logits.to_vec();
            if is_first {
                // Nothing is described before it, which it could restrict.
                let relations = logits.len() / 2;
                logits[1..=relations].fill(f32::NEG_INFINITY);
            }
            check_logits(golden, &choice, &logits, &roles.name);
        }
    }
    assert_eq!(end, tokens.len());
    check_parsed(golden, model, sentence, array(&case["steps"]));
}

/// The whole parser splits the sentence where the trainer does.
fn check_parsed(golden: &Golden, model: &Model<'_>, sentence: &str, steps: &[Value]) {
    let mut task = ParsingTask::new(model, sentence);
    let parsed = loop {
        if let Poll::Ready(parsed) = task.poll() {
            break parsed.cloned();
        }
    };
    match parsed {
        Ok(parsed) => {
            assert_eq!(parsed.decisions().len(), steps.len(), "{sentence}");
            for (decisions, step) in parsed.decisions().iter().zip(steps) {
                let expected = step["split"].as_f64().expect("split") as f32;
                golden.close("probability", &[decisions.split], &[expected], sentence);
                let expected = step["words"].as_f64().expect("words") as f32;
                golden.close("probability", &[decisions.words], &[expected], sentence);
            }
        }
        // The longest sentence may have more steps than a program, or end with words that describe
        // no step.
        Err(refusal) => assert!(
            matches!(
                refusal,
                Refusal::TooManySteps { .. }
                    | Refusal::IncompleteStep { .. }
                    | Refusal::UnclearWords { .. }
                    | Refusal::Unsure { .. }
                    | Refusal::TooManyReferences { .. }
                    | Refusal::SameReference { .. }
            ),
            "{sentence}: {refusal:?}"
        ),
    }
}

fn encoded(model: &Model<'_>, tokens: &[nsrm_core::language::Token]) -> Encoder {
    let mut encoder = Encoder::new();
    let embeddings = |token: &nsrm_core::language::Token| {
        let embeddings = token.embeddings(model).expect("a token of this model");
        (embeddings, token.filters().is_some())
    };
    for token in tokens {
        let (embeddings, group) = embeddings(token);
        assert!(encoder.forward(&model.language, &embeddings.encoder, group));
    }
    for token in tokens.iter().rev() {
        let (embeddings, group) = embeddings(token);
        encoder.backward(&model.language, &embeddings.encoder, group);
    }
    encoder
}

fn check_choice(golden: &Golden, choice: &Choice, logits: &Array) {
    check_logits(golden, choice, &logits.values, &logits.name);
}

/// The same index, and the probability that the trainer's logits give it.
fn check_logits(golden: &Golden, choice: &Choice, logits: &[f32], name: &str) {
    let greatest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let index = logits.iter().position(|logit| *logit == greatest);
    assert_eq!(choice.index(), index, "{name}");
    if index.is_some() {
        let exponentials = logits
            .iter()
            .map(|logit| (f64::from(*logit) - f64::from(greatest)).exp());
        let probability = 1.0 / exponentials.sum::<f64>();
        golden.close(
            "probability",
            &[choice.probability()],
            &[probability as f32],
            name,
        );
    }
}

#[test]
fn golden_relations() {
    on_both(|golden, model| {
        for case in 0..3 {
            let scene = scene(golden, model, case);
            let cosines = golden.array(&format!("scene.{case}.relations"));
            let objects = scene.objects();
            assert_eq!(
                cosines.shape,
                [model.actions.len(), objects.len(), objects.len()]
            );
            let mut expected = cosines.values.iter();
            let (viewpoint, places) = places(model, &scene);
            for (index, action) in (0..).zip(model.actions) {
                for (number, object) in places.iter().enumerate() {
                    for (other, anchor) in places.iter().enumerate() {
                        let expected = *expected.next().expect("a cosine for each pair");
                        let got = relate(model, &viewpoint, index, object, anchor);
                        if number != other {
                            let got = got.expect("a finite cosine");
                            golden.close("relation", &[got], &[expected], action.name);
                        }
                    }
                }
            }
        }
    });
}

/// Where the objects of a scene are, as the training's camera would see them.
fn places<'m>(model: &Model<'m>, scene: &Scene) -> (Viewpoint<'m>, Vec<[f32; LOCATION]>) {
    let viewpoint = Viewpoint::new(model, scene.camera());
    let seen = scene.objects().iter();
    let places = seen.map(|seen| viewpoint.to_training(&seen.location));
    (viewpoint, places.collect())
}

#[test]
fn golden_distances() {
    on_both(|golden, model| {
        for case in 0..3 {
            let (viewpoint, places) = places(model, &scene(golden, model, case));
            let expected = golden.array(&format!("scene.{case}.distances"));
            assert_eq!(expected.shape, [places.len(); 2]);
            for (object, expected) in places.iter().zip(expected.rows()) {
                for (anchor, expected) in places.iter().zip(expected) {
                    let got = distance(model, &viewpoint, object, anchor).expect("finite");
                    golden.close("position_m", &[got], &[*expected], "distances");
                }
            }
        }
    });
}

#[test]
fn golden_directions() {
    on_both(|golden, model| {
        for case in 0..3 {
            let (viewpoint, places) = places(model, &scene(golden, model, case));
            let expected = golden.array(&format!("scene.{case}.directions"));
            assert_eq!(expected.shape, [model.actions.len(), places.len(), 3]);
            for (action, expected) in model.actions.iter().zip(expected.rows()) {
                for (place, expected) in places.iter().zip(expected.chunks_exact(3)) {
                    let got = direction(model, &viewpoint, action, place).expect("finite");
                    golden.close("relation", &got, expected, "directions");
                }
            }
        }
    });
}

#[test]
fn golden_plans() {
    on_both(|golden, model| {
        let plans = array(&golden.cases["plans"]);
        assert!(!plans.is_empty());
        for (number, case) in plans.iter().enumerate() {
            let scene = scene(golden, model, case["scene"].as_u64().expect("scene"));
            let sentence = text(&case["sentence"]);
            let result = Planner::new(model).plan(&scene, sentence);
            if let Some(refused) = case.get("refused") {
                check_refusal(&result.expect_err(sentence), refused);
                continue;
            }
            let plan = result.unwrap_or_else(|refusal| panic!("{sentence}: {refusal}"));
            check_program(model, plan.program(), array(&case["steps"]));
            let part = |part: &str| golden.array(&format!("plan.{number}.{part}"));
            let (locations, positions) = (part("locations"), part("positions"));
            let (object_scores, reference_scores) =
                (part("object_scores"), part("reference_scores"));
            let groundings = object_scores.rows().zip(reference_scores.rows());
            let places = locations.rows().zip(positions.rows());
            let steps = array(&case["steps"]).iter();
            for (((step, expected), scores), (location, position)) in
                plan.steps().iter().zip(steps).zip(groundings).zip(places)
            {
                assert_eq!(expected["object_id"], step.object.object);
                assert_eq!(expected["reference_id"], step.reference.object);
                for (grounding, scores) in [(step.object, scores.0), (step.reference, scores.1)] {
                    let expected = scores[usize::from(grounding.index)];
                    golden.close("cosine", &[grounding.score], &[expected], sentence);
                }
                golden.close("location", &step.location, location, sentence);
                let got = step.sub_goal.pose.translation.vector;
                golden.close("position_m", got.as_slice(), position, sentence);
                let turned = step.sub_goal.pose.rotation.coords;
                assert_eq!(turned.as_slice(), model.header.placed_orientation);
            }
        }
    });
}

fn check_refusal(refusal: &Refusal, expected: &Value) {
    assert_eq!(refusal.kind(), text(&expected["kind"]));
    if let Refusal::Ambiguous { candidates, .. } = refusal {
        let got: Vec<_> = candidates
            .listed()
            .iter()
            .map(|candidate| f64::from(candidate.object))
            .collect();
        assert_eq!(got, numbers(&expected["candidates"]));
    }
}

fn check_program(model: &Model<'_>, program: &Program, expected: &[Value]) {
    assert_eq!(program.steps().len(), expected.len());
    for (step, expected) in program.steps().iter().zip(expected) {
        assert_eq!(
            model.actions[usize::from(step.action)].name,
            expected["action"]
        );
        for (description, names) in [
            (&step.object, &expected["object"]),
            (&step.reference, &expected["reference"]),
        ] {
            let mut got: Vec<_> = description
                .concepts()
                .iter()
                .map(|concept| model.concepts[usize::from(*concept)].name)
                .collect();
            let mut names: Vec<_> = array(names).iter().map(text).collect();
            got.sort_unstable();
            names.sort_unstable();
            assert_eq!(got, names);
        }
    }
}

/// A scene of the golden set, its crops encoded by core.
fn scene(golden: &Golden, model: &Model<'_>, number: u64) -> Scene {
    let case = &golden.cases["scenes"][number as usize];
    let part = |part: &str| golden.array(&format!("scene.{number}.{part}"));
    let (locations, crops, embeddings) = (part("locations"), part("crops"), part("embeddings"));
    let mut scene = RawScene::empty(model, camera(&case["camera"]));
    let seen = crops.rows().zip(embeddings.rows());
    let ids = numbers(&case["ids"]);
    for ((id, location), (crop, embedding)) in ids.iter().zip(locations.rows()).zip(seen) {
        let encoded: [f32; OBJECT_EMBEDDING] = encode(model, &crop_of(crop));
        golden.close("embedding", &encoded, embedding, "crop of a scene");
        let location: [f32; LOCATION] = fixed(location);
        let object = ObservedObject {
            id: *id as u32,
            location,
            embedding: encoded,
        };
        scene.push(object).expect("at most MAX_OBJECTS");
    }
    assert_eq!(scene.count as usize, ids.len());
    Scene::new(scene, model).expect("a scene in order")
}

fn crop_of(values: &[f32]) -> Crop {
    Crop {
        channels: maps(values),
    }
}

/// `[CHANNELS][SIDE][SIDE]` of values in that order.
fn maps<const CHANNELS: usize, const SIDE: usize>(
    values: &[f32],
) -> [[[f32; SIDE]; SIDE]; CHANNELS] {
    assert_eq!(values.len(), CHANNELS * SIDE * SIDE);
    std::array::from_fn(|channel| {
        std::array::from_fn(|row| fixed(&values[(channel * SIDE + row) * SIDE..][..SIDE]))
    })
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

fn array(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}
