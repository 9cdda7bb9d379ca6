//! A clock of CPU time and a small generator.

use std::f64::consts::PI;

/// CPU time of this thread, s. Giving way first makes the kernel bring its account up to date.
pub(crate) fn cpu_seconds() -> f64 {
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanos = text.split(' ').next().and_then(|n| n.parse::<f64>().ok());
    nanos.map_or_else(wall_seconds, |n| n * 1e-9)
}

/// Where there is no such account.
fn wall_seconds() -> f64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    now.map_or(0.0, |d| d.as_secs_f64())
}

/// Nanoseconds of one call: the median of nine batches of about 20 ms each.
pub(crate) fn nanos(mut f: impl FnMut()) -> f64 {
    let begin = cpu_seconds();
    f();
    let once = (cpu_seconds() - begin).max(1e-9);
    let calls = (0.02 / once).ceil().clamp(1.0, 1e6) as usize;
    let mut all: Vec<f64> = (0..9)
        .map(|_| {
            let begin = cpu_seconds();
            for _ in 0..calls {
                f();
            }
            (cpu_seconds() - begin) * 1e9 / calls as f64
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all[4]
}

/// SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    pub(crate) fn joints(&mut self) -> [f64; 6] {
        [0; 6].map(|_| self.within(-PI, PI))
    }
}
