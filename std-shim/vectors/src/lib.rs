//! Chooses the width of the processor's vectors at run time.
//!
//! A program for x86-64 may use vectors of four `f32` only, unless it is compiled for newer processors
//! alone. [`widest`] compiles a kernel three times, also for vectors of eight and of sixteen, and runs
//! what the processor has. The results are the same, bit by bit: the additions of a lane keep their
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
    {
        if has_avx512() {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { with_avx512(kernel) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the same.
            return unsafe { with_avx2(kernel) };
        }
    }
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn has_avx512() -> bool {
    std::arch::is_x86_feature_detected!("avx512f")
        && std::arch::is_x86_feature_detected!("avx512vl")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl")]
fn with_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    /// Sums of products, in an order that the lanes keep.
    #[derive(Clone, Copy)]
    struct Products<'a>(&'a [[f32; 37]]);

    impl Kernel for Products<'_> {
        type Output = [u32; 37];

        #[inline(always)]
        fn run(self) -> [u32; 37] {
            let mut sums = [0.1_f32; 37];
            for row in self.0 {
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum += *sum * value;
                }
            }
            sums.map(f32::to_bits)
        }
    }

    #[test]
    fn each_width_gives_the_same_bits() {
        let value = |index: u16| f32::from(index % 97) / 89.0 - 0.5;
        let rows: Vec<[f32; 37]> = (0..50)
            .map(|row| std::array::from_fn(|column| value(row * 37 + column as u16)))
            .collect();
        let kernel = Products(&rows);
        let expected = kernel.run();
        assert_eq!(widest(kernel), expected);
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function is compiled for.
            assert_eq!(unsafe { with_avx2(kernel) }, expected);
        }
        if has_avx512() {
            // SAFETY: the same.
            assert_eq!(unsafe { with_avx512(kernel) }, expected);
        }
    }
}
