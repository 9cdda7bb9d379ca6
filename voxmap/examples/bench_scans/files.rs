//! Scans from files: `*.scn` (posed clouds), `*.bin` (dumps of this program and of `tools/map_peers.py`), folders with
//! `trajectory.log` and depth images, and OctoMap's `.bt` maps.

use std::fs;
use std::io::{BufReader, Error, ErrorKind};
use std::path::{Path, PathBuf};

/// One sensor reading in the world frame.
pub struct Scan {
    pub origin: [f64; 3],
    pub points: Vec<[f32; 3]>,
}

fn bad(path: &Path, what: impl std::fmt::Display) -> Error {
    Error::new(
        ErrorKind::InvalidData,
        format!("{}: {what}", path.display()),
    )
}

/// Little-endian numbers, in order.
struct Numbers<'a> {
    bytes: &'a [u8],
    path: &'a Path,
}

impl Numbers<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let (head, rest) = self
            .bytes
            .split_first_chunk::<N>()
            .ok_or_else(|| bad(self.path, "ends too early"))?;
        self.bytes = rest;
        Ok(*head)
    }
    fn count(&mut self) -> Result<usize, Error> {
        let n = i32::from_le_bytes(self.take()?);
        usize::try_from(n).map_err(|_| bad(self.path, format!("{n} is no count")))
    }
    fn f32(&mut self) -> Result<f32, Error> {
        Ok(f32::from_le_bytes(self.take()?))
    }
    fn f64(&mut self) -> Result<f64, Error> {
        Ok(f64::from_le_bytes(self.take()?))
    }
    fn points(&mut self) -> Result<Vec<[f32; 3]>, Error> {
        let n = self.count()?;
        if n > self.bytes.len() / 12 {
            return Err(bad(self.path, format!("announces {n} points, holds fewer")));
        }
        (0..n)
            .map(|_| Ok([self.f32()?, self.f32()?, self.f32()?]))
            .collect()
    }
}

/// int32 scans; per scan: 3 x f32 origin, int32 points, points as 3 x f32 in the world frame.
pub fn read_bin(path: &Path) -> Result<Vec<Scan>, Error> {
    let bytes = fs::read(path)?;
    let mut numbers = Numbers {
        bytes: &bytes,
        path,
    };
    let n = numbers.count()?;
    (0..n)
        .map(|_| {
            let origin = [numbers.f32()?, numbers.f32()?, numbers.f32()?].map(f64::from);
            Ok(Scan {
                origin,
                points: numbers.points()?,
            })
        })
        .collect()
}

/// The inverse of [`read_bin`].
pub fn write_bin(path: &Path, scans: &[Scan]) -> Result<(), Error> {
    let mut out = (scans.len() as i32).to_le_bytes().to_vec();
    for scan in scans {
        for v in scan.origin {
            out.extend((v as f32).to_le_bytes());
        }
        out.extend((scan.points.len() as i32).to_le_bytes());
        for v in scan.points.iter().flatten() {
            out.extend(v.to_le_bytes());
        }
    }
    fs::write(path, out)
}

/// "SCN1", u32 scans; per scan: pose (x y z qx qy qz qw, f64, world from sensor), u32 points, points in the sensor frame.
pub fn read_scn(path: &Path) -> Result<Vec<Scan>, Error> {
    let bytes = fs::read(path)?;
    let mut numbers = Numbers {
        bytes: &bytes,
        path,
    };
    if &numbers.take::<4>()? != b"SCN1" {
        return Err(bad(path, "does not begin with SCN1"));
    }
    let n = numbers.count()?;
    (0..n)
        .map(|_| {
            let mut pose = [0.0; 7];
            for v in &mut pose {
                *v = numbers.f64()?;
            }
            let [x, y, z, qx, qy, qz, qw] = pose;
            let rotation = [
                [
                    1.0 - 2.0 * (qy * qy + qz * qz),
                    2.0 * (qx * qy - qz * qw),
                    2.0 * (qx * qz + qy * qw),
                ],
                [
                    2.0 * (qx * qy + qz * qw),
                    1.0 - 2.0 * (qx * qx + qz * qz),
                    2.0 * (qy * qz - qx * qw),
                ],
                [
                    2.0 * (qx * qz - qy * qw),
                    2.0 * (qy * qz + qx * qw),
                    1.0 - 2.0 * (qx * qx + qy * qy),
                ],
            ];
            let points = numbers
                .points()?
                .into_iter()
                .map(|p| moved(&rotation, [x, y, z], p.map(f64::from)));
            Ok(Scan {
                origin: [x, y, z],
                points: points.collect(),
            })
        })
        .collect()
}

fn moved(rotation: &[[f64; 3]; 3], by: [f64; 3], p: [f64; 3]) -> [f32; 3] {
    [0, 1, 2].map(|a| ((0..3).map(|b| rotation[a][b] * p[b]).sum::<f64>() + by[a]) as f32)
}

/// A folder of 16-bit depth images in mm, named by their index into `trajectory.log` (five lines a frame: three integers,
/// then world from camera). Every fourth pixel of every fourth row, f = 525, centre (319.5, 239.5), nearer than 0.2 m left out.
pub fn read_images(folder: &Path) -> Result<Vec<Scan>, Error> {
    let log_path = folder.join("trajectory.log");
    let log = fs::read_to_string(&log_path)?;
    let lines: Vec<&str> = log.lines().collect();
    let mut images: Vec<PathBuf> = fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "png"))
        .collect();
    images.sort();
    let mut scans = Vec::new();
    for path in images {
        let index: usize = path
            .file_stem()
            .and_then(|stem| stem.to_str()?.parse().ok())
            .ok_or_else(|| bad(&path, "is not named by a number"))?;
        let mut pose = [[0.0; 4]; 3];
        for (row, values) in pose.iter_mut().enumerate() {
            let line = lines
                .get(5 * index + 1 + row)
                .ok_or_else(|| bad(&log_path, format!("has no frame {index}")))?;
            for (slot, word) in values.iter_mut().zip(line.split_whitespace()) {
                *slot = word
                    .parse()
                    .map_err(|_| bad(&log_path, format!("{word} is no number")))?;
            }
        }
        let (depth, width) = read_png(&path)?;
        let rotation = pose.map(|row| [row[0], row[1], row[2]]);
        let origin = pose.map(|row| row[3]);
        let mut points = Vec::new();
        for v in (2..depth.len() / width).step_by(4) {
            for u in (2..width).step_by(4) {
                let z = f64::from(depth[v * width + u]) / 1000.0;
                if z > 0.2 {
                    let p = [
                        (u as f64 - 319.5) * z / 525.0,
                        (v as f64 - 239.5) * z / 525.0,
                        z,
                    ];
                    points.push(moved(&rotation, origin, p));
                }
            }
        }
        scans.push(Scan { origin, points });
    }
    Ok(scans)
}

fn read_png(path: &Path) -> Result<(Vec<u16>, usize), Error> {
    let decoder = png::Decoder::new(BufReader::new(fs::File::open(path)?));
    let mut reader = decoder.read_info().map_err(|e| bad(path, e))?;
    let mut bytes = vec![
        0;
        reader
            .output_buffer_size()
            .ok_or_else(|| bad(path, "is too large"))?
    ];
    let info = reader.next_frame(&mut bytes).map_err(|e| bad(path, e))?;
    if (info.color_type, info.bit_depth) != (png::ColorType::Grayscale, png::BitDepth::Sixteen) {
        return Err(bad(path, "is no 16-bit grey image"));
    }
    let (pixels, _) = bytes[..info.buffer_size()].as_chunks::<2>();
    Ok((
        pixels.iter().map(|b| u16::from_be_bytes(*b)).collect(),
        info.width as usize,
    ))
}

/// Everything below a folder that is known, by name, at most three levels deep.
pub fn find(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![(folder.to_path_buf(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        if folder.join("trajectory.log").is_file() {
            found.push(folder);
            continue;
        }
        for path in fs::read_dir(&folder)
            .into_iter()
            .flatten()
            .filter_map(|e| Some(e.ok()?.path()))
        {
            if path.is_dir() && depth < 3 {
                folders.push((path, depth + 1));
            } else if path
                .extension()
                .is_some_and(|e| e == "scn" || e == "bin" || e == "bt")
            {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
