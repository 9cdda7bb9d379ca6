//! Common data representation (OMG CDR, version 1, little endian), as ROS 2 messages are encoded in MCAP files.

/// A message that is being encoded. Primitives are aligned to their size, counted from the end of the four header bytes.
#[derive(Clone, Debug)]
pub(super) struct Cdr {
    bytes: Vec<u8>,
}

const HEADER: usize = 4;

impl Cdr {
    pub(super) fn new() -> Self {
        Self {
            // CDR_LE, no options.
            bytes: vec![0, 1, 0, 0],
        }
    }

    fn align(&mut self, size: usize) {
        while !(self.bytes.len() - HEADER).is_multiple_of(size) {
            self.bytes.push(0);
        }
    }

    pub(super) fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    pub(super) fn bool(&mut self, value: bool) {
        self.bytes.push(u8::from(value));
    }

    pub(super) fn u32(&mut self, value: u32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    pub(super) fn i32(&mut self, value: i32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    pub(super) fn f32(&mut self, value: f32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    pub(super) fn f64(&mut self, value: f64) {
        self.align(8);
        self.bytes.extend(value.to_le_bytes());
    }

    /// Length with the closing zero, the text, the zero. A zero inside the text would end it for C readers and is left out.
    pub(super) fn string(&mut self, text: &str) {
        let kept = text.bytes().filter(|b| *b != 0);
        self.u32(kept.clone().count() as u32 + 1);
        self.bytes.extend(kept);
        self.bytes.push(0);
    }

    /// Length of the sequence that follows.
    pub(super) fn length(&mut self, count: usize) {
        self.u32(count as u32);
    }

    /// A sequence of bytes.
    pub(super) fn blob(&mut self, bytes: &[u8]) {
        self.length(bytes.len());
        self.bytes.extend(bytes);
    }

    pub(super) fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Alignment as in the examples of the DDS-RTPS specification: padding counts from the end of the header.
    #[test]
    fn values_are_aligned_to_their_size() {
        let mut cdr = Cdr::new();
        cdr.u8(7);
        cdr.f64(1.0);
        cdr.bool(true);
        cdr.u32(2);
        cdr.string("ab");
        cdr.i32(-1);
        cdr.blob(&[9, 8]);
        cdr.f32(0.5);
        let wanted: Vec<u8> = [
            vec![0, 1, 0, 0],
            vec![7, 0, 0, 0, 0, 0, 0, 0],
            1.0_f64.to_le_bytes().to_vec(),
            vec![1, 0, 0, 0, 2, 0, 0, 0],
            vec![3, 0, 0, 0, b'a', b'b', 0, 0],
            vec![255, 255, 255, 255],
            vec![2, 0, 0, 0, 9, 8, 0, 0],
            0.5_f32.to_le_bytes().to_vec(),
        ]
        .concat();
        assert_eq!(cdr.finish(), wanted);
    }
}
