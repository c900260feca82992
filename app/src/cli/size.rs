//! How small a result is to be: arguments shared by `import` and `export`.

use anyhow::Result;
use bozzetto_core::file::{Model, Size, encode_smaller};
use bozzetto_core::mesh::TriangleMesh;

/// The size asked for.
#[derive(Debug, clap::Args)]
pub(super) struct SizeArgs {
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

fn decibels(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|d: &f64| (0.0..=300.0).contains(d));
    parsed.ok_or_else(|| "give decibels from 0 to 300".to_owned())
}
