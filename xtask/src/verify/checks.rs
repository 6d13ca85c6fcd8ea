//! The checks, in the order in which they run: quick ones first.

use anyhow::Result;

use super::context::Context;
use super::count::Runner;
use super::fuzz;
use super::package;
use super::step::Step;
use super::tools::Tool;

/// The packages outside the workspace, which have their own profiles;
const APART: [&str; 2] = ["tests/compare/Cargo.toml", "tests/no-std-plan/Cargo.toml"];
/// the fuzz targets, whose build denies warnings: clippy would check all that they are made of once
/// more, and the firmware, which is for another target.
const BUILT_ELSEWHERE: [&str; 2] = ["tests/fuzz/Cargo.toml", "tests/firmware/Cargo.toml"];

/// The settings of the Python linters, of pyright and of pytest.
const PYTHON_SETTINGS: &str = "sim-harness/pyproject.toml";

/// The Python packages, and their tests.
const PYTHON_PACKAGES: [&str; 2] = ["sim-harness", "std-shim/python"];

/// XLA's older emitters: they compile a stage of training in a third of the time, and what they
/// compile runs as fast. In one piece: several, for threads that have other work here, cost a fifth
/// more.
const QUICK_EMITTERS: &str =
    "--xla_cpu_use_fusion_emitters=false --xla_cpu_parallel_codegen_split_count=1";

/// One check.
pub(super) struct Check {
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    /// Approximate time on two cores from a clean clone.
    pub(super) about: &'static str,
    /// The commands to run, including those that prepare.
    pub(super) steps: Steps,
    /// The steps for `--quick`, if it is part of that.
    pub(super) quick: Option<Steps>,
    /// The sequence that it runs in.
    pub(super) lane: Lane,
}

/// A sequence of checks, which runs in parallel with the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lane {
    /// Checks that compute on all processors.
    Computing,
    /// Checks that leave a processor free, waiting for processes most of the time or computing on
    /// one.
    Waiting,
    /// Checks that compute for so long on one processor that the whole run waits for them, unless
    /// they have their share from the start.
    Long,
}

type Steps = fn(&Context) -> Result<Vec<Step>>;

impl Check {
    pub(super) const fn new(
        name: &'static str,
        title: &'static str,
        about: &'static str,
        steps: Steps,
    ) -> Self {
        Self {
            name,
            title,
            about,
            steps,
            quick: None,
            lane: Lane::Computing,
        }
    }

    /// The steps for `--quick`.
    pub(super) const fn quick(mut self, steps: Steps) -> Self {
        self.quick = Some(steps);
        self
    }

    pub(super) const fn waiting(mut self) -> Self {
        self.lane = Lane::Waiting;
        self
    }

    pub(super) const fn long(mut self) -> Self {
        self.lane = Lane::Long;
        self
    }
}

/// All checks, in the order in which they start, each in its lane. Those that leave a processor free
/// come early, so that the others run in parallel with them; a check that needs the environment
/// waits until it exists.
pub(super) const CHECKS: &[Check] = &[
    Check::new(
        "environment",
        "the Python environment installs from hashed requirements, with the module",
        "3 min, in parallel",
        environment,
    )
    .quick(environment)
    .waiting(),
    Check::new(
        "tables",
        "a reduced run of the paper's tables, from scratch; a second domain end to end",
        "15 min, in parallel",
        tables,
    )
    .long(),
    Check::new("format", "Rust is formatted by rustfmt", "1 s", format).quick(format),
    Check::new(
        "lints",
        "clippy gives no warnings, on all targets",
        "2 min",
        lints,
    )
    .quick(lints),
    Check::new(
        "rust-tests",
        "tests and doctests: no allocation, every refusal, robustness to any input",
        "3 min",
        rust_tests,
    )
    .quick(quick_rust_tests),
    Check::new(
        "second-user",
        "a robot's processes refuse another user's memory and too little memory (needs root)",
        "30 s",
        second_user,
    ),
    Check::new(
        "generated",
        "the static arrays of nsrm-tabletop match what the generator writes from the model file",
        "20 s",
        generated,
    )
    .quick(generated),
    Check::new(
        "golden",
        "the static and the loaded model match the golden vectors of the trainer",
        "30 s",
        golden,
    )
    .quick(golden),
    Check::new(
        "proofs",
        "a program that neither allocates nor panics links, and no other",
        "30 s",
        proofs,
    ),
    Check::new(
        "c-interface",
        "C does what Rust does, to the bit; misuse has error codes; cmake installs what programs find",
        "1 min",
        c_interface,
    ),
    Check::new(
        "instructions",
        "plans and crops take as many instructions as written, within 2 %",
        "30 s",
        instructions,
    ),
    Check::new("docs", "rustdoc has no warning", "15 s", docs),
    Check::new(
        "package",
        "each published crate can be packaged and builds from its package",
        "1 min",
        package::steps,
    ),
    Check::new(
        "trials",
        "50 random kills lose nothing and repeat nothing; short runs of soak, latency and the \
         arm's trials",
        "4 min, in parallel",
        trials,
    )
    .waiting(),
    Check::new(
        "robot",
        "cargo robot executes sentences through all processes",
        "4 min, in parallel",
        robot,
    )
    .waiting(),
    Check::new(
        "firmware",
        "on emulated Cortex-M4F and M7 the whole chain gives this machine's bits, within its budget",
        "3 min, in parallel",
        firmware,
    )
    .waiting(),
    Check::new(
        "hosts",
        "a robot on two hosts: a sentence from each, a slow link, a lost link (needs root)",
        "3 min, in parallel",
        hosts,
    )
    .waiting(),
    Check::new(
        "python-lints",
        "ruff and pyright report nothing",
        "45 s",
        python_lints,
    )
    .quick(python_lints),
    Check::new(
        "python-tests",
        "tests of the harness and the Python module, including the golden vectors",
        "8 min",
        python_tests,
    )
    .quick(quick_python_tests),
    Check::new("demo", "cargo demo plans, refuses and draws", "1 min", demo).quick(quick_demo),
    Check::new(
        "fuzz",
        "no bytes break the readers of untrusted input: committed inputs, then 10 s of new ones each",
        "3 min",
        fuzz::steps,
    ),
];

/// The tunnel between hosts.
const TUNNEL: Tool = Tool {
    package: "iceoryx2-integrations-zenoh-link-tunnel-cli",
    program: "iox2-link-tunnel-zenoh",
    version: "0.10.0",
};

fn format(_: &Context) -> Result<Vec<Step>> {
    let mut steps = vec![Step::cargo(&["fmt", "--all", "--check"])];
    for manifest in APART.into_iter().chain(BUILT_ELSEWHERE) {
        steps.push(Step::cargo(&[
            "fmt",
            "--manifest-path",
            manifest,
            "--check",
        ]));
    }
    Ok(steps)
}

fn lints(context: &Context) -> Result<Vec<Step>> {
    let strict = ["--", "--deny", "warnings"];
    let mut workspace = vec!["clippy", "--workspace", "--all-targets", "--locked"];
    workspace.extend(strict);
    let mut steps = vec![Step::cargo(&workspace)];
    // As the Python module has it: without iceoryx2.
    let mut alone = vec![
        "clippy",
        "--locked",
        "--package=nsrm-ipc",
        "--no-default-features",
    ];
    alone.extend(strict);
    steps.push(Step::cargo(&alone));
    for manifest in APART {
        let mut step = vec!["clippy", "--locked", "--manifest-path", manifest];
        step.extend(strict);
        let step = Step::cargo(&step).building_in(context.project().target());
        steps.push(step.with_workspace_profile());
    }
    Ok(steps)
}

/// What other checks run: golden vectors, second-user, proofs.
const ELSEWHERE: [&str; 5] = [
    "--skip=golden_",
    "--skip=a_second_user_is_refused",
    "--skip=too_little_shared_memory_is_refused",
    "--skip=without_allocator_and_panics_it_links",
    "--skip=it_does_not_link_with",
];

fn rust_tests(context: &Context) -> Result<Vec<Step>> {
    let compare = [
        "test",
        "--locked",
        "--manifest-path=tests/compare/Cargo.toml",
    ];
    let compare = Step::cargo(&compare).building_in(context.project().target());
    Ok(vec![
        Step::rust_tests(&["--"]).arguments(&ELSEWHERE),
        compare.with_workspace_profile().counting(Runner::Cargo),
    ])
}

/// Neither doc tests, of which each is linked alone, nor what crosses crates.
fn quick_rust_tests(_: &Context) -> Result<Vec<Step>> {
    let chosen = ["--lib", "--bins", "--tests", "--exclude=nsrm-tests"];
    let step = Step::rust_tests(&chosen);
    Ok(vec![step.argument("--").arguments(&ELSEWHERE)])
}

/// Ignored in a plain `cargo test`, since only root can start processes as another user and
/// mount memory.
fn second_user(_: &Context) -> Result<Vec<Step>> {
    let chosen = ["--test=second_user", "--test=small_memory"];
    Ok(vec![
        Step::rust_tests(&chosen).arguments(&["--", "--ignored"]),
    ])
}

fn generated(context: &Context) -> Result<Vec<Step>> {
    // With a test of the generator, cargo builds the generator as it does for the other tests.
    let build = Step::cargo(&[
        "test",
        "--locked",
        "--workspace",
        "--no-run",
        "--test=source",
    ]);
    let generator = context.project().target().join("debug/nsrm-codegen");
    let model = "weights-codegen/tabletop/tabletop.safetensors";
    let checked = |out: &str, options: &[&str]| {
        let step = Step::new(&generator, &[model, "--check", "--out"]);
        step.argument(out).arguments(options)
    };
    Ok(vec![
        build,
        checked("weights-codegen/tabletop/src/generated.rs", &[]),
        checked(
            "weights-codegen/tabletop/src/int8.rs",
            &["--quantise", "int8", "--name", "TABLETOP_INT8"],
        ),
    ])
}

fn golden(_: &Context) -> Result<Vec<Step>> {
    Ok(vec![Step::rust_tests(&["--test=golden"])])
}

/// Ignored in a plain `cargo test`, since they build programs.
fn proofs(_: &Context) -> Result<Vec<Step>> {
    let chosen = ["--test=linking", "--", "--ignored"];
    Ok(vec![Step::rust_tests(&chosen)])
}

/// Ignored in a plain `cargo test`, since they build a library.
fn c_interface(_: &Context) -> Result<Vec<Step>> {
    let chosen = ["--test=c_interface", "--", "--ignored"];
    Ok(vec![Step::rust_tests(&chosen)])
}

/// What it builds takes one processor.
fn firmware(context: &Context) -> Result<Vec<Step>> {
    let command = context.project().target().join("release/xtask");
    let build = Step::cargo(&["build", "--locked", "--release", "--package=xtask"]);
    Ok(vec![build, Step::new(command, &["footprint", "--quick"])])
}

fn instructions(context: &Context) -> Result<Vec<Step>> {
    // With nsrm: alone, it would be built with other features than other checks build it with.
    let build = Step::cargo(&["build", "--locked", "--release", "--package=nsrm"]);
    let count = context.project().target().join("release/instructions");
    Ok(vec![
        build.argument("--package=nsrm-bench"),
        Step::new(count, &[]),
    ])
}

fn docs(_: &Context) -> Result<Vec<Step>> {
    let step = Step::cargo(&["doc", "--locked", "--workspace", "--no-deps"]);
    Ok(vec![step.with("RUSTDOCFLAGS", "--deny warnings")])
}

fn environment(context: &Context) -> Result<Vec<Step>> {
    context.python()?;
    Ok(Vec::new())
}

fn python_lints(context: &Context) -> Result<Vec<Step>> {
    let python = context.python()?;
    let interpreter = python.to_string_lossy();
    let run = |arguments: &[&str]| {
        let mut step = Step::new(&python, &["-m"]);
        step.arguments.extend(arguments.iter().map(Into::into));
        step
    };
    let mut steps = Vec::new();
    for command in [&["ruff", "check"][..], &["ruff", "format", "--check"]] {
        steps.push(run(&[command, &PYTHON_PACKAGES].concat()));
        // The tests across packages have no settings of their own.
        let apart = ["--config", PYTHON_SETTINGS, "tests"];
        steps.push(run(&[command, &apart].concat()));
    }
    let types = ["pyright", "--warnings", "--pythonpath", &interpreter];
    steps.push(run(&[&types[..], &["--project", "sim-harness"]].concat()));
    steps.push(run(&[&types[..], &["std-shim/python", "tests"]].concat()));
    Ok(steps)
}

fn pytest(context: &Context, folder: &str) -> Result<Step> {
    let arguments = [
        "-m",
        "pytest",
        "--quiet",
        "--color=no",
        "-rs",
        // For the list of slow ones at the end.
        "--durations=20",
        "--durations-min=1",
        "--config-file",
        PYTHON_SETTINGS,
        "--rootdir=.",
        folder,
    ];
    // What XLA compiles in one test serves the others, also in other processes; of a training,
    // hundreds of small pieces, too.
    let compiled = context.project().target().join("jax");
    Ok(Step::new(context.python()?, &arguments)
        .with("JAX_COMPILATION_CACHE_DIR", compiled)
        .with("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
        .with("XLA_FLAGS", QUICK_EMITTERS)
        // Those that hang are aborted, and print where they were.
        .with("PYTHONFAULTHANDLER", "1")
        .counting(Runner::Pytest))
}

fn python_tests(context: &Context) -> Result<Vec<Step>> {
    let steps = PYTHON_PACKAGES.iter().map(|package| {
        let step = pytest(context, &format!("{package}/tests"))?;
        // Two files at a time, each in one process: what a file's tests share is made once.
        // In their usual order: the longest file has few tests and would come last.
        let files = ["--dist=loadfile", "--no-loadscope-reorder"];
        let step = step.argument("--numprocesses=2").arguments(&files);
        Ok(optimising(step, 0))
    });
    steps.collect()
}

/// What XLA compiles is optimised by LLVM at this level. Toys train for seconds, and what they train
/// is compiled for longer; the reduced tables take 9 minutes at level 1, and 11 at the greatest.
fn optimising(step: Step, level: u8) -> Step {
    let flags = format!("{QUICK_EMITTERS} --xla_backend_optimization_level={level}");
    step.with("XLA_FLAGS", flags)
}

/// Those that are not marked as slow, in which no arm moves and nothing is trained.
fn quick_python_tests(context: &Context) -> Result<Vec<Step>> {
    let steps = python_tests(context)?.into_iter();
    Ok(steps
        .map(|step| step.arguments(&["-m", "not slow"]))
        .collect())
}

fn tables(context: &Context) -> Result<Vec<Step>> {
    Ok(vec![
        optimising(pytest(context, "tests/tables")?, 1).beside_others(),
        optimising(pytest(context, "tests/domain")?, 0).beside_others(),
    ])
}

fn robot(context: &Context) -> Result<Vec<Step>> {
    Ok(vec![pytest(context, "tests/robot")?])
}

/// Their exit codes tell; what they wrote lies beside the logs.
fn trials(context: &Context) -> Result<Vec<Step>> {
    let trial = |name: &str, arguments: &[&str]| {
        let out = context.logs().join(name).into_os_string();
        Step::cargo(arguments).argument("--out").argument(out)
    };
    Ok(vec![
        trial("chaos", &["chaos", "--kills", "50"]),
        trial("soak", &["soak", "--hours", "0.01", "--every", "1"]),
        trial("latency", &["latency", "--samples", "500"]),
        trial("arm", &["harness", "trials", "--quick", "--quiet"]),
    ])
}

/// A robot on two hosts, with the tunnel that carries what is said between them.
fn hosts(context: &Context) -> Result<Vec<Step>> {
    let (_, install) = TUNNEL.at_hand(context);
    let programs = ["--package=nsrm", "--package=nsrm-trials"];
    let build = Step::cargo(&["build", "--release", "--locked"]).arguments(&programs);
    let test = pytest(context, "tests/hosts")?;
    Ok(install.into_iter().chain([build, test]).collect())
}

/// One sentence, drawn and carried out.
fn quick_demo(context: &Context) -> Result<Vec<Step>> {
    let one = "tests/demo/test_demo.py::test_without_the_arm_blocks_are_set_down";
    Ok(vec![pytest(context, one)?])
}

fn demo(context: &Context) -> Result<Vec<Step>> {
    let step = pytest(context, "tests/demo")?;
    Ok(vec![step.argument("--numprocesses=2")])
}
