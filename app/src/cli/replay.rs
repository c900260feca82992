//! `bozzetto replay`: a script or log played onto a wavelet file, without a window.

use super::input::tell;
use super::output;
use super::progress::Progress;
use anyhow::{Context, Result, bail};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{Log, log_path, read_log};
use bozzetto_core::session::{LogUse, OpenOptions, Opened, Session, effective};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Play an edit script onto a wavelet file and write the result.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto replay assets/head.boz assets/sample.edits -o changed.boz")]
pub(super) struct Args {
    /// The wavelet file to start from.
    file: PathBuf,
    /// The script or log: one edit or control a line.
    script: PathBuf,
    /// The wavelet file to write, with its log beside it.
    #[arg(short, long)]
    output: PathBuf,
    /// Start from the file plus its own log.
    #[arg(long)]
    onto_log: bool,
    /// Write one file with the edits folded in, without a log.
    #[arg(long)]
    bake: bool,
    /// Take a log that names another wavelet file.
    #[arg(long)]
    rebind: bool,
    /// Use so many threads; the result does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// A file cannot be read, a line cannot be replayed, or the output cannot be written.
pub(super) fn run(args: &Args) -> Result<()> {
    if args.bake {
        output::check_lone_wavelet_file(&args.output)?;
    } else {
        check_pair(args)?;
    }
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads.into());
    }
    pool.build().context("the threads cannot be started; choose fewer with --threads")?.install(|| play(args))
}

/// Refuses an output whose log would take the place of something else: of the history of the file that is started from, or of a
/// log without its file. The script itself is kept, see [`keep_script`].
fn check_pair(args: &Args) -> Result<()> {
    output::check_wavelet_file(&args.output)?;
    let log = log_path(&args.output);
    let is_script = same_file(&log, &args.script);
    if log.exists() && !is_script && !args.onto_log && same_file(&args.output, &args.file) {
        bail!(
            "{}: the file's own log would be replaced; choose another output, or --onto-log to go on from it",
            log.display()
        );
    }
    if log.exists() && !is_script && !args.output.exists() {
        bail!("{}: a log without its wavelet file lies here; choose another name", log.display());
    }
    Ok(())
}

/// Keeps a script whose name the output's log takes, under the first name that is free, and says which.
///
/// # Errors
/// The copy cannot be written.
fn keep_script(args: &Args) -> Result<Option<PathBuf>> {
    if !same_file(&log_path(&args.output), &args.script) {
        return Ok(None);
    }
    let name = |number: u32| {
        let ending = if number == 1 { "script".to_owned() } else { format!("script{number}") };
        args.script.with_added_extension(ending)
    };
    let copy = (1..).map(name).find(|copy| !copy.exists()).expect("some name is free");
    output::replace(&copy, &Disk.read(&args.script)?)?;
    Ok(Some(copy))
}

/// Whether two paths lead to one file.
fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

fn play(args: &Args) -> Result<()> {
    let mut script = read_script(&args.script)?;
    let log = if args.onto_log { LogUse::Whole } else { LogUse::Ignored };
    let progress = Progress::new("Replaying");
    let options = OpenOptions { log, rebind: args.rebind };
    let report = |share| progress.report(share);
    let Opened { mut session, notes } = Session::open_detached(Arc::new(Disk), &args.file, options, &report)?;
    let own = session.original_hash().to_string();
    if let Some(of) = script.of.as_ref().filter(|of| **of != own) {
        if !args.rebind {
            bail!(
                "{} belongs to another wavelet file ({of}, not {own}); use its own file, or --rebind to apply it anyway",
                args.script.display()
            );
        }
        // The recorded hashes are those of the other surface.
        script.lines.iter_mut().for_each(|numbered| numbered.line.hash = None);
    }
    tell(notes);
    let edits = session
        .play(&effective(&script.lines, false), &report)
        .map_err(|e| anyhow::anyhow!("{}, {e}; correct or remove that line", args.script.display()))?;
    let mut kept = None;
    let hash = session.hash();
    if args.bake {
        session.into_copy(&args.output)?;
    } else {
        kept = keep_script(args)?;
        session.save_as(&args.output)?;
        session.close().map_err(anyhow::Error::msg)?;
    }
    drop(progress);
    if args.json {
        return output::print_json(&json!({ "hash": hash.to_string(), "edits": edits, "script": kept }));
    }
    let kept = kept.map_or(String::new(), |copy| {
        format!("{} is the output's log now; the script is in {}\n", args.script.display(), copy.display())
    });
    output::print(&format!("{edits} edits, hash {hash}\n{kept}"))
}

/// Reads a script; a bad line is an error that names it.
fn read_script(path: &Path) -> Result<Log> {
    let bytes = Disk
        .read(path)
        .map_err(|e| anyhow::anyhow!("{}: {e}; check the path and its permissions", path.display()))?;
    let log = read_log(&bytes, false);
    if let Some((line, what)) = &log.damage {
        bail!("{}, line {line}: {what}; correct or remove that line", path.display());
    }
    Ok(log)
}
