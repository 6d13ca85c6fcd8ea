//! Observes and plans with the pretrained model, on bare Linux: no standard
//! library, no allocator, no C library, one process and its stack.
//!
//! Reads from its standard input what [`input`] describes, writes the plan to its
//! standard output and exits with
//!
//! * 0: planned; a step is the object's id, position and orientation; behind them
//!   how sure the plan is
//! * 1: `plan` and `poll` came to different results
//! * 2: refused; the text is [`nsrm_core::Refusal::kind`] and, behind a blank, the
//!   word that may have been meant, if there is one
//! * 3: the scene was refused
//! * 4: the input is not as described
//!
//! **That it links is two proofs.** Nothing in it allocates: `extern crate alloc`
//! has no allocator here. Nothing in it panics: the panic handler calls a function
//! that does not exist, so the linker fails unless the optimiser has shown that
//! no path leads there, from [`ObservationTask`] over [`Scene::new`] to
//! [`Planner::plan`] and `poll`. It holds for release builds, in which fat LTO
//! sees everything.

#![no_std]
#![no_main]

mod input;
mod linux;

#[cfg(feature = "allocate")]
extern crate alloc;

use core::task::Poll;
use input::Input;
use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_core::{Planner, Refusal, Scene};
#[cfg(not(feature = "int8"))]
use nsrm_tabletop::TABLETOP as MODEL;
#[cfg(feature = "int8")]
use nsrm_tabletop::TABLETOP_INT8 as MODEL;

/// Bytes of the largest image, 640 × 480.
const IMAGE_BYTES: usize = 640 * 480 * 3;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        /// Defined nowhere: what calls it does not link.
        fn a_panic_path_is_left() -> !;
    }
    // SAFETY: a program with this call in it does not exist.
    unsafe { a_panic_path_is_left() }
}

/// Called by `_start` in [`linux`] with an aligned stack.
#[unsafe(no_mangle)]
extern "C" fn program() -> ! {
    linux::exit(run())
}

fn run() -> i32 {
    let mut pixels = [0; IMAGE_BYTES];
    let Some(input) = Input::read(&mut pixels) else {
        return 4;
    };
    #[cfg(feature = "panic")]
    assert!(input.sentence().len() != 13, "a path that panics");
    #[cfg(feature = "allocate")]
    let _boxed = alloc::boxed::Box::new(input.sentence().len());

    let Some(scene) = observe(&input) else {
        return 3;
    };
    let planner = Planner::new(&MODEL);
    let whole = planner.plan(&scene, input.sentence());
    let mut task = planner.begin(&scene, input.sentence());
    let polled = loop {
        if let Poll::Ready(result) = task.poll() {
            break result;
        }
    };
    if whole.as_ref() != polled.as_ref().copied() {
        return 1;
    }
    match polled {
        Ok(plan) => {
            for goal in plan.sub_goals() {
                linux::write(&goal.object.to_le_bytes());
                for number in goal.pose.translation.vector.iter() {
                    linux::write(&number.to_le_bytes());
                }
                for number in goal.pose.rotation.coords.iter() {
                    linux::write(&number.to_le_bytes());
                }
            }
            linux::write(&plan.confidence().to_le_bytes());
            0
        }
        Err(refusal) => refused(&refusal, input.sentence()),
    }
}

fn refused(refusal: &Refusal, sentence: &str) -> i32 {
    linux::write(refusal.kind().as_bytes());
    if let Some(word) = refusal.suggestion(&MODEL, sentence) {
        linux::write(b" ");
        linux::write(word.as_bytes());
    }
    2
}

/// The scene, through the same check that one from another process goes through.
fn observe(input: &Input<'_>) -> Option<Scene> {
    let camera = input.camera;
    let stride = usize::try_from(camera.width).ok()?.checked_mul(3)?;
    let image = RgbImage::new(input.pixels, camera.width, camera.height, stride).ok()?;
    let detections = input.detections();
    let mut task =
        ObservationTask::new(&MODEL, image, camera, detections, Stamp::default()).ok()?;
    let observed = loop {
        if let Poll::Ready(scene) = task.poll() {
            break scene.ok()?;
        }
    };
    Scene::new(*observed.raw(), &MODEL).ok()
}
