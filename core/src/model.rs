//! The trained model by reference: parameters as fixed arrays, with their domain and thresholds.
//!
//! A word, a concept, an attribute type or an action is one struct with its parameters, so that the
//! number of rows of a matrix always matches the number of words. The hidden sizes below are those
//! of the architecture; everything that depends on the domain is a slice.
//!
//! Matrices are column-major here (`[[f32; ROWS]; COLUMNS]`), so that
//! `W·x = Σ_j x[j]·W[j]` runs over contiguous memory; the model file's are
//! row-major, and the code generator transposes them.
//!
//! The structs are not constructed as literals outside this crate. Each has `new`, which sets
//! nothing, and a `with_` method for each field, also for constants and statics: later versions can
//! add fields, and existing code still compiles. Unset parameters are NaN, so that an incomplete
//! model refuses.

mod builder;
mod check;
mod compound;
mod distance;
mod embeddings;
mod exception;
mod list;
mod ordinal;
mod perspectives;
mod repair;
mod rephrasing;
mod sequence;
mod simplification;
mod table;

pub use check::ModelFault;
pub use compound::{COMPOSED, Compound, CompoundKind, CompoundText, Compounds};
pub use distance::{DistanceNumber, DistanceShift, DistanceUnit, Distances};
pub use embeddings::{Embeddings, Int8WordEmbeddings, WordEmbeddings};
pub use exception::Exceptions;
pub use list::Lists;
pub use ordinal::{Count, CountedFrom, Ordinals, Ranked};
pub use perspectives::Perspectives;
pub use repair::Repairs;
pub use rephrasing::{Rephrased, Rephrasing};
pub use sequence::{Sequence, SequenceText};
pub use simplification::{Simplification, Standing, Taking};
pub use table::{MAX_SIDES, Table};

use crate::camera::Camera;
use crate::dsl::Property;
use crate::nn::{Cell, Dense, Linear, MergeConv, PatchConv};

/// Length of a word's embedding at the sentence encoder's input (section IV-B).
pub const WORD: usize = 32;
/// Hidden units of the sentence encoder in each direction.
pub const ENCODER_HIDDEN: usize = 48;
/// Length of the instruction embedding: both directions, forward first.
pub const INSTRUCTION: usize = 2 * ENCODER_HIDDEN;
/// Units of the hidden layer from which a word's acceptability is computed.
pub const ACCEPTABILITY_HIDDEN: usize = 16;
/// Length of a word's embedding at the splitter's input.
pub const SPLITTER_WORD: usize = 24;
/// Hidden units of the splitter's GRU, and of its hazard's hidden layer.
pub const SPLITTER_HIDDEN: usize = 32;
/// Tokens that the splitter sees behind the one at which a step may end.
pub const LOOKAHEAD: usize = 6;
/// Values from which the hazard is computed: the GRU's state and the next tokens.
pub const HAZARD_INPUT: usize = SPLITTER_HIDDEN + LOOKAHEAD * SPLITTER_WORD;
/// Side of the square crop that the encoder sees, in pixels (section IV-C).
pub const CROP: usize = 32;
/// Channels after the first convolution, 4×4 with stride 4.
pub const PATCH_CHANNELS: usize = 24;
/// Channels after the second convolution, 2×2 with stride 2.
pub const MERGE_CHANNELS: usize = 32;
/// Values after the second convolution: `MERGE_CHANNELS` maps of 4×4.
pub const MERGED: usize = MERGE_CHANNELS * 16;
/// Length of the embedding of one view of a crop (colour, brightness).
pub const VIEW_EMBEDDING: usize = 32;
/// Length of an object's embedding: the colour view, then the brightness view.
pub const OBJECT_EMBEDDING: usize = 2 * VIEW_EMBEDDING;
/// Hidden units of an attribute operator.
pub const OPERATOR_HIDDEN: usize = 32;
/// Dimension of the concept space in which the cosine is taken (Table II).
pub const CONCEPT: usize = 16;
/// Hidden units of each of the action simulator's two hidden layers (section IV-D).
pub const SIMULATOR_HIDDEN: usize = 64;
/// Numbers in a location: box corners x1, y1, x2, y2 and mean depth.
pub const LOCATION: usize = 5;
/// Version of the model file, of these structs and of the inputs that they were trained on (2:
/// brightness is the greatest of the three colours; 3: the file's hash covers its metadata; 4:
/// acceptability; 5: relations in descriptions; 6: the splitter sees six tokens ahead; 7: the
/// training's camera; 8: superlatives in descriptions; 9: extremes, such as "leftmost"); others are
/// refused.
pub const SCHEMA: u32 = 9;

/// A trained model, which [`crate::Planner`] only reads.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Model<'a> {
    /// The header of the model file.
    pub header: Header<'a>,
    /// Words outside the lexicon; sorted by text.
    pub words: &'a [Word<'a>],
    /// Of the token for a group of concept words, `[[X]]` in the paper, then of [`Model::words`].
    pub embeddings: Embeddings<'a>,
    /// Words that name a concept (the paper's only lexicon) or the table, or say which one of several
    /// objects is meant or that several are; sorted by text.
    pub lexicon: &'a [LexiconEntry<'a>],
    /// Words that may stand for what the step before moved; sorted by word.
    pub pronouns: &'a [Pronoun],
    /// Words that put an object somewhere and never only take it, "put", and not "get": behind a whole step of one of
    /// them, a pronoun behind one is of another step. Indices into [`Model::words`]; sorted.
    pub placing: &'a [u16],
    /// What a pronoun is a word like any other behind, "so that" in "so that it is", and "after" in "after that"; sorted.
    pub conjunctions: &'a [&'a str],
    /// What may be said of several objects.
    pub several: Several<'a>,
    /// What is read as other words.
    pub rephrasing: Rephrasing<'a>,
    /// What a sentence can do without that is refused as it stands.
    pub simplification: Simplification<'a>,
    /// Whose left is meant.
    pub perspectives: Perspectives<'a>,
    /// How something is left out of a description.
    pub exceptions: Exceptions<'a>,
    /// How several objects are listed that are moved.
    pub lists: Lists<'a>,
    /// How something is taken back.
    pub repairs: Repairs<'a>,
    /// In which order steps are carried out that are said in another one.
    pub sequence: Sequence<'a>,
    /// How far from the reference an object is put.
    pub distances: Distances<'a>,
    /// What stands between values of one object.
    pub apart: Apart<'a>,
    /// How is counted from one side.
    pub ordinals: Ordinals<'a>,
    /// How towers and rows are said.
    pub arrangements: Arrangements<'a>,
    /// The table as a place.
    pub table: Table<'a>,
    /// What unknown words are read as.
    pub spelling: Spelling<'a>,
    /// Attribute types with their operators, in the domain's order (Table I).
    pub attributes: &'a [Attribute<'a>],
    /// Attribute values, in the domain's order.
    pub concepts: &'a [Concept<'a>],
    /// Actions, in the domain's order.
    pub actions: &'a [Action<'a>],
    /// Actions that are made of these.
    pub compounds: Compounds<'a>,
    /// Sentence encoder, decoders and splitter (section IV-B).
    pub language: Language<'a>,
    /// Crop encoder (section IV-C); without it, scenes must come from elsewhere.
    pub vision: Option<Vision<'a>>,
    /// Action simulator (section IV-D).
    pub simulator: &'a Simulator<'a>,
    /// From a location to the object's centre in the camera's frame.
    pub camera: &'a PixelToCamera,
}

/// The header of the model file.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Header<'a> {
    /// Name of the domain file that it was trained on.
    pub domain: &'a str,
    /// SHA-256 of everything that results depend on: the tensors, and all metadata except
    /// `training` and `metrics`.
    pub identity: [u8; 32],
    /// When to refuse; calibrated on validation data.
    pub thresholds: Thresholds,
    /// Where sub-goals may lie.
    pub work_space: WorkSpace,
    /// Orientation in which the demonstrator places objects: x, y, z, w.
    pub placed_orientation: [f32; 4],
    /// The camera that saw the demonstrations, in whose image the simulator predicts.
    pub training_camera: Camera,
}

/// When to refuse instead of guessing; probabilities and cosines.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Thresholds {
    /// An object matches a description if its filtered score, a cosine, is at least this.
    pub match_score: f32,
    /// The smallest accepted probability of a split, an action, a relation or an argument.
    pub decision: f32,
    /// The smallest accepted [`crate::Plan::confidence`]; 0 accepts every plan.
    pub confidence: f32,
}

/// The box in which sub-goals may lie: world frame, metres, bounds included.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct WorkSpace {
    /// Smallest x, y, z of an object's centre.
    pub min: [f32; 3],
    /// Greatest x, y, z of an object's centre.
    pub max: [f32; 3],
}

/// A word outside the lexicon.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Word<'a> {
    /// In lower case; `","` is the comma.
    pub text: &'a str,
}

/// A word that may stand for the object that the step before moved: "it". The sentence is also read
/// with a group of concept words in its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Pronoun {
    /// Index into [`Model::words`].
    pub word: u16,
    /// The word that is then read behind the group, "one's" for "its": index into [`Model::words`].
    pub owner: Option<u16>,
}

/// How several objects are said, which a [`Quantifier`](crate::dsl::Quantifier) of the lexicon begins:
/// "all of the red blocks". By default, they cannot be said.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Several<'a> {
    /// Words that may stand between the quantifier and the rest, "of" and "the": indices into
    /// [`Model::words`].
    pub between: &'a [u16],
    /// Words in the plural; sorted by text. Elsewhere they are other words, or unknown ones.
    pub plurals: &'a [Plural<'a>],
}

/// A word in the plural.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Plural<'a> {
    /// In lower case: "blocks", "them".
    pub text: &'a str,
    /// The word as which it is read, "block", "it": index into [`Model::words`].
    pub word: u16,
}

/// What may stand between values of one object that are said apart: they are read as if they stood together.
/// By default nothing.
///
/// All texts are words in lower case with one space in between, which need not be among
/// [`Model::words`].
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Apart<'a> {
    /// Directly between values: "small and red block".
    pub between: &'a [&'a str],
    /// Between an object and another of its values, "that is" in "the small block that is red".
    pub phrases: &'a [&'a str],
}

/// How towers and rows are said, several steps in a few words: "build a tower of red, green and blue" is
/// read as "put green on red, then put blue on it". By default, they cannot be said.
///
/// All texts are words in lower case with one space in between. Those of openings, closings and
/// singulars need not be among [`Model::words`]; elsewhere they are unknown words.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Arrangements<'a> {
    /// Words that stand between the objects of a list, "," and "and"; sorted.
    pub between: &'a [&'a str],
    /// Words before which a list ends, "then"; sorted.
    pub ends: &'a [&'a str],
    /// What is read between two steps: ", then".
    pub next: &'a str,
    /// What each of the objects is moved to.
    pub arrangements: &'a [Arrangement<'a>],
    /// What stands before a list; sorted by text.
    pub openings: &'a [Opening<'a>],
    /// What stands behind a list.
    pub closings: &'a [Closing<'a>],
}

/// How each object of a list is put in relation to the one before it.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Arrangement<'a> {
    /// What is read before the object that is moved: "put".
    pub order: &'a str,
    /// What is read between it and the object before it: "on".
    pub relation: &'a str,
    /// Whether the list begins with the last object: "from top to bottom".
    pub is_reversed: bool,
}

/// What stands before a list: "build a tower of".
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Opening<'a> {
    /// Its words, at least one.
    pub text: &'a str,
    /// What may stand behind the list: closings with the same pattern.
    pub pattern: u8,
}

/// What stands behind a list: "from left to right".
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Closing<'a> {
    /// Its words; empty if nothing need stand there.
    pub text: &'a str,
    /// What stands before the list: openings with the same pattern.
    pub pattern: u8,
    /// What is then meant: index into [`Arrangements::arrangements`].
    pub arrangement: u8,
}

/// What unknown words are read as, if the sentence then makes sense; by default nothing.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Spelling<'a> {
    /// Words that dictation writes for known ones; sorted by text.
    pub heard: &'a [Heard<'a>],
    /// Hashes of words that are near known ones and mean something else, sorted; they are never
    /// read as known ones. Without any, no word is taken for misspelt.
    ///
    /// A word's hash is that of FNV-1a with 32 bits over its UTF-8 in lower case, both halves
    /// combined by exclusive or. Another word with the same hash is refused, too.
    pub other_words: &'a [u16],
}

/// A word that dictation writes for a known one.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Heard<'a> {
    /// In lower case.
    pub text: &'a str,
    /// The known word.
    pub read_as: &'a str,
}

/// A word that names a concept or the table, or says which one of several objects is meant or that
/// several are.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct LexiconEntry<'a> {
    /// In lower case.
    pub text: &'a str,
    /// What it says of an object.
    pub property: Property,
}

/// The part of a crop that an attribute operator sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum View {
    /// Red, green and blue.
    Color,
    /// Brightness only, standardised over the crop.
    Brightness,
}

/// An attribute type with its operator: `Linear → ReLU → Linear` into concept space.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Attribute<'a> {
    /// Name in the domain file.
    pub name: &'a str,
    /// The part of the object's embedding that it reads.
    pub view: View,
    /// First layer.
    pub hidden: Linear<VIEW_EMBEDDING, OPERATOR_HIDDEN>,
    /// Second layer.
    pub output: Linear<OPERATOR_HIDDEN, CONCEPT>,
}

/// An attribute value.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Concept<'a> {
    /// Name in the domain file.
    pub name: &'a str,
    /// Index of its type in [`Model::attributes`].
    pub attribute: u8,
    /// Its embedding, of length 1.
    pub embedding: [f32; CONCEPT],
    /// Edge lengths along x, y and z of the objects that have this value, metres; one
    /// attribute type says the objects' sizes, all others don't.
    pub edges_m: Option<[f32; 3]>,
}

/// An action.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Action<'a> {
    /// Name in the domain file: `MoveOn`.
    pub name: &'a str,
    /// How a person says it, the first phrase of the domain file: `on`.
    pub phrase: &'a str,
    /// How a person says which object lies farthest in the direction in which it puts things,
    /// [`Extreme::Action`](crate::dsl::Extreme::Action): `leftmost`. `None` if the domain has no word
    /// for it.
    pub extreme: Option<&'a str>,
    /// Its row of the action decoder.
    pub decoder: [f32; INSTRUCTION],
    /// Its logit's bias.
    pub decoder_bias: f32,
    /// Its rows of the relation decoder, on the encoder's state at a group of concept words. 0: the
    /// group restricts what is described before it, by the relation that this action brings about;
    /// 1: it describes what an object without values of its own is related to in this way.
    pub relation_decoder: [[f32; INSTRUCTION]; 2],
    /// The biases of these logits; that of a group without a relation is 0.
    pub relation_bias: [f32; 2],
    /// Its one-hot column of the simulator's first layer, with that layer's bias
    /// and the standardisation of locations folded in.
    pub simulator_bias: [f32; SIMULATOR_HIDDEN],
}

/// The rows of the relation decoder of a superlative.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Superlative {
    /// As [`Action::relation_decoder`].
    pub decoder: [[f32; INSTRUCTION]; 2],
    /// As [`Action::relation_bias`].
    pub bias: [f32; 2],
}

impl Superlative {
    /// Whether the model was taught which words mean it. Otherwise all weights are 0.
    pub fn is_relation(&self) -> bool {
        is_taught(&self.decoder)
    }
}

fn is_taught(decoder: &[[f32; INSTRUCTION]; 2]) -> bool {
    decoder.iter().flatten().any(|weight| *weight != 0.0)
}

impl Action<'_> {
    /// Whether the model was taught that descriptions may relate objects by what the action brings
    /// about: "the block on the red one". Otherwise all weights of its relation decoder are 0.
    pub fn is_relation(&self) -> bool {
        is_taught(&self.relation_decoder)
    }
}

/// Parameters of the language module that belong to no single word.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Language<'a> {
    /// The encoder's forward cell.
    pub forward: Cell<'a, WORD, ENCODER_HIDDEN>,
    /// The encoder's backward cell.
    pub backward: Cell<'a, WORD, ENCODER_HIDDEN>,
    /// From the instruction embedding to `c_1`, compared with each group's state.
    pub object_decoder: Dense<'a, INSTRUCTION, INSTRUCTION>,
    /// From the instruction embedding to `c_2`.
    pub reference_decoder: Dense<'a, INSTRUCTION, INSTRUCTION>,
    /// From the encoder's states at a word to the hidden layer (tanh) of its acceptability.
    pub acceptability_hidden: Dense<'a, INSTRUCTION, ACCEPTABILITY_HIDDEN>,
    /// From that hidden layer to the logit.
    pub acceptability: &'a Linear<ACCEPTABILITY_HIDDEN, 1>,
    /// "nearest to", in descriptions.
    pub nearest: &'a Superlative,
    /// "farthest from".
    pub farthest: &'a Superlative,
    /// The splitter's cell.
    pub splitter: Cell<'a, SPLITTER_WORD, SPLITTER_HIDDEN>,
    /// From the splitter's state and the next [`LOOKAHEAD`] tokens to the hazard's hidden layer
    /// (tanh).
    pub hazard_hidden: Dense<'a, HAZARD_INPUT, SPLITTER_HIDDEN>,
    /// From the hazard's hidden layer to its logit.
    pub hazard: &'a Linear<SPLITTER_HIDDEN, 1>,
}

/// The crop encoder: one small convolutional network per view.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Vision<'a> {
    /// On red, green and blue.
    pub color: &'a ViewEncoder<'a, 3>,
    /// On brightness.
    pub brightness: &'a ViewEncoder<'a, 1>,
}

/// `Conv 4×4/4 → ReLU → Conv 2×2/2 → ReLU → Linear → ReLU`.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct ViewEncoder<'a, const CHANNELS: usize> {
    /// 32×32 to 8×8.
    pub patch: PatchConv<CHANNELS, PATCH_CHANNELS>,
    /// 8×8 to 4×4.
    pub merge: MergeConv<PATCH_CHANNELS, MERGE_CHANNELS>,
    /// Flattened by row, column, channel.
    pub dense: Dense<'a, MERGED, VIEW_EMBEDDING>,
}

/// `loc' = base + MLP(action, loc_1, loc_2)`, where base has the moved object's
/// width and height at the reference's centre and depth; tanh between layers.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Simulator<'a> {
    /// Columns of the first layer for the moved object's and the reference's
    /// centre x, centre y, width, height and depth, standardisation folded in.
    pub input: [[f32; SIMULATOR_HIDDEN]; 2 * LOCATION],
    /// Second layer.
    pub hidden: Dense<'a, SIMULATOR_HIDDEN, SIMULATOR_HIDDEN>,
    /// Change of centre x, centre y, width, height and depth, the output's scale
    /// folded in.
    pub output: Linear<SIMULATOR_HIDDEN, LOCATION>,
}

/// Linear map from `(X, Y, D, W, H, 1)` to the object's centre in the camera's
/// frame, all in metres: the box's centre and size deprojected at mean depth D.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct PixelToCamera {
    /// A row for each of x, y, z.
    pub weight: [[f32; 6]; 3],
}
