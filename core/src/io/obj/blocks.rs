//! A text in blocks of whole lines.

use std::io::{BufRead, Read};

/// Bytes of a block, or a few more: enough that the end of the last line is soon found.
const BLOCK: u64 = 1 << 20;

/// Blocks that end with a line that is not carried on.
pub(super) struct Blocks<'a, R> {
    file: &'a mut R,
    buffer: Vec<u8>,
    /// What of the buffer was given out.
    given: usize,
    /// As far as this no line ends that is not carried on.
    searched: usize,
}

impl<'a, R: BufRead> Blocks<'a, R> {
    pub(super) fn new(file: &'a mut R) -> Self {
        Self { file, buffer: Vec::new(), given: 0, searched: 0 }
    }

    /// The next block; `None` at the end of what can be read.
    pub(super) fn next(&mut self) -> Option<&[u8]> {
        self.buffer.drain(..self.given);
        self.searched = 0;
        loop {
            let read = self.file.by_ref().take(BLOCK).read_to_end(&mut self.buffer).unwrap_or(0);
            self.given = if read == 0 { self.buffer.len() } else { whole_lines(&self.buffer, self.searched) };
            // The last byte may turn out to end a line.
            self.searched = self.buffer.len().saturating_sub(1);
            if self.given > 0 || read == 0 {
                break;
            }
        }
        (self.given > 0).then(|| &self.buffer[..self.given])
    }
}

/// Where the last line ends that is surely not carried on, its end not before `from`; 0 if none is.
fn whole_lines(text: &[u8], from: usize) -> usize {
    let ends = |at: usize| match text[at] {
        b'\n' => true,
        // If a line feed may follow, the line ends there.
        b'\r' => text.get(at + 1).is_some_and(|&next| next != b'\n'),
        _ => false,
    };
    let mut end = text.len();
    while let Some(at) = (from..end).rev().find(|&at| ends(at)) {
        let line = &text[..at];
        let before = if text[at] == b'\n' { line.strip_suffix(b"\r").unwrap_or(line) } else { line };
        let start = before.iter().rposition(|&byte| matches!(byte, b'\n' | b'\r')).map_or(0, |at| at + 1);
        if !before[start..].trim_ascii_end().ends_with(b"\\") {
            return at + 1;
        }
        end = at;
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_end_with_whole_lines_and_lose_nothing() {
        let cases: [(&[u8], usize); 9] = [
            (b"f 1 \\\n\n2", 7),
            (b"v 1\nv 2\nv", 8),
            (b"f 1 \\\n2", 0),
            (b"v\nf 1 \\ \r\n2", 2),
            (b"v\rv", 2),
            (b"v\r", 0),
            (b"v \\\rv", 0),
            (b"v\r\nv\r\n", 6),
            (b"", 0),
        ];
        for (text, end) in cases {
            assert_eq!(whole_lines(text, 0), end, "{}", String::from_utf8_lossy(text));
        }
        // Many blocks, and one line longer than a block; with each way to end lines.
        for end in ["\n", "\r\n", "\r"] {
            let mut text = format!("v 1 2 3 \\{end}{end}").repeat(200_000).into_bytes();
            text.extend(vec![b'x'; 3 << 20]);
            text.extend(format!("{end}last").bytes());
            blocks_of(&text);
        }
    }

    fn blocks_of(text: &[u8]) {
        let (mut file, mut read, mut count) = (text, Vec::new(), 0);
        let mut blocks = Blocks::new(&mut file);
        while let Some(block) = blocks.next() {
            read.extend_from_slice(block);
            count += 1;
        }
        assert!(read == text && count > 2, "{count} blocks");
    }
}
