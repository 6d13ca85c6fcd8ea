//! Chooses the width of the processor's vectors at run time.
//!
//! A program for x86-64 may use vectors of four `f32` only, unless it is compiled for newer processors
//! alone. [`widest`] compiles a kernel twice, once for vectors of eight, and runs that where
//! the processor has them. The results are the same, bit by bit: the additions of a lane keep their
//! order, and products are rounded before they are added.

/// What runs with the widest vectors.
pub trait Kernel {
    /// Its result.
    type Output;

    /// Computes it. Must be `#[inline(always)]`, as must all that it calls and that is to be compiled
    /// for these vectors: what is called instead of inlined is compiled for any processor.
    fn run(self) -> Self::Output;
}

/// Runs a kernel with the widest vectors that the processor has.
///
/// Cost besides the kernel's: an atomic load and a jump; the first call asks the processor.
///
/// ```
/// struct Scale(f32, [f32; 4]);
///
/// impl nsrm_vectors::Kernel for Scale {
///     type Output = [f32; 4];
///
///     #[inline(always)]
///     fn run(self) -> [f32; 4] {
///         self.1.map(|value| self.0 * value)
///     }
/// }
///
/// let scaled = nsrm_vectors::widest(Scale(2.5, [1.0, 2.0, 3.0, 4.0]));
/// assert_eq!(scaled, [2.5, 5.0, 7.5, 10.0]);
/// ```
#[inline]
pub fn widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what the function is compiled for.
        return unsafe { with_avx2(kernel) };
    }
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
