//! The header as bytes, little-endian throughout.

use super::progressive::Telling;
use crate::hierarchy::{FINEST_LEVEL, MOST_VERTICES};
use crate::surface::{CHANNELS, Form, PRECISIONS, Placement, Surface, SurfaceHash, UpAxis};
use crate::wavelet::{Scheme, Wavelet};

/// The most base faces that are opened. A closed surface has about twice as many faces as vertices.
const MOST_FACES: u32 = 4 * MOST_VERTICES;

/// What the `HEAD` chunk says.
pub(super) struct Header {
    pub(super) form: Form,
    pub(super) telling: Telling,
    pub(super) levels: u8,
    pub(super) vertices: u32,
    pub(super) faces: u32,
    pub(super) hash: SurfaceHash,
}

/// The version from which on the stream's transform is named.
const NAMES_CODING: u16 = 3;

/// The `HEAD` payload of a surface.
pub(super) fn encode(surface: &Surface, telling: Telling) -> Vec<u8> {
    let form = surface.form();
    let base = surface.hierarchy().base();
    let mut bytes = vec![telling.code(), form.scheme.code(), form.wavelet.code()];
    bytes.extend([surface.finest().0, form.precision]);
    bytes.extend([form.placement.up.code(), CHANNELS.len() as u8]);
    for text in CHANNELS.iter().copied().chain([form.placement.unit.as_str()]) {
        bytes.push(text.len() as u8);
        bytes.extend(text.as_bytes());
    }
    let [x, y, z] = form.placement.origin;
    let numbers = [x, y, z, form.placement.step];
    let short = numbers.iter().all(|&number| f64::from(number as f32).to_bits() == number.to_bits());
    bytes.push(u8::from(short));
    for number in numbers {
        if short {
            bytes.extend((number as f32).to_le_bytes());
        } else {
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes.extend(base.vertex_count().to_le_bytes());
    bytes.extend((base.faces().len() as u32).to_le_bytes());
    bytes.extend(surface.hash().0);
    bytes
}

impl Header {
    /// Reads a `HEAD` payload of a version, or says what is wrong with it.
    pub(super) fn decode(bytes: &[u8], version: u16) -> Result<Self, String> {
        let mut fields = Fields(bytes);
        let [telling] = if version < NAMES_CODING { [0] } else { fields.take()? };
        let telling = Telling::from_code(telling)
            .ok_or_else(|| format!("transform {telling} of the coefficients is not known"))?;
        let [scheme, wavelet, levels, precision, up, channels] = fields.take()?;
        let scheme = Scheme::from_code(scheme).ok_or_else(|| format!("scheme {scheme} is not known"))?;
        let wavelet = Wavelet::from_code(wavelet).ok_or_else(|| format!("wavelet {wavelet} is not known"))?;
        let up = UpAxis::from_code(up).ok_or("the up axis is not known")?;
        if levels > FINEST_LEVEL || !PRECISIONS.contains(&precision) {
            return Err(format!("{levels} levels at {precision} bits are out of range"));
        }
        let names: Vec<String> = (0..channels).map(|_| fields.text()).collect::<Result<_, _>>()?;
        if names != CHANNELS {
            return Err(format!("the channels {names:?} are not known"));
        }
        let unit = fields.text()?;
        let [short] = fields.take()?;
        if short > 1 {
            return Err("the placement is not made of usable numbers".into());
        }
        let mut number = || fields.number(short == 1);
        let numbers: [f64; 4] = [number()?, number()?, number()?, number()?];
        let [x, y, z, step] = numbers;
        if !numbers.iter().all(|n| n.is_finite() && n.abs() < 1e300) || step < 1e-300 {
            return Err("the placement is not made of usable numbers".into());
        }
        let placement = Placement { origin: [x, y, z], step, up, unit };
        let (vertices, faces) = (u32::from_le_bytes(fields.take()?), u32::from_le_bytes(fields.take()?));
        if vertices > MOST_VERTICES || faces > MOST_FACES {
            return Err(format!(
                "a base mesh of {vertices} vertices and {faces} faces is more than is opened"
            ));
        }
        let hash = SurfaceHash(fields.take()?);
        if !fields.0.is_empty() {
            return Err("the header is longer than this version's".into());
        }
        let form = Form { scheme, wavelet, precision, placement };
        Ok(Self { form, telling, levels, vertices, faces, hash })
    }
}

struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (head, rest) = self.0.split_at_checked(N).ok_or("the header is too short")?;
        self.0 = rest;
        Ok(head.try_into().expect("N bytes"))
    }

    fn number(&mut self, short: bool) -> Result<f64, String> {
        Ok(if short { f64::from(f32::from_le_bytes(self.take()?)) } else { f64::from_le_bytes(self.take()?) })
    }

    fn text(&mut self) -> Result<String, String> {
        let [length] = self.take()?;
        let length = usize::from(length);
        let (head, rest) = self.0.split_at_checked(length).ok_or("the header is too short")?;
        self.0 = rest;
        String::from_utf8(head.to_vec()).map_err(|_| "the header holds broken text".into())
    }
}
