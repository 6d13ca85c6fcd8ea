//! A model that owns its parameters and texts.

mod distances;
mod rewriting;

use nsrm_core::model::{
    Action, Apart, Attribute, Concept, Embeddings, Exceptions, Header, Heard, Language,
    LexiconEntry, MERGED, Model, Plural, Pronoun, Repairs, Several, Simulator, Spelling,
    VIEW_EMBEDDING, View, ViewEncoder, Vision, Word,
};
use nsrm_core::nn::{Cell, Dense, Gru, Int8Gru, Int8Linear, Linear, Precision};
use safetensors::SafeTensors;
use self_cell::self_cell;
use sha2::{Digest, Sha256};

use crate::domain::{self, Domain};
use crate::error::ModelError;
use crate::fold::{Folded, FoldedView};
use crate::hash;
use crate::metadata::{self, Metadata};
use crate::rounded::Rounded;
use crate::tensors::Tensors;
use distances::DistanceParts;
use rewriting::{
    ArrangementParts, CompoundParts, ListParts, OrdinalParts, PerspectiveParts, RephrasingParts,
    SequenceParts, SimplificationParts, TableParts,
};

/// A model read from a safetensors file, checked and folded.
///
/// It has the same values as the statics that [`crate::rust_source`] writes from that file, and
/// borrows them as the same type.
pub struct OwnedModel {
    parts: OwnedParts,
    source_hash: [u8; 32],
    training: serde_json::Value,
    metrics: serde_json::Value,
}

/// The texts and parameters that the named structs borrow from.
struct Owner {
    domain: Domain,
    vocabulary: Vec<String>,
    /// The actions of which each compound is made.
    compound_parts: Vec<Vec<u8>>,
    /// What can be counted.
    ranked: Vec<domain::Ranked>,
    folded: Folded,
    /// With a precision of eight bits.
    rounded: Option<Box<Rounded>>,
    identity: [u8; 32],
}

/// What core reads as slices: parameters next to their names.
struct Parts<'a> {
    header: Header<'a>,
    words: Vec<Word<'a>>,
    lexicon: Vec<LexiconEntry<'a>>,
    pronouns: Vec<Pronoun>,
    placing: Vec<u16>,
    conjunctions: Vec<&'a str>,
    between: Vec<u16>,
    plurals: Vec<Plural<'a>>,
    rephrasing: RephrasingParts<'a>,
    simplification: SimplificationParts<'a>,
    exceptions: [Vec<&'a str>; 2],
    perspectives: PerspectiveParts<'a>,
    lists: ListParts<'a>,
    repairs: [Vec<&'a str>; 2],
    sequence: SequenceParts<'a>,
    distances: DistanceParts<'a>,
    apart: [Vec<&'a str>; 2],
    ordinals: OrdinalParts<'a>,
    arrangements: ArrangementParts<'a>,
    table: TableParts<'a>,
    compounds: CompoundParts<'a>,
    heard: Vec<Heard<'a>>,
    other_words: Vec<u16>,
    attributes: Vec<Attribute<'a>>,
    concepts: Vec<Concept<'a>>,
    actions: Vec<Action<'a>>,
    color: Box<ViewEncoder<'a, 3>>,
    brightness: Box<ViewEncoder<'a, 1>>,
    simulator: Simulator<'a>,
    folded: &'a Folded,
    rounded: Option<&'a Rounded>,
}

self_cell!(
    struct OwnedParts {
        owner: Owner,

        #[covariant]
        dependent: Parts,
    }
);

impl OwnedModel {
    /// Reads, checks and folds a model file.
    ///
    /// # Errors
    /// A [`ModelError`] if anything does not match the architecture, the domain in the file or the
    /// metadata's hash. It never panics.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        Self::from_bytes_as(bytes, Precision::F32)
    }

    /// Reads, checks and folds a model file, and rounds its weights to a precision. The file's own
    /// are `f32`, whatever the precision.
    ///
    /// # Errors
    /// As [`OwnedModel::from_bytes`].
    pub fn from_bytes_as(bytes: &[u8], precision: Precision) -> Result<Self, ModelError> {
        let not_safetensors = |error: safetensors::SafeTensorError| ModelError::NotSafetensors {
            reason: error.to_string(),
        };
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(not_safetensors)?;
        let file = SafeTensors::deserialize(bytes).map_err(not_safetensors)?;
        let entries = header.metadata().clone().unwrap_or_default();
        metadata::check_schema(&entries)?;
        // First, before possibly modified content is used.
        hash::verify(&file, &entries)?;
        let metadata = Metadata::read(&entries)?;
        let folded = Folded::read(Tensors::read(&file)?, &metadata)?;
        let Metadata {
            domain,
            vocabulary,
            thresholds,
            work_space,
            placed_orientation,
            training_camera,
            training,
            metrics,
        } = metadata;
        let rounded = (precision == Precision::Int8).then(|| Box::new(Rounded::of(&folded)));
        let owner = Owner {
            compound_parts: domain.compound_parts()?,
            ranked: domain.ranked(),
            domain,
            vocabulary,
            folded,
            rounded,
            identity: hash::identity(&file, &entries),
        };
        let parts = OwnedParts::try_new(owner, |owner| {
            Parts::new(owner, |domain| {
                Header::new()
                    .with_domain(domain)
                    .with_identity(owner.identity)
                    .with_thresholds(thresholds)
                    .with_work_space(work_space)
                    .with_placed_orientation(placed_orientation)
                    .with_training_camera(training_camera)
            })
        })?;
        Ok(Self {
            parts,
            source_hash: Sha256::digest(bytes).into(),
            training,
            metrics,
        })
    }

    /// The model as core reads it.
    pub fn as_model(&self) -> Model<'_> {
        let parts = self.parts.borrow_dependent();
        let folded = parts.folded;
        Model::new()
            .with_header(parts.header)
            .with_words(&parts.words)
            .with_embeddings(parts.embeddings())
            .with_lexicon(&parts.lexicon)
            .with_pronouns(&parts.pronouns)
            .with_placing(&parts.placing)
            .with_conjunctions(&parts.conjunctions)
            .with_several(
                Several::new()
                    .with_between(&parts.between)
                    .with_plurals(&parts.plurals),
            )
            .with_rephrasing(parts.rephrasing.lent())
            .with_simplification(parts.simplification.lent())
            .with_exceptions(
                Exceptions::new()
                    .with_phrases(&parts.exceptions[0])
                    .with_negations(&parts.exceptions[1]),
            )
            .with_perspectives(parts.perspectives.lent())
            .with_lists(parts.lists.lent())
            .with_repairs(
                Repairs::new()
                    .with_corrections(&parts.repairs[0])
                    .with_exclusions(&parts.repairs[1]),
            )
            .with_sequence(parts.sequence.lent())
            .with_distances(parts.distances.lent())
            .with_apart(
                Apart::new()
                    .with_between(&parts.apart[0])
                    .with_phrases(&parts.apart[1]),
            )
            .with_ordinals(parts.ordinals.lent())
            .with_arrangements(parts.arrangements.lent())
            .with_table(parts.table.lent())
            .with_spelling(
                Spelling::new()
                    .with_heard(&parts.heard)
                    .with_other_words(&parts.other_words),
            )
            .with_attributes(&parts.attributes)
            .with_concepts(&parts.concepts)
            .with_actions(&parts.actions)
            .with_compounds(parts.compounds.lent())
            .with_language(parts.language())
            .with_vision(
                Vision::new()
                    .with_color(&parts.color)
                    .with_brightness(&parts.brightness),
            )
            .with_simulator(&parts.simulator)
            .with_camera(&folded.camera)
    }

    /// The domain of its training.
    pub fn domain(&self) -> &Domain {
        &self.parts.borrow_owner().domain
    }

    /// SHA-256 of the whole file, metadata included.
    pub fn source_hash(&self) -> [u8; 32] {
        self.source_hash
    }

    /// Its training, as written by the trainer.
    pub fn training(&self) -> &serde_json::Value {
        &self.training
    }

    /// Its metrics on test data, as written by the trainer.
    pub fn metrics(&self) -> &serde_json::Value {
        &self.metrics
    }
}

impl std::fmt::Debug for OwnedModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OwnedModel")
            .field("header", &self.as_model().header)
            .finish_non_exhaustive()
    }
}

impl<'a> Parts<'a> {
    fn new(
        owner: &'a Owner,
        header: impl FnOnce(&'a str) -> Header<'a>,
    ) -> Result<Self, ModelError> {
        let domain = &owner.domain;
        let folded = &owner.folded;
        let rounded = owner.rounded.as_deref();
        let words = owner.vocabulary.iter().skip(1);
        let mut lexicon: Vec<LexiconEntry<'a>> = domain
            .lexicon()
            .map(|(text, concept)| {
                let concept = index("concepts", concept)?;
                Ok(LexiconEntry::new().with_text(text).with_concept(concept))
            })
            .chain(domain.choices().map(|(text, property)| {
                Ok(LexiconEntry::new().with_text(text).with_property(property))
            }))
            .collect::<Result<_, ModelError>>()?;
        lexicon.sort_unstable_by_key(|entry| entry.text);
        Ok(Self {
            header: header(&domain.name),
            words: words.map(|text| Word::new().with_text(text)).collect(),
            lexicon,
            pronouns: pronouns(owner)?,
            placing: placing(owner)?,
            conjunctions: domain.conjunctions.iter().map(String::as_str).collect(),
            between: (domain.several.between.iter())
                .map(|text| word_index(owner, text))
                .collect::<Result<_, ModelError>>()?,
            plurals: (domain.several.plurals.iter())
                .map(|(text, singular)| {
                    let word = word_index(owner, singular)?;
                    Ok(Plural::new().with_text(text).with_word(word))
                })
                .collect::<Result<_, ModelError>>()?,
            rephrasing: RephrasingParts::new(&domain.rephrasing),
            simplification: SimplificationParts::new(domain),
            exceptions: [&domain.exceptions.phrases, &domain.exceptions.negations]
                .map(|texts| texts.iter().map(String::as_str).collect()),
            perspectives: PerspectiveParts::new(domain)?,
            lists: ListParts::new(&domain.lists),
            repairs: [&domain.repairs.corrections, &domain.repairs.exclusions]
                .map(|texts| texts.iter().map(String::as_str).collect()),
            sequence: SequenceParts::new(domain),
            distances: DistanceParts::new(domain)?,
            apart: [&domain.apart.between, &domain.apart.phrases]
                .map(|texts| texts.iter().map(String::as_str).collect()),
            ordinals: OrdinalParts::new(domain, &owner.ranked)?,
            arrangements: ArrangementParts::new(&domain.arrangements)?,
            table: TableParts::new(domain)?,
            compounds: CompoundParts::new(domain, &owner.compound_parts)?,
            heard: domain
                .spelling
                .heard
                .iter()
                .map(|(text, read_as)| Heard::new().with_text(text).with_read_as(read_as))
                .collect(),
            other_words: domain.spelling.hashes().into_iter().collect(),
            attributes: domain
                .attribute
                .iter()
                .zip(&folded.vision.operators)
                .map(|(attribute, operator)| {
                    Attribute::new()
                        .with_name(&attribute.name)
                        .with_view(match attribute.view {
                            domain::View::Color => View::Color,
                            domain::View::Brightness => View::Brightness,
                        })
                        .with_hidden(operator.hidden)
                        .with_output(operator.output)
                })
                .collect(),
            concepts: domain
                .concepts()
                .zip(&folded.vision.concepts)
                .map(|((attribute, value), &embedding)| {
                    Ok(Concept::new()
                        .with_name(&value.name)
                        .with_attribute(index("attribute types", attribute)?)
                        .with_embedding(embedding)
                        .with_edges_m(value.edges_m))
                })
                .collect::<Result<_, ModelError>>()?,
            actions: domain
                .action
                .iter()
                .zip(&folded.actions.actions)
                .map(|(action, parameters)| {
                    Action::new()
                        .with_name(&action.name)
                        .with_phrase(action.phrases.first().map_or("", String::as_str))
                        .with_extreme(extreme(domain, action))
                        .with_decoder(parameters.decoder)
                        .with_decoder_bias(parameters.decoder_bias)
                        .with_relation_decoder(parameters.relation_decoder)
                        .with_relation_bias(parameters.relation_bias)
                        .with_simulator_bias(parameters.simulator_bias)
                })
                .collect(),
            color: view(&folded.vision.color, rounded.map(|own| &own.color_dense)),
            brightness: view(
                &folded.vision.brightness,
                rounded.map(|own| &own.brightness_dense),
            ),
            simulator: Simulator::new()
                .with_input(folded.actions.simulator.input)
                .with_hidden(dense(
                    &folded.actions.simulator.hidden,
                    rounded.map(|own| &own.simulator_hidden),
                ))
                .with_output(folded.actions.simulator.output),
            folded,
            rounded,
        })
    }

    fn embeddings(&self) -> Embeddings<'_> {
        match self.rounded {
            None => Embeddings::F32(&self.folded.language.words),
            Some(rounded) => Embeddings::Int8(&rounded.words),
        }
    }

    fn language(&self) -> Language<'_> {
        let (language, actions) = (&self.folded.language, &self.folded.actions);
        let rounded = self.rounded;
        Language::new()
            .with_forward(cell(&language.forward, rounded.map(|own| &own.forward)))
            .with_backward(cell(&language.backward, rounded.map(|own| &own.backward)))
            .with_object_decoder(dense(
                &language.object_decoder,
                rounded.map(|own| &own.object_decoder),
            ))
            .with_reference_decoder(dense(
                &language.reference_decoder,
                rounded.map(|own| &own.reference_decoder),
            ))
            .with_acceptability_hidden(dense(
                &language.acceptability_hidden,
                rounded.map(|own| &own.acceptability_hidden),
            ))
            .with_acceptability(&language.acceptability)
            .with_nearest(&actions.nearest)
            .with_farthest(&actions.farthest)
            .with_splitter(cell(&language.splitter, rounded.map(|own| &own.splitter)))
            .with_hazard_hidden(dense(
                &language.hazard_hidden,
                rounded.map(|own| &own.hazard_hidden),
            ))
            .with_hazard(&language.hazard)
    }
}

/// A layer with rounded weights, if there are any.
fn dense<'a, const INPUT: usize, const OUTPUT: usize>(
    layer: &'a Linear<INPUT, OUTPUT>,
    rounded: Option<&'a Int8Linear<INPUT, OUTPUT>>,
) -> Dense<'a, INPUT, OUTPUT> {
    rounded.map_or(Dense::F32(layer), Dense::Int8)
}

/// As [`dense`].
fn cell<'a, const INPUT: usize, const HIDDEN: usize>(
    cell: &'a Gru<INPUT, HIDDEN>,
    rounded: Option<&'a Int8Gru<INPUT, HIDDEN>>,
) -> Cell<'a, INPUT, HIDDEN> {
    rounded.map_or(Cell::F32(cell), Cell::Int8)
}

fn view<'a, const CHANNELS: usize>(
    view: &'a FoldedView<CHANNELS>,
    rounded: Option<&'a Int8Linear<MERGED, VIEW_EMBEDDING>>,
) -> Box<ViewEncoder<'a, CHANNELS>> {
    Box::new(
        ViewEncoder::new()
            .with_patch(*view.patch)
            .with_merge(*view.merge)
            .with_dense(dense(&view.dense, rounded)),
    )
}

/// The name of the extreme in an action's direction.
fn extreme<'a>(domain: &'a Domain, action: &domain::Action) -> Option<&'a str> {
    let words = domain.extremes.get(&action.name)?;
    words.first().map(String::as_str)
}

/// The pronouns in the order of the vocabulary.
fn pronouns(owner: &Owner) -> Result<Vec<Pronoun>, ModelError> {
    let domain = &owner.domain;
    let index = |text: &String| word_index(owner, text);
    let pronoun = |text: &String| {
        let owner = domain.pronouns.get(text).filter(|owner| !owner.is_empty());
        let owner = owner.map(index).transpose()?;
        Ok(Pronoun::new().with_word(index(text)?).with_owner(owner))
    };
    let words = owner.vocabulary.iter().skip(1);
    let known = words.filter(|text| domain.pronouns.contains_key(*text));
    known.map(pronoun).collect()
}

/// The words that put an object somewhere, in the order of the vocabulary.
fn placing(owner: &Owner) -> Result<Vec<u16>, ModelError> {
    let words = owner.domain.placing.iter();
    let words: Result<Vec<_>, _> = words.map(|text| word_index(owner, text)).collect();
    let mut words = words?;
    words.sort_unstable();
    Ok(words)
}

/// The index of a word that the domain's check has found in the vocabulary.
fn word_index(owner: &Owner, text: &str) -> Result<u16, ModelError> {
    let found = owner
        .vocabulary
        .iter()
        .skip(1)
        .position(|word| word == text);
    let index = found.and_then(|index| u16::try_from(index).ok());
    index.ok_or_else(|| ModelError::Several { word: text.into() })
}

/// An index as core stores it, bounded by [`Domain`]'s check.
fn index(what: &'static str, value: usize) -> Result<u8, ModelError> {
    u8::try_from(value).map_err(|_| ModelError::TooMany {
        what,
        limit: domain::MAX_NAMES,
        got: value + 1,
    })
}
