use nsrm_core::Model;

use crate::pointers;
use crate::scene::Camera;
use crate::status::{Status, status};
use crate::text::Text;

/// A model: the trained parameters, by reference. Read only; any number of tasks and threads may use
/// it at once.
#[derive(Debug)]
pub struct ModelHandle {
    magic: u64,
    model: Model<'static>,
}

/// "NSRM" and the version of this struct.
const MAGIC: u64 = 0x4e53_524d_0000_0001;

impl ModelHandle {
    #[cfg(any(feature = "tabletop", feature = "int8"))]
    const fn of(model: Model<'static>) -> Self {
        Self {
            magic: MAGIC,
            #[cfg(feature = "vision")]
            model,
            #[cfg(not(feature = "vision"))]
            model: model.without_vision(),
        }
    }
}

/// The built-in model: toy blocks on a table. Never null.
#[cfg(feature = "tabletop")]
#[unsafe(no_mangle)]
pub extern "C" fn nsrm_tabletop() -> *const ModelHandle {
    static TABLETOP: ModelHandle = ModelHandle::of(nsrm_tabletop::TABLETOP);
    &raw const TABLETOP
}

/// The built-in model with weights of eight bits. Never null. Not in every library: see
/// `NSRM_PRECISIONS` of CMake.
#[cfg(feature = "int8")]
#[unsafe(no_mangle)]
pub extern "C" fn nsrm_tabletop_int8() -> *const ModelHandle {
    static TABLETOP_INT8: ModelHandle = ModelHandle::of(nsrm_tabletop::TABLETOP_INT8);
    &raw const TABLETOP_INT8
}

/// # Safety
/// If it is neither null nor misaligned, it points to at least 8 bytes; if these are the magic
/// number's, to a model.
pub(crate) unsafe fn model(handle: *const ModelHandle) -> Result<&'static Model<'static>, Status> {
    pointers::check(handle)?;
    // SAFETY: the caller's promise.
    let magic = unsafe { (&raw const (*handle).magic).read() };
    if magic != MAGIC {
        return Err(Status::ErrorNotAModel);
    }
    // SAFETY: the caller's promise.
    Ok(&unsafe { &*handle }.model)
}

/// Numbers of a model.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelInfo {
    /// `sizeof(nsrm_model_info_t)`; set it before the call.
    pub size: u32,
    /// How many actions it knows: indices of `nsrm_action_name`.
    pub actions: u32,
    /// How many attribute values it knows: indices of `nsrm_concept_name`.
    pub concepts: u32,
    /// How many words it knows, besides those that name attribute values.
    pub words: u32,
    /// Ties a scene's embeddings to the model that computed them.
    pub tag: u64,
    /// The least score, a cosine, with which an object fits a description.
    pub match_score: f32,
    /// The least accepted probability of one of the parser's decisions.
    pub decision: f32,
    /// The least accepted confidence of a plan.
    pub confidence: f32,
    /// Least x, y, z of a sub-goal: world frame, metres.
    pub work_space_min: [f32; 3],
    /// Greatest x, y, z of a sub-goal: world frame, metres.
    pub work_space_max: [f32; 3],
    /// The camera that saw the demonstrations.
    pub training_camera: Camera,
    /// Bits of a weight of its large layers: 32, as trained, or 8.
    pub weight_bits: u32,
    /// How many further actions it knows that are made of others, "next to": indices of `nsrm_action_name`
    /// behind `actions`.
    pub compounds: u32,
    /// What it can count, "the second from the left": indices of `nsrm_ranked_name`.
    pub ranked: u32,
}

// SAFETY: the first field is the size.
unsafe impl pointers::Sized32 for ModelInfo {}

/// Checks a model as a loader does: every index is valid, every list is sorted, the header is valid.
/// `NSRM_ERROR_NOT_A_MODEL` if it must not be used.
///
/// # Safety
/// The pointer is valid or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_model_check(model: *const ModelHandle) -> Status {
    status(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { self::model(model) }?;
        model.check().map_err(|_| Status::ErrorNotAModel)
    })
}

/// Numbers of a model.
///
/// # Safety
/// The pointers are valid or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_model_info(
    model: *const ModelHandle,
    info: *mut ModelInfo,
) -> Status {
    status(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { self::model(model) }?;
        let header = &model.header;
        let count = |length: usize| u32::try_from(length).map_err(|_| Status::ErrorTooLarge);
        let told = ModelInfo {
            size: size_of::<ModelInfo>() as u32,
            actions: count(model.actions.len())?,
            concepts: count(model.concepts.len())?,
            words: count(model.words.len())?,
            tag: model.tag(),
            match_score: header.thresholds.match_score,
            decision: header.thresholds.decision,
            confidence: header.thresholds.confidence,
            work_space_min: header.work_space.min,
            work_space_max: header.work_space.max,
            training_camera: header.training_camera.into(),
            weight_bits: model.embeddings.precision().bits(),
            compounds: count(model.compounds.compounds.len())?,
            ranked: count(model.ordinals.ranked.len())?,
        };
        // SAFETY: the caller's promise.
        unsafe { pointers::write_sized(info, told) }
    })
}

/// The name of an action: `MoveOn`; behind `actions`, of one that is made of others: `MoveNextTo`. The text
/// lives as long as the model.
///
/// # Safety
/// The pointers are valid or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_action_name(
    model: *const ModelHandle,
    index: u32,
    name: *mut Text,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe {
        named(model, name, |model| {
            let index = u8::try_from(index).ok()?;
            model.action_name(index)
        })
    }
}

/// The name of an attribute value: `red`. The text lives as long as the model.
///
/// # Safety
/// The pointers are valid or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_concept_name(
    model: *const ModelHandle,
    index: u32,
    name: *mut Text,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe {
        named(model, name, |model| {
            let index = usize::try_from(index).ok()?;
            model.concepts.get(index).map(|concept| concept.name)
        })
    }
}

/// The name of what is counted: `second leftmost`. The text lives as long as the model.
///
/// # Safety
/// The pointers are valid or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_ranked_name(
    model: *const ModelHandle,
    index: u32,
    name: *mut Text,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe {
        named(model, name, |model| {
            let index = usize::try_from(index).ok()?;
            model.ordinals.ranked.get(index).map(|ranked| ranked.name)
        })
    }
}

/// # Safety
/// The pointers are valid or null.
unsafe fn named(
    model: *const ModelHandle,
    name: *mut Text,
    find: impl FnOnce(&'static Model<'static>) -> Option<&'static str>,
) -> Status {
    status(|| {
        // SAFETY: the caller's promise.
        let model = unsafe { self::model(model) }?;
        let found = find(model).ok_or(Status::ErrorIndex)?;
        // SAFETY: the caller's promise.
        unsafe { pointers::write(name, Text::of(found)) }
    })
}
