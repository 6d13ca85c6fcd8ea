//! From a sentence to a program (section IV-B): words to tokens, a splitter into steps, a GRU
//! encoder for each step, a judge of its words' acceptability, and decoders for its action, the
//! relations between its descriptions and its arguments.
//!
//! Everything is learned except the words that name attribute values, which are given, as in the
//! paper. Adjacent words of this kind become one token.

mod acceptability;
mod apart;
mod arrangements;
mod compounds;
mod decoders;
mod distances;
mod encoder;
mod exceptions;
mod lists;
mod nearest;
mod off_table;
mod ordinals;
mod parsed;
mod perspectives;
mod phrases;
mod plurals;
mod pronouns;
mod reader;
mod relations;
mod repairs;
mod rephrasing;
mod segments;
mod sequence;
mod shifts;
mod simplification;
mod spelling;
mod splitter;
mod task;
mod tokens;
mod words;

pub use acceptability::Acceptability;
pub(crate) use arrangements::said_around;
pub(crate) use compounds::said_of_two;
pub use decoders::{choose_action, choose_group};
pub(crate) use distances::unit_of;
pub use encoder::Encoder;
pub use nearest::nearest_word;
pub use parsed::{Parsed, StepDecisions};
pub use reader::Reader;
pub(crate) use relations::SUPERLATIVES;
pub use relations::{GroupRole, choose_role};
pub(crate) use repairs::said_between;
pub(crate) use sequence::says_order;
pub use spelling::{Correction, word_hash};
pub use splitter::{SPLIT_HAZARD, Splitter};
pub use task::ParsingTask;
pub use tokens::{Corrections, Token, TokenKind, Tokens};
pub use words::Span;
