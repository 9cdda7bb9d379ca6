//! A cursor over bytes that never reads beyond their end.

use super::Error;

/// Bytes yet to be read.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a> {
    format: &'static str,
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(format: &'static str, all: &'a [u8]) -> Self {
        Self { format, all, at: 0 }
    }

    /// Bytes left.
    pub(super) fn left(&self) -> usize {
        self.all.len() - self.at
    }

    fn truncated(&self, part: &'static str) -> Error {
        Error::Truncated {
            format: self.format,
            part,
            offset: self.all.len(),
        }
    }

    /// The next `n` bytes.
    pub(super) fn take(&mut self, n: usize, part: &'static str) -> Result<&'a [u8], Error> {
        if n > self.left() {
            return Err(self.truncated(part));
        }
        let taken = &self.all[self.at..self.at + n];
        self.at += n;
        Ok(taken)
    }

    /// The next bytes as an array.
    pub(super) fn array<const N: usize>(&mut self, part: &'static str) -> Result<[u8; N], Error> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N, part)?);
        Ok(out)
    }

    /// The next line without its end. Bytes that are no UTF-8 are replaced.
    pub(super) fn line(&mut self, part: &'static str) -> Result<std::borrow::Cow<'a, str>, Error> {
        let rest = &self.all[self.at..];
        // A header line longer than this belongs to some other format.
        let within = &rest[..rest.len().min(4096)];
        let Some(end) = within.iter().position(|&b| b == b'\n') else {
            return Err(self.truncated(part));
        };
        self.at += end + 1;
        let line = &rest[..end];
        Ok(String::from_utf8_lossy(
            line.strip_suffix(b"\r").unwrap_or(line),
        ))
    }

    /// As [`line`](Self::line), but the end of the bytes ends a line as well.
    pub(super) fn last_line(
        &mut self,
        part: &'static str,
    ) -> Result<std::borrow::Cow<'a, str>, Error> {
        let rest = &self.all[self.at..];
        if rest.is_empty() || rest.iter().take(4096).any(|&b| b == b'\n') || rest.len() > 4096 {
            return self.line(part);
        }
        self.at = self.all.len();
        Ok(String::from_utf8_lossy(rest))
    }
}
