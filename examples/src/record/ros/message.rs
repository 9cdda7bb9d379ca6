//! The ROS 2 messages that are written, field by field.

use super::cdr::Cdr;
use crate::record::View;

/// Frame of everything.
pub(super) const MAP: &str = "map";

/// Nanoseconds of a simulated time, s.
pub(super) fn nanoseconds(time: f64) -> u64 {
    (time.max(0.0) * 1e9).round() as u64
}

fn stamp(cdr: &mut Cdr, time: f64) {
    let all = nanoseconds(time);
    cdr.i32((all / 1_000_000_000) as i32);
    cdr.u32((all % 1_000_000_000) as u32);
}

fn header(cdr: &mut Cdr, time: f64) {
    stamp(cdr, time);
    cdr.string(MAP);
}

fn point(cdr: &mut Cdr, p: [f64; 3]) {
    p.iter().for_each(|v| cdr.f64(*v));
}

fn pose(cdr: &mut Cdr, v: &View) {
    point(cdr, v.p);
    v.q.iter().for_each(|c| cdr.f64(*c));
}

/// A base pose x, y, yaw as a pose in space.
pub(super) fn planar(base: [f64; 3]) -> View {
    let (s, c) = (0.5 * base[2]).sin_cos();
    View {
        p: [base[0], base[1], 0.0],
        q: [0.0, 0.0, s, c],
    }
}

/// A position without a direction.
pub(super) fn upright(p: [f64; 3]) -> View {
    View {
        p,
        q: [0.0, 0.0, 0.0, 1.0],
    }
}

/// `tf2_msgs/TFMessage` from the map to each frame.
pub(super) fn transforms(time: f64, frames: &[(&str, View)]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.length(frames.len());
    for (name, view) in frames {
        header(&mut cdr, time);
        cdr.string(name);
        pose(&mut cdr, view);
    }
    cdr.finish()
}

/// `sensor_msgs/JointState`, positions only.
pub(super) fn joints(time: f64, names: &[String], positions: &[f64]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    header(&mut cdr, time);
    cdr.length(names.len());
    names.iter().for_each(|n| cdr.string(n));
    cdr.length(positions.len());
    positions.iter().for_each(|p| cdr.f64(*p));
    cdr.length(0);
    cdr.length(0);
    cdr.finish()
}

/// `nav_msgs/OccupancyGrid`: rows from low y, -1 unknown, 0 free, 100 occupied.
pub(super) fn grid(
    time: f64,
    resolution: f64,
    [width, height]: [usize; 2],
    low: [f64; 3],
    cells: &[i8],
) -> Vec<u8> {
    let mut cdr = Cdr::new();
    header(&mut cdr, time);
    stamp(&mut cdr, time);
    cdr.f32(resolution as f32);
    cdr.u32(width as u32);
    cdr.u32(height as u32);
    pose(&mut cdr, &upright([low[0], low[1], 0.0]));
    cdr.length(cells.len());
    cells.iter().for_each(|c| cdr.u8(*c as u8));
    cdr.finish()
}

/// `sensor_msgs/PointCloud2` of x, y, z (float32) and, if given, a state (uint8) for each point.
pub(super) fn cloud(
    time: f64,
    points: impl ExactSizeIterator<Item = [f64; 3]>,
    states: Option<&[u8]>,
) -> Vec<u8> {
    const FLOAT32: u8 = 7;
    const UINT8: u8 = 2;
    let mut cdr = Cdr::new();
    header(&mut cdr, time);
    let count = points.len();
    cdr.u32(1);
    cdr.u32(count as u32);
    let mut fields = vec![("x", 0, FLOAT32), ("y", 4, FLOAT32), ("z", 8, FLOAT32)];
    if states.is_some() {
        fields.push(("state", 12, UINT8));
    }
    cdr.length(fields.len());
    for (name, offset, kind) in &fields {
        cdr.string(name);
        cdr.u32(*offset);
        cdr.u8(*kind);
        cdr.u32(1);
    }
    cdr.bool(false);
    let step = if states.is_some() { 16 } else { 12 };
    cdr.u32(step);
    cdr.u32(step * count as u32);
    let mut data = Vec::with_capacity(step as usize * count);
    for (i, p) in points.enumerate() {
        p.iter()
            .for_each(|v| data.extend((*v as f32).to_le_bytes()));
        if let Some(states) = states {
            data.extend([states.get(i).copied().unwrap_or(0), 0, 0, 0]);
        }
    }
    cdr.blob(&data);
    cdr.bool(true);
    cdr.finish()
}

/// `nav_msgs/Path`: each pose with the time at which it is due.
pub(super) fn path(time: f64, poses: impl ExactSizeIterator<Item = (f64, View)>) -> Vec<u8> {
    let mut cdr = Cdr::new();
    header(&mut cdr, time);
    cdr.length(poses.len());
    for (due, view) in poses {
        header(&mut cdr, due);
        pose(&mut cdr, &view);
    }
    cdr.finish()
}

/// What a marker shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub(super) enum Shape {
    Cube = 1,
    LineList = 5,
    CubeList = 6,
}

/// A marker; one without points at its place, one with points at theirs.
#[derive(Clone, Debug)]
pub(super) struct Marker {
    pub(super) space: &'static str,
    pub(super) id: i32,
    pub(super) shape: Shape,
    /// Whether it goes.
    pub(super) delete: bool,
    pub(super) place: [f64; 3],
    pub(super) scale: [f64; 3],
    pub(super) color: [f32; 4],
    pub(super) points: Vec<[f64; 3]>,
}

/// `visualization_msgs/MarkerArray`.
pub(super) fn markers(time: f64, list: &[Marker]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.length(list.len());
    for m in list {
        header(&mut cdr, time);
        cdr.string(m.space);
        cdr.i32(m.id);
        cdr.i32(m.shape as i32);
        cdr.i32(if m.delete { 2 } else { 0 });
        pose(&mut cdr, &upright(m.place));
        point(&mut cdr, m.scale);
        m.color.iter().for_each(|c| cdr.f32(*c));
        // Lives until it is deleted or replaced.
        cdr.i32(0);
        cdr.u32(0);
        cdr.bool(false);
        cdr.length(m.points.len());
        m.points.iter().for_each(|p| point(&mut cdr, *p));
        cdr.length(0);
        // No texture, text or mesh.
        cdr.string("");
        stamp(&mut cdr, 0.0);
        cdr.string("");
        cdr.string("");
        cdr.length(0);
        cdr.length(0);
        cdr.string("");
        cdr.string("");
        cdr.string("");
        cdr.length(0);
        cdr.bool(false);
    }
    cdr.finish()
}

/// `std_msgs/Float32`.
pub(super) fn float(value: f64) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.f32(value as f32);
    cdr.finish()
}

/// `std_msgs/Int32`.
pub(super) fn integer(value: i32) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.i32(value);
    cdr.finish()
}

/// `std_msgs/String`.
pub(super) fn text(value: &str) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.string(value);
    cdr.finish()
}
