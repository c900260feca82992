//! Log lines as text: JSON Lines, one edit or control a line. A journal and a hand-written script are the same.
//!
//! A line may end in `"crc"`: the CRC-32 of the line's bytes before `,"crc"`, in eight hexadecimal digits. Journals
//! always carry it.

use super::Edit;
use crate::surface::SurfaceHash;
use serde_json::{Map, Value};
use thiserror::Error;

/// What a line of a log says.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// An edit; every 32nd carries the surface hash after it.
    Edit(Edit),
    /// Undo so many steps.
    Undo(u32),
    /// Redo so many steps.
    Redo(u32),
    /// The user saved here.
    Save,
    /// Everything since the last save mark (or the beginning) is discarded.
    Discard,
    /// The first line of a journal: which wavelet file it belongs to.
    Binding {
        /// The wavelet file's id.
        of: String,
    },
}

/// A parsed line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// What it says.
    pub entry: Entry,
    /// The surface hash after it, if it carries one.
    pub hash: Option<SurfaceHash>,
    /// Whether it carries a checksum, which then agrees.
    pub checked: bool,
}

/// Why a line cannot be read.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum LineError {
    /// Not one JSON object.
    #[error("this is not a JSON object ({0})")]
    NotJson(String),
    /// The checksum does not agree.
    #[error("its checksum does not agree with its text")]
    Checksum,
    /// Neither edit nor control.
    #[error("it holds neither an edit nor undo, redo, save, discard or log")]
    Unknown,
    /// An edit with wrong or missing fields.
    #[error("{0}")]
    Fields(String),
}

/// A longer line is refused unread.
pub const LONGEST_LINE: usize = 1 << 20;

impl Line {
    /// Reads a line.
    ///
    /// # Errors
    /// See [`LineError`].
    pub fn parse(text: &str) -> Result<Self, LineError> {
        let text = text.trim();
        if text.len() > LONGEST_LINE {
            return Err(LineError::NotJson(format!("longer than {LONGEST_LINE} bytes")));
        }
        let value: Value = serde_json::from_str(text).map_err(|e| LineError::NotJson(e.to_string()))?;
        let Value::Object(mut object) = value else {
            return Err(LineError::NotJson("another JSON value".into()));
        };
        let checked = match object.remove("crc") {
            None => false,
            Some(crc) => {
                let body = text.rfind(",\"crc\"").map(|at| &text[..at]).ok_or(LineError::Checksum)?;
                // Nothing may stand after the checksum, where it would not be covered.
                let crc_alone = text[body.len()..] == sealed(body)[body.len()..];
                if !crc_alone || !crc.is_string() {
                    return Err(LineError::Checksum);
                }
                true
            }
        };
        let hash = match object.remove("hash") {
            None => None,
            Some(Value::String(text)) => Some(
                text.parse()
                    .map_err(|()| LineError::Fields("\"hash\" must be 32 hexadecimal digits".into()))?,
            ),
            Some(_) => return Err(LineError::Fields("\"hash\" must be a string".into())),
        };
        Ok(Self { entry: entry(object)?, hash, checked })
    }

    /// The line as text with its checksum, without the line's end.
    pub fn to_text(entry: &Entry, hash: Option<SurfaceHash>) -> String {
        let body = match entry {
            Entry::Edit(edit) => serde_json::to_string(edit).expect("edits are plain data"),
            Entry::Undo(count) => format!("{{\"undo\":{count}}}"),
            Entry::Redo(count) => format!("{{\"redo\":{count}}}"),
            Entry::Save => "{\"save\":1}".to_owned(),
            Entry::Discard => "{\"discard\":1}".to_owned(),
            Entry::Binding { of } => format!("{{\"log\":1,\"of\":{}}}", Value::String(of.clone())),
        };
        let mut text = body;
        text.pop();
        if let Some(hash) = hash {
            text.push_str(&format!(",\"hash\":\"{hash}\""));
        }
        sealed(&text)
    }
}

/// A line's text without its last brace, with checksum and brace.
fn sealed(body: &str) -> String {
    format!("{body},\"crc\":\"{:08x}\"}}", crc32fast::hash(body.as_bytes()))
}

fn entry(object: Map<String, Value>) -> Result<Entry, LineError> {
    if object.contains_key("edit") {
        return serde_json::from_value(Value::Object(object))
            .map(Entry::Edit)
            .map_err(|e| LineError::Fields(e.to_string()));
    }
    let controls = ["undo", "redo", "save", "discard", "log"];
    let Some(control) = controls.into_iter().find(|c| object.contains_key(*c)) else {
        return Err(LineError::Unknown);
    };
    let allowed = if control == "log" { 2 } else { 1 };
    if object.len() > allowed {
        return Err(LineError::Fields(format!("\"{control}\" has fields that mean nothing beside it")));
    }
    let count = object[control].as_u64().and_then(|n| u32::try_from(n).ok()).filter(|&n| n > 0);
    let count =
        count.ok_or_else(|| LineError::Fields(format!("\"{control}\" must be a positive whole number")))?;
    Ok(match control {
        "undo" => Entry::Undo(count),
        "redo" => Entry::Redo(count),
        "save" => Entry::Save,
        "discard" => Entry::Discard,
        _ if count != 1 => {
            return Err(LineError::Fields(format!(
                "version {count} of the log is not known here; a newer Bozzetto wrote it"
            )));
        }
        _ => match object.get("of") {
            Some(Value::String(of)) => Entry::Binding { of: of.clone() },
            _ => return Err(LineError::Fields("\"log\" must say which file it is \"of\"".into())),
        },
    })
}
