use std::path::Path;

use anyhow::{Context as _, Result, bail};
use nsrm_core::language::TokenKind;
use nsrm_core::model::{CROP, LOCATION, OBJECT_EMBEDDING, SPLITTER_WORD, WORD};
use nsrm_tabletop::TABLETOP;
use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensors, serialize_to_file};

use crate::{Job, Table};

/// The numbers of a tensor, row by row.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// Real numbers.
    Real(Vec<f32>),
    /// Indices.
    Index(Vec<i64>),
    /// Yes or no.
    Flag(Vec<bool>),
}

/// An input, by the name that it has in the graphs.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    /// Its name.
    pub name: String,
    /// Its sizes.
    pub shape: Vec<usize>,
    /// Its numbers.
    pub numbers: Numbers,
}

/// What all contenders compute from:
///
/// * `tokens` `[12]`: rows of the word embeddings; 0 is a group of concept words
/// * `filters` `[12, C]`: the concepts of each token
/// * `words` `[12, 1, 32]`, `splitter_words` `[12, 1, 24]`: the tokens' embeddings
/// * `embeddings` `[6, 64]`, `locations` `[6, 5]`: of the objects
/// * `action` `[1]`, `pair` `[1, 10]`: the simulator's
/// * `crops` `[6, 3, 32, 32]`: of the objects, 0..1
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs(Vec<Tensor>);

impl Inputs {
    /// Those of a table with our model.
    pub fn new(table: &Table) -> Result<Self> {
        let tokens = &table.tokens;
        let embeddings = tokens
            .iter()
            .map(|token| token.embeddings(&TABLETOP).context("a token of this model"));
        let embeddings: Vec<_> = embeddings.collect::<Result<_>>()?;
        // Row 0 of the model file's embeddings is the group's, the words follow in our order.
        let rows = tokens.iter().map(|token| match token.kind {
            TokenKind::Word(index) => i64::from(index) + 1,
            _ => 0,
        });
        let concepts = 0..TABLETOP.concepts.len();
        let filters = tokens.iter().flat_map(|token| {
            let of = token
                .filters()
                .map_or(&[][..], |filters| filters.concepts());
            let has = move |concept| of.iter().any(|&other| usize::from(other) == concept);
            concepts.clone().map(has)
        });
        let objects = table.scene.objects();
        let pair = objects.iter().take(2).flat_map(|object| object.location);
        let crops = table.crops.iter().flat_map(|crop| &crop.channels);
        let locations = objects.iter().flat_map(|object| object.location);
        let of_objects = objects.iter().flat_map(|object| object.embedding);
        let count = tokens.len();
        Ok(Self(vec![
            Tensor::new("tokens", &[count], Numbers::Index(rows.collect())),
            Tensor::new(
                "filters",
                &[count, concepts.len()],
                Numbers::Flag(filters.collect()),
            ),
            Tensor::real(
                "words",
                &[count, 1, WORD],
                embeddings.iter().flat_map(|word| word.encoder),
            ),
            Tensor::real(
                "splitter_words",
                &[count, 1, SPLITTER_WORD],
                embeddings.iter().flat_map(|word| word.splitter),
            ),
            Tensor::real("embeddings", &[objects.len(), OBJECT_EMBEDDING], of_objects),
            Tensor::real("locations", &[objects.len(), LOCATION], locations),
            Tensor::new("action", &[1], Numbers::Index(vec![0])),
            Tensor::real("pair", &[1, 2 * LOCATION], pair),
            Tensor::real(
                "crops",
                &[objects.len(), 3, CROP, CROP],
                crops.flatten().flatten().copied(),
            ),
        ]))
    }

    /// Reads them from a file.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
        let file = SafeTensors::deserialize(&bytes)
            .with_context(|| format!("{}: no inputs", path.display()))?;
        let tensors = file.iter().map(|(name, view)| Tensor::of(name, &view));
        Ok(Self(tensors.collect::<Result<_>>()?))
    }

    /// Writes them to a file.
    pub fn write(&self, path: &Path) -> Result<()> {
        let bytes: Vec<_> = self.0.iter().map(Tensor::bytes).collect();
        let views = self.0.iter().zip(&bytes).map(|(tensor, (dtype, bytes))| {
            let view = TensorView::new(*dtype, tensor.shape.clone(), bytes)?;
            Ok((tensor.name.clone(), view))
        });
        let views = views.collect::<Result<Vec<_>>>()?;
        serialize_to_file(views, None, path).with_context(|| format!("writing {}", path.display()))
    }

    /// Those of a job, in the order of its graph's inputs.
    pub fn of(&self, job: Job) -> Result<Vec<Tensor>> {
        let names: &[&str] = match job {
            Job::Plan => &["tokens", "filters", "embeddings", "locations"],
            Job::Encoder => &["words"],
            Job::Splitter => &["splitter_words"],
            Job::Simulator => &["action", "pair"],
            Job::Crop | Job::Crops => &["crops"],
        };
        let tensors = names.iter().map(|name| {
            let tensor = self.get(name)?;
            Ok(match job {
                Job::Crop => tensor.first_row(),
                _ => tensor.clone(),
            })
        });
        tensors.collect()
    }

    /// The tensor of this name.
    pub fn get(&self, name: &str) -> Result<&Tensor> {
        let found = self.0.iter().find(|tensor| tensor.name == name);
        found.with_context(|| format!("the inputs lack {name}"))
    }
}

impl Tensor {
    fn new(name: &str, shape: &[usize], numbers: Numbers) -> Self {
        Self {
            name: name.to_owned(),
            shape: shape.to_vec(),
            numbers,
        }
    }

    fn real(name: &str, shape: &[usize], numbers: impl Iterator<Item = f32>) -> Self {
        Self::new(name, shape, Numbers::Real(numbers.collect()))
    }

    /// The first row alone, as a tensor of one row.
    fn first_row(&self) -> Self {
        let row = self.shape.iter().skip(1).product();
        let mut first = self.clone();
        first.shape[0] = 1;
        match &mut first.numbers {
            Numbers::Real(numbers) => numbers.truncate(row),
            Numbers::Index(numbers) => numbers.truncate(row),
            Numbers::Flag(numbers) => numbers.truncate(row),
        }
        first
    }

    fn of(name: &str, view: &TensorView<'_>) -> Result<Self> {
        let data = view.data();
        let numbers = match view.dtype() {
            Dtype::F32 => {
                let numbers = data.as_chunks().0.iter();
                Numbers::Real(numbers.map(|bytes| f32::from_le_bytes(*bytes)).collect())
            }
            Dtype::I64 => {
                let numbers = data.as_chunks().0.iter();
                Numbers::Index(numbers.map(|bytes| i64::from_le_bytes(*bytes)).collect())
            }
            Dtype::BOOL => Numbers::Flag(data.iter().map(|&byte| byte != 0).collect()),
            other => bail!("{name}: numbers of the type {other:?}"),
        };
        Ok(Self::new(name, view.shape(), numbers))
    }

    fn bytes(&self) -> (Dtype, Vec<u8>) {
        match &self.numbers {
            Numbers::Real(numbers) => {
                let bytes = numbers.iter().flat_map(|number| number.to_le_bytes());
                (Dtype::F32, bytes.collect())
            }
            Numbers::Index(numbers) => {
                let bytes = numbers.iter().flat_map(|number| number.to_le_bytes());
                (Dtype::I64, bytes.collect())
            }
            Numbers::Flag(numbers) => (
                Dtype::BOOL,
                numbers.iter().map(|&flag| u8::from(flag)).collect(),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_gives_the_inputs_back() {
        let inputs = Inputs::new(&Table::new().unwrap()).unwrap();
        let path = std::env::temp_dir().join(format!("inputs-{}.safetensors", std::process::id()));
        inputs.write(&path).unwrap();
        let read = Inputs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        for tensor in &inputs.0 {
            assert_eq!(read.get(&tensor.name).unwrap(), tensor);
        }
    }

    #[test]
    fn the_sentence_has_twelve_tokens_and_two_descriptions() {
        let inputs = Inputs::new(&Table::new().unwrap()).unwrap();
        let [tokens, filters, ..] = &inputs.of(Job::Plan).unwrap()[..] else {
            panic!("a plan has four inputs");
        };
        let Numbers::Index(tokens) = &tokens.numbers else {
            panic!("tokens are indices");
        };
        let groups = tokens.iter().filter(|&&token| token == 0).count();
        assert_eq!((tokens.len(), groups), (12, 2));
        let Numbers::Flag(filters) = &filters.numbers else {
            panic!("filters are flags");
        };
        // Blue; small and yellow.
        assert_eq!(filters.iter().filter(|&&flag| flag).count(), 3);
    }

    #[test]
    fn one_crop_is_the_first_of_six() {
        let inputs = Inputs::new(&Table::new().unwrap()).unwrap();
        let (one, six) = (
            inputs.of(Job::Crop).unwrap(),
            inputs.of(Job::Crops).unwrap(),
        );
        assert_eq!(
            (&one[0].shape[..], six[0].shape[0]),
            (&[1, 3, 32, 32][..], 6)
        );
    }
}
