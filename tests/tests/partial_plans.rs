//! A plan for the rest of a program has the same steps as the plan for the whole program.

use core::task::Poll;
use std::sync::LazyLock;

use nsrm::json;
use nsrm_core::planner::Plan;
use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_core::{Model, Planner, Scene};
use nsrm_tabletop::TABLETOP;
use nsrm_tests::picture;
use serde_json::Value;

/// The pretrained model without limits of its work space: it was trained on blocks, and would put
/// the squares outside.
static MODEL: LazyLock<Model<'static>> = LazyLock::new(|| {
    let mut model = TABLETOP;
    // The same middle, about which the view is turned.
    model.header.work_space.min = [-0.5, -1.0, -1.0];
    model.header.work_space.max = [1.5, 1.0, 1.0];
    model
});

const SENTENCE: &str = "put the red block on the blue block then put the yellow block on the red \
                        block then put the magenta block on the green block";

#[test]
fn json_of_the_rest_of_a_program_names_its_own_steps() {
    let scene = scene();
    let whole = rest(&scene, 0);
    let all = json::plan(&MODEL, &whole, SENTENCE);
    let steps = steps(&all);
    assert_eq!(steps.len(), 3);
    for first in 0..=3 {
        let rest = json::plan(&MODEL, &rest(&scene, first), SENTENCE);
        assert_eq!(self::steps(&rest).len(), 3 - first);
        for (got, whole) in self::steps(&rest).iter().zip(&steps[first..]) {
            for key in ["step", "action", "object", "reference", "object_id"] {
                assert_eq!(got[key], whole[key], "{key} with {first} steps done");
            }
            let told = got["explanation"].as_str().expect("a sentence");
            let number = got["step"].as_u64().expect("a number") + 1;
            assert!(told.starts_with(&format!("Step {number}: ")), "{told}");
        }
        // The program is that of the whole sentence.
        assert_eq!(rest["notation"], all["notation"]);
    }
}

#[test]
fn numbers_are_those_of_the_program() {
    let scene = scene();
    let rest = rest(&scene, 1);
    let numbers: Vec<_> = rest.numbered().map(|(number, ..)| number).collect();
    assert_eq!(numbers, [1, 2]);
    for (number, understood, planned) in rest.numbered() {
        assert_eq!(Some(understood), rest.program().steps().get(number));
        assert_eq!(understood.action, planned.action);
    }
}

fn steps(plan: &Value) -> Vec<Value> {
    plan["steps"].as_array().expect("a list").clone()
}

/// The plan for the rest of the program, from step `first` on.
fn rest(scene: &Scene, first: usize) -> Plan {
    let planner = Planner::new(&MODEL);
    let parsed = planner.parse(SENTENCE).expect("words that are known");
    let mut task = planner.begin_grounding(*scene, &parsed, first);
    loop {
        if let Poll::Ready(plan) = task.poll() {
            return plan.cloned().expect("a sentence that fits the squares");
        }
    }
}

fn scene() -> Scene {
    let picture = picture::squares();
    let [width, height] = picture::SIZE;
    let image = RgbImage::new(&picture.pixels, width, height, 3 * width as usize);
    let image = image.expect("an image");
    let (camera, boxes) = (picture::camera(), &picture.detections);
    let task = ObservationTask::new(&MODEL, image, camera, boxes, Stamp::default());
    task.and_then(ObservationTask::finish).expect("a scene")
}
