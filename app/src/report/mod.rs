//! The report of an import: one HTML file that holds everything it shows, pictures included.
//!
//! **Guarantees**: no part of it is fetched from elsewhere; names and sentences from files appear as text and nothing
//! else; where nothing can be drawn the report says so in place of the pictures and is whole otherwise.
//! **Non-guarantees**: pictures depend on the graphics driver.

mod charts;
mod html;
mod page;
mod pictures;
mod quality;

use crate::opening::{ImportOptions, Imported, MeshSource, Stage, error_map};
use anyhow::{Context, Result};
use bozzetto_core::mesh::{CompareOptions, Comparison, compare};
use pictures::Pictures;
use quality::{Angles, Valences};

/// What a report tells.
struct Report<'a> {
    source: &'a MeshSource,
    imported: &'a Imported,
    options: &'a ImportOptions,
    /// The name of the wavelet file written.
    output: String,
    comparison: Comparison,
    angles: [Angles; 2],
    valences: Valences,
    pictures: Pictures,
    seconds: Vec<(Stage, f64)>,
}

/// Writes the report of an import. Measures the distance where the import did not, and draws.
///
/// # Errors
/// The surfaces cannot be compared, or a picture cannot be drawn although there is an adapter.
pub(crate) fn report(
    source: &MeshSource,
    imported: &Imported,
    options: &ImportOptions,
    output: &str,
) -> Result<String> {
    let surface = &imported.model.surface;
    let finest = surface.to_mesh(surface.finest());
    let comparison = match imported.measured {
        Some(measured) => measured,
        None => compare(&source.mesh, &finest, &CompareOptions::default(), &|_| true)
            .with_context(|| source.name.clone())?,
    };
    let map = error_map(surface, &source.mesh, &|_, _| true)?;
    let base = surface.to_mesh(bozzetto_core::hierarchy::Level::BASE);
    let report = Report {
        source,
        imported,
        options,
        output: output.to_owned(),
        comparison,
        angles: [Angles::of(&finest), Angles::of(&base)],
        valences: Valences::of(surface.hierarchy().base()),
        pictures: Pictures::draw(source, surface, &map, options.conversion.tolerance)?,
        seconds: imported.seconds.clone(),
    };
    Ok(page::page(&report))
}
