//! A model small enough to be worked out by hand, for the tests.
//!
//! It knows colours (red, green; from the colour view) and sizes (lego, small;
//! from the brightness view): element 0 or 1 of a view is the cosine's direction.
//! `on` and `right` tell what stands before them from what stands behind them;
//! `right` makes the action `MoveRight`; the steps part in front of `then`.
//!
//! [`related`] also knows relations in descriptions: what stands before `above` or `beside` is on, or
//! to the right of, what stands behind; `past` stands for what is to the right of it. So are `closest`
//! and `furthest`; `around` stands for what is nearest to it.

use core::task::Poll;
use std::boxed::Box;
use std::string::{String, ToString};
use std::vec::Vec;

use crate::camera::Camera;
use crate::dsl::{Filters, Property};
use crate::language::ParsingTask;
use crate::model::*;
use crate::nn::{Cell, Dense, Gru, Linear, MergeConv, PatchConv};
use crate::refusal::Refusal;
use crate::scene::{ObservedObject, RawScene, Scene};

pub(crate) const RED: usize = 0;
pub(crate) const GREEN: usize = 1;
pub(crate) const LEGO: usize = 0;
pub(crate) const SMALL: usize = 1;

/// Edge length of all objects, metres.
pub(crate) const EDGE_M: f32 = 0.0625;
/// An update gate that is open or shut.
const SHUT: f32 = -20.0;
const OPEN: f32 = 20.0;
/// The encoder's unit that a relation sets.
const RELATION: usize = 1;
/// The encoder's unit that `right` sets.
const RIGHT: usize = 3;
/// Elements of an embedding, each for one word.
const ON: usize = 0;
const TO_RIGHT: usize = 1;
const NEAR: usize = 2;
const NOT: usize = 3;
/// Words that only [`related`] knows, and the encoder's units that they set.
const ABOVE: (usize, usize) = (4, 5);
const BESIDE: (usize, usize) = (5, 6);
const PAST: (usize, usize) = (6, 7);
/// Half of [`BESIDE`].
const ROUGHLY: (usize, usize) = (7, 6);
const CLOSEST: (usize, usize) = (8, 8);
const FURTHEST: (usize, usize) = (9, 9);
const AROUND: (usize, usize) = (10, 10);

pub(crate) fn linear<const INPUT: usize, const OUTPUT: usize>() -> Linear<INPUT, OUTPUT> {
    Linear {
        weight: [[0.0; OUTPUT]; INPUT],
        bias: [0.0; OUTPUT],
    }
}

pub(crate) fn dense<const INPUT: usize, const OUTPUT: usize>(
    layer: Linear<INPUT, OUTPUT>,
) -> Dense<'static, INPUT, OUTPUT> {
    Dense::F32(Box::leak(Box::new(layer)))
}

fn identity<const INPUT: usize, const OUTPUT: usize>() -> Linear<INPUT, OUTPUT> {
    let mut layer = linear();
    for index in 0..INPUT.min(OUTPUT) {
        layer.weight[index][index] = 1.0;
    }
    layer
}

/// A cell that keeps its state, whatever the word.
fn gru<const INPUT: usize, const HIDDEN: usize>() -> Gru<INPUT, HIDDEN> {
    Gru {
        weight_ih: [[[0.0; HIDDEN]; 3]; INPUT],
        bias: [[0.0; HIDDEN], [OPEN; HIDDEN], [0.0; HIDDEN]],
        weight_hh: [[[0.0; HIDDEN]; 3]; HIDDEN],
        bias_n: [0.0; HIDDEN],
    }
}

fn view_encoder<const CHANNELS: usize>() -> ViewEncoder<'static, CHANNELS> {
    ViewEncoder {
        patch: PatchConv {
            weight: [[[[0.0; PATCH_CHANNELS]; 4]; 4]; CHANNELS],
            bias: [0.0; PATCH_CHANNELS],
        },
        merge: MergeConv {
            weight: [[[[0.0; MERGE_CHANNELS]; PATCH_CHANNELS]; 2]; 2],
            bias: [0.0; MERGE_CHANNELS],
        },
        dense: dense(linear()),
    }
}

/// A word that leaves every state as it is.
fn word() -> WordEmbeddings {
    WordEmbeddings {
        encoder: [0.0; WORD],
        splitter: [0.0; SPLITTER_WORD],
    }
}

/// A word with a 1 at an element of its embedding, which the encoder's cells know.
fn meaning(element: usize) -> WordEmbeddings {
    let mut word = word();
    word.encoder[element] = 1.0;
    word
}

/// Lets a cell set a unit to about `value`, −1 to 1, whatever it was, at a word with this element.
fn set(cell: &mut Gru<WORD, ENCODER_HIDDEN>, element: usize, unit: usize, value: f32) {
    cell.weight_ih[element][1][unit] = SHUT - OPEN;
    cell.weight_ih[element][2][unit] = OPEN * value;
}

/// Words with their embeddings.
fn words() -> Vec<(&'static str, WordEmbeddings)> {
    let mut then = word();
    then.splitter[0] = 1.0;
    // A hazard of σ(0.04): just enough to split, not enough to be sure.
    let mut perhaps = word();
    perhaps.splitter[0] = 0.552_3 / OPEN;
    [
        (",", word()),
        ("near", meaning(NEAR)),
        ("not", meaning(NOT)),
        ("on", meaning(ON)),
        ("perhaps", perhaps),
        ("put", word()),
        ("right", meaning(TO_RIGHT)),
        ("the", word()),
        ("then", then),
    ]
    .into()
}

/// Sorts words, and separates their embeddings, behind the group's.
fn separated(
    mut words: Vec<(&'static str, WordEmbeddings)>,
) -> (&'static [Word<'static>], Embeddings<'static>) {
    words.sort_by_key(|(text, _)| *text);
    words.insert(0, ("", word()));
    let (texts, embeddings): (Vec<_>, Vec<_>) = words.into_iter().unzip();
    let words: Vec<_> = texts
        .into_iter()
        .skip(1)
        .map(|text| Word { text })
        .collect();
    (words.leak(), Embeddings::F32(embeddings.leak()))
}

fn language() -> Language<'static> {
    let mut forward = gru();
    let mut backward = gru();
    for element in [ON, TO_RIGHT, NEAR] {
        set(&mut forward, element, RELATION, 1.0);
        set(&mut backward, element, RELATION, 1.0);
    }
    set(&mut forward, ON, RIGHT, 0.0);
    set(&mut forward, TO_RIGHT, RIGHT, 1.0);
    // Something between on and right.
    set(&mut forward, NEAR, RIGHT, 1.0);
    forward.weight_ih[NEAR][2][RIGHT] = 0.549_306_15; // atanh(0.5)
    // Takes back that a relation stood before.
    set(&mut forward, NOT, RELATION, 0.0);
    let mut object_decoder = linear();
    object_decoder.bias[ENCODER_HIDDEN + RELATION] = 10.0;
    let mut reference_decoder = linear();
    reference_decoder.bias[RELATION] = 10.0;
    // Every word is acceptable.
    let mut acceptability = linear();
    acceptability.bias = [20.0];
    let mut hazard_hidden = linear();
    hazard_hidden.weight[SPLITTER_HIDDEN][0] = OPEN;
    let mut hazard = linear();
    hazard.weight[0] = [20.0];
    hazard.bias = [-10.0];
    Language {
        forward: Cell::F32(Box::leak(Box::new(forward))),
        backward: Cell::F32(Box::leak(Box::new(backward))),
        object_decoder: dense(object_decoder),
        reference_decoder: dense(reference_decoder),
        acceptability_hidden: dense(linear()),
        acceptability: Box::leak(Box::new(acceptability)),
        nearest: Box::leak(Box::new(superlative())),
        farthest: Box::leak(Box::new(superlative())),
        splitter: Cell::F32(Box::leak(Box::new(Gru {
            bias: [[0.0; SPLITTER_HIDDEN]; 3],
            ..gru()
        }))),
        hazard_hidden: dense(hazard_hidden),
        hazard: Box::leak(Box::new(hazard)),
    }
}

/// One that the model was not taught.
const fn superlative() -> Superlative {
    Superlative {
        decoder: [[0.0; INSTRUCTION]; 2],
        bias: [-20.0; 2],
    }
}

fn attribute(name: &'static str, view: View) -> Attribute<'static> {
    Attribute {
        name,
        view,
        hidden: identity(),
        output: identity(),
    }
}

fn concept(name: &'static str, attribute: u8, direction: usize) -> Concept<'static> {
    let mut embedding = [0.0; CONCEPT];
    embedding[direction] = 1.0;
    Concept {
        name,
        attribute,
        embedding,
        edges_m: (attribute == 1).then_some([EDGE_M; 3]),
    }
}

fn actions() -> &'static [Action<'static>] {
    let mut on = Action {
        name: "MoveOn",
        phrase: "on",
        extreme: Some("topmost"),
        decoder: [0.0; INSTRUCTION],
        decoder_bias: 10.0,
        relation_decoder: [[0.0; INSTRUCTION]; 2],
        relation_bias: [-20.0; 2],
        simulator_bias: [0.0; SIMULATOR_HIDDEN],
    };
    let mut right = on;
    (right.name, right.phrase) = ("MoveRight", "to the right of");
    right.extreme = Some("rightmost");
    right.decoder[RIGHT] = 20.0;
    right.decoder_bias = 0.0;
    on.simulator_bias[0] = 20.0;
    right.simulator_bias[1] = 20.0;
    Box::leak(Box::new([on, right]))
}

/// `MoveOn` moves the centre up by 0.0625 of the image's height, `MoveRight` right
/// by 0.125 of its width.
fn simulator() -> Simulator<'static> {
    let mut hidden = linear();
    let mut output = linear();
    for unit in 0..2 {
        hidden.weight[unit][unit] = 20.0;
    }
    output.weight[0][1] = -0.0625;
    output.weight[1][0] = 0.125;
    Simulator {
        input: [[0.0; SIMULATOR_HIDDEN]; 2 * LOCATION],
        hidden: dense(hidden),
        output,
    }
}

pub(crate) fn model() -> Model<'static> {
    let mut identity = [0; 32];
    identity[0] = 7;
    identity[7] = 1;
    use crate::dsl::Extreme::{Action, Largest, Smallest};
    use Property::{Concept, Extreme, Quantifier};
    let lexicon = [
        ("all", Quantifier(crate::dsl::Quantifier::All)),
        ("both", Quantifier(crate::dsl::Quantifier::Both)),
        ("green", Concept(1)),
        ("largest", Extreme(Largest)),
        ("lego", Concept(2)),
        ("red", Concept(0)),
        ("rightmost", Extreme(Action(1))),
        ("small", Concept(3)),
        ("smallest", Extreme(Smallest)),
        ("topmost", Extreme(Action(0))),
    ];
    let (words, embeddings) = separated(words());
    Model {
        header: Header {
            domain: "fixture",
            identity,
            thresholds: Thresholds {
                match_score: 0.6,
                decision: 0.6,
                confidence: 0.0,
            },
            work_space: WorkSpace {
                min: [0.0, -0.5, 0.0],
                max: [1.0, 0.5, 0.6],
            },
            placed_orientation: [0.0, 0.0, 0.0, 1.0],
            training_camera: camera(),
        },
        words,
        embeddings,
        pronouns: &[],
        placing: &[],
        conjunctions: &[],
        several: Several::new(),
        rephrasing: Rephrasing::new(),
        simplification: Simplification::new(),
        perspectives: Perspectives::new(),
        exceptions: Exceptions::new(),
        lists: Lists::new(),
        repairs: Repairs::new(),
        sequence: Sequence::new(),
        distances: Distances::new(),
        apart: Apart::new(),
        ordinals: Ordinals::new(),
        arrangements: Arrangements::new(),
        table: Table::new(),
        spelling: Spelling::new(),
        lexicon: Box::leak(Box::new(
            lexicon.map(|(text, property)| LexiconEntry { text, property }),
        )),
        attributes: Box::leak(Box::new([
            attribute("color", View::Color),
            attribute("size", View::Brightness),
        ])),
        concepts: Box::leak(Box::new([
            concept("red", 0, RED),
            concept("green", 0, GREEN),
            concept("lego", 1, LEGO),
            concept("small", 1, SMALL),
        ])),
        actions: actions(),
        compounds: Compounds::new(),
        language: language(),
        vision: Some(Vision {
            color: Box::leak(Box::new(view_encoder())),
            brightness: Box::leak(Box::new(view_encoder())),
        }),
        simulator: Box::leak(Box::new(simulator())),
        camera: Box::leak(Box::new(PixelToCamera {
            weight: [
                [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            ],
        })),
    }
}

/// The same, taught relations in descriptions.
pub(crate) fn related() -> Model<'static> {
    let mut model = model();
    let own = [
        ("above", ABOVE),
        ("beside", BESIDE),
        ("past", PAST),
        ("roughly", ROUGHLY),
        ("closest", CLOSEST),
        ("furthest", FURTHEST),
        ("around", AROUND),
    ];
    let mut words = words();
    let mut forward = *model.language.forward.as_f32().unwrap();
    for (text, (element, unit)) in own {
        words.push((text, meaning(element)));
        // One at a time, up to the next action.
        for (_, (_, other)) in own {
            set(&mut forward, element, other, 0.0);
        }
        set(&mut forward, element, unit, 1.0);
        for action in [ON, TO_RIGHT] {
            set(&mut forward, action, unit, 0.0);
        }
    }
    forward.weight_ih[ROUGHLY.0][2][ROUGHLY.1] = 0.549_306_15; // atanh(0.5)
    let mut actions = [model.actions[0], model.actions[1]];
    actions[0].relation_decoder[0][ABOVE.1] = 40.0;
    actions[1].relation_decoder[0][BESIDE.1] = 40.0;
    actions[1].relation_decoder[1][PAST.1] = 40.0;
    let [mut nearest, mut farthest] = [superlative(); 2];
    nearest.decoder[0][CLOSEST.1] = 40.0;
    farthest.decoder[0][FURTHEST.1] = 40.0;
    nearest.decoder[1][AROUND.1] = 40.0;
    model.language.nearest = Box::leak(Box::new(nearest));
    model.language.farthest = Box::leak(Box::new(farthest));
    (model.words, model.embeddings) = separated(words);
    model.actions = Box::leak(Box::new(actions));
    model.language.forward = Cell::F32(Box::leak(Box::new(forward)));
    model
}

/// [`related`] with a table: "desk", "off", "down from", "from", "remove" and "down"; what stands there is sought to the right
/// of other objects.
pub(crate) fn with_table() -> Model<'static> {
    let model = related();
    let mut lexicon = model.lexicon.to_vec();
    let desk = LexiconEntry {
        text: "desk",
        property: Property::Table,
    };
    lexicon.push(desk);
    lexicon.sort_by_key(|entry| entry.text);
    let table = Table {
        action: 0,
        sides: &[1],
        off: &["down from", "near", "off"],
        sources: &["from"],
        unless: &["perhaps"],
        removing: &["remove"],
        taking: "put",
        standing: "above",
        order: "on the",
        down: &["down"],
        relation: "on",
    };
    let ends = Arrangements::new().with_ends(&["then"]);
    let model = model.with_lexicon(lexicon.leak()).with_table(table);
    let model = model.with_arrangements(ends);
    assert_eq!(model.check(), Ok(()));
    model
}

/// [`related`] that counts: "second" and the known word "perhaps" as 2, "third" as 3, "first" as 1; "from
/// right" and "from the far right" from the right, "nearby right" as the first from there, and "from above" from
/// the topmost.
pub(crate) fn with_ordinals() -> Model<'static> {
    use crate::dsl::Extreme::{Action, Largest};
    let ranked = [
        ("second rightmost", Action(1), 2),
        ("third rightmost", Action(1), 3),
        ("second topmost", Action(0), 2),
        ("second largest", Largest, 2),
    ];
    let ranked = ranked.map(|(name, extreme, rank)| Ranked {
        name,
        extreme,
        rank,
    });
    let counts = [("first", 1), ("perhaps", 2), ("second", 2), ("third", 3)];
    let counts = counts.map(|(text, rank)| Count { text, rank });
    let from = [
        ("from above", Action(0), false),
        ("from right", Action(1), false),
        ("from the far right", Action(1), false),
        ("nearby right", Action(1), true),
        ("right", Action(1), false),
    ];
    let from = from.map(|(text, extreme, is_first)| CountedFrom {
        text,
        extreme,
        is_first,
    });
    let ordinals = Ordinals::new()
        .with_ranked(Box::leak(Box::new(ranked)))
        .with_counts(Box::leak(Box::new(counts)))
        .with_from(Box::leak(Box::new(from)))
        .with_first_words(&["nearby"])
        .with_articles(&["the"])
        .with_nouns(&[",", "near"])
        .with_unless(&["of"]);
    let apart = Apart::new().with_phrases(&["whose is"]);
    let model = related().with_ordinals(ordinals).with_apart(apart);
    assert_eq!(model.check(), Ok(()));
    model
}

/// [`with_table`] that leaves objects out: by "except" and "except for", and "that isn't" of what they are not; "near" is
/// a noun, with a plural.
pub(crate) fn with_exceptions() -> Model<'static> {
    let model = with_table();
    let near = model.words.iter().position(|word| word.text == "near");
    let plural = Plural {
        text: "nears",
        word: u16::try_from(near.unwrap()).unwrap(),
    };
    let ordinals = Ordinals::new()
        .with_articles(&["the"])
        .with_nouns(&["near"]);
    let several = Several::new().with_plurals(Box::leak(Box::new([plural])));
    let exceptions = Exceptions::new()
        .with_phrases(&["except", "except for"])
        .with_negations(&["that isn't"]);
    let model = model.with_exceptions(exceptions);
    let model = model.with_ordinals(ordinals).with_several(several);
    assert_eq!(model.check(), Ok(()));
    model
}

/// [`with_table`] with compounds: "by", "close to" and the known word "past" put to the right, or where "on" does, and
/// "diagonally" does both; "by the" and "what is by" are relations.
pub(crate) fn with_compounds() -> Model<'static> {
    let model = with_table();
    let of = |name, kind, read| Compound {
        name,
        phrase: name,
        kind,
        parts: &[1, 0],
        read,
    };
    let compounds = [
        of("NextTo", CompoundKind::Any, "right"),
        of("RightOn", CompoundKind::All, "the right"),
        of("IsNextTo", CompoundKind::Any, "beside"),
        of("StandsFor", CompoundKind::All, "past"),
    ];
    let said = [
        ("by", 0),
        ("by the", 2),
        ("close to", 0),
        ("diagonally", 1),
        ("past", 0),
        ("what is by", 3),
    ];
    let said = said.map(|(text, compound)| CompoundText { text, compound });
    let compounds = Compounds::new()
        .with_compounds(Box::leak(Box::new(compounds)))
        .with_said(Box::leak(Box::new(said)))
        .with_first_words(&["by", "close", "diagonally", "past", "what"])
        .with_sides(&["leftwards", "perhaps"]);
    let model = model.with_compounds(compounds);
    assert_eq!(model.check(), Ok(()));
    model
}

/// [`with_distances`], in which "amid" puts between two, or is a relation behind "the": "amid green and lego".
pub(crate) fn with_between() -> Model<'static> {
    let mut model = with_distances();
    let of = |name| Compound {
        name,
        phrase: "between",
        kind: CompoundKind::Between,
        parts: &[1],
        read: if name == "Amid" { "right" } else { "beside" },
    };
    let compounds = model.compounds.compounds.iter().copied();
    let compounds: Vec<_> = compounds.chain([of("Amid"), of("IsAmid")]).collect();
    let said = [("amid", 4), ("amidst", 5)].map(|(text, compound)| CompoundText { text, compound });
    let said: Vec<_> = said
        .into_iter()
        .chain(model.compounds.said.iter().copied())
        .collect();
    let first_words = ["amid", "amidst"].into_iter();
    let first_words: Vec<_> = first_words
        .chain(model.compounds.first_words.iter().copied())
        .collect();
    model.compounds = model
        .compounds
        .with_compounds(Box::leak(compounds.into()))
        .with_said(Box::leak(said.into()))
        .with_first_words(Box::leak(first_words.into()));
    model.lists = Lists::new().with_between(&["and"]).with_next("then");
    model.ordinals = Ordinals::new().with_articles(&["the"]);
    assert_eq!(model.check(), Ok(()));
    model
}

/// [`with_compounds`], with distances beside what is put.
pub(crate) fn with_distances() -> Model<'static> {
    let units = [("cm", 10.0), ("inches", 25.4), ("mm", 1.0)];
    let units = units.map(|(text, mm)| DistanceUnit { text, mm });
    let numbers = [
        ("a", 1.0),
        ("half a", 0.5),
        ("one and a half", 1.5),
        ("two", 2.0),
    ];
    let numbers = numbers.map(|(text, value)| DistanceNumber { text, value });
    let shifts = ["right", "to the right"].map(|text| DistanceShift { text, action: 1 });
    let distances = Distances::new()
        .with_sides(&[1])
        .with_units(Box::leak(Box::new(units)))
        .with_numbers(Box::leak(Box::new(numbers)))
        .with_before(&["about", "at a distance of", "by"])
        .with_behind(&["away"])
        .with_from(&["away from", "from"])
        .with_beside("past")
        .with_unless(&["the"])
        .with_shifts(Box::leak(Box::new(shifts)))
        .with_origins(&["from there"])
        .with_usual_mm(20);
    let mut model = with_compounds().with_distances(distances);
    let [on, right] = model.actions else {
        panic!("two actions");
    };
    let right = Action {
        phrase: "right",
        ..*right
    };
    model.actions = Box::leak(Box::new([*on, right]));
    assert_eq!(model.check(), Ok(()));
    model
}

/// Looks straight down from above (0.5, 0, 0): image right is the world's −y, image down
/// its −x. At a depth of 0.5 m the image is 0.5 m wide and high, and there is the centre of
/// what stands on the table.
pub(crate) fn camera() -> Camera {
    let half = core::f32::consts::FRAC_1_SQRT_2;
    Camera {
        width: 400,
        height: 200,
        fx: 400.0,
        fy: 200.0,
        cx: 200.0,
        cy: 100.0,
        position: [0.5, 0.0, 0.5 + EDGE_M / 2.0],
        orientation: [half, -half, 0.0, 0.0],
    }
}

/// An object with its box around (`x`, `y`), at 0.5 m.
pub(crate) fn object(id: u32, color: usize, size: usize, x: f32, y: f32) -> ObservedObject {
    let mut object = ObservedObject {
        id,
        location: [x - 0.0625, y - 0.0625, x + 0.0625, y + 0.0625, 0.5],
        ..ObservedObject::EMPTY
    };
    object.embedding[color] = 2.0;
    object.embedding[VIEW_EMBEDDING + size] = 0.5;
    object
}

pub(crate) fn raw_scene(model: &Model<'_>, objects: &[ObservedObject]) -> RawScene {
    let mut raw = RawScene::empty(model, camera());
    for object in objects {
        raw.push(*object).unwrap();
    }
    raw
}

/// 11: small red, 12: small green, 13: lego red.
pub(crate) fn scene(model: &Model<'_>) -> Scene {
    let objects = [
        object(11, RED, SMALL, 0.25, 0.5),
        object(12, GREEN, SMALL, 0.5, 0.25),
        object(13, RED, LEGO, 0.75, 0.75),
    ];
    Scene::new(raw_scene(model, &objects), model).unwrap()
}

/// The filters of one group.
pub(crate) fn filters(concepts: &[u8]) -> Filters {
    let mut filters = Filters::new();
    for &concept in concepts {
        filters.push(concept).expect("a place");
    }
    filters
}

/// The program of a sentence in the paper's notation.
pub(crate) fn parse(model: &Model<'_>, sentence: &str) -> Result<String, Refusal> {
    let mut task = ParsingTask::new(model, sentence);
    loop {
        if let Poll::Ready(result) = task.poll() {
            return result.map(|parsed| parsed.program().notation(model).to_string());
        }
    }
}

/// The same, or the kind of its refusal.
pub(crate) fn read(model: &Model<'_>, sentence: &str) -> String {
    match parse(model, sentence) {
        Ok(program) => program,
        Err(refusal) => refusal.kind().into(),
    }
}
