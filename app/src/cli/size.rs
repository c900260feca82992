//! How small a result is to be: arguments shared by `import` and `export`.

use anyhow::Result;
use bozzetto_core::file::{Model, Size, encode_smaller};
use bozzetto_core::lod::{Kept, keep_largest};
use bozzetto_core::mesh::TriangleMesh;

/// The size asked for.
#[derive(Debug, clap::Args)]
pub(super) struct SizeArgs {
    /// Keep this fraction of the wavelet coefficients, the largest after L2 normalisation.
    #[arg(long, value_name = "FRACTION", value_parser = fraction)]
    keep: Option<f64>,
    /// As much of the surface as a wavelet file of so many bytes holds.
    #[arg(long, value_name = "N", conflicts_with = "psnr")]
    bytes: Option<usize>,
    /// As little of the surface as is so near to the original: decibels, -20 log10 of the root mean square distance over
    /// the diagonal.
    #[arg(long, value_name = "D", value_parser = decibels)]
    psnr: Option<f64>,
}

impl SizeArgs {
    /// Whether a size is asked for.
    pub(super) fn is_given(&self) -> bool {
        self.bytes.is_some() || self.psnr.is_some()
    }

    /// Whether a share of the coefficients is to be kept.
    pub(super) fn keeps_some(&self) -> bool {
        self.keep.is_some()
    }

    /// Leaves the smallest coefficients out of a model, if that is asked for, and says what was kept.
    pub(super) fn keep(&self, model: &mut Model) -> Option<Kept> {
        let kept = keep_largest(&model.surface, self.keep?);
        let unknown = std::mem::take(&mut model.unknown);
        let metadata = std::mem::take(&mut model.metadata);
        *model = Model { unknown, ..Model::new(kept.surface.clone(), None, metadata) };
        Some(kept)
    }

    /// The size, if one is asked for; distances are those to a mesh.
    pub(super) fn to<'m>(&self, original: &'m TriangleMesh) -> Option<Size<'m>> {
        let near = self.psnr.map(|decibels| Size::Psnr(decibels, original));
        self.bytes.map(Size::Bytes).or(near)
    }

    /// The file of that size and the surface in it, if a size is asked for; distances are those to a mesh.
    ///
    /// # Errors
    /// There is no such file.
    pub(super) fn shrink(&self, model: &Model, original: &TriangleMesh) -> Result<Option<(Vec<u8>, Model)>> {
        Ok(self.to(original).map(|size| encode_smaller(model, size)).transpose()?)
    }
}

fn fraction(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|fraction| (0.0..=1.0).contains(fraction));
    parsed.ok_or_else(|| "give a fraction from 0 to 1".to_owned())
}

fn decibels(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|d: &f64| (0.0..=300.0).contains(d));
    parsed.ok_or_else(|| "give decibels from 0 to 300".to_owned())
}
