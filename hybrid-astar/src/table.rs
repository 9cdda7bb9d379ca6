//! A small hash table from lattice state to node, never iterated.

/// Open addressing with linear probing; keys are below `u64::MAX`.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    slots: Vec<(u64, u32)>,
    count: usize,
}

const EMPTY: u64 = u64::MAX;

impl Table {
    pub(crate) fn new() -> Self {
        Self {
            slots: vec![(EMPTY, 0); 1 << 12],
            count: 0,
        }
    }

    #[inline]
    fn slot(&self, key: u64) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize & mask;
        while self.slots[at].0 != key && self.slots[at].0 != EMPTY {
            at = (at + 1) & mask;
        }
        at
    }

    pub(crate) fn get(&self, key: u64) -> Option<u32> {
        let (k, v) = self.slots[self.slot(key)];
        (k == key).then_some(v)
    }

    pub(crate) fn set(&mut self, key: u64, value: u32) {
        if 2 * self.count >= self.slots.len() {
            let bigger = vec![(EMPTY, 0); 4 * self.slots.len()];
            for (k, v) in std::mem::replace(&mut self.slots, bigger) {
                if k != EMPTY {
                    let at = self.slot(k);
                    self.slots[at] = (k, v);
                }
            }
        }
        let at = self.slot(key);
        if self.slots[at].0 == EMPTY {
            self.count += 1;
        }
        self.slots[at] = (key, value);
    }
}

#[cfg(test)]
mod tests {
    use super::Table;

    #[test]
    fn keeps_the_last_value_through_growth() {
        let mut t = Table::new();
        for k in 0..20_000u64 {
            t.set(k * 37, k as u32);
            t.set(k * 37, k as u32 + 1);
        }
        assert!((0..20_000u64).all(|k| t.get(k * 37) == Some(k as u32 + 1)));
        assert_eq!(t.get(36), None);
    }
}
