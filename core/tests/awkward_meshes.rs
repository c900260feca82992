//! Any mesh converts or is refused in a sentence: a table of awkward ones, and random damage.
//!
//! `BOZZETTO_SOAK=COUNT cargo test --release -p bozzetto-core --test awkward_meshes -- --ignored --nocapture` damages many more,
//! from the seed `BOZZETTO_SEED` on; `scripts/soak` does that.

mod awkward;
mod samples;

use awkward::shapes::{Fate, all};
use awkward::{Outcome, damage, import};
use bozzetto_core::conversion::ConversionOptions;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

#[test]
fn awkward_meshes_convert_or_are_refused_in_a_sentence() {
    let mut broken = Vec::new();
    for (name, mesh, fate) in all() {
        let start = Instant::now();
        let outcome =
            catch_unwind(AssertUnwindSafe(|| import(&mesh, &ConversionOptions::default(), &|_, _| true)));
        let seconds = start.elapsed().as_secs_f64();
        println!("{name} ({} faces, {seconds:.2} s): {outcome:?}", mesh.faces.len());
        let as_fated = match (&outcome, fate) {
            (Ok(Outcome::Converted(figures)), Fate::Surface(topology)) => figures.topology == topology,
            (Ok(Outcome::Converted(_)), Fate::Something) => true,
            (Ok(Outcome::Refused(sentence)), Fate::Refused(part)) => sentence.contains(part),
            _ => false,
        };
        if !as_fated {
            broken.push(format!("{name}: {outcome:?}, expected {fate:?}"));
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// What became of a damaged mesh.
#[derive(Debug)]
enum Run {
    /// It converted, or was refused in this sentence.
    Done(Option<String>),
    /// It took longer than [`LONGEST`].
    Slow(f64),
    /// A promise was broken, or something panicked.
    Panicked(String),
}

/// What a conversion of a small mesh may take in release, many times over: by the clock, or by the processors where others
/// keep them busy.
const LONGEST: Duration = Duration::from_secs(10);

/// What the processors have spent on this program.
#[cfg(unix)]
fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Elsewhere the clock has to do.
#[cfg(not(unix))]
fn processor_time() -> Duration {
    std::time::UNIX_EPOCH.elapsed().unwrap_or_default()
}

/// Converts the mesh of a seed.
fn run(seed: u64) -> Run {
    let (mesh, options) = damage::case(seed);
    let (start, busy) = (Instant::now(), processor_time());
    let outcome = catch_unwind(AssertUnwindSafe(|| import(&mesh, &options, &|_, _| true)));
    let seconds = start.elapsed().min(processor_time().saturating_sub(busy));
    match outcome {
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            Run::Panicked(text.unwrap_or_default())
        }
        Ok(_) if seconds > LONGEST => Run::Slow(seconds.as_secs_f64()),
        Ok(Outcome::Converted(_)) => Run::Done(None),
        Ok(Outcome::Refused(sentence)) => Run::Done(Some(sentence)),
    }
}

#[test]
fn damaged_meshes_convert_or_are_refused_in_a_sentence() {
    for seed in 0..20 {
        println!("seed {seed}");
        if let Run::Panicked(text) = run(seed) {
            panic!("seed {seed}: {text}");
        }
    }
}

fn number(variable: &str, usual: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// One line a seed into the file `BOZZETTO_SUMMARY`: `ok`, the refusal, `SLOW` or `PANIC`. Fails if there was one of the last
/// two.
#[test]
#[ignore = "takes minutes; scripts/soak runs it"]
fn many_damaged_meshes_convert_or_are_refused_in_a_sentence() {
    let (first, count) = (number("BOZZETTO_SEED", 0), number("BOZZETTO_SOAK", 1000));
    let path = std::env::var("BOZZETTO_SUMMARY").unwrap_or_else(|_| "soak.txt".to_owned());
    let summary = std::fs::OpenOptions::new().create(true).append(true).open(&path);
    let mut summary = summary.unwrap_or_else(|error| panic!("{path}: {error}"));
    let (mut refused, mut bad) = (0, Vec::new());
    for seed in first..first + count {
        // Before the run, so that a seed that hangs is known.
        write!(summary, "{seed} ").expect("the summary is written");
        let outcome = run(seed);
        let text = match &outcome {
            Run::Done(None) => "ok".to_owned(),
            Run::Done(Some(sentence)) => format!("refused: {sentence}"),
            Run::Slow(seconds) => format!("SLOW {seconds:.1} s"),
            Run::Panicked(text) => format!("PANIC {}", text.replace('\n', " ")),
        };
        writeln!(summary, "{text}").expect("the summary is written");
        match outcome {
            Run::Done(sentence) => refused += u64::from(sentence.is_some()),
            Run::Slow(_) | Run::Panicked(_) => bad.push(format!("seed {seed}: {text}")),
        }
        if (seed + 1 - first).is_multiple_of(50) {
            println!("{} of {count}: {refused} refused, {} bad", seed + 1 - first, bad.len());
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
