//! The messages in other languages, written from the structs: Python (`ctypes`)
//! and C, and a table for people. Each states size, alignment and every offset as
//! Rust has them, for the other side to compare with its own.

use std::fmt::Write;

use nsrm_core::MAX_STEPS;

use crate::message::{
    CameraFrame, CameraMessage, DetectedBox, Feedback, Field, Heartbeat, Kind, Message,
    ObjectMessage, Outcome, PlanReply, PlanRequest, Purpose, REASONS, Role, SceneMessage, State,
    Status, StepMessage, SubGoal, Type,
};
use crate::service::{CAMERA, CAMERA_QUALITY, Carried, FRAMES_AT_ONCE, ONLOOKERS, Quality, ROOM};

/// A message as bindings tell of it.
#[derive(Debug, Clone, Copy)]
pub struct Description {
    /// The struct's name.
    pub name: &'static str,
    /// What it is, in Markdown.
    pub doc: &'static str,
    /// What iceoryx2 compares.
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

/// All messages; those that others are made of come before these.
pub const MESSAGES: [Description; 11] = [
    describe::<CameraMessage>(),
    describe::<DetectedBox>(),
    describe::<CameraFrame>(),
    describe::<ObjectMessage>(),
    describe::<SceneMessage>(),
    describe::<PlanRequest>(),
    describe::<StepMessage>(),
    describe::<PlanReply>(),
    describe::<SubGoal>(),
    describe::<Feedback>(),
    describe::<Heartbeat>(),
];

const HOW: &str = "Written by `cargo run -p nsrm-ipc --bin nsrm-bindings`; do not edit.";

/// What is committed, by its path from this package.
pub fn files() -> [(&'static str, String); 3] {
    [
        ("layout.txt", table()),
        ("include/nsrm_messages.h", c_header()),
        ("../sim-harness/nsrm_harness/messages.py", python()),
    ]
}

/// For people: what of the messages must be the same on both sides.
pub fn table() -> String {
    let mut table = format!(
        "Layout of the messages: offset, size (bytes), name and type of each field.\n{HOW}\n\
         A change is a new schema.\n"
    );
    for message in &MESSAGES {
        let (name, size, align) = (message.type_name, message.size, message.align);
        // Writing to a string does not fail.
        let _ = writeln!(table, "\n{name}  size {size}  align {align}");
        for field in message.fields {
            let (offset, size, name) = (field.offset, field.size, field.name);
            let written = rust_type(&field.element);
            let _ = writeln!(table, "  {offset:>6} {size:>6}  {name}: {written}");
        }
    }
    table
}

/// A Python module of `ctypes` structures.
pub fn python() -> String {
    let mut module = format!(
        "\"\"\"The messages that cross processes.\n\n{HOW}\n\"\"\"\n\n\
         from __future__ import annotations\n\nimport ctypes\nfrom enum import IntEnum\nfrom typing import ClassVar, NamedTuple\n\n\
         REASONS = (\n"
    );
    for reason in REASONS {
        let _ = writeln!(module, "    \"{reason}\",");
    }
    module.push_str(
        ")\n\"\"\"Why a request is not followed: `PlanReply.reason` is a place in here, counted \
         from 1.\"\"\"\n",
    );
    python_constants(&mut module);
    for message in &MESSAGES {
        let _ = write!(
            module,
            "\n\nclass {}(ctypes.Structure):\n    \"\"\"{}\"\"\"\n\n    _fields_: ClassVar = [\n",
            message.name,
            prose(message.doc, "\n    "),
        );
        for field in message.fields {
            for line in prose(field.doc, "\n").lines() {
                let _ = writeln!(module, "        # {line}");
            }
            let (name, kind) = (field.name, python_type(&field.element));
            let _ = writeln!(module, "        (\"{name}\", {kind}),");
        }
        let (type_name, size, align) = (message.type_name, message.size, message.align);
        let _ = write!(
            module,
            "    ]\n    LAYOUT: ClassVar = ({size}, {align})\n    \
             \"\"\"Size and alignment in bytes, as Rust has them.\"\"\"\n    \
             OFFSETS: ClassVar = {{\n"
        );
        for field in message.fields {
            let _ = writeln!(module, "        \"{}\": {},", field.name, field.offset);
        }
        let _ = write!(
            module,
            "    }}\n    \"\"\"Bytes before each field, as Rust has them.\"\"\"\n\n    \
             @staticmethod\n    def type_name() -> str:\n        \
             \"\"\"What iceoryx2 compares between peers.\"\"\"\n        \
             return \"{type_name}\"\n"
        );
    }
    module
}

/// Numbers by name, and what the services promise.
fn python_constants(module: &mut String) {
    for Numbers { name, of, members } in numbers() {
        let _ = write!(
            module,
            "\n\nclass {name}(IntEnum):\n    \"\"\"Numbers of `{of}`.\"\"\"\n\n"
        );
        for (member, number) in members {
            let _ = writeln!(module, "    {member} = {number}");
        }
    }
    module.push_str(
        "\n\nclass Quality(NamedTuple):\n    \"\"\"What a publish-subscribe service \
         promises.\"\"\"\n\n    buffer: int\n    history: int\n    overflow: bool\n    publishers: \
         int\n    subscribers: int\n\n\nQUALITIES = {\n",
    );
    for (service, quality) in QUALITIES {
        let Quality {
            buffer,
            history,
            overflow,
            publishers,
            subscribers,
        } = quality;
        let overflow = if overflow { "True" } else { "False" };
        let _ = writeln!(
            module,
            "    \"{service}\": Quality({buffer}, {history}, {overflow}, {publishers}, \
             {subscribers}),"
        );
    }
    let _ = write!(
        module,
        "}}\n\"\"\"By the end of the service's name.\"\"\"\nONLOOKERS = {ONLOOKERS}\n\"\"\"How many \
         may look on, beside those that a robot needs.\"\"\"\nROOM = {ROOM}\n\"\"\"Bytes of shared \
         memory that must be left for a process to begin.\"\"\"\nFRAMES_AT_ONCE = \
         {FRAMES_AT_ONCE}\n\"\"\"Frames that have memory at once with one reader.\"\"\"\nMAX_STEPS = \
         {MAX_STEPS}\n\"\"\"A plan has no more steps.\"\"\"\n"
    );
}

/// What the publish-subscribe services promise that a camera or a controller may open.
const QUALITIES: [(&str, Quality); 5] = [
    (CAMERA, CAMERA_QUALITY),
    (SceneMessage::SERVICE, SceneMessage::QUALITY),
    (SubGoal::SERVICE, SubGoal::QUALITY),
    (Feedback::SERVICE, Feedback::QUALITY),
    (Heartbeat::SERVICE, Heartbeat::QUALITY),
];

/// Names of the numbers that a field may hold.
struct Numbers {
    name: &'static str,
    /// The field.
    of: &'static str,
    /// In capitals, with their numbers.
    members: Vec<(String, u32)>,
}

/// All fields whose numbers have names.
fn numbers() -> [Numbers; 6] {
    fn members<T: core::fmt::Debug + Copy>(
        all: &[T],
        number: impl Fn(T) -> u32,
    ) -> Vec<(String, u32)> {
        let name = |one: T| snake(&format!("{one:?}")).to_uppercase();
        all.iter().map(|&one| (name(one), number(one))).collect()
    }
    let named = |name, of, members| Numbers { name, of, members };
    [
        named(
            "Purpose",
            "PlanRequest.purpose",
            members(&Purpose::ALL, |one| one as u32),
        ),
        named(
            "Status",
            "PlanReply.status",
            members(&Status::ALL, |one| one as u32),
        ),
        named(
            "Kind",
            "SubGoal.kind",
            members(&Kind::ALL, |one| one as u32),
        ),
        named(
            "Outcome",
            "Feedback.outcome",
            members(&Outcome::ALL, |one| one as u32),
        ),
        named(
            "Role",
            "Heartbeat.role",
            members(&Role::ALL, |one| one as u32),
        ),
        named(
            "State",
            "Heartbeat.state",
            members(&State::ALL, |one| one as u32),
        ),
    ]
}

/// A C header, for C11 and C++11.
pub fn c_header() -> String {
    let mut header = format!(
        "/* The messages that cross processes.\n * {HOW} */\n\n\
         #ifndef NSRM_MESSAGES_H\n#define NSRM_MESSAGES_H\n\n\
         #include <stddef.h>\n#include <stdint.h>\n\n\
         #ifdef __cplusplus\n#define NSRM_ASSERT(condition, text) static_assert(condition, text)\n\
         #define NSRM_ALIGN_OF(type) alignof(type)\n\
         #else\n#define NSRM_ASSERT(condition, text) _Static_assert(condition, text)\n\
         #define NSRM_ALIGN_OF(type) _Alignof(type)\n#endif\n"
    );
    for message in &MESSAGES {
        let name = snake(message.name);
        let _ = write!(
            header,
            "\n/** {} */\ntypedef struct nsrm_{name} {{\n",
            prose(message.doc, "\n *  "),
        );
        for field in message.fields {
            let (base, dimensions) = c_type(&field.element);
            let _ = writeln!(
                header,
                "    /** {} */\n    {base} {}{dimensions};",
                prose(field.doc, "\n     *  "),
                field.name
            );
        }
        let upper = name.to_uppercase();
        let _ = writeln!(
            header,
            "}} nsrm_{name};\n#define NSRM_{upper}_TYPE_NAME \"{}\"\n\
             NSRM_ASSERT(sizeof(nsrm_{name}) == {}, \"size of nsrm_{name}\");\n\
             NSRM_ASSERT(NSRM_ALIGN_OF(nsrm_{name}) == {}, \"alignment of nsrm_{name}\");",
            message.type_name, message.size, message.align,
        );
        for field in message.fields {
            let _ = writeln!(
                header,
                "NSRM_ASSERT(offsetof(nsrm_{name}, {0}) == {1}, \"offset of {0}\");",
                field.name, field.offset
            );
        }
    }
    c_constants(&mut header);
    header.push_str("\n#endif /* NSRM_MESSAGES_H */\n");
    header
}

/// Numbers by name, and what the services promise.
fn c_constants(header: &mut String) {
    let reasons = (1..)
        .zip(REASONS)
        .map(|(number, reason)| (reason.to_uppercase(), number));
    let reasons = Numbers {
        name: "Reason",
        of: "PlanReply.reason",
        members: reasons.collect(),
    };
    for Numbers { name, of, members } in numbers().into_iter().chain([reasons]) {
        let name = snake(name);
        let _ = writeln!(header, "\n/** Numbers of `{of}`. */\nenum nsrm_{name} {{");
        for (member, number) in members {
            let upper = name.to_uppercase();
            let _ = writeln!(header, "    NSRM_{upper}_{member} = {number},");
        }
        header.push_str("};\n");
    }
    header.push_str(
        "\n/* The publish-subscribe services `nsrm/v1/<robot>/<service>`, and with what they are to be \
         opened:\n * messages that wait for a subscriber, and that one who comes late is given; whether \
         the oldest\n * makes room for a new one; how many may publish and subscribe. */\n",
    );
    for (service, quality) in QUALITIES {
        let upper = service.to_uppercase();
        let Quality {
            buffer,
            history,
            overflow,
            publishers,
            subscribers,
        } = quality;
        let _ = writeln!(
            header,
            "#define NSRM_{upper}_SERVICE \"{service}\"\n\
             #define NSRM_{upper}_BUFFER {buffer}\n\
             #define NSRM_{upper}_HISTORY {history}\n\
             #define NSRM_{upper}_OVERFLOW {}\n\
             #define NSRM_{upper}_PUBLISHERS {publishers}\n\
             #define NSRM_{upper}_SUBSCRIBERS {subscribers}",
            u8::from(overflow),
        );
    }
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

fn python_type(element: &Type) -> String {
    match element {
        Type::U8 => "ctypes.c_uint8".into(),
        Type::U32 => "ctypes.c_uint32".into(),
        Type::U64 => "ctypes.c_uint64".into(),
        Type::F32 => "ctypes.c_float".into(),
        Type::Array(of, length) => format!("{} * {length}", python_type(of)),
        Type::Message(name) => (*name).into(),
    }
}

/// What stands before and behind a field's name.
fn c_type(element: &Type) -> (String, String) {
    match element {
        Type::U8 => ("uint8_t".into(), String::new()),
        Type::U32 => ("uint32_t".into(), String::new()),
        Type::U64 => ("uint64_t".into(), String::new()),
        Type::F32 => ("float".into(), String::new()),
        Type::Array(of, length) => {
            let (base, dimensions) = c_type(of);
            (base, format!("[{length}]{dimensions}"))
        }
        Type::Message(name) => (format!("nsrm_{}", snake(name)), String::new()),
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

/// A doc comment without the links that only rustdoc follows.
fn prose(doc: &str, line_end: &str) -> String {
    let lines = doc.lines().map(str::trim);
    let text = lines.collect::<Vec<_>>().join(line_end);
    let text = text.replace("[`", "`").replace("`]", "`");
    // Nor are there blanks at a line's end.
    let lines = text.lines().map(str::trim_end);
    lines.collect::<Vec<_>>().join("\n")
}
