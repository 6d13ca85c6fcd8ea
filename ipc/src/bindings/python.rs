//! The messages in Python.

use std::fmt::Write;

use nsrm_core::MAX_STEPS;

use super::{HOW, MESSAGES, NUMBERS, QUALITIES, prose, snake};
use crate::message::{Member, Numbers, REASONS, Type};
use crate::service::{FRAMES_AT_ONCE, ONLOOKERS, Quality, ROOM};

/// A Python module of `ctypes` structures.
pub(super) fn module() -> String {
    let mut module = format!(
        "\"\"\"The messages between processes.\n\n{HOW}\n\"\"\"\n\n\
         from __future__ import annotations\n\nimport ctypes\nfrom enum import IntEnum\nfrom typing import ClassVar, NamedTuple\n\n\
         REASONS = (\n"
    );
    for reason in REASONS {
        let _ = writeln!(module, "    \"{reason}\",");
    }
    module.push_str(
        ")\n\"\"\"Why a request failed: `PlanReply.reason` is a place in this list, counted \
         from 1.\"\"\"\n",
    );
    constants(&mut module);
    for message in &MESSAGES {
        let _ = write!(
            module,
            "\n\nclass {}(ctypes.Structure):\n    \"\"\"{}\"\"\"\n\n    _fields_: ClassVar = [\n",
            message.name,
            prose(message.doc, "\n    "),
        );
        for field in message.fields {
            comment(&mut module, "        ", field.doc);
            let (name, kind) = (field.name, type_of(&field.element));
            let _ = writeln!(module, "        (\"{name}\", {kind}),");
        }
        let (type_name, size, align) = (message.type_name, message.size, message.align);
        let _ = write!(
            module,
            "    ]\n    LAYOUT: ClassVar = ({size}, {align})\n    \
             \"\"\"Size and alignment in bytes, as in Rust.\"\"\"\n    \
             OFFSETS: ClassVar = {{\n"
        );
        for field in message.fields {
            let _ = writeln!(module, "        \"{}\": {},", field.name, field.offset);
        }
        let _ = write!(
            module,
            "    }}\n    \"\"\"Bytes before each field, as in Rust.\"\"\"\n\n    \
             @staticmethod\n    def type_name() -> str:\n        \
             \"\"\"The type name that iceoryx2 compares between peers.\"\"\"\n        \
             return \"{type_name}\"\n"
        );
    }
    module
}

/// Named values, and the guarantees of the services.
fn constants(module: &mut String) {
    for Numbers {
        name,
        field,
        members,
    } in NUMBERS
    {
        let _ = write!(
            module,
            "\n\nclass {name}(IntEnum):\n    \"\"\"Values of `{field}`.\"\"\"\n\n"
        );
        for Member { name, doc, number } in members {
            comment(module, "    ", doc);
            let _ = writeln!(module, "    {} = {number}", snake(name).to_uppercase());
        }
    }
    module.push_str(
        "\n\nclass Quality(NamedTuple):\n    \"\"\"The guarantees of a publish-subscribe \
         service.\"\"\"\n\n    buffer: int\n    history: int\n    overflow: bool\n    publishers: \
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
        "}}\n\"\"\"By the last part of the service's name.\"\"\"\nONLOOKERS = {ONLOOKERS}\n\"\"\"The greatest number of \
         observers, besides the processes that a robot needs.\"\"\"\nROOM = {ROOM}\n\"\"\"Bytes of shared \
         memory that must be free when a process starts.\"\"\"\nFRAMES_AT_ONCE = \
         {FRAMES_AT_ONCE}\n\"\"\"Frames in memory at once with one reader.\"\"\"\nMAX_STEPS = \
         {MAX_STEPS}\n\"\"\"The greatest number of steps of a plan.\"\"\"\n"
    );
}

fn comment(module: &mut String, indent: &str, doc: &str) {
    for line in prose(doc, "\n").lines() {
        let _ = writeln!(module, "{indent}# {line}");
    }
}

fn type_of(element: &Type) -> String {
    match element {
        Type::U8 => "ctypes.c_uint8".into(),
        Type::U32 => "ctypes.c_uint32".into(),
        Type::U64 => "ctypes.c_uint64".into(),
        Type::F32 => "ctypes.c_float".into(),
        Type::Array(of, length) => format!("{} * {length}", type_of(of)),
        Type::Message(name) => (*name).into(),
    }
}
