use core::ffi::c_char;
use core::task::Poll;

use nsrm_core::language::{Parsed, ParsingTask};
use nsrm_core::{
    GroundingTask, Model, Planner, PlanningTask, Refusal as CoreRefusal, Scene, SceneError, planner,
};

use crate::memory::Slot;
use crate::model::{self, ModelHandle};
use crate::plan::Plan;
use crate::pointers;
use crate::program::Program;
use crate::refusal::Refusal;
use crate::scene::{self, checked};
use crate::status::{Status, status};
use crate::text::{self, write_text};

/// Bytes of a task.
pub const TASK_BYTES: usize = 15_744;

/// Memory of a task, which the caller owns: static, on the stack or anywhere else. Initialise it with
/// `nsrm_begin` or another function that begins; it needs no cleaning up. Do not copy it while something
/// is begun in it.
#[repr(C)]
#[derive(Clone, Copy)]
pub union TaskMemory {
    /// Aligns it.
    pub alignment: u64,
    /// Its bytes.
    pub bytes: [u8; TASK_BYTES],
}

// Never less than needed, and on 64 bits little more.
const _: () = {
    assert!(align_of::<Slot<Task>>() <= align_of::<TaskMemory>());
    assert!(size_of::<Slot<Task>>() <= size_of::<TaskMemory>());
    assert!(usize::BITS < 64 || size_of::<Slot<Task>>() + 512 > size_of::<TaskMemory>());
};

/// What is begun in a task's memory. Scene and sentence are the caller's.
struct Task {
    model: &'static Model<'static>,
    sentence: &'static str,
    work: Work,
}

// All in the caller's memory, of which there is enough for the largest.
#[allow(clippy::large_enum_variant)]
enum Work {
    Parsing(ParsingTask<'static, &'static str>),
    Planning(PlanningTask<'static, &'static Scene, &'static str>),
    Grounding(GroundingTask<'static, &'static Scene>),
    /// The scene agrees with the calibration, or does not.
    Checked(Result<(), CoreRefusal>),
    /// There is no scene to plan in.
    InvalidScene(SceneError),
}

impl Task {
    /// Does one unit of work.
    fn poll(&mut self) -> Status {
        let result = match &mut self.work {
            Work::Parsing(task) => task.poll().map(|parsed| parsed.is_ok()),
            Work::Planning(task) => task.poll().map(|plan| plan.is_ok()),
            Work::Grounding(task) => task.poll().map(|plan| plan.is_ok()),
            Work::Checked(result) => Poll::Ready(result.is_ok()),
            Work::InvalidScene(_) => return Status::InvalidInput,
        };
        match result {
            Poll::Pending => Status::Pending,
            Poll::Ready(true) => Status::Ok,
            Poll::Ready(false) => Status::Refused,
        }
    }

    fn poll_to_the_end(&mut self) -> Status {
        loop {
            let status = self.poll();
            if status != Status::Pending {
                return status;
            }
        }
    }

    /// Once done; a refusal has its own status.
    fn plan(&mut self) -> Result<&planner::Plan, Status> {
        let result = match &mut self.work {
            Work::Planning(task) => task.poll(),
            Work::Grounding(task) => task.poll(),
            _ => return Err(Status::ErrorNotBegun),
        };
        match result {
            Poll::Pending => Err(Status::ErrorNotDone),
            Poll::Ready(plan) => plan.map_err(|_| Status::Refused),
        }
    }

    /// Once done; of a refused plan, too, if the sentence itself was understood.
    fn parsed(&mut self) -> Result<&Parsed, Status> {
        match &mut self.work {
            Work::Parsing(task) => match task.poll() {
                Poll::Pending => Err(Status::ErrorNotDone),
                Poll::Ready(Err(_)) => Err(Status::Refused),
                Poll::Ready(Ok(parsed)) => Ok(parsed),
            },
            Work::Planning(task) => task.parsed().ok_or(Status::ErrorNotDone),
            Work::Grounding(task) => Ok(task.parsed()),
            _ => Err(Status::ErrorNotBegun),
        }
    }

    /// Why there is no plan or program.
    fn refusal(&mut self) -> Result<CoreRefusal, Status> {
        let result = match &mut self.work {
            Work::Parsing(task) => task.poll().map(Result::err),
            Work::Planning(task) => task.poll().map(Result::err),
            Work::Grounding(task) => task.poll().map(Result::err),
            Work::Checked(result) => Poll::Ready(result.err()),
            Work::InvalidScene(_) => Poll::Ready(None),
        };
        match result {
            Poll::Pending => Err(Status::ErrorNotDone),
            Poll::Ready(refusal) => refusal.ok_or(Status::ErrorNotBegun),
        }
    }
}

/// What a pointer to a task points to.
const fn slot(task: *mut TaskMemory) -> *mut Slot<Task> {
    task.cast()
}

/// Begins in the memory, and says whether there is a scene to go on with.
///
/// # Safety
/// If `task` is neither null nor misaligned, it points to memory for a task.
unsafe fn begin(task: *mut TaskMemory, make: impl FnOnce() -> Result<Task, Status>) -> Status {
    let mut first = Status::Pending;
    // SAFETY: the caller's promise.
    let begun = unsafe {
        Slot::begin(slot(task), || {
            let task = make()?;
            first = match &task.work {
                Work::InvalidScene(_) => Status::InvalidInput,
                Work::Checked(Err(_)) => Status::Refused,
                Work::Checked(Ok(())) => Status::Ok,
                _ => Status::Pending,
            };
            Ok(task)
        })
    };
    begun.err().unwrap_or(first)
}

/// Begins to plan a sentence in a scene; `nsrm_poll` does the work.
///
/// Returns `NSRM_PENDING`, `NSRM_INVALID_INPUT` if the scene is invalid, or an error.
///
/// * `sentence`: UTF-8, `length` bytes; it needs no zero behind it
///
/// The model, the scene and the sentence must stay where they are, unchanged, as long as the task is
/// used. The scene is checked once, here.
///
/// # Safety
/// Each pointer is null or valid; `sentence` points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_begin(
    task: *mut TaskMemory,
    model: *const ModelHandle,
    scene: *const scene::Scene,
    sentence: *const c_char,
    length: usize,
) -> Status {
    // SAFETY: the caller's promises.
    unsafe {
        begin(task, || {
            let model = model::model(model)?;
            let sentence = text::sentence(sentence, length)?;
            let work = match checked(scene, model)? {
                Ok(scene) => Work::Planning(Planner::new(model).begin(scene, sentence)),
                Err(error) => Work::InvalidScene(error),
            };
            Ok(Task {
                model,
                sentence,
                work,
            })
        })
    }
}

/// Begins to parse a sentence without a scene, as `nsrm_begin` begins to plan one.
///
/// # Safety
/// As `nsrm_begin`'s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_begin_parsing(
    task: *mut TaskMemory,
    model: *const ModelHandle,
    sentence: *const c_char,
    length: usize,
) -> Status {
    // SAFETY: the caller's promises.
    unsafe {
        begin(task, || {
            let model = model::model(model)?;
            let sentence = text::sentence(sentence, length)?;
            let work = Work::Parsing(ParsingTask::new(model, sentence));
            Ok(Task {
                model,
                sentence,
                work,
            })
        })
    }
}

/// Begins to ground the program that a task has parsed in a scene as it is now, from step `first` on
/// (from 0): a plan for the rest of the sentence. Refusals count steps as in the whole sentence.
///
/// The task is one whose program `nsrm_get_program` gives: parsed, planned or grounded before. Returns
/// what `nsrm_begin` does; the task then has this result.
///
/// # Safety
/// As `nsrm_begin`'s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_begin_grounding(
    task: *mut TaskMemory,
    scene: *const scene::Scene,
    first: u32,
) -> Status {
    // SAFETY: the caller's promises.
    let begun = unsafe {
        Slot::with(slot(task), |task| {
            let parsed = task.parsed()?.clone();
            let first = usize::try_from(first).map_err(|_| Status::ErrorIndex)?;
            if first >= parsed.program().steps().len() {
                return Err(Status::ErrorIndex);
            }
            match checked(scene, task.model)? {
                Ok(scene) => {
                    let planner = Planner::new(task.model);
                    task.work = Work::Grounding(planner.begin_grounding(scene, &parsed, first));
                    Ok(Status::Pending)
                }
                Err(error) => {
                    task.work = Work::InvalidScene(error);
                    Ok(Status::InvalidInput)
                }
            }
        })
    };
    begun.unwrap_or_else(|error| error)
}

/// Does one bounded unit of work. Returns `NSRM_PENDING` until it is done, then `NSRM_OK` or
/// `NSRM_REFUSED`, also on every further call.
///
/// # Safety
/// `task` is null, or memory in which something was begun, or that is all zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_poll(task: *mut TaskMemory) -> Status {
    // SAFETY: the caller's promise.
    let polled = unsafe { Slot::with(slot(task), |task| Ok(task.poll())) };
    polled.unwrap_or_else(|error| error)
}

/// Polls what was begun to its end, and gets its result.
///
/// # Safety
/// As [`nsrm_poll`]'s.
unsafe fn finish(task: *mut TaskMemory, begun: Status, get: impl FnOnce() -> Status) -> Status {
    if begun != Status::Pending {
        return begun;
    }
    // SAFETY: the caller's promise.
    let polled = unsafe { Slot::with(slot(task), |task| Ok(task.poll_to_the_end())) };
    match polled.unwrap_or_else(|error| error) {
        Status::Ok => get(),
        other => other,
    }
}

/// Plans a sentence in a scene at once: `nsrm_begin`, `nsrm_poll` to the end and `nsrm_get_plan`.
///
/// Returns `NSRM_OK`, `NSRM_REFUSED`, `NSRM_INVALID_INPUT` or an error. Unless it is `NSRM_OK`, the plan
/// has no sub-goals.
///
/// # Safety
/// As `nsrm_begin`'s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_plan(
    task: *mut TaskMemory,
    model: *const ModelHandle,
    scene: *const scene::Scene,
    sentence: *const c_char,
    length: usize,
    plan: *mut Plan,
) -> Status {
    // SAFETY: the caller's promises.
    unsafe {
        if let Err(error) = pointers::write_sized(plan, Plan::empty()) {
            return error;
        }
        let begun = nsrm_begin(task, model, scene, sentence, length);
        finish(task, begun, || nsrm_get_plan(task, plan))
    }
}

/// Parses a sentence at once: `nsrm_begin_parsing`, `nsrm_poll` to the end and `nsrm_get_program`. Unless
/// it returns `NSRM_OK`, the program has no steps.
///
/// # Safety
/// As `nsrm_begin`'s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_parse(
    task: *mut TaskMemory,
    model: *const ModelHandle,
    sentence: *const c_char,
    length: usize,
    program: *mut Program,
) -> Status {
    // SAFETY: the caller's promises.
    unsafe {
        if let Err(error) = pointers::write_sized(program, Program::empty()) {
            return error;
        }
        let begun = nsrm_begin_parsing(task, model, sentence, length);
        finish(task, begun, || nsrm_get_program(task, program))
    }
}

/// Checks that a scene agrees with the camera's calibration, as planning does first; use it when a
/// camera is set up. Returns `NSRM_OK`, `NSRM_REFUSED`, `NSRM_INVALID_INPUT` or an error.
///
/// # Safety
/// As `nsrm_begin`'s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_check(
    task: *mut TaskMemory,
    model: *const ModelHandle,
    scene: *const scene::Scene,
) -> Status {
    // SAFETY: the caller's promises.
    unsafe {
        begin(task, || {
            let model = model::model(model)?;
            let work = match checked(scene, model)? {
                Ok(scene) => Work::Checked(Planner::new(model).check(scene)),
                Err(error) => Work::InvalidScene(error),
            };
            let sentence = "";
            Ok(Task {
                model,
                sentence,
                work,
            })
        })
    }
}

/// The plan of a task that is done. Unless it returns `NSRM_OK`, the plan has no sub-goals.
///
/// # Safety
/// As `nsrm_poll`'s; `plan` is null or valid, its size set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_get_plan(task: *mut TaskMemory, plan: *mut Plan) -> Status {
    // SAFETY: the caller's promises.
    status(|| unsafe {
        pointers::write_sized(plan, Plan::empty())?;
        Slot::with(slot(task), |task| {
            pointers::write_sized(plan, Plan::from(task.plan()?))
        })
    })
}

/// The program of a task that has parsed its sentence, also if there is no plan in the scene. Unless it
/// returns `NSRM_OK`, the program has no steps.
///
/// # Safety
/// As `nsrm_poll`'s; `program` is null or valid, its size set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_get_program(task: *mut TaskMemory, program: *mut Program) -> Status {
    // SAFETY: the caller's promises.
    status(|| unsafe {
        pointers::write_sized(program, Program::empty())?;
        Slot::with(slot(task), |task| {
            let model = task.model;
            pointers::write_sized(program, Program::new(model, task.parsed()?))
        })
    })
}

/// Why a task has no result.
///
/// # Safety
/// As `nsrm_poll`'s; `refusal` is null or valid, its size set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_get_refusal(task: *mut TaskMemory, refusal: *mut Refusal) -> Status {
    // SAFETY: the caller's promises.
    status(|| unsafe {
        Slot::with(slot(task), |task| {
            pointers::write_sized(refusal, Refusal::from(&task.refusal()?))
        })
    })
}

/// Why a task has no result, in full sentences for a person: of a refusal, or of an invalid scene.
///
/// * `buffer`, `size`: where the text goes, UTF-8 with a zero behind it; cut if it does not fit
///   (`NSRM_TRUNCATED`)
/// * `needed`: how many bytes it takes, the zero included; may be null
///
/// # Safety
/// As `nsrm_poll`'s; `buffer` points to `size` bytes, `needed` is null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_refusal_message(
    task: *mut TaskMemory,
    buffer: *mut c_char,
    size: usize,
    needed: *mut usize,
) -> Status {
    // SAFETY: the caller's promises.
    status(|| unsafe {
        Slot::with(slot(task), |task| {
            if let Work::InvalidScene(error) = &task.work {
                return write_text(error, buffer, size, needed);
            }
            let refusal = task.refusal()?;
            let message = refusal.in_context(task.model, task.sentence);
            write_text(&message, buffer, size, needed)
        })
    })
}

/// The program in the paper's notation, a line for each step; see `nsrm_refusal_message`.
///
/// # Safety
/// As `nsrm_refusal_message`'s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_program_notation(
    task: *mut TaskMemory,
    buffer: *mut c_char,
    size: usize,
    needed: *mut usize,
) -> Status {
    // SAFETY: the caller's promises.
    status(|| unsafe {
        Slot::with(slot(task), |task| {
            let model = task.model;
            let notation = task.parsed()?.program().notation(model);
            write_text(&notation, buffer, size, needed)
        })
    })
}

/// What the plan does and why, a sentence for each step; see `nsrm_refusal_message`.
///
/// # Safety
/// As `nsrm_refusal_message`'s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_plan_explanation(
    task: *mut TaskMemory,
    buffer: *mut c_char,
    size: usize,
    needed: *mut usize,
) -> Status {
    // SAFETY: the caller's promises.
    status(|| unsafe {
        Slot::with(slot(task), |task| {
            let model = task.model;
            write_text(&task.plan()?.explain(model), buffer, size, needed)
        })
    })
}

/// `NSRM_TASK_BYTES` of the library: compare it with the header's.
#[unsafe(no_mangle)]
pub extern "C" fn nsrm_task_bytes() -> usize {
    TASK_BYTES
}
