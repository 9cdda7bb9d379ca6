//! CPU time of this thread, which a busy machine disturbs less than wall time.

use cpu_time::ThreadTime;
use std::time::Duration;

/// CPU time of one call.
pub fn timed<T>(call: impl FnOnce() -> T) -> (T, Duration) {
    let start = ThreadTime::now();
    let out = call();
    (out, start.elapsed())
}

/// Median of some times, ms.
pub fn median_ms(times: &mut [Duration]) -> f64 {
    times.sort_unstable();
    times
        .get(times.len() / 2)
        .map_or(f64::NAN, |t| t.as_secs_f64() * 1e3)
}

/// Median time of a repeated call, ms.
pub fn repeated_ms<T>(n: usize, mut call: impl FnMut() -> T) -> f64 {
    let mut times: Vec<Duration> = (0..n)
        .map(|_| timed(|| std::hint::black_box(call())).1)
        .collect();
    median_ms(&mut times)
}

/// A chain of dependent additions, ns each: how fast the machine runs right now.
pub fn calibration() -> f64 {
    const N: u64 = 20_000_000;
    let ms = repeated_ms(3, || {
        let mut x = std::hint::black_box(1u64);
        for _ in 0..N {
            x = std::hint::black_box(x.wrapping_add(1));
        }
        x
    });
    ms * 1e6 / N as f64
}
