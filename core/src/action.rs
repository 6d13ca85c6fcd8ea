//! The action simulator (section IV-D, Table II last row): where the moved object
//! will be seen after an action.

use crate::model::{Action, LOCATION, Simulator};
use crate::nn::tanh_all;

/// The location of the moved object after `action`:
/// `loc' = (centre and depth of the reference, size of the object) + MLP(action, loc_1, loc_2)`.
///
/// * `object`, `reference`: x1, y1, x2, y2 as fractions of the image, mean depth in metres
///
/// The result has the same form. It may lie outside the image; a model that was
/// not trained may even give a box without area.
/// Cost: `64·(10 + 64 + 5)` multiply-adds and 128 hyperbolic tangents.
pub fn simulate(
    simulator: &Simulator,
    action: &Action<'_>,
    object: &[f32; LOCATION],
    reference: &[f32; LOCATION],
) -> [f32; LOCATION] {
    let object = Centred::from_corners(object);
    let reference = Centred::from_corners(reference);
    let mut hidden = action.simulator_bias;
    let inputs = object.numbers().into_iter().chain(reference.numbers());
    for (value, column) in inputs.zip(&simulator.input) {
        crate::nn::accumulate(&mut hidden, value, column);
    }
    tanh_all(&mut hidden);
    let mut hidden = simulator.hidden.apply(&hidden);
    tanh_all(&mut hidden);
    let [centre_x, centre_y, width, height, depth] = simulator.output.apply(&hidden);
    Centred {
        centre_x: reference.centre_x + centre_x,
        centre_y: reference.centre_y + centre_y,
        width: object.width + width,
        height: object.height + height,
        depth: reference.depth + depth,
    }
    .to_corners()
}

/// A location as the simulator's network sees it.
struct Centred {
    centre_x: f32,
    centre_y: f32,
    width: f32,
    height: f32,
    depth: f32,
}

impl Centred {
    fn from_corners(&[x1, y1, x2, y2, depth]: &[f32; LOCATION]) -> Self {
        Self {
            centre_x: (x1 + x2) * 0.5,
            centre_y: (y1 + y2) * 0.5,
            width: x2 - x1,
            height: y2 - y1,
            depth,
        }
    }

    fn numbers(&self) -> [f32; LOCATION] {
        [
            self.centre_x,
            self.centre_y,
            self.width,
            self.height,
            self.depth,
        ]
    }

    fn to_corners(&self) -> [f32; LOCATION] {
        let (half_width, half_height) = (self.width * 0.5, self.height * 0.5);
        [
            self.centre_x - half_width,
            self.centre_y - half_height,
            self.centre_x + half_width,
            self.centre_y + half_height,
            self.depth,
        ]
    }
}
