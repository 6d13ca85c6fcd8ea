//! Times each poll of a plan, and a plan at once: the shortest of many runs, microseconds.

use std::hint::black_box;
use std::time::Instant;

use nsrm_bench::{EIGHT_STEPS, ONE_STEP, THREE_STEPS, Table};
use nsrm_core::{Planner, Scene};
use nsrm_tabletop::TABLETOP;

const RUNS: usize = 5_000;

fn main() {
    let table = Table::new();
    println!("sentence,polls,largest_us,median_us,all_us,begin_us,at_once_us");
    for (name, sentence) in [
        ("1 step", ONE_STEP),
        ("3 steps", THREE_STEPS),
        ("8 steps", EIGHT_STEPS),
    ] {
        let times = Times::of(table.scene(), sentence);
        let mut sorted = times.polls.clone();
        sorted.sort_by(f64::total_cmp);
        let (largest, median) = (sorted[sorted.len() - 1], sorted[sorted.len() / 2]);
        println!(
            "{name},{},{largest:.2},{median:.2},{:.2},{:.2},{:.2}",
            sorted.len(),
            sorted.iter().sum::<f64>(),
            times.begin,
            times.at_once
        );
    }
}

/// The shortest times of a sentence, microseconds.
struct Times {
    /// Of each poll, less that of reading the clock.
    polls: Vec<f64>,
    at_once: f64,
    /// Before the first poll.
    begin: f64,
}

impl Times {
    fn of(scene: &Scene, sentence: &str) -> Self {
        let planner = Planner::new(&TABLETOP);
        let mut times = Self {
            polls: Vec::new(),
            at_once: f64::INFINITY,
            begin: f64::INFINITY,
        };
        let mut clock = f64::INFINITY;
        for _ in 0..RUNS {
            let (at_once, plan) = timed(|| planner.plan(black_box(scene), black_box(sentence)));
            plan.expect("a plan");
            times.at_once = times.at_once.min(at_once);
            clock = clock.min(timed(|| ()).0);
            let (begin, mut task) = timed(|| planner.begin(scene, black_box(sentence)));
            times.begin = times.begin.min(begin);
            for place in 0.. {
                let (poll, polled) = timed(|| task.poll());
                if times.polls.len() <= place {
                    times.polls.push(f64::INFINITY);
                }
                times.polls[place] = times.polls[place].min(poll);
                if polled.is_ready() {
                    break;
                }
            }
        }
        for poll in &mut times.polls {
            *poll -= clock;
        }
        times
    }
}

/// Microseconds, and the result.
fn timed<T>(job: impl FnOnce() -> T) -> (f64, T) {
    let begun = Instant::now();
    let result = black_box(job());
    (begun.elapsed().as_secs_f64() * 1e6, result)
}
