//! Numbers for a page: differences of neighbours as variable-length integers, as base64 text.

/// Packs integers: zig-zag, seven bits a byte, low bits first.
#[derive(Clone, Debug, Default)]
pub(super) struct Pack {
    bytes: Vec<u8>,
}

impl Pack {
    /// Adds a number.
    pub(super) fn int(&mut self, value: i64) {
        let mut rest = ((value << 1) ^ (value >> 63)) as u64;
        while rest >= 0x80 {
            self.bytes.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        self.bytes.push(rest as u8);
    }

    /// Adds a list: its length, then for each number its difference from the one `stride` places before.
    pub(super) fn list(&mut self, values: &[i64], stride: usize) {
        self.int(values.len() as i64);
        for (i, value) in values.iter().enumerate() {
            let before = i.checked_sub(stride).map_or(0, |k| values[k]);
            self.int(value.wrapping_sub(before));
        }
    }

    /// Bytes so far.
    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }

    /// The text.
    pub(super) fn text(&self) -> String {
        const DIGITS: &[u8; 64] =
            b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let mut out = String::with_capacity(self.bytes.len().div_ceil(3) * 4);
        for chunk in self.bytes.chunks(3) {
            let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
            let word = byte(0) << 16 | byte(1) << 8 | byte(2);
            for digit in 0..4 {
                if digit <= chunk.len() {
                    let index = (word >> (18 - 6 * digit) & 63) as usize;
                    out.push(char::from(DIGITS[index]));
                } else {
                    out.push('=');
                }
            }
        }
        out
    }
}

/// A table of integers, packed column by column.
#[derive(Clone, Debug)]
pub(super) struct Table {
    columns: usize,
    values: Vec<i32>,
}

impl Table {
    pub(super) fn new(columns: usize) -> Self {
        Self {
            columns: columns.max(1),
            values: Vec::new(),
        }
    }

    /// Adds a row; one of another width is left out.
    pub(super) fn row(&mut self, row: impl IntoIterator<Item = i32>) {
        let before = self.values.len();
        self.values.extend(row);
        if self.values.len() - before != self.columns {
            self.values.truncate(before);
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    /// Drops every second row but the last.
    pub(super) fn thin(&mut self) {
        let (rows, columns) = (self.rows(), self.columns);
        let mut kept = 0;
        for row in 0..rows {
            if row % 2 == 0 || row + 1 == rows {
                self.values
                    .copy_within(row * columns..(row + 1) * columns, kept * columns);
                kept += 1;
            }
        }
        self.values.truncate(kept * columns);
    }

    /// Number of rows, number of columns, then each column as differences.
    pub(super) fn text(&self) -> String {
        let mut pack = Pack::default();
        let rows = self.rows();
        pack.int(rows as i64);
        pack.int(self.columns as i64);
        for column in 0..self.columns {
            let mut before = 0;
            for row in 0..rows {
                let value = i64::from(self.values[row * self.columns + column]);
                pack.int(value - before);
                before = value;
            }
        }
        pack.text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let pack = Pack {
                bytes: bytes.as_bytes().to_vec(),
            };
            assert_eq!(pack.text(), text);
        }
    }

    #[test]
    fn numbers_take_the_bytes_they_need() {
        let mut pack = Pack::default();
        for value in [0, -1, 1, 63, -64, 64, i64::MIN] {
            pack.int(value);
        }
        assert_eq!(pack.bytes[..7], [0, 1, 2, 126, 127, 128, 1]);
        assert_eq!(pack.len(), 7 + 10);
    }

    #[test]
    fn thinning_keeps_both_ends() {
        let mut table = Table::new(2);
        for k in 0..6 {
            table.row([k, 10 * k]);
        }
        table.row([7]);
        assert_eq!(table.rows(), 6);
        table.thin();
        assert_eq!(table.values, [0, 0, 2, 20, 4, 40, 5, 50]);
    }
}
