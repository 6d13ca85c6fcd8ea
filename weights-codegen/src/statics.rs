//! The statics of a model, in the order in which they are written.

use nsrm_core::Camera;
use nsrm_core::model::{
    ACCEPTABILITY_HIDDEN, Action, Arrangement, Attribute, Closing, Concept, ENCODER_HIDDEN,
    HAZARD_INPUT, Header, Heard, INSTRUCTION, LexiconEntry, Model, Opening, PixelToCamera, Plural,
    Pronoun, SPLITTER_HIDDEN, SPLITTER_WORD, Simulator, Superlative, Thresholds, WORD, Word,
    WordEmbeddings, WorkSpace,
};

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
    Word<'_> { text, embeddings }
    WordEmbeddings { encoder, splitter }
    LexiconEntry<'_> { text, property }
    Pronoun { word, owner }
    Plural<'_> { text, word }
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
    Superlative { decoder, bias }
    Simulator { input, hidden, output }
    PixelToCamera { weight }
}

/// The model itself: the header, and references to [`statics`].
pub(crate) fn model_record(model: &Model<'_>) -> Node {
    Node::record(
        "Model",
        [
            ("header", model.header.describe()),
            ("words", Node::Reference("WORDS")),
            ("group", Node::Reference("GROUP")),
            ("lexicon", Node::Reference("LEXICON")),
            ("pronouns", Node::Reference("PRONOUNS")),
            (
                "several",
                Node::record(
                    "Several",
                    [
                        ("between", Node::Reference("BETWEEN")),
                        ("plurals", Node::Reference("PLURALS")),
                    ],
                ),
            ),
            (
                "apart",
                Node::record(
                    "Apart",
                    [
                        ("between", Node::Reference("APART_BETWEEN")),
                        ("phrases", Node::Reference("APART_PHRASES")),
                    ],
                ),
            ),
            (
                "arrangements",
                Node::record(
                    "Arrangements",
                    [
                        ("between", Node::Reference("LIST_BETWEEN")),
                        ("ends", Node::Reference("LIST_ENDS")),
                        ("next", model.arrangements.next.describe()),
                        ("arrangements", Node::Reference("ARRANGEMENTS")),
                        ("openings", Node::Reference("OPENINGS")),
                        ("closings", Node::Reference("CLOSINGS")),
                    ],
                ),
            ),
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
                "language",
                Node::record(
                    "Language",
                    [
                        ("forward", Node::Reference("FORWARD")),
                        ("backward", Node::Reference("BACKWARD")),
                        ("object_decoder", Node::Reference("OBJECT_DECODER")),
                        ("reference_decoder", Node::Reference("REFERENCE_DECODER")),
                        (
                            "acceptability_hidden",
                            Node::Reference("ACCEPTABILITY_HIDDEN"),
                        ),
                        ("acceptability", Node::Reference("ACCEPTABILITY")),
                        ("nearest", Node::Reference("NEAREST")),
                        ("farthest", Node::Reference("FARTHEST")),
                        ("splitter", Node::Reference("SPLITTER")),
                        ("hazard_hidden", Node::Reference("HAZARD_HIDDEN")),
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
        ],
    )
}

/// The statics that [`model_record`] refers to.
pub(crate) fn statics(model: &Model<'_>) -> Vec<Static> {
    let language = &model.language;
    let mut statics = vec![
        table("WORDS", "words", "Word<'static>", model.words),
        single("GROUP", "group", "WordEmbeddings", model.group),
        table("LEXICON", "lexicon", "LexiconEntry<'static>", model.lexicon),
        table("PRONOUNS", "pronouns", "Pronoun", model.pronouns),
        table("BETWEEN", "several.between", "u16", model.several.between),
        table(
            "PLURALS",
            "several.plurals",
            "Plural<'static>",
            model.several.plurals,
        ),
        table(
            "APART_BETWEEN",
            "apart.between",
            "&str",
            model.apart.between,
        ),
        table(
            "APART_PHRASES",
            "apart.phrases",
            "&str",
            model.apart.phrases,
        ),
        table(
            "LIST_BETWEEN",
            "arrangements.between",
            "&str",
            model.arrangements.between,
        ),
        table(
            "LIST_ENDS",
            "arrangements.ends",
            "&str",
            model.arrangements.ends,
        ),
        table(
            "ARRANGEMENTS",
            "arrangements.arrangements",
            "Arrangement<'static>",
            model.arrangements.arrangements,
        ),
        table(
            "OPENINGS",
            "arrangements.openings",
            "Opening<'static>",
            model.arrangements.openings,
        ),
        table(
            "CLOSINGS",
            "arrangements.closings",
            "Closing<'static>",
            model.arrangements.closings,
        ),
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
        single(
            "FORWARD",
            "language.forward",
            format!("Gru<{WORD}, {ENCODER_HIDDEN}>"),
            language.forward,
        ),
        single(
            "BACKWARD",
            "language.backward",
            format!("Gru<{WORD}, {ENCODER_HIDDEN}>"),
            language.backward,
        ),
        single(
            "OBJECT_DECODER",
            "language.object_decoder",
            format!("Linear<{INSTRUCTION}, {INSTRUCTION}>"),
            language.object_decoder,
        ),
        single(
            "REFERENCE_DECODER",
            "language.reference_decoder",
            format!("Linear<{INSTRUCTION}, {INSTRUCTION}>"),
            language.reference_decoder,
        ),
        single(
            "ACCEPTABILITY_HIDDEN",
            "language.acceptability_hidden",
            format!("Linear<{INSTRUCTION}, {ACCEPTABILITY_HIDDEN}>"),
            language.acceptability_hidden,
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
        single(
            "SPLITTER",
            "language.splitter",
            format!("Gru<{SPLITTER_WORD}, {SPLITTER_HIDDEN}>"),
            language.splitter,
        ),
        single(
            "HAZARD_HIDDEN",
            "language.hazard_hidden",
            format!("Linear<{HAZARD_INPUT}, {SPLITTER_HIDDEN}>"),
            language.hazard_hidden,
        ),
        single(
            "HAZARD",
            "language.hazard",
            format!("Linear<{SPLITTER_HIDDEN}, 1>"),
            language.hazard,
        ),
    ];
    // The model of a file has all parts.
    if let Some(vision) = &model.vision {
        let (color, light) = (vision.color, vision.brightness);
        statics.push(single("COLOR", "vision.color", "ViewEncoder<3>", color));
        statics.push(single(
            "BRIGHTNESS",
            "vision.brightness",
            "ViewEncoder<1>",
            light,
        ));
    }
    statics.push(single(
        "SIMULATOR",
        "simulator",
        "Simulator",
        model.simulator,
    ));
    statics.push(single("CAMERA", "camera", "PixelToCamera", model.camera));
    statics
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
