//! The statics of a model, in the order in which they are written.

mod rewriting;

use nsrm_core::Camera;
use nsrm_core::model::{
    ACCEPTABILITY_HIDDEN, Action, Arrangement, Attribute, Closing, Compound, CompoundText, Concept,
    Count, CountedFrom, DistanceNumber, DistanceShift, DistanceUnit, Embeddings, Header, Heard,
    Int8WordEmbeddings, LexiconEntry, Model, Opening, PixelToCamera, Plural, Pronoun, Ranked,
    Rephrased, SPLITTER_HIDDEN, SequenceText, Simulator, Superlative, Thresholds, ViewEncoder,
    Word, WordEmbeddings, WorkSpace,
};
use nsrm_core::nn::{Cell, Dense};

use crate::tree::{Describe, Node, describe};

/// One static.
pub(crate) struct Static {
    /// Its name in the source.
    pub(crate) name: &'static str,
    /// Its type in the source.
    pub(crate) kind: String,
    /// Its path in [`Model`].
    pub(crate) path: &'static str,
    pub(crate) node: Node,
    /// `size_of` on this machine, pointers and padding included.
    pub(crate) size: usize,
}

describe! {
    Header<'_> {
        domain, identity, thresholds, work_space, placed_orientation, training_camera,
    }
    Camera { width, height, fx, fy, cx, cy, position, orientation }
    Thresholds { match_score, decision, confidence }
    WorkSpace { min, max }
    Word<'_> { text }
    WordEmbeddings { encoder, splitter }
    Int8WordEmbeddings { encoder, encoder_scale, splitter, splitter_scale }
    LexiconEntry<'_> { text, property }
    Pronoun { word, owner }
    Plural<'_> { text, word }
    Ranked<'_> { name, extreme, rank }
    Count<'_> { text, rank }
    CountedFrom<'_> { text, extreme, is_first }
    Rephrased<'_> { text, read_as }
    SequenceText<'_> { text, read_as, is_afterthought }
    DistanceUnit<'_> { text, mm }
    DistanceNumber<'_> { text, value }
    DistanceShift<'_> { text, action }
    Arrangement<'_> { order, relation, is_reversed }
    Opening<'_> { text, pattern }
    Closing<'_> { text, pattern, arrangement }
    Heard<'_> { text, read_as }
    Attribute<'_> { name, view, hidden, output }
    Concept<'_> { name, attribute, embedding, edges_m }
    Action<'_> {
        name, phrase, extreme, decoder, decoder_bias, relation_decoder, relation_bias,
        simulator_bias,
    }
    Compound<'_> { name, phrase, kind, parts, read }
    CompoundText<'_> { text, compound }
    Superlative { decoder, bias }
    PixelToCamera { weight }
}

/// The model itself: the header, and references to [`statics`].
pub(crate) fn model_record(model: &Model<'_>) -> Node {
    let language = &model.language;
    let mut fields = vec![
        ("header", model.header.describe()),
        ("words", Node::Reference("WORDS")),
        ("embeddings", embeddings(&model.embeddings).0),
        ("lexicon", Node::Reference("LEXICON")),
        ("pronouns", Node::Reference("PRONOUNS")),
        ("placing", Node::Reference("PLACING")),
        ("conjunctions", Node::Reference("CONJUNCTIONS")),
    ];
    fields.extend(rewriting::records(model));
    fields.extend([
        (
            "spelling",
            Node::record(
                "Spelling",
                [
                    ("heard", Node::Reference("HEARD")),
                    ("other_words", Node::Reference("OTHER_WORDS")),
                ],
            ),
        ),
        ("attributes", Node::Reference("ATTRIBUTES")),
        ("concepts", Node::Reference("CONCEPTS")),
        ("actions", Node::Reference("ACTIONS")),
        (
            "compounds",
            Node::record(
                "Compounds",
                [
                    ("compounds", Node::Reference("COMPOUNDS")),
                    ("said", Node::Reference("COMPOUND_TEXTS")),
                    ("first_words", Node::Reference("FIRST_WORDS")),
                    ("sides", Node::Reference("SIDES")),
                ],
            ),
        ),
        (
            "language",
            Node::record(
                "Language",
                [
                    ("forward", cell_variant(&language.forward, "FORWARD")),
                    ("backward", cell_variant(&language.backward, "BACKWARD")),
                    (
                        "object_decoder",
                        dense_variant(&language.object_decoder, "OBJECT_DECODER"),
                    ),
                    (
                        "reference_decoder",
                        dense_variant(&language.reference_decoder, "REFERENCE_DECODER"),
                    ),
                    (
                        "acceptability_hidden",
                        dense_variant(&language.acceptability_hidden, "ACCEPTABILITY_HIDDEN"),
                    ),
                    ("acceptability", Node::Reference("ACCEPTABILITY")),
                    ("nearest", Node::Reference("NEAREST")),
                    ("farthest", Node::Reference("FARTHEST")),
                    ("splitter", cell_variant(&language.splitter, "SPLITTER")),
                    (
                        "hazard_hidden",
                        dense_variant(&language.hazard_hidden, "HAZARD_HIDDEN"),
                    ),
                    ("hazard", Node::Reference("HAZARD")),
                ],
            ),
        ),
        (
            "vision",
            Node::record(
                "Vision",
                [
                    ("color", Node::Reference("COLOR")),
                    ("brightness", Node::Reference("BRIGHTNESS")),
                ],
            ),
        ),
        ("simulator", Node::Reference("SIMULATOR")),
        ("camera", Node::Reference("CAMERA")),
    ]);
    Node::Record("Model", fields)
}

/// The statics that [`model_record`] refers to.
pub(crate) fn statics(model: &Model<'_>) -> Vec<Static> {
    let language = &model.language;
    let mut statics = vec![
        table("WORDS", "words", "Word<'static>", model.words),
        embeddings(&model.embeddings).1,
        table("LEXICON", "lexicon", "LexiconEntry<'static>", model.lexicon),
        table("PRONOUNS", "pronouns", "Pronoun", model.pronouns),
        table("PLACING", "placing", "u16", model.placing),
        table("CONJUNCTIONS", "conjunctions", "&str", model.conjunctions),
    ];
    statics.extend(rewriting::tables(model));
    statics.extend([
        table(
            "HEARD",
            "spelling.heard",
            "Heard<'static>",
            model.spelling.heard,
        ),
        table(
            "OTHER_WORDS",
            "spelling.other_words",
            "u16",
            model.spelling.other_words,
        ),
        table(
            "ATTRIBUTES",
            "attributes",
            "Attribute<'static>",
            model.attributes,
        ),
        table("CONCEPTS", "concepts", "Concept<'static>", model.concepts),
        table("ACTIONS", "actions", "Action<'static>", model.actions),
        table(
            "COMPOUNDS",
            "compounds.compounds",
            "Compound<'static>",
            model.compounds.compounds,
        ),
        table(
            "COMPOUND_TEXTS",
            "compounds.said",
            "CompoundText<'static>",
            model.compounds.said,
        ),
        table(
            "FIRST_WORDS",
            "compounds.first_words",
            "&str",
            model.compounds.first_words,
        ),
        table("SIDES", "compounds.sides", "&str", model.compounds.sides),
        cell_static("FORWARD", "language.forward", &language.forward),
        cell_static("BACKWARD", "language.backward", &language.backward),
        dense_static(
            "OBJECT_DECODER",
            "language.object_decoder",
            &language.object_decoder,
        ),
        dense_static(
            "REFERENCE_DECODER",
            "language.reference_decoder",
            &language.reference_decoder,
        ),
        dense_static(
            "ACCEPTABILITY_HIDDEN",
            "language.acceptability_hidden",
            &language.acceptability_hidden,
        ),
        single(
            "ACCEPTABILITY",
            "language.acceptability",
            format!("Linear<{ACCEPTABILITY_HIDDEN}, 1>"),
            language.acceptability,
        ),
        single(
            "NEAREST",
            "language.nearest",
            "Superlative",
            language.nearest,
        ),
        single(
            "FARTHEST",
            "language.farthest",
            "Superlative",
            language.farthest,
        ),
        cell_static("SPLITTER", "language.splitter", &language.splitter),
        dense_static(
            "HAZARD_HIDDEN",
            "language.hazard_hidden",
            &language.hazard_hidden,
        ),
        single(
            "HAZARD",
            "language.hazard",
            format!("Linear<{SPLITTER_HIDDEN}, 1>"),
            language.hazard,
        ),
    ]);
    // The model of a file has all parts.
    if let Some(vision) = &model.vision {
        statics.extend(view(
            ["COLOR", "COLOR_DENSE"],
            ["vision.color", "vision.color.dense"],
            vision.color,
        ));
        statics.extend(view(
            ["BRIGHTNESS", "BRIGHTNESS_DENSE"],
            ["vision.brightness", "vision.brightness.dense"],
            vision.brightness,
        ));
    }
    statics.extend(simulator(model.simulator));
    statics.push(single("CAMERA", "camera", "PixelToCamera", model.camera));
    statics
}

/// The embeddings in the model's record, and their static.
fn embeddings(embeddings: &Embeddings<'_>) -> (Node, Static) {
    const NAME: &str = "EMBEDDINGS";
    match embeddings {
        Embeddings::F32(rows) => (
            Node::Variant("Embeddings::F32", NAME),
            table(NAME, "embeddings", "WordEmbeddings", rows),
        ),
        Embeddings::Int8(rows) => (
            Node::Variant("Embeddings::Int8", NAME),
            table(NAME, "embeddings", "Int8WordEmbeddings", rows),
        ),
        _ => unknown_precision(),
    }
}

fn cell_variant<const I: usize, const H: usize>(cell: &Cell<'_, I, H>, name: &'static str) -> Node {
    match cell {
        Cell::F32(_) => Node::Variant("Cell::F32", name),
        Cell::Int8(_) => Node::Variant("Cell::Int8", name),
        _ => unknown_precision(),
    }
}

fn cell_static<const I: usize, const H: usize>(
    name: &'static str,
    path: &'static str,
    cell: &Cell<'_, I, H>,
) -> Static {
    match cell {
        Cell::F32(cell) => single(name, path, format!("Gru<{I}, {H}>"), *cell),
        Cell::Int8(cell) => single(name, path, format!("Int8Gru<{I}, {H}>"), *cell),
        _ => unknown_precision(),
    }
}

fn dense_variant<const I: usize, const O: usize>(
    layer: &Dense<'_, I, O>,
    name: &'static str,
) -> Node {
    match layer {
        Dense::F32(_) => Node::Variant("Dense::F32", name),
        Dense::Int8(_) => Node::Variant("Dense::Int8", name),
        _ => unknown_precision(),
    }
}

fn dense_static<const I: usize, const O: usize>(
    name: &'static str,
    path: &'static str,
    layer: &Dense<'_, I, O>,
) -> Static {
    match layer {
        Dense::F32(layer) => single(name, path, format!("Linear<{I}, {O}>"), *layer),
        Dense::Int8(layer) => single(name, path, format!("Int8Linear<{I}, {O}>"), *layer),
        _ => unknown_precision(),
    }
}

/// Core's enums are `#[non_exhaustive]`; the loader gives the precisions above.
fn unknown_precision() -> ! {
    unreachable!("a precision that the loader does not know")
}

/// A view's encoder, and its dense layer.
fn view<const CHANNELS: usize>(
    [name, dense]: [&'static str; 2],
    [path, dense_path]: [&'static str; 2],
    encoder: &ViewEncoder<'_, CHANNELS>,
) -> [Static; 2] {
    let fields = [
        ("patch", encoder.patch.describe()),
        ("merge", encoder.merge.describe()),
        ("dense", dense_variant(&encoder.dense, dense)),
    ];
    let encoder_static = Static {
        name,
        kind: format!("ViewEncoder<'static, {CHANNELS}>"),
        path,
        node: Node::record("ViewEncoder", fields),
        size: size_of_val(encoder),
    };
    let layer = dense_static(dense, dense_path, &encoder.dense);
    [encoder_static, layer]
}

/// The action simulator, and its hidden layer.
fn simulator(simulator: &Simulator<'_>) -> [Static; 2] {
    const HIDDEN: &str = "SIMULATOR_HIDDEN";
    let fields = [
        ("input", simulator.input.describe()),
        ("hidden", dense_variant(&simulator.hidden, HIDDEN)),
        ("output", simulator.output.describe()),
    ];
    let simulator_static = Static {
        name: "SIMULATOR",
        kind: "Simulator<'static>".into(),
        path: "simulator",
        node: Node::record("Simulator", fields),
        size: size_of_val(simulator),
    };
    let hidden = dense_static(HIDDEN, "simulator.hidden", &simulator.hidden);
    [simulator_static, hidden]
}

fn single<T: Describe>(
    name: &'static str,
    path: &'static str,
    kind: impl Into<String>,
    value: &T,
) -> Static {
    Static {
        name,
        kind: kind.into(),
        path,
        node: value.describe(),
        size: size_of::<T>(),
    }
}

fn table<T: Describe>(
    name: &'static str,
    path: &'static str,
    kind: &'static str,
    values: &[T],
) -> Static {
    Static {
        name,
        kind: format!("[{kind}; {}]", values.len()),
        path,
        node: values.describe(),
        size: size_of_val(values),
    }
}
