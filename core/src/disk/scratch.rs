//! A scratch file: bytes that need not be in memory, for as long as the program runs.
//!
//! The file has no name, so it goes with the program however that ends. No part of any document depends on it alone: what
//! it holds is in the log as well.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex};

/// The file, made when first needed, in the system's folder for such files.
#[derive(Debug, Clone, Default)]
pub struct Scratch(Arc<Mutex<Option<File>>>);

/// Bytes in a scratch file.
#[derive(Debug)]
pub struct Stored {
    scratch: Scratch,
    at: u64,
    len: usize,
}

impl Scratch {
    /// Writes bytes to the file's end.
    ///
    /// # Errors
    /// There is no room, or no such folder.
    pub fn store(&self, bytes: &[u8]) -> io::Result<Stored> {
        let mut file = self.0.lock().map_err(|_| io::Error::other("a writer stopped"))?;
        if file.is_none() {
            *file = Some(tempfile::tempfile()?);
        }
        let file = file.as_mut().expect("just made");
        let at = file.seek(SeekFrom::End(0))?;
        file.write_all(bytes)?;
        Ok(Stored { scratch: self.clone(), at, len: bytes.len() })
    }
}

impl Stored {
    /// The bytes.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read(&self) -> io::Result<Vec<u8>> {
        let mut file = self.scratch.0.lock().map_err(|_| io::Error::other("a writer stopped"))?;
        let file = file.as_mut().ok_or_else(|| io::Error::other("the scratch file is gone"))?;
        file.seek(SeekFrom::Start(self.at))?;
        let mut bytes = vec![0; self.len];
        file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stored_is_read_again_in_any_order() {
        let scratch = Scratch::default();
        let stored: Vec<Stored> =
            (0..5u8).map(|k| scratch.store(&vec![k; 100 * usize::from(k)]).expect("room")).collect();
        for (k, stored) in stored.iter().enumerate().rev() {
            assert_eq!(stored.read().expect("it is there"), vec![k as u8; 100 * k]);
        }
    }
}
