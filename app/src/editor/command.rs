//! What panels and tools ask for. One place, `execute`, carries it out.

use super::choices::ImportChoices;
use super::dialog::Dialog;
use super::preview::PreviewView;
use super::settings::{Hand, Navigation};
use crate::render::{Shading, View};
use bozzetto_core::edit::{Edit, Falloff, Kind, Over, Spread, Tool};
use bozzetto_core::hierarchy::PublicId;
use glam::{DVec2, DVec3};
use std::path::PathBuf;

/// A request.
#[derive(Debug, Clone)]
pub enum Command {
    // Documents
    /// Shows a dialog.
    Ask(Dialog),
    /// Closes the dialog.
    CloseDialog,
    /// Shows the system's file dialog for the dialog's path field.
    Browse,
    /// Opens a wavelet file or mesh; a mesh without subdivision connectivity asks how to convert it.
    Open(PathBuf),
    /// Asks how to convert the open surface again.
    AskRemesh,
    /// Converts a mesh, to look at the result before it is opened.
    Convert(Box<ImportChoices>),
    /// Looks at something else of the preview.
    LookAt(PreviewView),
    /// Opens what is previewed.
    CommitImport,
    /// Goes from the preview back to the choices.
    ChangeImport,
    /// Gives an import up; the open surface is as it was.
    CancelImport,
    /// Carries a command out although edits without a file are lost by it.
    Anyway(Box<Command>),
    /// Adds a save mark; asks for a name where there is none.
    Save,
    /// Saves under another name and goes on there.
    SaveAs(PathBuf),
    /// Writes one baked file.
    SaveCopy(PathBuf),
    /// Writes a level as a mesh.
    Export(PathBuf, u8),
    /// Closes the window, asking first if something is unsaved.
    Quit,
    /// Closes the window; the log keeps the edits.
    QuitKeeping,
    /// Closes the window and takes back everything since the last save.
    QuitDiscarding,
    /// Gives up the work under way.
    CancelWork,
    /// Takes the message away.
    DismissBanner,

    // Edits
    /// Makes an edit.
    Edit(Edit),
    /// Undoes a step.
    Undo,
    /// Redoes a step.
    Redo,
    /// Goes to a place in the history.
    GoTo(usize),
    /// Begins dragging a coefficient.
    BeginStroke {
        /// The coefficient.
        kind: Kind,
        /// Its level.
        level: u8,
        /// Its id.
        vertex: PublicId,
    },
    /// Begins dragging a place of the surface, in drawing space.
    BeginGrab(DVec3),
    /// Begins a brush stroke: what it does, and whether the other way round.
    BeginBrush(Tool, bool),
    /// Touches with the brush at a place in drawing space, with a pen's pressure if there is one.
    Dab(DVec3, Option<f64>),
    /// Moves the stroke to a delta, in drawing space.
    DragTo(DVec3),
    /// Ends the stroke.
    EndStroke,
    /// Takes the stroke back.
    CancelStroke,
    /// Chooses the gain of a level's detail, live.
    SetGain(u8, f64),
    /// Chooses where the equaliser acts.
    SetOver(Over),
    /// Makes the gains chosen an edit.
    EndEqualiser,
    /// Takes the gains chosen back.
    CancelEqualiser,

    // What is worked on
    /// Chooses scaling or wavelet coefficients.
    SetKind(Kind),
    /// Chooses the edited level.
    SetLevel(u8),
    /// Chooses the shown level.
    SetShown(u8),
    /// Chooses the reach of a move: 0 for one coefficient, else a fraction of the model's radius.
    SetRadius(f64),
    /// Chooses how a move fades.
    SetFalloff(Falloff),
    /// Takes something into the hand.
    Take(Hand),
    /// Chooses the brush's radius as a fraction of the model's.
    SetBrushRadius(f64),
    /// Chooses the brush's strength.
    SetStrength(f64),
    /// Switches the mirror plane across an axis.
    ToggleSymmetry(usize),
    /// Chooses how handles bend finer levels.
    SetSpread(Spread),
    /// Switches whether finer detail follows.
    ToggleFollow,
    /// Chooses the finest level of detail that erasing takes; none: the last.
    SetEraseTo(Option<u8>),
    /// Switches whether the radius chooses the level.
    ToggleAutoLevel,
    /// Chooses how far the brush trails behind the cursor.
    SetSteady(f64),
    /// Switches what a pen's pressure acts on: strength, radius.
    TogglePressure(bool),
    /// Chooses how the mouse moves the camera.
    SetNavigation(Navigation),
    /// Shows or hides the inspector.
    ToggleInspector,
    /// Takes the mask away.
    ClearMask,
    /// Looks at where the last stroke was.
    FrameStroke,
    /// Selects a coefficient, or none.
    Select(Option<PublicId>),

    // What is seen
    /// Looks from a named side.
    Look(View),
    /// Fits the surface into the picture.
    Fit,
    /// Turns the camera by points dragged.
    Orbit(DVec2),
    /// Slides the camera by points dragged.
    Pan(DVec2),
    /// Comes nearer (below 1) or goes away, towards a point of the picture.
    Zoom(f64, DVec2),
    /// Chooses the shading.
    SetShading(Shading),
    /// Switches an overlay.
    Toggle(Overlay),
}

impl Command {
    /// Whether it leaves gains under the hand as they are; everything else makes an edit of them first.
    pub fn leaves_equaliser(&self) -> bool {
        let gains =
            matches!(self, Self::SetGain(..) | Self::SetOver(_) | Self::EndEqualiser | Self::CancelEqualiser);
        gains
            || self.only_looks()
            || matches!(self, Self::SetShading(_) | Self::Toggle(_) | Self::DismissBanner)
    }

    /// Whether it is a step through the history.
    pub fn goes_through_history(&self) -> bool {
        matches!(self, Self::Undo | Self::Redo)
    }

    /// Whether it changes where the surface is looked at from and nothing else.
    pub fn only_looks(&self) -> bool {
        matches!(
            self,
            Self::Look(_)
                | Self::Fit
                | Self::Orbit(_)
                | Self::Pan(_)
                | Self::Zoom(..)
                | Self::ToggleInspector
        )
    }
}

/// What can be drawn over the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overlay {
    /// The edited level's edges.
    Edges,
    /// Handles of coefficients.
    Handles,
    /// The control polyhedron.
    Control,
    /// Tint and outline of the selected coefficient's support.
    Support,
}
