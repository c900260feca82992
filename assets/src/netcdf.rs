//! A reader for netCDF-3 "classic" files, as far as gridded elevations need it.
//!
//! Guarantees:
//! - every read is checked against the file's length; a damaged file is an error that names the byte, never a panic;
//! - fixed-size variables of type `short`, `int`, `float` and `double` are returned as `f64`.
//!
//! Non-guarantees: record variables, `CDF-5` and netCDF-4 (HDF5) files are refused, and attributes are skipped.
//!
//! Based on: Unidata, *NetCDF Classic Format Specification*. Everything in the file is big-endian and padded to
//! four bytes.

use anyhow::{Context, Result, anyhow, bail, ensure};

const TAG_DIMENSION: u32 = 0x0A;
const TAG_VARIABLE: u32 = 0x0B;
const TAG_ATTRIBUTE: u32 = 0x0C;

/// A named array of a netCDF file, its values widened to `f64` in file order (last dimension fastest).
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// The variable's name.
    pub name: String,
    /// Names and lengths of its dimensions, slowest first.
    pub shape: Vec<(String, u32)>,
    /// The values; as many as the product of the lengths.
    pub values: Vec<f64>,
}

/// Reads the variable called `name` from the bytes of a classic netCDF file.
///
/// # Errors
/// When the file is not classic netCDF, is cut short, or holds no fixed-size numeric variable of that name.
pub fn read_variable(bytes: &[u8], name: &str) -> Result<Variable> {
    let mut reader = Reader { bytes, at: 0 };
    let wide_offsets = reader.magic()?;
    reader.word().context("the record count")?;
    let dimensions = read_dimensions(&mut reader).context("the list of dimensions")?;
    skip_attributes(&mut reader).context("the global attributes")?;
    let headers = read_headers(&mut reader, wide_offsets).context("the list of variables")?;
    let header = headers.iter().find(|header| header.name == name).ok_or_else(|| {
        let names: Vec<&str> = headers.iter().map(|header| header.name.as_str()).collect();
        anyhow!("there is no variable `{name}`; the file holds: {}", names.join(", "))
    })?;
    read_values(bytes, header, &dimensions).with_context(|| format!("variable `{name}`"))
}

/// What the file's header says about one variable.
struct Header {
    name: String,
    dimensions: Vec<u32>,
    kind: u32,
    begin: u64,
}

fn read_dimensions(reader: &mut Reader) -> Result<Vec<(String, u32)>> {
    let count = reader.list(TAG_DIMENSION)?;
    (0..count).map(|_| Ok((reader.name()?, reader.word()?))).collect()
}

fn skip_attributes(reader: &mut Reader) -> Result<()> {
    for _ in 0..reader.list(TAG_ATTRIBUTE)? {
        let name = reader.name()?;
        let size = size_of_kind(reader.word()?).with_context(|| format!("attribute `{name}`"))?;
        let count = u64::from(reader.word()?);
        reader.take((count * size).next_multiple_of(4))?;
    }
    Ok(())
}

fn read_headers(reader: &mut Reader, wide_offsets: bool) -> Result<Vec<Header>> {
    let count = reader.list(TAG_VARIABLE)?;
    let mut headers = Vec::new();
    for _ in 0..count {
        let name = reader.name()?;
        let rank = reader.word()?;
        ensure!(rank <= 1024, "variable `{name}` claims {rank} dimensions");
        let dimensions = (0..rank).map(|_| reader.word()).collect::<Result<_>>()?;
        skip_attributes(reader)?;
        let kind = reader.word()?;
        reader.word()?; // the padded size: follows from shape and kind
        let begin = if wide_offsets {
            (u64::from(reader.word()?) << 32) | u64::from(reader.word()?)
        } else {
            u64::from(reader.word()?)
        };
        headers.push(Header { name, dimensions, kind, begin });
    }
    Ok(headers)
}

fn read_values(bytes: &[u8], header: &Header, dimensions: &[(String, u32)]) -> Result<Variable> {
    let mut shape = Vec::new();
    let mut count: u64 = 1;
    for &id in &header.dimensions {
        let dimension = dimensions
            .get(id as usize)
            .ok_or_else(|| anyhow!("it names dimension {id}, which is not there"))?;
        ensure!(
            dimension.1 > 0,
            "dimension `{}` is the record dimension, which is not read here",
            dimension.0
        );
        count = count.checked_mul(u64::from(dimension.1)).context("its size overflows")?;
        shape.push(dimension.clone());
    }
    let size = size_of_kind(header.kind)?;
    let length = count.checked_mul(size).context("its size overflows")?;
    let mut reader = Reader { bytes, at: header.begin };
    let data = reader.take(length)?;
    let values = match header.kind {
        3 => data.as_chunks().0.iter().map(|&b| f64::from(i16::from_be_bytes(b))).collect(),
        4 => data.as_chunks().0.iter().map(|&b| f64::from(i32::from_be_bytes(b))).collect(),
        5 => data.as_chunks().0.iter().map(|&b| f64::from(f32::from_be_bytes(b))).collect(),
        6 => data.as_chunks().0.iter().map(|&b| f64::from_be_bytes(b)).collect(),
        kind => bail!("its values are of type {kind}, not a number type read here"),
    };
    Ok(Variable { name: header.name.clone(), shape, values })
}

fn size_of_kind(kind: u32) -> Result<u64> {
    match kind {
        1 | 2 => Ok(1),
        3 => Ok(2),
        4 | 5 => Ok(4),
        6 => Ok(8),
        _ => bail!("unknown value type {kind}"),
    }
}

/// A place in the file; every step is checked.
struct Reader<'a> {
    bytes: &'a [u8],
    at: u64,
}

impl<'a> Reader<'a> {
    fn take(&mut self, length: u64) -> Result<&'a [u8]> {
        let cut_short = || {
            anyhow!(
                "{length} bytes are wanted at byte {}, but the file ends at {}",
                self.at,
                self.bytes.len()
            )
        };
        let start = usize::try_from(self.at)?;
        let end = start.checked_add(usize::try_from(length)?).ok_or_else(cut_short)?;
        let taken = self.bytes.get(start..end).ok_or_else(cut_short)?;
        self.at = end as u64;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32> {
        let bytes = self.take(4)?;
        Ok(u32::from_be_bytes(bytes.try_into()?))
    }

    /// Reads the magic number; true when offsets are 64 bits wide.
    fn magic(&mut self) -> Result<bool> {
        match self.take(4)? {
            b"CDF\x01" => Ok(false),
            b"CDF\x02" => Ok(true),
            other => bail!("it does not begin as a classic netCDF file does (found {other:?} at byte 0)"),
        }
    }

    /// Reads the head of a list and returns its length: `tag count`, or two zero words for an absent list.
    fn list(&mut self, tag: u32) -> Result<u32> {
        let at = self.at;
        let (found, count) = (self.word()?, self.word()?);
        ensure!(found == tag || (found == 0 && count == 0), "byte {at}: list tag {found}, expected {tag}");
        Ok(count)
    }

    fn name(&mut self) -> Result<String> {
        let at = self.at;
        let length = u64::from(self.word()?);
        let padded = self.take(length.next_multiple_of(4))?;
        let text = &padded[..length as usize];
        String::from_utf8(text.to_vec()).with_context(|| format!("the name at byte {at}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with one dimension `x` of length 3, one text attribute and one `short` variable `v`.
    fn sample() -> Vec<u8> {
        let mut bytes = b"CDF\x01".to_vec();
        let mut word = |value: u32| bytes.extend(value.to_be_bytes());
        word(0);
        [TAG_DIMENSION, 1, 1, u32::from_be_bytes(*b"x\0\0\0"), 3].into_iter().for_each(&mut word);
        [TAG_ATTRIBUTE, 1, 1, u32::from_be_bytes(*b"a\0\0\0"), 2, 2, u32::from_be_bytes(*b"hi\0\0")]
            .into_iter()
            .for_each(&mut word);
        [TAG_VARIABLE, 1, 1, u32::from_be_bytes(*b"v\0\0\0"), 1, 0, 0, 0, 3, 8, 100]
            .into_iter()
            .for_each(&mut word);
        bytes.resize(100, 0);
        for value in [-7i16, 0, 8848] {
            bytes.extend(value.to_be_bytes());
        }
        bytes
    }

    #[test]
    fn a_variable_is_read_with_its_shape() {
        let variable = read_variable(&sample(), "v").expect("the sample is well formed");
        assert_eq!(variable.shape, [("x".to_owned(), 3)]);
        assert_eq!(variable.values, [-7.0, 0.0, 8848.0]);
    }

    #[test]
    fn every_cut_is_an_error() {
        let bytes = sample();
        for length in 0..bytes.len() {
            assert!(read_variable(&bytes[..length], "v").is_err(), "cut at {length}");
        }
    }

    #[test]
    fn a_missing_variable_is_named_beside_those_present() {
        let message = read_variable(&sample(), "ROSE").expect_err("there is none").to_string();
        assert!(message.contains("ROSE") && message.contains(": v"), "{message}");
    }
}
