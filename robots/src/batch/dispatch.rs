//! Picks the widest vector instructions that the machine has, at run time.
//!
//! The loops themselves are safe code; the compiler is only told that it may use AVX2 and FMA for one copy of them.
#![allow(unsafe_code)]

use super::field::BatchField;
use super::lanes::LANES;
use super::model::{BatchBody, NO_SPHERES, SphereLanes, StateBlock};

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
#[inline]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
#[target_feature(enable = "avx2,fma")]
fn spheres_avx2(body: &BatchBody, states: &StateBlock, centers: &mut SphereLanes) {
    body.spheres_inline::<true>(states, centers);
}

#[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
#[target_feature(enable = "avx2,fma")]
fn free_avx2<F: BatchField>(
    body: &BatchBody,
    states: &StateBlock,
    field: &F,
    margin: f32,
) -> [bool; LANES] {
    body.free_inline::<F, true>(states, field, margin)
}

pub(super) fn spheres(body: &BatchBody, states: &StateBlock) -> SphereLanes {
    let mut centers = NO_SPHERES;
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    if has_avx2() {
        // SAFETY: the only requirement of a function with target features is that the machine has them, and it was
        // just asked.
        unsafe { spheres_avx2(body, states, &mut centers) };
        return centers;
    }
    body.spheres_inline::<false>(states, &mut centers);
    centers
}

pub(super) fn free<F: BatchField>(
    body: &BatchBody,
    states: &StateBlock,
    field: &F,
    margin: f32,
) -> [bool; LANES] {
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    if has_avx2() {
        // SAFETY: as above.
        return unsafe { free_avx2(body, states, field, margin) };
    }
    body.free_inline::<F, false>(states, field, margin)
}
