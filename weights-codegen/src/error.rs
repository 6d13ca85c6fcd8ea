//! Why a model file is refused.

use core::fmt;

use nsrm_core::camera::CameraError;
use nsrm_core::model::COMPOSED;
use thiserror::Error;

/// Why a model file is refused: one variant for each malformation.
///
/// `Display` names the tensor or metadata key, what was expected, what was
/// found, and what to do about it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The bytes are not a safetensors file.
    #[error(
        "not a safetensors file ({reason}); pass the model.safetensors that `harness train` wrote"
    )]
    NotSafetensors {
        /// What the reader of the format found.
        reason: String,
    },
    /// A key of `__metadata__` is missing.
    #[error("metadata: expected the key `{key}`, found none; export the model again")]
    MissingMetadata {
        /// The key.
        key: &'static str,
    },
    /// The value of a metadata key is not JSON, or has the wrong structure.
    #[error(
        "metadata `{key}`: expected the JSON that the exporter writes, but {reason}; export the \
         model again"
    )]
    NotJson {
        /// The key.
        key: &'static str,
        /// The error of the JSON reader.
        reason: String,
    },
    /// The file has a schema version that this build does not read.
    #[error(
        "metadata `schema`: expected {expected}, got {got:?}; {}",
        schema_advice(.got)
    )]
    Schema {
        /// The version that this build reads.
        expected: u32,
        /// The version of the file.
        got: String,
    },
    /// A dimension differs from that of the architecture.
    #[error(
        "metadata `dimensions`: expected {name} = {expected}, got {got}; train with the \
         architecture of this version"
    )]
    Dimension {
        /// Name in the metadata.
        name: String,
        /// The architecture's value.
        expected: u64,
        /// The file's value.
        got: u64,
    },
    /// A list of the domain is empty.
    #[error("domain: {what} must not be empty; add an entry and train again")]
    Empty {
        /// Which list.
        what: String,
    },
    /// A list of the domain has more entries than its index can hold.
    #[error("domain: expected at most {limit} {what}, got {got}; split the domain")]
    TooMany {
        /// Which list.
        what: &'static str,
        /// The greatest number.
        limit: usize,
        /// The file's value.
        got: usize,
    },
    /// Two entries of one list have the same name.
    #[error("domain: the {what} {name:?} occurs twice; rename one and train again")]
    Duplicate {
        /// Which list.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A word is heard as one that is not known.
    #[error(
        "domain: spelling.heard: {text:?} is read as {read_as:?}, which is not a word of the domain; \
         name one that is"
    )]
    HeardAs {
        /// The word that dictation writes.
        text: String,
        /// The word as which it is read.
        read_as: String,
    },
    /// An extreme is of no action, and neither by size.
    #[error("domain: extremes: {name:?} is no action of the domain, \"Largest\" or \"Smallest\"")]
    Extreme {
        /// Its name.
        name: String,
    },
    /// A pronoun, what is read behind it, or what puts an object somewhere is not a word of the domain.
    #[error("domain: pronouns and placing: {word:?} is not a word of the domain; name one that is")]
    Pronoun {
        /// The word.
        word: String,
    },
    /// What stands behind a quantifier, or a word that has a plural, is not a word of the domain.
    #[error("domain: several: {word:?} is not a word of the domain; name one that is")]
    Several {
        /// The word.
        word: String,
    },
    /// An arrangement is read as something that is not a word of the domain.
    #[error("domain: arrangements: {word:?} is not a word of the domain; name one that is")]
    Arrangement {
        /// The word.
        word: String,
    },
    /// What closes an arrangement means steps that are not there.
    #[error("domain: arrangements.patterns: no steps {name:?}; name some of arrangements.steps")]
    ArrangedSteps {
        /// The name.
        name: String,
    },
    /// What is read in place of a phrase is no word of the domain.
    #[error("domain: rephrasing: {word:?} is not a word of the domain; add it to the grammar")]
    Rephrased {
        /// The word.
        word: String,
    },
    /// What only connects two steps is read in other words.
    #[error(
        "domain: simplification.connecting: {text:?} only connects a step to the one before it; read it as nothing"
    )]
    Connecting {
        /// The words.
        text: String,
    },
    /// A direction has no opposite, or is not that of its opposite.
    #[error(
        "domain: perspectives.opposites: {name:?} and its opposite must be actions, and each that of the other"
    )]
    Opposite {
        /// The name of the action.
        name: String,
    },
    /// What is read between the steps of listed objects is no word of the domain.
    #[error("domain: lists: {word:?} is not a word of the domain; add it to the grammar")]
    Listed {
        /// The word.
        word: String,
    },
    /// What is read where steps are put in order is no word of the domain.
    #[error("domain: sequence: {word:?} is not a word of the domain; add it to the grammar")]
    Sequence {
        /// The word.
        word: String,
    },
    /// What is said behind a step only may also stand before one.
    #[error("domain: sequence: {text:?} is in earlier and in afterthoughts; remove it from one")]
    Afterthought {
        /// The words.
        text: String,
    },
    /// A unit of length, or a number in words, is not positive.
    #[error("domain: distances: {text:?} must be a positive number")]
    Length {
        /// The words.
        text: String,
    },
    /// A side is no action of the domain.
    #[error(
        "domain: distances.sides: no action {name:?}; name actions that put an object beside another one"
    )]
    DistanceSide {
        /// The name.
        name: String,
    },
    /// An object is moved in a direction that is none of the sides.
    #[error("domain: distances.shifts: {name:?} is not in distances.sides; add it there")]
    ShiftSide {
        /// The name.
        name: String,
    },
    /// Two directions are said with the same words.
    #[error("domain: distances.shifts: {text:?} is said of two directions; remove it from one")]
    ShiftText {
        /// The words.
        text: String,
    },
    /// What is read where a distance has no side is no word of the domain.
    #[error("domain: distances: {word:?} is not a word of the domain; add it to the grammar")]
    DistanceWord {
        /// The word.
        word: String,
    },
    /// What is counted from is no extreme of the domain.
    #[error("domain: ordinals: {name:?} has no words in extremes; name one that has")]
    CountedFrom {
        /// Its name.
        name: String,
    },
    /// The table names an action that is not there.
    #[error("domain: table: no action {name:?}; name some of the domain")]
    TableAction {
        /// Its name.
        name: String,
    },
    /// By its height, the highest object on the table may stand on the lowest one.
    #[error(
        "domain: table: the highest object is at least three times as high as the lowest, so that what stands on \
         the table cannot be told; leave out the table, what is any of several actions, and distances.shifts"
    )]
    TableHeight,
    /// The table is read as something that is not a word of the domain.
    #[error("domain: table: {word:?} is not a word of the domain; name one that is")]
    Table {
        /// The word.
        word: String,
    },
    /// A compound has both `any` and `all`, or `all` of another number of actions.
    #[error(
        "domain: compounds: {name:?} must have `any` with some actions, `all` of {COMPOSED}, or `between` with one, and \
         only one of these"
    )]
    CompoundParts {
        /// Its name.
        name: String,
    },
    /// A compound names an action that is not there.
    #[error("domain: compounds: {name:?}: no action {action:?}; name some of the domain")]
    CompoundAction {
        /// Its name.
        name: String,
        /// The name of the action.
        action: String,
    },
    /// A compound is read as something that is not a word of the domain.
    #[error("domain: compounds: {name:?}: {word:?} is not a word of the domain; name one that is")]
    CompoundWord {
        /// Its name.
        name: String,
        /// The word.
        word: String,
    },
    /// A concept of the size attribute has no edge lengths, or one that is not positive and
    /// finite.
    #[error(fmt = edges)]
    Edges {
        /// The concept.
        concept: String,
        /// Its edge lengths, metres.
        got: Option<[f32; 3]>,
    },
    /// A word that cannot occur in a tokenized sentence.
    #[error(
        "domain: no sentence can contain the word {word:?}; expected lower case, no white space, \
         no punctuation at its ends"
    )]
    UnreadableWord {
        /// The word.
        word: String,
    },
    /// Row 0 of the vocabulary is not the group token.
    #[error(
        "metadata `vocabulary`: expected \"[[X]]\" as its first entry, got {got:?}; export the \
         model again"
    )]
    GroupToken {
        /// Row 0; empty if the vocabulary is.
        got: String,
    },
    /// The vocabulary and the words of the domain are not the same set.
    #[error(fmt = vocabulary)]
    Vocabulary {
        /// Words of the domain that the vocabulary lacks.
        missing: Vec<String>,
        /// Words of the vocabulary that the domain lacks.
        extra: Vec<String>,
    },
    /// The vocabulary is not sorted.
    #[error(
        "metadata `vocabulary`: expected sorted words, got {first:?} before {second:?}; export \
         the model again"
    )]
    VocabularyOrder {
        /// A word.
        first: String,
        /// The next word, which sorts before it.
        second: String,
    },
    /// A tensor is missing.
    #[error(
        "tensor `{name}`: expected shape {expected:?}, found no such tensor; export the model \
         again"
    )]
    MissingTensor {
        /// Its name.
        name: String,
        /// The expected shape.
        expected: Vec<usize>,
    },
    /// A tensor that the architecture does not have.
    #[error(
        "tensor `{name}`: the architecture has no such tensor; export the model again without it"
    )]
    ExtraTensor {
        /// Its name.
        name: String,
    },
    /// A tensor has the wrong shape.
    #[error(
        "tensor `{name}`: expected shape {expected:?}, got {got:?}; train with the architecture \
         of this version"
    )]
    Shape {
        /// Its name.
        name: String,
        /// The expected shape.
        expected: Vec<usize>,
        /// The shape in the file.
        got: Vec<usize>,
    },
    /// A tensor's elements are not `f32`.
    #[error("tensor `{name}`: expected elements F32, got {got}; export it as float32")]
    ElementType {
        /// Its name.
        name: String,
        /// Their type, in the format's notation.
        got: String,
    },
    /// A tensor holds a NaN or an infinity.
    #[error(
        "tensor `{name}`: expected finite values, got {got} at position {index}; the training \
         diverged, train again"
    )]
    NotFinite {
        /// Its name.
        name: String,
        /// Position in row-major order.
        index: usize,
        /// `NaN`, `inf` or `-inf`.
        got: String,
    },
    /// Finite parameters whose folded product does not fit an `f32`.
    #[error("folded `{name}`: the product does not fit an f32; the training diverged, train again")]
    FoldedNotFinite {
        /// The folded array.
        name: String,
    },
    /// A concept's embedding is too short to have a direction.
    #[error(
        "tensor `vision.concept.weight`: expected an embedding with a direction for {concept:?}, \
         got length {length:e}; train again"
    )]
    ConceptLength {
        /// The concept.
        concept: String,
        /// The embedding's length.
        length: f64,
    },
    /// An entry of `action.simulator.location_scale` is not positive.
    #[error(
        "tensor `action.simulator.location_scale`: expected positive values, got {got:?} at \
         position {index}; export the model again"
    )]
    LocationScale {
        /// Its position.
        index: usize,
        /// Its value.
        got: f32,
    },
    /// The metadata's hash is not a SHA-256 in lower-case hexadecimal digits.
    #[error(
        "metadata `hash`: expected 64 lower-case hexadecimal digits, got {got:?}; export the \
         model again"
    )]
    HashForm {
        /// The value in the file.
        got: String,
    },
    /// Metadata or tensors do not match the file's hash.
    #[error(
        "metadata and tensors: expected the SHA-256 {expected} of metadata `hash`, got {got}; \
         the file was changed or damaged, fetch it again or export the model again"
    )]
    Hash {
        /// The hash in the file.
        expected: String,
        /// The hash of its content.
        got: String,
    },
    /// A threshold is outside 0 to 1.
    #[error("metadata `thresholds`: expected {name} from 0 to 1, got {got:?}; calibrate again")]
    Threshold {
        /// Which.
        name: &'static str,
        /// The file's value.
        got: f32,
    },
    /// The work space is empty or unbounded along an axis.
    #[error(
        "metadata `work_space`: expected finite bounds with min < max along {axis}, got {min:?} \
         and {max:?}; export the model again"
    )]
    WorkSpace {
        /// `x`, `y` or `z`.
        axis: char,
        /// Its lower bound, metres.
        min: f32,
        /// Its upper bound, metres.
        max: f32,
    },
    /// The placed orientation is not a unit quaternion.
    #[error(
        "metadata `placed_orientation`: expected a unit quaternion x, y, z, w, got length \
         {length:?}; export the model again"
    )]
    PlacedOrientation {
        /// Its length.
        length: f32,
    },
    /// `training_camera` is invalid.
    #[error("metadata `training_camera`: {0}; export the model again")]
    TrainingCamera(CameraError),
}

/// The schemas that `cargo harness convert` converts.
const CONVERTIBLE: [&str; 7] = ["2", "3", "4", "5", "6", "7", "8"];

/// What to do about a file of another schema.
fn schema_advice(got: &str) -> &'static str {
    if CONVERTIBLE.contains(&got) {
        "convert the file with `cargo harness convert FILE`, or train again"
    } else {
        "train again with the tools of this version"
    }
}

fn edges(concept: &str, got: &Option<[f32; 3]>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    write!(
        f,
        "domain: edges_m of {concept:?}: expected three lengths in metres, got "
    )?;
    match got {
        Some(edges) => write!(f, "{edges:?}")?,
        None => f.write_str("none")?,
    }
    f.write_str("; correct the domain file and train again")
}

fn vocabulary(missing: &[String], extra: &[String], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str("metadata `vocabulary`: expected exactly the words of the domain;")?;
    write_words(f, " lacks", missing)?;
    write_words(f, " also has", extra)?;
    f.write_str(" train again with this domain")
}

/// Writes `" lacks"` and at most eight words, or nothing when there are none.
fn write_words(f: &mut fmt::Formatter<'_>, what: &str, words: &[String]) -> fmt::Result {
    const SHOWN: usize = 8;
    if words.is_empty() {
        return Ok(());
    }
    write!(f, "{what}")?;
    for (index, word) in words.iter().take(SHOWN).enumerate() {
        write!(f, "{} {word:?}", if index == 0 { "" } else { "," })?;
    }
    if words.len() > SHOWN {
        write!(f, " and {} more", words.len() - SHOWN)?;
    }
    write!(f, ";")
}
