//! Choosing files: the system's dialog behind a seam. The in-window path field is always there beside it.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// What a file is chosen for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To be read; with the endings that make sense.
    Read(&'static [&'static str]),
    /// To be written.
    Write(&'static [&'static str]),
}

/// Asks the user for a file, in the background.
pub trait FileChooser {
    /// Shows the dialog. `wake` is woken when there is an answer.
    fn ask(&mut self, purpose: Purpose, wake: &egui::Context);

    /// The answer, once: a path, or `None` if the user gave up or there is no dialog on this machine.
    fn answer(&mut self) -> Option<Option<PathBuf>>;
}

/// The system's own dialog.
#[derive(Debug, Default)]
pub struct SystemChooser {
    pending: Option<Receiver<Option<PathBuf>>>,
}

impl FileChooser for SystemChooser {
    fn ask(&mut self, purpose: Purpose, wake: &egui::Context) {
        // The future is made here, on the main thread, as macOS wants it, and awaited elsewhere.
        let dialog = rfd::AsyncFileDialog::new();
        let (Purpose::Read(endings) | Purpose::Write(endings)) = purpose;
        let dialog = dialog.add_filter("Surfaces", endings);
        let (sender, receiver) = channel();
        let wake = wake.clone();
        let answer = move |chosen: Option<rfd::FileHandle>| {
            let _ = sender.send(chosen.map(|file| file.path().to_owned()));
            wake.request_repaint();
        };
        match purpose {
            Purpose::Read(_) => {
                let chosen = dialog.pick_file();
                std::thread::spawn(move || answer(pollster::block_on(chosen)));
            }
            Purpose::Write(_) => {
                let chosen = dialog.save_file();
                std::thread::spawn(move || answer(pollster::block_on(chosen)));
            }
        }
        self.pending = Some(receiver);
    }

    fn answer(&mut self) -> Option<Option<PathBuf>> {
        let answer = match self.pending.as_ref()?.try_recv() {
            Ok(answer) => answer,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => None,
        };
        self.pending = None;
        Some(answer)
    }
}
