//! No memory is allocated between image and sentence and the plan or refusal.

use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_core::{Model, Planner, Refusal, Scene};
use nsrm_tabletop::TABLETOP;
use nsrm_tests::by_hand::{self, Parts, block};
use nsrm_tests::counting::{Counting, counted};
use nsrm_tests::picture::{SIZE, camera, squares};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn the_counter_counts() {
    let (boxed, calls) = counted(|| Box::new(7));
    assert_eq!((*boxed, calls), (7, 1));
}

/// Writes nowhere: `Display` runs, and only that.
struct Nowhere;

impl std::fmt::Write for Nowhere {
    fn write_str(&mut self, _: &str) -> std::fmt::Result {
        Ok(())
    }
}

fn observe(model: &Model<'_>) -> (Scene, u64) {
    let picture = squares();
    let image = RgbImage::new(&picture.pixels, SIZE[0], SIZE[1], 3 * SIZE[0] as usize).unwrap();
    counted(|| {
        let task = ObservationTask::new(
            model,
            image,
            camera(),
            &picture.detections,
            Stamp::default(),
        );
        task.unwrap().finish().unwrap()
    })
}

#[test]
fn observing_and_planning_with_the_pretrained_model_allocates_nothing() {
    let (scene, calls) = observe(&TABLETOP);
    assert_eq!(calls, 0, "observing");
    let planner = Planner::new(&TABLETOP);
    for sentence in [
        "put the red block on the blue block",
        "put the small green block to the right of the lego block, then move the red one atop it",
        "fly to the moon",
        "",
    ] {
        // Plan or refusal, whichever it is: neither may allocate.
        let (result, calls) = counted(|| planner.plan(&scene, sentence));
        assert_eq!(calls, 0, "{sentence:?}: {result:?}");
    }
}

#[test]
fn a_plan_and_its_texts_allocate_nothing() {
    use std::fmt::Write;

    let parts = Parts::new();
    let model = parts.model();
    let blocks = [block("small", "red"), block("lego", "blue")];
    let scene = by_hand::scene(&model, &blocks);
    let planner = Planner::new(&model);
    let sentence = "put the red block on the blue block then put the lego beside the red block";
    let (plan, calls) = counted(|| planner.plan(&scene, sentence));
    let plan = plan.unwrap();
    assert_eq!((plan.steps().len(), calls), (2, 0));
    let notation = plan.program().notation(&model);
    let (written, calls) = counted(|| write!(Nowhere, "{notation}"));
    assert_eq!((written, calls), (Ok(()), 0), "the notation");

    let sentence = "put the green block on the blue block";
    let (refusal, calls) = counted(|| planner.plan(&scene, sentence));
    let refusal = refusal.unwrap_err();
    assert_eq!(calls, 0, "refusing");
    assert!(matches!(refusal, Refusal::NoSuchObject { .. }));
    let message = refusal.in_context(&model, sentence);
    let (written, calls) = counted(|| write!(Nowhere, "{message}"));
    assert_eq!((written, calls), (Ok(()), 0), "the message");
}
