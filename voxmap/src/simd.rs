//! Runs a kernel compiled for the processor at hand. The only unsafe code of the crate.
//!
//! Without it the default x86-64 build would use SSE2 only, which costs ray tracing a factor of about two. Kernels use
//! integers and plain IEEE operations (no fused ones), so that every processor gives the same bits.

/// A loop worth compiling more than once. `run` must be `#[inline(always)]`, and so must all that it calls.
pub(crate) trait Kernel {
    /// What the loop returns.
    type Output;
    /// The loop.
    fn run(self) -> Self::Output;
}

/// Runs the kernel with the widest instructions the processor has.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
pub(crate) fn run<K: Kernel>(kernel: K) -> K::Output {
    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn avx512<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn avx2<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
    if !(is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt"))
    {
        return kernel.run();
    }
    if is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
    {
        // SAFETY: every feature the function enables was detected just above.
        unsafe { avx512(kernel) }
    } else {
        // SAFETY: every feature the function enables was detected just above.
        unsafe { avx2(kernel) }
    }
}

/// Runs the kernel.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
