//! PLY clouds: text and binary of both byte orders in, little-endian binary out.

use super::Error;
use super::bytes::Bytes;
use super::cloud::{Cloud, Number, Records, number};

const PLY: &str = "PLY";
/// Most properties and elements of a file.
const MOST_PARTS: usize = 1000;

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

enum Property {
    Single(Number),
    /// Type of the length, type of the entries.
    List(Number, Number),
}

struct Element {
    is_vertex: bool,
    count: u64,
    properties: Vec<(String, Property)>,
}

/// Reads the vertices of a PLY file; other elements and properties are passed over.
///
/// # Errors
/// [`Error`] for bytes that are no such file, or one without `vertex` with `x`, `y` and `z`.
pub fn read_ply(bytes: &[u8]) -> Result<Cloud, Error> {
    let mut bytes = Bytes::new(PLY, bytes);
    let (encoding, elements) = header(&mut bytes)?;
    for element in &elements {
        if !element.is_vertex {
            skip(&mut bytes, element, encoding)?;
            continue;
        }
        let points = match encoding {
            Encoding::Text => text_points(&mut bytes, element)?,
            _ => records(element, encoding)?.read(&mut bytes, element.count)?,
        };
        return Ok(Cloud::new(points));
    }
    Err(Error::malformed(
        PLY,
        "element vertex",
        "missing",
        "given in the header",
    ))
}

/// The points as a PLY file of 32-bit floats, little-endian.
pub fn write_ply(cloud: &Cloud) -> Vec<u8> {
    let n = cloud.points.len();
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {n}\nproperty float x\nproperty float y\nproperty float z\n\
         end_header\n"
    )
    .into_bytes();
    for v in cloud.points.iter().flatten() {
        out.extend_from_slice(&v.to_le_bytes());
    }
    out
}

fn number_type(word: &str) -> Result<Number, Error> {
    Ok(match word {
        "char" | "int8" => Number::I8,
        "uchar" | "uint8" => Number::U8,
        "short" | "int16" => Number::I16,
        "ushort" | "uint16" => Number::U16,
        "int" | "int32" => Number::I32,
        "uint" | "uint32" => Number::U32,
        "float" | "float32" => Number::F32,
        "double" | "float64" => Number::F64,
        _ => {
            return Err(Error::malformed(
                PLY,
                "property type",
                word,
                "char .. double or int8 .. float64",
            ));
        }
    })
}

fn header(bytes: &mut Bytes<'_>) -> Result<(Encoding, Vec<Element>), Error> {
    let first = bytes.line("the first line")?;
    if first.trim_end() != "ply" {
        return Err(Error::malformed(PLY, "first line", first, "ply"));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut parts = 0;
    loop {
        let line = bytes.line("the header")?;
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["end_header"] => break,
            ["format", kind, "1.0"] => {
                encoding = Some(match kind {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => {
                        return Err(Error::malformed(
                            PLY,
                            "format",
                            kind,
                            "ascii or binary of either endian",
                        ));
                    }
                });
            }
            ["element", name, count] => elements.push(Element {
                is_vertex: name == "vertex",
                count: count
                    .parse()
                    .map_err(|_| Error::malformed(PLY, "element count", count, "a whole number"))?,
                properties: Vec::new(),
            }),
            ["property", ref rest @ ..] => {
                let (name, property) = match rest {
                    ["list", length, entry, name] => (
                        name,
                        Property::List(number_type(length)?, number_type(entry)?),
                    ),
                    [single, name] => (name, Property::Single(number_type(single)?)),
                    _ => {
                        return Err(Error::malformed(
                            PLY,
                            "property",
                            &line,
                            "property TYPE NAME",
                        ));
                    }
                };
                let Some(element) = elements.last_mut() else {
                    return Err(Error::malformed(PLY, "property", &line, "below an element"));
                };
                element.properties.push(((*name).to_owned(), property));
            }
            ["comment" | "obj_info", ..] | [] => {}
            _ => {
                return Err(Error::malformed(
                    PLY,
                    "header line",
                    &line,
                    "format, element, property or comment",
                ));
            }
        }
        parts += 1;
        if parts > MOST_PARTS {
            return Err(Error::TooLarge {
                part: "header lines",
                asked: parts as f64,
                most: MOST_PARTS as f64,
            });
        }
    }
    let encoding = encoding
        .ok_or_else(|| Error::malformed(PLY, "format", "missing", "given in the header"))?;
    Ok((encoding, elements))
}

fn missing_axis(axis: &'static str) -> Error {
    Error::malformed(PLY, "property of vertex", "missing", axis)
}

const AXES: [&str; 3] = ["x", "y", "z"];

fn records(element: &Element, encoding: Encoding) -> Result<Records, Error> {
    let mut width = 0;
    let mut xyz = [None; 3];
    for (name, property) in &element.properties {
        let Property::Single(number) = property else {
            return Err(Error::malformed(
                PLY,
                "property of vertex",
                "list",
                "a single number",
            ));
        };
        if let Some(a) = AXES.iter().position(|axis| axis == name) {
            xyz[a] = Some((width, *number));
        }
        width += number.bytes();
    }
    let place = |a: usize| xyz[a].ok_or_else(|| missing_axis(AXES[a]));
    Ok(Records {
        format: PLY,
        width,
        xyz: [place(0)?, place(1)?, place(2)?],
        big_endian: encoding == Encoding::Big,
    })
}

fn text_points(bytes: &mut Bytes<'_>, element: &Element) -> Result<Vec<[f32; 3]>, Error> {
    let mut column = [0; 3];
    for (a, axis) in AXES.iter().enumerate() {
        let found = element.properties.iter().position(|(name, _)| name == axis);
        column[a] = found.ok_or_else(|| missing_axis(axis))?;
    }
    if element
        .properties
        .iter()
        .any(|(_, p)| matches!(p, Property::List(..)))
    {
        return Err(Error::malformed(
            PLY,
            "property of vertex",
            "list",
            "a single number",
        ));
    }
    let mut points = Vec::new();
    for _ in 0..element.count {
        let line = bytes.last_line("a point")?;
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.len() < element.properties.len() {
            return Err(Error::malformed(
                PLY,
                "a point",
                &line,
                "as many numbers as properties",
            ));
        }
        let mut point = [0.0; 3];
        for a in 0..3 {
            point[a] = number(PLY, "a coordinate", words[column[a]])? as f32;
        }
        points.push(point);
    }
    Ok(points)
}

/// Passes over an element before the vertices.
fn skip(bytes: &mut Bytes<'_>, element: &Element, encoding: Encoding) -> Result<(), Error> {
    if element.properties.is_empty() && encoding != Encoding::Text {
        return Ok(());
    }
    for _ in 0..element.count {
        if encoding == Encoding::Text {
            bytes.last_line("an element")?;
            continue;
        }
        for (_, property) in &element.properties {
            match property {
                Property::Single(number) => {
                    bytes.take(number.bytes(), "an element")?;
                }
                Property::List(length, entry) => {
                    let n = length.value(
                        bytes.take(length.bytes(), "a list")?,
                        encoding == Encoding::Big,
                    );
                    // Also negative lengths and NaN.
                    if !(n >= 0.0 && n * entry.bytes() as f64 <= bytes.left() as f64) {
                        return Err(Error::malformed(
                            PLY,
                            "length of a list",
                            n,
                            "no more than there are bytes",
                        ));
                    }
                    bytes.take(n as usize * entry.bytes(), "a list")?;
                }
            }
        }
    }
    Ok(())
}
