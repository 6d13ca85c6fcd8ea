//! The messages in other languages, generated from the structs: Python (`ctypes`) and C, and a
//! table for people. Each states size, alignment and every offset in Rust, so that the other side
//! can compare them with its own.

mod c;
mod python;

use std::fmt::Write;

use crate::message::{
    CameraFrame, CameraMessage, DetectedBox, Feedback, Field, Heartbeat, Kind, Message, Numbers,
    ObjectMessage, Outcome, PlanReply, PlanRequest, Purpose, RelationMessage, Role, SceneMessage,
    State, Status, StepMessage, SubGoal, Type,
};
use crate::service::{CAMERA, CAMERA_QUALITY, Carried, Quality};

/// The description of a message for bindings.
#[derive(Debug, Clone, Copy)]
pub struct Description {
    /// The struct's name.
    pub name: &'static str,
    /// What it is, in Markdown.
    pub doc: &'static str,
    /// The type name that iceoryx2 compares.
    pub type_name: &'static str,
    /// Hash of the layout, the end of the type's name.
    pub layout_hash: u64,
    /// Bytes.
    pub size: usize,
    /// Bytes.
    pub align: usize,
    /// In memory order.
    pub fields: &'static [Field],
}

const fn describe<T: Message>() -> Description {
    Description {
        name: T::NAME,
        doc: T::DOC,
        type_name: T::TYPE_NAME,
        layout_hash: T::LAYOUT_HASH,
        size: size_of::<T>(),
        align: align_of::<T>(),
        fields: T::FIELDS,
    }
}

/// All messages; those that others contain come first.
pub const MESSAGES: [Description; 12] = [
    describe::<CameraMessage>(),
    describe::<DetectedBox>(),
    describe::<CameraFrame>(),
    describe::<ObjectMessage>(),
    describe::<SceneMessage>(),
    describe::<PlanRequest>(),
    describe::<RelationMessage>(),
    describe::<StepMessage>(),
    describe::<PlanReply>(),
    describe::<SubGoal>(),
    describe::<Feedback>(),
    describe::<Heartbeat>(),
];

/// All enumerated fields, except [`crate::message::REASONS`].
const NUMBERS: [Numbers; 6] = [
    Purpose::NUMBERS,
    Status::NUMBERS,
    Kind::NUMBERS,
    Outcome::NUMBERS,
    Role::NUMBERS,
    State::NUMBERS,
];

/// The guarantees of the publish-subscribe services that a camera or a controller may open.
const QUALITIES: [(&str, Quality); 5] = [
    (CAMERA, CAMERA_QUALITY),
    (SceneMessage::SERVICE, SceneMessage::QUALITY),
    (SubGoal::SERVICE, SubGoal::QUALITY),
    (Feedback::SERVICE, Feedback::QUALITY),
    (Heartbeat::SERVICE, Heartbeat::QUALITY),
];

const HOW: &str = "Written by `cargo run -p nsrm-ipc --bin nsrm-bindings`; do not edit.";

/// The generated files that are committed, by path from this package.
pub fn files() -> [(&'static str, String); 3] {
    [
        ("layout.txt", table()),
        ("include/nsrm_messages.h", c::header()),
        (
            "../sim-harness/nsrm_harness/nodes/messages.py",
            python::module(),
        ),
    ]
}

/// For people: the layout of the messages, which must be the same on both sides.
fn table() -> String {
    let mut table = format!(
        "Layout of the messages: offset, size (bytes), name and type of each field.\n{HOW}\n\
         Any change needs a new schema version.\n"
    );
    for message in &MESSAGES {
        let (name, size, align) = (message.type_name, message.size, message.align);
        // Writing to a string cannot fail.
        let _ = writeln!(table, "\n{name}  size {size}  align {align}");
        for field in message.fields {
            let (offset, size, name) = (field.offset, field.size, field.name);
            let written = rust_type(&field.element);
            let _ = writeln!(table, "  {offset:>6} {size:>6}  {name}: {written}");
        }
    }
    table
}

fn rust_type(element: &Type) -> String {
    match element {
        Type::U8 => "u8".into(),
        Type::U32 => "u32".into(),
        Type::U64 => "u64".into(),
        Type::F32 => "f32".into(),
        Type::Array(of, length) => format!("[{}; {length}]", rust_type(of)),
        Type::Message(name) => (*name).into(),
    }
}

fn snake(name: &str) -> String {
    let mut snake = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake
}

/// A doc comment without the links, which only rustdoc resolves.
fn prose(doc: &str, line_end: &str) -> String {
    let lines = doc.lines().map(str::trim);
    let text = lines.collect::<Vec<_>>().join(line_end);
    let text = text.replace("[`", "`").replace("`]", "`");
    // Without trailing blanks.
    let lines = text.lines().map(str::trim_end);
    lines.collect::<Vec<_>>().join("\n")
}
