//! What is wrong with a file, or with what should become one.

/// A file that cannot be read, or a map that its format cannot hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The bytes end in the middle of something.
    #[error("{format}: ends at byte {offset}, in the middle of {part}")]
    Truncated {
        /// Name of the format.
        format: &'static str,
        /// What was being read.
        part: &'static str,
        /// Where the bytes end.
        offset: usize,
    },
    /// Something that the format does not allow.
    #[error("{format}: {part} is {found:?}, must be {wanted}")]
    Malformed {
        /// Name of the format.
        format: &'static str,
        /// What was being read.
        part: &'static str,
        /// What stands there, cut to a few characters.
        found: String,
        /// What would be right.
        wanted: &'static str,
    },
    /// A number of things that the file announces and does not hold, or the other way round.
    #[error("{format}: announces {announced} {part}, holds {found}")]
    Count {
        /// Name of the format.
        format: &'static str,
        /// What is counted.
        part: &'static str,
        /// Number in the header.
        announced: u64,
        /// Number found.
        found: u64,
    },
    /// More than the caller allows, or than the format can address.
    #[error("{part}: {asked} asked for, at most {most}")]
    TooLarge {
        /// What there is too much of.
        part: &'static str,
        /// How much was asked for.
        asked: f64,
        /// The limit.
        most: f64,
    },
    /// A checksum that does not fit the bytes.
    #[error("{format}: checksum {found:016x}, the bytes give {wanted:016x}; the file is damaged")]
    Checksum {
        /// Name of the format.
        format: &'static str,
        /// Checksum in the file.
        found: u64,
        /// Checksum of the bytes read.
        wanted: u64,
    },
    /// OctoMap's cells have corners at whole multiples of the cell size; the map's are off.
    #[error(
        "corner {low:?} m is no whole number of cells of {cell_size} m from the world's origin"
    )]
    Unaligned {
        /// Corner of the map, m.
        low: [f64; 3],
        /// Edge of a cell, m.
        cell_size: f64,
    },
    /// The map itself refuses.
    #[error(transparent)]
    Map(#[from] crate::Error),
}

impl Error {
    /// [`Error::Malformed`] with the text found cut short.
    pub(super) fn malformed(
        format: &'static str,
        part: &'static str,
        found: impl std::fmt::Display,
        wanted: &'static str,
    ) -> Self {
        Self::Malformed {
            format,
            part,
            found: found.to_string().chars().take(40).collect(),
            wanted,
        }
    }
}
