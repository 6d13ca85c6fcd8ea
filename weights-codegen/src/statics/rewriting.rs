//! The statics of what is rewritten before a sentence is read.

use nsrm_core::model::Model;

use super::{Static, table};
use crate::tree::{Describe, Node};

/// What is read as other words.
fn phrases(said: &'static str, first_words: &'static str) -> Node {
    Node::record(
        "Rephrasing",
        [
            ("said", Node::Reference(said)),
            ("first_words", Node::Reference(first_words)),
        ],
    )
}

/// The fields of the model's record.
pub(super) fn records(model: &Model<'_>) -> Vec<(&'static str, Node)> {
    vec![
        (
            "several",
            Node::record(
                "Several",
                [
                    ("between", Node::Reference("BETWEEN")),
                    ("plurals", Node::Reference("PLURALS")),
                ],
            ),
        ),
        ("rephrasing", phrases("REPHRASED", "REPHRASED_FIRST_WORDS")),
        (
            "simplification",
            Node::record(
                "Simplification",
                [
                    ("opening", phrases("OPENING_PHRASES", "OPENING_FIRST_WORDS")),
                    ("anywhere", phrases("FILLERS", "FILLERS_FIRST_WORDS")),
                    ("closing", phrases("CLOSING_PHRASES", "CLOSING_FIRST_WORDS")),
                    (
                        "connecting",
                        phrases("CONNECTING", "CONNECTING_FIRST_WORDS"),
                    ),
                    ("starting", Node::Reference("STARTING")),
                    (
                        "standing",
                        Node::record(
                            "Standing",
                            [
                                ("clauses", Node::Reference("STANDING_CLAUSES")),
                                ("relations", Node::Reference("STANDING_RELATIONS")),
                                ("read_as", model.simplification.standing.read_as.describe()),
                            ],
                        ),
                    ),
                    (
                        "taking",
                        Node::record(
                            "Taking",
                            [
                                ("words", Node::Reference("TAKING")),
                                ("towards", Node::Reference("TAKEN_TOWARDS")),
                                ("order", model.simplification.taking.order.describe()),
                                ("object", model.simplification.taking.object.describe()),
                            ],
                        ),
                    ),
                ],
            ),
        ),
        (
            "exceptions",
            Node::record(
                "Exceptions",
                [
                    ("phrases", Node::Reference("EXCEPTIONS_PHRASES")),
                    ("negations", Node::Reference("EXCEPTIONS_NEGATIONS")),
                ],
            ),
        ),
        (
            "perspectives",
            Node::record(
                "Perspectives",
                [
                    ("own", Node::Reference("OWN_PERSPECTIVE")),
                    ("other", Node::Reference("OTHER_PERSPECTIVE")),
                    ("first_words", Node::Reference("PERSPECTIVE_FIRST_WORDS")),
                    ("opposites", Node::Reference("OPPOSITES")),
                ],
            ),
        ),
        (
            "lists",
            Node::record(
                "Lists",
                [
                    ("between", Node::Reference("LISTED_BETWEEN")),
                    ("them", Node::Reference("LISTED_THEM")),
                    ("stacking", Node::Reference("STACKING")),
                    ("aside", Node::Reference("STACKED_ASIDE")),
                    ("next", model.lists.next.describe()),
                ],
            ),
        ),
        (
            "repairs",
            Node::record(
                "Repairs",
                [
                    ("corrections", Node::Reference("REPAIRS_CORRECTIONS")),
                    ("exclusions", Node::Reference("REPAIRS_EXCLUSIONS")),
                ],
            ),
        ),
        (
            "sequence",
            Node::record(
                "Sequence",
                [
                    ("later", Node::Reference("SEQUENCE_LATER")),
                    ("earlier", Node::Reference("SEQUENCE_EARLIER")),
                    ("first_words", Node::Reference("SEQUENCE_FIRST_WORDS")),
                    ("next", model.sequence.next.describe()),
                ],
            ),
        ),
        (
            "distances",
            Node::record(
                "Distances",
                [
                    ("sides", Node::Reference("DISTANCE_SIDES")),
                    ("units", Node::Reference("DISTANCE_UNITS")),
                    ("numbers", Node::Reference("DISTANCE_NUMBERS")),
                    ("before", Node::Reference("DISTANCE_BEFORE")),
                    ("behind", Node::Reference("DISTANCE_BEHIND")),
                    ("from", Node::Reference("DISTANCE_FROM")),
                    ("beside", model.distances.beside.describe()),
                    ("unless", Node::Reference("DISTANCE_UNLESS")),
                    ("shifts", Node::Reference("DISTANCE_SHIFTS")),
                    ("origins", Node::Reference("DISTANCE_ORIGINS")),
                    ("usual_mm", model.distances.usual_mm.describe()),
                ],
            ),
        ),
        (
            "apart",
            Node::record(
                "Apart",
                [
                    ("between", Node::Reference("APART_BETWEEN")),
                    ("phrases", Node::Reference("APART_PHRASES")),
                ],
            ),
        ),
        (
            "ordinals",
            Node::record(
                "Ordinals",
                [
                    ("ranked", Node::Reference("RANKED")),
                    ("counts", Node::Reference("COUNTS")),
                    ("from", Node::Reference("COUNTED_FROM")),
                    ("first_words", Node::Reference("COUNTED_FIRST_WORDS")),
                    ("articles", Node::Reference("COUNTED_ARTICLES")),
                    ("nouns", Node::Reference("COUNTED_NOUNS")),
                    ("unless", Node::Reference("NOT_COUNTED")),
                ],
            ),
        ),
        (
            "arrangements",
            Node::record(
                "Arrangements",
                [
                    ("between", Node::Reference("LIST_BETWEEN")),
                    ("ends", Node::Reference("LIST_ENDS")),
                    ("next", model.arrangements.next.describe()),
                    ("arrangements", Node::Reference("ARRANGEMENTS")),
                    ("openings", Node::Reference("OPENINGS")),
                    ("closings", Node::Reference("CLOSINGS")),
                ],
            ),
        ),
        (
            "table",
            Node::record(
                "Table",
                [
                    ("action", model.table.action.describe()),
                    ("sides", Node::Reference("TABLE_SIDES")),
                    ("off", Node::Reference("TABLE_OFF")),
                    ("sources", Node::Reference("TABLE_SOURCES")),
                    ("unless", Node::Reference("TABLE_UNLESS")),
                    ("removing", Node::Reference("TABLE_REMOVING")),
                    ("taking", model.table.taking.describe()),
                    ("standing", model.table.standing.describe()),
                    ("order", model.table.order.describe()),
                    ("down", Node::Reference("TABLE_DOWN")),
                    ("relation", model.table.relation.describe()),
                ],
            ),
        ),
    ]
}

/// The statics that they refer to.
pub(super) fn tables(model: &Model<'_>) -> Vec<Static> {
    vec![
        table("BETWEEN", "several.between", "u16", model.several.between),
        table(
            "PLURALS",
            "several.plurals",
            "Plural<'static>",
            model.several.plurals,
        ),
        table(
            "REPHRASED",
            "rephrasing.said",
            "Rephrased<'static>",
            model.rephrasing.said,
        ),
        table(
            "REPHRASED_FIRST_WORDS",
            "rephrasing.first_words",
            "&str",
            model.rephrasing.first_words,
        ),
        table(
            "OPENING_PHRASES",
            "simplification.opening.said",
            "Rephrased<'static>",
            model.simplification.opening.said,
        ),
        table(
            "OPENING_FIRST_WORDS",
            "simplification.opening.first_words",
            "&str",
            model.simplification.opening.first_words,
        ),
        table(
            "FILLERS",
            "simplification.anywhere.said",
            "Rephrased<'static>",
            model.simplification.anywhere.said,
        ),
        table(
            "FILLERS_FIRST_WORDS",
            "simplification.anywhere.first_words",
            "&str",
            model.simplification.anywhere.first_words,
        ),
        table(
            "CLOSING_PHRASES",
            "simplification.closing.said",
            "Rephrased<'static>",
            model.simplification.closing.said,
        ),
        table(
            "CLOSING_FIRST_WORDS",
            "simplification.closing.first_words",
            "&str",
            model.simplification.closing.first_words,
        ),
        table(
            "CONNECTING",
            "simplification.connecting.said",
            "Rephrased<'static>",
            model.simplification.connecting.said,
        ),
        table(
            "CONNECTING_FIRST_WORDS",
            "simplification.connecting.first_words",
            "&str",
            model.simplification.connecting.first_words,
        ),
        table(
            "STANDING_CLAUSES",
            "simplification.standing.clauses",
            "&str",
            model.simplification.standing.clauses,
        ),
        table(
            "STANDING_RELATIONS",
            "simplification.standing.relations",
            "&str",
            model.simplification.standing.relations,
        ),
        table(
            "STARTING",
            "simplification.starting",
            "&str",
            model.simplification.starting,
        ),
        table(
            "TAKING",
            "simplification.taking.words",
            "&str",
            model.simplification.taking.words,
        ),
        table(
            "TAKEN_TOWARDS",
            "simplification.taking.towards",
            "&str",
            model.simplification.taking.towards,
        ),
        table(
            "EXCEPTIONS_PHRASES",
            "exceptions.phrases",
            "&str",
            model.exceptions.phrases,
        ),
        table(
            "EXCEPTIONS_NEGATIONS",
            "exceptions.negations",
            "&str",
            model.exceptions.negations,
        ),
        table(
            "OWN_PERSPECTIVE",
            "perspectives.own",
            "&str",
            model.perspectives.own,
        ),
        table(
            "OTHER_PERSPECTIVE",
            "perspectives.other",
            "&str",
            model.perspectives.other,
        ),
        table(
            "PERSPECTIVE_FIRST_WORDS",
            "perspectives.first_words",
            "&str",
            model.perspectives.first_words,
        ),
        table(
            "OPPOSITES",
            "perspectives.opposites",
            "u8",
            model.perspectives.opposites,
        ),
        table(
            "LISTED_BETWEEN",
            "lists.between",
            "&str",
            model.lists.between,
        ),
        table("LISTED_THEM", "lists.them", "&str", model.lists.them),
        table("STACKING", "lists.stacking", "&str", model.lists.stacking),
        table("STACKED_ASIDE", "lists.aside", "&str", model.lists.aside),
        table(
            "REPAIRS_CORRECTIONS",
            "repairs.corrections",
            "&str",
            model.repairs.corrections,
        ),
        table(
            "REPAIRS_EXCLUSIONS",
            "repairs.exclusions",
            "&str",
            model.repairs.exclusions,
        ),
        table(
            "SEQUENCE_LATER",
            "sequence.later",
            "SequenceText<'static>",
            model.sequence.later,
        ),
        table(
            "SEQUENCE_EARLIER",
            "sequence.earlier",
            "SequenceText<'static>",
            model.sequence.earlier,
        ),
        table(
            "SEQUENCE_FIRST_WORDS",
            "sequence.first_words",
            "&str",
            model.sequence.first_words,
        ),
        table(
            "DISTANCE_SIDES",
            "distances.sides",
            "u8",
            model.distances.sides,
        ),
        table(
            "DISTANCE_UNITS",
            "distances.units",
            "DistanceUnit<'static>",
            model.distances.units,
        ),
        table(
            "DISTANCE_NUMBERS",
            "distances.numbers",
            "DistanceNumber<'static>",
            model.distances.numbers,
        ),
        table(
            "DISTANCE_BEFORE",
            "distances.before",
            "&str",
            model.distances.before,
        ),
        table(
            "DISTANCE_BEHIND",
            "distances.behind",
            "&str",
            model.distances.behind,
        ),
        table(
            "DISTANCE_FROM",
            "distances.from",
            "&str",
            model.distances.from,
        ),
        table(
            "DISTANCE_UNLESS",
            "distances.unless",
            "&str",
            model.distances.unless,
        ),
        table(
            "DISTANCE_SHIFTS",
            "distances.shifts",
            "DistanceShift<'static>",
            model.distances.shifts,
        ),
        table(
            "DISTANCE_ORIGINS",
            "distances.origins",
            "&str",
            model.distances.origins,
        ),
        table(
            "APART_BETWEEN",
            "apart.between",
            "&str",
            model.apart.between,
        ),
        table(
            "APART_PHRASES",
            "apart.phrases",
            "&str",
            model.apart.phrases,
        ),
        table(
            "RANKED",
            "ordinals.ranked",
            "Ranked<'static>",
            model.ordinals.ranked,
        ),
        table(
            "COUNTS",
            "ordinals.counts",
            "Count<'static>",
            model.ordinals.counts,
        ),
        table(
            "COUNTED_FROM",
            "ordinals.from",
            "CountedFrom<'static>",
            model.ordinals.from,
        ),
        table(
            "COUNTED_FIRST_WORDS",
            "ordinals.first_words",
            "&str",
            model.ordinals.first_words,
        ),
        table(
            "COUNTED_ARTICLES",
            "ordinals.articles",
            "&str",
            model.ordinals.articles,
        ),
        table(
            "COUNTED_NOUNS",
            "ordinals.nouns",
            "&str",
            model.ordinals.nouns,
        ),
        table(
            "NOT_COUNTED",
            "ordinals.unless",
            "&str",
            model.ordinals.unless,
        ),
        table(
            "LIST_BETWEEN",
            "arrangements.between",
            "&str",
            model.arrangements.between,
        ),
        table(
            "LIST_ENDS",
            "arrangements.ends",
            "&str",
            model.arrangements.ends,
        ),
        table(
            "ARRANGEMENTS",
            "arrangements.arrangements",
            "Arrangement<'static>",
            model.arrangements.arrangements,
        ),
        table(
            "OPENINGS",
            "arrangements.openings",
            "Opening<'static>",
            model.arrangements.openings,
        ),
        table(
            "CLOSINGS",
            "arrangements.closings",
            "Closing<'static>",
            model.arrangements.closings,
        ),
        table("TABLE_SIDES", "table.sides", "u8", model.table.sides),
        table("TABLE_OFF", "table.off", "&str", model.table.off),
        table(
            "TABLE_SOURCES",
            "table.sources",
            "&str",
            model.table.sources,
        ),
        table("TABLE_UNLESS", "table.unless", "&str", model.table.unless),
        table(
            "TABLE_REMOVING",
            "table.removing",
            "&str",
            model.table.removing,
        ),
        table("TABLE_DOWN", "table.down", "&str", model.table.down),
    ]
}
