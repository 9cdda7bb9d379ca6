//! Point clouds: the points, and the pose they were taken from if the file has one.

use super::Error;
use super::bytes::Bytes;

/// Points of one file.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// Points, m. May hold NaN, which PCD uses for "no return".
    pub points: Vec<[f32; 3]>,
    /// Where the sensor stood in the points' frame, m. PCD's `VIEWPOINT`; zero in PLY.
    pub position: [f64; 3],
    /// How it was turned: a quaternion w, x, y, z. The points are not turned by it.
    pub rotation: [f64; 4],
}

impl Cloud {
    /// A cloud seen from its frame's origin.
    pub fn new(points: Vec<[f32; 3]>) -> Self {
        Self {
            points,
            position: [0.0; 3],
            rotation: [1.0, 0.0, 0.0, 0.0],
        }
    }
}

/// Type of a number in a file.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number of these bytes, which are as many as the type has.
    pub(super) fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        let mut b = [0; 8];
        b[..bytes.len()].copy_from_slice(bytes);
        if big_endian {
            b[..bytes.len()].reverse();
        }
        let low = [b[0], b[1], b[2], b[3]];
        match self {
            Self::I8 => f64::from(b[0] as i8),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::I32 => f64::from(i32::from_le_bytes(low)),
            Self::U32 => f64::from(u32::from_le_bytes(low)),
            Self::F32 => f64::from(f32::from_le_bytes(low)),
            Self::F64 => f64::from_le_bytes(b),
        }
    }
}

/// The numbers of a text line.
pub(super) fn number(format: &'static str, part: &'static str, word: &str) -> Result<f64, Error> {
    word.parse()
        .map_err(|_| Error::malformed(format, part, word, "a number"))
}

/// Rows of one record each, all of the same width, with x, y, z somewhere inside.
pub(super) struct Records {
    pub format: &'static str,
    /// Bytes of a record.
    pub width: usize,
    /// Where x, y and z stand in it, and as what.
    pub xyz: [(usize, Number); 3],
    pub big_endian: bool,
}

impl Records {
    /// Reads `count` records. What a header announces is believed only as far as there are bytes.
    pub(super) fn read(&self, bytes: &mut Bytes<'_>, count: u64) -> Result<Vec<[f32; 3]>, Error> {
        let held = (bytes.left() / self.width.max(1)) as u64;
        if count > held {
            return Err(Error::Count {
                format: self.format,
                part: "points",
                announced: count,
                found: held,
            });
        }
        (0..count)
            .map(|_| {
                let record = bytes.take(self.width, "a point")?;
                Ok(self.xyz.map(|(at, number)| {
                    number.value(&record[at..at + number.bytes()], self.big_endian) as f32
                }))
            })
            .collect()
    }
}
