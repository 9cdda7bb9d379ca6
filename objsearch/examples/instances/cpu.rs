//! CPU time of this process, from the kernel's accounting.

/// Seconds of CPU time used so far, all threads; wall time since the start where the kernel does not say.
#[allow(clippy::disallowed_methods)] // an example may read a clock
pub(crate) fn seconds() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    // First figure: nanoseconds on a CPU.
    std::fs::read_to_string("/proc/self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok())
        .map_or_else(
            || {
                START
                    .get_or_init(std::time::Instant::now)
                    .elapsed()
                    .as_secs_f64()
            },
            |nanoseconds| 1e-9 * nanoseconds,
        )
}
