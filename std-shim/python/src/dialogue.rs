//! What is asked back after a refusal.

use nsrm::dialogue;
use pyo3::prelude::*;

/// One of the possible answers to a question.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(Clone, PartialEq)]
pub(crate) struct Choice {
    answer: String,
    sentence: String,
}

#[pymethods]
impl Choice {
    fn __repr__(&self) -> String {
        let Self { answer, sentence } = self;
        format!("Choice(answer={answer:?}, sentence={sentence:?})")
    }
}

/// What is asked back after a refusal.
#[pyclass(frozen, module = "nsrm")]
pub(crate) struct Question {
    inner: dialogue::Question,
}

impl Question {
    pub(crate) const fn new(inner: dialogue::Question) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl Question {
    /// The possible answers; none if the question is open.
    #[getter]
    fn options(&self) -> Vec<Choice> {
        let options = self.inner.options().iter();
        let choice = |option: &dialogue::Choice| Choice {
            answer: option.answer.clone(),
            sentence: option.sentence.clone(),
        };
        options.map(choice).collect()
    }

    /// The sentence that an answer leads to; None if it is none of the possible ones.
    fn complete(&self, answer: &str) -> Option<String> {
        self.inner.complete(answer)
    }

    fn __str__(&self) -> String {
        self.inner.to_string()
    }

    fn __repr__(&self) -> String {
        format!("Question({:?})", self.inner.to_string())
    }
}
