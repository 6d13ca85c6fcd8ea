//! The greatest errors of the scalar functions, over every `f32`. Takes some minutes.

use nsrm_core::nn::{sigmoid, tanh};

/// How far a function is from what `f64` gives.
#[derive(Debug, Default)]
struct Error {
    absolute: f64,
    relative: f64,
}

impl Error {
    fn add(&mut self, got: f32, exact: f64) {
        let error = (f64::from(got) - exact).abs();
        self.absolute = self.absolute.max(error);
        if exact.abs() > f64::from(f32::MIN_POSITIVE) {
            self.relative = self.relative.max(error / exact.abs());
        }
    }
}

fn main() {
    let (mut of_tanh, mut of_sigmoid) = (Error::default(), Error::default());
    for x in (0..=u32::MAX).map(f32::from_bits) {
        if x.is_finite() {
            let exact = f64::from(x);
            of_tanh.add(tanh(x), exact.tanh());
            of_sigmoid.add(sigmoid(x), 1.0 / (1.0 + (-exact).exp()));
        }
    }
    println!("function,absolute,relative");
    for (name, error) in [("tanh", of_tanh), ("sigmoid", of_sigmoid)] {
        println!("{name},{:.2e},{:.2e}", error.absolute, error.relative);
    }
}
