//! 2-D maps as ROS keeps them: a PGM image and a YAML file with its place and thresholds, both ways.

use super::Error;
use super::bytes::Bytes;
use super::cloud::number;
use crate::costmap::{CostMap, CostMapParams, Ground};
use std::fmt::Write;

const PGM: &str = "PGM";
const YAML: &str = "map YAML";
/// Most pixels of an image.
const MOST_PIXELS: u64 = 1 << 28;

/// A grey image, first row on top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pgm {
    /// Pixels along x.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Value of white, 1..=65535.
    pub white: u16,
    /// Pixels, row by row.
    pub pixels: Vec<u16>,
}

/// The YAML file beside a map's image (nav2's map server and ROS 1's alike).
#[derive(Clone, Debug, PartialEq)]
pub struct GridInfo {
    /// File of the image.
    pub image: String,
    /// Edge of a pixel, m.
    pub resolution: f64,
    /// World position of the lower left corner of the lower left pixel, m, and its yaw, rad.
    pub origin: [f64; 3],
    /// Dark is occupied unless this is set.
    pub negate: bool,
    /// Occupancy above it is an obstacle.
    pub occupied_thresh: f64,
    /// Occupancy below it is free.
    pub free_thresh: f64,
}

/// Reads a PGM image, binary (P5) or text (P2).
///
/// # Errors
/// [`Error`] for bytes that are no such image, or more than 2^28 pixels.
pub fn read_pgm(bytes: &[u8]) -> Result<Pgm, Error> {
    let mut bytes = Bytes::new(PGM, bytes);
    let magic: [u8; 2] = bytes.array("the magic number")?;
    if &magic != b"P5" && &magic != b"P2" {
        return Err(Error::malformed(
            PGM,
            "magic number",
            String::from_utf8_lossy(&magic),
            "P5 or P2",
        ));
    }
    let width = pgm_number(&mut bytes, "the width")?;
    let height = pgm_number(&mut bytes, "the height")?;
    let white = pgm_number(&mut bytes, "the white value")?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MOST_PIXELS {
        return Err(Error::TooLarge {
            part: "pixels",
            asked: pixels as f64,
            most: MOST_PIXELS as f64,
        });
    }
    let white = u16::try_from(white)
        .ok()
        .filter(|&w| w > 0)
        .ok_or_else(|| Error::malformed(PGM, "white value", white, "1 to 65535"))?;
    let each = if &magic == b"P2" || white < 256 { 1 } else { 2 };
    if pixels * each > bytes.left() as u64 {
        return Err(Error::Count {
            format: PGM,
            part: "pixels",
            announced: pixels,
            found: bytes.left() as u64 / each,
        });
    }
    let mut out = Vec::with_capacity(pixels as usize);
    for _ in 0..pixels {
        let value = if &magic == b"P2" {
            pgm_number(&mut bytes, "a pixel")?
        } else if each == 1 {
            u32::from(bytes.array::<1>("a pixel")?[0])
        } else {
            u32::from(u16::from_be_bytes(bytes.array("a pixel")?))
        };
        let value = u16::try_from(value).ok().filter(|&v| v <= white);
        out.push(value.ok_or_else(|| {
            Error::malformed(PGM, "a pixel", "brighter", "at most the white value")
        })?);
    }
    Ok(Pgm {
        width: width as usize,
        height: height as usize,
        white,
        pixels: out,
    })
}

/// The next number of a header or a text image; comments run from `#` to the end of their line. One white space after the
/// number is eaten, as binary images want it.
fn pgm_number(bytes: &mut Bytes<'_>, part: &'static str) -> Result<u32, Error> {
    let mut value: Option<u32> = None;
    let mut comment = false;
    loop {
        let byte = match (bytes.array::<1>(part), value) {
            (Ok([byte]), _) => byte,
            // A text image may end with its last number.
            (Err(_), Some(value)) => return Ok(value),
            (Err(e), None) => return Err(e),
        };
        match byte {
            b'\n' => comment = false,
            _ if comment => continue,
            b'#' if value.is_none() => comment = true,
            b'0'..=b'9' => {
                let next = u64::from(value.unwrap_or(0)) * 10 + u64::from(byte - b'0');
                value = Some(
                    u32::try_from(next)
                        .map_err(|_| Error::malformed(PGM, part, next, "below 2^32"))?,
                );
                continue;
            }
            _ if byte.is_ascii_whitespace() => {}
            _ => {
                return Err(Error::malformed(
                    PGM,
                    part,
                    char::from(byte),
                    "a whole number",
                ));
            }
        }
        if let Some(value) = value {
            return Ok(value);
        }
    }
}

/// The image as a binary PGM.
pub fn write_pgm(image: &Pgm) -> Vec<u8> {
    let mut out = format!("P5\n{} {}\n{}\n", image.width, image.height, image.white).into_bytes();
    for &pixel in &image.pixels {
        if image.white < 256 {
            out.push(pixel as u8);
        } else {
            out.extend_from_slice(&pixel.to_be_bytes());
        }
    }
    out
}

impl GridInfo {
    /// Reads the YAML file of a map: flat `key: value` lines, the origin in brackets or as a list of dashes. The mode must be
    /// `trinary` (the default) or `scale`; unknown keys are passed over.
    ///
    /// # Errors
    /// [`Error::Malformed`] for lines, numbers and modes that make no map.
    pub fn read(text: &str) -> Result<Self, Error> {
        let mut out = Self {
            image: String::new(),
            resolution: f64::NAN,
            origin: [f64::NAN; 3],
            negate: false,
            occupied_thresh: 0.65,
            free_thresh: 0.196,
        };
        let mut dashes: Option<Vec<f64>> = None;
        for line in text.lines() {
            let line = line.split(" #").next().unwrap_or("").trim();
            if line.is_empty() || line.starts_with('#') || line == "---" {
                continue;
            }
            if let (Some(entry), Some(list)) = (line.strip_prefix("- "), &mut dashes) {
                list.push(number(YAML, "origin", entry.trim())?);
                if let [x, y, yaw] = list[..] {
                    out.origin = [x, y, yaw];
                }
                continue;
            }
            let Some((key, value)) = line.split_once(':') else {
                return Err(Error::malformed(YAML, "a line", line, "key: value"));
            };
            let value = value.trim().trim_matches(['"', '\'']);
            match key.trim() {
                "image" => value.clone_into(&mut out.image),
                "resolution" => out.resolution = number(YAML, "resolution", value)?,
                "occupied_thresh" => out.occupied_thresh = number(YAML, "occupied_thresh", value)?,
                "free_thresh" => out.free_thresh = number(YAML, "free_thresh", value)?,
                "negate" => {
                    out.negate = match value {
                        "0" | "false" => false,
                        "1" | "true" => true,
                        _ => {
                            return Err(Error::malformed(
                                YAML,
                                "negate",
                                value,
                                "0, 1, false or true",
                            ));
                        }
                    }
                }
                "mode" if !matches!(value, "trinary" | "scale") => {
                    return Err(Error::malformed(YAML, "mode", value, "trinary or scale"));
                }
                "origin" if value.is_empty() => dashes = Some(Vec::new()),
                "origin" => {
                    let inner = value.strip_prefix('[').and_then(|v| v.strip_suffix(']'));
                    let words: Vec<&str> = inner.unwrap_or("").split(',').map(str::trim).collect();
                    let [x, y, yaw] = words[..] else {
                        return Err(Error::malformed(YAML, "origin", value, "[x, y, yaw]"));
                    };
                    out.origin = [
                        number(YAML, "origin", x)?,
                        number(YAML, "origin", y)?,
                        number(YAML, "origin", yaw)?,
                    ];
                }
                _ => {}
            }
        }
        let good = |v: f64| v > 0.0 && v.is_finite();
        if !good(out.resolution) {
            return Err(Error::malformed(
                YAML,
                "resolution",
                out.resolution,
                "given, positive and finite",
            ));
        }
        if out.origin.iter().any(|v| !v.is_finite()) {
            return Err(Error::malformed(
                YAML,
                "origin",
                format!("{:?}", out.origin),
                "given, three finite numbers",
            ));
        }
        // Also false for NaN.
        if !(0.0 <= out.free_thresh
            && out.free_thresh <= out.occupied_thresh
            && out.occupied_thresh <= 1.0)
        {
            let found = format!("{} and {}", out.free_thresh, out.occupied_thresh);
            return Err(Error::malformed(
                YAML,
                "thresholds",
                found,
                "0 <= free <= occupied <= 1",
            ));
        }
        Ok(out)
    }

    /// The YAML file.
    pub fn write(&self) -> String {
        let [x, y, yaw] = self.origin;
        let mut out = String::new();
        let _ = writeln!(out, "image: {}", self.image);
        let _ = writeln!(out, "mode: trinary");
        let _ = writeln!(out, "resolution: {}", self.resolution);
        let _ = writeln!(out, "origin: [{x:?}, {y:?}, {yaw:?}]");
        let _ = writeln!(out, "negate: {}", u8::from(self.negate));
        let _ = writeln!(out, "occupied_thresh: {}", self.occupied_thresh);
        let _ = writeln!(out, "free_thresh: {}", self.free_thresh);
        out
    }

    /// The map of an image.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a map that is turned, or an image without pixels.
    pub fn cost_map(&self, image: &Pgm) -> Result<CostMap, Error> {
        if self.origin[2] != 0.0 {
            return Err(Error::malformed(
                YAML,
                "yaw of the origin",
                self.origin[2],
                "0; turned maps are not supported",
            ));
        }
        if image.width == 0
            || image.pixels.len() != image.width * image.height
            || image.pixels.is_empty()
        {
            let found = format!(
                "{} x {}, {} pixels",
                image.width,
                image.height,
                image.pixels.len()
            );
            return Err(Error::malformed(
                PGM,
                "size",
                found,
                "at least one pixel, as many as width x height",
            ));
        }
        let white = f64::from(image.white);
        let ground = |&pixel: &u16| {
            let shade = f64::from(pixel) / white;
            let occupancy = if self.negate { shade } else { 1.0 - shade };
            if occupancy > self.occupied_thresh {
                Ground::Obstacle
            } else if occupancy < self.free_thresh {
                Ground::Free
            } else {
                Ground::Unknown
            }
        };
        // The image's first row is the map's last.
        let cells = image
            .pixels
            .chunks(image.width)
            .rev()
            .flatten()
            .map(ground)
            .collect();
        let low = [self.origin[0], self.origin[1]];
        Ok(CostMap::from_ground(
            self.resolution,
            low,
            [image.width, image.height],
            cells,
        )?)
    }

    /// The YAML contents and the image of a map; `image` is the name of the image's file.
    pub fn of(map: &CostMap, image: &str) -> (Self, Pgm) {
        let [width, height] = map.size();
        let mut pixels = Vec::with_capacity(width * height);
        for y in (0..height as i32).rev() {
            for x in 0..width as i32 {
                pixels.push(match map.ground([x, y]) {
                    Ground::Obstacle => 0,
                    Ground::Unknown => 205,
                    Ground::Free => 254,
                });
            }
        }
        let info = Self {
            image: image.to_owned(),
            resolution: map.cell_size(),
            origin: [map.low()[0], map.low()[1], 0.0],
            negate: false,
            occupied_thresh: 0.65,
            free_thresh: 0.196,
        };
        let image = Pgm {
            width,
            height,
            white: 255,
            pixels,
        };
        (info, image)
    }
}

impl CostMap {
    /// A map of given ground, row by row from the lowest y.
    ///
    /// # Errors
    /// [`crate::Error`] for a cell size that is not positive, a corner that is not finite, or another number of cells than
    /// the size says.
    pub fn from_ground(
        cell_size: f64,
        low: [f64; 2],
        size: [usize; 2],
        ground: Vec<Ground>,
    ) -> Result<Self, crate::Error> {
        crate::map::checked_cell_size(cell_size)?;
        if !low.iter().all(|v| v.is_finite()) {
            return Err(crate::Error::Position {
                field: "low",
                value: [low[0], low[1], 0.0],
            });
        }
        if ground.is_empty() || size[0].checked_mul(size[1]) != Some(ground.len()) {
            return Err(crate::Error::Cells {
                given: ground.len(),
                size,
            });
        }
        Ok(Self::of_ground(
            cell_size,
            low,
            size,
            ground,
            CostMapParams::default(),
        ))
    }
}
