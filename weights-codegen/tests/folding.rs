//! The folded network computes the same as the original one, which is row-major and in `f64` here,
//! with random weights and shapes that are not square.

mod common;

use common::{ACTIONS, CONCEPTS, LEXICON, ModelFile, RELATIONS, WORDS};
use nsrm_core::dsl::Extreme;
use nsrm_core::model::{CompoundKind, Rephrasing, SequenceText, View};
use nsrm_core::nn::{Cell, Dense, Precision};

/// Rounding of a sum in `f64` to `f32`, values below 10.
const ROUNDED: f64 = 1e-6;

#[track_caller]
fn assert_close(got: f32, expected: f64) {
    let difference = (f64::from(got) - expected).abs();
    assert!(difference <= ROUNDED, "{got} is not {expected}");
}

/// `W·x + b` of a row-major matrix.
fn affine(weight: &[f32], bias: &[f32], input: &[f64]) -> Vec<f64> {
    weight
        .chunks_exact(input.len())
        .zip(bias)
        .map(|(row, &bias)| {
            let products = row.iter().zip(input).map(|(&w, &x)| f64::from(w) * x);
            products.sum::<f64>() + f64::from(bias)
        })
        .collect()
}

fn row(values: &[f32], index: usize, length: usize) -> Vec<f64> {
    values[index * length..][..length]
        .iter()
        .map(|&x| x.into())
        .collect()
}

#[test]
fn names_stand_with_their_parameters() {
    let owned = ModelFile::random(3).load();
    let model = owned.as_model();
    assert_eq!(model.header.domain, "shelf");
    assert!(model.words.iter().map(|word| word.text).eq(WORDS));
    let lexicon = model
        .lexicon
        .iter()
        .map(|entry| (entry.text, entry.property));
    assert!(lexicon.eq(LEXICON));
    let extremes = model.actions.iter().map(|action| action.extreme);
    assert!(extremes.eq([None, Some("outermost")]));
    let pronouns = model.pronouns.iter();
    let pronouns = pronouns.map(|pronoun| (pronoun.word, pronoun.owner));
    assert!(pronouns.eq([(3, Some(2)), (7, None)]));
    let placing = model.placing.iter();
    let placing = placing.map(|word| model.words[usize::from(*word)].text);
    assert!(placing.eq(["near", "shift"]));
    assert_eq!(model.conjunctions, ["so that"]);
    assert_eq!(model.several.between, [6]);
    let plurals = model.several.plurals.iter();
    assert!(
        plurals
            .map(|plural| (plural.text, plural.word))
            .eq([("jars", 2)])
    );
    let said = model.rephrasing.said.iter();
    assert!(
        said.map(|said| (said.text, said.read_as))
            .eq([("do so", ""), ("is supposed to", "then")])
    );
    assert_eq!(model.rephrasing.first_words, ["do", "is"]);
    let lists = model.simplification;
    let said = |list: Rephrasing<'_>| -> Vec<(String, String)> {
        let said = list.said.iter();
        said.map(|said| (said.text.into(), said.read_as.into()))
            .collect()
    };
    assert_eq!(said(lists.opening), [("so".into(), String::new())]);
    assert_eq!(
        said(lists.anywhere),
        [
            ("by then".into(), "then".into()),
            ("uh".into(), String::new())
        ]
    );
    assert_eq!(lists.anywhere.first_words, ["by", "uh"]);
    assert_eq!(said(lists.closing), [("then".into(), String::new())]);
    assert_eq!(said(lists.connecting), [("and then".into(), String::new())]);
    assert_eq!(lists.starting, ["first"]);
    assert_eq!(lists.standing.clauses, ["that is"]);
    assert_eq!(lists.standing.relations, ["near"]);
    assert_eq!(lists.standing.read_as, "jar near");
    assert_eq!(lists.taking.words, ["lift", "take"]);
    assert_eq!(lists.taking.towards, ["onto"]);
    assert_eq!((lists.taking.order, lists.taking.object), ("shift", "then"));
    assert_eq!(model.exceptions.phrases, ["except", "except for"]);
    assert_eq!(model.exceptions.negations, ["that is not"]);
    assert_eq!(model.perspectives.own, ["as i see it"]);
    assert_eq!(model.perspectives.other, ["as you see it", "from there"]);
    assert_eq!(model.perspectives.first_words, ["as", "from"]);
    assert_eq!(model.perspectives.opposites, [1, 0]);
    assert_eq!(model.lists.between, ["as well as"]);
    assert_eq!(model.lists.them, ["both", "those"]);
    assert_eq!(model.lists.stacking, ["heap"]);
    assert_eq!(model.lists.aside, ["near"]);
    assert_eq!(model.lists.next, ", then");
    assert_eq!(model.repairs.corrections, ["no", "oh no"]);
    assert_eq!(model.repairs.exclusions, ["not"]);
    let texts = |texts: &[SequenceText<'_>]| -> Vec<(String, String, bool)> {
        let texts = texts.iter();
        let texts = texts.map(|text| (text.text.into(), text.read_as.into(), text.is_afterthought));
        texts.collect()
    };
    assert_eq!(
        texts(model.sequence.later),
        [
            ("before shifting".into(), "shift".into(), false),
            ("before you".into(), "".into(), false)
        ]
    );
    assert_eq!(
        texts(model.sequence.earlier),
        [
            ("after you".into(), "".into(), false),
            ("although first".into(), "".into(), true),
            ("but first".into(), "".into(), true)
        ]
    );
    assert_eq!(
        model.sequence.first_words,
        ["after", "although", "before", "but"]
    );
    assert_eq!(model.sequence.next, ", then");
    let distances = model.distances;
    assert_eq!(distances.sides, [1]);
    let units = distances.units.iter().map(|unit| (unit.text, unit.mm));
    assert!(units.eq([("cm", 10.0), ("mm", 1.0)]));
    let numbers = distances.numbers.iter();
    let numbers = numbers.map(|number| (number.text, number.value));
    assert!(numbers.eq([("a", 1.0), ("half a", 0.5)]));
    assert_eq!(distances.before, ["at a distance of", "by"]);
    assert_eq!(
        (distances.behind, distances.from),
        (&["away"][..], &["off"][..])
    );
    assert_eq!((distances.beside, distances.usual_mm), ("beside", 25));
    assert_eq!(distances.unless, ["the"]);
    let shifts = distances.shifts.iter();
    let shifts = shifts.map(|shift| (shift.text, shift.action));
    assert!(shifts.eq([("aside", 1), ("sideways", 1)]));
    assert_eq!(distances.origins, ["from there"]);
    assert_eq!(model.apart.between, ["and"]);
    assert_eq!(model.apart.phrases, ["whose finish is", "then"]);
    let counted = model.ordinals;
    let ranked = counted.ranked.iter();
    let ranked = ranked.map(|ranked| (ranked.name, ranked.extreme, ranked.rank));
    assert!(ranked.eq([
        ("second outermost", Extreme::Action(1), 2),
        ("second largest", Extreme::Largest, 2),
    ]));
    let counts = counted.counts.iter();
    let counts = counts.map(|count| (count.text, count.rank));
    assert!(counts.eq([("2nd", 2), ("first", 1), ("second", 2)]));
    let from = counted.from.iter();
    let from = from.map(|from| (from.text, from.extreme, from.is_first));
    assert!(from.eq([
        ("far out", Extreme::Action(1), true),
        ("from outside", Extreme::Action(1), false),
    ]));
    assert_eq!(counted.first_words, ["far"]);
    assert_eq!(
        (counted.articles, counted.nouns, counted.unless),
        (&["the"][..], &["box", "jar"][..], &["of"][..])
    );
    let said = model.arrangements;
    assert_eq!(
        (said.between, said.ends, said.next),
        (&[",", "and"][..], &["then"][..], ", then")
    );
    let steps = said.arrangements.iter();
    let steps = steps.map(|steps| (steps.order, steps.relation, steps.is_reversed));
    assert!(steps.eq([("shift", "onto", true), ("shift the", "onto", false)]));
    let openings = said.openings.iter();
    let openings = openings.map(|opening| (opening.text, opening.pattern));
    assert!(openings.eq([("a pile of", 0), ("heap", 1), ("pile", 0)]));
    let closings = said.closings.iter();
    let closings = closings.map(|closing| (closing.text, closing.pattern, closing.arrangement));
    assert!(closings.eq([("", 0, 1), ("downwards", 0, 0), ("up", 1, 1)]));
    let table = model.table;
    assert_eq!((table.action, table.sides), (0, &[1][..]));
    assert_eq!(table.off, ["down from", "off"]);
    assert_eq!(table.sources, ["from", "out of"]);
    assert_eq!(table.unless, ["away", "far"]);
    assert_eq!((table.removing, table.taking), (&["remove"][..], "shift"));
    assert_eq!(table.down, ["down"]);
    assert_eq!(
        [table.standing, table.order, table.relation],
        ["onto", "then shift the", "onto the"]
    );
    let made = model.compounds.compounds.iter();
    let made = made.map(|one| (one.name, one.phrase, one.kind, one.parts, one.read));
    assert!(made.eq([
        ("Nearby", "nearby", CompoundKind::Any, &[1][..], "near to"),
        ("Both", "both", CompoundKind::All, &[1, 0], "beside"),
    ]));
    assert_eq!(model.compounds.first_words, ["beside", "by", "close"]);
    assert_eq!(model.compounds.sides, ["beyond", "leftwards"]);
    let said = model.compounds.said.iter();
    let said = said.map(|said| (said.text, said.compound));
    assert!(said.eq([("beside and onto", 1), ("by", 0), ("close to", 0)]));
    let heard = model.spelling.heard.iter();
    let heard = heard.map(|heard| (heard.text, heard.read_as));
    assert!(heard.eq([("bare", "beside"), ("steal", "teal")]));
    let mut hashes = ["plumb", "jam", "teak"].map(nsrm_core::language::word_hash);
    hashes.sort_unstable();
    assert_eq!(model.spelling.other_words, hashes);
    let attributes = model.attributes.iter().map(|a| (a.name, a.view));
    let (color, brightness) = (View::Color, View::Brightness);
    assert!(attributes.eq([
        ("tint", color),
        ("bulk", brightness),
        ("finish", brightness)
    ]));
    let concepts = model.concepts.iter().map(|c| (c.name, c.attribute));
    assert!(concepts.eq([
        ("amber", 0),
        ("teal", 0),
        ("plum", 0),
        ("big", 1),
        ("tiny", 1),
        ("matte", 2),
        ("glossy", 2),
    ]));
    let mut edges = model.concepts.iter().filter_map(|c| c.edges_m);
    assert_eq!(edges.next(), Some([0.08, 0.06, 0.05]));
    assert_eq!(edges.next(), Some([0.02, 0.02, 0.03]));
    assert_eq!(edges.next(), None);
    let actions = model.actions.iter().map(|a| (a.name, a.phrase));
    assert!(actions.eq([("Stack", "onto"), ("Flank", "near to")]));
    assert_eq!(owned.training()["seed"], 3);
    assert_eq!(owned.metrics()["program"], 0.5);
}

#[test]
fn embeddings_of_each_word() {
    let file = ModelFile::random(4);
    let owned = file.load();
    let model = owned.as_model();
    let encoder = file.values("language.embedding.weight");
    let splitter = file.values("language.splitter.embedding.weight");
    for token in 0..=WORDS.len() {
        let word = model.embeddings.get(token).unwrap();
        assert!(word.encoder[..] == encoder[32 * token..][..32]);
        assert!(word.splitter[..] == splitter[24 * token..][..24]);
    }
}

#[test]
fn hazard_columns_are_state_and_next_six_tokens() {
    let file = ModelFile::random(5);
    let owned = file.load();
    let layer = owned.as_model().language.hazard_hidden.as_f32().unwrap();
    let weight = file.values("language.splitter.hidden.weight");
    for (column, unit) in [(0, 0), (31, 4), (32, 5), (55, 31), (56, 2), (175, 30)] {
        assert_eq!(layer.weight[column][unit], weight[176 * unit + column]);
    }
    assert!(layer.bias[..] == file.values("language.splitter.hidden.bias")[..]);
}

#[test]
fn weights_of_a_cell_by_column_gate_and_row() {
    let file = ModelFile::random(6);
    let owned = file.load();
    let cell = owned.as_model().language.backward.as_f32().unwrap();
    let weight = file.values("language.encoder.backward.weight_hh");
    for (hidden, gate, unit) in [(0, 0, 0), (5, 1, 7), (47, 2, 3), (3, 2, 47)] {
        let expected = weight[(gate * 48 + unit) * 48 + hidden];
        assert_eq!(cell.weight_hh[hidden][gate][unit], expected);
    }
    let weight = file.values("language.encoder.backward.weight_ih");
    for (input, gate, unit) in [(0, 0, 0), (5, 1, 7), (31, 2, 3), (3, 2, 47)] {
        let expected = weight[(gate * 48 + unit) * 32 + input];
        assert_eq!(cell.weight_ih[input][gate][unit], expected);
    }
    assert!(cell.bias.as_flattened() == file.values("language.encoder.backward.bias"));
    assert_eq!(
        cell.bias_n[..],
        file.values("language.encoder.backward.bias_n")
    );
}

#[test]
fn convolutions_by_channel_row_column_and_output() {
    let file = ModelFile::random(7);
    let owned = file.load();
    let view = owned.as_model().vision.expect("all parts").color;
    let patch = file.values("vision.color.patch.weight");
    let merge = file.values("vision.color.merge.weight");
    for (output, input, row, column) in [(0, 0, 0, 1), (23, 2, 3, 0), (11, 1, 2, 3)] {
        let expected = patch[((output * 3 + input) * 4 + row) * 4 + column];
        assert_eq!(view.patch.weight[input][row][column][output], expected);
    }
    for (output, input, row, column) in [(31, 0, 1, 0), (2, 23, 0, 1)] {
        let expected = merge[((output * 24 + input) * 2 + row) * 2 + column];
        assert_eq!(view.merge.weight[row][column][input][output], expected);
    }
    let dense = file.values("vision.color.dense.weight");
    let layer = view.dense.as_f32().unwrap();
    for (channel, pixel, output) in [(31, 15, 3), (1, 0, 31), (0, 1, 0)] {
        let expected = dense[output * 512 + channel * 16 + pixel];
        assert_eq!(layer.weight[pixel * 32 + channel][output], expected);
    }
    assert_eq!(layer.bias[..], file.values("vision.color.dense.bias"));
}

#[test]
fn operators_of_each_attribute() {
    let file = ModelFile::random(8);
    let owned = file.load();
    for attribute in owned.as_model().attributes {
        let name = format!("vision.operator.{}", attribute.name);
        let weight = file.values(&format!("{name}.output.weight"));
        assert_eq!(attribute.output.weight[31][9], weight[9 * 32 + 31]);
        assert_eq!(
            attribute.hidden.bias[..],
            file.values(&format!("{name}.hidden.bias"))
        );
    }
}

#[test]
fn concepts_have_length_one_and_their_direction() {
    let file = ModelFile::random(9);
    let owned = file.load();
    let weight = file.values("vision.concept.weight");
    let model = owned.as_model();
    assert_eq!(model.concepts.len(), CONCEPTS);
    for (index, concept) in model.concepts.iter().enumerate() {
        let raw = row(&weight, index, 16);
        let length = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
        concept
            .embedding
            .iter()
            .zip(raw)
            .for_each(|(&x, raw)| assert_close(x, raw / length));
    }
}

#[test]
fn simulator_on_plain_locations() {
    let file = ModelFile::random(10);
    let owned = file.load();
    let model = owned.as_model();
    let mean = file.values("action.simulator.location_mean");
    let scale = file.values("action.simulator.location_scale");
    let locations = [0.25, 0.5, 0.125, 0.0625, 0.9, 0.75, 0.375, 0.25, 0.3, 1.1];
    for action in 0..ACTIONS {
        let mut input = vec![0.0; ACTIONS];
        input[action] = 1.0;
        input.extend(
            locations.iter().enumerate().map(|(j, &x): (usize, &f64)| {
                (x - f64::from(mean[j % 5])) / f64::from(scale[j % 5])
            }),
        );
        let weight = file.values("action.simulator.input.weight");
        let bias = file.values("action.simulator.input.bias");
        let expected = affine(&weight, &bias, &input);
        for (unit, expected) in expected.into_iter().enumerate() {
            let columns = model.simulator.input.iter().zip(&locations);
            let products = columns.map(|(column, x)| f64::from(column[unit]) * x);
            let sum = products.sum::<f64>() + f64::from(model.actions[action].simulator_bias[unit]);
            assert!((sum - expected).abs() < ROUNDED, "{sum} is not {expected}");
        }
        let decoder = file.values("language.action_decoder.weight");
        assert_eq!(
            model.actions[action].decoder[..],
            decoder[action * 96..][..96]
        );
        let bias = file.values("language.action_decoder.bias");
        assert_eq!(model.actions[action].decoder_bias, bias[action]);
        // First those that restrict, then those that stand for an object.
        let decoder = file.values("language.relation_decoder.weight");
        let bias = file.values("language.relation_decoder.bias");
        for (side, row) in [action, RELATIONS + action].into_iter().enumerate() {
            assert_eq!(
                model.actions[action].relation_decoder[side][..],
                decoder[row * 96..][..96]
            );
            assert_eq!(model.actions[action].relation_bias[side], bias[row]);
        }
    }
    let decoder = file.values("language.relation_decoder.weight");
    let bias = file.values("language.relation_decoder.bias");
    let superlatives = [model.language.nearest, model.language.farthest];
    for (relation, superlative) in (ACTIONS..).zip(superlatives) {
        for (side, row) in [relation, RELATIONS + relation].into_iter().enumerate() {
            assert_eq!(superlative.decoder[side][..], decoder[row * 96..][..96]);
            assert_eq!(superlative.bias[side], bias[row]);
        }
    }
}

#[test]
fn simulator_output_is_scaled() {
    let file = ModelFile::random(11);
    let owned = file.load();
    let output = &owned.as_model().simulator.output;
    let weight = file.values("action.simulator.output.weight");
    assert_close(output.weight[63][2], f64::from(weight[2 * 64 + 63]) * 0.1);
    let bias = file.values("action.simulator.output.bias");
    assert_close(output.bias[4], f64::from(bias[4]) * 0.1);
}

#[test]
fn camera_by_rows() {
    let file = ModelFile::random(12);
    let owned = file.load();
    let camera = owned.as_model().camera;
    assert_eq!(camera.weight.as_flattened(), file.values("camera.weight"));
}

/// Whether the rows of a rounded matrix are those of the file's, within half a step.
fn rounds<const COLUMNS: usize>(rows: &[[i8; COLUMNS]], scales: &[f32], weight: &[f32]) -> bool {
    let mut pairs = rows.iter().zip(scales).zip(weight.chunks_exact(COLUMNS));
    rows.len() * COLUMNS == weight.len()
        && pairs.all(|((row, &scale), weights)| {
            let mut pairs = row.iter().zip(weights);
            pairs.all(|(&rounded, &weight)| {
                (f32::from(rounded) * scale - weight).abs() <= 0.5 * scale * 1.001
            })
        })
}

#[test]
fn rounded_weights_are_those_of_the_file_within_half_a_step() {
    let file = ModelFile::random(13);
    let owned = file.load_as(Precision::Int8);
    let model = owned.as_model();
    let exact = file.load();
    let exact = exact.as_model();
    assert_eq!(model.embeddings.precision(), Precision::Int8);
    let language = model.language;
    let layers = [
        ("language.object_decoder", language.object_decoder),
        ("language.reference_decoder", language.reference_decoder),
    ];
    for (name, layer) in layers {
        let Dense::Int8(layer) = layer else {
            panic!("{name} is not rounded");
        };
        let weight = file.values(&format!("{name}.weight"));
        assert!(rounds(&layer.weight, &layer.scale, &weight), "{name}");
        assert_eq!(layer.bias[..], file.values(&format!("{name}.bias")));
    }
    let (Dense::Int8(hidden), Dense::Int8(hazard), Dense::Int8(simulator)) = (
        language.acceptability_hidden,
        language.hazard_hidden,
        model.simulator.hidden,
    ) else {
        panic!("a layer is not rounded");
    };
    let weight = file.values("language.acceptability.hidden.weight");
    assert!(rounds(&hidden.weight, &hidden.scale, &weight));
    let weight = file.values("language.splitter.hidden.weight");
    assert!(rounds(&hazard.weight, &hazard.scale, &weight));
    let weight = file.values("action.simulator.hidden.weight");
    assert!(rounds(&simulator.weight, &simulator.scale, &weight));
    let cells = [
        ("language.encoder.forward", language.forward),
        ("language.encoder.backward", language.backward),
    ];
    for (name, cell) in cells {
        let Cell::Int8(cell) = cell else {
            panic!("{name} is not rounded");
        };
        let (rows, scales) = (cell.weight_ih.as_flattened(), cell.scale_ih.as_flattened());
        let weight = file.values(&format!("{name}.weight_ih"));
        assert!(rounds(rows, scales, &weight), "{name}");
        let (rows, scales) = (cell.weight_hh.as_flattened(), cell.scale_hh.as_flattened());
        let weight = file.values(&format!("{name}.weight_hh"));
        assert!(rounds(rows, scales, &weight), "{name}");
        assert!(cell.bias.as_flattened() == file.values(&format!("{name}.bias")));
        assert!(cell.bias_n[..] == file.values(&format!("{name}.bias_n"))[..]);
    }
    let Cell::Int8(splitter) = language.splitter else {
        panic!("the splitter is not rounded");
    };
    let rows = splitter.weight_hh.as_flattened();
    let weight = file.values("language.splitter.gru.weight_hh");
    assert!(rounds(rows, splitter.scale_hh.as_flattened(), &weight));
    let (vision, exact_vision) = (model.vision.unwrap(), exact.vision.unwrap());
    for (rounded, exact) in [
        (vision.color.dense, exact_vision.color.dense),
        (vision.brightness.dense, exact_vision.brightness.dense),
    ] {
        let input: [f32; 512] = std::array::from_fn(|index| (index % 7) as f32);
        let results = rounded.apply(&input).into_iter().zip(exact.apply(&input));
        for (rounded, exact) in results {
            assert!(
                (rounded - exact).abs() < 0.02 * input.iter().sum::<f32>(),
                "{rounded}"
            );
        }
    }
    for token in 0..=WORDS.len() {
        let (rounded, exact) = (model.embeddings.get(token), exact.embeddings.get(token));
        let pairs = rounded
            .unwrap()
            .encoder
            .into_iter()
            .zip(exact.unwrap().encoder);
        for (rounded, exact) in pairs {
            assert!((rounded - exact).abs() < 0.01, "token {token}");
        }
    }
}
