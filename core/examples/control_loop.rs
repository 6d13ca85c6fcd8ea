//! Planning beside other work: a control loop does a few bounded units of planning per tick.
//! Nothing here allocates; the loop owns the task, with its scene and its sentence.
//!
//! ```sh
//! cargo run -p nsrm-core --example control_loop
//! ```

mod observed;

use core::task::Poll;
use nsrm_core::heapless::String;
use nsrm_core::planner::{TASK_BYTES, UNIT_MULTIPLY_ADDS};
use nsrm_core::{MAX_SENTENCE_BYTES, Plan, Planner, PlanningTask, Refusal, Scene};
use nsrm_tabletop::TABLETOP;

/// Units of work per tick: as many as the remaining time allows. One takes at most
/// [`UNIT_MULTIPLY_ADDS`].
const PIECES: usize = 4;

/// The state of a robot's loop between two ticks.
struct Controller {
    planner: Planner<'static>,
    task: Option<PlanningTask<'static, Scene, String<MAX_SENTENCE_BYTES>>>,
}

impl Controller {
    const fn new() -> Self {
        Self {
            planner: Planner::new(&TABLETOP),
            task: None,
        }
    }

    /// Starts a sentence, unless it is too long to be stored; an earlier one is abandoned.
    fn ask(
        &mut self,
        scene: Scene,
        sentence: &str,
    ) -> Result<(), nsrm_core::heapless::CapacityError> {
        let sentence = String::try_from(sentence)?;
        self.task = Some(self.planner.begin(scene, sentence));
        Ok(())
    }

    /// One tick: control first, then some planning.
    fn tick(&mut self) -> Option<Result<Plan, Refusal>> {
        // … read sensors, command joints …
        let task = self.task.as_mut()?;
        for _ in 0..PIECES {
            if let Poll::Ready(result) = task.poll() {
                let result = result.cloned();
                self.task = None;
                return Some(result);
            }
        }
        None
    }
}

fn main() {
    let scene = observed::scene(&TABLETOP);
    let mut controller = Controller::new();
    let asked = controller.ask(scene, "put the small green block on the magenta block");
    asked.expect("it fits");
    let mut ticks = 1;
    let result = loop {
        if let Some(result) = controller.tick() {
            break result;
        }
        ticks += 1;
    };
    println!("{ticks} ticks of {PIECES} pieces, at most {UNIT_MULTIPLY_ADDS} multiply-adds each");
    println!("the task is at most {TASK_BYTES} bytes, without scene and sentence");
    match result {
        Ok(plan) => println!("{}", plan.explain(&TABLETOP)),
        Err(refusal) => println!("refused: {refusal}"),
    }
}
