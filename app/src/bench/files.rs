//! Import of a subdivided mesh, opening and saving.

use super::timings::Timings;
use crate::opening::{ImportOptions, import_file_alone};
use anyhow::{Result, ensure};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{Metadata, Model, encode};
use bozzetto_core::io::{MeshFormat, write_mesh};
use bozzetto_core::session::{OpenOptions, open_model};
use bozzetto_core::surface::Surface;
use std::fs::File;

/// Seconds, medians; and the size of the wavelet file.
pub(super) struct FileFigures {
    /// A binary PLY with subdivision connectivity to a surface.
    pub(super) import: f64,
    /// A surface to a wavelet file on disk.
    pub(super) save: f64,
    /// A wavelet file to a surface.
    pub(super) open: f64,
    pub(super) bytes: u64,
}

/// Measures them with files in a folder of their own for temporary files.
///
/// # Errors
/// The folder cannot be written to.
pub(super) fn files(surface: Surface, runs: usize, done: &dyn Fn(f32)) -> Result<FileFigures> {
    let folder = tempfile::tempdir()?;
    let (ply, boz) = (folder.path().join("ball.ply"), folder.path().join("ball.boz"));
    let finest = surface.finest();
    write_mesh(&surface.to_mesh(finest), MeshFormat::Ply, &mut File::create(&ply)?)?;
    let model = Model::new(surface, None, Metadata::default());
    let (mut import, mut save, mut open) = (Timings::default(), Timings::default(), Timings::default());
    for run in 0..runs {
        done(run as f32 / runs as f32);
        save.time(|| Disk.replace(&boz, &encode(&model)))?;
        let (opened, _) = open.time(|| open_model(&Disk, &boz, OpenOptions::default()))?;
        ensure!(
            opened.surface.hash() == model.surface.hash(),
            "what was saved reads back otherwise; report this as a defect"
        );
        drop(opened);
        let imported = import.time(|| import_file_alone(&ply, &ImportOptions::default(), &|_, _| true))?;
        ensure!(
            imported.model.surface.finest() == finest,
            "the subdivision was not found; report this as a defect"
        );
    }
    let bytes = std::fs::metadata(&boz)?.len();
    Ok(FileFigures { import: import.median(), save: save.median(), open: open.median(), bytes })
}

#[cfg(test)]
mod tests {
    use super::super::shape::Base;
    use super::*;

    #[test]
    fn files_are_written_and_read_back() {
        let figures = files(Base::EightFaces.surface(3).expect("small"), 2, &|_| {}).expect("there is room");
        assert!(figures.bytes > 500);
        assert!([figures.import, figures.save, figures.open].iter().all(|s| *s > 0.0));
    }
}
