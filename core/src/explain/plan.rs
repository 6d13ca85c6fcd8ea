use core::fmt;

use crate::dsl::{Description, Filters, RelationKind, action_phrase};
use crate::language::Correction;
use crate::model::Model;
use crate::planner::{Grounding, Plan};

impl Plan {
    /// A sentence that says what one step does and why: `Step 1: move the small
    /// green object (id 3, score 0.98) to the right of the lego green object
    /// (id 1, score 0.99); confidence 0.97.` Nothing for a step that isn't there. What is put on the
    /// table is said to be put beside the object next to which there is room, and what is put next to an object
    /// on which side of it.
    ///
    /// * `model`: the one that the plan was made with
    /// * `step`: counted from 0, as in the whole sentence
    pub fn explain_step<'a>(&'a self, model: &'a Model<'a>, step: usize) -> impl fmt::Display + 'a {
        StepExplanation {
            plan: self,
            model,
            step,
        }
    }

    /// [`Plan::explain_step`] of every step, a line each.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use nsrm_core::Planner;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # let scene = scene(&TABLETOP);
    /// let plan = Planner::new(&TABLETOP).plan(&scene, "put the red block on the lego block")?;
    /// let told = plan.explain(&TABLETOP).to_string();
    /// assert!(told.starts_with("Step 1: move the red object (id 4, score "), "{told}");
    /// # Ok(())
    /// # }
    /// ```
    pub fn explain<'a>(&'a self, model: &'a Model<'a>) -> impl fmt::Display + 'a {
        PlanExplanation { plan: self, model }
    }
}

impl Correction {
    /// For the person: `"yelow" was read as "yellow"`.
    ///
    /// * `model`, `sentence`: those of the plan or the parse
    pub fn explain<'a>(
        &'a self,
        model: &'a Model<'a>,
        sentence: &'a str,
    ) -> impl fmt::Display + 'a {
        CorrectionExplanation {
            word: self.span().of(sentence).unwrap_or("?"),
            read_as: self.read_as(model),
        }
    }
}

struct CorrectionExplanation<'a> {
    word: &'a str,
    read_as: &'a str,
}

impl fmt::Display for CorrectionExplanation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { word, read_as } = self;
        write!(f, "\"{word}\" was read as \"{read_as}\"")
    }
}

struct StepExplanation<'a> {
    plan: &'a Plan,
    model: &'a Model<'a>,
    step: usize,
}

impl StepExplanation<'_> {
    fn object(
        &self,
        description: &Description,
        grounding: &Grounding,
        f: &mut fmt::Formatter<'_>,
    ) -> fmt::Result {
        self.noun(description.filters(), f)?;
        if let Some(except) = description.except() {
            write!(f, " except {}", except.of_each().words(self.model))?;
        }
        for relation in description.relations() {
            let phrase = relation.kind.phrase(self.model);
            let lead = match relation.kind {
                RelationKind::And => "",
                _ => "that is ",
            };
            write!(f, " {lead}{phrase} ")?;
            self.noun(&relation.to, f)?;
        }
        let Grounding { object, score, .. } = grounding;
        write!(f, " (id {object}, score {score:.2})")
    }

    fn noun(&self, filters: &Filters, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if filters.is_table() {
            return f.write_str("the table");
        }
        let is_each = filters.quantifier().is_some() && filters.concepts().is_empty();
        if filters.is_empty() || is_each {
            f.write_str("the object")
        } else {
            write!(f, "the {} object", filters.words(self.model))
        }
    }
}

impl fmt::Display for StepExplanation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut steps = self.plan.numbered();
        let Some((_, understood, planned)) = steps.find(|(number, ..)| *number == self.step) else {
            return Ok(());
        };
        let phrase = action_phrase(self.model, understood.action);
        write!(f, "Step {}: move ", self.step.saturating_add(1))?;
        self.object(&understood.object, &planned.object, f)?;
        write!(f, " {phrase} ")?;
        if understood.reference.filters().is_itself() {
            f.write_str("where it is")?;
        } else if understood.reference.filters().is_table() {
            let phrase = action_phrase(self.model, planned.action);
            write!(f, "the table, {phrase} object {}", planned.reference.object)?;
        } else {
            self.object(&understood.reference, &planned.reference, f)?;
            if planned.action != understood.action {
                write!(f, ", {} it", action_phrase(self.model, planned.action))?;
            }
        }
        if let Some(mm) = understood.distance_mm {
            let from_itself = understood.reference.filters().is_itself();
            f.write_str(if from_itself {
                ", by"
            } else {
                ", at a distance of"
            })?;
            write!(f, " {mm} mm")?;
        }
        write!(f, "; confidence {:.2}.", planned.confidence.joint())
    }
}

struct PlanExplanation<'a> {
    plan: &'a Plan,
    model: &'a Model<'a>,
}

impl fmt::Display for PlanExplanation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, ..) in self.plan.numbered() {
            if number > self.plan.first() {
                f.write_str("\n")?;
            }
            self.plan.explain_step(self.model, number).fmt(f)?;
        }
        Ok(())
    }
}
