//! What is rewritten before a sentence is read, in a domain: said in no words, or meaning nothing.

use nsrm_codegen::ModelError;
use serde_json::json;

use crate::{SpoilDomain, refused_domain};

#[test]
fn arrangements_that_mean_nothing() {
    let spoils: [(&str, SpoilDomain); 3] = [
        ("next", |domain| {
            domain["arrangements"]["next"] = json!(", next")
        }),
        ("put", |domain| {
            domain["arrangements"]["steps"]["up"]["order"] = json!("put")
        }),
        ("", |domain| {
            domain["arrangements"]["steps"]["up"]["relation"] = json!("")
        }),
    ];
    for (word, spoil) in spoils {
        let error = refused_domain(spoil, &["arrangements", word, "not a word of the domain"]);
        assert_eq!(error, ModelError::Arrangement { word: word.into() });
    }
    refused_domain(
        |domain| domain["arrangements"]["patterns"][1]["closings"]["up"] = json!("across"),
        &[
            "arrangements.patterns",
            "no steps \"across\"",
            "arrangements.steps",
        ],
    );
    let unreadable: [SpoilDomain; 10] = [
        |domain| domain["exceptions"]["phrases"] = json!(["Except"]),
        |domain| domain["exceptions"]["negations"] = json!([""]),
        |domain| domain["repairs"]["corrections"] = json!(["No"]),
        |domain| domain["repairs"]["exclusions"] = json!([""]),
        |domain| domain["apart"]["between"] = json!([""]),
        |domain| domain["apart"]["phrases"] = json!(["That is"]),
        |domain| domain["arrangements"]["patterns"][0]["openings"] = json!(["a  pile"]),
        |domain| domain["arrangements"]["patterns"][0]["openings"] = json!([""]),
        |domain| domain["arrangements"]["patterns"][0]["closings"] = json!({"Down": "down"}),
        |domain| domain["arrangements"]["ends"] = json!(["and then"]),
    ];
    for spoil in unreadable {
        refused_domain(spoil, &["no sentence can contain"]);
    }
}

#[test]
fn a_table_that_is_no_place() {
    let spoils: [(SpoilDomain, &[&str]); 8] = [
        (|table| table["words"] = json!([]), &["words for the table"]),
        (|table| table["sides"] = json!([]), &["sides of the table"]),
        (
            |table| table["sides"] = json!(vec!["Flank"; 9]),
            &["sides of the table", "8"],
        ),
        (
            |table| table["sides"] = json!(["Above"]),
            &["table", "no action \"Above\""],
        ),
        (
            |table| table["action"] = json!("Above"),
            &["table", "no action \"Above\""],
        ),
        (
            |table| table["order"] = json!("put it"),
            &["table", "\"put\" is not a word of the"],
        ),
        (
            |table| table["off"] = json!(["Off"]),
            &["no sentence can contain"],
        ),
        (|table| table["words"] = json!(["then"]), &["\"then\""]),
    ];
    for (spoil, texts) in spoils {
        refused_domain(|domain| spoil(&mut domain["table"]), texts);
    }
    let error = refused_domain(
        |domain| domain["attribute"][1]["values"][0]["edges_m"] = json!([0.08, 0.06, 0.1]),
        &["table", "three times as high"],
    );
    assert_eq!(error, ModelError::TableHeight);
}

#[test]
fn what_cannot_be_counted() {
    let spoils: [(SpoilDomain, &[&str]); 7] = [
        (
            |all| all["counts"] = json!([["first"], []]),
            &["words of a count"],
        ),
        (
            |all| all["counts"] = json!(vec![["first"]; 200]),
            &["extremes times counts", "256"],
        ),
        (
            |all| all["counts"] = json!([["first"], ["first"]]),
            &["count", "\"first\""],
        ),
        (
            |all| all["first"] = json!({"from outside": "Largest"}),
            &["text from where is counted", "\"from outside\""],
        ),
        (
            |all| all["starts"] = json!({"from above": "Stack"}),
            &["\"Stack\" has no words in extremes"],
        ),
        (
            |all| all["starts"] = json!({"from Above": "Flank"}),
            &["no sentence can contain"],
        ),
        (
            |all| all["nouns"] = json!([""]),
            &["no sentence can contain"],
        ),
    ];
    for (spoil, texts) in spoils {
        refused_domain(|domain| spoil(&mut domain["ordinals"]), texts);
    }
}

#[test]
fn compounds_that_are_made_of_nothing() {
    let spoils: [(SpoilDomain, &[&str]); 8] = [
        (|one| one["any"] = json!([]), &["actions of \"Nearby\""]),
        (
            |one| one["any"] = json!(vec!["Flank"; 9]),
            &["actions of a compound", "8"],
        ),
        (
            |one| one["any"] = json!(["Above"]),
            &["\"Nearby\"", "no action \"Above\""],
        ),
        (
            |one| one["all"] = json!(["Flank", "Stack"]),
            &["\"Nearby\"", "only one of these"],
        ),
        (
            |one| (one["any"], one["all"]) = (json!([]), json!(["Flank"])),
            &["\"Nearby\"", "`all` of 2"],
        ),
        (
            |one| one["read"] = json!("near by"),
            &["\"Nearby\"", "\"by\" is not a word of the"],
        ),
        (
            |one| one["said"] = json!(["By"]),
            &["no sentence can contain"],
        ),
        (|one| one["name"] = json!("Stack"), &["action", "\"Stack\""]),
    ];
    for (spoil, texts) in spoils {
        refused_domain(|domain| spoil(&mut domain["compounds"]["made"][0]), texts);
    }
    refused_domain(
        |domain| domain["compounds"]["sides"] = json!(["On the left"]),
        &["no sentence can contain"],
    );
    refused_domain(
        |domain| domain["compounds"]["made"][1]["said"] = json!(["by"]),
        &["text of a compound", "\"by\""],
    );
    let error = refused_domain(
        |domain| {
            domain["table"] = json!(null);
            domain["attribute"][1]["values"][0]["edges_m"] = json!([0.08, 0.06, 0.1]);
        },
        &["three times as high"],
    );
    assert_eq!(error, ModelError::TableHeight);
}

#[test]
fn an_order_of_steps_that_cannot_be_said() {
    let unknown: [SpoilDomain; 2] = [
        |domain| domain["sequence"]["next"] = json!("thereupon"),
        |domain| domain["sequence"]["later"] = json!({"before you": "thereupon"}),
    ];
    for spoil in unknown {
        let error = refused_domain(
            spoil,
            &["sequence", "thereupon", "not a word of the domain"],
        );
        let word = "thereupon".into();
        assert_eq!(error, ModelError::Sequence { word });
    }
    refused_domain(
        |domain| domain["sequence"]["afterthoughts"] = json!(["after you"]),
        &[
            "sequence",
            "\"after you\" is in earlier and in afterthoughts",
        ],
    );
    let unreadable: [SpoilDomain; 3] = [
        |domain| domain["sequence"]["earlier"] = json!({"After": ""}),
        |domain| domain["sequence"]["later"] = json!({"": ""}),
        |domain| domain["sequence"]["afterthoughts"] = json!([""]),
    ];
    for spoil in unreadable {
        refused_domain(spoil, &["no sentence can contain"]);
    }
}

#[test]
fn distances_that_cannot_be_said_or_are_none() {
    for (key, text, length) in [("units", "cm", 0.0), ("numbers", "two", -2.0)] {
        let error = refused_domain(
            |domain| domain["distances"][key] = json!({text: length}),
            &["distances", text, "must be a positive number"],
        );
        assert_eq!(error, ModelError::Length { text: text.into() });
    }
    refused_domain(
        |domain| domain["distances"]["sides"] = json!(["Lift"]),
        &["distances.sides", "no action \"Lift\""],
    );
    refused_domain(
        |domain| domain["distances"]["beside"] = json!("beneath"),
        &["distances", "beneath", "not a word of the domain"],
    );
    let error = refused_domain(
        |domain| domain["distances"]["shifts"] = json!({"Lift": ["up"]}),
        &["distances.shifts", "\"Lift\" is not in distances.sides"],
    );
    let name = "Lift".into();
    assert_eq!(error, ModelError::ShiftSide { name });
    refused_domain(
        |domain| domain["distances"]["shifts"] = json!({"Flank": ["To the side"]}),
        &["no sentence can contain"],
    );
    for key in ["before", "behind", "from", "unless", "origins"] {
        refused_domain(
            |domain| domain["distances"][key] = json!(["By"]),
            &["no sentence can contain"],
        );
    }
}

#[test]
fn phrases_that_cannot_be_read_or_are_read_as_no_words() {
    let error = refused_domain(
        |domain| domain["rephrasing"] = json!({"is to": "ought to"}),
        &["rephrasing", "\"ought\" is not a word of the domain"],
    );
    let word = "ought".into();
    assert_eq!(error, ModelError::Rephrased { word });
    refused_domain(
        |domain| domain["simplification"]["closing"] = json!({"is to": "ought to"}),
        &["\"ought\" is not a word of the domain"],
    );
    let error = refused_domain(
        |domain| domain["simplification"]["connecting"] = json!({"and then": "then"}),
        &[
            "simplification.connecting",
            "\"and then\" only connects a step",
        ],
    );
    let text = "and then".into();
    assert_eq!(error, ModelError::Connecting { text });
    refused_domain(
        |domain| domain["simplification"]["taking"]["object"] = json!("that"),
        &["\"that\" is not a word of the domain"],
    );
    refused_domain(
        |domain| domain["simplification"]["standing"]["read_as"] = json!("jar that"),
        &["\"that\" is not a word of the domain"],
    );
    refused_domain(
        |domain| domain["simplification"]["standing"]["clauses"] = json!(["That is"]),
        &["no sentence can contain"],
    );
    refused_domain(
        |domain| domain["simplification"]["starting"] = json!(["First"]),
        &["no sentence can contain"],
    );
    refused_domain(
        |domain| domain["simplification"]["taking"]["words"] = json!(["Lift"]),
        &["no sentence can contain"],
    );
    refused_domain(
        |domain| domain["rephrasing"] = json!({"Is to": ""}),
        &["no sentence can contain"],
    );
}
