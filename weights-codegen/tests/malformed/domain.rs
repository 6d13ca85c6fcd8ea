//! An invalid domain, and a vocabulary that is not the domain's.

use nsrm_codegen::ModelError;
use serde_json::{Value, json};

use crate::common;
use crate::{SpoilDomain, refused, refused_domain};

#[test]
fn empty_lists() {
    let spoils: [SpoilDomain; 6] = [
        |domain| domain["attribute"] = json!([]),
        |domain| domain["action"] = json!([]),
        |domain| domain["attribute"][1]["values"] = json!([]),
        |domain| domain["attribute"][1]["values"][0]["words"] = json!([]),
        |domain| domain["action"][1]["phrases"] = json!([]),
        |domain| domain["extremes"]["Smallest"] = json!([]),
    ];
    for spoil in spoils {
        let error = refused_domain(spoil, &["must not be empty", "train again"]);
        assert!(matches!(error, ModelError::Empty { .. }), "{error:?}");
    }
}

#[test]
fn more_names_than_an_index_holds() {
    let value = |n: usize| json!({"name": format!("v{n}"), "words": [format!("v{n}")]});
    let action = |n: usize| json!({"name": format!("a{n}"), "phrases": ["onto"]});
    let attribute =
        |n: usize| json!({"name": format!("t{n}"), "view": "color", "values": [value(n)]});
    let spoils: [(&str, &str, Vec<Value>); 3] = [
        (
            "concepts",
            "/attribute/0/values",
            (0..253).map(value).collect(),
        ),
        ("actions", "/action", (0..257).map(action).collect()),
        (
            "attribute types",
            "/attribute",
            (0..257).map(attribute).collect(),
        ),
    ];
    for (what, place, list) in spoils {
        let spoil = |domain: &mut Value| *domain.pointer_mut(place).expect("a list") = json!(list);
        let error = refused_domain(spoil, &["at most 256", what, "got 257"]);
        assert_eq!(
            error,
            ModelError::TooMany {
                what,
                limit: 256,
                got: 257
            }
        );
    }
}

#[test]
fn sizes_that_no_object_has() {
    let error = refused_domain(
        |domain| {
            let values = domain["attribute"][1]["values"].as_array_mut();
            for value in values.expect("values") {
                value["edges_m"] = Value::Null;
            }
        },
        &["edges_m", "must not be empty"],
    );
    assert!(matches!(error, ModelError::Empty { .. }), "{error:?}");
    let error = refused_domain(
        |domain| domain["attribute"][2]["values"][0]["edges_m"] = json!([0.1, 0.1, 0.1]),
        &["at most 1 attribute types with edges_m, got 2"],
    );
    assert!(matches!(error, ModelError::TooMany { .. }), "{error:?}");
    for (edges, got) in [
        (json!([0.02, 0.0, 0.03]), Some([0.02, 0.0, 0.03])),
        (json!([0.02, -0.02, 0.03]), Some([0.02, -0.02, 0.03])),
        (Value::Null, None),
    ] {
        let error = refused_domain(
            |domain| domain["attribute"][1]["values"][1]["edges_m"] = edges,
            &["edges_m of \"tiny\"", "three lengths in metres"],
        );
        let concept = "tiny".into();
        assert_eq!(error, ModelError::Edges { concept, got });
    }
}

#[test]
fn more_words_than_an_index_holds() {
    let nouns: Vec<String> = (0..70_000).map(|n| format!("n{n}")).collect();
    let spoil = |domain: &mut Value| domain["grammar"]["nouns"] = json!(nouns);
    let error = refused_domain(spoil, &["at most 65536 words"]);
    assert!(matches!(
        error,
        ModelError::TooMany {
            what: "words",
            limit: 65_536,
            ..
        }
    ));
}

#[test]
fn names_that_stand_there_twice() {
    let spoils: [(&str, &str, SpoilDomain); 7] = [
        ("attribute type", "tint", |domain| {
            domain["attribute"][1]["name"] = json!("tint")
        }),
        ("concept", "teal", |domain| {
            domain["attribute"][1]["values"][0]["name"] = json!("teal");
        }),
        ("action", "Stack", |domain| {
            domain["action"][1]["name"] = json!("Stack")
        }),
        ("word", "teal", |domain| {
            domain["attribute"][1]["values"][0]["words"] = json!(["teal"]);
        }),
        ("word", "teal", |domain| {
            domain["grammar"]["nouns"] = json!(["teal"])
        }),
        ("word", "jar", |domain| {
            domain["spelling"]["other_words"] = json!(["jam", "jar"])
        }),
        ("word", "plum", |domain| {
            domain["spelling"]["heard"]["plum"] = json!("teal")
        }),
    ];
    for (what, name, spoil) in spoils {
        let error = refused_domain(spoil, &[what, name, "twice"]);
        assert_eq!(
            error,
            ModelError::Duplicate {
                what,
                name: name.into()
            }
        );
    }
}

#[test]
fn an_extreme_of_no_action() {
    let error = refused_domain(
        |domain| domain["extremes"]["Flink"] = json!(["uttermost"]),
        &["extremes", "\"Flink\" is no action of the domain"],
    );
    let name = "Flink".into();
    assert_eq!(error, ModelError::Extreme { name });
    refused_domain(
        |domain| domain["extremes"]["Smallest"] = json!(["teal"]),
        &["\"teal\" occurs twice"],
    );
}

#[test]
fn a_word_that_is_heard_as_an_unknown_one() {
    let error = refused_domain(
        |domain| domain["spelling"]["heard"]["steal"] = json!("steel"),
        &["\"steal\" is read as \"steel\"", "not a word of the domain"],
    );
    let (text, read_as) = ("steal".into(), "steel".into());
    assert_eq!(error, ModelError::HeardAs { text, read_as });
}

#[test]
fn what_is_said_of_several_objects_in_words_that_are_none() {
    let spoils: [(&str, SpoilDomain); 2] = [
        ("of", |domain| {
            domain["several"]["between"] = json!(["the", "of"])
        }),
        ("glass", |domain| {
            domain["several"]["plurals"]["glasses"] = json!("glass")
        }),
    ];
    for (word, spoil) in spoils {
        let error = refused_domain(spoil, &["several", word, "not a word of the domain"]);
        assert_eq!(error, ModelError::Several { word: word.into() });
    }
    refused_domain(
        |domain| domain["several"]["plurals"]["teal"] = json!("jar"),
        &["\"teal\" occurs twice"],
    );
    refused_domain(
        |domain| domain["several"]["all"] = json!(["both"]),
        &["\"both\" occurs twice"],
    );
    refused_domain(
        |domain| domain["several"]["plurals"]["big jars"] = json!("jar"),
        &["no sentence can contain", "\"big jars\""],
    );
}

#[test]
fn pronouns_that_are_no_words() {
    refused_domain(
        |domain| domain["conjunctions"] = json!(["so That"]),
        &["no sentence can contain", "That"],
    );
    let spoils: [(&str, SpoilDomain); 4] = [
        ("set", |domain| domain["placing"] = json!(["set"])),
        ("that", |domain| domain["pronouns"]["that"] = json!("")),
        ("plum", |domain| domain["pronouns"]["plum"] = json!("")),
        ("glass", |domain| {
            domain["pronouns"]["near"] = json!("glass")
        }),
    ];
    for (word, spoil) in spoils {
        let error = refused_domain(spoil, &["pronouns", word, "not a word of the domain"]);
        assert_eq!(error, ModelError::Pronoun { word: word.into() });
    }
}

#[test]
fn words_that_no_sentence_contains() {
    for word in ["Jar", "", "two words", "jar.", "'jar", "a,b"] {
        let spoil =
            |domain: &mut Value| domain["attribute"][0]["values"][1]["words"] = json!([word]);
        let error = refused_domain(spoil, &["no sentence can contain"]);
        assert_eq!(error, ModelError::UnreadableWord { word: word.into() });
    }
    let error = refused_domain(
        |domain| domain["grammar"]["nouns"] = json!(["Jar"]),
        &["Jar"],
    );
    assert_eq!(error, ModelError::UnreadableWord { word: "Jar".into() });
}

#[test]
fn no_group_token() {
    for (vocabulary, got) in [(json!([]), ""), (json!(["the", "[[X]]"]), "the")] {
        let error = refused(
            |file| file.set("vocabulary", vocabulary),
            &["[[X]]", "first entry"],
        );
        assert_eq!(error, ModelError::GroupToken { got: got.into() });
    }
}

fn vocabulary(change: impl FnOnce(&mut Vec<&str>)) -> Value {
    let mut words = vec!["[[X]]"];
    words.extend(common::WORDS);
    change(&mut words);
    json!(words)
}

#[test]
fn a_vocabulary_that_is_not_the_domains() {
    let words = vocabulary(|words| words[3] = "mug");
    let error = refused(
        |file| file.set("vocabulary", words),
        &["lacks \"jar\"", "also has \"mug\"", "train again"],
    );
    let (missing, extra) = (vec!["jar".into()], vec!["mug".into()]);
    assert_eq!(error, ModelError::Vocabulary { missing, extra });
}

#[test]
fn a_long_difference_is_cut_short() {
    let error = refused(
        |file| file.set("vocabulary", json!(["[[X]]"])),
        &["and 1 more"],
    );
    assert!(matches!(error, ModelError::Vocabulary { ref missing, .. } if missing.len() == 9));
}

#[test]
fn a_word_twice_in_the_vocabulary() {
    let words = vocabulary(|words| words.push("the"));
    let error = refused(|file| file.set("vocabulary", words), &["\"the\"", "twice"]);
    let what = "word of the vocabulary";
    assert_eq!(
        error,
        ModelError::Duplicate {
            what,
            name: "the".into()
        }
    );
}

#[test]
fn a_vocabulary_out_of_order() {
    let words = vocabulary(|words| words.swap(2, 3));
    let error = refused(
        |file| file.set("vocabulary", words),
        &["\"jar\" before \"beside\""],
    );
    let (first, second) = ("jar".into(), "beside".into());
    assert_eq!(error, ModelError::VocabularyOrder { first, second });
}
