//! The seeds of the targets: valid messages, sentences and files, and the words that libFuzzer may
//! combine.

use nsrm_core::{Planner, Refusal};
use nsrm_ipc::executive::{Command, CommandId, Event, Failure, Mode};
use nsrm_ipc::message::{
    CameraFrame, DetectedBox, Feedback, Heartbeat, Message, Outcome, PlanReply, PlanRequest,
    ReplyTo, Role, SceneMessage, State, SubGoal,
};
use nsrm_tabletop::TABLETOP;
use serde_json::json;

use super::bytes::bytes_of;
use super::executive::{BY_HAND, OBEDIENT, Op, SENTENCES};
use super::text::{MODEL, SQUARES, header_of};
use crate::picture;

/// The seeds of the target with this name; none if there is no such target.
pub fn of(target: &str) -> Vec<Vec<u8>> {
    match target {
        "camera_frame" => camera_frames(),
        "scene" => vec![bytes_of(&SceneMessage::from(&*SQUARES)).to_vec()],
        "plan_request" => plan_requests(),
        "plan_reply" => plan_replies(),
        "sub_goal" => sub_goals(),
        "feedback" => feedbacks(),
        "heartbeat" => heartbeats(),
        "executive" => scripts(),
        "sentence" => sentences().map(|text| text.as_bytes().to_vec()).collect(),
        "scene_file" => scene_files(),
        "model_file" => model_files(),
        _ => Vec::new(),
    }
}

/// The words of a target's dictionary, if it has one.
pub fn dictionary(target: &str) -> Vec<String> {
    match target {
        "plan_request" | "executive" | "sentence" => {
            let words = TABLETOP.words.iter().map(|word| word.text);
            let lexicon = TABLETOP.lexicon.iter().map(|entry| entry.text);
            words
                .chain(lexicon)
                .map(|word| format!(" {word}"))
                .collect()
        }
        "scene_file" => [
            "schema",
            "camera",
            "image",
            "objects",
            "id",
            "box",
            "depth",
            "width",
            "height",
            "fx",
            "fy",
            "cx",
            "cy",
            "position",
            "orientation",
        ]
        .map(|name| format!("\"{name}\":"))
        .into_iter()
        .chain(["1e39", "-0.0", "0.5", "null", "[", "{", "\\ud800"].map(Into::into))
        .collect(),
        "model_file" => [
            "__metadata__",
            "schema",
            "hash",
            "domain",
            "vocabulary",
            "dimensions",
            "thresholds",
            "work_space",
            "placed_orientation",
            "training_camera",
            "training",
            "metrics",
            "attribute",
            "name",
            "view",
            "values",
            "words",
            "rgb",
            "edges_m",
            "action",
            "phrases",
            "grammar",
            "dtype",
            "F32",
            "F64",
            "shape",
            "data_offsets",
            "match_score",
            "decision",
            "min",
            "max",
        ]
        .into_iter()
        .flat_map(|name| [format!("\"{name}\""), format!("\\\"{name}\\\"")])
        .collect(),
        _ => Vec::new(),
    }
}

fn sentences() -> impl Iterator<Item = &'static str> {
    let more = [
        "",
        " ",
        "put the red block",
        "move the small red block on top of the magenta block.",
        "put the cyan lego block to the right of the yellow block, then put the red block on it",
        "PUT the red, BLOCK on the blue block!",
        "put the gren block on the blue block",
        "put the rötliche block on the blue block",
        "on the blue block put the red block and then put the green one to the left of it",
        "slide the red block 5 cm to the left, then put it two inches behind the blue one",
        "put everything except the red one on the two blocks that are not blue, no, on the table",
    ];
    SENTENCES.into_iter().chain(more)
}

fn camera_frames() -> Vec<Vec<u8>> {
    let mut frame = CameraFrame {
        sequence: 1,
        timestamp_ns: 2,
        camera: picture::scaled(picture::camera(), [8, 6]).into(),
        count: 2,
        boxes: Default::default(),
    };
    for (place, id) in frame.boxes.iter_mut().zip(1..=2_u32) {
        // As large as lego blocks.
        let left = 0.4 * (id - 1) as f32;
        *place = DetectedBox::whole(id, [left, 0.2, left + 0.06, 0.28, 0.96]);
    }
    let image: Vec<u8> = (0..8 * 6 * 7).map(|at: u32| (at * 7 % 256) as u8).collect();
    let alone = bytes_of(&frame).to_vec();
    vec![[&alone[..], &image].concat(), alone]
}

fn plan_requests() -> Vec<Vec<u8>> {
    let modes = [Mode::PlanOnly, Mode::ClosedLoop, Mode::OpenLoop];
    let requests = sentences().zip(modes.into_iter().cycle());
    let requests = requests.map(|(sentence, mode)| {
        let request = PlanRequest::new(1, 2, mode, sentence).expect("a short sentence");
        without_zeros(&request)
    });
    requests
        .chain([without_zeros(&PlanRequest::cancel(1, 2))])
        .collect()
}

/// The bytes up to the last that is not 0; the reader fills in the others.
fn without_zeros<T: Message>(message: &T) -> Vec<u8> {
    let bytes = bytes_of(message);
    let end = bytes.iter().rposition(|byte| *byte != 0);
    bytes[..end.map_or(0, |end| end + 1)].to_vec()
}

/// The replies to a sentence of two steps, and to one that is refused.
fn events() -> Vec<Event> {
    let sentence = "put the red block on the blue block then put the yellow block on the red block";
    let plan = Planner::new(&TABLETOP).plan(&SQUARES, sentence);
    let plan = plan.expect("a sentence that fits the squares");
    let (step, object) = (1, 5);
    let refused = Failure::Refused(Refusal::NoWords);
    let commands: Vec<_> = (0..)
        .zip(plan.steps())
        .map(|(step, planned)| {
            let id = CommandId {
                plan: 7,
                command: u32::from(step) + 1,
            };
            Event::Command(Command {
                until_ns: 1_000_000_000,
                id,
                step,
                steps: 2,
                planned: *planned,
                keep: core::array::from_fn(|place| if place < 2 { place as u32 + 1 } else { 0 }),
            })
        })
        .collect();
    let mut events = vec![
        Event::Planned(plan),
        Event::Clearing {
            step,
            object,
            first: [3, 0],
        },
        Event::Reached { step, off_m: 0.002 },
        Event::Again {
            step,
            why: Failure::NotSeen { step, object },
        },
        Event::Ended(Ok(())),
        Event::Ended(Err(refused)),
        Event::Ended(Err(Failure::NoScene { last: None })),
    ];
    events.extend(commands);
    events
}

fn plan_replies() -> Vec<Vec<u8>> {
    let to = ReplyTo {
        client: 1,
        request: 2,
        plan: 7,
        number: 1,
    };
    let events = events();
    let replies = events
        .iter()
        .filter_map(|event| PlanReply::about(to, event, &TABLETOP, ""));
    let refused = PlanReply::refused(to, "busy", "wait");
    replies
        .chain([refused])
        .map(|reply| without_zeros(&reply))
        .collect()
}

fn sub_goals() -> Vec<Vec<u8>> {
    let events = events();
    let moves = events.iter().filter_map(|event| match event {
        Event::Command(command) => Some(SubGoal::from(command)),
        _ => None,
    });
    let stop = SubGoal::stop(CommandId {
        plan: 7,
        command: 1,
    });
    moves
        .chain([stop])
        .map(|sub_goal| bytes_of(&sub_goal).to_vec())
        .collect()
}

fn feedbacks() -> Vec<Vec<u8>> {
    let all = (1..).zip(Outcome::ALL).map(|(sequence, outcome)| Feedback {
        plan: 7,
        sequence,
        timestamp_ns: 10_000_000 * sequence,
        command: 1,
        outcome: outcome as u32,
        objects: [5, 0],
    });
    let each: Vec<_> = all.map(|feedback| bytes_of(&feedback).to_vec()).collect();
    let together = each.concat();
    [each, vec![together]].concat()
}

fn heartbeats() -> Vec<Vec<u8>> {
    let all = (1..).zip(Role::ALL).map(|(sequence, role)| Heartbeat {
        sequence,
        timestamp_ns: 10_000_000 * sequence,
        started_ns: 5,
        role: role as u32,
        state: State::Idle as u32,
        rejected: 0,
    });
    let each: Vec<_> = all.map(|heartbeat| bytes_of(&heartbeat).to_vec()).collect();
    let together = each.concat();
    [each, vec![together]].concat()
}

/// What may happen after the first command of a sentence: success, and failures of all kinds.
fn continuations() -> [&'static [u8]; 13] {
    use Op::{
        Accept, Babble, Cancel, Leap, Lose, Move, Obey, Poll, PollOn, Say, See, SeeBroken, SeeLate,
        Wait, WaitLong,
    };
    [
        &[Cancel as u8, Poll as u8, 1],
        &[
            Obey as u8,
            Wait as u8,
            1,
            See as u8,
            PollOn as u8,
            Obey as u8,
        ],
        &[
            Accept as u8,
            Say as u8,
            Outcome::Dropped as u8,
            64,
            PollOn as u8,
        ],
        &[
            Accept as u8,
            Poll as u8,
            3,
            WaitLong as u8,
            255,
            PollOn as u8,
        ],
        &[
            Cancel as u8,
            Poll as u8,
            1,
            Say as u8,
            Outcome::Stopped as u8,
            64,
        ],
        &[Lose as u8, 0, PollOn as u8],
        &[Lose as u8, 1, PollOn as u8],
        &[
            Accept as u8,
            Poll as u8,
            3,
            Lose as u8,
            0,
            Cancel as u8,
            PollOn as u8,
        ],
        &[Lose as u8, 1, Accept as u8, PollOn as u8],
        &[
            Obey as u8,
            Move as u8,
            0,
            100,
            100,
            Wait as u8,
            5,
            See as u8,
            PollOn as u8,
        ],
        &[
            Obey as u8,
            Move as u8,
            128,
            0,
            0,
            Wait as u8,
            5,
            See as u8,
            PollOn as u8,
        ],
        &[
            SeeLate as u8,
            200,
            SeeBroken as u8,
            40,
            0,
            1,
            2,
            3,
            4,
            Leap as u8,
            0,
            1,
        ],
        &[
            Babble as u8,
            100,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            WaitLong as u8,
            9,
            PollOn as u8,
        ],
    ]
}

/// A sentence that succeeds, and some that fail in various ways.
fn scripts() -> Vec<Vec<u8>> {
    use Op::{Ask, PollOn, See};
    let mut scripts = Vec::new();
    for settings in [0, BY_HAND, OBEDIENT, BY_HAND | OBEDIENT, BY_HAND | 3 << 6] {
        // Sentence and scene, plan, command.
        let which = 1 - (settings & BY_HAND);
        let begun = [Ask as u8, 0, which, PollOn as u8, See as u8, PollOn as u8];
        for rest in continuations() {
            scripts.push([&[settings][..], &begun, rest].concat());
        }
        for (mode, which) in (0..3).zip([1, 3, 6]) {
            scripts.push(vec![settings, Ask as u8, mode, which, See as u8]);
        }
    }
    scripts
}

fn scene_files() -> Vec<Vec<u8>> {
    let camera = json!({
        "width": 640, "height": 480, "fx": 600.0, "fy": 600.0, "cx": 320.0, "cy": 240.0,
        "position": [0.5, 0.0, 1.0], "orientation": [1.0, 0.0, 0.0, 0.0],
    });
    let objects: Vec<_> = picture::squares()
        .detections
        .iter()
        .map(|found| {
            let [x1, y1, x2, y2, depth] = found.location;
            json!({"id": found.id, "box": [x1, y1, x2, y2], "depth": depth})
        })
        .collect();
    [&objects[..], &objects[..1], &[]]
        .map(|objects| {
            json!({"schema": 1, "camera": camera, "image": "image.png", "objects": objects})
                .to_string()
                .into_bytes()
        })
        .to_vec()
}

fn model_files() -> Vec<Vec<u8>> {
    let (header, tensors) = header_of(MODEL);
    let length = (header.len() as u64).to_le_bytes();
    // One that ends early.
    let whole = [&[0][..], &length, header, &tensors[..64]].concat();
    // The content of a small file: a tensor, and a map of strings.
    let small =
        br#"{"__metadata__":{"schema":"3"},"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}}"#;
    let small_length = (small.len() as u64).to_le_bytes();
    vec![
        whole,
        [&[1][..], header].concat(),
        [&[0][..], &small_length, small, &[0; 4]].concat(),
    ]
}
