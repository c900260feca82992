//! Importing for a small file: over which base mesh, at how many levels and with which wavelets a mesh takes the fewest
//! bytes at a distance, or comes nearest in so many bytes.
//!
//! How bytes depend on these is only known by trying. A search goes from an estimate to the best neighbour, then in smaller
//! steps, until none is better, so many surfaces were tried or so many faces were converted. It depends on nothing but the
//! input: times do not count. Each surface is drawn along itself until its detail lies along normals
//! ([`bozzetto_core::file::normal_mesh`]).

use super::{ImportOptions, Imported, MeshSource, Stage, import, import_if_kept};
use anyhow::{Result, anyhow};
use bozzetto_core::conversion::{ConversionOptions, Remesh};
use bozzetto_core::file::{Model, NoSuchFile, NotNormal, Size, encode, encode_smaller, normal_mesh};
use bozzetto_core::hierarchy::{FINEST_LEVEL, Slot};
use bozzetto_core::mesh::{CompareOptions, Comparison, TriangleMesh, compare};
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use std::cell::Cell;

/// The distance that a surface is chosen for where no size is asked for, in decibels: a 10,000th of the diagonal.
const DECIBELS: f64 = 80.0;
/// Base faces to begin with: of four scans between 60 and 80 dB the best number is between 60 and 200, and files over this
/// many are at most a twentieth larger.
const BASE_FACES: usize = 110;
/// Faces of the finest level for 60 dB; twice as many for 6 dB more. Finer levels cost little, coarser ones much.
const FACES_AT_60_DB: f64 = 7200.0;
/// Faces of the finest level that a byte is worth.
const FACES_PER_BYTE: usize = 4;
/// Faces converted by a search, those of the input counted each time; the first conversion takes what it takes.
const MOST_WORK: usize = 600_000;
/// Surfaces tried by a search.
const MOST_TRIED: usize = 8;
/// Faces of a surface for each of the input's: more have nothing to tell.
const MOST_FACES: usize = 16;
/// By how much base faces change from one attempt to the next, coarse steps first.
const RATIOS: [f64; 4] = [1.6, 1.26, 1.12, 1.06];
/// How many times as many base faces stand in for a level.
const FLATTER: f64 = 2.5;
/// Surfaces that are coarser than this take more bytes than finer ones: all of their detail.
const TOO_COARSE: f64 = 0.7;
/// Surfaces that are finer than this have levels of which nothing is held.
const TOO_FINE: f64 = 0.1;
/// A base mesh with so many hundredths of the faces aimed at has as few as it can have.
const FEWEST: usize = 115;

/// How much of an attempt the conversion is; the rest is straightening.
const CONVERTED: f32 = 0.6;

/// The best of a search.
#[derive(Debug)]
pub(crate) struct Compact {
    /// The import, its model what the file holds.
    pub(crate) imported: Imported,
    /// The choices made.
    pub(crate) options: ImportOptions,
    /// The file.
    pub(crate) bytes: Vec<u8>,
    /// How many surfaces were tried.
    pub(crate) tried: usize,
}

/// Imports a mesh as the best file of a size; without one, as the whole of the surface that is smallest at [`DECIBELS`], of
/// which every part is a small file. Of `options` base faces are a limit and levels are kept where they are given;
/// `wavelets` may take the place of the one there. A mesh with subdivision connectivity is tried as it is, too, unless it is
/// to be converted in any case. `progress` gets the share done and returns whether to go on.
///
/// # Errors
/// The mesh is not a surface, no file can be that small or that near, or `progress` asked to stop.
pub(crate) fn import_compact(
    source: &MeshSource,
    options: &ImportOptions,
    wavelets: &[Wavelet],
    asked: Option<Size>,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Compact> {
    let size = asked.unwrap_or(Size::Psnr(DECIBELS, &source.mesh));
    let mut search = Search {
        source,
        options,
        size,
        progress,
        tried: Vec::new(),
        work: 0,
        shown: Cell::new(0.0),
        fewest: 4,
        best: None,
    };
    search.run()?;
    let tried = search.tried.len();
    let best = search.best.expect("the first attempt fails or is kept");
    let (mut options, mut imported) = (best.options, best.imported);
    let mut found = match best.found {
        Err(_) if asked.is_none() => {
            let bytes = encode(&imported.model);
            return Ok(Compact { imported, options, bytes, tried });
        }
        found => found.map_err(|error| anyhow!("{}: {error}", source.name))?,
    };
    let tried_with = options.form.wavelet;
    for &wavelet in wavelets.iter().filter(|&&wavelet| wavelet != tried_with) {
        let form = FormOptions { wavelet, ..options.form.clone() };
        let other = in_form(&imported.model, &form).map(|model| Found::of(&model, size, &source.mesh));
        if let Some(Ok(other)) = other
            && other.rank > found.rank
        {
            (found, options.form) = (other, form);
        }
    }
    if asked.is_none() {
        if options.form.wavelet != tried_with {
            imported.model = in_form(&imported.model, &options.form).expect("it was made before");
        }
        let bytes = encode(&imported.model);
        return Ok(Compact { imported, options, bytes, tried });
    }
    let distance = found.distance(&source.mesh)?;
    imported.model = found.model;
    imported.distance = [distance.rms, distance.max];
    imported.measured = Some(distance);
    Ok(Compact { imported, options, bytes: found.bytes, tried })
}

/// The same surface drawn along itself until its detail lies along normals; as it is where its base mesh cannot have the
/// wavelets.
fn straightened(
    source: &MeshSource,
    mut imported: Imported,
    options: &ImportOptions,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<Imported> {
    let surface = &imported.model.surface;
    let hierarchy = surface.hierarchy().as_ref();
    let wavelet = options.form.wavelet;
    let positions = match normal_mesh(&source.mesh, hierarchy, &finest_positions(surface), wavelet, go_on) {
        Ok(positions) => positions,
        Err(NotNormal::Valence(_)) => return Ok(imported),
        Err(error) => return Err(anyhow!("{}: {error}", source.name)),
    };
    let surface = Surface::from_positions(hierarchy.clone(), &positions, &options.form)
        .map_err(|error| anyhow!("{}: {error}", source.name))?;
    let mesh = surface.to_mesh(surface.finest());
    let measured = compare(&source.mesh, &mesh, &CompareOptions::default(), &|_| go_on(1.0))
        .map_err(|error| anyhow!("{}: {error}", source.name))?;
    imported.model = Model::new(surface, None, source.metadata.clone());
    imported.distance = [measured.rms, measured.max];
    imported.measured = Some(measured);
    Ok(imported)
}

/// Model positions by slot of the finest level.
fn finest_positions(surface: &Surface) -> Vec<[f64; 3]> {
    let finest = surface.finest();
    (0..surface.scaling(finest).len() as u32).map(|v| surface.position(finest, Slot(v))).collect()
}

/// The same positions in another form; `None` if the base mesh cannot have it.
fn in_form(model: &Model, form: &FormOptions) -> Option<Model> {
    let surface = &model.surface;
    let positions = finest_positions(surface);
    let reformed = Surface::from_positions(surface.hierarchy().as_ref().clone(), &positions, form).ok()?;
    Some(Model::new(reformed, None, model.metadata.clone()))
}

/// How good an attempt is. Greater is better.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Rank {
    /// No file has the size; by how far it is from that.
    Missed(f64),
    /// A file has it; by how small or how near it is.
    Met(f64),
}

/// The file of a size that holds as much of a surface as it can.
#[derive(Debug)]
struct Found {
    bytes: Vec<u8>,
    model: Model,
    rank: Rank,
}

impl Found {
    fn of(model: &Model, size: Size, mesh: &TriangleMesh) -> Result<Self, NoSuchFile> {
        let (bytes, model) = encode_smaller(model, size)?;
        let mut found = Self { bytes, model, rank: Rank::Missed(f64::NEG_INFINITY) };
        found.rank = match size {
            Size::Psnr(..) => Rank::Met(-(found.bytes.len() as f64)),
            Size::Bytes(_) => found.distance(mesh).map_or(found.rank, |distance| Rank::Met(-distance.rms)),
        };
        Ok(found)
    }

    fn distance(&self, mesh: &TriangleMesh) -> Result<Comparison> {
        let surface = &self.model.surface;
        let held = surface.to_mesh(surface.finest());
        Ok(compare(mesh, &held, &CompareOptions::default(), &|_| true)?)
    }
}

fn rank(found: &Result<Found, NoSuchFile>) -> Rank {
    match found {
        Ok(found) => found.rank,
        Err(NoSuchFile::NotThatNear { best }) => Rank::Missed(*best),
        Err(NoSuchFile::TooSmall { least }) => Rank::Missed(-(*least as f64)),
    }
}

/// What is tried: base faces aimed at, and levels; or nothing of these, the connectivity that the mesh has.
type Place = Option<(usize, u8)>;

/// Steps from a place to its neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Finer,
    MoreFaces,
    FewerFaces,
    Coarser,
    /// One level less over more base faces.
    Flatter,
}

/// A place that was tried.
#[derive(Debug, Clone, Copy)]
struct Visit {
    place: (usize, u8),
    rank: Rank,
    /// How far the whole surface is from the mesh, over how far what a file holds of it is or should be.
    coarseness: f64,
}

#[derive(Debug)]
struct Attempt {
    imported: Imported,
    options: ImportOptions,
    found: Result<Found, NoSuchFile>,
    rank: Rank,
}

struct Search<'a> {
    source: &'a MeshSource,
    options: &'a ImportOptions,
    size: Size<'a>,
    progress: &'a dyn Fn(f32) -> bool,
    tried: Vec<Place>,
    /// Faces converted.
    work: usize,
    /// The share of the whole that was last said to be done.
    shown: Cell<f32>,
    /// Base faces below which there is no base mesh, as far as is known.
    fewest: usize,
    best: Option<Attempt>,
}

impl Search<'_> {
    fn run(&mut self) -> Result<()> {
        let asked = self.options.conversion;
        if asked.remesh != Remesh::Always {
            let go_on = |stage: Stage, done: f32| self.go_on(0.1 * stage.share(done));
            if let Some(kept) = import_if_kept(self.source, self.options, &go_on)? {
                self.keep(None, kept, self.options.clone());
            }
            if asked.remesh == Remesh::Never {
                return Ok(());
            }
        }
        let Some(mut here) = self.attempt(self.first())? else { return Ok(()) };
        for ratio in RATIOS {
            while let Some(better) = self.better_neighbour(here, ratio)? {
                here = better;
            }
        }
        Ok(())
    }

    /// The estimate.
    fn first(&self) -> (usize, u8) {
        let asked = self.options.conversion;
        let base_faces = asked.base_faces.map_or(BASE_FACES, |most| most.min(BASE_FACES)).max(4);
        let wanted = match self.size {
            Size::Bytes(bytes) => FACES_PER_BYTE.saturating_mul(bytes) as f64,
            Size::Psnr(decibels, _) => FACES_AT_60_DB * 10f64.powf((decibels - 60.0) / 20.0),
        };
        let enough = |levels: u8| finest(base_faces, levels) as f64 >= wanted;
        let too_many = |levels: u8| finest(base_faces, levels + 1) > self.most_faces();
        let free = || (1..8).find(|&levels| enough(levels) || too_many(levels)).unwrap_or(8);
        (base_faces, asked.levels.unwrap_or_else(free))
    }

    fn most_faces(&self) -> usize {
        MOST_FACES * self.source.mesh.faces.len()
    }

    /// Says how much is done, never less than before; whether to go on.
    fn go_on(&self, share: f32) -> bool {
        self.shown.set(self.shown.get().max(share.min(1.0)));
        (self.progress)(self.shown.get())
    }

    /// The best neighbour, if it is better.
    fn better_neighbour(&mut self, here: Visit, ratio: f64) -> Result<Option<Visit>> {
        let steps: &[Step] = match here.coarseness {
            much if much > TOO_COARSE => &[Step::Finer, Step::MoreFaces],
            little if little < TOO_FINE => &[Step::FewerFaces, Step::MoreFaces, Step::Coarser, Step::Flatter],
            _ => &[Step::MoreFaces, Step::FewerFaces, Step::Coarser, Step::Flatter, Step::Finer],
        };
        let mut better: Option<Visit> = None;
        for &step in steps {
            let Some(next) = self.neighbour(here.place, step, ratio) else { continue };
            if let Some(there) = self.attempt(next)?
                && there.rank > better.unwrap_or(here).rank
            {
                better = Some(there);
            }
        }
        Ok(better)
    }

    fn neighbour(&self, (base_faces, levels): (usize, u8), step: Step, ratio: f64) -> Option<(usize, u8)> {
        let asked = self.options.conversion;
        let most = asked.base_faces.unwrap_or(usize::MAX);
        let free = asked.levels.is_none();
        let times = |ratio: f64| (base_faces as f64 * ratio).round() as usize;
        match step {
            Step::Finer => (free && levels < FINEST_LEVEL).then_some((base_faces, levels + 1)),
            Step::Coarser => (free && levels > 1).then(|| (base_faces, levels - 1)),
            Step::Flatter => (free && levels > 1).then(|| (times(FLATTER).min(most), levels - 1)),
            Step::MoreFaces => Some((times(ratio).max(self.fewest).min(most), levels)),
            Step::FewerFaces => Some((times(1.0 / ratio), levels)).filter(|&(fewer, _)| fewer >= self.fewest),
        }
    }

    /// Converts at a place and keeps the result if it is the best; `None` if that was tried before, takes too long or, but
    /// for the first, cannot be done.
    fn attempt(&mut self, place: (usize, u8)) -> Result<Option<Visit>> {
        let (base_faces, levels) = place;
        let work = finest(base_faces, levels).saturating_add(self.source.mesh.faces.len());
        let first = self.best.is_none();
        let too_much = self.work + work > MOST_WORK
            || self.tried.len() >= MOST_TRIED
            || finest(base_faces, levels) > self.most_faces();
        if self.tried.contains(&Some(place)) || (!first && too_much) {
            return Ok(None);
        }
        let total = MOST_WORK.max(work) as f32;
        let (stopped, furthest) = (Cell::new(false), Cell::new(0.0f32));
        // Some stages are gone through more than once.
        let go_on = |done: f32| {
            furthest.set(furthest.get().max(done));
            let (before, of_all) = (self.work as f32 / total, self.tried.len() as f32 / MOST_TRIED as f32);
            let share = (before + work as f32 * furthest.get() / total)
                .max(of_all + furthest.get() / MOST_TRIED as f32);
            stopped.set(stopped.get() || !self.go_on(0.1 + 0.9 * share));
            !stopped.get()
        };
        let conversion = ConversionOptions {
            base_faces: Some(base_faces),
            levels: Some(levels),
            remesh: Remesh::Always,
            ..self.options.conversion
        };
        let options = ImportOptions { conversion, form: self.options.form.clone() };
        let imported = import(self.source, &options, &|stage, done| go_on(CONVERTED * stage.share(done)))
            .and_then(|imported| {
                straightened(self.source, imported, &options, &|done| {
                    go_on(CONVERTED + (1.0 - CONVERTED) * done)
                })
            });
        self.work += work;
        match imported {
            Err(error) if first || stopped.get() => Err(error),
            Err(_) => {
                self.tried.push(Some(place));
                Ok(None)
            }
            Ok(imported) => {
                let (rank, coarseness) = self.keep(Some(place), imported, options);
                Ok(Some(Visit { place, rank, coarseness }))
            }
        }
    }

    /// Takes an import into account; how good it is, and how coarse.
    fn keep(&mut self, place: Place, imported: Imported, options: ImportOptions) -> (Rank, f64) {
        let faces = imported.model.surface.hierarchy().base().faces().len();
        if place.is_some_and(|(aimed, _)| 100 * faces > FEWEST * aimed) {
            self.fewest = self.fewest.max(faces);
        }
        self.tried.push(place);
        let found = Found::of(&imported.model, self.size, &self.source.mesh);
        let rank = rank(&found);
        let aimed = match (self.size, rank) {
            (Size::Psnr(decibels, _), _) => 10f64.powf(-decibels / 20.0),
            (Size::Bytes(_), Rank::Met(distance)) => -distance,
            (Size::Bytes(_), Rank::Missed(_)) => f64::INFINITY,
        };
        let coarseness = imported.distance[0] / aimed;
        if self.best.as_ref().is_none_or(|best| rank > best.rank) {
            self.best = Some(Attempt { imported, options, found, rank });
        }
        (rank, coarseness)
    }
}

/// Faces of the finest level.
fn finest(base_faces: usize, levels: u8) -> usize {
    base_faces.saturating_mul(1 << (2 * levels))
}

#[cfg(test)]
mod tests;
