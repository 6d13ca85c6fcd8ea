//! What a control loop relies on: planning and observing make no system call, so that nothing can
//! block, cause no page fault once they have run, and meet no denormal numbers, which some processors
//! compute a hundred times more slowly.
#![cfg(target_os = "linux")]

use std::hint::black_box;

use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_core::{Planner, Scene};
use nsrm_tabletop::TABLETOP;
use nsrm_tests::picture::{Picture, SIZE, camera, squares};

const SENTENCES: [&str; 5] = [
    "put the red block on the blue block",
    "put the green block on the blue block, then move the magenta one on the green one",
    "put the block left of the green block on the blue block",
    "could you please drop that yelow brick on the blue one's left",
    "fly to the moon",
];

fn observe(picture: &Picture) -> Scene {
    let [width, height] = SIZE;
    let image = RgbImage::new(&picture.pixels, width, height, 3 * width as usize);
    let image = image.expect("an image");
    let detections = &picture.detections;
    ObservationTask::new(&TABLETOP, image, camera(), detections, Stamp::default())
        .and_then(ObservationTask::finish)
        .expect("a scene")
}

/// From the image to plans and refusals.
fn work(picture: &Picture) {
    let scene = observe(black_box(picture));
    let planner = Planner::new(&TABLETOP);
    for sentence in SENTENCES {
        let _ = black_box(planner.plan(&scene, black_box(sentence)));
    }
}

/// How a child process ended.
#[derive(Debug, PartialEq, Eq)]
enum Ended {
    /// With this code.
    Exited(i32),
    Killed,
}

/// Runs a job in a child process, which exits with what it returns. Nothing else happens there: no
/// other test takes its time or its memory.
fn in_child(job: impl FnOnce() -> i32) -> Ended {
    // SAFETY: between fork and exit the child runs `job` and system calls alone, on its only thread;
    // it takes no lock that another thread of its parent may have held.
    unsafe {
        let child = libc::fork();
        assert!(child >= 0, "fork: {}", std::io::Error::last_os_error());
        if child == 0 {
            // `exit` ends the thread. `exit_group`, which libc calls, is a call too many.
            libc::syscall(libc::SYS_exit, job());
        }
        let mut status = 0;
        assert_eq!(libc::waitpid(child, &raw mut status, 0), child);
        if libc::WIFSIGNALED(status) {
            assert_eq!(libc::WTERMSIG(status), libc::SIGKILL);
            return Ended::Killed;
        }
        Ended::Exited(libc::WEXITSTATUS(status))
    }
}

/// Otherwise the work would end before the last stages.
#[test]
fn the_work_has_plans_and_refusals() {
    let scene = observe(&squares());
    let planner = Planner::new(&TABLETOP);
    let kinds = SENTENCES.map(|sentence| match planner.plan(&scene, sentence) {
        Ok(_) => "planned",
        Err(refusal) => refusal.kind(),
    });
    assert_eq!(
        kinds,
        ["planned", "planned", "planned", "planned", "unknown_word"]
    );
}

#[test]
fn planning_and_observing_make_no_system_call() {
    const NO_SECCOMP: i32 = 3;
    // From here on the process may only read, write and exit.
    let sealed = || {
        // SAFETY: it takes numbers alone.
        unsafe { libc::prctl(libc::PR_SET_SECCOMP, libc::SECCOMP_MODE_STRICT) == 0 }
    };
    let picture = squares();
    let ended = in_child(|| {
        if !sealed() {
            return NO_SECCOMP;
        }
        work(&picture);
        0
    });
    assert_eq!(ended, Ended::Exited(0));
    // What makes one does not come to its end.
    let ended = in_child(|| {
        if !sealed() {
            return NO_SECCOMP;
        }
        // SAFETY: it has no arguments.
        unsafe { libc::syscall(libc::SYS_sched_yield) };
        0
    });
    assert_eq!(ended, Ended::Killed);
}

/// Page faults of this thread so far.
fn page_faults() -> i64 {
    // SAFETY: all-zero is a valid `rusage`, which the call fills.
    unsafe {
        let mut usage: libc::rusage = std::mem::zeroed();
        libc::getrusage(libc::RUSAGE_THREAD, &raw mut usage);
        usage.ru_minflt + usage.ru_majflt
    }
}

#[test]
fn once_warm_planning_and_observing_cause_no_page_fault() {
    let picture = squares();
    let mut fresh = vec![1_u8; 1 << 22];
    let ended = in_child(|| {
        work(&picture);
        let before = page_faults();
        for _ in 0..20 {
            work(&picture);
        }
        i32::try_from(page_faults() - before).unwrap_or(-1)
    });
    assert_eq!(ended, Ended::Exited(0));
    // Memory that the child shares with its parent is copied when it is written.
    let ended = in_child(|| {
        let before = page_faults();
        black_box(&mut fresh).fill(2);
        i32::from(page_faults() > before)
    });
    assert_eq!(ended, Ended::Exited(1));
}

#[cfg(target_arch = "x86_64")]
mod denormals {
    use std::arch::asm;

    use super::*;

    /// Flags of the control and status register: an operand, or a result, was denormal.
    const OPERAND: u32 = 1 << 1;
    const RESULT: u32 = 1 << 4;

    /// Which of the two flags a job sets.
    fn met(job: impl FnOnce()) -> u32 {
        let mut register = 0_u32;
        // SAFETY: the register is read and written as it is, but for the two flags.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut register) };
        let cleared = register & !(OPERAND | RESULT);
        // SAFETY: the same.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const cleared) };
        job();
        // SAFETY: the same.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut register) };
        register & (OPERAND | RESULT)
    }

    #[test]
    fn planning_and_observing_meet_no_denormal_numbers() {
        let picture = squares();
        assert_eq!(met(|| work(&picture)), 0);
        assert_ne!(met(|| _ = black_box(black_box(1e-40_f32) * 0.5)), 0);
    }

    /// Nor does any weight of the model become one when it is multiplied.
    #[test]
    fn denormal_inputs_give_a_plan_or_a_refusal() {
        let mut raw = *observe(&squares()).raw();
        for object in &mut raw.objects {
            object.embedding = object.embedding.map(|value| value * 1e-42);
        }
        let scene = Scene::new(raw, &TABLETOP).expect("finite numbers");
        for sentence in SENTENCES {
            match Planner::new(&TABLETOP).plan(&scene, sentence) {
                Ok(plan) => assert!(plan.confidence().is_finite()),
                Err(refusal) => assert_ne!(refusal.kind(), "not_finite"),
            }
        }
    }
}
