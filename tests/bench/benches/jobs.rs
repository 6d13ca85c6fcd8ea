//! Times of layers, of modules and of whole jobs: `cargo bench -p nsrm-bench`.

use std::hint::black_box;

use divan::Bencher;
use nsrm_bench::{Job, ONE_STEP, Table};
use nsrm_core::Model;
use nsrm_core::language::{Encoder, Reader, Splitter, Token};
use nsrm_core::model::{INSTRUCTION, LOCATION, SPLITTER_HIDDEN, WordEmbeddings};
use nsrm_core::nn::tanh_all;
use nsrm_tabletop::{TABLETOP, TABLETOP_INT8};

const PRECISIONS: [&str; 2] = ["f32", "int8"];

fn main() {
    divan::main();
}

/// The built-in model in a precision.
fn of(precision: &str) -> &'static Model<'static> {
    if precision == "int8" {
        &TABLETOP_INT8
    } else {
        &TABLETOP
    }
}

#[divan::bench(args = Job::ALL.map(Job::name))]
fn job(bencher: Bencher<'_, '_>, name: &str) {
    jobs(bencher, name, Table::new());
}

#[divan::bench(args = Job::ALL.map(Job::name))]
fn job_int8(bencher: Bencher<'_, '_>, name: &str) {
    jobs(bencher, name, Table::of(&TABLETOP_INT8));
}

fn jobs(bencher: Bencher<'_, '_>, name: &str, table: Table) {
    let job = Job::ALL.into_iter().find(|job| job.name() == name);
    let job = job.expect("one of all jobs");
    bencher.bench_local(|| table.run(job));
}

#[divan::bench]
fn layer_tanh_of_64(bencher: Bencher<'_, '_>) {
    bencher.bench_local(|| tanh_all(black_box(&mut [0.3; 64])));
}

#[divan::bench(args = PRECISIONS)]
fn layer_gru_step_of_48(bencher: Bencher<'_, '_>, precision: &str) {
    let cell = of(precision).language.forward;
    bencher.bench_local(|| cell.step(black_box(&[0.3; 32]), black_box(&[0.1; 48])));
}

#[divan::bench(args = PRECISIONS)]
fn layer_gru_step_of_32(bencher: Bencher<'_, '_>, precision: &str) {
    let cell = of(precision).language.splitter;
    bencher.bench_local(|| cell.step(black_box(&[0.3; 24]), black_box(&[0.1; SPLITTER_HIDDEN])));
}

#[divan::bench(args = PRECISIONS)]
fn layer_dense_96_to_96(bencher: Bencher<'_, '_>, precision: &str) {
    let layer = of(precision).language.object_decoder;
    bencher.bench_local(|| layer.apply(black_box(&[0.3; INSTRUCTION])));
}

#[divan::bench]
fn module_words(bencher: Bencher<'_, '_>) {
    bencher.bench_local(|| words(black_box(ONE_STEP)));
}

#[divan::bench]
fn module_encoder(bencher: Bencher<'_, '_>) {
    let tokens = embedded(ONE_STEP);
    let mut encoder = Encoder::new();
    bencher.bench_local(|| {
        encoder.clear();
        for (embeddings, group) in black_box(&tokens) {
            encoder.forward(&TABLETOP.language, &embeddings.encoder, *group);
        }
        for (embeddings, group) in tokens.iter().rev() {
            encoder.backward(&TABLETOP.language, &embeddings.encoder, *group);
        }
        encoder.instruction()
    });
}

#[divan::bench]
fn module_splitter(bencher: Bencher<'_, '_>) {
    let tokens = embedded(ONE_STEP);
    bencher.bench_local(|| {
        let mut splitter = Splitter::new();
        let mut rest = black_box(tokens.as_slice());
        while let [(token, _), behind @ ..] = rest {
            let ahead = behind.iter().map(|(token, _)| token.splitter);
            black_box(splitter.hazard(&TABLETOP.language, &token.splitter, ahead));
            rest = behind;
        }
    });
}

#[divan::bench]
fn module_action_simulator(bencher: Bencher<'_, '_>) {
    let action = &TABLETOP.actions[0];
    let places: [[f32; LOCATION]; 2] = [[0.2, 0.3, 0.3, 0.4, 1.1], [0.6, 0.5, 0.7, 0.6, 1.2]];
    bencher.bench_local(|| {
        let [object, reference] = black_box(&places);
        nsrm_core::action::simulate(TABLETOP.simulator, action, object, reference)
    });
}

fn words(sentence: &str) -> Vec<Token> {
    let mut reader = Reader::new(sentence).expect("a sentence");
    while reader.advance(&TABLETOP, sentence).expect("known words") {}
    reader.tokens().to_vec()
}

/// Each token's embeddings, and whether it is a group of concept words.
fn embedded(sentence: &str) -> Vec<(WordEmbeddings, bool)> {
    let tokens = words(sentence);
    let embedded = tokens.iter().map(|token| {
        let embeddings = token.embeddings(&TABLETOP).expect("a token of this model");
        (embeddings, token.filters().is_some())
    });
    embedded.collect()
}
