//! From an image to concepts (section IV-C): a crop for each object, its
//! embedding by a small convolutional network, an operator for each attribute
//! type into the concept space, and the cosine with a concept there.

mod concepts;
mod crop;
mod encoder;
mod observer;
mod resample;
mod uncovered;

pub(crate) use concepts::{is_color, is_size, similarity_or_other};
pub use concepts::{operate, similarity, volume};
pub use crop::{Crop, ImageError, RgbImage};
pub use encoder::{ENCODE_MULTIPLY_ADDS, encode, encode_in_place, recolor};
pub use observer::{Detection, ObservationTask, Stamp};
pub(crate) use uncovered::left_of_box;
pub use uncovered::uncovered;
