//! Your own model instead of the tabletop's. `nsrm-codegen` writes a trained model file as static
//! arrays:
//!
//! ```sh
//! nsrm-codegen kitchen.safetensors --name KITCHEN --out src/kitchen.rs
//! ```
//!
//! and `mod kitchen;` makes them `kitchen::KITCHEN`. A build script can do the same (see the
//! documentation of `nsrm-codegen`), and the package `nsrm` loads the file at run time. All three
//! give a [`Model`]; here it is the tabletop's with another header, for a robot with a shorter
//! reach and higher confidence thresholds.
//!
//! ```sh
//! cargo run -p nsrm-core --example own_model
//! ```

mod observed;

use nsrm_core::model::{Thresholds, WorkSpace};
use nsrm_core::{Model, Planner};
use nsrm_tabletop::TABLETOP;

/// Fields that are not named stay the same; all of it is evaluated at compile time.
static CAREFUL: Model<'static> = TABLETOP.with_header(
    TABLETOP
        .header
        .with_thresholds(Thresholds::new().with_match_score(0.6).with_decision(0.95))
        .with_work_space(
            WorkSpace::new()
                .with_min([0.35, -0.10, 0.0])
                .with_max([0.50, 0.10, 0.18]),
        ),
);

fn main() {
    // Models of the generator and the loader have passed this check; hand-made ones have not.
    CAREFUL.check().expect("a sound model");
    for (name, model) in [("tabletop", &TABLETOP), ("careful", &CAREFUL)] {
        let scene = observed::scene(model);
        let sentence = "put the small green block to the right of the red block";
        match Planner::new(model).plan(&scene, sentence) {
            Ok(plan) => println!("{name}: {}", plan.explain(model)),
            Err(refusal) => println!("{name}: refused: {}", refusal.in_context(model, sentence)),
        }
    }
}
