//! The command `nsrm`: what it prints, its exit codes, and one message for each
//! refusal and each kind of bad input.
#![cfg(feature = "command")]

mod common;

use common::{Bench, DEPTH_M, ModelFile, ORIENTATION, POSITION, done, pretrained, refused, scene};
use serde_json::{Value, json};

const SENTENCE: &str = "Put the red block on the small blue block, then move the blue cube \
                        to the right of the red one.";

#[test]
fn parses() {
    let bench = Bench::new();
    let model = ["--model", "model.safetensors"];
    let text = done(&bench.run(&[&["parse", SENTENCE][..], &model].concat()));
    assert_eq!(
        text,
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(small, Filter(blue, Scene()))))\n\
         Action(MoveRight, Unique(Filter(blue, Scene())), Unique(Filter(red, Scene())))\n"
    );
    let text = done(&bench.run(&[&["parse", SENTENCE, "--json"][..], &model].concat()));
    let program: Value = serde_json::from_str(&text).expect("JSON");
    let expected = json!({"steps": [
        {"action": "MoveOn", "object": ["red"], "reference": ["small", "blue"]},
        {"action": "MoveRight", "object": ["blue"], "reference": ["red"]},
    ], "corrections": []});
    assert_eq!(program, expected);
}

#[test]
fn models_have_the_precision_that_is_asked_for() {
    let bench = Bench::new();
    let of = |arguments: &[&str], precision: &str| {
        done(&bench.run(&[arguments, &["--precision", precision]].concat()))
    };
    for model in [&[][..], &["--model", "model.safetensors"]] {
        let parse = [&["parse", SENTENCE][..], model].concat();
        assert_eq!(of(&parse, "int8"), of(&parse, "f32"));
    }
    for model in [&["info"][..], &["info", "model.safetensors"]] {
        let told = of(model, "int8");
        assert!(told.contains("\nweights              int8\n"), "{told}");
    }
    let wrong = bench.run(&["parse", SENTENCE, "--precision", "int4"]);
    assert_eq!(wrong.status.code(), Some(2));
    let said = String::from_utf8_lossy(&wrong.stderr);
    assert!(said.contains("'int4' for '--precision"), "{said}");
    assert!(said.contains("expected f32 or int8"), "{said}");
}

#[test]
fn tells_what_misspelt_words_were_read_as() {
    let bench = Bench::new();
    let sentence = "plase put the yelow block on the read one";
    let text = done(&bench.run(&["parse", sentence]));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines,
        [
            "Action(MoveOn, Unique(Filter(yellow, Scene())), Unique(Filter(red, Scene())))",
            "\"plase\" was read as \"please\"",
            "\"yelow\" was read as \"yellow\"",
            "\"read\" was read as \"red\"",
        ]
    );
    let text = done(&bench.run(&["parse", sentence, "--json"]));
    let parsed: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(parsed["steps"][0]["object"], json!(["yellow"]));
    let yelow = json!({"text": "yelow", "start": 14, "end": 19});
    let expected = json!({"words": yelow, "read_as": "yellow"});
    assert_eq!(parsed["corrections"][1], expected);
}

#[test]
fn plans_from_an_image() {
    let bench = Bench::new();
    let text = done(&bench.plan("put the red block on the blue block", &["--json"]));
    let plan: Value = serde_json::from_str(&text).expect("JSON");
    let step = &plan["steps"][0];
    assert_eq!(step["action"], "MoveOn");
    assert_eq!(step["object"], json!(["red"]));
    assert_eq!(step["reference"], json!(["blue"]));
    assert_eq!(
        (&step["object_id"], &step["reference_id"]),
        (&json!(1), &json!(3))
    );
    assert!(
        step["confidence"]
            .as_f64()
            .is_some_and(|sure| sure > 0.9 && sure <= 1.0)
    );
    assert_eq!(plan["confidence"], step["confidence"]);
    // The reference's centre (496, 372) px deprojected at 0.625 m: (0.22, 0.165) m from the
    // optical axis.
    let position: Vec<f64> =
        serde_json::from_value(step["sub_goal"]["position"].clone()).expect("numbers");
    for (got, expected) in position.iter().zip([0.5 - 0.165, -0.22, 0.02]) {
        assert!((got - expected).abs() < 1e-5, "{position:?}");
    }
    assert_eq!(step["sub_goal"]["orientation"], json!([0.0, 0.0, 0.0, 1.0]));
    assert_eq!(step["location"].as_array().map(Vec::len), Some(5));
    let explanation = step["explanation"].as_str().expect("a sentence");
    assert!(
        explanation.contains("the red object (id 1"),
        "{explanation}"
    );
    let text = done(&bench.plan("put the red block on the blue block", &[]));
    assert!(text.starts_with("Action(MoveOn, "), "{text}");
    assert!(
        text.contains("object 1 to (0.335, -0.220, 0.020) m"),
        "{text}"
    );
}

#[test]
fn plans_from_crops_as_from_the_image() {
    let bench = Bench::new();
    let from_image = done(&bench.plan(SENTENCE, &["--json"]));
    std::fs::remove_file(bench.path("initial.png")).expect("an image");
    let from_crops = done(&bench.plan(SENTENCE, &["--json", "--crops", "crops"]));
    assert_eq!(from_crops, from_image);
}

/// Runs `plan` with and without `--json`; the refusal as JSON.
#[track_caller]
fn refusal(bench: &Bench, sentence: &str, kind: &str, parts: &[&str]) -> Value {
    assert_eq!(refused(&bench.plan(sentence, &[]), parts), Value::Null);
    let json = refused(&bench.plan(sentence, &["--json"]), parts);
    assert_eq!(json["refused"]["kind"], kind, "{json}");
    let message = json["refused"]["message"].as_str().expect("a message");
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    json["refused"].clone()
}

#[test]
fn refuses_sentences() {
    let bench = Bench::new();
    refusal(&bench, " ", "no_words", &["no words"]);
    let details = refusal(
        &bench,
        "put the sofa on the red block",
        "unknown_word",
        &["\"sofa\""],
    );
    assert_eq!(
        details["words"],
        json!({"text": "sofa", "start": 8, "end": 12})
    );
    assert_eq!(details["suggestion"], Value::Null);
    let details = refusal(
        &bench,
        "put the greens block on the red block",
        "unknown_word",
        &["\"greens\"", "did you mean \"green\"?"],
    );
    assert_eq!(details["suggestion"], "green");
    let details = refusal(
        &bench,
        &"put ".repeat(2000),
        "sentence_too_long",
        &["bytes"],
    );
    assert_eq!(
        (&details["limit"], &details["unit"]),
        (&json!(4096), &json!("bytes"))
    );
    let details = refusal(&bench, &"put ".repeat(200), "sentence_too_long", &["128"]);
    assert_eq!(details["unit"], "tokens");
    let words = "red red red small red";
    let details = refusal(&bench, words, "too_many_concepts", &[words, "4"]);
    assert_eq!(details["limit"], 4);
    let steps = "put the red block on the blue block then ".repeat(9);
    refusal(&bench, &steps, "too_many_steps", &["8 steps"]);
    let details = refusal(
        &bench,
        "put the small red blue block on the green block",
        "conflicting_values",
        &["small red blue", "both red and blue"],
    );
    assert_eq!(
        (&details["first"], &details["second"]),
        (&json!("red"), &json!("blue"))
    );
    let many = "put the red block on the green block left of the blue block";
    let details = refusal(
        &bench,
        many,
        "too_many_references",
        &["more than 2 objects"],
    );
    assert_eq!(details["limit"], 2);
    let details = refusal(
        &bench,
        "put the red block",
        "incomplete_step",
        &["describes 1"],
    );
    assert_eq!(
        (&details["step"], &details["references"]),
        (&json!(0), &json!(1))
    );
    let text = "\"put the red block\" names one object only: what is missing?";
    assert_eq!(details["question"], json!({"text": text, "options": []}));
}

#[test]
fn refuses_what_the_scene_does_not_allow() {
    let bench = Bench::new();
    let sentence = "put the yellow block on the red block";
    let details = refusal(&bench, sentence, "no_such_object", &["yellow", "0.75"]);
    assert_eq!(details["argument"], "object");
    assert_eq!(details["description"], json!(["yellow"]));
    assert!(details["best"]["score"].as_f64() < Some(0.75));
    let question = &details["question"];
    let text = question["text"].as_str().expect("a question");
    assert!(
        text.starts_with("do you mean the ") && text.ends_with(" one?"),
        "{text}"
    );
    // Each option is a sentence that can be planned.
    let options = question["options"].as_array().expect("options");
    assert!(!options.is_empty());
    for option in options {
        done(&bench.plan(option["sentence"].as_str().expect("a sentence"), &[]));
    }
    let sentence = "put the red block on the green block";
    let details = refusal(&bench, sentence, "ambiguous", &["green", "2 objects"]);
    assert_eq!(
        (&details["argument"], &details["count"]),
        (&json!("reference"), &json!(2))
    );
    let ids: Vec<&Value> = details["candidates"]
        .as_array()
        .expect("candidates")
        .iter()
        .map(|candidate| &candidate["object_id"])
        .collect();
    assert!(
        ids.len() == 2 && ids.contains(&&json!(2)) && ids.contains(&&json!(5)),
        "{ids:?}"
    );
    let sentence = "put the red block on the small red block";
    let details = refusal(&bench, sentence, "same_object", &["1"]);
    assert_eq!(details["object_id"], 1);
}

#[test]
fn refuses_what_it_is_not_sure_of() {
    let mut model = ModelFile::designed();
    model.set("language.action_decoder.bias", &[0], 0.0);
    let bench = Bench::with(&model);
    let sentence = "put the red block on the blue block";
    let details = refusal(
        &bench,
        sentence,
        "unsure",
        &["what is to be done", "0.20", "0.50"],
    );
    assert_eq!(
        (&details["decision"], &details["threshold"]),
        (&json!("action"), &json!(0.5))
    );
}

#[test]
fn refuses_one_description_for_both() {
    let mut model = ModelFile::designed();
    model.set("language.reference_decoder.bias", &[0], -100.0);
    let bench = Bench::with(&model);
    let sentence = "put the red block on the blue block";
    let details = refusal(&bench, sentence, "same_reference", &["\"red\""]);
    assert_eq!(details["words"]["text"], "red");
}

#[test]
fn refuses_sub_goals_out_of_reach() {
    let mut model = ModelFile::designed();
    let (min, max) = ([0.0, -0.125, 0.0], [1.0, 0.125, 2.0]);
    model.set_json("work_space", json!({"min": min, "max": max}));
    let bench = Bench::with(&model);
    let sentence = "put the red block on the blue block";
    let details = refusal(
        &bench,
        sentence,
        "outside_work_space",
        &["object 1", "-0.220"],
    );
    assert_eq!(details["bounds"], json!({"min": min, "max": max}));
}

/// Refused because what is seen disagrees with the calibration; `change` is made to the scene.
#[track_caller]
fn miscalibrated(change: impl FnOnce(&mut Value), parts: &[&str]) -> Value {
    let bench = Bench::new();
    let mut scene = scene();
    change(&mut scene);
    bench.write("scene.json", scene.to_string());
    let sentence = "put the red block on the blue block";
    refusal(&bench, sentence, "calibration", parts)
}

fn with_depths(scene: &mut Value, depth: f32) {
    for object in scene["objects"].as_array_mut().expect("objects") {
        object["depth"] = json!(depth);
    }
}

#[test]
fn refuses_scenes_that_disagree_with_the_calibration() {
    let [x, y, z] = POSITION;
    let details = miscalibrated(
        |scene| scene["camera"]["position"] = json!([x, y, z + 0.05]),
        &[
            "disagrees",
            "seen at a height of 0.070 m",
            "at 0.020 m",
            "too high",
        ],
    );
    assert_eq!(details["quantity"], "height");
    assert_eq!(details["cause"], Value::Null);
    assert_eq!(
        (&details["disagreeing"], &details["whole"]),
        (&json!(4), &json!(4))
    );
    let details = miscalibrated(
        |scene| with_depths(scene, 0.95 * DEPTH_M),
        &["disagrees", "calibrate the camera again"],
    );
    assert!(details["object_id"].is_u64(), "{details}");
    // Blocks of 4 cm whose boxes are too narrow.
    assert_eq!(
        (&details["quantity"], &details["expected_m"]),
        (&json!("width"), &json!(0.04))
    );
    assert!(details["measured_m"].as_f64() < Some(0.039), "{details}");
    let details = miscalibrated(
        |scene| with_depths(scene, 1.05 * DEPTH_M),
        &["disagrees", "too low, or depths too long"],
    );
    assert_eq!(details["expected_m"], json!(0.02));
}

#[test]
fn tells_other_units_and_conventions_of_a_scene() {
    let details = miscalibrated(
        |scene| with_depths(scene, 1000.0 * DEPTH_M),
        &["depths look like millimetres; NSRM wants metres", "divide"],
    );
    assert_eq!(details["cause"], "depths_in_millimetres");
    let [x, y, z, w] = ORIENTATION;
    let details = miscalibrated(
        |scene| scene["camera"]["orientation"] = json!([w, x, y, z]),
        &["orientation looks like w, x, y, z; NSRM wants x, y, z, w"],
    );
    assert_eq!(details["cause"], "orientation_wxyz");
}

#[test]
fn refuses_results_that_are_not_finite() {
    let mut model = ModelFile::designed();
    model.fill("action.simulator.output.weight", 3e38);
    model.fill("action.simulator.hidden.bias", 3e38);
    let bench = Bench::with(&model);
    let sentence = "put the red block on the blue block";
    let details = refusal(&bench, sentence, "not_finite", &["location"]);
    assert_eq!(details["quantity"], "location");
}

/// Writes a spoilt scene; the message must hold `parts`.
#[track_caller]
fn bad_scene(spoil: impl FnOnce(&mut Value), parts: &[&str]) {
    let mut spoilt = scene();
    spoil(&mut spoilt);
    bad_text(&spoilt.to_string(), parts);
}

#[track_caller]
fn bad_text(text: &str, parts: &[&str]) {
    let bench = Bench::new();
    bench.write("scene.json", text);
    let sentence = "put the red block on the blue block";
    let json = refused(&bench.plan(sentence, &["--json"]), parts);
    let message = json["error"]["message"].as_str().expect("a message");
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
}

#[test]
fn scene_files_that_are_none() {
    bad_text("", &["scene.json", "JSON"]);
    bad_text("{\"schema\": 1,", &["scene.json", "line 1"]);
    bad_text("{}", &["scene.json", "missing field `schema`"]);
    bad_text("7", &["scene.json", "an object with schema"]);
    bad_text(
        &scene().to_string().replace("0.5", "NaN"),
        &["scene.json", "line 1"],
    );
    bad_text(
        &scene().to_string().replace("0.5", "1e999"),
        &["scene.json", "out of range"],
    );
    bad_scene(
        |scene| scene["schema"] = json!(2),
        &["schema", "expected 1", "2"],
    );
    bad_scene(
        |scene| scene["objects"] = json!(3),
        &["expected a sequence"],
    );
    bad_scene(
        |scene| scene["objects"][0]["box"] = json!([0.1, 0.2, 0.3]),
        &["length 3"],
    );
    bad_scene(|scene| scene["objects"][0]["id"] = json!(-1), &["-1"]);
}

#[test]
fn scenes_that_are_none() {
    let object = |change: fn(&mut Value), parts: &[&str]| {
        bad_scene(|scene| change(&mut scene["objects"][1]), parts);
    };
    object(
        |object| object["id"] = json!(1),
        &["object 1", "already taken"],
    );
    object(|object| object["id"] = json!(0), &["must not be 0"]);
    object(
        |object| object["depth"] = json!(0.0),
        &["object 2", "depth"],
    );
    object(
        |object| object["depth"] = json!(1e39),
        &["object 2", "finite"],
    );
    object(
        |object| object["box"] = json!([0.5, 0.1, 0.4, 0.2]),
        &["object 2", "x1 < x2"],
    );
    object(
        |object| object["box"] = json!([0.5, 0.1, 1.5, 0.2]),
        &["object 2", "inside"],
    );
    let many = |scene: &mut Value| {
        let object = scene["objects"][0].clone();
        scene["objects"] = (0..17).map(|_| object.clone()).collect();
    };
    bad_scene(many, &["17 objects", "16"]);
    bad_scene(
        |scene| scene["camera"]["fx"] = json!(0.0),
        &["camera", "fx"],
    );
    bad_scene(
        |scene| scene["camera"]["orientation"] = json!([0, 0, 0, 0]),
        &["orientation"],
    );
    bad_scene(
        |scene| scene["camera"]["width"] = json!(641),
        &["640×480", "641×480"],
    );
}

#[test]
fn images_that_are_none() {
    bad_scene(
        |scene| scene["image"] = json!("none.png"),
        &["none.png", "cannot read"],
    );
    bad_scene(
        |scene| scene["image"] = json!("scene.json"),
        &["scene.json", "PNG"],
    );
    bad_scene(|scene| scene["image"] = Value::Null, &["--crops"]);
    let bench = Bench::new();
    let whole = std::fs::read(bench.path("initial.png")).expect("an image");
    bench.write("initial.png", &whole[..whole.len() / 2]);
    let sentence = "put the red block on the blue block";
    refused(&bench.plan(sentence, &[]), &["initial.png", "PNG"]);
    std::fs::remove_file(bench.path("crops/3.png")).expect("a crop");
    refused(
        &bench.plan(sentence, &["--crops", "crops"]),
        &["3.png", "cannot read"],
    );
    refused(
        &bench.plan(sentence, &["--crops", "none"]),
        &["none", "cannot read"],
    );
}

#[test]
fn models_that_are_none() {
    let bench = Bench::new();
    bench.write("bad.safetensors", b"no model");
    refused(
        &bench.run(&["check", "bad.safetensors"]),
        &["bad.safetensors", "safetensors"],
    );
    refused(
        &bench.run(&["info", "none.safetensors"]),
        &["none.safetensors", "cannot read"],
    );
    let parse = ["parse", "--json", "--model", "bad.safetensors", "put"];
    let json = refused(&bench.run(&parse), &["bad.safetensors"]);
    assert!(json["error"]["message"].is_string(), "{json}");
    refused(
        &bench.run(&["plan", "--scene", "none.json", "put"]),
        &["none.json", "cannot read"],
    );
}

#[test]
fn checks_models() {
    let bench = Bench::new();
    let text = done(&bench.run(&["check", "model.safetensors"]));
    assert!(
        text.contains("model.safetensors: valid; domain tabletop"),
        "{text}"
    );
    let path = pretrained();
    let text = done(&bench.run(&["check", "--json", path.to_str().expect("a path")]));
    let json: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["identity"].as_str().map(str::len), Some(64));
}

#[test]
fn informs() {
    let bench = Bench::new();
    let text = done(&bench.run(&["info"]));
    for part in [
        "tabletop",
        "magenta",
        "MoveLeft",
        "scratch_bytes",
        "total",
        "match_score",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let built_in = done(&bench.run(&["info", "--json"]));
    let loaded = done(&bench.run(&["info", "--json", pretrained().to_str().expect("a path")]));
    assert_eq!(built_in, loaded);
    let info: Value = serde_json::from_str(&built_in).expect("JSON");
    assert_eq!(info["domain"], "tabletop");
    assert_eq!(info["dimensions"]["encoder_hidden"], 48);
    assert_eq!(info["capacities"]["objects"], 16);
    assert!(info["flash"]["total"].as_u64() > Some(300_000));
    assert!(info["training"].is_object());
}

#[test]
fn wrong_arguments_exit_with_2() {
    let bench = Bench::new();
    for arguments in [
        &["frobnicate"][..],
        &["parse"],
        &["plan", "a sentence"],
        &["check"],
    ] {
        let output = bench.run(arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(!output.stderr.is_empty());
    }
}
