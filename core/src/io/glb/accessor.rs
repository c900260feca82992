//! Numbers in the binary chunk (glTF 2.0 specification, sections 3.6 and 5.1). Every range is checked against the
//! chunk's length before a byte is read.

use super::scene::{Accessor, Scenes, Shape};
use crate::io::text::{Decimal, check_coordinate};
use crate::io::watch::Watch;
use crate::io::{Defect, LARGEST_COUNT, Parsed, Place, with_room};

/// Where an accessor's elements are.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: Component,
    normalized: bool,
}

/// The type of a number.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    Byte,
    UnsignedByte,
    Short,
    UnsignedShort,
    UnsignedInt,
    Float,
}

impl Component {
    fn of(code: u32) -> Option<Self> {
        match code {
            5120 => Some(Self::Byte),
            5121 => Some(Self::UnsignedByte),
            5122 => Some(Self::Short),
            5123 => Some(Self::UnsignedShort),
            5125 => Some(Self::UnsignedInt),
            5126 => Some(Self::Float),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::Byte | Self::UnsignedByte => 1,
            Self::Short | Self::UnsignedShort => 2,
            Self::UnsignedInt | Self::Float => 4,
        }
    }

    /// The number at the start of `bytes`, which hold at least one.
    fn read(self, bytes: &[u8]) -> f64 {
        match self {
            Self::Byte => f64::from(bytes[0] as i8),
            Self::UnsignedByte => f64::from(bytes[0]),
            Self::Short => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Self::UnsignedShort => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Self::UnsignedInt => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
            Self::Float => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        }
    }

    /// The number that stands for 1 where integers are normalised.
    fn one(self) -> f64 {
        match self {
            Self::Byte => 127.0,
            Self::UnsignedByte => 255.0,
            Self::Short => 32767.0,
            Self::UnsignedShort => 65535.0,
            Self::UnsignedInt | Self::Float => 1.0,
        }
    }
}

/// The place that an error about an accessor names.
pub(super) fn accessor_place(index: usize) -> Place {
    Place::Element { name: "accessor".to_owned(), index: index as u64 }
}

fn scene_defect(problem: &str) -> Defect {
    Defect::Scene { problem: problem.to_owned() }
}

/// The accessor of a number.
pub(super) fn accessor(scenes: &Scenes, index: usize) -> Parsed<&Accessor> {
    let missing = || (accessor_place(index), scene_defect("the accessor does not exist"));
    scenes.accessors.get(index).ok_or_else(missing)
}

/// The positions of an accessor, as `place` makes them.
pub(super) fn positions(
    (scenes, binary): (&Scenes, &[u8]),
    index: usize,
    place: impl Fn([f64; 3]) -> [f64; 3],
    watch: &Watch,
    into: &mut Vec<[f64; 3]>,
) -> Parsed<()> {
    let here = |defect| (accessor_place(index), defect);
    let elements = elements(scenes, binary, index, Shape::Vec3)?;
    let component = elements.component;
    if component == Component::UnsignedInt {
        return Err(here(scene_defect("positions cannot be 32-bit integers")));
    }
    into.try_reserve(elements.count).map_err(|_| here(Defect::OutOfMemory))?;
    for vertex in 0..elements.count {
        watch.pass()?;
        let bytes = &elements.bytes[vertex * elements.stride..];
        let number = |axis: usize| {
            let number = component.read(&bytes[axis * component.size()..]);
            if elements.normalized { (number / component.one()).max(-1.0) } else { number }
        };
        let placed = place([number(0), number(1), number(2)]);
        for x in placed {
            let name = || Place::Element { name: format!("accessor {index}, vertex"), index: vertex as u64 };
            check_coordinate(x, || Decimal(x).to_string()).map_err(|defect| (name(), defect))?;
        }
        into.push(placed);
    }
    Ok(())
}

/// The indices of an accessor, all below `vertices`.
pub(super) fn indices(
    (scenes, binary): (&Scenes, &[u8]),
    index: usize,
    vertices: u64,
    watch: &Watch,
) -> Parsed<Vec<u32>> {
    let elements = elements(scenes, binary, index, Shape::Scalar)?;
    let unsigned = [Component::UnsignedByte, Component::UnsignedShort, Component::UnsignedInt];
    if !unsigned.contains(&elements.component) {
        return Err((accessor_place(index), scene_defect("indices must be unsigned integers")));
    }
    let mut indices = with_room(elements.count)?;
    for element in 0..elements.count {
        watch.pass()?;
        let vertex = elements.component.read(&elements.bytes[element * elements.stride..]) as u32;
        if u64::from(vertex) >= vertices {
            let place = Place::Element { name: format!("accessor {index}, index"), index: element as u64 };
            return Err((place, Defect::IndexBeyond { index: vertex.into(), vertices, base: 0 }));
        }
        indices.push(vertex);
    }
    Ok(indices)
}

/// Finds and checks an accessor's elements.
fn elements<'a>(scenes: &Scenes, binary: &'a [u8], index: usize, shape: Shape) -> Parsed<Elements<'a>> {
    let here = |defect| (accessor_place(index), defect);
    let wrong = |problem: &str| here(scene_defect(problem));
    let accessor = accessor(scenes, index)?;
    if accessor.sparse.is_some() {
        return Err(here(Defect::Feature { feature: "a sparse accessor".to_owned() }));
    }
    let component = Component::of(accessor.component_type);
    let component = component.ok_or_else(|| wrong("its component type is none of glTF's"))?;
    if accessor.shape != shape {
        return Err(wrong(match shape {
            Shape::Vec3 => "positions must be of type VEC3",
            _ => "indices must be of type SCALAR",
        }));
    }
    if accessor.count > LARGEST_COUNT {
        return Err(here(Defect::TooMany { what: "elements" }));
    }
    let view = accessor.buffer_view.ok_or_else(|| wrong("it has no buffer view, so no data"))?;
    let view = scenes.buffer_views.get(view).ok_or_else(|| wrong("its buffer view does not exist"))?;
    view.check_compression().map_err(here)?;
    if view.buffer != 0 || scenes.buffers.first().is_none_or(|buffer| buffer.uri.is_some()) {
        return Err(here(Defect::Feature { feature: "a buffer outside the file's binary chunk".to_owned() }));
    }
    let width = component.size() * if shape == Shape::Vec3 { 3 } else { 1 };
    let stride = view.byte_stride.unwrap_or(width as u64);
    if stride < width as u64 {
        return Err(wrong("the stride of its buffer view is shorter than an element"));
    }
    // Counts and strides of real files are far below what would overflow; others are beyond the end.
    let from = view.byte_offset.checked_add(accessor.byte_offset);
    let length =
        accessor.count.saturating_sub(1).checked_mul(stride).map(|most| most.saturating_add(width as u64));
    let end = |from: u64, length: u64| from.checked_add(if accessor.count == 0 { 0 } else { length });
    let view_end = view.byte_offset.checked_add(view.byte_length).filter(|&end| end <= binary.len() as u64);
    match (from, from.zip(length).and_then(|(from, length)| end(from, length)), view_end) {
        (Some(from), Some(end), Some(view_end)) if end <= view_end => Ok(Elements {
            bytes: &binary[from as usize..end as usize],
            stride: stride as usize,
            count: accessor.count as usize,
            component,
            normalized: accessor.normalized,
        }),
        _ => Err(wrong("its data reaches beyond the end of its buffer view or of the file")),
    }
}
