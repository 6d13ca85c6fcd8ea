//! The proofs by the linker, and what the proved program computes.
//!
//! These tests build `tests/no-std-plan`, which takes a minute the first time; a plain
//! `cargo test` ignores them, `cargo verify` runs them.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use nsrm_core::planner::Plan;
use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_core::{Model, Planner, Refusal};
use nsrm_tabletop::{TABLETOP, TABLETOP_INT8};
use nsrm_tests::picture::{Picture, SIZE, camera, squares};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/no-std-plan");

/// Builds the program with this feature, or with none.
fn build(feature: Option<&str>) -> (Output, PathBuf) {
    // One folder for all builds, so that the dependencies are built once.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-std-plan");
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["build", "--release", "--locked", "--manifest-path"])
        .arg(format!("{FOLDER}/Cargo.toml"))
        .arg("--target-dir")
        .arg(&target)
        // Flags of other builds must not change the proof.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    if let Some(feature) = feature {
        cargo.args(["--features", feature]);
    }
    let output = cargo.output().expect("cargo runs");
    (output, target.join("release/no-std-plan"))
}

fn messages(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
#[ignore = "builds a program; run by cargo verify"]
fn without_allocator_and_panics_it_links_and_plans() {
    for (feature, model) in [(None, &TABLETOP), (Some("int8"), &TABLETOP_INT8)] {
        links_and_plans(feature, model);
    }
}

fn links_and_plans(feature: Option<&str>, model: &Model<'_>) {
    let (output, program) = build(feature);
    assert!(output.status.success(), "{}", messages(&output));
    let picture = squares();
    let mut planned = 0;
    for sentence in [
        "put the red block on the blue block",
        "put the small green block to the right of the lego blue block",
        "move the red block to the left of the green block, then put the yellow block on the red one",
        "fly to the moon",
        "put the greens block on the red block",
        "put the bleu block on the gren block",
        "",
    ] {
        let ran = run(&program, &input(&picture, sentence));
        let (code, bytes) = match on_the_host(model, &picture, sentence) {
            Ok(plan) => {
                planned += 1;
                let confidence = plan.confidence().to_le_bytes();
                (0, [sub_goals(&plan), confidence.into()].concat())
            }
            Err(refusal) => {
                let word = refusal.suggestion(model, sentence);
                let word = word.map_or(String::new(), |word| format!(" {word}"));
                (2, format!("{}{word}", refusal.kind()).into())
            }
        };
        assert_eq!(ran.status.code(), Some(code), "{sentence:?}");
        assert_eq!(ran.stdout, bytes, "{sentence:?}");
    }
    // Otherwise no sub-goal was compared: the image then needs squares that this model recognises
    // as its objects.
    assert!(planned > 0, "the pretrained model refuses every sentence");
    // A box outside the image, and an input that ends early.
    let mut broken = picture.clone();
    broken.detections[0].location[2] = 1.5;
    assert_eq!(run(&program, &input(&broken, "")).status.code(), Some(3));
    assert_eq!(run(&program, b"short").status.code(), Some(4));
}

#[test]
#[ignore = "builds a program; run by cargo verify"]
fn it_does_not_link_with_a_path_that_panics() {
    let (output, _) = build(Some("panic"));
    let messages = messages(&output);
    assert!(!output.status.success());
    assert!(messages.contains("a_panic_path_is_left"), "{messages}");
}

#[test]
#[ignore = "builds a program; run by cargo verify"]
fn it_does_not_link_with_an_allocation() {
    let (output, _) = build(Some("allocate"));
    let messages = messages(&output);
    assert!(!output.status.success());
    assert!(
        messages.contains("no global memory allocator"),
        "{messages}"
    );
}

#[test]
fn dependencies_of_core_are_those_of_the_workspace() {
    // These have lock files of their own, but must prove and measure the same code.
    let tests = env!("CARGO_MANIFEST_DIR");
    let ours = locked(&format!("{tests}/../Cargo.lock"));
    for folder in ["no-std-plan", "firmware"] {
        let theirs = locked(&format!("{tests}/{folder}/Cargo.lock"));
        for name in ["heapless", "libm", "nalgebra", "simba", "thiserror"] {
            assert!(theirs.contains_key(name), "{folder}: no {name}");
            assert_eq!(
                theirs[name], ours[name],
                "{name}: run cargo update --precise in tests/{folder}"
            );
        }
    }
}

/// Names and versions of a lock file.
fn locked(path: &str) -> BTreeMap<String, Vec<String>> {
    let text = std::fs::read_to_string(path).expect(path);
    let value = |line: &str| line.split('"').nth(1).expect(path).to_owned();
    let mut packages = BTreeMap::<_, Vec<_>>::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("name = ") {
            let version = value(lines.next().expect(path));
            packages.entry(value(line)).or_default().push(version);
        }
    }
    packages
}

/// The program's input; see `no-std-plan/src/input.rs`.
fn input(picture: &Picture, sentence: &str) -> Vec<u8> {
    let camera = camera();
    let mut bytes = Vec::new();
    bytes.extend([camera.width, camera.height].map(u32::to_le_bytes).concat());
    let numbers = [camera.fx, camera.fy, camera.cx, camera.cy];
    for number in numbers
        .iter()
        .chain(&camera.position)
        .chain(&camera.orientation)
    {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend((picture.detections.len() as u32).to_le_bytes());
    for detection in &picture.detections {
        bytes.extend(detection.id.to_le_bytes());
        bytes.extend(detection.location.map(f32::to_le_bytes).concat());
    }
    bytes.extend((sentence.len() as u32).to_le_bytes());
    bytes.extend(sentence.as_bytes());
    bytes.extend(&picture.pixels);
    bytes
}

fn run(program: &Path, input: &[u8]) -> Output {
    let mut process = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // It may end before it has read everything.
    let _ = process.stdin.take().expect("piped").write_all(input);
    process.wait_with_output().expect("the program ends")
}

fn on_the_host(model: &Model<'_>, picture: &Picture, sentence: &str) -> Result<Plan, Refusal> {
    let image = RgbImage::new(&picture.pixels, SIZE[0], SIZE[1], 3 * SIZE[0] as usize).unwrap();
    let detections = &picture.detections;
    let task = ObservationTask::new(model, image, camera(), detections, Stamp::default()).unwrap();
    let scene = task.finish().expect("the picture is in order");
    Planner::new(model).plan(&scene, sentence)
}

fn sub_goals(plan: &Plan) -> Vec<u8> {
    let mut bytes = Vec::new();
    for goal in plan.sub_goals() {
        bytes.extend(goal.object.to_le_bytes());
        let pose = &goal.pose;
        for number in pose
            .translation
            .vector
            .iter()
            .chain(pose.rotation.coords.iter())
        {
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes
}
