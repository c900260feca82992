//! How long strokes take: every brush on a sphere of a million vertices, its relief made of many sizes.
//!
//! ```text
//! cargo run --release -p bozzetto-core --example strokes [LEVELS] [SECONDS]
//! ```
//!
//! Dabs are timed by the processor time of the whole program, so that other programs do not count; a drag's steps, levels
//! and undos by the clock too. What a window prepares for the graphics card is timed by
//! `cargo run -p bozzetto --example followed`.

use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Dab, Kind, Move, Over, Pull, Stroke, Tool};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use std::sync::Arc;
use std::time::Instant;

fn sphere(levels: u8) -> Surface {
    Surface::ball(levels, |q| {
        let wave = |f: f64| (f * q[0]).sin() * (f * q[1]).sin() * (f * q[2]).sin() / f;
        1.0 + wave(7.0) + wave(31.0) + wave(200.0)
    })
}

/// Milliseconds of the clock and of the processor.
#[derive(Debug, Clone, Copy)]
struct Took {
    clock: f64,
    cpu: f64,
}

#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Elsewhere the clock has to do.
#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    std::time::UNIX_EPOCH.elapsed().map_or(0.0, |since| since.as_secs_f64())
}

fn timed<T>(times: &mut Vec<Took>, work: impl FnOnce() -> T) -> T {
    let (begun, cpu) = (Instant::now(), cpu_seconds());
    let result = work();
    times.push(Took { clock: begun.elapsed().as_secs_f64() * 1e3, cpu: (cpu_seconds() - cpu) * 1e3 });
    result
}

fn at(times: &[Took], share: f64, of: fn(&Took) -> f64) -> f64 {
    let mut sorted: Vec<f64> = times.iter().map(of).collect();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// A row: median and 99th percentile of the processor's time, and of the clock's.
fn report(name: &str, times: &[Took], more: &str) {
    if times.is_empty() {
        return;
    }
    let [median, p99] = [0.5, 0.99].map(|share| at(times, share, |t| t.cpu));
    let [wall, wall99] = [0.5, 0.99].map(|share| at(times, share, |t| t.clock));
    println!("{name:<34} cpu {median:8.3} {p99:8.3} ms   clock {wall:8.3} {wall99:8.3} ms   {more}");
}

fn words(tool: Tool, level: u8) -> Stroke {
    Stroke {
        tool,
        level,
        radius: 0.05,
        strength: 0.5,
        falloff: None,
        mirror: None,
        to: None,
        from: Some([-1.0, 0.2, 0.1]),
        dabs: Vec::new(),
        v: tool.latest_version(),
    }
}

/// Strokes of all brushes on a fine and a coarse level, one after another, for so many seconds.
fn strokes(session: &mut Session, seconds: f64) {
    let finest = session.surface().finest();
    let kinds: Vec<(Tool, u8)> = Tool::ALL
        .into_iter()
        .flat_map(|tool| [finest.0, finest.0.saturating_sub(3)].map(|level| (tool, level)))
        .collect();
    let mut of_kind: Vec<Vec<Took>> = vec![Vec::new(); kinds.len()];
    let (mut ends, mut undos, mut bytes, mut count) = (Vec::new(), Vec::new(), 0, 0);
    let begun = Instant::now();
    while begun.elapsed().as_secs_f64() < seconds || count < kinds.len() {
        let (kind, round) = (count % kinds.len(), (count / kinds.len()) as f64);
        let (tool, level) = kinds[kind];
        session.begin_brush(words(tool, level)).expect("a sensible stroke");
        for dab in 0..80 {
            let turn = f64::from(dab) * 0.0125 + round + 0.3 * kind as f64;
            let place = [turn.cos(), (0.37 * round + 0.1 * kind as f64) % 1.4 - 0.7, turn.sin()];
            timed(&mut of_kind[kind], || session.dab(Dab::new(place)).expect("in range"));
        }
        timed(&mut ends, || session.end_stroke());
        bytes += session.history().last().map_or(0, |e| serde_json::to_string(&e).expect("data").len() + 20);
        timed(&mut undos, || session.undo());
        count += 1;
    }
    println!("{count} strokes of 80 dabs; median and 99th percentile:");
    for ((tool, level), times) in kinds.iter().zip(&of_kind) {
        report(&format!("{} at level {level}", tool.name()), times, "");
    }
    report("all dabs", &of_kind.concat(), "goal: 1 and 4 ms");
    report("end of a stroke", &ends, "");
    report("undo of a stroke", &undos, "goal: 16 ms");
    let growth = bytes as f64 / count as f64 * 20.0 / 1e6;
    println!("log growth of 20 strokes           {growth:.3} MB   goal: 1 MB");
    println!("history in memory                  {:.1} MB", session.history_in_memory() as f64 / 1e6);
}

/// Steps of a drag: a handle of the base mesh that follows takes seconds each where nothing is previewed.
const STEPS: u32 = 9;

/// Up to where a drag goes.
#[derive(Debug, Clone, Copy)]
enum Reach {
    Whole,
    /// As the window does.
    Affordable,
    Coarser(u8),
}

fn handle(session: &mut Session, name: &str, reach: Reach) {
    let mut steps = Vec::new();
    let finest = session.surface().finest();
    let affordable = session.affordable_reach().expect("a drag is under way");
    let (level, shown) = match reach {
        Reach::Whole => (finest, "whole".to_owned()),
        Reach::Affordable => (affordable, format!("on level {affordable}, as in the window   goal: 16 ms")),
        Reach::Coarser(by) => {
            let level = Level(finest.0.saturating_sub(by));
            (level, format!("preview on level {level}"))
        }
    };
    session.preview_stroke(level);
    for step in 1..=STEPS {
        let delta = [0.01 * f64::from(step), 0.0, 0.0];
        timed(&mut steps, || session.drag_to(delta).expect("in range"));
    }
    session.cancel_stroke();
    report(name, &steps, &shown);
}

/// The steps of handles of level 0: whole, as far as the window lets them go, and previewed on coarser levels.
fn handles(session: &mut Session) {
    let raw = Move {
        kind: Kind::Scaling,
        level: 0,
        vertex: 2,
        delta: [0.0; 3],
        radius: None,
        falloff: None,
        mirror: None,
        v: 1,
    };
    let pull = Pull::of(Kind::Scaling, 0, 2, [0.0; 3]);
    for reach in [Reach::Whole, Reach::Affordable].into_iter().chain((1..5).map(Reach::Coarser)) {
        session.begin_stroke(raw).expect("it exists");
        handle(session, "handle of level 0, raw", reach);
        session.begin_pull(pull).expect("it exists");
        handle(session, "handle of level 0, smooth", reach);
        session.begin_pull(Pull { follow: true, ..pull }).expect("it exists");
        handle(session, "handle of level 0, smooth + follow", reach);
    }
}

/// The equaliser's steps: whole, and previewed two levels coarser.
fn equaliser(session: &mut Session) {
    let finest = session.surface().finest();
    for reach in [finest, Level(finest.0 - 2)] {
        session.begin_equaliser(Over::All).expect("it has wavelets");
        let mut steps = Vec::new();
        for step in 1..20 {
            let gains = [1.0, 1.0, 1.0, 1.0 + 0.02 * f64::from(step)];
            timed(&mut steps, || session.set_gains(&gains, reach).expect("in range"));
        }
        session.cancel_stroke();
        report("equaliser, gain of level 3", &steps, &format!("up to level {reach}"));
    }
    session.begin_equaliser(Over::All).expect("it has wavelets");
    session.set_gains(&[1.0, 1.0, 1.0, 1.5], finest).expect("in range");
    let (mut end, mut undo) = (Vec::new(), Vec::new());
    timed(&mut end, || session.end_stroke());
    timed(&mut undo, || session.undo());
    report("equaliser's end", &end, "");
    report("equaliser's undo", &undo, "");
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let levels = arguments.next().map_or(9, |x| x.parse().expect("a number of levels"));
    let seconds = arguments.next().map_or(60.0, |x| x.parse().expect("a number of seconds"));
    let surface = sphere(levels);
    println!("{} vertices", surface.scaling(surface.finest()).len());
    let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    session.surface().nearest([0.0; 3]);
    strokes(&mut session, seconds);
    handles(&mut session);
    equaliser(&mut session);
}
