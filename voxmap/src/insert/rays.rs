//! From points to rays: cut to range and map, and prepared for the traversal, many at a time.
//!
//! Every loop here runs over whole arrays without branches, so that the compiler turns it into vector code; whole numbers
//! stay in `f64` until the end for the same reason.

use crate::simd::Kernel;

/// Rays prepared at a time; their arrays stay in the first cache level.
pub(super) const BATCH: usize = 256;
/// Time at which a ray ends, in the units of [`Batch::next`].
pub(super) const ONE: i32 = 1 << 30;
/// Longest ray in cells along one axis for which times in those units keep crossings in order.
const LONGEST: f64 = 1024.0;
/// Ends keep this distance from the borders between cells, in cells, so that rounding cannot add or lose a step: crossings
/// then keep `MARGIN / LONGEST * ONE` = 1024 units from the end, while `LONGEST` of them are off by less than 514.
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

/// The ray does not meet the map.
pub(super) const OUTSIDE: i32 = 0;
/// The point is not finite or stands at the sensor.
pub(super) const BAD: i32 = 1;
/// The ray is free up to its end.
pub(super) const FREE: i32 = 2;
/// The ray returned from its end.
pub(super) const HIT: i32 = 3;

/// Rays ready for the traversal, structure of arrays.
pub(super) struct Batch {
    /// Start and end inside the map, cells.
    pub from: [[f64; BATCH]; 3],
    pub to: [[f64; BATCH]; 3],
    /// [`OUTSIDE`], [`BAD`], [`FREE`] or [`HIT`].
    pub kind: [i32; BATCH],
    /// More cells along an axis than the lanes can count.
    pub long: [i32; BATCH],
    /// Time of the next crossing along each axis, `ONE` at the end; `i32::MAX` on axes without a crossing.
    pub next: [[i32; BATCH]; 3],
    /// Time between crossings.
    pub delta: [[i32; BATCH]; 3],
    /// Time of the last crossing that counts; `ONE` unless the grazing guard cuts a ray short.
    pub end: [i32; BATCH],
    /// Signed address step.
    pub step: [[i32; BATCH]; 3],
    /// Address of the first and the last cell.
    pub first: [i32; BATCH],
    pub last: [i32; BATCH],
    /// Number of steps.
    pub count: [i32; BATCH],
    /// Cells of both ends of all rays, on each axis: lowest, highest.
    pub span: [(i32, i32); 3],
}

impl Batch {
    pub(super) fn new() -> Box<Self> {
        Box::new(Self {
            from: [[0.0; BATCH]; 3],
            to: [[0.0; BATCH]; 3],
            kind: [0; BATCH],
            long: [0; BATCH],
            next: [[0; BATCH]; 3],
            delta: [[0; BATCH]; 3],
            end: [ONE; BATCH],
            step: [[0; BATCH]; 3],
            first: [0; BATCH],
            last: [0; BATCH],
            count: [0; BATCH],
            span: [(0, 0); 3],
        })
    }
}

/// Prepares up to [`BATCH`] points. Slots beyond the last point repeat it.
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
        // A copy, so that the compiler sees that no store changes it.
        let frame = *frame;
        let points = &points[..points.len().min(BATCH)];
        for a in 0..3 {
            for (to, point) in batch.to[a].iter_mut().zip(points) {
                *to = (f64::from(point[a]) - frame.low[a]) * frame.scale;
            }
            if let Some(&last) = batch.to[a][..points.len()].last() {
                batch.to[a][points.len()..].fill(last);
            }
        }
        let inside = (0..3).all(|a| frame.origin[a] >= 0.0 && frame.origin[a] < frame.size[a]);
        if inside {
            cut_from_inside(batch, frame);
        } else {
            cut_from_outside(batch, frame);
        }
        batch.first.fill(0);
        batch.last.fill(0);
        batch.count.fill(0);
        batch.end.fill(ONE);
        batch.long.fill(0);
        for a in 0..3 {
            axis(batch, frame, a);
        }
    }
}

/// Adding and subtracting it rounds to a whole number; added, the number stands in the low bits.
const ROUND: f64 = (1u64 << 52) as f64;

/// The whole number below or at a number in 0..2^31.
#[inline(always)]
fn floor(v: f64) -> f64 {
    let near = (v + ROUND) - ROUND;
    if near > v { near - 1.0 } else { near }
}

/// The nearest integer to a number in 0..2^31.
#[inline(always)]
fn integer(v: f64) -> i32 {
    (v + ROUND).to_bits() as i32
}

/// Limits a number; NaN becomes `low`.
#[inline(always)]
fn clamp(v: f64, low: f64, high: f64) -> f64 {
    let v = if v > low { v } else { low };
    if v < high { v } else { high }
}

/// The way to a ray's end, and whether the point is good and in range.
#[inline(always)]
fn reach(to: [f64; 3], frame: Frame) -> ([f64; 3], bool, bool) {
    let o = frame.origin;
    let way = [to[0] - o[0], to[1] - o[1], to[2] - o[2]];
    let length = (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
    let good = (length > 0.0) & (length < f64::INFINITY);
    let far = length > frame.range;
    let reach = if far {
        frame.range
    } else {
        length + frame.depth
    };
    let factor = reach / length;
    let factor = if good { factor } else { 0.0 };
    (
        [way[0] * factor, way[1] * factor, way[2] * factor],
        good,
        !far,
    )
}

#[inline(always)]
fn cut_from_inside(batch: &mut Batch, frame: Frame) {
    let o = frame.origin;
    let [xs, ys, zs] = &mut batch.to;
    for i in 0..BATCH {
        let (way, good, near) = reach([xs[i], ys[i], zs[i]], frame);
        let leave = room(way[0], o[0], frame.size[0])
            .min(room(way[1], o[1], frame.size[1]))
            .min(room(way[2], o[2], frame.size[2]))
            .min(1.0);
        // A ray cut at the border of the map is free up to there.
        let hit = near & (leave >= 1.0) & frame.returned;
        batch.kind[i] = BAD + i32::from(good) * (FREE - BAD) + i32::from(good & hit) * (HIT - FREE);
        xs[i] = o[0] + way[0] * leave;
        ys[i] = o[1] + way[1] * leave;
        zs[i] = o[2] + way[2] * leave;
    }
    for a in 0..3 {
        batch.from[a].fill(o[a]);
    }
}

/// Part of the way at which a ray leaves the map along one axis. Not moving is infinitely far, or not a number, which a
/// minimum passes over.
#[inline(always)]
fn room(way: f64, origin: f64, size: f64) -> f64 {
    let room = if way > 0.0 { size - origin } else { origin };
    room / way.abs()
}

#[inline(always)]
fn cut_from_outside(batch: &mut Batch, frame: Frame) {
    let o = frame.origin;
    for i in 0..BATCH {
        let to = [batch.to[0][i], batch.to[1][i], batch.to[2][i]];
        let (way, good, near) = reach(to, frame);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for a in 0..3 {
            if way[a] == 0.0 {
                if o[a] < 0.0 || o[a] >= frame.size[a] {
                    enter = 1.0;
                    leave = 0.0;
                }
            } else {
                let (t0, t1) = (-o[a] / way[a], (frame.size[a] - o[a]) / way[a]);
                enter = enter.max(t0.min(t1));
                leave = leave.min(t0.max(t1));
            }
        }
        let meets = enter < leave;
        let hit = near & (leave >= 1.0) & frame.returned;
        batch.kind[i] = if !good {
            BAD
        } else if !meets {
            OUTSIDE
        } else if hit {
            HIT
        } else {
            FREE
        };
        for a in 0..3 {
            batch.from[a][i] = o[a] + if meets { way[a] * enter } else { 0.0 };
            batch.to[a][i] = o[a] + if meets { way[a] * leave } else { 0.0 };
        }
    }
}

/// Crossings, steps and addresses along one axis. Brings both ends inside the map.
#[inline(always)]
fn axis(batch: &mut Batch, frame: Frame, a: usize) {
    let (one, size, stride) = (f64::from(ONE), frame.size[a], frame.stride[a]);
    let (top, longest) = (size - 1.0, one + 1024.0);
    let (mut low, mut high) = (i32::MAX, 0);
    for i in 0..BATCH {
        let from = clamp(batch.from[a][i], 0.0, size);
        let to = clamp(batch.to[a][i], 0.0, size);
        let (first, last) = (floor(from), floor(to));
        let first = if first < top { first } else { top };
        let last = if last < top { last } else { top };
        let to = clamp(to, last + MARGIN, last + (1.0 - MARGIN));
        batch.from[a][i] = from;
        batch.to[a][i] = to;
        let (below, above) = if first < last {
            (first, last)
        } else {
            (last, first)
        };
        low = low.min(integer(below));
        high = high.max(integer(above));

        let crosses = first != last;
        let up = last > first;
        let border = if up { first + 1.0 - from } else { from - first };
        let way = if up { to - from } else { from - to };
        let inverse = one / way;
        let delta = if inverse < longest { inverse } else { longest };
        batch.next[a][i] = if crosses {
            integer(border * inverse)
        } else {
            i32::MAX
        };
        batch.delta[a][i] = if crosses { integer(delta) } else { 0 };
        batch.step[a][i] = if up { stride } else { -stride };
        batch.first[i] += integer(first) * stride;
        batch.last[i] += integer(last) * stride;
        batch.count[i] += integer(above - below);
        batch.long[i] |= i32::from(above - below > LONGEST);
    }
    batch.span[a] = (low, high);
}
