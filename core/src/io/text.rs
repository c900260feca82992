//! Lines, words and numbers of text formats.
//!
//! Files are bytes, not UTF-8: comments and names may be in any encoding, only the words that are read
//! as numbers must be ASCII. A line ends with LF, CR LF, or CR alone.

use std::borrow::Cow;

use super::error::excerpt;
use super::{Defect, LARGEST_COORDINATE};

/// The lines of a file with their numbers, from 1, without their ends.
#[derive(Clone, Debug)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
}

impl<'a> Lines<'a> {
    /// The lines of a file. A UTF-8 byte order mark at its start is left out.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), number: 0 }
    }

    /// The lines of the rest of a file, of which `number` have been read.
    pub(super) fn after(rest: &'a [u8], number: u64) -> Self {
        Self { rest, number }
    }

    /// How many lines of the file have been read.
    pub(super) fn number(&self) -> u64 {
        self.number
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let end = end.unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        let ending = if rest.starts_with(b"\r\n") { 2 } else { rest.len().min(1) };
        self.rest = &rest[ending..];
        Some((self.number, line))
    }
}

/// Lines in which a `\` at the end of one carries it on into the next; the number is that of the first.
/// A comment is not carried on, for a path that ends in `\` must not swallow the line after it.
#[derive(Clone, Debug)]
pub(super) struct ContinuedLines<'a>(pub(super) Lines<'a>);

impl<'a> Iterator for ContinuedLines<'a> {
    type Item = (u64, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let (number, line) = self.0.next()?;
        let goes_on = |line: &[u8]| line.trim_ascii_end().ends_with(b"\\") && !line.contains(&b'#');
        if !goes_on(line) {
            return Some((number, Cow::Borrowed(line)));
        }
        let mut joined = Vec::new();
        let mut part = line;
        loop {
            joined.extend_from_slice(part);
            if !goes_on(part) {
                break;
            }
            joined.truncate(joined.trim_ascii_end().len() - 1);
            joined.push(b' ');
            match self.0.next() {
                Some((_, next)) => part = next,
                None => break,
            }
        }
        Some((number, Cow::Owned(joined)))
    }
}

/// The words of a line up to a comment.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let end = line.iter().position(|&byte| byte == b'#').unwrap_or(line.len());
    line[..end].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A finite coordinate of at most [`LARGEST_COORDINATE`].
pub(super) fn coordinate(word: &[u8]) -> Result<f64, Defect> {
    let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    let number: f64 = number.ok_or_else(|| Defect::NotANumber { token: excerpt(word) })?;
    check_coordinate(number, || excerpt(word))
}

/// The coordinate itself, if it is finite and not too large.
pub(super) fn check_coordinate(number: f64, token: impl Fn() -> String) -> Result<f64, Defect> {
    if !number.is_finite() {
        return Err(Defect::NotFinite { token: token() });
    }
    if number.abs() > LARGEST_COORDINATE {
        return Err(Defect::TooLarge { token: token() });
    }
    Ok(number)
}

/// The first three words as coordinates; what follows is ignored.
pub(super) fn coordinates<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], Defect> {
    let mut position = [0.0; 3];
    for (found, x) in position.iter_mut().enumerate() {
        *x = coordinate(words.next().ok_or(Defect::TooFewCoordinates { found })?)?;
    }
    Ok(position)
}

/// A whole number, such as an index.
pub(super) fn whole(word: &[u8]) -> Result<i64, Defect> {
    let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    number.ok_or_else(|| Defect::NotAnIndex { token: excerpt(word) })
}

/// An index counted from 0 of one of `vertices` vertices.
pub(super) fn index_from_zero(index: i64, vertices: u64) -> Result<u32, Defect> {
    if index < 0 {
        return Err(Defect::NegativeIndex { index });
    }
    // Counts are at most LARGEST_COUNT, so an index below one fits.
    match u32::try_from(index) {
        Ok(vertex) if u64::from(vertex) < vertices => Ok(vertex),
        _ => Err(Defect::IndexBeyond { index, vertices, base: 0 }),
    }
}

/// The shortest decimals that read back to the same `f64`: plain digits within reason, else an exponent.
pub(super) struct Decimal(pub(super) f64);

impl std::fmt::Display for Decimal {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(x) = *self;
        if x == 0.0 || (1e-5..1e16).contains(&x.abs()) { write!(out, "{x}") } else { write!(out, "{x:e}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_every_way_and_keep_their_numbers() {
        let lines: Vec<_> = Lines::new(b"\xef\xbb\xbfa\nb\r\nc\rd\n\ne").collect();
        let expected: [(u64, &[u8]); 6] = [(1, b"a"), (2, b"b"), (3, b"c"), (4, b"d"), (5, b""), (6, b"e")];
        assert_eq!(lines, expected);
    }

    #[test]
    fn a_backslash_carries_a_line_on_but_not_a_comment() {
        let text = b"f 1 2 \\\n 3 \\ \n4\n# C:\\\nv 0 0 0\nf 1 \\";
        let lines: Vec<(u64, Vec<u8>)> =
            ContinuedLines(Lines::new(text)).map(|(number, line)| (number, line.into_owned())).collect();
        let of =
            |index: usize| words(&lines[index].1).map(|word| word.to_vec()).collect::<Vec<_>>().join(&b' ');
        assert_eq!((lines[0].0, of(0)), (1, b"f 1 2 3 4".to_vec()));
        assert_eq!(lines[1].0, 4);
        assert_eq!((lines[2].0, of(2)), (5, b"v 0 0 0".to_vec()));
        assert_eq!((lines[3].0, of(3)), (6, b"f 1".to_vec()));
    }

    #[test]
    fn decimals_read_back_bit_for_bit() {
        for x in [0.0, -0.0, 0.1, 1.0 / 3.0, -1e-300, 5e-324, 123_456_789.123, 1e30, 2f64.powi(53), 9.5e-6] {
            let text = Decimal(x).to_string();
            assert_eq!(coordinate(text.as_bytes()).unwrap().to_bits(), x.to_bits(), "{text}");
            assert!(text.len() <= 25, "{text}");
        }
    }
}
