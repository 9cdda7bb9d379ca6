//! Reader of TSPLIB files with a full matrix (Reinelt, "TSPLIB - A traveling salesman problem library", ORSA Journal on
//! Computing 3(4), 1991).
//!
//! ```
//! let text = "NAME: tiny\nTYPE: ATSP\nDIMENSION: 2\nEDGE_WEIGHT_TYPE: EXPLICIT\n\
//!             EDGE_WEIGHT_FORMAT: FULL_MATRIX\nEDGE_WEIGHT_SECTION\n9999 3\n4 9999\nEOF\n";
//! let instance = atsp::tsplib::parse(text)?;
//! assert_eq!(instance.name, "tiny");
//! assert_eq!(atsp::CostModel::cost(&instance.costs, 0, 1), 3.0);
//! # Ok::<(), atsp::tsplib::ParseError>(())
//! ```

use std::fmt;

use crate::cost::CostMatrix;

/// An instance: closed tours over all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// `NAME`, empty if the file gives none.
    pub name: String,
    /// Row = tail; the file's diagonal is ignored.
    pub costs: CostMatrix,
}

/// Why a text is no instance that can be read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParseError {
    /// A line of the head that must be there is not.
    Missing {
        /// The key.
        key: &'static str,
    },
    /// A line of the head has a value that cannot be read here.
    Unsupported {
        /// The key.
        key: &'static str,
        /// Its value.
        value: String,
        /// What can be read.
        wanted: &'static str,
    },
    /// A weight is no finite number.
    BadWeight {
        /// Number of the line, from 1.
        line: usize,
        /// The text.
        text: String,
    },
    /// The matrix has more or fewer weights than dimension times dimension.
    WrongCount {
        /// Weights found; counting stops one past those wanted.
        found: usize,
        /// Weights wanted.
        wanted: usize,
    },
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { key } => write!(f, "no {key} line; TSPLIB instances need one"),
            Self::Unsupported { key, value, wanted } => {
                write!(f, "{key} is {value:?}; can be read: {wanted}")
            }
            Self::BadWeight { line, text } => {
                write!(f, "line {line}: weight {text:?} is no finite number")
            }
            Self::WrongCount { found, wanted } => write!(
                f,
                "found {found} weights, needs {wanted} (DIMENSION times DIMENSION)"
            ),
        }
    }
}

impl std::error::Error for ParseError {}

/// Largest dimension read; the matrix then takes 800 MB.
const MAX_DIMENSION: usize = 10_000;

/// Reads an instance from the text of a file: `TYPE` ATSP or TSP, `EDGE_WEIGHT_FORMAT` FULL_MATRIX.
///
/// # Errors
/// [`ParseError`].
pub fn parse(text: &str) -> Result<Instance, ParseError> {
    let mut name = String::new();
    let (mut kind, mut dimension, mut weights, mut format) = (None, None, None, None);
    let mut lines = text.lines().enumerate();
    let mut has_section = false;
    for (_, line) in lines.by_ref() {
        let (key, value) = line.split_once(':').unwrap_or((line, ""));
        let value = value.trim();
        match key.trim() {
            "NAME" => name = value.to_owned(),
            "TYPE" => kind = Some(value),
            "DIMENSION" => dimension = Some(value),
            "EDGE_WEIGHT_TYPE" => weights = Some(value),
            "EDGE_WEIGHT_FORMAT" => format = Some(value),
            "EDGE_WEIGHT_SECTION" => {
                has_section = true;
                break;
            }
            _ => {}
        }
    }
    one_of("TYPE", kind, &["ATSP", "TSP"], "ATSP, TSP")?;
    one_of("EDGE_WEIGHT_TYPE", weights, &["EXPLICIT"], "EXPLICIT")?;
    one_of(
        "EDGE_WEIGHT_FORMAT",
        format,
        &["FULL_MATRIX"],
        "FULL_MATRIX",
    )?;
    let dimension = dimension.ok_or(ParseError::Missing { key: "DIMENSION" })?;
    let n = match dimension.parse::<usize>() {
        Ok(n) if (1..=MAX_DIMENSION).contains(&n) => n,
        _ => {
            return Err(ParseError::Unsupported {
                key: "DIMENSION",
                value: dimension.to_owned(),
                wanted: "a number from 1 to 10000",
            });
        }
    };
    if !has_section {
        return Err(ParseError::Missing {
            key: "EDGE_WEIGHT_SECTION",
        });
    }
    let mut values = Vec::new();
    'file: for (number, line) in lines {
        for word in line.split_whitespace() {
            // The matrix ends at the end of the file or at the next keyword; `inf` and `nan` are no keywords.
            if word == "EOF" || word.ends_with("_SECTION") {
                break 'file;
            }
            match word.parse::<f64>() {
                Ok(value) if value.is_finite() => values.push(value),
                _ => {
                    return Err(ParseError::BadWeight {
                        line: number + 1,
                        text: word.to_owned(),
                    });
                }
            }
            if values.len() > n * n {
                break 'file;
            }
        }
    }
    if values.len() != n * n {
        return Err(ParseError::WrongCount {
            found: values.len(),
            wanted: n * n,
        });
    }
    Ok(Instance {
        name,
        costs: CostMatrix::from_finite(n, values),
    })
}

fn one_of(
    key: &'static str,
    value: Option<&str>,
    known: &[&str],
    wanted: &'static str,
) -> Result<(), ParseError> {
    match value {
        None => Err(ParseError::Missing { key }),
        Some(value) if known.contains(&value) => Ok(()),
        Some(value) => Err(ParseError::Unsupported {
            key,
            value: value.to_owned(),
            wanted,
        }),
    }
}
