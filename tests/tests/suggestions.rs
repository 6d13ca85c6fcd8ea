//! Suggestions for words that the built-in model does not know.

use nsrm_core::{Planner, Refusal};
use nsrm_tabletop::TABLETOP;

#[test]
fn what_may_have_been_meant_is_a_known_word_nearby() {
    for (sentence, word, expected) in [
        (
            "put the greed block on the red block",
            "greed",
            Some("green"),
        ),
        (
            "Put the GREENS block on the red one",
            "GREENS",
            Some("green"),
        ),
        ("put red blocks on the blue one", "blocks", Some("block")),
        ("put the rod block on the blue one", "rod", Some("red")),
        ("putt the red block on the blue one", "putt", Some("put")),
        (
            "put the mmagneta block on the blue one",
            "mmagneta",
            Some("magenta"),
        ),
        ("put the red block under the blue block", "under", None),
        ("put the red block below the blue block", "below", None),
        ("put the red block outside the blue block", "outside", None),
        ("put the purple block on the blue block", "purple", None),
        ("don't put the red block on the blue block", "don't", None),
    ] {
        let model = &TABLETOP;
        let refusal = Planner::new(model).parse(sentence).expect_err(sentence);
        let Refusal::UnknownWord { span } = refusal else {
            panic!("{sentence:?}: {refusal:?}");
        };
        assert_eq!(span.of(sentence), Some(word));
        assert_eq!(
            refusal.suggestion(model, sentence),
            expected,
            "{sentence:?}"
        );
        let message = refusal.in_context(model, sentence).to_string();
        let offer = expected.map_or("use another one".into(), |known| {
            format!("did you mean \"{known}\"?")
        });
        assert!(message.ends_with(&offer), "{message}");
        assert!(!refusal.to_string().contains("did you mean"));
    }
    let other = Refusal::NoWords.suggestion(&TABLETOP, "");
    assert_eq!(other, None);
}
