//! A model file for the tests: a small domain, every tensor of the architecture, and ways to damage
//! each of them.
#![allow(
    dead_code,
    reason = "each test binary compiles this module and uses its part"
)]

use std::collections::BTreeMap;
use std::f32::consts::FRAC_1_SQRT_2;

use nsrm_codegen::{ModelError, OwnedModel};
use nsrm_core::dsl::{Extreme, Property, Quantifier};
use nsrm_core::nn::Precision;
use serde_json::{Value, json};

/// A tensor of the file.
#[derive(Clone)]
pub(crate) struct Tensor {
    pub(crate) dtype: &'static str,
    pub(crate) shape: Vec<usize>,
    pub(crate) bytes: Vec<u8>,
}

/// The parts of a model file.
#[derive(Clone)]
pub(crate) struct ModelFile {
    pub(crate) metadata: BTreeMap<String, String>,
    pub(crate) tensors: BTreeMap<String, Tensor>,
}

/// Words of [`domain`]'s grammar, sorted.
pub(crate) const WORDS: [&str; 9] = [
    ",", "beside", "jar", "near", "onto", "shift", "the", "then", "to",
];
/// Its lexicon, sorted.
pub(crate) const LEXICON: [(&str, Property); 13] = [
    ("amber", Property::Concept(0)),
    ("bench", Property::Table),
    ("big", Property::Concept(3)),
    ("both", Property::Quantifier(Quantifier::Both)),
    ("every", Property::Quantifier(Quantifier::All)),
    ("glossy", Property::Concept(6)),
    ("largest", Property::Extreme(Extreme::Largest)),
    ("matte", Property::Concept(5)),
    ("orange", Property::Concept(0)),
    ("outermost", Property::Extreme(Extreme::Action(1))),
    ("plum", Property::Concept(2)),
    ("teal", Property::Concept(1)),
    ("tiny", Property::Concept(4)),
];
pub(crate) const ACTIONS: usize = 2;
/// Those of the actions, and the superlatives.
pub(crate) const RELATIONS: usize = ACTIONS + 2;
pub(crate) const CONCEPTS: usize = 7;

/// Looks straight down on the table; image right is the world's −y, image down its −x.
pub(crate) fn training_camera() -> Value {
    json!({
        "width": 640,
        "height": 480,
        "fx": 500.0,
        "fy": 500.0,
        "cx": 320.0,
        "cy": 240.0,
        "position": [0.5, 0.0, 0.645],
        "orientation": [FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.0, 0.0],
    })
}

/// Three attribute types and two actions, with other names than in tabletop.
pub(crate) fn domain() -> Value {
    json!({
        "name": "shelf",
        "attribute": [
            {"name": "tint", "view": "color", "values": [
                {"name": "amber", "words": ["orange", "amber"], "rgb": [0.9, 0.6, 0.1]},
                {"name": "teal", "words": ["teal"]},
                {"name": "plum", "words": ["plum"]},
            ]},
            {"name": "bulk", "view": "brightness", "values": [
                {"name": "big", "words": ["big"], "edges_m": [0.08, 0.06, 0.05]},
                {"name": "tiny", "words": ["tiny"], "edges_m": [0.02, 0.02, 0.03]},
            ]},
            {"name": "finish", "view": "brightness", "values": [
                {"name": "matte", "words": ["matte"]},
                {"name": "glossy", "words": ["glossy"]},
            ]},
        ],
        "action": [
            {"name": "Stack", "place": "on", "phrases": ["onto"]},
            {"name": "Flank", "place": "beside", "phrases": ["near to", "beside"]},
        ],
        "grammar": {
            "verbs": ["shift"],
            "nouns": ["jar", ""],
            "descriptions": ["the {values} {noun}"],
            "commands": ["{verb} {moved} {relation} {reference}"],
            "connectives": [", then", "then"],
        },
        "extremes": {"Flank": ["outermost"], "Largest": ["largest"]},
        "pronouns": {"then": "", "near": "jar"},
        "placing": ["shift", "near"],
        "conjunctions": ["so that"],
        "several": {
            "all": ["every"],
            "both": ["both"],
            "between": ["the"],
            "plurals": {"jars": "jar"},
        },
        "rephrasing": {"is supposed to": "then", "do so": ""},
        "simplification": {"opening": {"so": ""}, "anywhere": {"uh": "", "by then": "then"}, "closing": {"then": ""}, "connecting": {"and then": ""}, "starting": ["first"], "standing": {"clauses": ["that is"], "relations": ["near"], "read_as": "jar near"}, "taking": {"words": ["take", "lift"], "towards": ["onto"], "order": "shift", "object": "then"}},
        "exceptions": {"phrases": ["except for", "except"], "negations": ["that is not"]},
        "perspectives": {"own": ["as i see it"], "other": ["from there", "as you see it"], "opposites": {"Flank": "Stack", "Stack": "Flank"}},
        "lists": {"between": ["as well as"], "them": ["those", "both"], "stacking": ["heap"], "aside": ["near"], "next": ", then"},
        "repairs": {"corrections": ["oh no", "no"], "exclusions": ["not"]},
        "sequence": {
            "later": {"before you": "", "before shifting": "shift"},
            "earlier": {"after you": ""},
            "afterthoughts": ["but first", "although first"],
            "next": ", then",
        },
        "distances": {
            "sides": ["Flank"],
            "units": {"mm": 1, "cm": 10.0},
            "numbers": {"half a": 0.5, "a": 1},
            "before": ["by", "at a distance of"],
            "behind": ["away"],
            "from": ["off"],
            "beside": "beside",
            "unless": ["the"],
            "shifts": {"Flank": ["sideways", "aside"]},
            "origins": ["from there"],
            "usual_mm": 25,
        },
        "apart": {"between": ["and"], "phrases": ["whose finish is", "then"]},
        "ordinals": {
            "counts": [["first"], ["second", "2nd"]],
            "starts": {"from outside": "Flank"},
            "first": {"far out": "Flank"},
            "articles": ["the"],
            "nouns": ["jar", "box"],
            "unless": ["of"],
        },
        "arrangements": {
            "between": ["and", ","],
            "ends": ["then"],
            "next": ", then",
            "steps": {
                "up": {"action": "Stack", "order": "shift the", "relation": "onto"},
                "down": {"action": "Stack", "order": "shift", "relation": "onto", "reversed": true},
            },
            "patterns": [
                {"openings": ["pile", "a pile of"], "closings": {"": "up", "downwards": "down"}},
                {"openings": ["heap"], "closings": {"up": "up"}},
            ],
        },
        "table": {
            "words": ["bench"],
            "action": "Stack",
            "sides": ["Flank"],
            "off": ["off", "down from"],
            "sources": ["out of", "from"],
            "unless": ["far", "away"],
            "removing": ["remove"],
            "taking": "shift",
            "standing": "onto",
            "order": "then shift the",
            "down": ["down"],
            "relation": "onto the",
        },
        "compounds": {"sides": ["leftwards", "beyond"], "made": [
            {
                "name": "Nearby", "phrase": "nearby", "any": ["Flank"], "read": "near to",
                "said": ["close to", "by"],
            },
            {
                "name": "Both", "phrase": "both", "all": ["Flank", "Stack"], "read": "beside",
                "said": ["beside and onto"],
            },
        ]},
        "spelling": {
            "heard": {"steal": "teal", "bare": "beside"},
            "other_words": ["plumb", "jam", "teak"],
            "language": "en",
        },
    })
}

/// Names and shapes, as specified for the model file.
fn shapes() -> Vec<(String, Vec<usize>)> {
    let words = WORDS.len() + 1;
    let mut shapes: Vec<(String, Vec<usize>)> = Vec::new();
    let mut add = |name: &str, shape: &[usize]| shapes.push((name.into(), shape.to_vec()));
    add("language.embedding.weight", &[words, 32]);
    for direction in ["forward", "backward"] {
        let cell = format!("language.encoder.{direction}");
        add(&format!("{cell}.weight_ih"), &[144, 32]);
        add(&format!("{cell}.weight_hh"), &[144, 48]);
        add(&format!("{cell}.bias"), &[144]);
        add(&format!("{cell}.bias_n"), &[48]);
    }
    add("language.action_decoder.weight", &[ACTIONS, 96]);
    add("language.action_decoder.bias", &[ACTIONS]);
    add("language.relation_decoder.weight", &[2 * RELATIONS, 96]);
    add("language.relation_decoder.bias", &[2 * RELATIONS]);
    for decoder in ["object", "reference"] {
        add(&format!("language.{decoder}_decoder.weight"), &[96, 96]);
        add(&format!("language.{decoder}_decoder.bias"), &[96]);
    }
    add("language.acceptability.hidden.weight", &[16, 96]);
    add("language.acceptability.hidden.bias", &[16]);
    add("language.acceptability.output.weight", &[1, 16]);
    add("language.acceptability.output.bias", &[1]);
    add("language.splitter.embedding.weight", &[words, 24]);
    add("language.splitter.gru.weight_ih", &[96, 24]);
    add("language.splitter.gru.weight_hh", &[96, 32]);
    add("language.splitter.gru.bias", &[96]);
    add("language.splitter.gru.bias_n", &[32]);
    add("language.splitter.hidden.weight", &[32, 176]);
    add("language.splitter.hidden.bias", &[32]);
    add("language.splitter.hazard.weight", &[1, 32]);
    add("language.splitter.hazard.bias", &[1]);
    for (view, channels) in [("color", 3), ("brightness", 1)] {
        add(
            &format!("vision.{view}.patch.weight"),
            &[24, channels, 4, 4],
        );
        add(&format!("vision.{view}.patch.bias"), &[24]);
        add(&format!("vision.{view}.merge.weight"), &[32, 24, 2, 2]);
        add(&format!("vision.{view}.merge.bias"), &[32]);
        add(&format!("vision.{view}.dense.weight"), &[32, 512]);
        add(&format!("vision.{view}.dense.bias"), &[32]);
    }
    for attribute in ["tint", "bulk", "finish"] {
        add(
            &format!("vision.operator.{attribute}.hidden.weight"),
            &[32, 32],
        );
        add(&format!("vision.operator.{attribute}.hidden.bias"), &[32]);
        add(
            &format!("vision.operator.{attribute}.output.weight"),
            &[16, 32],
        );
        add(&format!("vision.operator.{attribute}.output.bias"), &[16]);
    }
    add("vision.concept.weight", &[CONCEPTS, 16]);
    add("action.simulator.input.weight", &[64, ACTIONS + 10]);
    add("action.simulator.input.bias", &[64]);
    add("action.simulator.hidden.weight", &[64, 64]);
    add("action.simulator.hidden.bias", &[64]);
    add("action.simulator.output.weight", &[5, 64]);
    add("action.simulator.output.bias", &[5]);
    add("action.simulator.location_mean", &[5]);
    add("action.simulator.location_scale", &[5]);
    add("camera.weight", &[3, 6]);
    shapes
}

impl ModelFile {
    /// Values drawn from a seed, between -0.5 and 0.5; scales between 0.5 and 1.5.
    pub(crate) fn random(seed: u64) -> Self {
        let mut state = seed;
        Self::with(|name, _| {
            let offset = if name.ends_with("location_scale") {
                1.0
            } else {
                0.0
            };
            uniform(&mut state) + offset
        })
    }

    /// One value for each tensor, or for each row of some: a file whose source is short.
    pub(crate) fn flat() -> Self {
        Self::with(|name, row| match name {
            "action.simulator.location_scale" => 0.5,
            _ => ((name.len() % 13) as f32 - 6.0) / 64.0 + row as f32 / 8.0,
        })
    }

    /// * `value`: from a tensor's name and the element's row
    fn with(mut value: impl FnMut(&str, usize) -> f32) -> Self {
        let mut tensors = BTreeMap::new();
        for (name, shape) in shapes() {
            let rows = if name.ends_with("embedding.weight") {
                shape[0]
            } else {
                1
            };
            let count: usize = shape.iter().product();
            let bytes = (0..count)
                .flat_map(|index| value(&name, index * rows / count).to_le_bytes())
                .collect();
            let dtype = "F32";
            tensors.insert(
                name,
                Tensor {
                    dtype,
                    shape,
                    bytes,
                },
            );
        }
        let mut words = vec!["[[X]]"];
        words.extend(WORDS);
        let mut file = Self {
            metadata: BTreeMap::new(),
            tensors,
        };
        file.set("schema", json!(nsrm_core::model::SCHEMA));
        file.set("domain", domain());
        file.set("vocabulary", json!(words));
        file.set("dimensions", json!({"word": 32, "encoder_hidden": 48}));
        file.set("thresholds", json!({"match_score": 0.5, "decision": 0.75}));
        file.set(
            "work_space",
            json!({"min": [0.25, -0.5, 0.0], "max": [0.75, 0.5, 0.25]}),
        );
        file.set("placed_orientation", json!([0.0, 0.0, 0.0, 1.0]));
        file.set("training_camera", training_camera());
        file.set("training", json!({"seed": 3}));
        file.set("metrics", json!({"program": 0.5}));
        file
    }

    pub(crate) fn set(&mut self, key: &str, value: Value) {
        self.metadata.insert(key.into(), value.to_string());
    }

    pub(crate) fn tensor(&mut self, name: &str) -> &mut Tensor {
        self.tensors
            .get_mut(name)
            .expect("a tensor of the architecture")
    }

    /// Values of a tensor, row-major.
    pub(crate) fn values(&self, name: &str) -> Vec<f32> {
        let (values, _) = self.tensors[name].bytes.as_chunks::<4>();
        values.iter().copied().map(f32::from_le_bytes).collect()
    }

    pub(crate) fn set_value(&mut self, name: &str, index: usize, value: f32) {
        self.tensor(name).bytes[4 * index..][..4].copy_from_slice(&value.to_le_bytes());
    }

    /// The file's bytes; if the metadata have no `hash`, with the one that the loader expects.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        if self.metadata.contains_key("hash") {
            return self.with_metadata(&self.metadata);
        }
        let mut metadata = self.metadata.clone();
        metadata.insert("hash".into(), "0".repeat(64));
        let file = self.with_metadata(&metadata);
        match OwnedModel::from_bytes(&file) {
            Err(ModelError::Hash { got, .. }) => {
                metadata.insert("hash".into(), got);
                self.with_metadata(&metadata)
            }
            // Refused before its hash is checked.
            _ => file,
        }
    }

    fn with_metadata(&self, metadata: &BTreeMap<String, String>) -> Vec<u8> {
        let mut header = serde_json::Map::new();
        header.insert("__metadata__".into(), json!(metadata));
        let mut content: Vec<u8> = Vec::new();
        for (
            name,
            Tensor {
                dtype,
                shape,
                bytes,
            },
        ) in &self.tensors
        {
            let start = content.len();
            content.extend(bytes);
            let offsets = [start, content.len()];
            let entry = json!({"dtype": dtype, "shape": shape, "data_offsets": offsets});
            header.insert(name.clone(), entry);
        }
        let mut header = Value::Object(header).to_string().into_bytes();
        header.resize(header.len().next_multiple_of(8), b' ');
        let mut file = (header.len() as u64).to_le_bytes().to_vec();
        file.extend(header);
        file.extend(content);
        file
    }

    pub(crate) fn load(&self) -> OwnedModel {
        OwnedModel::from_bytes(&self.bytes()).expect("a sound model file")
    }

    pub(crate) fn load_as(&self, precision: Precision) -> OwnedModel {
        OwnedModel::from_bytes_as(&self.bytes(), precision).expect("a sound model file")
    }

    pub(crate) fn refusal(&self) -> ModelError {
        OwnedModel::from_bytes(&self.bytes()).expect_err("a refusal")
    }
}

/// SplitMix64, between -0.5 and 0.5.
fn uniform(state: &mut u64) -> f32 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut bits = *state;
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^= bits >> 31;
    (bits >> 40) as f32 / (1u64 << 24) as f32 - 0.5
}
