//! The elements `edge`: sharp edges, unless a property `sharp` or `crease` is there and says otherwise.

use super::*;

/// What the elements are called.
pub(super) const NAME: &str = "edge";
/// The properties that hold an edge's vertices.
pub(super) const ENDS: [&str; 2] = ["vertex1", "vertex2"];
/// Properties that are above zero where an edge is sharp.
const SHARPNESS: [&str; 2] = ["sharp", "crease"];

/// An edge in the making.
pub(super) struct Edge {
    ends: [Option<i64>; 2],
    sharp: bool,
}

impl Edge {
    /// The vertices if they are both given, in range, and not said to be smooth.
    pub(super) fn ends(&self, vertices: u64) -> Result<Option<[u32; 2]>, Defect> {
        let [Some(a), Some(b)] = self.ends else { return Ok(None) };
        let ends = [index_from_zero(a, vertices)?, index_from_zero(b, vertices)?];
        Ok(self.sharp.then_some(ends))
    }
}

impl PropertyAccess for Edge {
    fn new() -> Self {
        Self { ends: [None; 2], sharp: true }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let whole = match property {
            Property::Char(x) => i64::from(x),
            Property::UChar(x) => i64::from(x),
            Property::Short(x) => i64::from(x),
            Property::UShort(x) => i64::from(x),
            Property::Int(x) => i64::from(x),
            Property::UInt(x) => i64::from(x),
            Property::Float(x) => i64::from(x > 0.0),
            Property::Double(x) => i64::from(x > 0.0),
            _ => return PropertyAccessResult::Ignored,
        };
        let number_is_whole = !matches!(property, Property::Float(_) | Property::Double(_));
        if SHARPNESS.contains(&name) {
            self.sharp = whole > 0;
        } else if let Some(end) = ENDS.iter().position(|end| *end == name).filter(|_| number_is_whole) {
            self.ends[end] = Some(whole);
        } else {
            return PropertyAccessResult::Ignored;
        }
        PropertyAccessResult::Set
    }
}
