//! The caller's mistakes, and the one outcome that has no order.

use std::fmt;

use crate::two_level::Place;

/// Why there is no order.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// There are no nodes.
    Empty,
    /// A matrix row has another length than the number of rows.
    NotSquare {
        /// Index of the row.
        row: usize,
        /// Its length.
        len: usize,
        /// The number of rows, which it should equal.
        nodes: usize,
    },
    /// A cost is NaN or negative infinity.
    BadCost {
        /// Tail of the arc.
        from: usize,
        /// Head of the arc.
        to: usize,
        /// The cost.
        cost: f64,
    },
    /// A time between two places of a decision is negative or NaN.
    BadTime {
        /// Where from.
        from: Place,
        /// Where to.
        to: Place,
        /// The time, s.
        seconds: f64,
    },
    /// A node index is not below the number of nodes.
    OutOfRange {
        /// What the index stands for: `start`, `end`, `current`, ...
        what: &'static str,
        /// The index.
        index: usize,
        /// The number it must stay below.
        len: usize,
    },
    /// Finite costs whose sum overflows.
    Overflow,
    /// Proved: every order uses a forbidden arc.
    Infeasible,
    /// Not proved, but no order without a forbidden arc was found within the effort.
    NotFound,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "no nodes to order; at least one is needed"),
            Self::NotSquare { row, len, nodes } => {
                write!(f, "row {row} has {len} costs, needs {nodes} (one per node)")
            }
            Self::BadCost { from, to, cost } => write!(
                f,
                "cost from {from} to {to} is {cost}; costs are finite, or +infinity for a forbidden arc"
            ),
            Self::BadTime { from, to, seconds } => write!(
                f,
                "{seconds} s from {from:?} to {to:?}; times are zero or more, or +infinity where there is no way"
            ),
            Self::OutOfRange { what, index, len } => {
                write!(f, "{what} = {index} must be below {len}")
            }
            Self::Overflow => write!(f, "the costs are so large that their sum is not finite"),
            Self::Infeasible => write!(f, "every order uses a forbidden arc"),
            Self::NotFound => {
                write!(
                    f,
                    "no order without a forbidden arc was found; raise the number of kicks"
                )
            }
        }
    }
}

impl std::error::Error for Error {}
