//! A model whose weights were set by hand.
//!
//! It reads `put the small red block on the blue block then …`: `then` ends a step, `on` and
//! `beside` are the actions, the description before them is the object's and the one after them the
//! reference's. It is unsure if both come after them (`on the blue block put the red block`),
//! without `on` or `beside`, and at `maybe`, which ends a step with a probability of 0.57. After
//! `it`, it takes the next description for both arguments. `sideways` is acceptable nowhere.
//! `behind` names the relation of the action `beside` to the next description, and `opposite` does
//! so for an object that has no other description: `put opposite the red block on …`. `furthest` says
//! that the one before it is the farthest from the next. `outermost` is a word for the extreme of the
//! action `beside`, `both` one for two objects, and `this` a pronoun.
//!
//! An object's embedding has a 1 for its colour and a 1 for its size; an action predicts the moved
//! object at the reference's location.

use nsrm_core::dsl::{Extreme, Property, Quantifier};
use nsrm_core::model::{
    ACCEPTABILITY_HIDDEN, Action, Attribute, CONCEPT, Concept, DistanceShift, DistanceUnit,
    Distances, ENCODER_HIDDEN, Embeddings, HAZARD_INPUT, Header, INSTRUCTION, LOCATION, Language,
    LexiconEntry, MERGE_CHANNELS, MERGED, Model, OBJECT_EMBEDDING, PATCH_CHANNELS, PixelToCamera,
    Pronoun, SIMULATOR_HIDDEN, SPLITTER_HIDDEN, SPLITTER_WORD, Simulator, Superlative, Table,
    Thresholds, VIEW_EMBEDDING, View, ViewEncoder, Vision, WORD, Word, WordEmbeddings, WorkSpace,
};
use nsrm_core::nn::{Cell, Dense, Gru, Linear, MergeConv, PatchConv};
use nsrm_core::scene::ObservedObject;
use nsrm_core::{RawScene, Scene};

use crate::picture;

/// Edge lengths of all blocks, metres.
pub const EDGES_M: [f32; 3] = [0.04, 0.015, 0.05];
/// The depth at which [`picture::camera`] sees the centre of a block on the table, metres.
pub const DEPTH_M: f32 = 0.975;
/// See [`Vision::color`]; all zero.
static COLOR: ViewEncoder<'static, 3> = view_encoder();
/// See [`Vision::brightness`]; all zero.
static BRIGHTNESS: ViewEncoder<'static, 1> = view_encoder();
/// See [`Simulator::hidden`]; all zero.
static SIMULATED: Linear<SIMULATOR_HIDDEN, SIMULATOR_HIDDEN> = zero();
/// See [`ViewEncoder::dense`]; all zero.
static DENSE: Linear<MERGED, VIEW_EMBEDDING> = zero();
/// A saturated gate or logit.
const SURE: f32 = 20.0;
/// The unit of the forward encoder for `on`; the next one is for `beside`.
const ACTION_UNIT: usize = 0;
/// The unit of the forward encoder for `it`.
const IT_UNIT: usize = 20;
/// The unit of the forward encoder for `behind`; the next one is for `opposite`.
const RELATION_UNIT: usize = 22;
/// The unit of the forward encoder for `furthest`.
const FARTHEST_UNIT: usize = RELATION_UNIT + 2;
/// The unit of both encoders for `sideways`.
const SIDEWAYS_UNIT: usize = 21;

/// The parts of the model; a test may spoil one before it takes [`Parts::model`].
#[derive(Debug, Clone)]
pub struct Parts {
    /// See [`Model::header`].
    pub header: Header<'static>,
    /// See [`Model::words`].
    pub words: Vec<Word<'static>>,
    /// See [`Model::embeddings`].
    pub embeddings: Vec<WordEmbeddings>,
    /// See [`Model::lexicon`].
    pub lexicon: Vec<LexiconEntry<'static>>,
    /// See [`Model::pronouns`].
    pub pronouns: Vec<Pronoun>,
    /// See [`Model::table`]; none.
    pub table: Table<'static>,
    /// See [`Model::distances`]; none.
    pub distances: Distances<'static>,
    /// See [`Model::attributes`].
    pub attributes: Vec<Attribute<'static>>,
    /// See [`Model::concepts`].
    pub concepts: Vec<Concept<'static>>,
    /// See [`Model::actions`].
    pub actions: Vec<Action<'static>>,
    /// See [`Language::forward`]; the backward cell is the same.
    pub encoder: Gru<WORD, ENCODER_HIDDEN>,
    /// See [`Language::object_decoder`].
    pub object_decoder: Linear<INSTRUCTION, INSTRUCTION>,
    /// See [`Language::reference_decoder`].
    pub reference_decoder: Linear<INSTRUCTION, INSTRUCTION>,
    /// See [`Language::acceptability_hidden`].
    pub acceptability_hidden: Linear<INSTRUCTION, ACCEPTABILITY_HIDDEN>,
    /// See [`Language::acceptability`].
    pub acceptability: Linear<ACCEPTABILITY_HIDDEN, 1>,
    /// See [`Language::nearest`].
    pub nearest: Superlative,
    /// See [`Language::farthest`].
    pub farthest: Superlative,
    /// See [`Language::splitter`].
    pub splitter: Gru<SPLITTER_WORD, SPLITTER_HIDDEN>,
    /// See [`Language::hazard_hidden`].
    pub hazard_hidden: Linear<HAZARD_INPUT, SPLITTER_HIDDEN>,
    /// See [`Language::hazard`].
    pub hazard: Linear<SPLITTER_HIDDEN, 1>,
    /// See [`Model::simulator`].
    pub simulator: Simulator<'static>,
    /// See [`Model::camera`].
    pub camera: PixelToCamera,
}

impl Parts {
    /// The model as described above.
    pub fn new() -> Self {
        let mut parts = Self {
            header: header(),
            words: WORDS.map(|text| Word::new().with_text(text)).into(),
            embeddings: embeddings(),
            lexicon: Vec::new(),
            pronouns: Vec::new(),
            table: Table::new(),
            distances: Distances::new(),
            attributes: vec![
                attribute("color", View::Color, 0),
                attribute("size", View::Brightness, 3),
            ],
            concepts: Vec::new(),
            actions: vec![action("MoveOn", "on", 0), action("MoveBeside", "beside", 1)],
            encoder: encoder(),
            object_decoder: pointer(-SURE),
            reference_decoder: pointer(SURE),
            acceptability_hidden: zero(),
            acceptability: zero(),
            nearest: superlative(None),
            farthest: superlative(Some(FARTHEST_UNIT)),
            splitter: keeper(),
            hazard_hidden: zero(),
            hazard: zero(),
            simulator: Simulator::new()
                .with_input([[0.0; SIMULATOR_HIDDEN]; 2 * LOCATION])
                .with_hidden(Dense::F32(&SIMULATED))
                .with_output(zero()),
            camera: PixelToCamera::new().with_weight([
                [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            ]),
        };
        for (name, attribute) in [
            ("red", 0),
            ("green", 0),
            ("blue", 0),
            ("small", 1),
            ("lego", 1),
        ] {
            let mut embedding = [0.0; CONCEPT];
            embedding[parts.concepts.len()] = 1.0;
            parts.lexicon.push(
                LexiconEntry::new()
                    .with_text(name)
                    .with_concept(parts.concepts.len() as u8),
            );
            parts.concepts.push(
                Concept::new()
                    .with_name(name)
                    .with_attribute(attribute)
                    .with_embedding(embedding)
                    .with_edges_m((attribute == 1).then_some(EDGES_M)),
            );
        }
        parts.lexicon.push(
            LexiconEntry::new()
                .with_text("outermost")
                .with_property(Property::Extreme(Extreme::Action(1))),
        );
        parts.lexicon.push(
            LexiconEntry::new()
                .with_text("both")
                .with_property(Property::Quantifier(Quantifier::Both)),
        );
        parts.actions[1].extreme = Some("outermost");
        parts.lexicon.sort_by_key(|entry| entry.text);
        let this = parts.words.iter().position(|word| word.text == "this");
        let this = this.map(|index| Pronoun::new().with_word(index as u16));
        parts.pronouns.extend(this);
        // Acceptable is every word at which not both directions have just seen "sideways".
        parts.acceptability_hidden.weight[SIDEWAYS_UNIT][0] = SURE;
        parts.acceptability_hidden.weight[ENCODER_HIDDEN + SIDEWAYS_UNIT][0] = SURE;
        parts.acceptability_hidden.bias[0] = -1.5 * SURE;
        parts.acceptability.weight[0] = [-SURE];
        // A step ends before a word whose share in the hazard's first hidden unit outweighs the
        // bias.
        parts.hazard_hidden.weight[SPLITTER_HIDDEN][0] = SURE;
        parts.hazard.weight[0] = [2.0 * SURE];
        parts.hazard.bias = [-SURE];
        parts
    }

    /// A word's embeddings.
    ///
    /// # Panics
    /// If the model has no such word.
    pub fn embeddings_of(&self, text: &str) -> WordEmbeddings {
        self.embeddings[1 + self.place(text)]
    }

    fn place(&self, text: &str) -> usize {
        let place = self.words.iter().position(|word| word.text == text);
        place.expect("a word of the model")
    }

    /// Adds a table, "desk", on which the action `beside` finds a place.
    pub fn add_table(&mut self) {
        let desk = LexiconEntry::new().with_text("desk");
        self.lexicon.push(desk.with_property(Property::Table));
        self.lexicon.sort_by_key(|entry| entry.text);
        self.table = Table::new()
            .with_action(0)
            .with_sides(&[1])
            .with_standing("on")
            .with_order("on the")
            .with_relation("on the");
    }

    /// Adds distances, `mm`.
    pub fn add_distances(&mut self) {
        const UNITS: [DistanceUnit<'_>; 1] = [DistanceUnit::new().with_text("mm").with_mm(1.0)];
        const SHIFTS: [DistanceShift<'_>; 1] =
            [DistanceShift::new().with_text("aside").with_action(1)];
        self.distances = Distances::new()
            .with_sides(&[1])
            .with_units(&UNITS)
            .with_shifts(&SHIFTS)
            .with_usual_mm(20);
    }

    /// Removes a word that is no pronoun.
    ///
    /// # Panics
    /// As [`Parts::embeddings_of`].
    pub fn remove_word(&mut self, text: &str) {
        let place = self.place(text);
        self.words.remove(place);
        self.embeddings.remove(1 + place);
        for pronoun in &mut self.pronouns {
            pronoun.word -= u16::from(usize::from(pronoun.word) > place);
        }
    }

    /// Adds a word that is like another one.
    ///
    /// # Panics
    /// As [`Parts::embeddings_of`].
    pub fn add_word(&mut self, text: &'static str, like: &str) {
        let embeddings = self.embeddings_of(like);
        let place = self.words.partition_point(|word| word.text < text);
        self.words.insert(place, Word::new().with_text(text));
        self.embeddings.insert(1 + place, embeddings);
        for pronoun in &mut self.pronouns {
            pronoun.word += u16::from(usize::from(pronoun.word) >= place);
        }
    }

    /// Lets the first unit of the simulator's second layer be that of the first.
    pub fn simulate_one_unit(&mut self) {
        static ONE_UNIT: Linear<SIMULATOR_HIDDEN, SIMULATOR_HIDDEN> = {
            let mut layer = zero();
            layer.weight[0][0] = SURE;
            layer
        };
        self.simulator.hidden = Dense::F32(&ONE_UNIT);
    }

    /// The model made of these parts.
    pub fn model(&self) -> Model<'_> {
        Model::new()
            .with_header(self.header)
            .with_words(&self.words)
            .with_embeddings(Embeddings::F32(&self.embeddings))
            .with_lexicon(&self.lexicon)
            .with_pronouns(&self.pronouns)
            .with_table(self.table)
            .with_distances(self.distances)
            .with_attributes(&self.attributes)
            .with_concepts(&self.concepts)
            .with_actions(&self.actions)
            .with_language(
                Language::new()
                    .with_forward(Cell::F32(&self.encoder))
                    .with_backward(Cell::F32(&self.encoder))
                    .with_object_decoder(Dense::F32(&self.object_decoder))
                    .with_reference_decoder(Dense::F32(&self.reference_decoder))
                    .with_acceptability_hidden(Dense::F32(&self.acceptability_hidden))
                    .with_acceptability(&self.acceptability)
                    .with_nearest(&self.nearest)
                    .with_farthest(&self.farthest)
                    .with_splitter(Cell::F32(&self.splitter))
                    .with_hazard_hidden(Dense::F32(&self.hazard_hidden))
                    .with_hazard(&self.hazard),
            )
            .with_vision(
                Vision::new()
                    .with_color(&COLOR)
                    .with_brightness(&BRIGHTNESS),
            )
            .with_simulator(&self.simulator)
            .with_camera(&self.camera)
    }
}

impl Default for Parts {
    fn default() -> Self {
        Self::new()
    }
}

/// A block of the hand-made domain: `color` and `size` as in [`Parts::concepts`].
#[derive(Debug, Clone, Copy)]
pub struct Block {
    /// `red`, `green` or `blue`.
    pub color: &'static str,
    /// `small` or `lego`.
    pub size: &'static str,
}

/// Shorthand for a [`Block`].
pub const fn block(size: &'static str, color: &'static str) -> Block {
    Block { color, size }
}

/// These blocks in a row, with ids from 1, not yet checked.
pub fn raw_scene(model: &Model<'_>, blocks: &[Block]) -> RawScene {
    let mut scene = RawScene::empty(model, picture::camera());
    for (id, block) in (1..).zip(blocks) {
        let left = 0.3 + 0.02 * id as f32;
        let object = ObservedObject {
            id,
            location: [left, 0.48, left + 0.015, 0.52, DEPTH_M],
            embedding: embedding(block),
        };
        scene.push(object).expect("at most MAX_OBJECTS blocks");
    }
    scene
}

/// These blocks in a row, with ids from 1.
pub fn scene(model: &Model<'_>, blocks: &[Block]) -> Scene {
    Scene::new(raw_scene(model, blocks), model).expect("the blocks stand as they should")
}

/// A 1 for the colour, a 1 for the size.
pub fn embedding(block: &Block) -> [f32; OBJECT_EMBEDDING] {
    let place = |names: &[&str], name| {
        let found = names.iter().position(|known| *known == name);
        found.expect("a value of the hand-made domain")
    };
    let mut embedding = [0.0; OBJECT_EMBEDDING];
    embedding[place(&["red", "green", "blue"], block.color)] = 1.0;
    embedding[VIEW_EMBEDDING + place(&["small", "lego"], block.size)] = 1.0;
    embedding
}

fn header() -> Header<'static> {
    Header::new()
        .with_domain("by hand")
        .with_identity([7; 32])
        .with_thresholds(Thresholds::new().with_match_score(0.5).with_decision(0.6))
        .with_work_space(
            WorkSpace::new()
                .with_min([0.3, -0.3, 0.0])
                .with_max([0.7, 0.3, 0.2]),
        )
        .with_placed_orientation([0.0, 0.0, 0.0, 1.0])
        .with_training_camera(picture::camera())
}

const WORDS: [&str; 15] = [
    ",", "and", "behind", "beside", "block", "furthest", "it", "maybe", "on", "opposite", "put",
    "sideways", "the", "then", "this",
];

/// The group's, then those of [`WORDS`].
fn embeddings() -> Vec<WordEmbeddings> {
    let mut rows = vec![silent_word(); WORDS.len() + 1];
    for (embeddings, text) in rows.iter_mut().skip(1).zip(WORDS) {
        match text {
            "on" => embeddings.encoder[ACTION_UNIT] = 1.0,
            "beside" => embeddings.encoder[ACTION_UNIT + 1] = 1.0,
            "behind" => embeddings.encoder[RELATION_UNIT] = 1.0,
            "opposite" => embeddings.encoder[RELATION_UNIT + 1] = 1.0,
            "furthest" => embeddings.encoder[FARTHEST_UNIT] = 1.0,
            "it" => embeddings.encoder[IT_UNIT] = 1.0,
            "sideways" => embeddings.encoder[SIDEWAYS_UNIT] = 1.0,
            "then" => embeddings.splitter[0] = 1.0,
            // 40·tanh(0.5583) − 20 = 0.27, of which the sigmoid is 0.57.
            "maybe" => embeddings.splitter[0] = 0.5583 / SURE,
            _ => {}
        }
    }
    rows
}

/// A word that changes nothing: all update gates keep the state.
fn silent_word() -> WordEmbeddings {
    WordEmbeddings::new()
        .with_encoder([0.0; WORD])
        .with_splitter([0.0; SPLITTER_WORD])
}

/// A cell that keeps its state, whatever the word.
fn keeper<const INPUT: usize, const HIDDEN: usize>() -> Gru<INPUT, HIDDEN> {
    Gru::new()
        .with_weight_ih([[[0.0; HIDDEN]; 3]; INPUT])
        .with_bias([[0.0; HIDDEN], [SURE; HIDDEN], [0.0; HIDDEN]])
        .with_weight_hh([[[0.0; HIDDEN]; 3]; HIDDEN])
        .with_bias_n([0.0; HIDDEN])
}

/// Sets a unit to 1 at a word whose embedding has a 1 at the same place, and those of relations to 0
/// at `on` and `beside`.
fn encoder() -> Gru<WORD, ENCODER_HIDDEN> {
    let mut cell = keeper();
    for unit in [
        ACTION_UNIT,
        ACTION_UNIT + 1,
        IT_UNIT,
        SIDEWAYS_UNIT,
        RELATION_UNIT,
        RELATION_UNIT + 1,
        FARTHEST_UNIT,
    ] {
        let [_, update, new] = &mut cell.weight_ih[unit];
        update[unit] = -2.0 * SURE;
        new[unit] = SURE;
    }
    for action in [ACTION_UNIT, ACTION_UNIT + 1] {
        let [_, update, _] = &mut cell.weight_ih[action];
        update[RELATION_UNIT] = -2.0 * SURE;
        update[RELATION_UNIT + 1] = -2.0 * SURE;
        update[FARTHEST_UNIT] = -2.0 * SURE;
    }
    cell
}

fn attribute(name: &'static str, view: View, first_concept: usize) -> Attribute<'static> {
    let mut attribute = Attribute::new()
        .with_name(name)
        .with_view(view)
        .with_hidden(zero())
        .with_output(zero());
    for (unit, column) in attribute.hidden.weight.iter_mut().enumerate() {
        column[unit] = 1.0;
    }
    for (unit, column) in attribute.output.weight.iter_mut().enumerate() {
        if let Some(concept) = column.get_mut(first_concept + unit) {
            *concept = 1.0;
        }
    }
    attribute
}

fn action(name: &'static str, phrase: &'static str, index: usize) -> Action<'static> {
    let mut decoder = [0.0; INSTRUCTION];
    decoder[ACTION_UNIT + index] = SURE;
    let mut relation_decoder = [[0.0; INSTRUCTION]; 2];
    if index == 1 {
        relation_decoder[0][RELATION_UNIT] = 2.0 * SURE;
        relation_decoder[1][RELATION_UNIT + 1] = 2.0 * SURE;
    }
    Action::new()
        .with_name(name)
        .with_phrase(phrase)
        .with_decoder(decoder)
        .with_decoder_bias(0.0)
        .with_relation_decoder(relation_decoder)
        .with_relation_bias([-SURE; 2])
        .with_simulator_bias([0.0; SIMULATOR_HIDDEN])
}

/// With the unit that says that it restricts, if any word does.
fn superlative(unit: Option<usize>) -> Superlative {
    let mut decoder = [[0.0; INSTRUCTION]; 2];
    if let Some(unit) = unit {
        decoder[0][unit] = 2.0 * SURE;
    }
    Superlative::new()
        .with_decoder(decoder)
        .with_bias([-SURE; 2])
}

/// A decoder that prefers, or avoids, descriptions after `on` and `beside`, and prefers those after
/// `it` most.
fn pointer(behind_action: f32) -> Linear<INSTRUCTION, INSTRUCTION> {
    let mut decoder = zero::<INSTRUCTION, INSTRUCTION>();
    decoder.bias[ACTION_UNIT] = behind_action;
    decoder.bias[ACTION_UNIT + 1] = behind_action;
    decoder.bias[IT_UNIT] = 3.0 * SURE;
    decoder
}

const fn zero<const INPUT: usize, const OUTPUT: usize>() -> Linear<INPUT, OUTPUT> {
    Linear::new()
        .with_weight([[0.0; OUTPUT]; INPUT])
        .with_bias([0.0; OUTPUT])
}

const fn view_encoder<const CHANNELS: usize>() -> ViewEncoder<'static, CHANNELS> {
    ViewEncoder::new()
        .with_patch(
            PatchConv::new()
                .with_weight([[[[0.0; PATCH_CHANNELS]; 4]; 4]; CHANNELS])
                .with_bias([0.0; PATCH_CHANNELS]),
        )
        .with_merge(
            MergeConv::new()
                .with_weight([[[[0.0; MERGE_CHANNELS]; PATCH_CHANNELS]; 2]; 2])
                .with_bias([0.0; MERGE_CHANNELS]),
        )
        .with_dense(Dense::F32(&DENSE))
}

#[cfg(test)]
mod tests {
    use super::{Parts, block, scene};
    use nsrm_core::Planner;

    #[test]
    fn it_is_a_valid_model_that_reads_as_described() {
        let parts = Parts::new();
        let model = parts.model();
        assert_eq!(model.check(), Ok(()));
        let blocks = [
            block("small", "red"),
            block("lego", "red"),
            block("lego", "blue"),
        ];
        let scene = scene(&model, &blocks);
        let sentence = "Put the small red block on the blue block, then put the red lego \
                        beside the small red one";
        let sentence = sentence.replace(" one", " block");
        let plan = Planner::new(&model).plan(&scene, &sentence).unwrap();
        assert_eq!(
            plan.program().notation(&model).to_string().trim(),
            "Action(MoveOn, Unique(Filter(small, Filter(red, Scene()))), \
             Unique(Filter(blue, Scene())))\n\
             Action(MoveBeside, Unique(Filter(red, Filter(lego, Scene()))), \
             Unique(Filter(small, Filter(red, Scene()))))"
        );
        let objects: Vec<_> = plan
            .steps()
            .iter()
            .map(|step| (step.object.object, step.reference.object))
            .collect();
        assert_eq!(objects, [(1, 3), (2, 1)]);
    }
}
