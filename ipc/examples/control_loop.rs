//! A planner inside a 1 kHz control loop, instead of `nsrm serve`:
//!
//! ```sh
//! cargo harness world --robot left --seed 4 &
//! target/release/nsrm perceive --robot left &
//! cargo run --release -p nsrm-ipc --example control_loop -- --robot left --seconds 20 &
//! target/release/nsrm say --robot left "put the small red block on the magenta block"
//! ```
//!
//! Each tick gives the planner a time budget, in which it receives what has arrived through shared
//! memory and does units of work; the rest waits for the next tick. Nothing in a tick blocks, and
//! only iceoryx2's sending allocates: once for each heartbeat, command and reply. A tick in which a
//! process joins or leaves may exceed the budget, since its memory is mapped or unmapped. An idle
//! loop runs beside it: deadlines that it misses are the machine's. Ctrl-C ends both early.
//! `--limits-s 60` sets all timeouts to 60 s, for a busy machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use hdrhistogram::Histogram;
use iceoryx2::config::Config;
use iceoryx2::prelude::{LogLevel, set_log_level};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::Limits;
use nsrm_ipc::message::Role;
use nsrm_ipc::node::{PlannerNode, PollStatus};
use nsrm_ipc::service::{Robot, RobotName};
use nsrm_tabletop::TABLETOP;
use rustix::thread::{ClockId, Timespec, clock_nanosleep_absolute};
use signal_hook::consts::SIGINT;
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Time between two ticks, nanoseconds.
const PERIOD_NS: u64 = 1_000_000;
/// The planner's budget in a tick; the last unit of work takes up to some tens of microseconds
/// more.
const BUDGET_NS: u64 = 200_000;
/// The longest time that is counted, nanoseconds; longer ones count as this.
const LONGEST_NS: u64 = 1_000_000_000;

/// The options on the command line.
struct Options {
    robot: RobotName,
    seconds: u64,
    limits: Limits,
}

impl Options {
    fn parse() -> Result<Self, Box<dyn std::error::Error>> {
        let mut options = Self {
            robot: "robot".parse()?,
            seconds: 10,
            limits: Limits::default(),
        };
        let mut arguments = std::env::args().skip(1);
        while let Some(option) = arguments.next() {
            let value = arguments.next();
            match (option.as_str(), value) {
                ("--robot", Some(name)) => options.robot = name.parse()?,
                ("--seconds", Some(number)) => options.seconds = number.parse()?,
                ("--limits-s", Some(number)) => options.limits = all(number.parse()?),
                _ => {
                    let usage = "usage: control_loop [--robot NAME] [--seconds N] [--limits-s N]";
                    return Err(usage.into());
                }
            }
        }
        Ok(options)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Options {
        robot,
        seconds,
        limits,
    } = Options::parse()?;
    set_log_level(LogLevel::Fatal);
    let locked = rustix::mm::mlockall(
        rustix::mm::MlockAllFlags::CURRENT | rustix::mm::MlockAllFlags::FUTURE,
    );
    println!("memory locked: {}", said(locked.is_ok()));
    let stop = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(SIGINT, Arc::clone(&stop))?;
    let empty = {
        let stop = Arc::clone(&stop);
        std::thread::spawn(move || {
            let realtime = become_realtime();
            let mut ticks = Ticks::new();
            while !stop.load(Ordering::Relaxed) {
                ticks.next(|| {});
            }
            (ticks, realtime)
        })
    };
    let ended = Arc::clone(&stop);
    let planning: JoinHandle<Result<_, String>> = std::thread::spawn(move || {
        // Ports are created in the thread that uses them.
        let robot = Robot::join(robot, Role::Planner, Config::global_config());
        let node = robot.and_then(|robot| PlannerNode::begin(robot, &TABLETOP, limits));
        let mut node = node.map_err(|error| error.to_string())?;
        let realtime = become_realtime();
        println!("planning, in a loop of 1 kHz for {seconds} s");
        let mut ticks = Ticks::new();
        for _ in 0..seconds * (1_000_000_000 / PERIOD_NS) {
            if ended.load(Ordering::Relaxed) {
                break;
            }
            ticks.next(|| {
                let end_ns = now_ns() + BUDGET_NS;
                while node.poll(now_ns()) == PollStatus::Working && now_ns() < end_ns {}
            });
        }
        Ok((ticks, realtime))
    });
    let planned = planning.join().expect("the loop does not panic");
    stop.store(true, Ordering::Relaxed);
    let (empty, _) = empty.join().expect("the loop does not panic");
    let (ticks, realtime) = planned?;
    println!("SCHED_FIFO: {}", said(realtime));
    ticks.print("planner's loop");
    empty.print("empty loop beside it");
    println!(
        "missed: {} of {} ticks by work longer than a period, {} by a late start; the empty loop \
         began {} late",
        ticks.overrun,
        ticks.work.len(),
        ticks.late,
        empty.late
    );
    Ok(())
}

/// Limits with all timeouts set to this many seconds.
fn all(seconds: u32) -> Limits {
    let ns = u64::from(seconds) * 1_000_000_000;
    Limits {
        scene_age_ns: ns,
        scene_wait_ns: ns,
        accept_wait_ns: ns,
        move_wait_ns: ns,
        silence_ns: ns,
        ..Limits::default()
    }
}

fn said(granted: bool) -> &'static str {
    if granted { "yes" } else { "not permitted" }
}

/// Requests real-time scheduling; returns whether it was granted.
fn become_realtime() -> bool {
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let priority =
        ThreadPriority::from_posix(thread_priority::ScheduleParams { sched_priority: 50 });
    set_thread_priority_and_policy(thread_native_id(), priority, policy).is_ok()
}

/// One line per power of two: how many ticks took up to this many microseconds, and more than in
/// the previous line; twice as many have a bar that is one sign longer.
fn print_bars(what: &str, histogram: &Histogram<u64>) {
    for line in histogram
        .iter_log(1000, 2.0)
        .skip_while(|line| line.count_since_last_iteration() == 0)
    {
        let count = line.count_since_last_iteration();
        let signs = count.checked_ilog2().map_or(0, |twice| 1 + twice as usize);
        let (bar, most) = ("#".repeat(signs), line.value_iterated_to() / 1000 + 1);
        let line = format!("  {what:>10} ≤ {most:>7} {count:>8} {bar}");
        println!("{}", line.trim_end());
    }
}

/// The measured times of a loop.
struct Ticks {
    /// How late each tick started, nanoseconds.
    lateness: Histogram<u64>,
    /// How long its work took, nanoseconds.
    work: Histogram<u64>,
    /// Ticks whose work took longer than a period.
    overrun: u64,
    /// Ticks that started more than a period late although the work before them did not take that
    /// long.
    late: u64,
    next_ns: u64,
}

impl Ticks {
    fn new() -> Self {
        let histogram = || Histogram::new_with_bounds(1, LONGEST_NS, 3).expect("sound bounds");
        Self {
            lateness: histogram(),
            work: histogram(),
            overrun: 0,
            late: 0,
            next_ns: now_ns() + PERIOD_NS,
        }
    }

    /// Waits for the next tick and does its work.
    fn next(&mut self, work: impl FnOnce()) {
        let wake = Timespec {
            tv_sec: (self.next_ns / 1_000_000_000).cast_signed(),
            tv_nsec: (self.next_ns % 1_000_000_000).cast_signed(),
        };
        // A signal that wakes it early makes the tick early.
        let _ = clock_nanosleep_absolute(ClockId::Monotonic, &wake);
        let begun_ns = now_ns();
        work();
        let ended_ns = now_ns();
        let (late_ns, work_ns) = (begun_ns.saturating_sub(self.next_ns), ended_ns - begun_ns);
        self.lateness.saturating_record(late_ns.max(1));
        self.work.saturating_record(work_ns.max(1));
        self.overrun += u64::from(work_ns > PERIOD_NS);
        self.late += u64::from(late_ns > PERIOD_NS);
        self.next_ns += PERIOD_NS;
        if ended_ns > self.next_ns {
            // Missed ticks are skipped.
            self.next_ns = ended_ns + PERIOD_NS - (ended_ns - self.next_ns) % PERIOD_NS;
        }
    }

    fn print(&self, name: &str) {
        println!("{name}, microseconds; how many ticks, # for each doubling");
        println!(
            "  {:>10}{:>10}{:>10}{:>10}{:>10}",
            "", "p50", "p99", "p99.99", "most"
        );
        for (what, histogram) in [("late by", &self.lateness), ("work", &self.work)] {
            print!("  {what:>10}");
            for quantile in [0.5, 0.99, 0.9999] {
                print!(
                    "{:>10.1}",
                    histogram.value_at_quantile(quantile) as f64 / 1000.0
                );
            }
            println!("{:>10.1}", histogram.max() as f64 / 1000.0);
        }
        for (what, histogram) in [("late by", &self.lateness), ("work", &self.work)] {
            print_bars(what, histogram);
        }
    }
}
