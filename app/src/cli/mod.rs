//! The command line: one file per command.
//!
//! Every command prints its result on stdout (with `--json` one object and nothing else), notes and progress on
//! stderr, and replaces its output in one step or not at all. Exit status: 0, 1 failed, 2 bad arguments.

mod bake;
mod bench;
mod coefficients;
mod compare;
mod export;
mod form;
mod globe;
mod import;
mod info;
mod input;
mod output;
mod progress;
mod render;
mod replay;
mod size;
mod verify;

pub use input::{Loaded, load};
pub use progress::Progress;

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// Multiresolution sculpting: open a surface, pick a level, drag.
#[derive(Debug, Parser)]
#[command(
    name = "bozzetto",
    version,
    about,
    args_conflicts_with_subcommands = true,
    after_help = "Example: bozzetto assets/head.boz"
)]
pub struct Cli {
    /// The wavelet file or mesh to open in the editor; without one, the sample.
    file: Option<PathBuf>,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Import(import::Args),
    Globe(globe::Args),
    Info(info::Args),
    Coefficients(coefficients::Args),
    Export(export::Args),
    Compare(compare::Args),
    Replay(replay::Args),
    Bake(bake::Args),
    Verify(verify::Args),
    Render(render::Args),
    Bench(bench::Args),
}

/// Parses the arguments, does what they ask, and gives the exit status.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match cli.command {
        None => crate::editor::run(cli.file),
        Some(Command::Import(args)) => import::run(&args),
        Some(Command::Globe(args)) => globe::run(&args),
        Some(Command::Info(args)) => info::run(&args),
        Some(Command::Coefficients(args)) => coefficients::run(&args),
        Some(Command::Export(args)) => export::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Replay(args)) => replay::run(&args),
        Some(Command::Bake(args)) => bake::run(&args),
        Some(Command::Verify(args)) => verify::run(&args),
        Some(Command::Render(args)) => render::run(&args),
        Some(Command::Bench(args)) => bench::run(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", sentence(&error));
            ExitCode::FAILURE
        }
    }
}

/// An error and its causes in one line. Causes that a message already tells are not told twice.
fn sentence(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for message in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = message;
        } else if !text.contains(&message) {
            text = format!("{text}: {message}");
        }
    }
    text.replace(char::is_control, " ")
}
