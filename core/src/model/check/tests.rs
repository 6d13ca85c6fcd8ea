use super::*;
use crate::fixture;
use crate::model::{
    Concept, Embeddings, Heard, LexiconEntry, Plural, Pronoun, Several, Spelling, Word,
    WordEmbeddings,
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
