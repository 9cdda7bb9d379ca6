//! Intervals and the constraints between camera and target that they propagate.

/// A closed interval; empty where `low > high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Interval {
    pub(crate) const ALL: Self = Self::new(f64::NEG_INFINITY, f64::INFINITY);

    pub(crate) const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    pub(crate) fn point(value: f64) -> Self {
        Self::new(value, value)
    }

    /// Wider than empty by a rounding error at least.
    pub(crate) fn is_empty(&self) -> bool {
        self.low > self.high + 1e-12
    }

    pub(crate) fn width(&self) -> f64 {
        self.high - self.low
    }

    pub(crate) fn common(self, other: Self) -> Self {
        Self::new(self.low.max(other.low), self.high.min(other.high))
    }

    fn plus(self, other: Self) -> Self {
        Self::new(self.low + other.low, self.high + other.high)
    }

    fn minus(self, other: Self) -> Self {
        Self::new(self.low - other.high, self.high - other.low)
    }

    fn scaled(self, factor: f64) -> Self {
        if factor == 0.0 {
            return Self::point(0.0); // also of what has no end
        }
        let (a, b) = (self.low * factor, self.high * factor);
        Self::new(a.min(b), a.max(b))
    }

    fn times(self, other: Self) -> Self {
        let ends = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        let fold = |f: fn(f64, f64) -> f64, start| ends.iter().copied().fold(start, f);
        Self::new(
            fold(f64::min, f64::INFINITY),
            fold(f64::max, f64::NEG_INFINITY),
        )
    }

    /// Everything if the divisor holds 0.
    fn over(self, other: Self) -> Self {
        if other.low <= 0.0 && other.high >= 0.0 {
            return Self::ALL;
        }
        self.times(Self::new(1.0 / other.high, 1.0 / other.low))
    }

    /// Smallest and largest square.
    pub(crate) fn square(self) -> Self {
        let (a, b) = (self.low * self.low, self.high * self.high);
        let least = if self.low <= 0.0 && self.high >= 0.0 {
            0.0
        } else {
            a.min(b)
        };
        Self::new(least, a.max(b))
    }
}

/// Where a camera may be relative to its target: offset d, distance r, cosine b = n.d / r to the normal, and sine
/// a = d_z / r of the angle of depression.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constraints {
    pub(crate) d: [Interval; 3],
    pub(crate) r: Interval,
    pub(crate) b: Interval,
    pub(crate) a: Interval,
    /// Unit normal.
    pub(crate) n: [f64; 3],
}

/// Change of width below which propagation ends.
const SETTLED: f64 = 1e-3;

impl Constraints {
    /// Narrows all intervals until they settle; false if one became empty.
    pub(crate) fn propagate(&mut self) -> bool {
        // Each round narrows some interval by more than SETTLED, and all are a few metres wide; the limit is a backstop.
        for _ in 0..1000 {
            let before = self.widths();
            self.round();
            let all = [self.d[0], self.d[1], self.d[2], self.r, self.b, self.a];
            if all.iter().any(Interval::is_empty) {
                return false;
            }
            let after = self.widths();
            if before.iter().zip(after).all(|(b, a)| b - a <= SETTLED) {
                return true;
            }
        }
        true
    }

    fn widths(&self) -> [f64; 6] {
        [self.d[0], self.d[1], self.d[2], self.r, self.b, self.a].map(|i| i.width())
    }

    fn round(&mut self) {
        let along = |d: &[Interval; 3], n: [f64; 3], skip: usize| {
            (0..3)
                .filter(|&i| i != skip)
                .fold(Interval::point(0.0), |sum, i| sum.plus(d[i].scaled(n[i])))
        };
        let dot = along(&self.d, self.n, 3);
        self.r = self.r.common(dot.over(self.b));
        self.b = self.b.common(dot.over(self.r));
        for i in 0..3 {
            if self.n[i].abs() > 1e-3 {
                let rest = self.r.times(self.b).minus(along(&self.d, self.n, i));
                self.d[i] = self.d[i].common(rest.scaled(1.0 / self.n[i]));
            }
        }
        let squares = self.d.map(Interval::square);
        let sum = squares[0].plus(squares[1]).plus(squares[2]);
        self.r = self.r.common(Interval::new(
            sum.low.max(0.0).sqrt(),
            sum.high.max(0.0).sqrt(),
        ));
        for i in 0..3 {
            let others: f64 = (0..3).filter(|&j| j != i).map(|j| squares[j].low).sum();
            let most = (self.r.square().high - others).max(0.0).sqrt();
            self.d[i] = self.d[i].common(Interval::new(-most, most));
        }
        self.r = self.r.common(self.d[2].over(self.a));
        self.a = self.a.common(self.d[2].over(self.r));
        self.d[2] = self.d[2].common(self.r.times(self.a));
    }

    /// Least magnitude that offset `i` can have.
    pub(crate) fn least(&self, i: usize) -> f64 {
        let squares = self.d.map(Interval::square);
        let others: f64 = (0..3).filter(|&j| j != i).map(|j| squares[j].high).sum();
        let from_range = (self.r.square().low - others).max(0.0).sqrt();
        squares[i].low.max(0.0).sqrt().max(from_range)
    }
}
