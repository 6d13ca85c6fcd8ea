//! Flash, RAM, stack and instructions of the library on emulated Cortex-M processors, into
//! `docs/controller/footprint.csv`. `cargo footprint` builds the images and calls this.
//!
//! Arguments: QEMU; `arm-none-eabi-objdump`; `write`, or `compare` with what is written; the images.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, Result, ensure};
use nsrm_bench::firmware::{Image, PROCESSORS};
use nsrm_bench::{ONE_STEP, THREE_STEPS, Table};
use nsrm_core::nn::Precision;
use nsrm_tabletop::{TABLETOP, TABLETOP_INT8};

const HEADER: &str = "target,precision,vision,flash_bytes,ram_bytes,stack_bytes,instructions_1,\
    instructions_3,largest_poll,vision_instructions,vision_largest_poll,stack_bound_bytes";

/// Where the table of the page begins, and where it ends.
const BEGIN: &str = "<!-- figures: `cargo footprint` replaces them -->\n";
const END: &str = "<!-- end of figures -->";

/// How far a figure may be above what is written, as a fraction: another compiler compiles differently.
const TOLERANCE: f64 = 0.1;

/// Stack of the functions that measure, which the painted stack includes.
const MEASURING_BYTES: u64 = 256;

/// Refused at its second word, and planned.
const UNKNOWN_WORD: &str = "put crimson block on the blue block";

fn main() -> Result<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    let qemu = PathBuf::from(arguments.next().context("QEMU's path")?);
    let objdump = PathBuf::from(arguments.next().context("the path of objdump")?);
    let compares = arguments.next().is_some_and(|word| word == "compare");
    let tables = [&TABLETOP, &TABLETOP_INT8].map(Table::of);
    let mut rows = Vec::new();
    for file in arguments {
        let image = Image::open(Path::new(&file))?;
        let bound = image.stack_bound(&objdump)?;
        let [trained, rounded] = &tables;
        let table = match image.precision {
            Precision::Int8 => rounded,
            _ => trained,
        };
        for processor in PROCESSORS.iter().filter(|one| one.target == image.target) {
            let sentences = [ONE_STEP, THREE_STEPS, UNKNOWN_WORD];
            let run = image.run(&qemu, processor, table, &sentences)?;
            let (flash, ram) = image.memory()?;
            let (mut vision, mut vision_largest) = (0, 0);
            if image.has_vision {
                vision = run.instructions("observe", 0, "ticks")?;
                vision_largest = run.instructions("observe", 0, "largest")?;
            }
            let largest = run
                .instructions("plan", 0, "largest")?
                .max(run.instructions("plan", 1, "largest")?);
            let stack = run.stack()?;
            ensure!(
                stack <= bound + MEASURING_BYTES,
                "{}: {stack} bytes of stack were used, above the bound of {bound}",
                processor.name
            );
            rows.push(format!(
                "{},{},{},{flash},{ram},{stack},{},{},{largest},{vision},{vision_largest},{bound}",
                processor.name,
                image.precision.name(),
                if image.has_vision { "yes" } else { "no" },
                run.instructions("plan", 0, "ticks")?,
                run.instructions("plan", 1, "ticks")?,
            ));
        }
    }
    rows.sort();
    println!("{HEADER}");
    rows.iter().for_each(|row| println!("{row}"));
    if compares {
        compare(&rows)
    } else {
        write(&rows)
    }
}

/// A file of `docs/controller`.
fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/controller");
    folder.join(name)
}

fn write(rows: &[String]) -> Result<ExitCode> {
    let text = format!("{HEADER}\n{}\n", rows.join("\n"));
    std::fs::write(file("footprint.csv"), text).context("writing footprint.csv")?;
    let page = std::fs::read_to_string(file("README.md")).context("docs/controller/README.md")?;
    let (before, rest) = page.split_once(BEGIN).context("README.md: no figures")?;
    let (_, behind) = rest
        .split_once(END)
        .context("README.md: no end of figures")?;
    let page = format!("{before}{BEGIN}{}{END}{behind}", markdown(rows));
    std::fs::write(file("README.md"), page).context("writing docs/controller/README.md")?;
    Ok(ExitCode::SUCCESS)
}

/// The rows as a table for people.
fn markdown(rows: &[String]) -> String {
    let mut table = String::from(
        "| processor | weights | vision | flash KB | RAM KB | stack KB | one step | three steps | \
         largest poll | image | its largest poll | stack bound KB |\n|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for row in rows {
        let cells = row.split(',').enumerate().map(|(column, cell)| {
            let number: f64 = cell.parse().unwrap_or_default();
            match column {
                0..3 => cell.to_owned(),
                3..6 | 11 => format!("{:.1}", number / 1024.0),
                _ if number == 0.0 => String::new(),
                _ if number < 1e6 => format!("{:.1} k", number / 1e3),
                _ => format!("{:.2} M", number / 1e6),
            }
        });
        let cells: Vec<_> = cells.collect();
        table += &format!("| {} |\n", cells.join(" | "));
    }
    table
}

/// Whether each row is, within the tolerance, the written one of the same processor.
fn compare(rows: &[String]) -> Result<ExitCode> {
    let written = std::fs::read_to_string(file("footprint.csv")).context("footprint.csv")?;
    ensure!(!rows.is_empty(), "nothing was measured");
    let mut agree = true;
    for row in rows {
        let key: Vec<_> = row.split(',').take(3).collect();
        let line = written
            .lines()
            .find(|line| line.starts_with(&key.join(",")));
        let line = line.with_context(|| format!("footprint.csv has no {}", key.join(",")))?;
        let fields = HEADER.split(',').zip(row.split(',').zip(line.split(',')));
        for (name, (got, expected)) in fields.skip(3) {
            let (got, expected): (f64, f64) = (got.parse()?, expected.parse()?);
            if got > (1.0 + TOLERANCE) * expected {
                eprintln!("error: {}: {name} is {got}, written is {expected}", key[0]);
                agree = false;
            }
        }
    }
    if !agree {
        eprintln!("error: if that is meant, write the figures again: cargo footprint");
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}
