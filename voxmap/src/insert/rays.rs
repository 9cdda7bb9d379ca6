//! From points to rays: cut to range and map, and prepared for the traversal, many at a time.

use crate::simd::Kernel;

/// Rays prepared at a time; their arrays stay in the first two cache levels.
pub(super) const BATCH: usize = 512;
/// Time at which a ray ends, in the units of [`Batch::next`].
pub(super) const ONE: i32 = 1 << 30;
/// Longest ray in cells along one axis for which times in those units keep crossings in order.
pub(super) const LONGEST: f64 = 1024.0;
/// Ends keep this distance from the borders between cells, in cells, so that rounding cannot add or lose a step: with at
/// most `LONGEST` crossings the error stays below 2^9 + 2 units and crossings keep `MARGIN / LONGEST * ONE` = 2^10 units from the end.
const MARGIN: f64 = 1.0 / 1024.0;

/// What all rays of a batch share. Lengths in cells.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    /// Sensor, in cells from the map's corner.
    pub origin: [f64; 3],
    /// Corner of the map, m.
    pub low: [f64; 3],
    /// Cells per metre.
    pub scale: f64,
    /// Size of the map.
    pub size: [f64; 3],
    /// Address step along each axis.
    pub stride: [i32; 3],
    /// Longest range.
    pub range: f64,
    /// Prolongation of rays that returned.
    pub depth: f64,
    /// Whether these rays returned.
    pub returned: bool,
}

/// Rays ready for the traversal, structure of arrays.
pub(super) struct Batch {
    /// Start and end inside the map, cells.
    pub from: [[f64; BATCH]; 3],
    pub to: [[f64; BATCH]; 3],
    /// 0: not a ray, 1: bad point, 2: free up to its end, 3: hit at its end.
    pub kind: [u8; BATCH],
    /// Time of the next crossing along each axis, `ONE` at the end; `i32::MAX` on axes without a crossing.
    pub next: [[i32; BATCH]; 3],
    /// Time between crossings.
    pub delta: [[i32; BATCH]; 3],
    /// Signed address step.
    pub step: [[i32; BATCH]; 3],
    /// Address of the first and the last cell.
    pub first: [i32; BATCH],
    pub last: [i32; BATCH],
    /// Number of steps.
    pub count: [i32; BATCH],
}

/// A point is no ray, or bad, or a ray.
pub(super) const OUTSIDE: u8 = 0;
pub(super) const BAD: u8 = 1;
pub(super) const FREE: u8 = 2;
pub(super) const HIT: u8 = 3;

impl Batch {
    pub(super) fn new() -> Box<Self> {
        Box::new(Self {
            from: [[0.0; BATCH]; 3],
            to: [[0.0; BATCH]; 3],
            kind: [0; BATCH],
            next: [[0; BATCH]; 3],
            delta: [[0; BATCH]; 3],
            step: [[0; BATCH]; 3],
            first: [0; BATCH],
            last: [0; BATCH],
            count: [0; BATCH],
        })
    }
}

/// Prepares up to [`BATCH`] points.
pub(super) struct Prepare<'a> {
    pub batch: &'a mut Batch,
    pub points: &'a [[f32; 3]],
    pub frame: &'a Frame,
}

impl Kernel for Prepare<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            batch,
            points,
            frame,
        } = self;
        for (i, point) in points.iter().take(BATCH).enumerate() {
            for a in 0..3 {
                batch.to[a][i] = (f64::from(point[a]) - frame.low[a]) * frame.scale;
            }
        }
        let inside = (0..3).all(|a| frame.origin[a] >= 0.0 && frame.origin[a] < frame.size[a]);
        // Fixed lengths vectorise; slots beyond the last point hold leftovers that nobody reads.
        if inside {
            cut_from_inside(batch, frame);
        } else {
            cut_from_outside(batch, frame);
        }
        for a in 0..3 {
            axis(batch, frame, a);
        }
        for i in 0..BATCH {
            batch.first[i] = 0;
            batch.last[i] = 0;
            batch.count[i] = 0;
        }
        for a in 0..3 {
            addresses(batch, frame, a);
        }
    }
}

/// Direction and length factor of a point at `to`: (way to the end, kind).
#[inline(always)]
fn reach(to: [f64; 3], frame: &Frame) -> ([f64; 3], u8) {
    let o = frame.origin;
    let way = [to[0] - o[0], to[1] - o[1], to[2] - o[2]];
    let length = (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
    let good = length > 0.0 && length < f64::INFINITY;
    let far = length > frame.range;
    let reach = if far {
        frame.range
    } else {
        length + frame.depth
    };
    let factor = if good { reach / length } else { 0.0 };
    let kind = if !good {
        BAD
    } else if far || !frame.returned {
        FREE
    } else {
        HIT
    };
    ([way[0] * factor, way[1] * factor, way[2] * factor], kind)
}

#[inline(always)]
fn cut_from_inside(batch: &mut Batch, frame: &Frame) {
    let o = frame.origin;
    for i in 0..BATCH {
        let (way, kind) = reach([batch.to[0][i], batch.to[1][i], batch.to[2][i]], frame);
        let mut leave = 1.0f64;
        for a in 0..3 {
            let room = if way[a] > 0.0 {
                frame.size[a] - o[a]
            } else {
                -o[a]
            };
            let time = if way[a] == 0.0 { 1.0 } else { room / way[a] };
            leave = if time < leave { time } else { leave };
        }
        // A ray cut at the border of the map is free up to there.
        batch.kind[i] = if leave < 1.0 && kind == HIT {
            FREE
        } else {
            kind
        };
        for a in 0..3 {
            batch.from[a][i] = o[a];
            batch.to[a][i] = o[a] + way[a] * leave;
        }
    }
}

#[inline(always)]
fn cut_from_outside(batch: &mut Batch, frame: &Frame) {
    let o = frame.origin;
    for i in 0..BATCH {
        let (way, mut kind) = reach([batch.to[0][i], batch.to[1][i], batch.to[2][i]], frame);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for a in 0..3 {
            if way[a] == 0.0 {
                if o[a] < 0.0 || o[a] >= frame.size[a] {
                    enter = f64::INFINITY;
                }
            } else {
                let (t0, t1) = (-o[a] / way[a], (frame.size[a] - o[a]) / way[a]);
                enter = enter.max(t0.min(t1));
                leave = leave.min(t0.max(t1));
            }
        }
        if kind != BAD && enter >= leave {
            kind = OUTSIDE;
        }
        batch.kind[i] = if leave < 1.0 && kind == HIT {
            FREE
        } else {
            kind
        };
        for a in 0..3 {
            let inside = if kind >= FREE { enter } else { 0.0 };
            batch.from[a][i] = o[a] + way[a] * inside;
            batch.to[a][i] = o[a] + way[a] * leave;
        }
    }
}

/// First and last cell on one axis; the coordinates are brought inside the map.
#[inline(always)]
fn cells(from: f64, to: f64, size: f64) -> (f64, f64, f64, f64) {
    let top = size - 1.0;
    let clamp = |v: f64, low: f64, high: f64| {
        if v > low {
            if v < high { v } else { high }
        } else {
            low
        }
    };
    // Truncation is floor from zero on, and NaN becomes zero.
    let from = clamp(from, 0.0, size);
    let first = clamp(f64::from(from as i32), 0.0, top);
    let last = clamp(f64::from(clamp(to, 0.0, size) as i32), 0.0, top);
    let to = clamp(to, last + MARGIN, last + (1.0 - MARGIN));
    (from, to, first, last)
}

#[inline(always)]
fn axis(batch: &mut Batch, frame: &Frame, a: usize) {
    let one = f64::from(ONE);
    for i in 0..BATCH {
        let (from, to, first, last) = cells(batch.from[a][i], batch.to[a][i], frame.size[a]);
        let crosses = first != last;
        let up = last > first;
        let border = if up { first + 1.0 - from } else { from - first };
        let way = if up { to - from } else { from - to };
        let inverse = one / way;
        let next = border * inverse;
        let limit = one + 1024.0;
        let delta = if inverse < limit { inverse } else { limit };
        batch.next[a][i] = if crosses {
            (next + 0.5) as i32
        } else {
            i32::MAX
        };
        batch.delta[a][i] = if crosses { (delta + 0.5) as i32 } else { 0 };
        batch.step[a][i] = if up {
            frame.stride[a]
        } else {
            -frame.stride[a]
        };
    }
}

#[inline(always)]
fn addresses(batch: &mut Batch, frame: &Frame, a: usize) {
    for i in 0..BATCH {
        let (_, _, first, last) = cells(batch.from[a][i], batch.to[a][i], frame.size[a]);
        let (first, last) = (first as i32, last as i32);
        batch.first[i] += first * frame.stride[a];
        batch.last[i] += last * frame.stride[a];
        batch.count[i] += (last - first).abs();
    }
}
