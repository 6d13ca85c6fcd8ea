//! The C interface does what Rust does, to the bit, and what it is not meant for has error codes.
//!
//! Tests that build the library are ignored by a plain `cargo test`; `cargo verify` runs them.

mod programs;
mod requests;

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_core::{Model, RawScene, Scene};
use nsrm_tabletop::{TABLETOP, TABLETOP_INT8};
use nsrm_tests::golden::{Golden, camera as golden_camera, fixed};
use nsrm_tests::picture::{Picture, SIZE, camera, squares};
use programs::{PACKAGE, compile, compile_with, library, library_without_std, run, said};
use requests::Requests;

#[test]
#[ignore = "builds a library; run by cargo verify"]
fn misuse_has_error_codes_and_touches_no_other_memory() {
    let sanitizers = ["-fsanitize=address,undefined", "-fno-sanitize-recover"];
    let ran = run(&compile("tests/misuse.c", &sanitizers), &[]);
    assert!(ran.status.success(), "{}", said(&ran));
    // Sanitizers see what C does; valgrind sees the library, too.
    let program = compile("tests/misuse.c", &[]);
    let program = program.to_str().expect("a path in UTF-8");
    let watched = ["--quiet", "--error-exitcode=9", program, "alone"];
    let ran = run(Path::new("valgrind"), &watched);
    assert!(ran.status.success(), "{}", said(&ran));
}

#[test]
#[ignore = "builds a library; run by cargo verify"]
fn the_examples_plan_and_refuse() {
    let program = compile("examples/plan.c", &[]);
    let ran = run(&program, &["put the red block on the small green block"]);
    let told = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{}", said(&ran));
    assert!(told.starts_with("Action(MoveOn, Unique("), "{told}");
    assert!(told.contains("object 1 to x "), "{told}");
    let ran = run(&program, &["put the crimson block on the blue block"]);
    assert_eq!(ran.status.code(), Some(2));
    assert!(said(&ran).starts_with("refused: \"crimson\" is not a word"));

    let ran = run(&compile("examples/control_loop.cpp", &[]), &["500"]);
    assert!(ran.status.success(), "{}", said(&ran));
    let told = String::from_utf8_lossy(&ran.stdout);
    assert!(told.starts_with("500 cycles of 1 ms: "), "{told}");
}

#[test]
#[ignore = "builds a library; run by cargo verify"]
fn golden_scenes_and_sentences_give_the_same_bits_as_in_rust() {
    let golden = Golden::read();
    let count = |part: &str| golden.cases[part].as_array().expect("a list").len();
    let scenes: Vec<_> = (0..count("scenes")).map(|n| scene(&golden, n)).collect();
    let mut sentences: Vec<_> = golden.cases["sentences"]
        .as_array()
        .expect("sentences")
        .iter()
        .map(|case| case["sentence"].as_str().expect("a sentence").to_owned())
        .collect();
    let lists = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../sim-harness/tests/language/sentences.tsv"
    );
    let listed = std::fs::read_to_string(lists).expect(lists);
    let others = listed.lines().filter(|line| !line.starts_with('#'));
    sentences.extend(others.filter_map(|line| Some(line.split('\t').nth(1)?.to_owned())));
    sentences.push("put the bleu block on the gren block".into());
    sentences.push("put the red block next to the blue block".into());
    sentences.push("put the red block 2 cm to the left of the blue one".into());
    sentences.push("put the second block from the left on the third red one from the top".into());
    sentences.push("ü".repeat(2100));

    for model in [&TABLETOP, &TABLETOP_INT8] {
        same_bits(&golden, &scenes, &sentences, Requests::of(model));
    }
}

fn same_bits(golden: &Golden, scenes: &[Scene], sentences: &[String], mut requests: Requests) {
    for sentence in sentences {
        requests.parse(sentence);
    }
    for plan in golden.cases["plans"].as_array().expect("plans") {
        let number = plan["scene"].as_u64().expect("a scene") as usize;
        let sentence = plan["sentence"].as_str().expect("a sentence");
        requests.plan(scenes[number].raw(), sentence);
    }
    for raw in scenes.iter().map(Scene::raw) {
        for sentence in sentences {
            requests.plan(raw, sentence);
        }
    }
    let twice = "put the red block on the blue block, then put the green block on the red block";
    for raw in scenes.iter().map(Scene::raw) {
        requests.parse(twice);
        requests.ground(raw, twice, 1);
    }
    let mut broken = *scenes[0].raw();
    broken.objects[0].location[4] = -1.0;
    requests.plan(&broken, &sentences[0]);
    assert!(
        requests.counts.iter().all(|count| *count > 20),
        "{:?}",
        requests.counts
    );
    requests.check();
}

#[test]
#[ignore = "builds a library; run by cargo verify"]
fn scenes_from_images_give_the_same_bits_as_in_rust() {
    for model in [&TABLETOP, &TABLETOP_INT8] {
        same_scenes(model, Requests::of(model));
    }
}

fn same_scenes(model: &Model<'_>, mut requests: Requests) {
    let picture = squares();
    requests.observe(camera(), &picture);
    let mut outside = picture.clone();
    outside.detections[2].location[2] = 1.5;
    requests.observe(camera(), &outside);
    let mut smaller = camera();
    smaller.width /= 2;
    requests.observe(smaller, &picture);
    requests.observe(
        camera(),
        &Picture {
            detections: Vec::new(),
            ..picture.clone()
        },
    );

    let image = RgbImage::new(&picture.pixels, SIZE[0], SIZE[1], 3 * SIZE[0] as usize).unwrap();
    let task = ObservationTask::new(
        model,
        image,
        camera(),
        &picture.detections,
        Stamp::default(),
    );
    let scene = task.unwrap().finish().unwrap();
    requests.plan(scene.raw(), "put the red block on the small green block");
    assert_eq!(requests.counts, [1, 0]);
    requests.check();
}

/// A scene of the golden vectors.
fn scene(golden: &Golden, number: usize) -> Scene {
    let case = &golden.cases["scenes"][number];
    let mut raw = RawScene::empty(&TABLETOP, golden_camera(&case["camera"]));
    let part = |part: &str| golden.array(&format!("scene.{number}.{part}"));
    let (locations, embeddings) = (part("locations"), part("embeddings"));
    let ids = case["ids"].as_array().expect("ids");
    for (id, (location, embedding)) in ids.iter().zip(locations.rows().zip(embeddings.rows())) {
        raw.push(nsrm_core::scene::ObservedObject {
            id: id.as_u64().expect("an id") as u32,
            location: fixed(location),
            embedding: fixed(embedding),
        })
        .expect("room for an object");
    }
    Scene::new(raw, &TABLETOP).expect("a scene in order")
}

/// In what is linked, and only that: the messages for people may panic as far as the linker can see.
#[test]
#[ignore = "builds a library; run by cargo verify"]
fn no_panic_is_linked_into_a_control_loop() {
    let library = library_without_std();
    let flags = ["-ffunction-sections", "-Wl,--gc-sections"];
    let linked = |source| symbols(&compile_with(&library, source, &flags));
    let panics = |symbols: &str| symbols.contains("panic");
    let control_loop = linked("tests/control_loop_only.c");
    assert!(control_loop.contains("nsrm_poll"));
    assert!(!panics(&control_loop), "{control_loop}");
    // Otherwise nothing would be seen in any program.
    assert!(panics(&linked("examples/plan.c")));
}

/// Without a standard library it needs these functions of a compiler's, and no others.
#[test]
#[ignore = "builds a library; run by cargo verify"]
fn the_library_needs_no_operating_system() {
    let archive = library_without_std().join("libnsrm.a");
    let all = symbols(&archive);
    let named = |kind: &str| -> BTreeSet<&str> {
        let lines = all.lines().filter_map(|line| line.split_once(kind));
        lines.map(|(_, name)| name).collect()
    };
    let defined: BTreeSet<_> = [" T ", " t ", " W ", " V ", " R ", " D "]
        .into_iter()
        .flat_map(named)
        .collect();
    let needed: Vec<_> = named(" U ").difference(&defined).copied().collect();
    let allowed = [
        "bcmp",
        "memcmp",
        "memcpy",
        "memmove",
        "memset",
        // Division of 128 bits, of the compiler's library.
        "__udivti3",
    ];
    assert!(!defined.is_empty());
    assert!(
        needed.iter().all(|name| allowed.contains(name)),
        "{needed:?}"
    );
}

fn symbols(file: &Path) -> String {
    let listed = Command::new("nm").arg(file).output().expect("nm runs");
    assert!(listed.status.success(), "{}", said(&listed));
    String::from_utf8_lossy(&listed.stdout).into_owned()
}

#[test]
#[ignore = "builds a library; run by cargo verify"]
fn installed_by_cmake_it_is_found_by_cmake_and_pkg_config() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let target = library();
    let target = target.parent().expect("a folder").display();
    cmake(&[
        "-S",
        PACKAGE,
        "-B",
        &path("build"),
        &format!("-DNSRM_TARGET_DIR={target}"),
        "-DNSRM_PRECISIONS=f32;int8",
        &format!("-DCMAKE_INSTALL_PREFIX={}", path("installed")),
        "-DCMAKE_INSTALL_LIBDIR=lib",
    ]);
    cmake(&["--build", &path("build")]);
    cmake(&["--install", &path("build")]);

    let consumer = format!("{PACKAGE}/tests/consumer");
    let installed = format!("-DCMAKE_PREFIX_PATH={}", path("installed"));
    cmake(&["-S", &consumer, "-B", &path("consumer"), &installed]);
    cmake(&["--build", &path("consumer")]);
    let found = Command::new("pkg-config")
        .args(["--cflags", "--libs", "nsrm"])
        .env("PKG_CONFIG_PATH", path("installed/lib/pkgconfig"))
        .output()
        .expect("pkg-config runs");
    assert!(found.status.success(), "{}", said(&found));
    let flags = String::from_utf8_lossy(&found.stdout);
    let compiled = Command::new("cc")
        .arg(format!("{PACKAGE}/examples/plan.c"))
        .args(flags.split_whitespace())
        .arg(format!("-Wl,-rpath,{}", path("installed/lib")))
        .args(["-o", &path("by_pkg_config")])
        .output()
        .expect("a C compiler");
    assert!(compiled.status.success(), "{}", said(&compiled));

    let programs = [
        "consumer/plan_static",
        "consumer/plan_shared",
        "by_pkg_config",
    ];
    for program in programs.map(path) {
        let ran = run(Path::new(&program), &[]);
        assert!(ran.status.success(), "{program}: {}", said(&ran));
        assert!(String::from_utf8_lossy(&ran.stdout).starts_with("Action("));
    }
}

fn cmake(arguments: &[&str]) {
    let ran: Output = Command::new("cmake")
        .args(arguments)
        .output()
        .expect("cmake runs");
    assert!(ran.status.success(), "{arguments:?}: {}", said(&ran));
}
