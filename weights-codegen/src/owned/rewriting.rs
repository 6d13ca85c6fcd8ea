//! What is read in place of other words: what is counted, arrangements, the table and compounds.

use std::collections::BTreeSet;

use nsrm_core::model::{
    Arrangement, Arrangements, Closing, Compound, CompoundText, Compounds, Count, CountedFrom,
    Lists, Opening, Ordinals, Perspectives, Ranked, Rephrased, Rephrasing, Sequence, SequenceText,
    Simplification, Standing, Table, Taking,
};

use super::index;
use crate::domain::{self, Domain};
use crate::error::ModelError;

/// What core reads as slices of [`Ordinals`].
pub(super) struct OrdinalParts<'a> {
    ranked: Vec<Ranked<'a>>,
    counts: Vec<Count<'a>>,
    from: Vec<CountedFrom<'a>>,
    first_words: Vec<&'a str>,
    articles: Vec<&'a str>,
    nouns: Vec<&'a str>,
    unless: Vec<&'a str>,
}

/// What core reads as slices of [`Arrangements`].
pub(super) struct ArrangementParts<'a> {
    between: Vec<&'a str>,
    ends: Vec<&'a str>,
    next: &'a str,
    arrangements: Vec<Arrangement<'a>>,
    openings: Vec<Opening<'a>>,
    closings: Vec<Closing<'a>>,
}

/// What core reads as slices of [`Rephrasing`].
pub(super) struct RephrasingParts<'a> {
    said: Vec<Rephrased<'a>>,
    first_words: Vec<&'a str>,
}

/// What core reads as slices of [`Simplification`].
pub(super) struct SimplificationParts<'a> {
    opening: RephrasingParts<'a>,
    anywhere: RephrasingParts<'a>,
    closing: RephrasingParts<'a>,
    connecting: RephrasingParts<'a>,
    starting: Vec<&'a str>,
    words: Vec<&'a str>,
    towards: Vec<&'a str>,
    order: &'a str,
    object: &'a str,
    clauses: Vec<&'a str>,
    relations: Vec<&'a str>,
    read_as: &'a str,
}

/// What core reads as slices of [`Lists`].
pub(super) struct ListParts<'a> {
    between: Vec<&'a str>,
    them: Vec<&'a str>,
    stacking: Vec<&'a str>,
    aside: Vec<&'a str>,
    next: &'a str,
}

/// What core reads as slices of [`Perspectives`].
pub(super) struct PerspectiveParts<'a> {
    own: Vec<&'a str>,
    other: Vec<&'a str>,
    first_words: Vec<&'a str>,
    opposites: Vec<u8>,
}

/// What core reads as slices of [`Sequence`].
pub(super) struct SequenceParts<'a> {
    later: Vec<SequenceText<'a>>,
    earlier: Vec<SequenceText<'a>>,
    first_words: Vec<&'a str>,
    next: &'a str,
}

/// What core reads as slices of [`Table`].
#[derive(Default)]
pub(super) struct TableParts<'a> {
    action: u8,
    sides: Vec<u8>,
    off: Vec<&'a str>,
    sources: Vec<&'a str>,
    unless: Vec<&'a str>,
    removing: Vec<&'a str>,
    taking: &'a str,
    standing: &'a str,
    order: &'a str,
    down: Vec<&'a str>,
    relation: &'a str,
}

/// What core reads as slices of [`Compounds`].
pub(super) struct CompoundParts<'a> {
    compounds: Vec<Compound<'a>>,
    said: Vec<CompoundText<'a>>,
    first_words: Vec<&'a str>,
    sides: Vec<&'a str>,
}

impl<'a> OrdinalParts<'a> {
    /// * `ranked`: what can be counted
    pub(super) fn new(
        domain: &'a Domain,
        ranked: &'a [domain::Ranked],
    ) -> Result<Self, ModelError> {
        let named = |ranked: &'a domain::Ranked| {
            Ranked::new()
                .with_name(&ranked.name)
                .with_extreme(ranked.extreme)
                .with_rank(ranked.rank)
        };
        let count = |(text, rank)| Count::new().with_text(text).with_rank(rank);
        let from = |(text, (extreme, is_first))| {
            let from = CountedFrom::new().with_text(text);
            from.with_extreme(extreme).with_is_first(is_first)
        };
        let words = |words: &'a BTreeSet<String>| words.iter().map(String::as_str).collect();
        Ok(Self {
            ranked: ranked.iter().map(named).collect(),
            counts: domain.counts().into_iter().map(count).collect(),
            from: domain.counted_from()?.into_iter().map(from).collect(),
            first_words: domain.first_words_of_counts().into_iter().collect(),
            articles: words(&domain.ordinals.articles),
            nouns: words(&domain.ordinals.nouns),
            unless: words(&domain.ordinals.unless),
        })
    }

    pub(super) fn lent(&self) -> Ordinals<'_> {
        Ordinals::new()
            .with_ranked(&self.ranked)
            .with_counts(&self.counts)
            .with_from(&self.from)
            .with_first_words(&self.first_words)
            .with_articles(&self.articles)
            .with_nouns(&self.nouns)
            .with_unless(&self.unless)
    }
}

impl<'a> ArrangementParts<'a> {
    pub(super) fn new(said: &'a domain::Arrangements) -> Result<Self, ModelError> {
        let opening = |(text, pattern)| {
            let pattern = index("patterns of arrangements", pattern)?;
            Ok(Opening::new().with_text(text).with_pattern(pattern))
        };
        let closing = |(text, pattern, meant): (&'a str, usize, &str)| {
            let pattern = index("patterns of arrangements", pattern)?;
            let found = said.steps.keys().position(|name| name == meant);
            let found = found.ok_or_else(|| ModelError::ArrangedSteps { name: meant.into() })?;
            let closing = Closing::new().with_text(text).with_pattern(pattern);
            Ok(closing.with_arrangement(index("arrangements", found)?))
        };
        let arrangement = |steps: &'a domain::ArrangedStep| {
            Arrangement::new()
                .with_order(&steps.order)
                .with_relation(&steps.relation)
                .with_is_reversed(steps.reversed)
        };
        let (openings, closings) = (said.openings().into_iter(), said.closings());
        Ok(Self {
            between: said.between.iter().map(String::as_str).collect(),
            ends: said.ends.iter().map(String::as_str).collect(),
            next: &said.next,
            arrangements: said.steps.values().map(arrangement).collect(),
            openings: openings.map(opening).collect::<Result<_, ModelError>>()?,
            closings: closings.map(closing).collect::<Result<_, ModelError>>()?,
        })
    }

    pub(super) fn lent(&self) -> Arrangements<'_> {
        Arrangements::new()
            .with_between(&self.between)
            .with_ends(&self.ends)
            .with_next(self.next)
            .with_arrangements(&self.arrangements)
            .with_openings(&self.openings)
            .with_closings(&self.closings)
    }
}

impl<'a> RephrasingParts<'a> {
    pub(super) fn new(phrases: &'a domain::Rephrasing) -> Self {
        let first_words = phrases.keys().filter_map(|text| text.split(' ').next());
        let first_words: BTreeSet<_> = first_words.collect();
        let said = phrases.iter();
        let said =
            said.map(|(text, read_as)| Rephrased::new().with_text(text).with_read_as(read_as));
        Self {
            said: said.collect(),
            first_words: first_words.into_iter().collect(),
        }
    }

    pub(super) fn lent(&self) -> Rephrasing<'_> {
        Rephrasing::new()
            .with_said(&self.said)
            .with_first_words(&self.first_words)
    }
}

impl<'a> SimplificationParts<'a> {
    pub(super) fn new(domain: &'a Domain) -> Self {
        let simplification = &domain.simplification;
        let (taking, standing) = (&simplification.taking, &simplification.standing);
        Self {
            opening: RephrasingParts::new(&simplification.opening),
            anywhere: RephrasingParts::new(&simplification.anywhere),
            closing: RephrasingParts::new(&simplification.closing),
            connecting: RephrasingParts::new(&simplification.connecting),
            starting: simplification.starting.iter().map(String::as_str).collect(),
            words: taking.words.iter().map(String::as_str).collect(),
            towards: taking.towards.iter().map(String::as_str).collect(),
            order: &taking.order,
            object: &taking.object,
            clauses: standing.clauses.iter().map(String::as_str).collect(),
            relations: standing.relations.iter().map(String::as_str).collect(),
            read_as: &standing.read_as,
        }
    }

    pub(super) fn lent(&self) -> Simplification<'_> {
        let taking = Taking::new()
            .with_words(&self.words)
            .with_towards(&self.towards)
            .with_order(self.order)
            .with_object(self.object);
        let standing = Standing::new()
            .with_clauses(&self.clauses)
            .with_relations(&self.relations)
            .with_read_as(self.read_as);
        Simplification::new()
            .with_standing(standing)
            .with_opening(self.opening.lent())
            .with_anywhere(self.anywhere.lent())
            .with_closing(self.closing.lent())
            .with_connecting(self.connecting.lent())
            .with_starting(&self.starting)
            .with_taking(taking)
    }
}

impl<'a> ListParts<'a> {
    pub(super) fn new(lists: &'a domain::Lists) -> Self {
        Self {
            between: lists.between.iter().map(String::as_str).collect(),
            them: lists.them.iter().map(String::as_str).collect(),
            stacking: lists.stacking.iter().map(String::as_str).collect(),
            aside: lists.aside.iter().map(String::as_str).collect(),
            next: &lists.next,
        }
    }

    pub(super) fn lent(&self) -> Lists<'_> {
        Lists::new()
            .with_between(&self.between)
            .with_them(&self.them)
            .with_stacking(&self.stacking)
            .with_aside(&self.aside)
            .with_next(self.next)
    }
}

impl<'a> PerspectiveParts<'a> {
    pub(super) fn new(domain: &'a Domain) -> Result<Self, ModelError> {
        let perspectives = &domain.perspectives;
        let texts = perspectives.own.iter().chain(&perspectives.other);
        let first_words: BTreeSet<_> = texts.filter_map(|text| text.split(' ').next()).collect();
        Ok(Self {
            own: perspectives.own.iter().map(String::as_str).collect(),
            other: perspectives.other.iter().map(String::as_str).collect(),
            first_words: first_words.into_iter().collect(),
            opposites: domain.opposites()?,
        })
    }

    pub(super) fn lent(&self) -> Perspectives<'_> {
        Perspectives::new()
            .with_own(&self.own)
            .with_other(&self.other)
            .with_first_words(&self.first_words)
            .with_opposites(&self.opposites)
    }
}

impl<'a> SequenceParts<'a> {
    pub(super) fn new(domain: &'a Domain) -> Self {
        let sequence = &domain.sequence;
        let text = |(text, read_as): (&'a String, &'a String)| {
            SequenceText::new().with_text(text).with_read_as(read_as)
        };
        let afterthoughts = sequence.afterthoughts.iter();
        let afterthoughts = afterthoughts.map(|text| {
            SequenceText::new()
                .with_text(text)
                .with_is_afterthought(true)
        });
        let mut earlier: Vec<_> = sequence
            .earlier
            .iter()
            .map(text)
            .chain(afterthoughts)
            .collect();
        earlier.sort_unstable_by_key(|text| text.text);
        Self {
            later: sequence.later.iter().map(text).collect(),
            earlier,
            first_words: domain.first_words_of_sequence().into_iter().collect(),
            next: &sequence.next,
        }
    }

    pub(super) fn lent(&self) -> Sequence<'_> {
        Sequence::new()
            .with_later(&self.later)
            .with_earlier(&self.earlier)
            .with_first_words(&self.first_words)
            .with_next(self.next)
    }
}

impl<'a> TableParts<'a> {
    pub(super) fn new(domain: &'a Domain) -> Result<Self, ModelError> {
        let Some(table) = &domain.table else {
            return Ok(Self::default());
        };
        let action = |name: &String| {
            let found = domain.action_index(name);
            let found = found.ok_or_else(|| ModelError::TableAction { name: name.clone() })?;
            index("actions", found)
        };
        Ok(Self {
            action: action(&table.action)?,
            sides: table.sides.iter().map(action).collect::<Result<_, _>>()?,
            off: sorted(&table.off),
            sources: sorted(&table.sources),
            unless: sorted(&table.unless),
            removing: sorted(&table.removing),
            taking: &table.taking,
            standing: &table.standing,
            order: &table.order,
            down: sorted(&table.down),
            relation: &table.relation,
        })
    }

    pub(super) fn lent(&self) -> Table<'_> {
        Table::new()
            .with_action(self.action)
            .with_sides(&self.sides)
            .with_off(&self.off)
            .with_sources(&self.sources)
            .with_unless(&self.unless)
            .with_removing(&self.removing)
            .with_taking(self.taking)
            .with_standing(self.standing)
            .with_order(self.order)
            .with_down(&self.down)
            .with_relation(self.relation)
    }
}

impl<'a> CompoundParts<'a> {
    /// * `actions`: those of which each compound is made
    pub(super) fn new(domain: &'a Domain, actions: &'a [Vec<u8>]) -> Result<Self, ModelError> {
        let made = domain.compounds.made.iter().zip(actions);
        let compound = |(compound, actions): (&'a domain::Compound, &'a Vec<u8>)| {
            Compound::new()
                .with_name(&compound.name)
                .with_phrase(&compound.phrase)
                .with_kind(compound.parts().0)
                .with_parts(actions)
                .with_read(&compound.read)
        };
        let said = |(text, compound)| {
            let compound = index("compounds", compound)?;
            Ok(CompoundText::new().with_text(text).with_compound(compound))
        };
        let texts = domain.compound_texts().into_iter();
        let sides = domain.compounds.sides.iter();
        Ok(Self {
            compounds: made.map(compound).collect(),
            said: texts.map(said).collect::<Result<_, ModelError>>()?,
            first_words: domain.compound_first_words().into_iter().collect(),
            sides: sides.map(String::as_str).collect(),
        })
    }

    pub(super) fn lent(&self) -> Compounds<'_> {
        Compounds::new()
            .with_compounds(&self.compounds)
            .with_said(&self.said)
            .with_first_words(&self.first_words)
            .with_sides(&self.sides)
    }
}

/// Texts in their order, each once.
fn sorted(texts: &[String]) -> Vec<&str> {
    let texts: BTreeSet<&str> = texts.iter().map(String::as_str).collect();
    texts.into_iter().collect()
}
