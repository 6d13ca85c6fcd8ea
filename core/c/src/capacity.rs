//! The capacities, as numbers that C can read.

/// Objects in a scene.
pub const MAX_OBJECTS: usize = 16;
/// Steps in a program.
pub const MAX_STEPS: usize = 8;
/// Attribute values that describe one object.
pub const MAX_FILTERS: usize = 4;
/// Relations in one description.
pub const MAX_RELATIONS: usize = 2;
/// Misspelt words of a sentence that are read as others.
pub const MAX_CORRECTIONS: usize = 4;
/// Candidates that are listed where several objects fit.
pub const MAX_CANDIDATES: usize = 8;
/// Bytes in a sentence.
pub const MAX_SENTENCE_BYTES: usize = 4096;
/// Calls of `nsrm_poll` until it is done, at most.
pub const MAX_POLLS: usize = 157_209;
/// Numbers in an object's embedding.
pub const EMBEDDING: usize = 64;

const _: () = {
    assert!(MAX_OBJECTS == nsrm_core::MAX_OBJECTS);
    assert!(MAX_STEPS == nsrm_core::MAX_STEPS);
    assert!(MAX_FILTERS == nsrm_core::MAX_FILTERS);
    assert!(MAX_RELATIONS == nsrm_core::MAX_RELATIONS);
    assert!(MAX_CORRECTIONS == nsrm_core::MAX_CORRECTIONS);
    assert!(MAX_CANDIDATES == nsrm_core::MAX_CANDIDATES);
    assert!(MAX_SENTENCE_BYTES == nsrm_core::MAX_SENTENCE_BYTES);
    assert!(MAX_POLLS == nsrm_core::planner::MAX_POLLS);
    assert!(EMBEDDING == nsrm_core::model::OBJECT_EMBEDDING);
};
