//! Plans sentences: prints programs and sub-goals, or the reason of a refusal.
//!
//! ```sh
//! cargo run -p nsrm-core --example plan -- "put the red block to the right of the yellow block"
//! ```

mod observed;

use nsrm_core::Planner;
use nsrm_tabletop::TABLETOP;

fn main() {
    let sentence = std::env::args().nth(1);
    let sentences = match &sentence {
        Some(sentence) => vec![sentence.as_str()],
        None => vec![
            "put the small green block on the magenta block",
            "put the magenta block on the yellow block, then put the green block to the left of \
             the lego block",
            "put the purple block on the magenta block",
            "put the small block on the lego block",
        ],
    };
    let scene = observed::scene(&TABLETOP);
    let planner = Planner::new(&TABLETOP);
    for sentence in sentences {
        println!("> {sentence}");
        match planner.plan(&scene, sentence) {
            Ok(plan) => {
                println!("{}", plan.program().notation(&TABLETOP));
                println!("{}", plan.explain(&TABLETOP));
                for goal in plan.sub_goals() {
                    // World frame, metres: for the motion planner.
                    let [x, y, z]: [f32; 3] = goal.pose.translation.vector.into();
                    println!("object {} to ({x:.3}, {y:.3}, {z:.3}) m", goal.object);
                }
                println!("confidence {:.3}", plan.confidence());
            }
            Err(refusal) => println!("refused: {}", refusal.in_context(&TABLETOP, sentence)),
        }
        println!();
    }
}
