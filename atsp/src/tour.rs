//! A closed tour as an array with positions; changes are logged so that they can be taken back.

/// One change of the array.
#[derive(Clone, Copy, Debug)]
struct Step {
    at: u32,
    /// Length of the first segment.
    first: u32,
    /// Length of the second segment; zero for a reversal of the first.
    second: u32,
}

/// Successors, predecessors and positions in constant time; segments change places in time of the two shortest.
#[derive(Debug, Default)]
pub(crate) struct Tour {
    order: Vec<u32>,
    place: Vec<u32>,
    log: Vec<Step>,
    spare: Vec<u32>,
}

impl Tour {
    /// Takes over a permutation of `0..order.len()`.
    pub(crate) fn set(&mut self, order: &[u32]) {
        let n = order.len();
        self.order.clear();
        self.order.extend_from_slice(order);
        self.place.resize(n, 0);
        for (i, &node) in order.iter().enumerate() {
            self.place[node as usize] = i as u32;
        }
        self.log.clear();
        self.spare.clear();
        self.spare.reserve(n);
    }

    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.order.len()
    }

    /// The node at a position below `2 n`.
    #[inline]
    pub(crate) fn at(&self, position: usize) -> u32 {
        let n = self.order.len();
        self.order[if position >= n {
            position - n
        } else {
            position
        }]
    }

    #[inline]
    pub(crate) fn place(&self, node: u32) -> usize {
        self.place[node as usize] as usize
    }

    #[inline]
    pub(crate) fn next(&self, node: u32) -> u32 {
        let i = self.place(node) + 1;
        self.order[if i == self.order.len() { 0 } else { i }]
    }

    #[inline]
    pub(crate) fn previous(&self, node: u32) -> u32 {
        let i = self.place(node);
        self.order[if i == 0 { self.order.len() } else { i } - 1]
    }

    /// Steps from position `from` forward to the node.
    #[inline]
    pub(crate) fn offset(&self, from: usize, node: u32) -> usize {
        let i = self.place(node);
        if i >= from {
            i - from
        } else {
            i + self.order.len() - from
        }
    }

    /// Forgets what could be taken back.
    pub(crate) fn commit(&mut self) {
        self.log.clear();
    }

    /// Takes back every change since the last [`commit`](Self::commit).
    pub(crate) fn undo(&mut self) {
        while let Some(step) = self.log.pop() {
            if step.second == 0 {
                self.flip(step.at as usize, step.first as usize);
            } else {
                self.swap(step.at as usize, step.second as usize, step.first as usize);
            }
        }
    }

    /// Exchanges the neighbouring segments of lengths `first` and `second` that begin at position `at`, as seen around
    /// the closed tour; the positions of the rest may move too.
    pub(crate) fn exchange(&mut self, at: usize, first: usize, second: usize) {
        let n = self.order.len();
        if first == 0 || second == 0 {
            return;
        }
        let rest = n - first - second;
        // A B rest, B rest A and rest A B are one closed tour: the longest of the three stays.
        let (at, first, second) = if rest >= first && rest >= second {
            (at, first, second)
        } else if first >= second {
            (at + first, second, rest)
        } else {
            (at + first + second, rest, first)
        };
        let at = if at >= n { at - n } else { at };
        if first == 0 || second == 0 {
            return;
        }
        self.swap(at, first, second);
        self.log.push(Step {
            at: at as u32,
            first: first as u32,
            second: second as u32,
        });
    }

    /// Reverses the segment of length `len` that begins at position `at`.
    pub(crate) fn reverse(&mut self, at: usize, len: usize) {
        self.flip(at, len);
        self.log.push(Step {
            at: at as u32,
            first: len as u32,
            second: 0,
        });
    }

    fn swap(&mut self, at: usize, first: usize, second: usize) {
        let n = self.order.len();
        let end = at + first + second;
        if end <= n {
            self.order[at..end].rotate_left(first);
            for i in at..end {
                self.place[self.order[i] as usize] = i as u32;
            }
        } else {
            self.spare.clear();
            for k in (at + first..end).chain(at..at + first) {
                let node = self.at(k);
                self.spare.push(node);
            }
            for (k, &node) in self.spare.iter().enumerate() {
                let i = if at + k >= n { at + k - n } else { at + k };
                self.order[i] = node;
                self.place[node as usize] = i as u32;
            }
        }
    }

    fn flip(&mut self, at: usize, len: usize) {
        let n = self.order.len();
        let (mut i, mut j) = (at, at + len - 1);
        while i < j {
            let (p, q) = (
                if i >= n { i - n } else { i },
                if j >= n { j - n } else { j },
            );
            self.order.swap(p, q);
            self.place[self.order[p] as usize] = p as u32;
            self.place[self.order[q] as usize] = q as u32;
            i += 1;
            j -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed tour read from node 0.
    fn read(tour: &Tour) -> Vec<u32> {
        let zero = tour.place(0);
        (0..tour.len()).map(|k| tour.at(zero + k)).collect()
    }

    #[test]
    fn exchanges_around_the_end_and_their_undo() {
        for at in 0..7 {
            for first in 1..6 {
                for second in 1..=(6 - first) {
                    let mut tour = Tour::default();
                    tour.set(&[0, 1, 2, 3, 4, 5, 6]);
                    let wanted: Vec<u32> = (at + first..at + first + second)
                        .chain(at..at + first)
                        .chain(at + first + second..at + 7)
                        .map(|k| (k % 7) as u32)
                        .collect();
                    tour.exchange(at, first, second);
                    let mut reference = Tour::default();
                    reference.set(&wanted);
                    assert_eq!(read(&tour), read(&reference), "{at} {first} {second}");
                    for k in 0..7 {
                        assert_eq!(tour.place(tour.at(k)), k);
                    }
                    tour.reverse(at, first);
                    tour.undo();
                    assert_eq!(read(&tour), [0, 1, 2, 3, 4, 5, 6]);
                }
            }
        }
    }
}
