//! The map's own file: everything that a map knows, compact, with a version and a checksum.
//!
//! Little-endian: `VOXM`, version (u32), cell size (f64), anchor (3 f64), first cell (3 i32), size (3 u32), log-odds units of
//! the sensor model (hit, miss, min, max, occupied: 5 i8), growth limit (u64, 0 for bounded maps), scans (u64), number of rows
//! (u32), rows, and the FNV-1a hash (u64) of all bytes before it. A row is 64 cells along x with something known: its word's
//! number (u32), a kind (u8), the free and occupied bits (2 u64), then log-odds (kind bit 0: one i8 for all free and one for
//! all occupied cells; else one i8 for each known cell in order) and, with kind bit 1, six u64 of inspected faces.

use super::Error;
use super::bytes::Bytes;
use crate::map::{MOST_CELLS, VoxelMap, checked_cell_size, fits};
use crate::sensor::Odds;

const SAVED: &str = "voxmap snapshot";
const MAGIC: &[u8; 4] = b"VOXM";
const VERSION: u32 = 1;
/// One value for all free and one for all occupied cells.
const UNIFORM: u8 = 1;
/// Inspected faces follow.
const SEEN: u8 = 2;

fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &b| {
        (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    })
}

impl VoxelMap {
    /// The map as bytes, about one and a half for each known cell or less; changes not yet taken are not saved.
    pub fn save(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend_from_slice(&VERSION.to_le_bytes());
        out.extend_from_slice(&self.cell_size.to_le_bytes());
        self.anchor
            .iter()
            .for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
        self.first
            .iter()
            .for_each(|v| out.extend_from_slice(&v.to_le_bytes()));
        self.size
            .iter()
            .for_each(|&v| out.extend_from_slice(&(v as u32).to_le_bytes()));
        let Odds {
            hit,
            miss,
            min,
            max,
            occupied,
        } = self.odds;
        out.extend([hit, miss, min, max, occupied].map(|v| v as u8));
        out.extend_from_slice(&(self.limit.unwrap_or(0) as u64).to_le_bytes());
        out.extend_from_slice(&self.scans.to_le_bytes());
        let count_at = out.len();
        out.extend_from_slice(&[0; 4]);
        let mut rows = 0u32;
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                for w in 0..self.words {
                    rows += u32::from(self.save_row(&mut out, w, y, z));
                }
            }
        }
        out[count_at..count_at + 4].copy_from_slice(&rows.to_le_bytes());
        let hash = fnv(&out);
        out.extend_from_slice(&hash.to_le_bytes());
        out
    }

    /// Appends a row if anything in it is known.
    fn save_row(&self, out: &mut Vec<u8>, w: usize, y: usize, z: usize) -> bool {
        let word = self.word(w, y, z);
        let (free, occupied) = (self.free[word], self.occupied[word]);
        let known = free | occupied;
        if known == 0 {
            return false;
        }
        let blank = [0; 64];
        let log = self.log.get(w, y, z).unwrap_or(&blank);
        let values = |bits: u64| (0..64).filter(move |x| bits >> x & 1 != 0).map(|x| log[x]);
        // The one value of some cells, 0 if there are none.
        let one = |bits: u64| {
            let first = values(bits).next().unwrap_or(0);
            values(bits).all(|v| v == first).then_some(first)
        };
        let seen = self.seen.get(w, y, z).filter(|seen| **seen != [0; 6]);
        let uniform = one(free).zip(one(occupied));
        let kind = u8::from(uniform.is_some()) * UNIFORM + u8::from(seen.is_some()) * SEEN;
        out.extend_from_slice(&(word as u32).to_le_bytes());
        out.push(kind);
        out.extend_from_slice(&free.to_le_bytes());
        out.extend_from_slice(&occupied.to_le_bytes());
        match uniform {
            Some((free, occupied)) => out.extend([free as u8, occupied as u8]),
            None => out.extend(values(known).map(|v| v as u8)),
        }
        for plane in seen.into_iter().flatten() {
            out.extend_from_slice(&plane.to_le_bytes());
        }
        true
    }

    /// The map of [`save`](Self::save)d bytes, if it has at most `most` cells (rows padded to 64).
    ///
    /// # Errors
    /// [`Error`] for bytes of something else, of another version, damaged ones, or a map that contradicts itself.
    pub fn load(bytes: &[u8], most: usize) -> Result<Self, Error> {
        let mut all = Bytes::new(SAVED, bytes);
        let magic: [u8; 4] = all.array("the magic number")?;
        if &magic != MAGIC {
            return Err(Error::malformed(
                SAVED,
                "magic number",
                String::from_utf8_lossy(&magic),
                "VOXM",
            ));
        }
        let version = u32::from_le_bytes(all.array("the version")?);
        if version != VERSION {
            return Err(Error::malformed(SAVED, "version", version, "1"));
        }
        if bytes.len() < 16 {
            return Err(Error::Truncated {
                format: SAVED,
                part: "the checksum",
                offset: bytes.len(),
            });
        }
        let end = bytes.len() - 8;
        let found = u64::from_le_bytes(Bytes::new(SAVED, &bytes[end..]).array("the checksum")?);
        let wanted = fnv(&bytes[..end]);
        if found != wanted {
            return Err(Error::Checksum {
                format: SAVED,
                found,
                wanted,
            });
        }
        let mut body = Bytes::new(SAVED, &bytes[8..end]);
        let mut map = blank(&mut body, most)?;
        let rows = u32::from_le_bytes(body.array("the number of rows")?);
        let mut last = None;
        for _ in 0..rows {
            let word = u32::from_le_bytes(body.array("a row")?);
            if word as usize >= map.free.len() || last.is_some_and(|last| last >= word) {
                return Err(Error::malformed(
                    SAVED,
                    "number of a row",
                    word,
                    "inside the map, in ascending order",
                ));
            }
            last = Some(word);
            map.load_row(&mut body, word as usize)?;
        }
        if body.left() > 0 {
            return Err(Error::Count {
                format: SAVED,
                part: "bytes after the last row",
                announced: 0,
                found: body.left() as u64,
            });
        }
        map.take_changes();
        Ok(map)
    }

    fn load_row(&mut self, body: &mut Bytes<'_>, word: usize) -> Result<(), Error> {
        let (w, line) = (word % self.words, word / self.words);
        let (y, z) = (line % self.size[1], line / self.size[1]);
        let [kind] = body.array("a row's kind")?;
        let free = u64::from_le_bytes(body.array("free cells")?);
        let occupied = u64::from_le_bytes(body.array("occupied cells")?);
        let known = free | occupied;
        let inside = match self.size[0] - w * 64 {
            cells if cells >= 64 => u64::MAX,
            cells => (1 << cells) - 1,
        };
        if kind > UNIFORM + SEEN || known == 0 || free & occupied != 0 || known & !inside != 0 {
            return Err(Error::malformed(
                SAVED,
                "a row",
                word,
                "of cells inside the map, each free or occupied",
            ));
        }
        let odds = self.odds;
        let row = self.log.make(w, y, z);
        let values = if kind & UNIFORM != 0 {
            body.take(2, "log-odds")?
        } else {
            body.take(known.count_ones() as usize, "log-odds")?
        };
        let mut next = 0;
        for x in (0..64).filter(|x| known >> x & 1 != 0) {
            let is_occupied = occupied >> x & 1 != 0;
            let value = if kind & UNIFORM != 0 {
                values[usize::from(is_occupied)]
            } else {
                next += 1;
                values[next - 1]
            } as i8;
            if (value >= odds.occupied) != is_occupied || value < odds.min || value > odds.max {
                return Err(Error::malformed(
                    SAVED,
                    "log-odds",
                    value,
                    "within the clamps, on the state's side",
                ));
            }
            row[x] = value;
        }
        self.write(w, y, z, known, free, occupied);
        if kind & SEEN != 0 {
            let mut seen = [0; 6];
            for plane in &mut seen {
                *plane = u64::from_le_bytes(body.array("inspected faces")?);
                if *plane & !occupied != 0 {
                    return Err(Error::malformed(
                        SAVED,
                        "inspected faces",
                        word,
                        "of occupied cells",
                    ));
                }
            }
            *self.seen.make(w, y, z) = seen;
        }
        Ok(())
    }
}

/// A map without known cells, as the header says.
fn blank(body: &mut Bytes<'_>, most: usize) -> Result<VoxelMap, Error> {
    let cell_size = checked_cell_size(f64::from_le_bytes(body.array("the cell size")?))?;
    let mut anchor = [0.0; 3];
    for v in &mut anchor {
        *v = f64::from_le_bytes(body.array("the anchor")?);
    }
    let mut first = [0; 3];
    for v in &mut first {
        *v = i32::from_le_bytes(body.array("the first cell")?);
    }
    let mut size = [0; 3];
    for v in &mut size {
        *v = u32::from_le_bytes(body.array("the size")?) as usize;
    }
    let [hit, miss, min, max, occupied] = body.array("the sensor model")?.map(|b: u8| b as i8);
    let odds = Odds {
        hit,
        miss,
        min,
        max,
        occupied,
    };
    let limit = u64::from_le_bytes(body.array("the limit")?) as usize;
    let scans = u64::from_le_bytes(body.array("the number of scans")?);
    let far = |v: &i32| v.unsigned_abs() > 1 << 30;
    if !anchor.iter().all(|v| v.is_finite()) || first.iter().any(far) || size.contains(&0) {
        return Err(Error::malformed(
            SAVED,
            "bounds",
            format!("{first:?} {size:?}"),
            "finite, with at least one cell",
        ));
    }
    if hit <= 0 || miss >= 0 || min >= occupied || max < occupied {
        return Err(Error::malformed(
            SAVED,
            "sensor model",
            format!("{odds:?}"),
            "miss < 0 < hit, min < occupied <= max",
        ));
    }
    let aligned = size[0] % 64 == 0 && size[1] % 8 == 0 && size[2] % 8 == 0;
    if limit > 0 && !(aligned && first[0] % 64 == 0 && first[1] % 8 == 0 && first[2] % 8 == 0) {
        return Err(Error::malformed(
            SAVED,
            "bounds",
            format!("{first:?} {size:?}"),
            "multiples of 64, 8, 8 in a growing map",
        ));
    }
    let asked = (size[0].div_ceil(64) * 64) as f64 * size[1] as f64 * size[2] as f64;
    let most = most.min(MOST_CELLS);
    if asked > most as f64 || !fits(size.map(|n| n as f64)) {
        return Err(Error::TooLarge {
            part: "cells",
            asked,
            most: most as f64,
        });
    }
    let mut map = VoxelMap::blank(cell_size, anchor, first, size, odds);
    map.limit = (limit > 0).then_some(limit.min(MOST_CELLS));
    map.scans = scans;
    Ok(map)
}
