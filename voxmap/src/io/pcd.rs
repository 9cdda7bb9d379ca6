//! PCD clouds: text, binary and compressed in, binary out.

use super::Error;
use super::bytes::Bytes;
use super::cloud::{Cloud, Number, Records, number};

const PCD: &str = "PCD";
/// Most fields of a point.
const MOST_FIELDS: usize = 256;
/// A byte of LZF stands for at most this many.
const MOST_EXPANSION: usize = 264;

struct Field {
    name: String,
    kind: Number,
    count: usize,
}

struct Header {
    fields: Vec<Field>,
    points: u64,
    position: [f64; 3],
    rotation: [f64; 4],
    data: String,
}

/// Reads the fields x, y and z of a PCD file, and its viewpoint.
///
/// # Errors
/// [`Error`] for bytes that are no such file, or one without those fields.
pub fn read_pcd(bytes: &[u8]) -> Result<Cloud, Error> {
    let mut bytes = Bytes::new(PCD, bytes);
    let header = header(&mut bytes)?;
    let mut xyz = [None; 3];
    let (mut width, mut columns) = (0, 0);
    for field in &header.fields {
        if let Some(a) = ["x", "y", "z"].iter().position(|axis| *axis == field.name) {
            xyz[a] = Some((width, columns, field.kind));
        }
        width += field.kind.bytes() * field.count;
        columns += field.count;
    }
    let place = |a: usize| {
        xyz[a].ok_or_else(|| Error::malformed(PCD, "field x, y or z", "missing", "given in FIELDS"))
    };
    let places = [place(0)?, place(1)?, place(2)?];
    let records = Records {
        format: PCD,
        width,
        xyz: places.map(|(at, _, kind)| (at, kind)),
        big_endian: false,
    };
    let points = match header.data.as_str() {
        "ascii" => {
            let mut points = Vec::new();
            for _ in 0..header.points {
                let line = bytes.last_line("a point")?;
                let words: Vec<&str> = line.split_whitespace().collect();
                if words.len() < columns {
                    return Err(Error::malformed(
                        PCD,
                        "a point",
                        &line,
                        "as many numbers as fields",
                    ));
                }
                let mut point = [0.0; 3];
                for (slot, (_, column, _)) in point.iter_mut().zip(places) {
                    *slot = number(PCD, "a coordinate", words[column])? as f32;
                }
                points.push(point);
            }
            points
        }
        "binary" => records.read(&mut bytes, header.points)?,
        "binary_compressed" => compressed(&mut bytes, &header, width)?,
        other => {
            return Err(Error::malformed(
                PCD,
                "DATA",
                other,
                "ascii, binary or binary_compressed",
            ));
        }
    };
    Ok(Cloud {
        points,
        position: header.position,
        rotation: header.rotation,
    })
}

/// The cloud as a binary PCD file of 32-bit floats.
pub fn write_pcd(cloud: &Cloud) -> Vec<u8> {
    let n = cloud.points.len();
    let ([x, y, z], [qw, qx, qy, qz]) = (cloud.position, cloud.rotation);
    let mut out = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n\
         WIDTH {n}\nHEIGHT 1\nVIEWPOINT {x} {y} {z} {qw} {qx} {qy} {qz}\nPOINTS {n}\nDATA binary\n"
    )
    .into_bytes();
    for v in cloud.points.iter().flatten() {
        out.extend_from_slice(&v.to_le_bytes());
    }
    out
}

fn header(bytes: &mut Bytes<'_>) -> Result<Header, Error> {
    let (mut names, mut sizes, mut kinds, mut counts) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut width, mut height, mut points) = (None, None, None);
    let mut viewpoint = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let whole = |word: &str| {
        word.parse::<u64>()
            .map_err(|_| Error::malformed(PCD, "a header's number", word, "a whole number"))
    };
    let data = loop {
        let line = bytes.line("the header")?;
        let mut words = line.split_whitespace();
        let key = words.next().unwrap_or("#");
        let words: Vec<&str> = words.collect();
        if words.len() > MOST_FIELDS && !key.starts_with('#') {
            return Err(Error::TooLarge {
                part: "fields of a point",
                asked: words.len() as f64,
                most: MOST_FIELDS as f64,
            });
        }
        let value = words.first().copied().unwrap_or("");
        match key {
            "VERSION" => {}
            "FIELDS" | "COLUMNS" => names = words.iter().map(|w| (*w).to_owned()).collect(),
            "SIZE" => sizes = words.iter().map(|w| whole(w)).collect::<Result<_, _>>()?,
            "TYPE" => kinds = words.iter().map(|w| (*w).to_owned()).collect(),
            "COUNT" => counts = words.iter().map(|w| whole(w)).collect::<Result<_, _>>()?,
            "WIDTH" => width = Some(whole(value)?),
            "HEIGHT" => height = Some(whole(value)?),
            "POINTS" => points = Some(whole(value)?),
            "VIEWPOINT" => {
                if words.len() != 7 {
                    return Err(Error::malformed(PCD, "VIEWPOINT", &line, "seven numbers"));
                }
                for (slot, word) in viewpoint.iter_mut().zip(&words) {
                    *slot = number(PCD, "VIEWPOINT", word)?;
                }
            }
            "DATA" => break value.to_owned(),
            _ if key.starts_with('#') => {}
            _ => {
                return Err(Error::malformed(
                    PCD,
                    "header line",
                    &line,
                    "VERSION .. DATA or a comment",
                ));
            }
        }
    };
    if counts.is_empty() {
        counts = vec![1; names.len()];
    }
    if names.is_empty()
        || sizes.len() != names.len()
        || kinds.len() != names.len()
        || counts.len() != names.len()
    {
        return Err(Error::malformed(
            PCD,
            "SIZE, TYPE or COUNT",
            "another length",
            "as long as FIELDS",
        ));
    }
    let mut fields = Vec::new();
    for (((name, size), kind), count) in names.into_iter().zip(&sizes).zip(&kinds).zip(&counts) {
        let kind = match (kind.as_str(), size) {
            ("I", 1) => Number::I8,
            ("U", 1) => Number::U8,
            ("I", 2) => Number::I16,
            ("U", 2) => Number::U16,
            ("I", 4) => Number::I32,
            ("U", 4) => Number::U32,
            ("F", 4) => Number::F32,
            // Eight bytes of any kind are passed over; as a coordinate they are a double.
            ("F" | "I" | "U", 8) => Number::F64,
            _ => {
                return Err(Error::malformed(
                    PCD,
                    "TYPE and SIZE",
                    format!("{kind} {size}"),
                    "I, U or F of 1, 2, 4 or 8",
                ));
            }
        };
        if !(1..=1 << 16).contains(count) {
            return Err(Error::malformed(PCD, "COUNT", count, "1 to 65536"));
        }
        fields.push(Field {
            name,
            kind,
            count: *count as usize,
        });
    }
    let area = width.unwrap_or(0).saturating_mul(height.unwrap_or(1));
    let points = points.unwrap_or(area);
    if width.is_some() && area != points {
        return Err(Error::Count {
            format: PCD,
            part: "points (WIDTH x HEIGHT)",
            announced: area,
            found: points,
        });
    }
    let [x, y, z, qw, qx, qy, qz] = viewpoint;
    Ok(Header {
        fields,
        points,
        position: [x, y, z],
        rotation: [qw, qx, qy, qz],
        data,
    })
}

/// Compressed data stands field by field, not point by point.
fn compressed(
    bytes: &mut Bytes<'_>,
    header: &Header,
    width: usize,
) -> Result<Vec<[f32; 3]>, Error> {
    let packed = u32::from_le_bytes(bytes.array("the compressed size")?) as usize;
    let plain = u32::from_le_bytes(bytes.array("the plain size")?) as usize;
    let wanted = header.points.saturating_mul(width as u64);
    if plain as u64 != wanted || plain > packed.saturating_mul(MOST_EXPANSION) {
        return Err(Error::Count {
            format: PCD,
            part: "bytes when unpacked",
            announced: wanted,
            found: plain as u64,
        });
    }
    let data = unpack(bytes.take(packed, "compressed data")?, plain)?;
    let n = header.points as usize;
    let mut points = vec![[0.0; 3]; n];
    let mut at = 0;
    for field in &header.fields {
        if let Some(a) = ["x", "y", "z"].iter().position(|axis| *axis == field.name) {
            let each = field.kind.bytes() * field.count;
            for (i, point) in points.iter_mut().enumerate() {
                let start = at + i * each;
                point[a] = field
                    .kind
                    .value(&data[start..start + field.kind.bytes()], false)
                    as f32;
            }
        }
        at += n * field.kind.bytes() * field.count;
    }
    Ok(points)
}

/// LZF: runs of literals (length - 1 in five bits) and copies from up to 8 KiB back.
fn unpack(packed: &[u8], plain: usize) -> Result<Vec<u8>, Error> {
    let mut bytes = Bytes::new(PCD, packed);
    let mut out = Vec::with_capacity(plain);
    while bytes.left() > 0 {
        let [control] = bytes.array("compressed data")?;
        let high = usize::from(control >> 5);
        if high == 0 {
            out.extend_from_slice(bytes.take(usize::from(control) + 1, "compressed data")?);
        } else {
            let more = if high == 7 {
                usize::from(bytes.array::<1>("compressed data")?[0])
            } else {
                0
            };
            let [low] = bytes.array("compressed data")?;
            let back = (usize::from(control & 31) << 8 | usize::from(low)) + 1;
            let Some(start) = out.len().checked_sub(back) else {
                return Err(Error::malformed(
                    PCD,
                    "a copy",
                    format!("{back} bytes back"),
                    "from within the data",
                ));
            };
            for i in start..start + high + more + 2 {
                out.push(out[i]);
            }
        }
        if out.len() > plain {
            break;
        }
    }
    if out.len() == plain {
        return Ok(out);
    }
    Err(Error::Count {
        format: PCD,
        part: "bytes when unpacked",
        announced: plain as u64,
        found: out.len() as u64,
    })
}
