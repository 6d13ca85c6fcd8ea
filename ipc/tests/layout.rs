//! The messages lie in memory as `layout.txt` says, and their type names carry
//! the hash of it.

use std::fmt::Write;

use nsrm_ipc::{
    CameraFrame, CameraMessage, DetectedBox, Feedback, Heartbeat, Message, ObjectMessage,
    PlanReply, PlanRequest, SceneMessage, SubGoal,
};

const COMMITTED: &str = include_str!("../layout.txt");

fn describe<T: Message>(table: &mut String) {
    let (size, align) = (size_of::<T>(), align_of::<T>());
    writeln!(table, "\n{}  size {size}  align {align}", T::TYPE_NAME).unwrap();
    for field in T::FIELDS {
        let (offset, size) = (field.offset, field.size);
        let (name, kind) = (field.name, field.written_type);
        writeln!(table, "  {offset:>6} {size:>6}  {name}: {kind}").unwrap();
    }
}

fn check_name<T: Message>(wrong: &mut String) {
    let hash = format!("{:016x}", T::LAYOUT_HASH);
    let named = T::TYPE_NAME.rsplit('.').next().unwrap();
    if named != hash {
        writeln!(wrong, "{}: its hash is {hash}", T::TYPE_NAME).unwrap();
    }
    assert!(T::TYPE_NAME.starts_with("nsrm.v1."));
}

macro_rules! for_all {
    ($function:ident, $argument:expr) => {{
        $function::<CameraMessage>($argument);
        $function::<DetectedBox>($argument);
        $function::<CameraFrame>($argument);
        $function::<ObjectMessage>($argument);
        $function::<SceneMessage>($argument);
        $function::<PlanRequest>($argument);
        $function::<SubGoal>($argument);
        $function::<PlanReply>($argument);
        $function::<Feedback>($argument);
        $function::<Heartbeat>($argument);
    }};
}

#[test]
fn every_type_name_carries_the_hash_of_its_layout() {
    let mut wrong = String::new();
    for_all!(check_name, &mut wrong);
    assert!(wrong.is_empty(), "change these type names:\n{wrong}");
}

#[test]
fn every_offset_and_size_is_the_committed_one() {
    let mut table = String::from(
        "Layout of the messages: offset, size (bytes), name and type of each field.\n\
         Compared with the structs by tests/layout.rs; a change is a new schema.\n",
    );
    for_all!(describe, &mut table);
    if std::env::var_os("NSRM_WRITE_LAYOUT").is_some() {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/layout.txt"), &table).unwrap();
        return;
    }
    assert_eq!(
        COMMITTED, table,
        "write it anew with NSRM_WRITE_LAYOUT=1 cargo test -p nsrm-ipc"
    );
}
