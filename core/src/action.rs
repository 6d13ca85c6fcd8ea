//! The action simulator (section IV-D, Table II last row): where the moved object will be observed
//! after an action.

use crate::model::{Action, COMPOSED, CompoundKind, LOCATION, Model, Simulator};
use crate::nn::{add_products, tanh_all};

/// The location of the moved object after `action`:
/// `loc' = (centre and depth of the reference, size of the object) + MLP(action, loc_1, loc_2)`.
///
/// * `object`, `reference`: x1, y1, x2, y2 as fractions of the image of the training's camera
///   (of another one: [`Viewpoint::to_training`]), mean depth in metres
///
/// [`Viewpoint::to_training`]: crate::viewpoint::Viewpoint::to_training
///
/// The result has the same form. It may lie outside the image; an untrained model may even give a
/// box without area. Cost: `64·(10 + 64 + 5)` multiply-adds and 128 hyperbolic tangents.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_core::action::simulate;
/// use nsrm_tabletop::TABLETOP;
///
/// # let scene = scene(&TABLETOP);
/// let (object, reference) = (scene.objects()[0].location, scene.objects()[1].location);
/// let on = &TABLETOP.actions[0];
/// assert_eq!(on.name, "MoveOn");
/// let [_, _, _, y2, _] = simulate(TABLETOP.simulator, on, &object, &reference);
/// assert!(y2 < reference[3]); // it stands higher in the image than what bears it
/// # Ok(())
/// # }
/// ```
pub fn simulate(
    simulator: &Simulator<'_>,
    action: &Action<'_>,
    object: &[f32; LOCATION],
    reference: &[f32; LOCATION],
) -> [f32; LOCATION] {
    let object = Centred::from_corners(object);
    let reference = Centred::from_corners(reference);
    let mut hidden = action.simulator_bias;
    let (object_columns, reference_columns) = simulator.input.split_at(LOCATION);
    add_products(&mut hidden, &object.numbers(), object_columns);
    add_products(&mut hidden, &reference.numbers(), reference_columns);
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

/// [`simulate`] for an action, or for one after the other of a compound's: in front and to the left is what
/// is in front of the place to the left. `None` for an index that is none of them, and for a compound of
/// the kind [`CompoundKind::Any`], which leads to no single place, or [`CompoundKind::Between`], which has two references.
///
/// * `action`: as of [`crate::dsl::Step::action`]
///
/// Cost: up to two [`simulate`].
pub fn simulate_any(
    model: &Model<'_>,
    action: u8,
    object: &[f32; LOCATION],
    reference: &[f32; LOCATION],
) -> Option<[f32; LOCATION]> {
    let known = |index: u8| model.actions.get(usize::from(index));
    if let Some(action) = known(action) {
        return Some(simulate(model.simulator, action, object, reference));
    }
    let compound = model.compound(action)?;
    if compound.kind != CompoundKind::All {
        return None;
    }
    let mut place = *reference;
    for &part in compound.parts.iter().take(COMPOSED) {
        place = simulate(model.simulator, known(part)?, object, &place);
    }
    Some(place)
}

/// A location as input of the simulator's network.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    /// One path from each input number and the action to one output each.
    #[test]
    fn the_network_reads_centre_and_size_of_both_objects_in_order() {
        let model = fixture::model();
        let mut simulator = *model.simulator;
        let mut hidden = fixture::linear();
        hidden.weight[20][40] = 3.0;
        hidden.bias[40] = -1.0;
        simulator.hidden = fixture::dense(hidden);
        simulator.output = fixture::linear();
        let mut action = model.actions[0];
        action.simulator_bias = [0.0; 64];
        action.simulator_bias[20] = 0.5;
        let object = [0.2, 0.1, 0.4, 0.2, 0.9];
        let reference = [0.5, 0.5, 0.8, 0.9, 1.1];
        // Centre x, centre y, width, height, depth of the one and the other.
        let numbers = [0.3, 0.15, 0.2, 0.1, 0.9, 0.65, 0.7, 0.3, 0.4, 1.1_f32];
        for (input, number) in numbers.into_iter().enumerate() {
            let mut simulator = simulator;
            simulator.input[input][20] = 0.25;
            simulator.output.weight[40][4] = 0.125;
            simulator.output.bias[2] = 0.02;
            let hidden = libm::tanhf(0.25 * number + 0.5);
            let depth = 1.1 + 0.125 * libm::tanhf(3.0 * hidden - 1.0);
            // The reference's centre, the object's size, 0.02 wider.
            let expected = [0.54, 0.65, 0.76, 0.75, depth];
            let got = simulate(&simulator, &action, &object, &reference);
            for (got, expected) in got.iter().zip(expected) {
                assert!((got - expected).abs() < 1e-6, "input {input}: {got}");
            }
        }
    }
}
