//! Why a model file is refused.

use core::fmt;

/// Why a model file is refused: one variant for each malformation.
///
/// `Display` names the tensor or metadata key, what was expected, what was
/// found, and what to do about it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// The bytes are not a safetensors file.
    NotSafetensors {
        /// What the reader of the format found.
        reason: String,
    },
    /// A key of `__metadata__` is missing.
    MissingMetadata {
        /// The key.
        key: &'static str,
    },
    /// The value of a metadata key is not JSON, or has the wrong structure.
    NotJson {
        /// The key.
        key: &'static str,
        /// The error of the JSON reader.
        reason: String,
    },
    /// The file has a schema version that this build does not read.
    Schema {
        /// The version that this build reads.
        expected: u32,
        /// The version of the file.
        got: String,
    },
    /// A dimension differs from that of the architecture.
    Dimension {
        /// Name in the metadata.
        name: String,
        /// The architecture's value.
        expected: u64,
        /// The file's value.
        got: u64,
    },
    /// A list of the domain is empty.
    Empty {
        /// Which list.
        what: String,
    },
    /// A list of the domain has more entries than its index can hold.
    TooMany {
        /// Which list.
        what: &'static str,
        /// The greatest number.
        limit: usize,
        /// The file's value.
        got: usize,
    },
    /// Two entries of one list have the same name.
    Duplicate {
        /// Which list.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A concept of the size attribute has no edge lengths, or one that is not positive and
    /// finite.
    Edges {
        /// The concept.
        concept: String,
        /// Its edge lengths, metres.
        got: Option<[f32; 3]>,
    },
    /// A word that can't occur in a tokenized sentence.
    UnreadableWord {
        /// The word.
        word: String,
    },
    /// Row 0 of the vocabulary is not the group token.
    GroupToken {
        /// Row 0; empty if the vocabulary is.
        got: String,
    },
    /// The vocabulary and the words of the domain are not the same set.
    Vocabulary {
        /// Words of the domain that the vocabulary lacks.
        missing: Vec<String>,
        /// Words of the vocabulary that the domain lacks.
        extra: Vec<String>,
    },
    /// The vocabulary is not sorted.
    VocabularyOrder {
        /// A word.
        first: String,
        /// The next word, which sorts before it.
        second: String,
    },
    /// A tensor is missing.
    MissingTensor {
        /// Its name.
        name: String,
        /// The expected shape.
        expected: Vec<usize>,
    },
    /// A tensor that the architecture does not have.
    ExtraTensor {
        /// Its name.
        name: String,
    },
    /// A tensor has the wrong shape.
    Shape {
        /// Its name.
        name: String,
        /// The expected shape.
        expected: Vec<usize>,
        /// The shape in the file.
        got: Vec<usize>,
    },
    /// A tensor's elements are not `f32`.
    ElementType {
        /// Its name.
        name: String,
        /// Their type, in the format's notation.
        got: String,
    },
    /// A tensor holds a NaN or an infinity.
    NotFinite {
        /// Its name.
        name: String,
        /// Position in row-major order.
        index: usize,
        /// `NaN`, `inf` or `-inf`.
        got: String,
    },
    /// Finite parameters whose folded product does not fit an `f32`.
    FoldedNotFinite {
        /// The folded array.
        name: String,
    },
    /// A concept's embedding is too short to have a direction.
    ConceptLength {
        /// The concept.
        concept: String,
        /// The embedding's length.
        length: f64,
    },
    /// An entry of `action.simulator.location_scale` is not positive.
    LocationScale {
        /// Its position.
        index: usize,
        /// Its value.
        got: f32,
    },
    /// The metadata's hash is not a SHA-256 in lower-case hexadecimal digits.
    HashForm {
        /// The value in the file.
        got: String,
    },
    /// Metadata or tensors do not match the file's hash.
    Hash {
        /// The hash in the file.
        expected: String,
        /// The hash of its content.
        got: String,
    },
    /// A threshold is outside 0 to 1.
    Threshold {
        /// Which.
        name: &'static str,
        /// The file's value.
        got: f32,
    },
    /// The work space is empty or unbounded along an axis.
    WorkSpace {
        /// `x`, `y` or `z`.
        axis: char,
        /// Its lower bound, metres.
        min: f32,
        /// Its upper bound, metres.
        max: f32,
    },
    /// The placed orientation is not a unit quaternion.
    PlacedOrientation {
        /// Its length.
        length: f32,
    },
}

/// The schema that `cargo harness convert` converts.
const CONVERTIBLE: &str = "2";

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSafetensors { reason } => write!(
                f,
                "not a safetensors file ({reason}); pass the model.safetensors that `harness train` wrote"
            ),
            Self::MissingMetadata { key } => write!(
                f,
                "metadata: expected the key `{key}`, found none; export the model again"
            ),
            Self::NotJson { key, reason } => write!(
                f,
                "metadata `{key}`: expected the JSON that the exporter writes, but {reason}; export the model again"
            ),
            Self::Schema { expected, got } if got == CONVERTIBLE => write!(
                f,
                "metadata `schema`: expected {expected}, got {got:?}; convert the file with `cargo harness convert FILE`, or train again"
            ),
            Self::Schema { expected, got } => write!(
                f,
                "metadata `schema`: expected {expected}, got {got:?}; train again with the tools of this version"
            ),
            Self::Dimension {
                name,
                expected,
                got,
            } => write!(
                f,
                "metadata `dimensions`: expected {name} = {expected}, got {got}; train with the architecture of this version"
            ),
            Self::Empty { what } => {
                write!(
                    f,
                    "domain: {what} must not be empty; add an entry and train again"
                )
            }
            Self::TooMany { what, limit, got } => write!(
                f,
                "domain: expected at most {limit} {what}, got {got}; split the domain"
            ),
            Self::Duplicate { what, name } => write!(
                f,
                "domain: the {what} {name:?} occurs twice; rename one and train again"
            ),
            Self::Edges { concept, got } => {
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
            Self::UnreadableWord { word } => write!(
                f,
                "domain: no sentence can contain the word {word:?}; expected lower case, no white space, no punctuation at its ends"
            ),
            Self::GroupToken { got } => write!(
                f,
                "metadata `vocabulary`: expected \"[[X]]\" as its first entry, got {got:?}; export the model again"
            ),
            Self::Vocabulary { missing, extra } => {
                write!(
                    f,
                    "metadata `vocabulary`: expected exactly the words of the domain;"
                )?;
                write_words(f, " lacks", missing)?;
                write_words(f, " also has", extra)?;
                write!(f, " train again with this domain")
            }
            Self::VocabularyOrder { first, second } => write!(
                f,
                "metadata `vocabulary`: expected sorted words, got {first:?} before {second:?}; export the model again"
            ),
            Self::MissingTensor { name, expected } => write!(
                f,
                "tensor `{name}`: expected shape {expected:?}, found no such tensor; export the model again"
            ),
            Self::ExtraTensor { name } => write!(
                f,
                "tensor `{name}`: the architecture has no such tensor; export the model again without it"
            ),
            Self::Shape {
                name,
                expected,
                got,
            } => write!(
                f,
                "tensor `{name}`: expected shape {expected:?}, got {got:?}; train with the architecture of this version"
            ),
            Self::ElementType { name, got } => write!(
                f,
                "tensor `{name}`: expected elements F32, got {got}; export it as float32"
            ),
            Self::NotFinite { name, index, got } => write!(
                f,
                "tensor `{name}`: expected finite values, got {got} at position {index}; the training diverged, train again"
            ),
            Self::FoldedNotFinite { name } => write!(
                f,
                "folded `{name}`: the product does not fit an f32; the training diverged, train again"
            ),
            Self::ConceptLength { concept, length } => write!(
                f,
                "tensor `vision.concept.weight`: expected an embedding with a direction for {concept:?}, got length {length:e}; train again"
            ),
            Self::LocationScale { index, got } => write!(
                f,
                "tensor `action.simulator.location_scale`: expected positive values, got {got:?} at position {index}; export the model again"
            ),
            Self::HashForm { got } => write!(
                f,
                "metadata `hash`: expected 64 lower-case hexadecimal digits, got {got:?}; export the model again"
            ),
            Self::Hash { expected, got } => write!(
                f,
                "metadata and tensors: expected the SHA-256 {expected} of metadata `hash`, got {got}; the file was changed or damaged, fetch it again or export the model again"
            ),
            Self::Threshold { name, got } => write!(
                f,
                "metadata `thresholds`: expected {name} from 0 to 1, got {got:?}; calibrate again"
            ),
            Self::WorkSpace { axis, min, max } => write!(
                f,
                "metadata `work_space`: expected finite bounds with min < max along {axis}, got {min:?} and {max:?}; export the model again"
            ),
            Self::PlacedOrientation { length } => write!(
                f,
                "metadata `placed_orientation`: expected a unit quaternion x, y, z, w, got length {length:?}; export the model again"
            ),
        }
    }
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

impl std::error::Error for ModelError {}
