//! Kernels: what is computed with the widest vectors that there are. With the feature `vectors` those
//! are the processor's, otherwise those of the compiler's target.

#[cfg(feature = "vectors")]
pub(crate) use nsrm_vectors::{Kernel, widest};

/// What runs with the widest vectors.
#[cfg(not(feature = "vectors"))]
pub(crate) trait Kernel {
    /// Its result.
    type Output;

    /// Computes it. Must be `#[inline(always)]`, as must all that it calls.
    fn run(self) -> Self::Output;
}

/// Runs a kernel.
#[cfg(not(feature = "vectors"))]
#[inline]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
