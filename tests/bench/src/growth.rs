//! What grows with a domain, a scene and a sentence: the work of a plan with more objects, steps,
//! words or concepts.

use std::hint::black_box;

use nsrm_core::language::Reader;
use nsrm_core::model::{Concept, Embeddings, Word};
use nsrm_core::scene::ObservedObject;
use nsrm_core::{Model, Planner, RawScene, Scene};
use nsrm_tabletop::TABLETOP;

use crate::{EIGHT_STEPS, ONE_STEP, Table};

/// What grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Objects in the scene.
    Objects,
    /// Steps of the sentence.
    Steps,
    /// Tokens of the sentence, which is only parsed.
    Tokens,
    /// Words that the model knows.
    Words,
    /// Attribute values that the model knows.
    Concepts,
}

impl Axis {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Objects,
        Self::Steps,
        Self::Tokens,
        Self::Words,
        Self::Concepts,
    ];

    /// Its name in tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Objects => "objects",
            Self::Steps => "steps",
            Self::Tokens => "tokens",
            Self::Words => "words",
            Self::Concepts => "concepts",
        }
    }

    /// What is measured: numbers of objects, steps, words or concepts; for tokens, of steps.
    pub const fn sizes(self) -> &'static [usize] {
        match self {
            Self::Objects => &[2, 4, 8, 12, 16],
            Self::Steps | Self::Tokens => &[1, 2, 3, 4, 6, 8],
            Self::Words => &[347, 512, 1024, 2048, 4096],
            Self::Concepts => &[9, 32, 64, 128, 256],
        }
    }
}

/// A model, a scene and a sentence of one size.
#[derive(Debug)]
pub struct Subject {
    model: Model<'static>,
    scene: Scene,
    sentence: String,
    parses_only: bool,
    size: usize,
}

impl Subject {
    /// One of [`Axis::sizes`].
    ///
    /// # Panics
    /// If there is no such size.
    pub fn new(axis: Axis, size: usize) -> Self {
        let mut subject = Self {
            model: TABLETOP,
            scene: *Table::new().scene(),
            sentence: ONE_STEP.to_owned(),
            parses_only: false,
            size,
        };
        match axis {
            Axis::Objects => subject.scene = with_objects(&subject.scene, size),
            Axis::Steps => subject.sentence = steps(size),
            Axis::Tokens => {
                subject.sentence = steps(size);
                subject.size = tokens(&subject.sentence);
                subject.parses_only = true;
            }
            Axis::Words => subject.model = with_words(size),
            Axis::Concepts => subject.model = subject.model.with_concepts(concepts(size)),
        }
        subject
    }

    /// The number of objects, steps, tokens, words or concepts.
    pub const fn size(&self) -> usize {
        self.size
    }

    /// Plans the sentence, or parses it, once.
    ///
    /// # Panics
    /// If it is refused.
    #[inline(never)]
    pub fn run(&self) {
        let planner = Planner::new(black_box(&self.model));
        if self.parses_only {
            black_box(planner.parse(black_box(&self.sentence)).expect("a program"));
        } else {
            let plan = planner.plan(black_box(&self.scene), black_box(&self.sentence));
            black_box(plan.expect("a plan"));
        }
    }
}

/// The scene with copies of an object that the sentence does not name, or without such objects.
fn with_objects(scene: &Scene, count: usize) -> Scene {
    let named = |object: &&ObservedObject| {
        let plan = Planner::new(&TABLETOP)
            .plan(scene, ONE_STEP)
            .expect("a plan");
        let step = plan.steps()[0];
        [step.object.object, step.reference.object].contains(&object.id)
    };
    let (needed, others): (Vec<&ObservedObject>, Vec<&ObservedObject>) =
        scene.objects().iter().partition(named);
    let mut raw = RawScene::empty(&TABLETOP, *scene.camera());
    let copies = needed.into_iter().chain(others.into_iter().cycle());
    for (id, object) in (1..).zip(copies.take(count)) {
        let copy = ObservedObject { id, ..*object };
        raw.push(copy).expect("room for an object");
    }
    Scene::new(raw, &TABLETOP).expect("a scene in order")
}

/// The first steps of [`EIGHT_STEPS`].
fn steps(count: usize) -> String {
    let steps: Vec<&str> = EIGHT_STEPS.split(", then ").collect();
    steps[..count].join(", then ")
}

fn tokens(sentence: &str) -> usize {
    let mut reader = Reader::new(sentence).expect("a sentence");
    while reader.advance(&TABLETOP, sentence).expect("known words") {}
    reader.tokens().len()
}

/// The model with other words behind its own, that no sentence has.
fn with_words(count: usize) -> Model<'static> {
    let Embeddings::F32(rows) = TABLETOP.embeddings else {
        panic!("the model's precision is f32");
    };
    let (mut words, mut rows) = (TABLETOP.words.to_vec(), rows.to_vec());
    let like = rows[1];
    let others = (words.len()..count).map(|number| format!("~{number:04}").leak());
    words.extend(
        others
            .map(|text| Word::new().with_text(text))
            .collect::<Vec<_>>(),
    );
    rows.resize(words.len() + 1, like);
    TABLETOP
        .with_words(words.leak())
        .with_embeddings(Embeddings::F32(rows.leak()))
}

/// The model's concepts, and others that no sentence has.
fn concepts(count: usize) -> &'static [Concept<'static>] {
    let mut concepts = TABLETOP.concepts.to_vec();
    let like = concepts[0];
    let others = (concepts.len()..count).map(|number| like.with_name(format!("c{number}").leak()));
    concepts.extend(others.collect::<Vec<_>>());
    concepts.leak()
}
