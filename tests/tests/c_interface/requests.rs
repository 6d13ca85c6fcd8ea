//! The same from C and from Rust.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

use nsrm_core::dsl::{Argument, Description, Property, RelationKind};
use nsrm_core::language::{Correction, Parsed};
use nsrm_core::nn::Precision;
use nsrm_core::planner::{Grounding, Plan};
use nsrm_core::refusal::Candidate;
use nsrm_core::vision::{Detection, ObservationTask, RgbImage, Stamp};
use nsrm_core::{Camera, Model, Planner, Program, RawScene, Refusal, Scene};
use nsrm_tests::picture::{Picture, SIZE};

use super::programs::{compile, said};

/// What `core/c/tests/conformance.c` reads, and what it is expected to print.
pub(crate) struct Requests {
    model: &'static Model<'static>,
    bytes: Vec<u8>,
    expected: String,
    /// How many sentences were planned, and how many refused.
    pub(crate) counts: [usize; 2],
}

impl Requests {
    /// None yet, of a model that is built in.
    pub(crate) fn of(model: &'static Model<'static>) -> Self {
        Self {
            model,
            bytes: Vec::new(),
            expected: String::new(),
            counts: [0; 2],
        }
    }

    pub(crate) fn plan(&mut self, raw: &RawScene, sentence: &str) {
        self.bytes.push(b'P');
        self.scene(raw);
        self.sentence(sentence);
        match Scene::new(*raw, self.model) {
            Ok(scene) => {
                let planner = Planner::new(self.model);
                let plan = planner.plan(&scene, sentence);
                self.planned(plan.as_ref(), sentence);
            }
            Err(error) => self.line(&format!("invalid: {error}")),
        }
        self.line("");
    }

    pub(crate) fn parse(&mut self, sentence: &str) {
        self.bytes.push(b'S');
        self.sentence(sentence);
        match Planner::new(self.model).parse(sentence) {
            Ok(parsed) => self.program(&parsed, parsed.program()),
            Err(refusal) => self.refused(&refusal, sentence),
        }
        self.line("");
    }

    pub(crate) fn ground(&mut self, raw: &RawScene, sentence: &str, first: u32) {
        self.bytes.push(b'G');
        self.scene(raw);
        self.bytes.extend(first.to_le_bytes());
        let planner = Planner::new(self.model);
        let scene = Scene::new(*raw, self.model).expect("a scene in order");
        let parsed = planner.parse(sentence).expect("a sentence in order");
        let mut task = planner.begin_grounding(&scene, &parsed, first as usize);
        let plan = loop {
            if let std::task::Poll::Ready(plan) = task.poll() {
                break plan;
            }
        };
        self.planned(plan.as_ref().copied(), sentence);
        self.line("");
    }

    pub(crate) fn observe(&mut self, camera: Camera, picture: &Picture) {
        self.bytes.push(b'O');
        self.camera(&camera);
        let count = picture.detections.len() as u32;
        let numbers = [SIZE[0], SIZE[1], count].map(u32::to_le_bytes);
        self.bytes.extend(numbers.concat());
        for Detection {
            id,
            visible,
            location,
        } in &picture.detections
        {
            self.bytes.extend(id.to_le_bytes());
            self.floats(visible);
            self.floats(location);
        }
        self.bytes.extend(&picture.pixels);
        let image = RgbImage::new(&picture.pixels, SIZE[0], SIZE[1], 3 * SIZE[0] as usize).unwrap();
        let stamp = Stamp {
            sequence: 7,
            timestamp_ns: 9,
        };
        let observed = ObservationTask::new(self.model, image, camera, &picture.detections, stamp)
            .and_then(ObservationTask::finish);
        match observed {
            Ok(scene) => {
                self.line(&format!("scene {:016x} 7 9", self.model.tag()));
                for object in scene.objects() {
                    let mut line = format!("object {}", object.id);
                    line += &bits(&object.location);
                    line += &bits(&object.embedding);
                    self.line(&line);
                }
            }
            Err(error) => self.line(&format!("invalid: {error}")),
        }
        self.line("");
    }

    fn planned(&mut self, plan: Result<&Plan, &Refusal>, sentence: &str) {
        match plan {
            Ok(plan) => {
                self.counts[0] += 1;
                self.program(plan.parsed(), plan.program());
                self.line(&format!("confidence{}", bits(&[plan.confidence()])));
                for (number, _, step) in plan.numbered() {
                    let pose = &step.sub_goal.pose;
                    let mut line = format!("step {number} action {}", step.action);
                    line += &grounding(&step.object);
                    line += &grounding(&step.reference);
                    line += " goal";
                    line += &bits(pose.translation.vector.as_slice());
                    line += &bits(pose.rotation.coords.as_slice());
                    line += &bits(&step.location);
                    let confidence = &step.confidence;
                    line += &bits(&[confidence.split, confidence.reference_unique]);
                    self.line(&line);
                }
                self.line(&format!("explanation: {}", plan.explain(self.model)));
            }
            Err(refusal) => {
                self.counts[1] += 1;
                self.refused(refusal, sentence);
            }
        }
    }

    fn program(&mut self, parsed: &Parsed, program: &Program) {
        for (step, decisions) in program.steps().iter().zip(parsed.decisions()) {
            self.line(&format!(
                "parsed: action {} concepts {} {} relations {} {} kinds {} {} which {} {} mm {} \
                 span {} {}",
                step.action,
                step.object.concepts().len(),
                step.reference.concepts().len(),
                step.object.relations().len(),
                step.reference.relations().len(),
                kind(&step.object),
                kind(&step.reference),
                which(&step.object),
                which(&step.reference),
                step.distance_mm.map_or(0, std::num::NonZeroU16::get),
                decisions.span.start,
                decisions.span.end,
            ));
        }
        for correction in parsed.corrections() {
            self.line(&corrected(self.model, correction));
        }
        self.line(&format!("notation: {}", program.notation(self.model)));
    }

    fn refused(&mut self, refusal: &Refusal, sentence: &str) {
        let kinds = Refusal::KINDS.iter();
        let kind = (1..).zip(kinds).find(|(_, kind)| **kind == refusal.kind());
        let kind: u32 = kind.expect("a kind").0;
        let (mut step, mut argument, mut span, mut object) = (0, 0, (0, 0), 0);
        let (mut fitting, mut listed, mut detail) = (0, Vec::new(), "");
        let number = |argument: &Argument| if *argument == Argument::Object { 1 } else { 2 };
        match refusal {
            Refusal::UnknownWord { span: at }
            | Refusal::TooManyConcepts { span: at, .. }
            | Refusal::ConflictingValues { span: at, .. } => span = (at.start, at.end),
            Refusal::SentenceTooLong { unit, .. } => detail = unit.name(),
            Refusal::TooManyReferences {
                step: n, span: at, ..
            }
            | Refusal::TooManyRelations {
                step: n, span: at, ..
            }
            | Refusal::IncompleteStep {
                step: n, span: at, ..
            }
            | Refusal::SameReference { step: n, span: at }
            | Refusal::SeveralReferences { step: n, span: at }
            | Refusal::OnlyOnTable { step: n, span: at }
            | Refusal::UnclearPronoun { step: n, span: at }
            | Refusal::UnclearWords {
                step: n, span: at, ..
            } => {
                (step, span) = (*n, (at.start, at.end));
            }
            Refusal::Unsure {
                step: n, decision, ..
            } => (step, detail) = (*n, decision.name()),
            Refusal::NoSuchObject {
                step: n,
                argument: which,
                best,
                ..
            } => {
                (step, argument) = (*n, number(which));
                listed.extend(best);
            }
            Refusal::Ambiguous {
                step: n,
                argument: which,
                candidates,
                ..
            } => {
                (step, argument, fitting) = (*n, number(which), candidates.count());
                listed.extend(candidates.listed());
            }
            Refusal::SameObject {
                step: n,
                object: id,
            }
            | Refusal::AlreadyOnTable {
                step: n,
                object: id,
            }
            | Refusal::NoRoomOnTable {
                step: n,
                object: id,
            }
            | Refusal::NotOnTable {
                step: n,
                object: id,
            }
            | Refusal::HiddenReference {
                step: n,
                object: id,
            }
            | Refusal::OutsideWorkSpace {
                step: n,
                object: id,
                ..
            } => (step, object) = (*n, *id),
            Refusal::OutsideTrainingView {
                step: n,
                argument: which,
                object: id,
            } => {
                (step, argument, object) = (*n, number(which), *id);
            }
            Refusal::Calibration(fault) => (object, detail) = (fault.object, fault.quantity.name()),
            _ => {}
        }
        let mut line = format!(
            "refused: kind {kind} step {step} argument {argument} span {} {} object {object} \
             fitting {fitting} candidates",
            span.0, span.1
        );
        for Candidate { object, score, .. } in listed {
            let _ = write!(line, " {object}{}", bits(&[score]));
        }
        self.line(&format!("{line} detail {detail}"));
        self.line(&format!(
            "message: {}",
            refusal.in_context(self.model, sentence)
        ));
    }

    fn line(&mut self, line: &str) {
        self.expected += line;
        self.expected.push('\n');
    }

    fn sentence(&mut self, sentence: &str) {
        self.bytes.extend((sentence.len() as u32).to_le_bytes());
        self.bytes.extend(sentence.as_bytes());
    }

    fn floats(&mut self, values: &[f32]) {
        self.bytes
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }

    fn camera(&mut self, camera: &Camera) {
        let size = [camera.width, camera.height].map(u32::to_le_bytes);
        self.bytes.extend(size.concat());
        self.floats(&[camera.fx, camera.fy, camera.cx, camera.cy]);
        self.floats(&camera.position);
        self.floats(&camera.orientation);
    }

    /// The bytes of `nsrm_scene_t`.
    fn scene(&mut self, raw: &RawScene) {
        let header = &raw.header;
        self.bytes
            .extend([header.schema, header.frame].map(u32::to_le_bytes).concat());
        let numbers = [header.model_tag, header.sequence, header.timestamp_ns];
        self.bytes.extend(numbers.map(u64::to_le_bytes).concat());
        self.camera(&raw.camera);
        self.bytes.extend(raw.count.to_le_bytes());
        for object in &raw.objects {
            self.bytes.extend(object.id.to_le_bytes());
            self.floats(&object.location);
            self.floats(&object.embedding);
        }
    }

    /// Runs the program.
    pub(crate) fn check(&self) {
        let precision = self.model.embeddings.precision();
        let flags: &[&str] = match precision {
            Precision::Int8 => &["-DMODEL=nsrm_tabletop_int8"],
            _ => &[],
        };
        let program = compile("tests/conformance.c", flags);
        let mut process = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut input = process.stdin.take().expect("piped");
        let bytes = self.bytes.clone();
        let writer = std::thread::spawn(move || input.write_all(&bytes));
        let output = process.wait_with_output().expect("the program ends");
        assert!(output.status.success(), "{}", said(&output));
        writer
            .join()
            .expect("a thread")
            .expect("it reads everything");
        let printed = String::from_utf8_lossy(&output.stdout);
        for (number, (got, expected)) in printed.lines().zip(self.expected.lines()).enumerate() {
            assert_eq!(got, expected, "line {number}");
        }
        assert_eq!(printed.len(), self.expected.len());
    }
}

fn bits(values: &[f32]) -> String {
    values
        .iter()
        .map(|value| format!(" {:08x}", value.to_bits()))
        .collect()
}

fn grounding(grounding: &Grounding) -> String {
    let mut text = format!(" object {}", grounding.object);
    text += &bits(&[grounding.score, grounding.probability]);
    for anchor in grounding.anchors() {
        let _ = write!(text, " anchor {anchor}");
    }
    text
}

fn corrected(model: &Model<'_>, correction: &Correction) -> String {
    let span = correction.span();
    let read_as = correction.read_as(model);
    format!("corrected: {} {} {read_as}", span.start, span.end)
}

/// The kind of the first relation as a number, 0 without one.
fn which(description: &Description) -> u32 {
    description
        .filters()
        .choice()
        .map_or(0, Property::which_number)
}

fn kind(description: &Description) -> u32 {
    match description
        .relations()
        .first()
        .map(|relation| relation.kind)
    {
        None | Some(RelationKind::Action(_)) => 0,
        Some(RelationKind::Nearest) => 1,
        Some(RelationKind::Farthest) => 2,
        Some(RelationKind::And) => 3,
    }
}
