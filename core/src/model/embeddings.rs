use super::{SPLITTER_WORD, WORD};
use crate::nn::{Precision, round_row};

/// The embeddings of a model's tokens, in one of the precisions that there are.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Embeddings<'a> {
    /// As trained.
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    F32(&'a [WordEmbeddings]),
    /// Rounded. Needs the feature `int8`.
    #[cfg(feature = "int8")]
    Int8(&'a [Int8WordEmbeddings]),
}

/// A token's embeddings.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct WordEmbeddings {
    /// At the input of both of the encoder's cells.
    pub encoder: [f32; WORD],
    /// At the input of the splitter's cell and of the hazard's hidden layer.
    pub splitter: [f32; SPLITTER_WORD],
}

/// A token's embeddings in whole numbers, one scale each.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Int8WordEmbeddings {
    /// At the input of both of the encoder's cells.
    pub encoder: [i8; WORD],
    /// What 1 in `encoder` stands for.
    pub encoder_scale: f32,
    /// At the input of the splitter's cell and of the hazard's hidden layer.
    pub splitter: [i8; SPLITTER_WORD],
    /// What 1 in `splitter` stands for.
    pub splitter_scale: f32,
}

impl Embeddings<'_> {
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    pub(super) const NONE: Self = Self::F32(&[]);
    #[cfg(all(feature = "int8", not(feature = "f32")))]
    pub(super) const NONE: Self = Self::Int8(&[]);

    /// The number of tokens.
    pub const fn count(&self) -> usize {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(rows) => rows.len(),
            #[cfg(feature = "int8")]
            Self::Int8(rows) => rows.len(),
        }
    }

    /// Their precision, which is that of a model's layers.
    pub const fn precision(&self) -> Precision {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(_) => Precision::F32,
            #[cfg(feature = "int8")]
            Self::Int8(_) => Precision::Int8,
        }
    }

    /// A token's embeddings.
    pub fn get(&self, token: usize) -> Option<WordEmbeddings> {
        Some(WordEmbeddings {
            encoder: self.encoder(token)?,
            splitter: self.splitter(token)?,
        })
    }

    /// A token at the input of the encoder's cells.
    pub fn encoder(&self, token: usize) -> Option<[f32; WORD]> {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(rows) => rows.get(token).map(|row| row.encoder),
            #[cfg(feature = "int8")]
            Self::Int8(rows) => {
                let row = rows.get(token)?;
                Some(row.encoder.map(|x| f32::from(x) * row.encoder_scale))
            }
        }
    }

    /// A token at the input of the splitter's cell and of the hazard's hidden layer.
    pub fn splitter(&self, token: usize) -> Option<[f32; SPLITTER_WORD]> {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(rows) => rows.get(token).map(|row| row.splitter),
            #[cfg(feature = "int8")]
            Self::Int8(rows) => {
                let row = rows.get(token)?;
                Some(row.splitter.map(|x| f32::from(x) * row.splitter_scale))
            }
        }
    }
}

impl Int8WordEmbeddings {
    /// A token's embeddings, each rounded to 255 steps.
    pub fn of(token: &WordEmbeddings) -> Self {
        let mut rounded = Self {
            encoder: [0; WORD],
            encoder_scale: 0.0,
            splitter: [0; SPLITTER_WORD],
            splitter_scale: 0.0,
        };
        rounded.encoder_scale = round_row(&mut rounded.encoder, token.encoder.iter().copied());
        rounded.splitter_scale = round_row(&mut rounded.splitter, token.splitter.iter().copied());
        rounded
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_embeddings_are_within_half_a_step() {
        let token = WordEmbeddings {
            encoder: core::array::from_fn(|index| libm::sinf(index as f32)),
            splitter: core::array::from_fn(|index| 10.0 * libm::cosf(index as f32)),
        };
        let (rows, small) = ([token], [Int8WordEmbeddings::of(&token)]);
        let (rows, small) = (Embeddings::F32(&rows), Embeddings::Int8(&small));
        let close = |left: &[f32], right: &[f32], step: f32| {
            left.iter()
                .zip(right)
                .all(|(left, right)| (left - right).abs() <= 0.5 * step)
        };
        let (exact, rounded) = (rows.encoder(0).unwrap(), small.encoder(0).unwrap());
        assert!(close(&exact, &rounded, 1.001 / 127.0), "{rounded:?}");
        let (exact, rounded) = (rows.splitter(0).unwrap(), small.splitter(0).unwrap());
        assert!(close(&exact, &rounded, 10.001 / 127.0), "{rounded:?}");
        assert!(small.encoder(1).is_none() && small.splitter(1).is_none());
    }
}
