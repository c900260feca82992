//! The header of a PLY file: parsed, then checked against the bytes that follow it.

use ply_rs_bw::ply::ScalarType;

use super::*;
use crate::io::LARGEST_COUNT;

/// The names that a face's list of vertices goes by.
pub(super) const VERTEX_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// The longest header that is read. Real ones are under 10 kB, some with long comments.
const LONGEST_HEADER: usize = 1 << 20;

/// A header as the file has it.
pub(super) struct Text {
    bytes: Vec<u8>,
    /// How many lines it has.
    pub(super) lines: u64,
}

impl Text {
    /// Its length in bytes.
    pub(super) fn len(&self) -> u64 {
        self.bytes.len() as u64
    }
}

/// Takes the header off the front of a file; what is left begins after it.
pub(super) fn take(file: &mut impl BufRead) -> Parsed<Text> {
    let mut text = Text { bytes: Vec::new(), lines: 0 };
    loop {
        let (start, room) = (text.bytes.len(), LONGEST_HEADER - text.bytes.len());
        let read = file.by_ref().take(room as u64).read_until(b'\n', &mut text.bytes).unwrap_or(0);
        text.lines += 1;
        if text.lines == 1 && !text.bytes.starts_with(b"ply") {
            let reason = "it does not begin with 'ply'".to_owned();
            return Err((Place::Line(1), Defect::NotThisFormat { format: "a PLY file", reason }));
        }
        if text.bytes[start..].trim_ascii_end() == b"end_header" {
            return Ok(text);
        }
        if read == 0 {
            let problem = "the line 'end_header' is missing".to_owned();
            return Err((Place::Whole, Defect::Header { problem }));
        }
    }
}

/// What a header says.
pub(super) fn read(text: &Text) -> Parsed<Header> {
    // Comments may be in any encoding, but the parser wants UTF-8.
    let text = String::from_utf8_lossy(&text.bytes);
    let mut reader = Reader::new(text.as_bytes());
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|error| {
        let place = error.line().map_or(Place::Whole, |line| Place::Line(line as u64));
        let problem =
            "this is not a line of a PLY header, or it says what another line contradicts".to_owned();
        (place, Defect::Header { problem })
    })?;
    check_names(&text, &header)?;
    Ok(header)
}

/// Refuses two elements, or two properties of one element, of the same name, of which the parser keeps
/// only one.
fn check_names(text: &str, header: &Header) -> Parsed<()> {
    let declared = |keyword: &str| text.lines().filter(|line| line.starts_with(keyword)).count();
    let (elements, properties) = (declared("element"), declared("property"));
    let kept: usize = header.elements.values().map(|element| element.properties.len()).sum();
    if (elements, properties) == (header.elements.len(), kept) {
        return Ok(());
    }
    let problem = "two of its elements or properties have the same name".to_owned();
    Err((Place::Whole, Defect::Header { problem }))
}

/// Checks that there are vertices and faces with what they need, and no more of anything than `bytes`
/// bytes can hold.
pub(super) fn check(header: &Header, bytes: u64) -> Parsed<()> {
    let lacks = |problem: &str| Err((Place::Whole, Defect::Header { problem: problem.to_owned() }));
    let vertex = header.elements.get("vertex").filter(|vertex| vertex.count > 0);
    let vertex = vertex.ok_or((Place::Whole, Defect::NoVertices))?;
    let face = header.elements.get("face").filter(|face| face.count > 0);
    let face = face.ok_or((Place::Whole, Defect::NoFaces))?;

    let scalar = |name: &&str| {
        vertex
            .properties
            .get(*name)
            .is_some_and(|property| matches!(property.data_type, PropertyType::Scalar(_)))
    };
    if !["x", "y", "z"].iter().all(scalar) {
        return lacks("the element 'vertex' lacks one of the properties x, y and z");
    }
    let lists = face.properties.values().filter(|property| VERTEX_LISTS.contains(&property.name.as_str()));
    let mut integer_lists = lists.filter(|property| match &property.data_type {
        PropertyType::List(_, index) => !matches!(index, ScalarType::Float | ScalarType::Double),
        PropertyType::Scalar(_) => false,
    });
    if integer_lists.next().is_none() || integer_lists.next().is_some() {
        return lacks("the element 'face' needs one list of integers named vertex_indices");
    }
    check_sizes(header, bytes)
}

fn check_sizes(header: &Header, bytes: u64) -> Parsed<()> {
    let mut left = bytes;
    for element in header.elements.values() {
        let declared = element.count as u64;
        let what = format!("elements '{}'", excerpt(element.name.as_bytes()));
        if matches!(element.name.as_str(), "vertex" | "face") && declared > LARGEST_COUNT {
            let what = if element.name == "vertex" { "vertices" } else { "faces" };
            return Err((Place::Whole, Defect::TooMany { what }));
        }
        let least = least_size(element, header.encoding)?;
        if declared > 0 && least == 0 {
            let problem = format!("the header gives the {what} no properties");
            return Err((Place::Whole, Defect::Header { problem }));
        }
        // The last line of a text may lack its end.
        let allowance = u64::from(header.encoding == Encoding::Ascii);
        let needed = declared.checked_mul(least).filter(|&needed| needed <= left + allowance);
        let oversized = || (Place::Whole, Defect::Oversized { what, declared, bytes });
        left = left.saturating_sub(needed.ok_or_else(oversized)?);
    }
    Ok(())
}

/// The fewest bytes an element can take: in binary its scalars and the counts of its lists, in ASCII a
/// digit and a space or line end for each.
fn least_size(element: &ElementDef, encoding: Encoding) -> Parsed<u64> {
    let mut least = 0;
    for property in element.properties.values() {
        let first = match &property.data_type {
            PropertyType::Scalar(scalar) => scalar,
            PropertyType::List(ScalarType::Float | ScalarType::Double, _) => {
                let name = excerpt(property.name.as_bytes());
                let problem = format!("the list '{name}' has a count that is not an integer");
                return Err((Place::Whole, Defect::Header { problem }));
            }
            PropertyType::List(count, _) => count,
        };
        least += match first {
            _ if encoding == Encoding::Ascii => 2,
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        };
    }
    Ok(least)
}
