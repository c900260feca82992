//! A mesh file that is parsed as it comes from the disk.

use super::{Defect, MeshFileError, Place};
use std::fs::File;
use std::io::{BufRead, Error, ErrorKind, Read, Result, Take};
use std::path::Path;

/// Bytes read at a time: some hundredths of a second on a slow disk.
const AT_ONCE: usize = 1 << 20;

/// A file of which every byte read is shown to an observer, with the share of the file read by then.
pub(super) struct Stream<'a> {
    /// As long as the file was when it was opened.
    file: Take<File>,
    length: u64,
    buffer: Vec<u8>,
    /// What of the buffer is still to be parsed.
    left: std::ops::Range<usize>,
    seen: &'a mut dyn FnMut(&[u8], f32),
    failure: Option<Error>,
}

impl<'a> Stream<'a> {
    /// Opens a file.
    pub(super) fn open(
        path: &Path,
        name: &str,
        seen: &'a mut dyn FnMut(&[u8], f32),
    ) -> std::result::Result<Self, MeshFileError> {
        let unreadable = |error: Error| MeshFileError::unreadable(name, error);
        let metadata = std::fs::metadata(path).map_err(unreadable)?;
        if !metadata.is_file() {
            return Err(MeshFileError::not_a_file(name));
        }
        let length = metadata.len();
        let file = File::open(path).map_err(unreadable)?.take(length);
        Ok(Self { file, length, buffer: vec![0; AT_ONCE], left: 0..0, seen, failure: None })
    }

    /// The file's length in bytes.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// The whole file, for parsers that need it; asks whether to go on before each part.
    pub(super) fn read_whole(
        &mut self,
        name: &str,
        go_on: &mut dyn FnMut() -> bool,
    ) -> std::result::Result<Vec<u8>, MeshFileError> {
        let mut bytes = Vec::new();
        let length = usize::try_from(self.length).unwrap_or(usize::MAX);
        let room = bytes.try_reserve_exact(length);
        room.map_err(|_| MeshFileError::malformed(name, Place::Whole, Defect::OutOfMemory))?;
        loop {
            if !go_on() {
                return Err(MeshFileError::cancelled(name));
            }
            let part = self.fill_buf().map_err(|error| MeshFileError::unreadable(name, error))?;
            if part.is_empty() {
                return Ok(bytes);
            }
            bytes.extend_from_slice(part);
            let count = part.len();
            self.consume(count);
        }
    }

    /// Shows what the parser had no need of.
    pub(super) fn pass_over_rest(&mut self) {
        while let Ok(part @ [_, ..]) = self.fill_buf() {
            let count = part.len();
            self.consume(count);
        }
    }

    /// Why the file could not be read on, if it could not.
    pub(super) fn failure(self) -> Option<Error> {
        self.failure
    }
}

impl BufRead for Stream<'_> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        while self.left.is_empty() {
            match self.file.read(&mut self.buffer) {
                Ok(0) => return Ok(&[]),
                Ok(count) => {
                    self.left = 0..count;
                    let done = self.length - self.file.limit();
                    (self.seen)(&self.buffer[..count], done as f32 / self.length as f32);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    // The parser takes it for the file's end.
                    let kind = error.kind();
                    self.failure = Some(error);
                    return Err(kind.into());
                }
            }
        }
        Ok(&self.buffer[self.left.clone()])
    }

    fn consume(&mut self, amount: usize) {
        self.left.start += amount;
    }
}

impl Read for Stream<'_> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let count = self.fill_buf()?.read(into)?;
        self.consume(count);
        Ok(count)
    }
}
