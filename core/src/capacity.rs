//! The capacities, each defined once. Exceeding one is a typed refusal, never a panic.

/// Objects in a scene.
pub const MAX_OBJECTS: usize = 16;
/// Steps in a program.
pub const MAX_STEPS: usize = 8;
/// Tokens in a sentence, a group of concept words counted as one.
pub const MAX_TOKENS: usize = 128;
/// Tokens in one step.
pub const MAX_STEP_TOKENS: usize = 64;
/// Bytes in a sentence, so that reading one word is bounded work.
pub const MAX_SENTENCE_BYTES: usize = 4096;
/// Concepts that describe one object: `Filter`s in front of one `Unique`.
pub const MAX_FILTERS: usize = 4;
/// Relations in one description: links of its chain.
pub const MAX_RELATIONS: usize = 2;
/// Objects that a step describes: the one to move and the reference.
pub(crate) const ARGUMENTS: usize = 2;
/// Groups of concept words in one step: the object to move, the reference, and those that their
/// relations refer to.
pub const MAX_GROUPS: usize = ARGUMENTS * (1 + MAX_RELATIONS);
/// Misspelt words of a sentence that are read as others.
pub const MAX_CORRECTIONS: usize = 4;
/// Readings of a sentence with misspelt words or pronouns that are tried.
pub const MAX_READINGS: usize = 16;
/// Ways to split a reading into steps that are tried.
pub const MAX_SPLITS: usize = 4;
/// Candidates that an ambiguous description lists, the best first.
pub const MAX_CANDIDATES: usize = 8;

// Counters of these sizes are kept in a byte, positions in a sentence in two.
const _: () = assert!(MAX_OBJECTS <= 255 && MAX_STEPS <= 255 && MAX_TOKENS <= 255);
const _: () = assert!(MAX_FILTERS <= 255 && MAX_GROUPS <= 255 && MAX_CANDIDATES <= MAX_OBJECTS);
const _: () = assert!(MAX_STEP_TOKENS <= MAX_TOKENS);
const _: () = assert!(MAX_SENTENCE_BYTES <= u16::MAX as usize);
