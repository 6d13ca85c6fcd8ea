use super::*;
use crate::dsl::Extreme;
use crate::fixture;
use crate::model::{
    Arrangement, Arrangements, Closing, Compound, CompoundKind, CompoundText, Compounds, Count,
    CountedFrom, DistanceNumber, DistanceShift, DistanceUnit, Lists, MAX_SIDES, Opening, Ordinals,
    Perspectives, Ranked, Repairs, Rephrased, Rephrasing, Sequence, SequenceText, Simplification,
    Table, Taking,
};

#[test]
fn each_fault_of_an_arrangement_is_named() {
    let model = fixture::model();
    let check = |openings: &[&'static str], arrangement, order, next| {
        let opening = |&text: &_| Opening { text, pattern: 0 };
        let openings: std::vec::Vec<_> = openings.iter().map(opening).collect();
        let closings = [Closing::new().with_arrangement(arrangement)];
        let arrangements = [Arrangement::new().with_order(order).with_relation("on the")];
        let said = Arrangements::new()
            .with_next(next)
            .with_arrangements(&arrangements)
            .with_openings(&openings)
            .with_closings(&closings);
        let checked = model.with_arrangements(said).check();
        checked.map_err(|fault| std::format!("{fault:?}"))
    };
    let good = ["a tower of", "a tower of", "build"];
    assert_eq!(check(&good, 0, "put the", ", then"), Ok(()));
    for (openings, opening) in [(&["b", "a"][..], "a"), (&[""], "")] {
        let fault = std::format!("Opening({opening:?})");
        assert_eq!(check(openings, 0, "put", "then"), Err(fault));
    }
    let fault = Err("Closing(\"\")".into());
    assert_eq!(check(&good, 1, "put", "then"), fault);
    for words in [["and", "and"], ["and", ","]] {
        for said in [
            Arrangements::new().with_between(&words),
            Arrangements::new().with_ends(&words),
        ] {
            let fault = ModelFault::ListWord(words[1]);
            assert_eq!(model.with_arrangements(said).check(), Err(fault));
        }
    }
    for (order, next, word) in [
        ("place", "then", "place"),
        ("put", "next", "next"),
        ("", "then", ""),
        ("put", "", ""),
        ("put  the", "then", ""),
    ] {
        let fault = std::format!("ArrangementWord({word:?})");
        assert_eq!(check(&good, 0, order, next), Err(fault));
    }
}

#[test]
fn each_fault_of_a_table_is_named() {
    type Change = fn(&mut Table<'static>);
    let model = fixture::with_table();
    let check = |change: Change| {
        let mut table = model.table;
        change(&mut table);
        model.with_table(table).check()
    };
    assert_eq!(check(|_| ()), Ok(()));
    let faults: [(Change, ModelFault<'_>); 9] = [
        (
            |table| table.sources = &["from", "from"],
            ModelFault::TableText("from"),
        ),
        (|table| table.removing = &[""], ModelFault::TableText("")),
        (
            |table| table.taking = "withdraw",
            ModelFault::TableWord("withdraw"),
        ),
        (|table| table.action = 2, ModelFault::TableAction),
        (|table| table.sides = &[2], ModelFault::TableAction),
        (
            |table| table.sides = &[1; MAX_SIDES + 1],
            ModelFault::TableAction,
        ),
        (
            |table| table.off = &["off", "down from"],
            ModelFault::TableText("down from"),
        ),
        (|table| table.order = "put  on", ModelFault::TableWord("")),
        // A word of the lexicon then means what is not there.
        (
            |table| table.sides = &[],
            ModelFault::LexiconProperty("desk"),
        ),
    ];
    for (change, fault) in faults {
        assert_eq!(check(change), Err(fault));
    }
    let mut concepts = model.concepts.to_vec();
    // Three times as high as the lowest.
    concepts[2].edges_m = Some([0.1, 0.1, 3.0 * fixture::EDGE_M]);
    let model = model.with_concepts(&concepts);
    assert_eq!(model.check(), Err(ModelFault::TableHeight));
}

#[test]
fn each_fault_of_a_compound_is_named() {
    type Change = fn(&mut Compounds<'static>);
    let model = fixture::with_compounds();
    let check = |change: Change| {
        let mut compounds = model.compounds;
        change(&mut compounds);
        model.with_compounds(compounds).check()
    };
    const ANY: Compound<'static> = Compound::new()
        .with_name("NextTo")
        .with_parts(&[1])
        .with_read("right");
    const BY: CompoundText<'static> = CompoundText::new().with_text("by").with_compound(0);
    assert_eq!(
        check(|made| (made.compounds, made.said) = (&[ANY], &[BY])),
        Ok(())
    );
    let faults: [(Change, ModelFault<'_>); 13] = [
        (
            |made| made.first_words = &["by", "what", "past"],
            ModelFault::CompoundText("close to"),
        ),
        (
            |made| (made.said, made.first_words) = (&[BY], &["by", "at"]),
            ModelFault::CompoundText("at"),
        ),
        (
            |made| made.compounds = &[const { ANY.with_parts(&[]) }; 5],
            ModelFault::CompoundParts("NextTo"),
        ),
        (
            |made| made.compounds = &[const { ANY.with_parts(&[2]) }; 5],
            ModelFault::CompoundParts("NextTo"),
        ),
        (
            |made| made.compounds = &[const { ANY.with_parts(&[1; MAX_SIDES + 1]) }; 5],
            ModelFault::CompoundParts("NextTo"),
        ),
        (
            |made| made.compounds = &[const { ANY.with_kind(CompoundKind::All) }; 5],
            ModelFault::CompoundParts("NextTo"),
        ),
        (
            |made| {
                made.compounds =
                    &[const { ANY.with_kind(CompoundKind::Between).with_parts(&[1, 0]) }; 5];
            },
            ModelFault::CompoundParts("NextTo"),
        ),
        (
            |made| made.compounds = &[const { ANY.with_read("right of") }; 5],
            ModelFault::CompoundWord("of"),
        ),
        (
            |made| (made.compounds, made.said) = (&[ANY], &[const { BY.with_compound(1) }]),
            ModelFault::CompoundText("by"),
        ),
        (
            |made| (made.compounds, made.said) = (&[ANY], &[BY, BY]),
            ModelFault::CompoundText("by"),
        ),
        (
            |made| (made.compounds, made.said) = (&[ANY], &[const { BY.with_text("") }]),
            ModelFault::CompoundText(""),
        ),
        (
            |made| made.sides = &["right", "left"],
            ModelFault::CompoundText("left"),
        ),
        (
            |made| made.compounds = &[ANY; 256],
            ModelFault::TooLong("actions"),
        ),
    ];
    for (change, fault) in faults {
        assert_eq!(check(change), Err(fault));
    }
    let mut concepts = model.concepts.to_vec();
    // Three times as high as the lowest.
    concepts[2].edges_m = Some([0.1, 0.1, 3.0 * fixture::EDGE_M]);
    let related = fixture::related().with_concepts(&concepts);
    assert_eq!(related.check(), Ok(()));
    let high = related.with_compounds(model.compounds);
    assert_eq!(high.check(), Err(ModelFault::TableHeight));
}

#[test]
fn each_fault_of_what_is_counted_is_named() {
    const COUNT: Count<'static> = Count::new().with_text("a").with_rank(1);
    const FROM: CountedFrom<'static> = CountedFrom::new()
        .with_text("a")
        .with_extreme(Extreme::Action(1));
    const RANKED: Ranked<'static> = Ranked::new()
        .with_name("a")
        .with_extreme(Extreme::Largest)
        .with_rank(2);
    let model = fixture::with_ordinals();
    let check = |change: &dyn Fn(&mut Ordinals<'static>)| {
        let mut ordinals = model.ordinals;
        change(&mut ordinals);
        let checked = model.with_ordinals(ordinals).check();
        checked.map_err(|fault| std::format!("{fault:?}"))
    };
    let ranked = || Err(std::string::String::from("Ranked(\"a\")"));
    let text = |text| Err(std::format!("OrdinalText({text:?})"));
    assert_eq!(check(&|_| {}), Ok(()));
    assert_eq!(check(&|all| all.ranked = &[RANKED]), Ok(()));
    assert_eq!(
        check(&|all| all.ranked = &[const { RANKED.with_rank(1) }]),
        ranked()
    );
    assert_eq!(
        check(&|all| all.ranked = &[const { RANKED.with_extreme(Extreme::Action(2)) }]),
        ranked()
    );
    assert_eq!(check(&|all| all.ranked = &[RANKED, RANKED]), ranked());
    assert_eq!(
        check(&|all| all.counts = &[const { COUNT.with_rank(0) }]),
        text("a")
    );
    assert_eq!(check(&|all| all.counts = &[COUNT, COUNT]), text("a"));
    assert_eq!(
        check(&|all| all.from = &[const { FROM.with_extreme(Extreme::Action(2)) }]),
        text("a")
    );
    assert_eq!(check(&|all| all.from = &[FROM, FROM]), text("a"));
    assert_eq!(check(&|all| all.first_words = &[]), text("nearby right"));
    assert_eq!(check(&|all| all.first_words = &["nearby", "a"]), text("a"));
    assert_eq!(check(&|all| all.articles = &["b", "a"]), text("a"));
    assert_eq!(check(&|all| all.nouns = &["a", "a"]), text("a"));
    assert_eq!(check(&|all| all.unless = &[""]), text(""));
}

#[test]
fn each_fault_of_what_is_read_as_other_words_is_named() {
    let model = fixture::related();
    let check = |texts: [&'static str; 2], read_as, first_words| {
        let said = texts.map(|text| Rephrased::new().with_text(text).with_read_as(read_as));
        let rephrasing = Rephrasing::new().with_said(&said);
        let model = model.with_rephrasing(rephrasing.with_first_words(first_words));
        model
            .check()
            .map_err(|fault| std::string::ToString::to_string(&fault))
    };
    let first: &[&str] = &["is", "so"];
    assert_eq!(check(["is to", "so that"], "put", first), Ok(()));
    let repeated = [Rephrased::new().with_text("so"); 2];
    let list = Rephrasing::new()
        .with_said(&repeated)
        .with_first_words(&["so"]);
    let none = Simplification::new();
    let taking = Taking::new().with_order("put").with_object("the");
    let words: &[&str] = &["grab", "take"];
    for (taking, fault) in [
        (
            taking.with_words(&["take", "grab"]),
            ModelFault::TakingText("grab"),
        ),
        (
            taking.with_words(words).with_towards(&[""]),
            ModelFault::TakingText(""),
        ),
        (
            taking.with_words(words).with_order("toss"),
            ModelFault::RephrasedWord("toss"),
        ),
        (
            taking.with_words(words).with_object(""),
            ModelFault::RephrasedWord(""),
        ),
    ] {
        let simplification = none.with_taking(taking);
        let checked = model.with_simplification(simplification).check();
        assert_eq!(checked, Err(fault));
    }
    for simplification in [
        none.with_opening(list),
        none.with_anywhere(list),
        none.with_closing(list),
        none.with_connecting(list),
    ] {
        let checked = model.with_simplification(simplification).check();
        assert_eq!(checked, Err(ModelFault::Rephrased("so")));
    }
    let connecting = [Rephrased::new().with_text("so").with_read_as("put")];
    let connecting = list.with_said(&connecting);
    let checked = model.with_simplification(none.with_connecting(connecting));
    assert_eq!(checked.check(), Err(ModelFault::Connecting("so")));
    let checked = model.with_simplification(none.with_starting(&["first", "begin"]));
    assert_eq!(checked.check(), Err(ModelFault::Connecting("begin")));
    assert_eq!(check(["is to", "so that"], "", first), Ok(()));
    for (texts, first_words, named) in [
        (["so that", "is to"], first, "\"is to\", which is read"),
        (["is to", "so that"], &["so", "is"], "\"is\", which is read"),
        (["", "so that"], first, "\"\", which is read"),
        (["has to", "is to"], first, "\"has to\", which is read"),
    ] {
        let fault = check(texts, "put", first_words).unwrap_err();
        assert!(fault.starts_with(named), "{fault}");
    }
    let fault = check(["is to", "so that"], "put beneath", first).unwrap_err();
    assert!(
        fault.starts_with("word \"beneath\", which is read"),
        "{fault}"
    );
}

#[test]
fn each_fault_of_repairs_and_of_a_sequence_is_named() {
    let model = fixture::related();
    let repairs = |corrections, exclusions| {
        let repairs = Repairs::new().with_corrections(corrections);
        model
            .with_repairs(repairs.with_exclusions(exclusions))
            .check()
    };
    assert_eq!(repairs(&["no", "sorry"], &["not"]), Ok(()));
    let text = |text| Err(ModelFault::RepairText(text));
    assert_eq!(repairs(&["sorry", "no"], &[]), text("no"));
    assert_eq!(repairs(&[], &[""]), text(""));
    let sequence = |texts: [&'static str; 2], read_as, first_words, next| {
        let texts = texts.map(|text| SequenceText::new().with_text(text).with_read_as(read_as));
        let sequence = Sequence::new().with_later(&texts[..1]);
        let sequence = sequence.with_earlier(&texts[1..]).with_next(next);
        let model = model.with_sequence(sequence.with_first_words(first_words));
        model
            .check()
            .map_err(|fault| std::string::ToString::to_string(&fault))
    };
    let first: &[&str] = &["after", "before"];
    assert_eq!(
        sequence(["before", "after putting"], "put", first, "then"),
        Ok(())
    );
    for (texts, first_words, named) in [
        (["", "after"], first, "\"\", which says the order"),
        (["before", "hence"], first, "\"hence\", which"),
        (
            ["before", "after"],
            &["before", "after"],
            "\"after\", which",
        ),
    ] {
        let fault = sequence(texts, "", first_words, "then").unwrap_err();
        assert!(fault.starts_with(named), "{fault}");
    }
    for (read_as, next) in [("place", "then"), ("", "thereupon")] {
        let fault = sequence(["before", "after"], read_as, first, next).unwrap_err();
        assert!(
            fault.contains("is read where two steps are put in order"),
            "{fault}"
        );
    }
}

#[test]
fn each_fault_of_distances_is_named() {
    let check = |change: &dyn Fn(&mut crate::model::Distances<'static>)| {
        let mut model = fixture::with_distances();
        change(&mut model.distances);
        model.check()
    };
    const UNIT: DistanceUnit<'_> = DistanceUnit::new().with_text("cm").with_mm(10.0);
    const NUMBER: DistanceNumber<'_> = DistanceNumber::new().with_text("two");
    let text = |text| Err(ModelFault::DistanceText(text));
    assert_eq!(check(&|_| {}), Ok(()));
    assert_eq!(check(&|all| all.units = &[UNIT, UNIT]), text("cm"));
    assert_eq!(
        check(&|all| all.units = &[const { UNIT.with_mm(f32::NAN) }]),
        text("cm")
    );
    assert_eq!(check(&|all| all.numbers = &[NUMBER]), text("two"));
    assert_eq!(check(&|all| all.numbers = &[NUMBER, NUMBER]), text("two"));
    assert_eq!(check(&|all| all.before = &["by", "about"]), text("about"));
    assert_eq!(check(&|all| all.behind = &[""]), text(""));
    assert_eq!(check(&|all| all.from = &["from", "from"]), text("from"));
    assert_eq!(check(&|all| all.unless = &["the", "a"]), text("a"));
    let word = Err(ModelFault::DistanceWord("beneath"));
    assert_eq!(check(&|all| all.beside = "past beneath"), word);
    assert_eq!(check(&|all| all.sides = &[]), text("cm"));
    assert_eq!(check(&|all| all.sides = &[1, 2]), text("cm"));
    const SHIFT: DistanceShift<'_> = DistanceShift::new().with_text("aside").with_action(1);
    assert_eq!(check(&|all| all.shifts = &[SHIFT]), Ok(()));
    assert_eq!(check(&|all| all.shifts = &[SHIFT, SHIFT]), text("aside"));
    const UP: DistanceShift<'_> = SHIFT.with_action(0);
    assert_eq!(check(&|all| all.shifts = &[UP]), text("aside"));
    assert_eq!(check(&|all| all.origins = &["there", "here"]), text("here"));
    let mut model = fixture::with_distances();
    model.actions = fixture::model().actions;
    assert_eq!(model.check(), Err(ModelFault::DistanceWord("to")));
}

#[test]
fn each_fault_of_perspectives_and_lists_is_named() {
    let model = fixture::model();
    let said = Perspectives::new()
        .with_own(&["as i see it"])
        .with_other(&["as you see it", "from there"])
        .with_first_words(&["as", "from"])
        .with_opposites(&[1, 0]);
    let check = |perspectives| model.with_perspectives(perspectives).check();
    assert_eq!(check(said), Ok(()));
    for (perspectives, fault) in [
        (
            said.with_own(&["from here", "as i see it"]),
            ModelFault::PerspectiveText("as i see it"),
        ),
        (
            said.with_first_words(&["as"]),
            ModelFault::PerspectiveText("from there"),
        ),
        (said.with_opposites(&[1]), ModelFault::Opposites),
        (said.with_opposites(&[1, 1]), ModelFault::Opposites),
        (said.with_opposites(&[]), ModelFault::Opposites),
        (said.with_other(&[]), ModelFault::Opposites),
    ] {
        assert_eq!(check(perspectives), Err(fault));
    }
    let lists = Lists::new().with_between(&["and"]).with_next("the");
    let check = |lists| model.with_lists(lists).check();
    assert_eq!(check(lists), Ok(()));
    let fault = check(lists.with_them(&["them", "them"]));
    assert_eq!(fault, Err(ModelFault::ListedText("them")));
    let fault = check(lists.with_next("whereupon"));
    assert_eq!(fault, Err(ModelFault::ListedWord("whereupon")));
}
