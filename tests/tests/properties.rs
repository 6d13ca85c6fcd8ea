//! Any sentence, any scene: a plan of finite poses or a typed refusal, never a
//! panic. With the pretrained model and the one made by hand, each also with other thresholds, so
//! that it continues where it would refuse.

use nsrm_core::model::{LOCATION, OBJECT_EMBEDDING};
use nsrm_core::scene::{ObservedObject, SceneHeader};
use nsrm_core::{Camera, MAX_OBJECTS, Model, Plan, Planner, RawScene, Refusal, Scene};
use nsrm_tabletop::TABLETOP;
use nsrm_tests::by_hand::{Block, DEPTH_M, Parts, embedding};
use nsrm_tests::picture;
use nsrm_tests::plans::{check_in, reckless};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// Plans; what comes of it must be in order.
fn plan(model: &Model<'_>, scene: &Scene, sentence: &str) -> Result<Plan, Refusal> {
    let result = Planner::new(model).plan(scene, sentence);
    match &result {
        Ok(plan) => check_in(model, scene, plan),
        Err(refusal) => {
            assert!(!matches!(refusal, Refusal::InvalidModel));
            assert!(!refusal.in_context(model, sentence).to_string().is_empty());
        }
    }
    result
}

/// On all models, in scenes of objects with these embeddings.
fn plan_on_all(sentence: &str, embeddings: &[[f32; OBJECT_EMBEDDING]], match_score: f32) {
    let parts = Parts::new();
    for model in [
        parts.model(),
        reckless(parts.model(), match_score),
        TABLETOP,
        reckless(TABLETOP, match_score),
    ] {
        let scene = row(&model, embeddings);
        let _ = plan(&model, &scene, sentence);
    }
}

/// Objects in a row, on the table by all models' account: as wide as a small block, and seen
/// from above.
fn row(model: &Model<'_>, embeddings: &[[f32; OBJECT_EMBEDDING]]) -> Scene {
    let mut scene = RawScene::empty(model, picture::camera());
    for (id, embedding) in (1..).zip(embeddings) {
        let left = 0.3 + 0.04 * id as f32;
        let object = ObservedObject {
            id,
            location: [left, 0.48, left + 0.04, 0.52, DEPTH_M],
            embedding: *embedding,
        };
        scene.push(object).expect("at most MAX_OBJECTS");
    }
    Scene::new(scene, model).expect("a scene in order")
}

/// Every word that a model knows, and some that none does.
fn vocabulary() -> Vec<&'static str> {
    let mut words: Vec<_> = TABLETOP.words.iter().map(|word| word.text).collect();
    words.extend(TABLETOP.lexicon.iter().map(|entry| entry.text));
    words.extend(["it", "maybe", "beside", ",", ".", "!", "crimson", "PUT"]);
    words
}

fn any_block() -> impl Strategy<Value = Block> {
    let colors = select(vec!["red", "green", "blue"]);
    (colors, select(vec!["small", "lego"])).prop_map(|(color, size)| Block { color, size })
}

fn embeddings(
    number: std::ops::Range<usize>,
) -> impl Strategy<Value = Vec<[f32; OBJECT_EMBEDDING]>> {
    let of_blocks = any_block().prop_map(|block| embedding(&block));
    let of_anything = vec(-3.0_f32..3.0, OBJECT_EMBEDDING)
        .prop_map(|values| values.try_into().expect("the length asked for"));
    vec(prop_oneof![of_blocks, of_anything], number)
}

/// Any `f32`: every bit pattern, with the troublesome ones often.
fn any_number() -> impl Strategy<Value = f32> {
    let awkward = select(vec![
        0.0,
        -0.0,
        1.0,
        0.5,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN_POSITIVE,
    ]);
    prop_oneof![awkward, any::<u32>().prop_map(f32::from_bits)]
}

/// A number that may pass a check, often.
fn number_near(range: std::ops::Range<f32>) -> impl Strategy<Value = f32> {
    prop_oneof![9 => range, 1 => any_number()]
}

fn any_camera() -> impl Strategy<Value = Camera> {
    let numbers = (
        vec(number_near(1.0..2000.0), 4),
        vec(number_near(-2.0..2.0), 3),
        prop_oneof![
            4 => Just(vec![1.0, 0.0, 0.0, 0.0]),
            1 => vec(any_number(), 4)
        ],
    );
    (any::<[u32; 2]>(), numbers).prop_map(|([width, height], (lens, position, orientation))| {
        Camera {
            width,
            height,
            fx: lens[0],
            fy: lens[1],
            cx: lens[2],
            cy: lens[3],
            position: position.try_into().expect("three"),
            orientation: orientation.try_into().expect("four"),
        }
    })
}

fn any_object() -> impl Strategy<Value = ObservedObject> {
    let memory = || number_near(0.0..0.5);
    let far_corner = || number_near(0.5..1.0);
    let location = (
        memory(),
        memory(),
        far_corner(),
        far_corner(),
        number_near(0.1..3.0),
    )
        .prop_map(|(x1, y1, x2, y2, depth)| -> [f32; LOCATION] { [x1, y1, x2, y2, depth] });
    let finite = vec(-3.0_f32..3.0, OBJECT_EMBEDDING);
    let embedding = prop_oneof![9 => finite, 1 => vec(any_number(), OBJECT_EMBEDDING)]
        .prop_map(|values| values.try_into().expect("the length asked for"));
    (any::<u32>(), location, embedding).prop_map(|(id, location, embedding)| ObservedObject {
        id,
        location,
        embedding,
    })
}

fn any_scene() -> impl Strategy<Value = RawScene> {
    let tag = TABLETOP.tag();
    let header = (
        prop_oneof![9 => Just(1), 1 => any::<u32>()],
        prop_oneof![9 => Just(0), 1 => any::<u32>()],
        prop_oneof![9 => Just(tag), 1 => any::<u64>()],
        any::<[u64; 2]>(),
    )
        .prop_map(
            |(schema, frame, model_tag, [sequence, timestamp_ns])| SceneHeader {
                schema,
                frame,
                model_tag,
                sequence,
                timestamp_ns,
            },
        );
    let count = prop_oneof![9 => 0..=MAX_OBJECTS as u32, 1 => any::<u32>()];
    let objects = vec(any_object(), MAX_OBJECTS);
    (header, any_camera(), count, objects).prop_map(|(header, camera, count, objects)| RawScene {
        header,
        camera,
        count,
        objects: objects.try_into().expect("MAX_OBJECTS"),
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_planned_or_refused(
        sentence in any::<String>(),
        embeddings in embeddings(0..4),
        match_score in 0.0_f32..1.0,
    ) {
        plan_on_all(&sentence, &embeddings, match_score);
    }

    #[test]
    fn known_words_with_anything_between_them_are_planned_or_refused(
        parts in vec((select(vocabulary()), "[ \t,;.]{0,2}|\\PC{0,2}"), 0..24),
        embeddings in embeddings(0..6),
        match_score in 0.0_f32..1.0,
    ) {
        let mut sentence = String::new();
        for (word, between) in parts {
            sentence += word;
            sentence += &between;
        }
        plan_on_all(&sentence, &embeddings, match_score);
    }

    #[test]
    fn any_scene_is_checked_and_what_passes_can_be_planned_in(
        raw in any_scene(),
        words in vec(select(vocabulary()), 6..14),
        match_score in 0.0_f32..1.0,
    ) {
        let Ok(scene) = Scene::new(raw, &TABLETOP) else {
            return Ok(());
        };
        let sentence = words.join(" ");
        let _ = plan(&TABLETOP, &scene, &sentence);
        let _ = plan(&reckless(TABLETOP, match_score), &scene, &sentence);
    }

    #[test]
    fn a_scene_of_bytes_alone_is_never_trusted(
        numbers in vec(any_number(), 32),
        count in any::<u32>(),
        places in vec(any::<Index>(), 64),
    ) {
        let pick = |place: usize| *places[place % 64].get(&numbers);
        let object = |seed: usize| ObservedObject {
            id: pick(seed).to_bits(),
            location: std::array::from_fn(|place| pick(seed + place)),
            embedding: std::array::from_fn(|place| pick(seed + 7 * place)),
        };
        let raw = RawScene {
            header: SceneHeader { model_tag: TABLETOP.tag(), schema: 1, ..Default::default() },
            camera: picture::camera(),
            count: count % 20,
            objects: std::array::from_fn(object),
        };
        if let Ok(scene) = Scene::new(raw, &TABLETOP) {
            let _ = plan(&reckless(TABLETOP, 0.5), &scene, "put the red block on the blue block");
        }
    }
}

proptest! {
    // Long ones, fewer.
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn long_sentences_of_known_words_are_planned_or_refused(
        words in vec(select(vocabulary()), 60..200),
        embeddings in embeddings(MAX_OBJECTS - 1..MAX_OBJECTS + 1),
        match_score in 0.0_f32..1.0,
    ) {
        plan_on_all(&words.join(" "), &embeddings, match_score);
    }
}

/// The properties above would hold of a planner that refuses everything.
#[test]
fn what_makes_sense_is_planned() {
    let parts = Parts::new();
    let model = parts.model();
    let blocks =
        [("red", "small"), ("blue", "lego")].map(|(color, size)| embedding(&Block { color, size }));
    let scene = row(&model, &blocks);
    for sentence in [
        "put the red block beside the lego block",
        "  PUT  the small red, block ON blue!",
    ] {
        let planned = plan(&model, &scene, sentence);
        assert!(planned.is_ok(), "{planned:?}");
    }
}
