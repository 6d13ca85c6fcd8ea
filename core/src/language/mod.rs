//! From a sentence to a program (section IV-B): words to tokens, where the steps
//! part, a GRU encoder for each step, and decoders for its action and arguments.
//!
//! All of it is learned but one thing: which words name attribute values is given,
//! as in the paper. Such words next to each other become one token.

mod decoders;
mod encoder;
mod nearest;
mod segments;
mod splitter;
mod task;
mod tokens;

pub use decoders::{choose_action, choose_group};
pub use encoder::Encoder;
pub use nearest::nearest_word;
pub use splitter::{SPLIT_HAZARD, Splitter};
pub use task::{Parsed, ParsingTask, StepDecisions};
pub use tokens::{Reader, Span, Token, TokenKind, Tokens};
