//! `bozzetto coefficients`: every coefficient of a wavelet file as a row of a table.

use super::input::{LogArgs, load_model};
use super::output;
use anyhow::{Result, bail};
use bozzetto_core::file::Model;
use bozzetto_core::hierarchy::{Level, Odd, Slot};
use std::fmt::Write;
use std::path::PathBuf;

/// Write all scaling and wavelet coefficients as CSV, in model units.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto coefficients assets/head.boz --csv head.csv")]
pub(super) struct Args {
    /// The wavelet file.
    file: PathBuf,
    /// The table to write.
    #[arg(long, value_name = "OUT.csv")]
    csv: PathBuf,
    #[command(flatten)]
    log: LogArgs,
}

/// Runs the command.
///
/// # Errors
/// The file cannot be read or the table not written.
pub(super) fn run(args: &Args) -> Result<()> {
    if args.csv.extension().is_none_or(|e| !e.eq_ignore_ascii_case("csv")) {
        bail!("{}: tables are CSV files; let the name end in .csv", args.csv.display());
    }
    output::check(&args.csv)?;
    let model = load_model(&args.file, args.log.options())?;
    output::replace(&args.csv, table(&model).as_bytes())
}

/// The table: scaling coefficients of level 0, then the wavelets level by level, by public id.
pub(super) fn table(model: &Model) -> String {
    let surface = &model.surface;
    let placement = &surface.form().placement;
    let sources = model.source.as_ref().map(|source| source.unpacked());
    let source = |id: u32| sources.as_ref().map_or(String::new(), |s| s[id as usize].to_string());
    let mut csv = String::from("kind,level,vertex,parent_a,parent_b,source,x,y,z\n");
    let mut row = |kind: &str, level: Level, id: u32, parents: [String; 2], [x, y, z]: [f64; 3]| {
        let [a, b] = parents;
        writeln!(csv, "{kind},{level},{id},{a},{b},{},{x},{y},{z}", source(id)).expect("strings grow");
    };
    for (slot, _) in surface.scaling(Level::BASE).iter().enumerate() {
        let position = surface.position(Level::BASE, Slot(slot as u32));
        row("scaling", Level::BASE, slot as u32, [String::new(), String::new()], position);
    }
    for level in (0..surface.finest().0).map(Level) {
        let layout = surface.hierarchy().layout(level);
        for (at, &detail) in surface.wavelets(level).iter().enumerate() {
            let odd = Odd(at as u32);
            let mut parents = layout.parents(layout.odd_site(odd)).map(|p| layout.public_id(p));
            parents.sort_unstable();
            let id = surface.wavelet_id(level, odd).0;
            row("wavelet", level, id, parents.map(|p| p.to_string()), placement.vector_to_model(detail));
        }
    }
    csv
}
