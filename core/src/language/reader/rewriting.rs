//! Rewrites the tokens of a sentence once all are read, one piece at a time.

use super::Reader;
use crate::language::Tokens;
use crate::language::phrases::PhraseMatcher;
use crate::language::sequence::StepEnd;
use crate::language::tokens::{join, span_of, unclear};
use crate::model::Model;
use crate::refusal::Refusal;

/// How far the tokens of a sentence are rewritten, once all are read: from which one on is still to be
/// looked at.
#[derive(Debug, Clone, Copy)]
pub(super) enum Rewriting {
    /// For what says whose left is meant.
    Perspectives {
        from: usize,
    },
    /// For what the sentence can do without.
    Simplifying {
        from: usize,
    },
    /// For phrases that are read as others.
    Rephrasing {
        from: usize,
    },
    /// For what is left out of descriptions.
    Exceptions {
        from: usize,
    },
    /// For what is taken back or ruled out.
    Repairs {
        from: usize,
    },
    /// For two steps in another order.
    Sequence,
    /// For values that stand apart.
    Apart {
        from: usize,
    },
    /// For what is counted from one side.
    Ordinals {
        from: usize,
    },
    /// For plurals.
    Plurals {
        from: usize,
    },
    /// For what means the table.
    Table {
        from: usize,
    },
    /// For towers and rows.
    Arrangements {
        from: usize,
    },
    /// For compounds.
    Compounds {
        from: usize,
    },
    /// For listed objects.
    Lists {
        from: usize,
    },
    /// For values directly beside each other.
    Beside {
        from: usize,
    },
    /// For distances.
    Distances {
        from: usize,
    },
    Done,
}

/// Known words that also mean something else: the sentence has two readings.
#[derive(Clone, Copy)]
pub(super) enum Twofold {
    /// What stands between values that stand apart.
    Apart,
    /// What counts.
    Ordinals,
    /// What means a compound.
    Compounds,
}

impl Twofold {
    /// How many there are.
    pub(super) const COUNT: usize = 3;
}

impl Reader {
    /// Does a piece of rewriting: leaves out what a sentence can do without, reads phrases as others, leaves out exceptions and what is taken back, puts steps in order, joins
    /// values that stand apart, adds to descriptions what is counted, names the table where it is meant, replaces
    /// arrangements, compounds and lists, joins values that stand beside each other, then leaves out distances. False if all
    /// tokens have been looked at, and none is unknown.
    pub(super) fn rewrite(&mut self, model: &Model<'_>, sentence: &str) -> Result<bool, Refusal> {
        if self.tokens.is_empty() || model.has_no_rewriting() {
            return Ok(false);
        }
        let said = PhraseMatcher { model, sentence };
        match self.rewriting {
            Rewriting::Perspectives { from } => self.leave_perspective_out(said, from)?,
            Rewriting::Simplifying { from } => self.simplify(said, from)?,
            Rewriting::Rephrasing { from } => self.rephrase(said, from)?,
            Rewriting::Exceptions { from } => self.leave_exception_out(said, from)?,
            Rewriting::Repairs { from } => self.repair(said, from)?,
            Rewriting::Sequence => self.put_in_order(said)?,
            Rewriting::Apart { from } => self.join(said, from, false)?,
            Rewriting::Ordinals { from } => self.rewriting = self.count(said, from)?,
            Rewriting::Plurals { from } => self.read_plural(said, from)?,
            Rewriting::Table { from } => self.name_table(said, from)?,
            Rewriting::Arrangements { from } => self.arrange(said, from)?,
            Rewriting::Compounds { from } => {
                self.rewriting = self.replace_compound(said, from)?;
            }
            Rewriting::Lists { from } => self.write_list(said, from)?,
            Rewriting::Beside { from } => self.join(said, from, true)?,
            Rewriting::Distances { from } => self.leave_out_distance(said, from)?,
            Rewriting::Done => return self.unknown().map_or(Ok(false), Err),
        }
        Ok(true)
    }

    /// Leaves out the next words that say whose left is meant, if there are any, and keeps what they say.
    #[inline(never)]
    fn leave_perspective_out(
        &mut self,
        said: PhraseMatcher<'_, '_>,
        from: usize,
    ) -> Result<(), Refusal> {
        let mut places = from..self.tokens.len();
        if said.model.perspectives.is_empty() {
            places.start = places.end;
        }
        let Some(found) = places.find_map(|at| said.seen_from(&self.tokens, at)) else {
            self.rewriting = match self.simplifies {
                true => Rewriting::Simplifying { from: 0 },
                false => Rewriting::Rephrasing { from: 0 },
            };
            return Ok(());
        };
        let span = span_of(self.tokens.get(found.words.clone()).unwrap_or_default());
        let span = span.ok_or(Refusal::InvalidModel)?;
        if *self.is_opposite.get_or_insert(found.is_opposite) != found.is_opposite {
            return Err(unclear(said.model, span));
        }
        let mut from = said.replace(&mut self.tokens, &found.words, "", span)?;
        if let Some(marks) = said.left_over(&self.tokens, from) {
            from = said.replace(&mut self.tokens, &marks, "", span)?;
        }
        self.rewriting = Rewriting::Perspectives { from };
        Ok(())
    }

    /// Leaves out the next words that the sentence can do without, or reads them in simpler ones, if there are any.
    /// A sentence without any has been read before.
    #[inline(never)]
    fn simplify(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<(), Refusal> {
        let mut places = from..self.tokens.len();
        let found = places.find_map(|at| said.simpler(&self.tokens, at));
        let Some((words, read_as)) = found else {
            self.put_values_before_nouns(said)?;
            said.read_articles(&mut self.tokens);
            self.rewriting = Rewriting::Rephrasing { from: 0 };
            return self.is_simpler.then_some(()).ok_or(Refusal::NoWords);
        };
        self.is_simpler = true;
        // "It" has the place of the word behind it.
        let said_at = words.start..words.end.max(words.start.saturating_add(1));
        let span = span_of(self.tokens.get(said_at).unwrap_or_default());
        let span = span.ok_or(Refusal::InvalidModel)?;
        let mut from = said.replace(&mut self.tokens, &words, read_as, span)?;
        if read_as.is_empty()
            && let Some(mark) = said.left_over(&self.tokens, from)
        {
            from = said.replace(&mut self.tokens, &mark, "", span)?;
        }
        if read_as.is_empty() {
            self.join_neighbours(said, from)?;
            // A phrase may begin with the mark before.
            let before = from.saturating_sub(1);
            if said.is_mark(&self.tokens, before) {
                from = before;
            }
        }
        self.rewriting = Rewriting::Simplifying { from };
        Ok(())
    }

    /// Puts values that stand behind their noun before it: "the small block red" is "the small red block".
    fn put_values_before_nouns(&mut self, said: PhraseMatcher<'_, '_>) -> Result<(), Refusal> {
        let mut at = 0_usize;
        while let Some(noun) = said.postposed(&self.tokens, at) {
            let behind = noun.saturating_add(1);
            if let Some(places) = self.tokens.get_mut(noun..=behind)
                && let [noun, values] = places
            {
                core::mem::swap(noun, values);
                self.is_simpler = true;
            }
            self.join_neighbours(said, noun)?;
            at = behind;
        }
        Ok(())
    }

    /// Joins the groups before and behind a place, between which words were left out: "the big sized red block".
    fn join_neighbours(
        &mut self,
        said: PhraseMatcher<'_, '_>,
        behind: usize,
    ) -> Result<(), Refusal> {
        let Some(before) = behind.checked_sub(1) else {
            return Ok(());
        };
        let pair = before..behind.saturating_add(1);
        if let Some([first, second]) = self.tokens.get(pair.clone())
            && first.filters().is_some()
            && second
                .filters()
                .is_some_and(|second| second.choice().is_none())
        {
            let whole = join(said.model, first, second)?;
            PhraseMatcher::resize(&mut self.tokens, &pair, 1, whole.span)?;
            *self.tokens.get_mut(before).ok_or(Refusal::InvalidModel)? = whole;
        }
        Ok(())
    }

    /// Reads the next phrase as another one, if there is one.
    #[inline(never)]
    fn rephrase(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<(), Refusal> {
        let mut places = from..self.tokens.len();
        let found = places.find_map(|at| said.rephrased(&said.model.rephrasing, &self.tokens, at));
        self.rewriting = match found {
            None => Rewriting::Exceptions { from: 0 },
            Some((words, read_as)) => {
                let span = span_of(self.tokens.get(words.clone()).unwrap_or_default());
                let span = span.ok_or(Refusal::InvalidModel)?;
                let from = said.replace(&mut self.tokens, &words, read_as, span)?;
                Rewriting::Rephrasing { from }
            }
        };
        Ok(())
    }

    /// Leaves out the next exception, if there is one, and keeps what it says.
    #[inline(never)]
    fn leave_exception_out(
        &mut self,
        said: PhraseMatcher<'_, '_>,
        from: usize,
    ) -> Result<(), Refusal> {
        let mut places = from..self.tokens.len();
        // One of the words that say so is unknown.
        let found = match self.unknown() {
            Some(_) => places.find_map(|at| said.exception(&self.tokens, at)),
            None => None,
        };
        self.rewriting = Rewriting::Repairs { from: 0 };
        // More than there can be steps are refused for their words.
        if let Some(found) = found
            && !self.kept.is_full()
        {
            let (exception, from) = said.leave_exception_out(&mut self.tokens, &found)?;
            let _ = self.kept.push(exception);
            self.rewriting = Rewriting::Exceptions { from };
        }
        Ok(())
    }

    /// Leaves out the next description that is taken back or ruled out, if there is one.
    #[inline(never)]
    fn repair(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<(), Refusal> {
        let mut places = from..self.tokens.len();
        // One of the words that say so is unknown.
        let repair = match self.unknown() {
            Some(_) => places.find_map(|at| said.repair(&self.tokens, at)),
            None => None,
        };
        self.rewriting = match repair {
            None => Rewriting::Sequence,
            Some(repair) => {
                self.tokens = repair.repaired(&self.tokens)?;
                Rewriting::Repairs {
                    from: repair.behind(),
                }
            }
        };
        Ok(())
    }

    /// Puts two steps in order that are said in another one; refuses others with words that say an order. Where the
    /// first one may end at two places, the sentence has two readings.
    #[inline(never)]
    fn put_in_order(&mut self, said: PhraseMatcher<'_, '_>) -> Result<(), Refusal> {
        self.rewriting = Rewriting::Apart { from: 0 };
        let mut places = 0..self.tokens.len();
        let Some(order) = places.find_map(|at| said.order(&self.tokens, at)) else {
            return Ok(());
        };
        let at_comma = said.sequenced(&self.tokens, &order, StepEnd::Comma);
        let at_verb = said.sequenced(&self.tokens, &order, StepEnd::Verb);
        let sequenced = match (at_comma, at_verb) {
            (Some(at_comma), Some(at_verb)) => self.choose(2).map(|chosen| match chosen {
                0 => at_comma,
                _ => at_verb,
            }),
            (at_comma, at_verb) => at_comma.or(at_verb),
        };
        let span = order.span(&self.tokens);
        let sequenced = sequenced.ok_or(unclear(said.model, span))?;
        self.tokens = said.in_order(&self.tokens, &sequenced, span)?;
        Ok(())
    }

    /// Joins the next group to what it stands apart from, if there is one. All words in between have
    /// another meaning without it, and so the sentence two readings, unless one is unknown.
    ///
    /// * `directly`: whether only another group may stand before what is in between
    fn join(
        &mut self,
        said: PhraseMatcher<'_, '_>,
        from: usize,
        directly: bool,
    ) -> Result<(), Refusal> {
        let mut groups = from..self.tokens.len();
        let joint = groups.find_map(|at| said.joint(&self.tokens, at, directly));
        let Some(joint) = joint else {
            self.rewriting = match directly {
                false => Rewriting::Ordinals { from: 0 },
                true => Rewriting::Distances { from: 0 },
            };
            return Ok(());
        };
        let mut from = joint.behind();
        if PhraseMatcher::must_join(&self.tokens, joint) || self.chooses(Twofold::Apart) {
            (self.tokens, from) = said.joined(&self.tokens, joint)?;
        }
        self.rewriting = match directly {
            false => Rewriting::Apart { from },
            true => Rewriting::Beside { from },
        };
        Ok(())
    }

    /// Adds what the next words count to its description, if there are any, and tells what is next. Where all of
    /// them are known, the sentence has two readings.
    #[inline(never)]
    fn count(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<Rewriting, Refusal> {
        let mut places = from..self.tokens.len();
        let counted = places.find_map(|at| said.counted(&self.tokens, at));
        let Some(counted) = counted else {
            return Ok(Rewriting::Plurals { from: 0 });
        };
        let mut from = counted.behind();
        if counted.is_sure(&self.tokens) || self.chooses(Twofold::Ordinals) {
            let group;
            (self.tokens, group) = said.with_counted(&self.tokens, &counted)?;
            from = group.saturating_add(1);
        }
        Ok(Rewriting::Ordinals { from })
    }

    /// Names the table at the next words that mean it, if there are any. Where this is one known word, the
    /// sentence has two readings.
    #[inline(never)]
    fn name_table(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<(), Refusal> {
        let mut places = from..self.tokens.len();
        let implied = places.find_map(|at| Some((at, said.implied_table(&self.tokens, at)?)));
        self.rewriting = match implied {
            None if said.has_list(&self.tokens) => Rewriting::Arrangements { from: 0 },
            None => Rewriting::Compounds { from: 0 },
            Some((at, implied)) => {
                let mut from = at.saturating_add(1);
                let is_sure = !PhraseMatcher::may_be_read(&self.tokens, &implied);
                if is_sure || self.choose(2) == Some(1) {
                    let mut before = Tokens::new();
                    // As many fit.
                    let _ = before.extend_from_slice(&self.tokens);
                    self.tokens.clear();
                    from = said.write_table(&before, &implied, &mut self.tokens)?;
                }
                Rewriting::Table { from }
            }
        };
        Ok(())
    }

    /// Replaces the arrangement at a token, if there is one.
    fn arrange(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<(), Refusal> {
        let rest = self.tokens.get(from..).unwrap_or_default();
        let next = if rest.is_empty() {
            Rewriting::Compounds { from: 0 }
        } else if said.arrangement(rest).is_some() {
            let from = self.replace(said, from)?;
            Rewriting::Arrangements { from }
        } else {
            let from = from.saturating_add(1);
            Rewriting::Arrangements { from }
        };
        self.rewriting = next;
        Ok(())
    }

    /// Replaces the next words that mean a compound, if there are any, and tells what is next. Where all of
    /// them are known, the sentence has two readings.
    #[inline(never)]
    fn replace_compound(
        &mut self,
        said: PhraseMatcher<'_, '_>,
        from: usize,
    ) -> Result<Rewriting, Refusal> {
        let mut places = from..self.tokens.len();
        let meant = places.find_map(|at| said.compound(&self.tokens, at));
        let Some(meant) = meant else {
            return Ok(Rewriting::Lists { from: 0 });
        };
        let mut from = meant.behind();
        // More pairs than there can be steps are refused for their words.
        let has_room = !meant.is_pair() || !self.kept.is_full();
        if has_room && (meant.is_sure || self.chooses(Twofold::Compounds)) {
            let pair;
            (from, pair) = said.replace_compound(&mut self.tokens, &meant)?;
            if let Some(pair) = pair {
                // There is room.
                let _ = self.kept.push(pair);
            }
        }
        Ok(Rewriting::Compounds { from })
    }

    /// Replaces the next list of objects by its steps, if there is one. Where all its words are known, the sentence
    /// has two readings.
    #[inline(never)]
    fn write_list(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<(), Refusal> {
        if let Some(words) = said.stacked_aside(&self.tokens) {
            let span = span_of(self.tokens.get(words).unwrap_or_default());
            return Err(unclear(said.model, span.ok_or(Refusal::InvalidModel)?));
        }
        let mut places = from..self.tokens.len();
        if !said.may_list(&self.tokens) {
            places.start = places.end;
        }
        self.rewriting = match places.find_map(|at| said.list(&self.tokens, at)) {
            None => Rewriting::Beside { from: 0 },
            Some(found) if self.unknown().is_none() && self.choose(2) != Some(1) => {
                let from = found.behind();
                Rewriting::Lists { from }
            }
            Some(found) => {
                let from = said.write_list(&mut self.tokens, &found)?;
                Rewriting::Lists { from }
            }
        };
        Ok(())
    }

    /// Reads the next plural with an article as all of them, if there is one.
    fn read_plural(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<(), Refusal> {
        let mut places = match self.unknown() {
            // Plurals are unknown words.
            Some(_) => from..self.tokens.len(),
            None => 0..0,
        };
        let found = places.find_map(|at| Some((at, said.all_of(&self.tokens, at)?)));
        self.rewriting = match found {
            None => Rewriting::Table { from: 0 },
            Some((at, all)) => {
                PhraseMatcher::put_all_of(&mut self.tokens, at, all)?;
                Rewriting::Plurals {
                    from: at.saturating_add(1),
                }
            }
        };
        Ok(())
    }

    /// Leaves out the words of the next distance, if there is one, and keeps what they say.
    #[inline(never)]
    fn leave_out_distance(
        &mut self,
        said: PhraseMatcher<'_, '_>,
        from: usize,
    ) -> Result<(), Refusal> {
        let mut places = from..self.tokens.len();
        // A number in digits and a unit are unknown.
        let distance = match self.unknown() {
            Some(_) => places.find_map(|at| said.distance(&self.tokens, at)),
            None => None,
        };
        self.rewriting = Rewriting::Done;
        // More than there can be steps are refused for their words.
        if let Some(found) = distance
            && !self.distances.is_full()
        {
            let (distance, from) = said.leave_out(&mut self.tokens, &found)?;
            let _ = self.distances.push(distance);
            self.rewriting = Rewriting::Distances { from };
        }
        Ok(())
    }

    /// Whether known words of a kind are rewritten in this reading: all or none.
    fn chooses(&mut self, kind: Twofold) -> bool {
        let index = kind as usize;
        if let Some(Some(chosen)) = self.chosen.get(index) {
            return *chosen;
        }
        let chosen = self.choose(2) == Some(1);
        if let Some(place) = self.chosen.get_mut(index) {
            *place = Some(chosen);
        }
        chosen
    }

    /// Replaces the arrangement at a token by its steps, and tells the number of the token behind them.
    /// Words that have another meaning without it have two readings.
    #[inline(never)]
    fn replace(&mut self, said: PhraseMatcher<'_, '_>, from: usize) -> Result<usize, Refusal> {
        let mut before = Tokens::new();
        // As many fit.
        let _ = before.extend_from_slice(&self.tokens);
        let rest = before.get(from..).unwrap_or_default();
        let Some(found) = said.arrangement(rest) else {
            return Ok(from);
        };
        if self.unknown().is_none() && self.choose(2) != Some(1) {
            return Ok(from.saturating_add(found.length()));
        }
        self.tokens.truncate(from);
        said.write(&found, &mut self.tokens)?;
        let behind = self.tokens.len();
        let rest = rest.get(found.length()..).unwrap_or_default();
        for token in rest {
            self.add(token.kind, token.span)?;
        }
        Ok(behind)
    }
}
