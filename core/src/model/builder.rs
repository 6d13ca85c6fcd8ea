//! Builders: models are built field by field, by name, so that a new field breaks nothing: earlier
//! output of nsrm-codegen still compiles.

use super::{
    ACCEPTABILITY_HIDDEN, Action, Apart, Arrangement, Arrangements, Attribute, CONCEPT, Closing,
    Compound, CompoundKind, CompoundText, Compounds, Concept, Count, CountedFrom, DistanceNumber,
    DistanceShift, DistanceUnit, Distances, ENCODER_HIDDEN, Embeddings, Exceptions, HAZARD_INPUT,
    Header, Heard, INSTRUCTION, Int8WordEmbeddings, LOCATION, Language, LexiconEntry, Lists,
    MERGE_CHANNELS, MERGED, Model, OPERATOR_HIDDEN, Opening, Ordinals, PATCH_CHANNELS,
    Perspectives, PixelToCamera, Plural, Pronoun, Ranked, Repairs, Rephrased, Rephrasing,
    SIMULATOR_HIDDEN, SPLITTER_HIDDEN, SPLITTER_WORD, Sequence, SequenceText, Several,
    Simplification, Simulator, Spelling, Standing, Superlative, Table, Taking, Thresholds,
    VIEW_EMBEDDING, View, ViewEncoder, Vision, WORD, Word, WordEmbeddings, WorkSpace,
};
use crate::camera::Camera;
use crate::dsl::{Extreme, Property};
use crate::nn::{Cell, Dense, Gru, Int8Gru, Int8Linear, Linear, MergeConv, PatchConv};

/// The value of an unset parameter. Results that depend on it are refused.
const UNSET: f32 = f32::NAN;

/// The value of an unset index, which [`Model::check`] refuses.
const NOWHERE: u8 = u8::MAX;

/// Defines `new`, which sets nothing, and a `with_` method for each field.
macro_rules! builder {
    ($([$($parameter:tt)*] $type:ty {
        $($field:ident, $with:ident: $kind:ty $(as $wrapped:path)? = $unset:expr;)*
    })*) => {$(
        impl<$($parameter)*> $type {
            const UNSET: Self = Self { $($field: $unset),* };

            /// Sets nothing: texts and lists are empty, numbers are NaN, so that an incomplete
            /// model refuses.
            #[allow(clippy::new_without_default, reason = "unset is no value to go on with")]
            pub const fn new() -> Self {
                Self::UNSET
            }

            $(
                #[doc = concat!("Sets [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub const fn $with(mut self, $field: $kind) -> Self {
                    self.$field = $($wrapped)? ($field);
                    self
                }
            )*
        }
    )*};
}

builder! {
    ['a] Model<'a> {
        header, with_header: Header<'a> = Header::UNSET;
        words, with_words: &'a [Word<'a>] = &[];
        embeddings, with_embeddings: Embeddings<'a> = Embeddings::NONE;
        lexicon, with_lexicon: &'a [LexiconEntry<'a>] = &[];
        pronouns, with_pronouns: &'a [Pronoun] = &[];
        placing, with_placing: &'a [u16] = &[];
        conjunctions, with_conjunctions: &'a [&'a str] = &[];
        several, with_several: Several<'a> = Several::UNSET;
        rephrasing, with_rephrasing: Rephrasing<'a> = Rephrasing::UNSET;
        simplification, with_simplification: Simplification<'a> = Simplification::UNSET;
        perspectives, with_perspectives: Perspectives<'a> = Perspectives::UNSET;
        exceptions, with_exceptions: Exceptions<'a> = Exceptions::UNSET;
        lists, with_lists: Lists<'a> = Lists::UNSET;
        repairs, with_repairs: Repairs<'a> = Repairs::UNSET;
        sequence, with_sequence: Sequence<'a> = Sequence::UNSET;
        distances, with_distances: Distances<'a> = Distances::UNSET;
        apart, with_apart: Apart<'a> = Apart::UNSET;
        ordinals, with_ordinals: Ordinals<'a> = Ordinals::UNSET;
        arrangements, with_arrangements: Arrangements<'a> = Arrangements::UNSET;
        table, with_table: Table<'a> = Table::UNSET;
        spelling, with_spelling: Spelling<'a> = Spelling::UNSET;
        attributes, with_attributes: &'a [Attribute<'a>] = &[];
        concepts, with_concepts: &'a [Concept<'a>] = &[];
        actions, with_actions: &'a [Action<'a>] = &[];
        compounds, with_compounds: Compounds<'a> = Compounds::UNSET;
        language, with_language: Language<'a> = Language::UNSET;
        vision, with_vision: Vision<'a> as Some = None;
        simulator, with_simulator: &'a Simulator<'a> = &Simulator::UNSET;
        camera, with_camera: &'a PixelToCamera = &PixelToCamera::UNSET;
    }
    ['a] Header<'a> {
        domain, with_domain: &'a str = "";
        identity, with_identity: [u8; 32] = [0; 32];
        thresholds, with_thresholds: Thresholds = Thresholds::UNSET;
        work_space, with_work_space: WorkSpace = WorkSpace::UNSET;
        placed_orientation, with_placed_orientation: [f32; 4] = [UNSET; 4];
        training_camera, with_training_camera: Camera = Camera::UNSET;
    }
    [] Camera {
        width, with_width: u32 = 0;
        height, with_height: u32 = 0;
        fx, with_fx: f32 = UNSET;
        fy, with_fy: f32 = UNSET;
        cx, with_cx: f32 = UNSET;
        cy, with_cy: f32 = UNSET;
        position, with_position: [f32; 3] = [UNSET; 3];
        orientation, with_orientation: [f32; 4] = [UNSET; 4];
    }
    [] Thresholds {
        match_score, with_match_score: f32 = UNSET;
        decision, with_decision: f32 = UNSET;
        // Files of models that nobody calibrated have none.
        confidence, with_confidence: f32 = 0.0;
    }
    [] WorkSpace {
        min, with_min: [f32; 3] = [UNSET; 3];
        max, with_max: [f32; 3] = [UNSET; 3];
    }
    ['a] Word<'a> {
        text, with_text: &'a str = "";
    }
    [] Pronoun {
        word, with_word: u16 = u16::MAX;
        owner, with_owner: Option<u16> = None;
    }
    ['a] Several<'a> {
        between, with_between: &'a [u16] = &[];
        plurals, with_plurals: &'a [Plural<'a>] = &[];
    }
    ['a] Plural<'a> {
        text, with_text: &'a str = "";
        word, with_word: u16 = u16::MAX;
    }
    ['a] Apart<'a> {
        between, with_between: &'a [&'a str] = &[];
        phrases, with_phrases: &'a [&'a str] = &[];
    }
    ['a] Arrangements<'a> {
        between, with_between: &'a [&'a str] = &[];
        ends, with_ends: &'a [&'a str] = &[];
        next, with_next: &'a str = "";
        arrangements, with_arrangements: &'a [Arrangement<'a>] = &[];
        openings, with_openings: &'a [Opening<'a>] = &[];
        closings, with_closings: &'a [Closing<'a>] = &[];
    }
    ['a] Arrangement<'a> {
        order, with_order: &'a str = "";
        relation, with_relation: &'a str = "";
        is_reversed, with_is_reversed: bool = false;
    }
    ['a] Opening<'a> {
        text, with_text: &'a str = "";
        pattern, with_pattern: u8 = NOWHERE;
    }
    ['a] Closing<'a> {
        text, with_text: &'a str = "";
        pattern, with_pattern: u8 = NOWHERE;
        arrangement, with_arrangement: u8 = NOWHERE;
    }
    ['a] Rephrasing<'a> {
        said, with_said: &'a [Rephrased<'a>] = &[];
        first_words, with_first_words: &'a [&'a str] = &[];
    }
    ['a] Rephrased<'a> {
        text, with_text: &'a str = "";
        read_as, with_read_as: &'a str = "";
    }
    ['a] Simplification<'a> {
        opening, with_opening: Rephrasing<'a> = Rephrasing::UNSET;
        anywhere, with_anywhere: Rephrasing<'a> = Rephrasing::UNSET;
        closing, with_closing: Rephrasing<'a> = Rephrasing::UNSET;
        connecting, with_connecting: Rephrasing<'a> = Rephrasing::UNSET;
        starting, with_starting: &'a [&'a str] = &[];
        taking, with_taking: Taking<'a> = Taking::UNSET;
        standing, with_standing: Standing<'a> = Standing::UNSET;
    }
    ['a] Standing<'a> {
        clauses, with_clauses: &'a [&'a str] = &[];
        relations, with_relations: &'a [&'a str] = &[];
        read_as, with_read_as: &'a str = "";
    }
    ['a] Taking<'a> {
        words, with_words: &'a [&'a str] = &[];
        towards, with_towards: &'a [&'a str] = &[];
        order, with_order: &'a str = "";
        object, with_object: &'a str = "";
    }
    ['a] Perspectives<'a> {
        own, with_own: &'a [&'a str] = &[];
        other, with_other: &'a [&'a str] = &[];
        first_words, with_first_words: &'a [&'a str] = &[];
        opposites, with_opposites: &'a [u8] = &[];
    }
    ['a] Exceptions<'a> {
        phrases, with_phrases: &'a [&'a str] = &[];
        negations, with_negations: &'a [&'a str] = &[];
    }
    ['a] Lists<'a> {
        between, with_between: &'a [&'a str] = &[];
        them, with_them: &'a [&'a str] = &[];
        stacking, with_stacking: &'a [&'a str] = &[];
        aside, with_aside: &'a [&'a str] = &[];
        next, with_next: &'a str = "";
    }
    ['a] Repairs<'a> {
        corrections, with_corrections: &'a [&'a str] = &[];
        exclusions, with_exclusions: &'a [&'a str] = &[];
    }
    ['a] Sequence<'a> {
        later, with_later: &'a [SequenceText<'a>] = &[];
        earlier, with_earlier: &'a [SequenceText<'a>] = &[];
        first_words, with_first_words: &'a [&'a str] = &[];
        next, with_next: &'a str = "";
    }
    ['a] SequenceText<'a> {
        text, with_text: &'a str = "";
        read_as, with_read_as: &'a str = "";
        is_afterthought, with_is_afterthought: bool = false;
    }
    ['a] Distances<'a> {
        sides, with_sides: &'a [u8] = &[];
        units, with_units: &'a [DistanceUnit<'a>] = &[];
        numbers, with_numbers: &'a [DistanceNumber<'a>] = &[];
        before, with_before: &'a [&'a str] = &[];
        behind, with_behind: &'a [&'a str] = &[];
        from, with_from: &'a [&'a str] = &[];
        beside, with_beside: &'a str = "";
        unless, with_unless: &'a [&'a str] = &[];
        shifts, with_shifts: &'a [DistanceShift<'a>] = &[];
        origins, with_origins: &'a [&'a str] = &[];
        usual_mm, with_usual_mm: u16 = 0;
    }
    ['a] DistanceUnit<'a> {
        text, with_text: &'a str = "";
        mm, with_mm: f32 = 0.0;
    }
    ['a] DistanceShift<'a> {
        text, with_text: &'a str = "";
        action, with_action: u8 = NOWHERE;
    }
    ['a] DistanceNumber<'a> {
        text, with_text: &'a str = "";
        value, with_value: f32 = 0.0;
    }
    ['a] Table<'a> {
        action, with_action: u8 = NOWHERE;
        sides, with_sides: &'a [u8] = &[];
        off, with_off: &'a [&'a str] = &[];
        sources, with_sources: &'a [&'a str] = &[];
        unless, with_unless: &'a [&'a str] = &[];
        removing, with_removing: &'a [&'a str] = &[];
        taking, with_taking: &'a str = "";
        standing, with_standing: &'a str = "";
        order, with_order: &'a str = "";
        down, with_down: &'a [&'a str] = &[];
        relation, with_relation: &'a str = "";
    }
    ['a] Spelling<'a> {
        heard, with_heard: &'a [Heard<'a>] = &[];
        other_words, with_other_words: &'a [u16] = &[];
    }
    ['a] Heard<'a> {
        text, with_text: &'a str = "";
        read_as, with_read_as: &'a str = "";
    }
    [] WordEmbeddings {
        encoder, with_encoder: [f32; WORD] = [UNSET; WORD];
        splitter, with_splitter: [f32; SPLITTER_WORD] = [UNSET; SPLITTER_WORD];
    }
    [] Int8WordEmbeddings {
        encoder, with_encoder: [i8; WORD] = [0; WORD];
        encoder_scale, with_encoder_scale: f32 = UNSET;
        splitter, with_splitter: [i8; SPLITTER_WORD] = [0; SPLITTER_WORD];
        splitter_scale, with_splitter_scale: f32 = UNSET;
    }
    ['a] LexiconEntry<'a> {
        text, with_text: &'a str = "";
        property, with_property: Property = Property::Concept(NOWHERE);
    }
    ['a] Attribute<'a> {
        name, with_name: &'a str = "";
        view, with_view: View = View::Color;
        hidden, with_hidden: Linear<VIEW_EMBEDDING, OPERATOR_HIDDEN> = Linear::UNSET;
        output, with_output: Linear<OPERATOR_HIDDEN, CONCEPT> = Linear::UNSET;
    }
    ['a] Concept<'a> {
        name, with_name: &'a str = "";
        attribute, with_attribute: u8 = NOWHERE;
        embedding, with_embedding: [f32; CONCEPT] = [UNSET; CONCEPT];
        edges_m, with_edges_m: Option<[f32; 3]> = None;
    }
    ['a] Action<'a> {
        name, with_name: &'a str = "";
        phrase, with_phrase: &'a str = "";
        extreme, with_extreme: Option<&'a str> = None;
        decoder, with_decoder: [f32; INSTRUCTION] = [UNSET; INSTRUCTION];
        decoder_bias, with_decoder_bias: f32 = UNSET;
        relation_decoder, with_relation_decoder: [[f32; INSTRUCTION]; 2] =
            [[UNSET; INSTRUCTION]; 2];
        relation_bias, with_relation_bias: [f32; 2] = [UNSET; 2];
        simulator_bias, with_simulator_bias: [f32; SIMULATOR_HIDDEN] = [UNSET; SIMULATOR_HIDDEN];
    }
    ['a] Ordinals<'a> {
        ranked, with_ranked: &'a [Ranked<'a>] = &[];
        counts, with_counts: &'a [Count<'a>] = &[];
        from, with_from: &'a [CountedFrom<'a>] = &[];
        first_words, with_first_words: &'a [&'a str] = &[];
        articles, with_articles: &'a [&'a str] = &[];
        nouns, with_nouns: &'a [&'a str] = &[];
        unless, with_unless: &'a [&'a str] = &[];
    }
    ['a] Ranked<'a> {
        name, with_name: &'a str = "";
        extreme, with_extreme: Extreme = Extreme::Action(NOWHERE);
        rank, with_rank: u8 = NOWHERE;
    }
    ['a] Count<'a> {
        text, with_text: &'a str = "";
        rank, with_rank: u8 = NOWHERE;
    }
    ['a] CountedFrom<'a> {
        text, with_text: &'a str = "";
        extreme, with_extreme: Extreme = Extreme::Action(NOWHERE);
        is_first, with_is_first: bool = false;
    }
    ['a] Compounds<'a> {
        compounds, with_compounds: &'a [Compound<'a>] = &[];
        said, with_said: &'a [CompoundText<'a>] = &[];
        first_words, with_first_words: &'a [&'a str] = &[];
        sides, with_sides: &'a [&'a str] = &[];
    }
    ['a] CompoundText<'a> {
        text, with_text: &'a str = "";
        compound, with_compound: u8 = NOWHERE;
    }
    ['a] Compound<'a> {
        name, with_name: &'a str = "";
        phrase, with_phrase: &'a str = "";
        kind, with_kind: CompoundKind = CompoundKind::Any;
        parts, with_parts: &'a [u8] = &[];
        read, with_read: &'a str = "";
    }
    [] Superlative {
        decoder, with_decoder: [[f32; INSTRUCTION]; 2] = [[UNSET; INSTRUCTION]; 2];
        bias, with_bias: [f32; 2] = [UNSET; 2];
    }
    ['a] Language<'a> {
        forward, with_forward: Cell<'a, WORD, ENCODER_HIDDEN> = Cell::UNSET;
        backward, with_backward: Cell<'a, WORD, ENCODER_HIDDEN> = Cell::UNSET;
        object_decoder, with_object_decoder: Dense<'a, INSTRUCTION, INSTRUCTION> = Dense::UNSET;
        reference_decoder, with_reference_decoder: Dense<'a, INSTRUCTION, INSTRUCTION> =
            Dense::UNSET;
        acceptability_hidden, with_acceptability_hidden:
            Dense<'a, INSTRUCTION, ACCEPTABILITY_HIDDEN> = Dense::UNSET;
        acceptability, with_acceptability: &'a Linear<ACCEPTABILITY_HIDDEN, 1> = &Linear::UNSET;
        nearest, with_nearest: &'a Superlative = &Superlative::UNSET;
        farthest, with_farthest: &'a Superlative = &Superlative::UNSET;
        splitter, with_splitter: Cell<'a, SPLITTER_WORD, SPLITTER_HIDDEN> = Cell::UNSET;
        hazard_hidden, with_hazard_hidden: Dense<'a, HAZARD_INPUT, SPLITTER_HIDDEN> = Dense::UNSET;
        hazard, with_hazard: &'a Linear<SPLITTER_HIDDEN, 1> = &Linear::UNSET;
    }
    ['a] Vision<'a> {
        color, with_color: &'a ViewEncoder<'a, 3> = &ViewEncoder::UNSET;
        brightness, with_brightness: &'a ViewEncoder<'a, 1> = &ViewEncoder::UNSET;
    }
    ['a, const CHANNELS: usize] ViewEncoder<'a, CHANNELS> {
        patch, with_patch: PatchConv<CHANNELS, PATCH_CHANNELS> = PatchConv::UNSET;
        merge, with_merge: MergeConv<PATCH_CHANNELS, MERGE_CHANNELS> = MergeConv::UNSET;
        dense, with_dense: Dense<'a, MERGED, VIEW_EMBEDDING> = Dense::UNSET;
    }
    ['a] Simulator<'a> {
        input, with_input: [[f32; SIMULATOR_HIDDEN]; 2 * LOCATION] =
            [[UNSET; SIMULATOR_HIDDEN]; 2 * LOCATION];
        hidden, with_hidden: Dense<'a, SIMULATOR_HIDDEN, SIMULATOR_HIDDEN> = Dense::UNSET;
        output, with_output: Linear<SIMULATOR_HIDDEN, LOCATION> = Linear::UNSET;
    }
    [] PixelToCamera {
        weight, with_weight: [[f32; 6]; 3] = [[UNSET; 6]; 3];
    }
    [const INPUT: usize, const OUTPUT: usize] Linear<INPUT, OUTPUT> {
        weight, with_weight: [[f32; OUTPUT]; INPUT] = [[UNSET; OUTPUT]; INPUT];
        bias, with_bias: [f32; OUTPUT] = [UNSET; OUTPUT];
    }
    [const INPUT: usize, const OUTPUT: usize] PatchConv<INPUT, OUTPUT> {
        weight, with_weight: [[[[f32; OUTPUT]; 4]; 4]; INPUT] = [[[[UNSET; OUTPUT]; 4]; 4]; INPUT];
        bias, with_bias: [f32; OUTPUT] = [UNSET; OUTPUT];
    }
    [const INPUT: usize, const OUTPUT: usize] MergeConv<INPUT, OUTPUT> {
        weight, with_weight: [[[[f32; OUTPUT]; INPUT]; 2]; 2] = [[[[UNSET; OUTPUT]; INPUT]; 2]; 2];
        bias, with_bias: [f32; OUTPUT] = [UNSET; OUTPUT];
    }
    [const INPUT: usize, const HIDDEN: usize] Gru<INPUT, HIDDEN> {
        weight_ih, with_weight_ih: [[[f32; HIDDEN]; 3]; INPUT] = [[[UNSET; HIDDEN]; 3]; INPUT];
        bias, with_bias: [[f32; HIDDEN]; 3] = [[UNSET; HIDDEN]; 3];
        weight_hh, with_weight_hh: [[[f32; HIDDEN]; 3]; HIDDEN] = [[[UNSET; HIDDEN]; 3]; HIDDEN];
        bias_n, with_bias_n: [f32; HIDDEN] = [UNSET; HIDDEN];
    }
    [const INPUT: usize, const OUTPUT: usize] Int8Linear<INPUT, OUTPUT> {
        weight, with_weight: [[i8; INPUT]; OUTPUT] = [[0; INPUT]; OUTPUT];
        scale, with_scale: [f32; OUTPUT] = [UNSET; OUTPUT];
        bias, with_bias: [f32; OUTPUT] = [UNSET; OUTPUT];
    }
    [const INPUT: usize, const HIDDEN: usize] Int8Gru<INPUT, HIDDEN> {
        weight_ih, with_weight_ih: [[[i8; INPUT]; HIDDEN]; 3] = [[[0; INPUT]; HIDDEN]; 3];
        scale_ih, with_scale_ih: [[f32; HIDDEN]; 3] = [[UNSET; HIDDEN]; 3];
        bias, with_bias: [[f32; HIDDEN]; 3] = [[UNSET; HIDDEN]; 3];
        weight_hh, with_weight_hh: [[[i8; HIDDEN]; HIDDEN]; 3] = [[[0; HIDDEN]; HIDDEN]; 3];
        scale_hh, with_scale_hh: [[f32; HIDDEN]; 3] = [[UNSET; HIDDEN]; 3];
        bias_n, with_bias_n: [f32; HIDDEN] = [UNSET; HIDDEN];
    }
}

impl<const INPUT: usize, const OUTPUT: usize> Dense<'_, INPUT, OUTPUT> {
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    const UNSET: Self = Self::F32(&Linear::UNSET);
    #[cfg(all(feature = "int8", not(feature = "f32")))]
    const UNSET: Self = Self::Int8(&Int8Linear::UNSET);
}

impl<const INPUT: usize, const HIDDEN: usize> Cell<'_, INPUT, HIDDEN> {
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    const UNSET: Self = Self::F32(&Gru::UNSET);
    #[cfg(all(feature = "int8", not(feature = "f32")))]
    const UNSET: Self = Self::Int8(&Int8Gru::UNSET);
}

impl LexiconEntry<'_> {
    /// Sets [`property`](Self::property) to the concept with this index.
    #[must_use]
    pub const fn with_concept(self, concept: u8) -> Self {
        self.with_property(Property::Concept(concept))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Header, Model, ModelFault};
    use crate::camera::CameraError;
    use crate::nn::Linear;
    use crate::{Planner, Refusal, fixture};

    #[test]
    fn a_model_in_which_nothing_is_set_is_refused() {
        assert_eq!(Model::new().check(), Err(ModelFault::Empty("words")));
        let model = fixture::model();
        let header = |header| model.with_header(header).check();
        let unset = Header::new();
        assert_eq!(header(unset), Err(ModelFault::Threshold));
        let unset = unset.with_thresholds(model.header.thresholds);
        assert_eq!(header(unset), Err(ModelFault::WorkSpace));
        let unset = unset.with_work_space(model.header.work_space);
        assert_eq!(header(unset), Err(ModelFault::PlacedOrientation));
        let unset = unset.with_placed_orientation(model.header.placed_orientation);
        let camera = ModelFault::TrainingCamera(CameraError::NotFinite("fx"));
        assert_eq!(header(unset), Err(camera));
        let set = unset.with_training_camera(model.header.training_camera);
        assert_eq!(header(set), Ok(()));
    }

    #[test]
    fn what_rests_on_a_parameter_that_is_not_set_is_refused() {
        let model = fixture::model();
        let scene = fixture::scene(&model);
        let plan = |model| Planner::new(&model).plan(&scene, "put small red on green");
        assert!(plan(model).is_ok());
        let unset = Model::new();
        let language = model.language;
        for broken in [
            model.with_simulator(unset.simulator),
            model.with_language(language.with_forward(unset.language.forward)),
            model.with_language(language.with_object_decoder(unset.language.object_decoder)),
            model.with_language(language.with_acceptability(unset.language.acceptability)),
            model.with_language(language.with_nearest(unset.language.nearest)),
            model.with_language(language.with_splitter(unset.language.splitter)),
            model.with_language(language.with_hazard(unset.language.hazard)),
        ] {
            let refusal = plan(broken).unwrap_err();
            assert!(matches!(refusal, Refusal::NotFinite { .. }), "{refusal:?}");
        }
        let refusal = plan(model.with_camera(unset.camera)).unwrap_err();
        assert!(matches!(refusal, Refusal::Calibration(_)), "{refusal:?}");
    }

    #[test]
    fn parts_are_set_by_name_also_in_statics() {
        static LAYER: Linear<2, 1> = Linear::new()
            .with_bias([1.0])
            .with_weight([[10.0], [100.0]]);
        assert_eq!(LAYER.apply(&[2.0, 3.0]), [321.0]);
    }
}
