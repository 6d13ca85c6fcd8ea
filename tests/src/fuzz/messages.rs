//! Each message from any bytes: read, checked, and passed to its consumers.

use nsrm_core::dsl::Argument;
use nsrm_core::{MAX_FILTERS, MAX_OBJECTS, MAX_RELATIONS, MAX_SENTENCE_BYTES, MAX_STEPS};
use nsrm_core::{Planner, Scene};
use nsrm_ipc::message::{
    Asked, CameraFrame, Feedback, Heartbeat, MAX_MESSAGE_BYTES, Order, PlanReply, PlanRequest,
    REASONS, Reply, SceneMessage, SubGoal,
};
use nsrm_ipc::node::{Peer, View, see};
use nsrm_tabletop::TABLETOP;

use super::bytes::message;
use super::says;
use super::text::follow;
use crate::picture;
use crate::plans::{check_in, reckless};

/// The greatest side of the images that are made for a frame.
const SIDE: u32 = 24;
/// The sentence for every scene.
const SENTENCES: [&str; 2] = [
    "put the red block on the small blue block",
    "put the green block to the left of the lego block then put the red one on it",
];

/// A camera frame and its image: as they are, then with an image that fits, then with a valid
/// camera.
pub fn camera_frame(bytes: &[u8]) {
    let (mut frame, image): (CameraFrame, _) = message(bytes);
    look_at(&frame, image);
    // Random bytes seldom have the length that a camera needs.
    let camera = &mut frame.camera;
    (camera.width, camera.height) = (1 + camera.width % SIDE, 1 + camera.height % SIDE);
    let pixels = (camera.width * camera.height) as usize;
    let pattern = if image.is_empty() { &[90][..] } else { image };
    let image: Vec<u8> = pattern.iter().copied().cycle().take(7 * pixels).collect();
    look_at(&frame, &image);
    let size = [frame.camera.width, frame.camera.height];
    frame.camera = picture::scaled(picture::camera(), size).into();
    frame.count %= MAX_OBJECTS as u32 + 1;
    look_at(&frame, &image);
}

fn look_at(frame: &CameraFrame, image: &[u8]) {
    match frame.read(image) {
        Ok(parts) => {
            let pixels = parts.camera.width as usize * parts.camera.height as usize;
            assert_eq!(parts.camera.check(), Ok(()));
            assert_eq!(
                (parts.rgb.len(), parts.depth.len()),
                (3 * pixels, 4 * pixels)
            );
            assert!(parts.boxes.len() <= MAX_OBJECTS);
        }
        Err(error) => says(&error),
    }
    match see(&TABLETOP, frame, image) {
        Ok(message) => {
            let scene = message
                .to_scene(&TABLETOP)
                .expect("perception's scenes are");
            assert_eq!(scene.header().timestamp_ns, frame.timestamp_ns);
            assert_eq!(scene.objects().len(), frame.count as usize);
            plan_in(&scene);
        }
        Err(fault) => says(&fault),
    }
}

/// A scene: as it is, then with a valid header and a possible count.
pub fn scene(bytes: &[u8]) {
    let (mut raw, _): (SceneMessage, _) = message(bytes);
    let mut view = View::default();
    for now_ns in [0, raw.timestamp_ns] {
        let _ = view.hear_scene(&raw, now_ns);
    }
    take_scene(&raw);
    let empty = nsrm_core::RawScene::empty(&TABLETOP, picture::camera());
    raw.schema = empty.header.schema;
    raw.frame = empty.header.frame;
    raw.model_tag = empty.header.model_tag;
    raw.count %= MAX_OBJECTS as u32 + 1;
    take_scene(&raw);
    raw.camera = empty.camera.into();
    take_scene(&raw);
}

fn take_scene(message: &SceneMessage) {
    match message.to_scene(&TABLETOP) {
        Ok(scene) => {
            check_scene(&scene);
            // As it is published again, by its bytes: a signalling NaN may stand behind
            // the last object.
            let again = SceneMessage::from(&scene).to_scene(&TABLETOP);
            assert_eq!(
                again.map(|again| again.objects().to_vec()),
                Ok(scene.objects().to_vec())
            );
            plan_in(&scene);
        }
        Err(error) => says(&error),
    }
}

/// The guarantees for a checked scene in the documentation of `nsrm_core::scene`.
pub(super) fn check_scene(scene: &Scene) {
    assert_eq!(scene.camera().check(), Ok(()));
    let objects = scene.objects();
    assert!(objects.len() <= MAX_OBJECTS);
    for (index, object) in objects.iter().enumerate() {
        let [x1, y1, x2, y2, depth] = object.location;
        assert!(object.id != 0);
        assert!(objects[..index].iter().all(|before| before.id != object.id));
        assert!(0.0 <= x1 && x1 < x2 && x2 <= 1.0, "{object:?}");
        assert!(0.0 <= y1 && y1 < y2 && y2 <= 1.0, "{object:?}");
        assert!(depth > 0.0 && depth.is_finite(), "{object:?}");
        assert!(object.embedding.iter().all(|number| number.is_finite()));
    }
}

/// Plans in a scene, with the model as it is and as one that refuses less.
pub(super) fn plan_in(scene: &Scene) {
    let reckless = reckless(TABLETOP, 0.0);
    for model in [&TABLETOP, &reckless] {
        for sentence in SENTENCES {
            match Planner::new(model).plan(scene, sentence) {
                Ok(plan) => check_in(model, scene, &plan),
                Err(refusal) => says(&refusal.in_context(model, sentence)),
            }
        }
    }
}

/// A request, and the sentence in it to its plan.
pub fn plan_request(bytes: &[u8]) {
    let (request, _): (PlanRequest, _) = message(bytes);
    match request.read() {
        Ok(Asked::Follow { sentence, mode }) => {
            assert!(sentence.len() <= MAX_SENTENCE_BYTES);
            let PlanRequest {
                client, sequence, ..
            } = request;
            let again = PlanRequest::new(client, sequence, mode, &sentence);
            let again = again.expect("a sentence that came by a request fits into one");
            let read = again.read();
            assert_eq!(read, request.read());
            follow(&sentence);
        }
        Ok(Asked::Cancel) => {}
        Err(error) => says(&error),
    }
}

/// A reply, and each of its steps.
pub fn plan_reply(bytes: &[u8]) {
    let (reply, _): (PlanReply, _) = message(bytes);
    let mut view = View::default();
    for _ in 0..10 {
        assert_eq!(view.hear_reply(&reply).is_ok(), reply.read().is_ok());
    }
    let said = match reply.read() {
        Ok(said) => said,
        Err(error) => return says(&error),
    };
    match said {
        Reply::Planned { steps, program } => {
            assert!((1..=MAX_STEPS).contains(&steps.len()));
            assert!(program.len() <= MAX_MESSAGE_BYTES);
            for step in steps {
                assert!(step.object_count <= MAX_FILTERS as u32);
                assert!(step.reference_count <= MAX_FILTERS as u32);
                for argument in [Argument::Object, Argument::Reference] {
                    let description = step.description(argument);
                    assert!(description.relations().len() <= MAX_RELATIONS);
                }
                assert!(step.object_relation_count <= MAX_RELATIONS as u32);
                assert!(step.reference_relation_count <= MAX_RELATIONS as u32);
                let numbers = [&step.position[..], &step.location, &step.confidence];
                assert!(numbers.concat().iter().all(|number| number.is_finite()));
                assert!(step.object_score.is_finite() && step.reference_score.is_finite());
                assert_eq!(step.is_grounded(), step.object_id != 0);
                if step.is_grounded() {
                    assert!(is_unit(&step.orientation), "{:?}", step.orientation);
                }
            }
        }
        Reply::Commanded { step } | Reply::Reached { step, .. } | Reply::Clearing { step, .. } => {
            assert!(step < MAX_STEPS as u32);
        }
        Reply::Again { reason, .. } | Reply::Failed { reason, .. } => {
            assert!(REASONS.contains(&reason));
        }
        Reply::Done => {}
    }
}

fn is_unit(quaternion: &[f32; 4]) -> bool {
    let length = quaternion.iter().map(|x| x * x).sum::<f32>().sqrt();
    (length - 1.0).abs() < 1e-3
}

/// A command as a controller reads it.
pub fn sub_goal(bytes: &[u8]) {
    let (sub_goal, _): (SubGoal, _) = message(bytes);
    // As late as it may be started.
    match sub_goal.read(sub_goal.until_ns) {
        Ok(Order::Move { object, pose }) => {
            assert!(object != 0 && object == sub_goal.object_id);
            assert_ne!(object, sub_goal.reference_id);
            assert!(sub_goal.step < sub_goal.steps && sub_goal.steps <= MAX_STEPS as u32);
            let position: [f32; 3] = pose.translation.vector.into();
            assert!(position.iter().all(|number| number.is_finite()));
            let turned: [f32; 4] = pose.rotation.coords.into();
            assert!(is_unit(&turned), "{turned:?}");
            assert!((0.0..=1.0).contains(&sub_goal.confidence));
            let late = sub_goal.until_ns.saturating_add(1);
            assert_eq!(sub_goal.read(late).is_ok(), late == sub_goal.until_ns);
        }
        Ok(Order::Stop) => {
            let stop = SubGoal::stop(sub_goal.id());
            assert_eq!(
                (stop.id(), stop.read(u64::MAX)),
                (sub_goal.id(), Ok(Order::Stop))
            );
        }
        Err(error) => return says(&error),
    }
    assert!(sub_goal.id().command > 0);
}

/// A sequence of feedback, as a planner and an observer read it.
pub fn feedback(bytes: &[u8]) {
    let mut view = View::default();
    for bytes in bytes.chunks(size_of::<Feedback>()) {
        let (feedback, _): (Feedback, _) = message(bytes);
        let heard = view.hear_feedback(&feedback, feedback.timestamp_ns ^ 1);
        assert_eq!(heard.is_ok(), feedback.read().is_ok());
        match feedback.read() {
            Ok(report) => {
                assert!(report.id.command > 0);
                assert_eq!(report.outcome as u32, feedback.outcome);
                assert!(!report.outcome.words().is_empty());
            }
            Err(error) => says(&error),
        }
    }
    assert_flow(&view.feedback);
}

fn assert_flow(flow: &nsrm_ipc::node::Flow) {
    assert!(flow.rate_hz.is_finite() && flow.rate_hz >= 0.0, "{flow:?}");
}

/// A sequence of heartbeats, as a peer and an observer read it.
pub fn heartbeat(bytes: &[u8]) {
    let mut view = View::default();
    let mut peer = Peer::default();
    let mut heard = None;
    for bytes in bytes.chunks(size_of::<Heartbeat>()) {
        let (heartbeat, _): (Heartbeat, _) = message(bytes);
        let now_ns = heartbeat.timestamp_ns;
        let taken = view.hear_heartbeat(&heartbeat, now_ns);
        assert_eq!(taken.is_ok(), heartbeat.read().is_ok());
        let (role, state) = match heartbeat.read() {
            Ok(read) => read,
            Err(error) => {
                says(&error);
                continue;
            }
        };
        let node = view.nodes[role as usize - 1].expect("it was heard");
        assert_eq!(
            (node.role, node.state, node.heard_ns),
            (role, state, now_ns)
        );
        let is_other = heard.is_some_and(|started_ns| started_ns != heartbeat.started_ns);
        assert_eq!(peer.hear(&heartbeat, now_ns), is_other);
        assert!(peer.may_be_alive(0, 0, now_ns));
        heard = Some(heartbeat.started_ns);
    }
}
