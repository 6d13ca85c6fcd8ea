/// The recurrent part of a GRU cell; the input's part is folded into the words.
#[derive(Debug, Clone, Copy)]
pub struct Gru<const HIDDEN: usize> {
    /// For each hidden unit its column in the reset, update and new gate.
    pub weight_hh: [[[f32; HIDDEN]; 3]; HIDDEN],
    /// Added inside `r ⊙ (…)` of the new gate.
    pub bias_n: [f32; HIDDEN],
}
