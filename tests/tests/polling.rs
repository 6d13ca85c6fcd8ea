//! `poll` gives the same plan or refusal as `plan`, in a bounded number of calls.

use core::task::Poll;
use nsrm_core::planner::MAX_POLLS;
use nsrm_core::{MAX_STEPS, MAX_TOKENS, Model, Plan, Planner, Refusal, Scene};
use nsrm_tests::by_hand::{self, Parts, block};

/// Polls to the end; returns the result and the number of calls.
fn poll(model: &Model<'_>, scene: &Scene, sentence: &str) -> (Result<Plan, Refusal>, usize) {
    let mut task = Planner::new(model).begin(scene, sentence);
    for polls in 1..=MAX_POLLS {
        if let Poll::Ready(result) = task.poll() {
            let result = result.cloned();
            let Poll::Ready(again) = task.poll() else {
                panic!("what is done stays done");
            };
            assert_eq!(result.as_ref(), again.as_ref().copied());
            return (result, polls);
        }
    }
    panic!("{sentence:?} takes more than {MAX_POLLS} calls");
}

#[test]
fn it_is_what_plan_gives() {
    let parts = Parts::new();
    let model = parts.model();
    let blocks = [
        block("small", "red"),
        block("lego", "red"),
        block("lego", "blue"),
    ];
    let scene = by_hand::scene(&model, &blocks);
    for sentence in [
        "put the small red block on the blue block",
        "put the small red block on the blue block then put the red lego beside the small block",
        "put the red block on the blue block",
        "put the small red block on the moon",
        "put the small red block",
        "",
    ] {
        let (result, _) = poll(&model, &scene, sentence);
        assert_eq!(result, Planner::new(&model).plan(&scene, sentence));
    }
}

#[test]
fn the_longest_sentence_over_the_fullest_scene_stays_within_the_bound() {
    let parts = Parts::new();
    let model = parts.model();
    let mut blocks = vec![block("lego", "green"); 16];
    blocks[14] = block("small", "red");
    blocks[15] = block("lego", "blue");
    let scene = by_hand::scene(&model, &blocks);
    // The greatest number of steps, of words, and of concept words in one group.
    let step = "put the small red small red block on the blue lego blue lego then ";
    let tokens_of_step = 8;
    let mut sentence = step.repeat(MAX_STEPS);
    let rest = MAX_TOKENS - MAX_STEPS * tokens_of_step;
    sentence.truncate(sentence.len() - "then ".len());
    // In the first and the last step: none of them may have all.
    let sentence = "the ".repeat(rest / 2) + &sentence + &"the ".repeat(rest - rest / 2 + 1);
    let (result, polls) = poll(&model, &scene, &sentence);
    assert_eq!(result.unwrap().steps().len(), MAX_STEPS);
    // One more word is refused, so this was the longest sentence.
    let longer = sentence + "the";
    assert!(matches!(
        poll(&model, &scene, &longer).0,
        Err(Refusal::SentenceTooLong { .. })
    ));
    println!("{polls} calls of at most {MAX_POLLS}");
}

#[test]
fn no_two_tasks_share_anything() {
    let parts = Parts::new();
    let model = parts.model();
    let scene = by_hand::scene(&model, &[block("small", "red"), block("lego", "blue")]);
    let planner = Planner::new(&model);
    let sentences = [
        "put the red block on the blue block",
        "put the lego beside the small block",
    ];
    let mut tasks = sentences.map(|sentence| planner.begin(&scene, sentence));
    let mut results = [None, None];
    while results.iter().any(Option::is_none) {
        for (task, result) in tasks.iter_mut().zip(&mut results) {
            if let Poll::Ready(done) = task.poll() {
                *result = Some(done.cloned());
            }
        }
    }
    for (sentence, result) in sentences.iter().zip(results) {
        assert_eq!(result, Some(planner.plan(&scene, sentence)));
    }
}
