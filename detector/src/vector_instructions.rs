//! Hot loops in wide vector instructions.

/// A hot loop.
///
/// `run` and the functions it calls are to be `#[inline(always)]`: only inlined code is compiled for other instructions.
pub(crate) trait HotLoop {
    /// Result of the loop.
    type Output;

    /// Runs the loop.
    fn run(self) -> Self::Output;
}

/// Runs `task`, compiled for AVX-512 or AVX2 where the processor has it and like everything else where not.
///
/// The result is the same to the bit: more numbers are worked on at a time, but products and sums are never fused and never
/// change their order.
#[inline(always)]
pub(crate) fn vectorised<T: HotLoop>(task: T) -> T::Output {
    pulp::Arch::new().dispatch(Task(task))
}

struct Task<T>(T);

impl<T: HotLoop> pulp::WithSimd for Task<T> {
    type Output = T::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> T::Output {
        self.0.run()
    }
}

/// The lesser of two numbers of which none is NaN; unlike `f32::min` a single instruction.
#[inline(always)]
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater of two numbers of which none is NaN.
#[inline(always)]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
