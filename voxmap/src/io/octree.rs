//! OctoMap's octrees: `.bt` (free, occupied) and `.ot` (log-odds), both ways.
//!
//! In memory a tree is the list of its leaves in depth-first order, which is Morton order of their keys: every inner node is
//! a run of the list, so that writing and look-ups need no pointers.

use super::Error;
use super::bytes::Bytes;
use crate::geometry::{Cell, State};
use crate::map::{MOST_CELLS, VoxelMap};
use crate::sensor::{Odds, SensorModel, UNIT};

/// Levels of OctoMap's trees below the root.
const DEPTH: u8 = 16;
/// Key of the cell whose lower corner is the world's origin.
const MIDDLE: i32 = 1 << (DEPTH - 1);
const BT: &str = "OctoMap .bt";
const OT: &str = "OctoMap .ot";
/// Log-odds that OctoMap gives the leaves of a `.bt`: its clamps.
const BINARY: [f32; 2] = [-2.0, 3.5];

/// A leaf: a cube of `2^level` cells on a side with one log-odds value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcLeaf {
    /// Lowest cell of the cube; cell `c` covers `[c, c + 1)` times the resolution on every axis.
    pub cell: Cell,
    /// 0 for a single cell, 16 for the whole tree.
    pub level: u8,
    /// Log-odds of being occupied; OctoMap calls leaves at or above 0 occupied.
    pub log_odds: f32,
}

impl OcLeaf {
    /// Cells along an edge.
    pub fn edge(&self) -> i32 {
        1 << self.level
    }

    /// Free or occupied by OctoMap's default threshold.
    pub fn state(&self) -> State {
        if self.log_odds >= 0.0 {
            State::Occupied
        } else {
            State::Free
        }
    }

    fn code(&self) -> u64 {
        morton(self.cell)
    }
}

/// Position of a cell in depth-first order: the bits of its keys interleaved, x lowest.
fn morton(cell: Cell) -> u64 {
    let spread = |v: i32| {
        let mut bits = u64::from((v + MIDDLE) as u16);
        bits = (bits | bits << 16) & 0x001f_0000_ff00_00ff;
        bits = (bits | bits << 8) & 0x100f_00f0_0f00_f00f;
        bits = (bits | bits << 4) & 0x10c3_0c30_c30c_30c3;
        (bits | bits << 2) & 0x1249_2492_4924_9249
    };
    spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2
}

/// An octree as OctoMap stores it.
#[derive(Clone, Debug, PartialEq)]
pub struct OcTree {
    resolution: f64,
    /// In Morton order, disjoint.
    leaves: Vec<OcLeaf>,
}

impl OcTree {
    /// Reads a `.bt` file: trees of the id `OcTree`.
    ///
    /// # Errors
    /// [`Error`] for bytes that are no such file. Memory stays below 64 times their length.
    pub fn read_bt(bytes: &[u8]) -> Result<Self, Error> {
        let mut bytes = Bytes::new(BT, bytes);
        let header = header(&mut bytes, BT, "# Octomap OcTree binary file")?;
        if header.id != "OcTree" {
            return Err(Error::malformed(BT, "id", header.id, "OcTree"));
        }
        let mut reader = Reader::new(bytes, BT);
        if header.nodes > 0 {
            reader.bt_node([-MIDDLE; 3], DEPTH)?;
        }
        reader.finish(&header)
    }

    /// Reads an `.ot` file: trees of the ids `OcTree` and `ColorOcTree` (colours are left out).
    ///
    /// # Errors
    /// [`Error`] for bytes that are no such file. Memory stays below 64 times their length.
    pub fn read_ot(bytes: &[u8]) -> Result<Self, Error> {
        let mut bytes = Bytes::new(OT, bytes);
        let header = header(&mut bytes, OT, "# Octomap OcTree file")?;
        let extra = match header.id.as_str() {
            "OcTree" => 0,
            "ColorOcTree" => 3,
            other => {
                let wanted = "OcTree or ColorOcTree";
                return Err(Error::malformed(OT, "id", other, wanted));
            }
        };
        let mut reader = Reader::new(bytes, OT);
        if header.nodes > 0 {
            reader.ot_node([-MIDDLE; 3], DEPTH, extra)?;
        }
        reader.finish(&header)
    }

    /// The tree as a `.bt` file: every leaf free or occupied, equal leaves joined.
    pub fn write_bt(&self) -> Vec<u8> {
        let mut binary = Vec::new();
        for leaf in &self.leaves {
            let log_odds = BINARY[usize::from(leaf.state() == State::Occupied)];
            push_joined(&mut binary, OcLeaf { log_odds, ..*leaf });
        }
        let mut data = Vec::new();
        // The format has no place for the state of the root itself: a tree that is one leaf is split.
        let nodes = if binary.is_empty() {
            0
        } else {
            write_bt_node(&mut data, &split_root(binary), [-MIDDLE; 3], DEPTH)
        };
        let first = "# Octomap OcTree binary file";
        with_header(first, nodes, self.resolution, &data)
    }

    /// The tree as an `.ot` file; inner nodes hold the largest value below them, as OctoMap's do.
    pub fn write_ot(&self) -> Vec<u8> {
        let mut data = Vec::new();
        let mut nodes = 0;
        if !self.leaves.is_empty() {
            write_ot_node(&mut data, &mut nodes, &self.leaves, [-MIDDLE; 3], DEPTH);
        }
        with_header("# Octomap OcTree file", nodes, self.resolution, &data)
    }

    /// The known cells of a map.
    ///
    /// # Errors
    /// [`Error::Unaligned`] if the map's corner is no whole number of cells from the world's origin, [`Error::TooLarge`] if
    /// the map reaches farther than 32768 cells from there.
    pub fn from_map(map: &VoxelMap) -> Result<Self, Error> {
        let h = map.cell_size();
        let low = map.low();
        // Whole cells from the world's origin to cell 0.
        let offset = map.anchor.map(|v| (v / h).round());
        if (0..3).any(|a| (map.anchor[a] - offset[a] * h).abs() > 1e-3 * h) {
            return Err(Error::Unaligned { low, cell_size: h });
        }
        let bounds = map.bounds();
        for a in 0..3 {
            let reach =
                (-offset[a] - f64::from(bounds.low[a])).max(offset[a] + f64::from(bounds.high[a]));
            if reach > f64::from(MIDDLE) {
                return Err(Error::TooLarge {
                    part: "cells from the origin",
                    asked: reach,
                    most: f64::from(MIDDLE),
                });
            }
        }
        let offset = offset.map(|v| v as i32);
        let mut leaves = Vec::new();
        collect(map, offset, [-MIDDLE; 3], DEPTH, &mut leaves);
        Ok(Self {
            resolution: h,
            leaves,
        })
    }

    /// A bounded map of the tree's bounding box. Cells have the same indices in both: cell 0 has its lower corner at the
    /// world's origin. Values are clamped to the sensor model and rounded to its units without changing sides of OctoMap's
    /// threshold.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the box holds more than `most` cells (a tree of a few bytes may span 2^48), and the map's own
    /// errors. A tree without leaves becomes a map of one unknown cell.
    pub fn to_map(&self, sensor: &SensorModel, most: usize) -> Result<VoxelMap, Error> {
        let (low, mut high) = self.bounds();
        for a in 0..3 {
            high[a] = high[a].max(low[a] + 1);
        }
        let size = [0, 1, 2].map(|a| (high[a] - low[a]) as usize);
        let asked = (size[0].div_ceil(64) * 64) as f64 * size[1] as f64 * size[2] as f64;
        let most = most.min(MOST_CELLS);
        if asked > most as f64 {
            return Err(Error::TooLarge {
                part: "cells of the bounding box",
                asked,
                most: most as f64,
            });
        }
        let odds = Odds::new(sensor)?;
        let mut map = VoxelMap::blank(self.resolution, [0.0; 3], low, size, odds);
        for leaf in &self.leaves {
            let unit = (f64::from(leaf.log_odds) / UNIT)
                .round()
                .clamp(-127.0, 127.0) as i8;
            // Rounding must not carry a free leaf over OctoMap's threshold, 0.
            let unit = if leaf.log_odds < 0.0 {
                unit.min(-1)
            } else {
                unit.max(0)
            };
            let unit = unit.clamp(odds.min, odds.max);
            let from = leaf.cell;
            let edge = leaf.edge();
            for z in from[2]..from[2] + edge {
                for y in from[1]..from[1] + edge {
                    for x in from[0]..from[0] + edge {
                        map.set_log([x, y, z], unit);
                    }
                }
            }
        }
        Ok(map)
    }

    /// Edge of a cell, m.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// The leaves in depth-first order.
    pub fn leaves(&self) -> &[OcLeaf] {
        &self.leaves
    }

    /// First cell inside the leaves' bounding box, and first beyond; both zero without leaves.
    pub fn bounds(&self) -> (Cell, Cell) {
        if self.leaves.is_empty() {
            return ([0; 3], [0; 3]);
        }
        let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
        for leaf in &self.leaves {
            for a in 0..3 {
                low[a] = low[a].min(leaf.cell[a]);
                high[a] = high[a].max(leaf.cell[a] + leaf.edge());
            }
        }
        (low, high)
    }

    /// The leaf that holds a cell.
    pub fn leaf(&self, cell: Cell) -> Option<&OcLeaf> {
        if cell.iter().any(|v| !(-MIDDLE..MIDDLE).contains(v)) {
            return None;
        }
        let code = morton(cell);
        let after = self.leaves.partition_point(|leaf| leaf.code() <= code);
        let leaf = &self.leaves[after.checked_sub(1)?];
        ((code - leaf.code()) >> (3 * leaf.level) == 0).then_some(leaf)
    }

    /// State of the cell that holds a point, by OctoMap's default threshold; unknown outside the tree.
    pub fn state_at(&self, point: [f64; 3]) -> State {
        let cell = point.map(|v| (v / self.resolution).floor() as i32);
        self.leaf(cell).map_or(State::Unknown, OcLeaf::state)
    }
}

struct Header {
    id: String,
    nodes: u64,
    resolution: f64,
}

/// The text before the data.
fn header(
    bytes: &mut Bytes<'_>,
    format: &'static str,
    first: &'static str,
) -> Result<Header, Error> {
    let line = bytes.line("the first line")?;
    if line.trim_end() != first {
        return Err(Error::malformed(format, "first line", line, first));
    }
    let (mut id, mut nodes, mut resolution) = (None, None, None);
    loop {
        let line = bytes.line("the header")?;
        let mut words = line.split_whitespace();
        let (key, value) = (words.next().unwrap_or("#"), words.next().unwrap_or(""));
        match key {
            "data" => break,
            "id" => id = Some(value.to_owned()),
            "size" => {
                let wanted = "a number of nodes";
                nodes = Some(
                    value
                        .parse()
                        .map_err(|_| Error::malformed(format, "size", value, wanted))?,
                );
            }
            "res" => {
                let good = value
                    .parse()
                    .ok()
                    .filter(|v: &f64| *v > 0.0 && v.is_finite());
                let wanted = "a positive length";
                resolution =
                    Some(good.ok_or_else(|| Error::malformed(format, "res", value, wanted))?);
            }
            _ if key.starts_with('#') => {}
            _ => {
                return Err(Error::malformed(
                    format,
                    "header line",
                    &line,
                    "id, size, res, data or a comment",
                ));
            }
        }
    }
    let missing = |part| Error::malformed(format, part, "missing", "given before `data`");
    Ok(Header {
        id: id.ok_or_else(|| missing("id"))?,
        nodes: nodes.ok_or_else(|| missing("size"))?,
        resolution: resolution.ok_or_else(|| missing("res"))?,
    })
}

fn with_header(first: &str, nodes: u64, resolution: f64, data: &[u8]) -> Vec<u8> {
    let text = format!("{first}\nid OcTree\nsize {nodes}\nres {resolution}\ndata\n");
    let mut out = text.into_bytes();
    out.extend_from_slice(data);
    out
}

/// Lowest cell of a child.
fn child_cell(cell: Cell, level: u8, child: usize) -> Cell {
    let half = 1 << (level - 1);
    [0, 1, 2].map(|a| cell[a] + if child >> a & 1 != 0 { half } else { 0 })
}

/// Depth-first reader of nodes.
struct Reader<'a> {
    bytes: Bytes<'a>,
    format: &'static str,
    nodes: u64,
    leaves: Vec<OcLeaf>,
}

impl<'a> Reader<'a> {
    fn new(bytes: Bytes<'a>, format: &'static str) -> Self {
        Self {
            bytes,
            format,
            nodes: 0,
            leaves: Vec::new(),
        }
    }

    /// Two bits a child: 0 unknown, 1 free, 2 occupied, 3 inner.
    fn bt_node(&mut self, cell: Cell, level: u8) -> Result<(), Error> {
        if level == 0 {
            let wanted = "at most 16 levels below the root";
            return Err(Error::malformed(self.format, "depth", "17 levels", wanted));
        }
        self.nodes += 1;
        let kinds = u16::from_le_bytes(self.bytes.array("a node")?);
        for child in 0..8 {
            let place = child_cell(cell, level, child);
            match kinds >> (2 * child) & 3 {
                0 => {}
                3 => self.bt_node(place, level - 1)?,
                kind => {
                    self.nodes += 1;
                    self.leaves.push(OcLeaf {
                        cell: place,
                        level: level - 1,
                        log_odds: BINARY[usize::from(kind - 1)],
                    });
                }
            }
        }
        Ok(())
    }

    /// Log-odds as a little-endian float, `extra` bytes, one bit a child.
    fn ot_node(&mut self, cell: Cell, level: u8, extra: usize) -> Result<(), Error> {
        self.nodes += 1;
        let log_odds = f32::from_le_bytes(self.bytes.array("a node's value")?);
        self.bytes.take(extra, "a node's colour")?;
        let [children] = self.bytes.array("a node's children")?;
        if children == 0 {
            if log_odds.is_nan() {
                return Err(Error::malformed(
                    self.format,
                    "log-odds",
                    log_odds,
                    "a number",
                ));
            }
            self.leaves.push(OcLeaf {
                cell,
                level,
                log_odds,
            });
            return Ok(());
        }
        if level == 0 {
            let wanted = "at most 16 levels below the root";
            return Err(Error::malformed(self.format, "depth", "17 levels", wanted));
        }
        for child in (0..8).filter(|c| children >> c & 1 != 0) {
            self.ot_node(child_cell(cell, level, child), level - 1, extra)?;
        }
        Ok(())
    }

    fn finish(self, header: &Header) -> Result<OcTree, Error> {
        let count = |part, announced, found| Error::Count {
            format: self.format,
            part,
            announced,
            found,
        };
        if self.nodes != header.nodes {
            return Err(count("nodes", header.nodes, self.nodes));
        }
        if self.bytes.left() > 0 {
            return Err(count(
                "bytes after the last node",
                0,
                self.bytes.left() as u64,
            ));
        }
        Ok(OcTree {
            resolution: header.resolution,
            leaves: self.leaves,
        })
    }
}

/// Appends a leaf in Morton order; eight equal siblings become their parent.
fn push_joined(leaves: &mut Vec<OcLeaf>, mut leaf: OcLeaf) {
    loop {
        let last_child = (0..3).all(|a| (leaf.cell[a] + MIDDLE) >> leaf.level & 1 == 1);
        let alike = |other: &OcLeaf| {
            other.level == leaf.level
                && other.log_odds == leaf.log_odds
                && (0..3).all(|a| (other.cell[a] ^ leaf.cell[a]) >> (leaf.level + 1) == 0)
        };
        let Some(first) = leaves.len().checked_sub(7) else {
            break;
        };
        if leaf.level == DEPTH || !last_child || !leaves[first..].iter().all(alike) {
            break;
        }
        leaf = OcLeaf {
            level: leaf.level + 1,
            ..leaves[first]
        };
        leaves.truncate(first);
    }
    leaves.push(leaf);
}

/// A leaf that fills the whole tree as its eight children.
fn split_root(leaves: Vec<OcLeaf>) -> Vec<OcLeaf> {
    match leaves[..] {
        [root] if root.level == DEPTH => (0..8)
            .map(|child| OcLeaf {
                cell: child_cell(root.cell, DEPTH, child),
                level: DEPTH - 1,
                ..root
            })
            .collect(),
        _ => leaves,
    }
}

/// The leaves below each child of a node.
fn below(leaves: &[OcLeaf], cell: Cell, level: u8) -> [&[OcLeaf]; 8] {
    let start = morton(cell);
    let mut rest = leaves;
    std::array::from_fn(|child| {
        let end = start + ((child as u64 + 1) << (3 * (level - 1)));
        let (here, after) = rest.split_at(rest.partition_point(|leaf| leaf.code() < end));
        rest = after;
        here
    })
}

/// True if one leaf fills a node of that level.
fn is_leaf(leaves: &[OcLeaf], level: u8) -> bool {
    matches!(leaves, [leaf] if leaf.level == level)
}

/// Returns the number of nodes written, the leaves included.
fn write_bt_node(out: &mut Vec<u8>, leaves: &[OcLeaf], cell: Cell, level: u8) -> u64 {
    let children = below(leaves, cell, level);
    let mut kinds = 0u16;
    for (child, leaves) in children.iter().enumerate() {
        let kind = match leaves.first() {
            None => 0,
            Some(leaf) if is_leaf(leaves, level - 1) => 1 + u16::from(leaf.log_odds >= 0.0),
            Some(_) => 3,
        };
        kinds |= kind << (2 * child);
    }
    out.extend_from_slice(&kinds.to_le_bytes());
    let mut nodes = 1;
    for (child, leaves) in children.iter().enumerate() {
        nodes += match kinds >> (2 * child) & 3 {
            0 => 0,
            3 => write_bt_node(out, leaves, child_cell(cell, level, child), level - 1),
            _ => 1,
        };
    }
    nodes
}

fn write_ot_node(out: &mut Vec<u8>, nodes: &mut u64, leaves: &[OcLeaf], cell: Cell, level: u8) {
    *nodes += 1;
    let highest = leaves
        .iter()
        .map(|leaf| leaf.log_odds)
        .fold(f32::NEG_INFINITY, f32::max);
    out.extend_from_slice(&highest.to_le_bytes());
    if is_leaf(leaves, level) {
        out.push(0);
        return;
    }
    let children = below(leaves, cell, level);
    let mask = (0..8).fold(0, |mask, c| mask | u8::from(!children[c].is_empty()) << c);
    out.push(mask);
    for (child, leaves) in children.iter().enumerate() {
        if !leaves.is_empty() {
            write_ot_node(
                out,
                nodes,
                leaves,
                child_cell(cell, level, child),
                level - 1,
            );
        }
    }
}

/// Appends the known cells of a cube in Morton order, joined. `offset` takes the map's cells to the tree's.
fn collect(map: &VoxelMap, offset: Cell, cell: Cell, level: u8, leaves: &mut Vec<OcLeaf>) {
    let bounds = map.bounds();
    let edge = 1i32 << level;
    let from = [0, 1, 2].map(|a| cell[a] - offset[a]);
    if (0..3).any(|a| from[a] >= bounds.high[a] || from[a] + edge <= bounds.low[a]) {
        return;
    }
    if level == 0 {
        if map.is_known(from) {
            let log_odds = (f64::from(map.log(from)) * UNIT) as f32;
            let log_odds = if map.is_occupied(from) {
                log_odds.max(0.0)
            } else {
                log_odds.min(-UNIT as f32)
            };
            push_joined(
                leaves,
                OcLeaf {
                    cell,
                    level,
                    log_odds,
                },
            );
        }
        return;
    }
    for child in 0..8 {
        collect(
            map,
            offset,
            child_cell(cell, level, child),
            level - 1,
            leaves,
        );
    }
}
