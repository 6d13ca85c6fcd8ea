//! The messages in C.

use std::fmt::Write;

use super::{HOW, MESSAGES, NUMBERS, QUALITIES, prose, snake};
use crate::message::{Member, Numbers, REASONS, Type};
use crate::service::Quality;

/// A C header, for C11 and C++11.
pub(super) fn header() -> String {
    let mut header = format!(
        "/* The messages between processes.\n * {HOW} */\n\n\
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
            let (base, dimensions) = type_of(&field.element);
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
    constants(&mut header);
    header.push_str("\n#endif /* NSRM_MESSAGES_H */\n");
    header
}

/// Named values, and the guarantees of the services.
fn constants(header: &mut String) {
    for Numbers {
        name,
        field,
        members,
    } in NUMBERS
    {
        let name = snake(name);
        let upper = name.to_uppercase();
        let _ = writeln!(header, "\n/** Values of `{field}`. */\nenum nsrm_{name} {{");
        for Member { name, doc, number } in members {
            let (doc, name) = (prose(doc, "\n     *  "), snake(name).to_uppercase());
            let _ = writeln!(
                header,
                "    /** {doc} */\n    NSRM_{upper}_{name} = {number},"
            );
        }
        header.push_str("};\n");
    }
    header.push_str("\n/** Values of `PlanReply.reason`. */\nenum nsrm_reason {\n");
    for (number, reason) in (1..).zip(REASONS) {
        let _ = writeln!(
            header,
            "    NSRM_REASON_{} = {number},",
            reason.to_uppercase()
        );
    }
    header.push_str("};\n");
    header.push_str(
        "\n/* The publish-subscribe services `nsrm/v1/<robot>/<service>`, and the settings to open \
         them with:\n * how many messages wait for a subscriber; how many a late subscriber gets; \
         whether a full buffer\n * drops the oldest; the numbers of publishers and subscribers. */\n",
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

/// The text before and after a field's name.
fn type_of(element: &Type) -> (String, String) {
    match element {
        Type::U8 => ("uint8_t".into(), String::new()),
        Type::U32 => ("uint32_t".into(), String::new()),
        Type::U64 => ("uint64_t".into(), String::new()),
        Type::F32 => ("float".into(), String::new()),
        Type::Array(of, length) => {
            let (base, dimensions) = type_of(of);
            (base, format!("[{length}]{dimensions}"))
        }
        Type::Message(name) => (format!("nsrm_{}", snake(name)), String::new()),
    }
}
