//! The messages go through iceoryx2, by the names that peers compare.

use iceoryx2::config::Config;
use iceoryx2::prelude::*;
use nsrm_ipc::message::{
    CameraFrame, CameraMessage, DetectedBox, Feedback, Heartbeat, Message, Role, State,
};

/// A corner of the machine that no other test or robot uses.
fn own_config(test: &str) -> Config {
    let mut config = Config::default();
    let name = format!("nsrm-test-{}-{test}", std::process::id());
    let folder = std::env::temp_dir().join(&name);
    let path = folder.to_str().unwrap().as_bytes();
    config
        .global
        .set_root_path(&Path::new(path).expect("a path of moderate length"));
    config.global.prefix = FileName::new(format!("{name}_").as_bytes()).expect("a short name");
    config
}

#[test]
fn a_heartbeat_arrives_as_it_was_sent() {
    let config = own_config("heartbeat");
    let node = NodeBuilder::new()
        .config(&config)
        .create::<ipc::Service>()
        .unwrap();
    let name = "nsrm/v1/test/heartbeat".try_into().unwrap();
    let service = node
        .service_builder(&name)
        .publish_subscribe::<Heartbeat>()
        .open_or_create()
        .unwrap();
    let publisher = service.publisher_builder().create().unwrap();
    let subscriber = service.subscriber_builder().create().unwrap();
    let sent = Heartbeat {
        sequence: 5,
        timestamp_ns: 6,
        started_ns: 4,
        role: Role::Planner as u32,
        state: State::Busy as u32,
    };
    publisher.send_copy(sent).unwrap();
    let received = subscriber.receive().unwrap().expect("it was just sent");
    assert_eq!(*received, sent);
    assert_eq!(received.read(), Ok((Role::Planner, State::Busy)));
}

#[test]
fn a_peer_with_another_layout_is_refused() {
    let config = own_config("layout");
    let node = NodeBuilder::new()
        .config(&config)
        .create::<ipc::Service>()
        .unwrap();
    let name = "nsrm/v1/test/layout".try_into().unwrap();
    let _heartbeats = node
        .service_builder(&name)
        .publish_subscribe::<Heartbeat>()
        .create()
        .unwrap();
    // Of the same size: only the type name tells them apart.
    assert_eq!(size_of::<Feedback>(), size_of::<Heartbeat>());
    let other = node
        .service_builder(&name)
        .publish_subscribe::<Feedback>()
        .open();
    assert!(other.is_err());
}

#[test]
fn a_frame_is_loaned_in_place_with_its_header() {
    let config = own_config("frame");
    let node = NodeBuilder::new()
        .config(&config)
        .create::<ipc::Service>()
        .unwrap();
    let name = "nsrm/v1/test/camera".try_into().unwrap();
    let service = node
        .service_builder(&name)
        .publish_subscribe::<[u8]>()
        .user_header::<CameraFrame>()
        .open_or_create()
        .unwrap();
    let publisher = service
        .publisher_builder()
        .initial_max_slice_len(2 * 3 * 7)
        .create()
        .unwrap();
    let subscriber = service.subscriber_builder().create().unwrap();
    let frame = frame();
    let mut sample = publisher.loan_slice(2 * 3 * 7).unwrap();
    *sample.user_header_mut() = frame;
    sample.payload_mut().fill(9);
    sample.send().unwrap();
    let received = subscriber.receive().unwrap().expect("it was just sent");
    let parts = received.user_header().read(received.payload()).unwrap();
    assert_eq!((parts.rgb, parts.depth), (&[9; 18][..], &[9; 24][..]));
    assert_eq!(parts.boxes, &frame.boxes[..1]);
}

fn frame() -> CameraFrame {
    let camera = CameraMessage {
        width: 2,
        height: 3,
        fx: 500.0,
        fy: 500.0,
        cx: 1.0,
        cy: 1.5,
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
    };
    let found = DetectedBox {
        id: 1,
        corners: [0.1, 0.2, 0.3, 0.4],
        depth_m: 1.0,
    };
    CameraFrame {
        sequence: 1,
        timestamp_ns: 2,
        camera,
        count: 1,
        boxes: [found; 16],
    }
}

#[test]
fn iceoryx2_compares_the_names_with_the_hash() {
    // SAFETY: the name is only read.
    let name = unsafe { <CameraFrame as ZeroCopySend>::type_name() };
    assert_eq!(name, CameraFrame::TYPE_NAME);
}
