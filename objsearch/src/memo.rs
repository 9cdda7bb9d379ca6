//! Sets of views that were reached before, and how fast.

use std::collections::HashMap;

/// Most sets remembered; about 50 MB.
const MOST: usize = 1 << 20;

/// Least expected time with which each pair of a set of views and a last view was reached.
///
/// What is still to come depends on nothing else, so a slower way to the same pair need not be followed.
#[derive(Clone, Debug)]
pub(crate) struct Memo {
    reached: HashMap<(Vec<u64>, u32), f64>,
    words: usize,
}

impl Memo {
    pub(crate) fn new(views: usize) -> Self {
        Self {
            reached: HashMap::new(),
            words: views.div_ceil(64),
        }
    }

    /// True if the views of `sequence` were reached before with the same last view and no later; remembers it else.
    pub(crate) fn reached_before(&mut self, sequence: &[usize], expected: f64) -> bool {
        let Some(&last) = sequence.last() else {
            return false;
        };
        let mut set = vec![0; self.words];
        for &v in sequence {
            set[v / 64] |= 1u64 << (v % 64);
        }
        let full = self.reached.len() >= MOST;
        let key = (set, last as u32);
        match self.reached.get_mut(&key) {
            Some(before) if *before <= expected => true,
            Some(before) => {
                *before = expected;
                false
            }
            None => {
                if !full {
                    self.reached.insert(key, expected);
                }
                false
            }
        }
    }
}
