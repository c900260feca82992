//! A disk that fails at any one operation, in any way: nothing panics, the error names the file, and after a power cut
//! everything that was reported as on disk is there. What the checks are worth is shown by disks that cheat.

mod broken_disk;
mod memory_disk;
mod samples;

use bozzetto_core::disk::Vfs;
use bozzetto_core::file::{FileError, encode};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::{LogUse, OpenOptions, Session, SessionError, open_model};
use bozzetto_core::surface::SurfaceHash;
use bozzetto_core::wavelet::Wavelet;
use broken_disk::{FailingDisk, Fault, Plan, lines};
use memory_disk::MemoryDisk;
use samples::{Numbers, draw_edit, model};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

const FILE: &str = "work/bust.boz";
const LOG: &str = "work/bust.edits";
const OTHER: &str = "work/other.boz";
const OTHER_LOG: &str = "work/other.edits";
const COPY: &str = "work/copy.boz";

/// What a run did, as far as the program could know.
#[derive(Debug, Default)]
struct Report {
    /// The surface after 0, 1, … edits.
    states: Vec<SurfaceHash>,
    /// Edits made and reported as on disk in the first file's log.
    in_file: (usize, usize),
    /// The same for the other file, and whether it was reported as saved.
    in_other: (usize, usize),
    saved: Option<bool>,
    /// Whether the copy was reported as written, and after how many edits.
    copied: Option<(bool, usize)>,
    errors: Vec<String>,
}

/// A disk with two documents, each with two edits in its log.
fn two_documents() -> (MemoryDisk, [SurfaceHash; 2]) {
    let disk = MemoryDisk::default();
    let hashes = [(FILE, 1), (OTHER, 2)].map(|(file, seed)| {
        disk.put(file, &encode(&model(&shapes::octahedron(), Wavelet::Disc(0), 0, 1, seed)));
        let vfs = Arc::new(disk.clone());
        let mut session =
            Session::open(vfs, Path::new(file), OpenOptions::default(), &|_| true).expect("sound").session;
        for _ in 0..2 {
            session.edit(draw_edit(&mut Numbers(seed), session.surface())).expect("a modest edit");
        }
        let hash = session.hash();
        session.close().expect("sound");
        hash
    });
    (disk, hashes)
}

/// Open, five edits, save over the other document, save a copy, one more edit, close.
fn run(vfs: &FailingDisk) -> Report {
    let mut report = Report::default();
    let shared: Arc<dyn Vfs> = Arc::new(vfs.clone());
    let before = lines(&vfs.disk.bytes(LOG));
    let opened = Session::open(shared, Path::new(FILE), OpenOptions::default(), &|_| true);
    let mut session = match opened {
        Ok(opened) => opened.session,
        Err(error) => {
            report.errors.push(error.to_string());
            return report;
        }
    };
    let mut numbers = Numbers(3);
    report.states.push(session.hash());
    let mut edit = |session: &mut Session, report: &mut Report, log: &str, expected: usize| {
        session.edit(draw_edit(&mut numbers, session.surface())).expect("edits do not need the disk");
        report.states.push(session.hash());
        // Edits do not wait; the test does, so that every run has the same operations in the same order.
        let patience = Instant::now() + Duration::from_secs(10);
        while vfs.acknowledged(log) < expected && session.journal_failure().is_none() {
            assert!(Instant::now() < patience, "a committed edit is on disk within milliseconds");
            std::thread::yield_now();
        }
    };
    for at in 1..=5 {
        edit(&mut session, &mut report, LOG, before + at);
    }
    report.in_file = (5, vfs.acknowledged(LOG).saturating_sub(before));
    if let Some(failure) = session.journal_failure() {
        assert!(session.save().is_err(), "a save that is not on disk is no save");
        assert!(session.is_unsaved());
        report.errors.push(failure);
    }
    let saved = session.save_as(Path::new(OTHER));
    report.saved = Some(saved.is_ok());
    let mut log = LOG;
    match saved {
        Ok(()) => {
            assert!(!session.is_unsaved() && session.path() == Some(Path::new(OTHER)));
            report.in_other = (5, 5);
            log = OTHER_LOG;
        }
        Err(error) => {
            assert_eq!(session.path(), Some(Path::new(FILE)), "the session stays where it was");
            report.errors.push(error.to_string());
        }
    }
    let copied = session.save_copy(Path::new(COPY));
    report.copied = Some((copied.is_ok(), 5));
    report.errors.extend(copied.err().map(|e| e.to_string()));
    let expected = vfs.acknowledged(log) + 1;
    edit(&mut session, &mut report, log, expected);
    let more = usize::from(vfs.acknowledged(log) == expected);
    let place = if log == LOG { &mut report.in_file } else { &mut report.in_other };
    *place = (place.0 + 1, place.1 + more);
    report.errors.extend(session.close().err());
    report
}

/// Whether a document holds at least what was acknowledged, and nothing that was never made.
fn check_document(
    disk: &MemoryDisk,
    file: &str,
    states: &[SurfaceHash],
    (made, known): (usize, usize),
) -> Result<(), String> {
    let (model, _) =
        open_model(disk, Path::new(file), OpenOptions::default()).map_err(|e| format!("reading: {e}"))?;
    if !states[known..=made].contains(&model.surface.hash()) {
        return Err(format!("{file} lost an edit that was reported as on disk"));
    }
    let vfs = Arc::new(disk.clone());
    let opened = Session::open(vfs, Path::new(file), OpenOptions::default(), &|_| true);
    let mut session = opened.map_err(|e| format!("opening: {e}"))?.session;
    let (found, steps) = (session.hash(), session.steps());
    session.go_to(0);
    session.go_to(steps);
    if found == model.surface.hash() && session.hash() == found { Ok(()) } else { Err("other states".into()) }
}

/// Everything that must hold on what a power cut leaves.
fn check(
    disk: &MemoryDisk,
    plan: &Plan,
    report: &Report,
    [original, other]: [SurfaceHash; 2],
) -> Result<(), String> {
    let states = if report.states.is_empty() { vec![original] } else { report.states.clone() };
    check_document(disk, FILE, &states, report.in_file)?;
    match report.saved {
        Some(true) => check_document(disk, OTHER, &states, report.in_other)?,
        // The document is the old one, log and all. A disk that died in the middle may leave the new file with the
        // old log, which is refused, or the new one with its log.
        Some(false) | None => match open_model(disk, Path::new(OTHER), OpenOptions::default()) {
            Ok((model, _)) if model.surface.hash() == other => {}
            Err(SessionError::File(FileError::ForeignLog { .. })) if plan.fault != Fault::Once => {}
            Ok((model, _)) if plan.fault != Fault::Once && states.get(5) == Some(&model.surface.hash()) => {}
            Ok(_) => return Err("the other document is neither old nor refused".into()),
            Err(error) => return Err(format!("the other document: {error}")),
        },
    }
    match (report.copied, disk.exists(Path::new(COPY))) {
        (Some((true, _)), false) => return Err("the copy is gone".into()),
        (Some((_, at)), true) => {
            let copy = open_model(disk, Path::new(COPY), OpenOptions::default());
            let (copy, _) = copy.map_err(|e| format!("the copy: {e}"))?;
            if copy.surface.hash() != states[at] {
                return Err("the copy is another surface".into());
            }
        }
        _ => {}
    }
    Ok(())
}

/// One run with a fault, and all checks after power cuts that lose more or less.
fn try_fault(fault: Fault, at: usize) -> (Result<(), String>, usize, Option<PathBuf>, Report) {
    let (disk, hashes) = two_documents();
    let vfs = FailingDisk::new(&disk, fault, at);
    let report = run(&vfs);
    let plan = vfs.plan.lock().expect("no panic here");
    let outcome = [0.0, 0.4, 1.0].into_iter().try_for_each(|share| {
        check(&disk.after_power_cut(share), &plan, &report, hashes)
            .map_err(|e| format!("{fault:?} at operation {at}, {share} of the tail left: {e}"))
    });
    (outcome, plan.operations, plan.failed.clone(), report)
}

#[test]
fn whatever_fails_nothing_acknowledged_is_lost() {
    let (outcome, operations, failed, report) = try_fault(Fault::Once, usize::MAX);
    assert_eq!((outcome, failed, report.errors.len()), (Ok(()), None, 0), "nothing fails, nothing is wrong");
    assert_eq!((report.in_file, report.in_other), ((5, 5), (6, 6)));
    assert_eq!(operations, 4 + 10 + 7 + 1 + 2, "open, edits, save as, copy, edit");
    for fault in [Fault::Once, Fault::Dead, Fault::Torn, Fault::Late] {
        for at in 0..operations {
            let (outcome, _, failed, report) = try_fault(fault, at);
            outcome.unwrap_or_else(|e| panic!("{e}"));
            let failed = failed.expect("some operation failed").display().to_string();
            let first = report.errors.first().unwrap_or_else(|| panic!("{fault:?} at {at}: no error"));
            assert!(first.contains(&failed), "{fault:?} at {at}: {first:?} does not name {failed}");
            assert!(first.contains("the disk is broken") && !first.contains('\n'), "{first}");
        }
    }
}

/// The checks notice disks that cheat: a sync or a replacement that never reaches the disk, one that is not atomic.
#[test]
fn the_checks_notice_cheating_disks() {
    let (_, operations, ..) = try_fault(Fault::Once, usize::MAX);
    let noticed = |fault| (0..operations).filter(|&at| try_fault(fault, at).0.is_err()).count();
    let lost_sync = noticed(Fault::LostSync);
    assert_eq!(lost_sync, operations, "the last operation is a sync");
    // From operation 0 to the copy's.
    let lost_replace = noticed(Fault::LostReplace);
    assert_eq!(lost_replace, operations - 2);
    // Both of the other document's files; a broken copy is no more than an error.
    let broken_replace = noticed(Fault::BrokenReplace);
    assert!((2..=3).contains(&broken_replace), "{broken_replace}");
}

/// A surface without a file, saved under a name that is free: the file is there whole with its log, or not at all.
#[test]
fn a_new_name_is_taken_whole_or_not_at_all() {
    let save = |fault, at| {
        let disk = MemoryDisk::default();
        let vfs = FailingDisk::new(&disk, fault, at);
        let start = model(&shapes::tetrahedron(), Wavelet::Disc(1), 0, 1, 5);
        let mut session = Session::new(Arc::new(vfs.clone()), start);
        for seed in 0..3 {
            session
                .edit(draw_edit(&mut Numbers(seed), session.surface()))
                .expect("edits do not need the disk");
        }
        let (hash, saved) = (session.hash(), session.save_as(Path::new(FILE)));
        assert_eq!(session.is_unsaved(), saved.is_err());
        drop(session);
        let left = disk.after_power_cut(0.0);
        match open_model(&left, Path::new(FILE), OpenOptions::default()) {
            Ok((model, _)) => assert_eq!(model.surface.hash(), hash, "{fault:?} at {at}: whole"),
            Err(error) => {
                assert!(saved.is_err() && !left.exists(Path::new(FILE)), "{fault:?} at {at}: {error}");
                // A disk that works again keeps no log of a file that is not there.
                let lone = fault == Fault::Once && left.exists(&Path::new(FILE).with_extension("edits"));
                assert!(!lone, "at {at}: a log alone");
            }
        }
        // What is left does not stand in the way of saving again.
        let again = model(&shapes::octahedron(), Wavelet::Lazy, 0, 1, 6);
        let hash = again.surface.hash();
        Session::new(Arc::new(left.clone()), again).save_as(Path::new(FILE)).expect("a sound disk");
        let (model, _) = open_model(&left, Path::new(FILE), OpenOptions::default()).expect("saved again");
        assert_eq!(model.surface.hash(), hash);
        vfs.plan.lock().expect("no panic here").operations
    };
    let operations = save(Fault::Once, usize::MAX);
    assert_eq!(operations, 4, "lock, log, file, journal");
    for fault in [Fault::Once, Fault::Dead, Fault::Torn, Fault::Late] {
        for at in 0..operations {
            save(fault, at);
        }
    }
}

/// When a save returns, its mark and everything before it is on disk, or it says that it is not.
#[test]
fn a_save_is_on_disk_when_it_returns() {
    for fault in [Fault::Once, Fault::Dead, Fault::Torn, Fault::Late] {
        let mut failures = 0;
        for at in 4.. {
            let (disk, _) = two_documents();
            let vfs = FailingDisk::new(&disk, fault, at);
            let opened =
                Session::open(Arc::new(vfs.clone()), Path::new(FILE), OpenOptions::default(), &|_| true);
            let mut session = opened.expect("opening takes four operations").session;
            session.edit(draw_edit(&mut Numbers(7), session.surface())).expect("edits do not need the disk");
            let (hash, saved) = (session.hash(), session.save());
            assert_eq!(session.is_unsaved(), saved.is_err());
            // The power is cut before the session can do anything more.
            let left = disk.after_power_cut(0.0);
            let options = OpenOptions { log: LogUse::Saved, rebind: false };
            let (model, _) = open_model(&left, Path::new(FILE), options).expect("a sound log");
            match saved {
                Ok(()) => assert_eq!(model.surface.hash(), hash, "{fault:?} at {at}"),
                Err(error) => {
                    assert!(error.to_string().starts_with(LOG), "{error}");
                    failures += 1;
                }
            }
            if vfs.plan.lock().expect("no panic here").failed.is_none() {
                break;
            }
        }
        assert!(failures >= 2, "{fault:?}: the write and the sync at least");
    }
}
