use super::*;
use crate::fixture;
use crate::model::{
    Arrangement, Arrangements, Closing, Compound, CompoundKind, CompoundText, Compounds, Concept,
    Count, CountedFrom, DistanceNumber, DistanceUnit, Embeddings, Heard, LexiconEntry, MAX_SIDES,
    Opening, Ordinals, Plural, Pronoun, Ranked, Repairs, Rephrased, Rephrasing, Sequence,
    SequenceText, Several, Spelling, Table, Word, WordEmbeddings,
};

#[test]
fn each_fault_of_a_list_is_named() {
    let model = fixture::model();
    assert_eq!(model.check(), Ok(()));
    let nothing = Model {
        actions: &[],
        ..model
    };
    assert_eq!(nothing.check(), Err(ModelFault::Empty("actions")));
    let concepts = [model.concepts[0]; MAX_INDEXED + 1];
    let too_many = Model {
        concepts: &concepts,
        ..model
    };
    assert_eq!(too_many.check(), Err(ModelFault::TooLong("concepts")));
}

#[test]
fn each_fault_of_the_spelling_is_named() {
    let check = |heard: &[(&'static str, &'static str)], other_words: &[u16]| {
        let heard: std::vec::Vec<_> = heard
            .iter()
            .map(|(text, known)| Heard::new().with_text(text).with_read_as(known))
            .collect();
        let spelling = Spelling::new()
            .with_heard(&heard)
            .with_other_words(other_words);
        let model = fixture::model().with_spelling(spelling);
        model.check().err().map(|fault| std::format!("{fault}"))
    };
    assert_eq!(check(&[("read", "red"), ("thee", "the")], &[1, 7]), None);
    for (heard, other_words, fault) in [
        (&[("thee", "the"), ("read", "red")][..], &[][..], "\"read\""),
        (&[("read", "red"), ("read", "red")], &[], "\"read\""),
        (&[("green", "red")], &[], "\"green\""),
        (&[("read", "rad")], &[], "as \"rad\", which is not known"),
        (&[], &[3, 3], "hash 3"),
        (&[], &[4, 3], "hash 3"),
    ] {
        let found = check(heard, other_words);
        assert!(found.is_some_and(|found| found.contains(fault)), "{fault}");
    }
}

#[test]
fn each_fault_of_a_word_is_named() {
    let model = fixture::model();
    let check = |words: &[&'static str], lexicon: &[(&'static str, u8)]| {
        let words: std::vec::Vec<Word<'static>> = words.iter().map(|text| Word { text }).collect();
        let embeddings = std::vec![WordEmbeddings::new(); words.len() + 1];
        let lexicon: std::vec::Vec<LexiconEntry<'static>> = lexicon
            .iter()
            .map(|&(text, concept)| LexiconEntry::new().with_text(text).with_concept(concept))
            .collect();
        let model = Model {
            words: &words,
            embeddings: Embeddings::F32(&embeddings),
            lexicon: &lexicon,
            ..model
        };
        model.check().map_err(|fault| std::format!("{fault:?}"))
    };
    let fault = |text: &str| Err(text.into());
    let missing = Embeddings::F32(&[]);
    let checked = model.with_embeddings(missing).check();
    assert_eq!(checked, Err(ModelFault::Embeddings(0)));
    assert_eq!(check(&["a", "b"], &[("c", 3)]), Ok(()));
    assert_eq!(check(&["b", "a"], &[("c", 3)]), fault("WordOrder(\"a\")"));
    assert_eq!(check(&["a", "a"], &[("c", 3)]), fault("WordOrder(\"a\")"));
    assert_eq!(
        check(&["a"], &[("c", 3), ("b", 0)]),
        fault("LexiconOrder(\"b\")")
    );
    assert_eq!(check(&["a"], &[("c", 4)]), fault("LexiconProperty(\"c\")"));
    assert_eq!(check(&["a"], &[("a", 0)]), fault("WordInLexicon(\"a\")"));
    let extreme = |action, word| {
        let mut actions = [model.actions[0], model.actions[1]];
        actions[1].extreme = word;
        let property = Property::Extreme(Extreme::Action(action));
        let lexicon = [LexiconEntry::new().with_text("a").with_property(property)];
        let model = model.with_actions(&actions).with_lexicon(&lexicon);
        model.check().map_err(|fault| std::format!("{fault:?}"))
    };
    assert_eq!(extreme(1, Some("a")), Ok(()));
    let missing = fault("LexiconProperty(\"a\")");
    assert_eq!(extreme(1, None), missing);
    assert_eq!(extreme(2, Some("a")), missing);
}

#[test]
fn each_fault_of_what_is_said_of_several_objects_is_named() {
    let model = fixture::model();
    let last = u16::try_from(model.words.len() - 1).unwrap();
    let fault = |text: &str| Err(text.into());
    let check = |between: &[u16], plurals: &[(&str, u16)]| {
        let each = |&(text, word): &_| Plural { text, word };
        let plurals: std::vec::Vec<Plural<'_>> = plurals.iter().map(each).collect();
        let several = Several::new().with_between(between).with_plurals(&plurals);
        let checked = model.with_several(several).check();
        checked.map_err(|fault| std::format!("{fault:?}"))
    };
    assert_eq!(check(&[0, last], &[("blocks", 0), ("cubes", 0)]), Ok(()));
    assert_eq!(
        check(&[last + 1], &[]),
        fault(&std::format!("Between({})", last + 1))
    );
    for (plurals, plural) in [
        (&[("cubes", 0), ("blocks", 0)][..], "blocks"),
        (&[("blocks", 0), ("blocks", 1)], "blocks"),
        (&[("red", 0)], "red"),
        (&[("blocks", last + 1)], "blocks"),
    ] {
        assert_eq!(
            check(&[], plurals),
            fault(&std::format!("Plural({plural:?})"))
        );
    }
    let mut lexicon = model.lexicon.to_vec();
    lexicon[0].property = Property::Quantifier(Quantifier::Each);
    let fault = ModelFault::LexiconProperty(lexicon[0].text);
    assert_eq!(model.with_lexicon(&lexicon).check(), Err(fault));
}

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
fn each_fault_of_a_pronoun_is_named() {
    let model = fixture::model();
    let check = |pronouns: &[(u16, Option<u16>)]| {
        let each = |&(word, owner)| Pronoun { word, owner };
        let pronouns: std::vec::Vec<Pronoun> = pronouns.iter().map(each).collect();
        let model = model.with_pronouns(&pronouns);
        model.check().map_err(|fault| std::format!("{fault:?}"))
    };
    let (last, fault) = (model.words.len() as u16 - 1, |text: &str| Err(text.into()));
    assert_eq!(check(&[(0, None), (last, Some(last))]), Ok(()));
    assert_eq!(check(&[(1, None), (1, None)]), fault("Pronoun(1)"));
    assert_eq!(check(&[(2, None), (1, None)]), fault("Pronoun(1)"));
    assert_eq!(
        check(&[(last + 1, None)]),
        fault(&std::format!("Pronoun({})", last + 1))
    );
    assert_eq!(check(&[(1, Some(last + 1))]), fault("Pronoun(1)"));
}

#[test]
fn each_fault_of_a_concept_is_named() {
    let model = fixture::model();
    let check = |change: fn(&mut Concept<'static>)| {
        let mut concepts = [model.concepts[0], model.concepts[1]];
        concepts[1].edges_m = Some([0.1; 3]);
        change(&mut concepts[1]);
        let lexicon = [LexiconEntry::new().with_text("green").with_concept(1)];
        let model = Model {
            concepts: &concepts,
            lexicon: &lexicon,
            ..model
        };
        model.check().err().map(|fault| std::format!("{fault:?}"))
    };
    assert_eq!(check(|_| ()), None);
    assert_eq!(
        check(|concept| concept.attribute = 2).as_deref(),
        Some("ConceptAttribute(\"green\")")
    );
    assert_eq!(
        check(|concept| concept.edges_m = Some([0.1, 0.0, 0.1])).as_deref(),
        Some("ConceptEdges(\"green\")")
    );
    assert_eq!(
        check(|concept| concept.edges_m = Some([0.1, f32::NAN, 0.1])).as_deref(),
        Some("ConceptEdges(\"green\")")
    );
    assert_eq!(
        check(|concept| concept.edges_m = None).as_deref(),
        Some("NoEdges")
    );
    for broken in [0.0, 1.01, f32::NAN] {
        let mut concepts = [model.concepts[0]];
        concepts[0].embedding[0] = broken;
        let lexicon = [LexiconEntry::new().with_text("red").with_concept(0)];
        let model = Model {
            concepts: &concepts,
            lexicon: &lexicon,
            ..model
        };
        assert_eq!(model.check(), Err(ModelFault::ConceptLength("red")));
    }
}

#[test]
fn each_fault_of_the_header_is_named() {
    let check = |change: fn(&mut Model<'static>)| {
        let mut model = fixture::model();
        change(&mut model);
        model.check()
    };
    let threshold = Err(ModelFault::Threshold);
    assert_eq!(check(|m| m.header.thresholds.decision = -0.1), threshold);
    assert_eq!(check(|m| m.header.thresholds.confidence = 1.1), threshold);
    assert_eq!(
        check(|m| m.header.thresholds.match_score = f32::NAN),
        threshold
    );
    let work_space = Err(ModelFault::WorkSpace);
    assert_eq!(check(|m| m.header.work_space.min[2] = 1.0), work_space);
    assert_eq!(
        check(|m| m.header.work_space.max[0] = f32::INFINITY),
        work_space
    );
    assert_eq!(
        check(|m| m.header.placed_orientation[3] = 0.5),
        Err(ModelFault::PlacedOrientation)
    );
    assert_eq!(
        check(|m| m.header.training_camera.fy = 0.0),
        Err(ModelFault::TrainingCamera(CameraError::NotPositive("fy")))
    );
}

#[test]
fn the_bounds_of_the_work_space_are_inside() {
    let space = fixture::model().header.work_space;
    assert!(space.contains(&space.min) && space.contains(&space.max));
    assert!(!space.contains(&[0.5, 0.5001, 0.3]));
    assert!(!space.contains(&[0.5, 0.0, -0.0001]));
    assert!(!space.contains(&[0.5, f32::NAN, 0.3]));
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
    let faults: [(Change, ModelFault<'_>); 12] = [
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
}
