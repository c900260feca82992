//! Adding a level, and taking away finer or coarser ones.
//!
//! Unlike all other edits these give the surface another hierarchy: ids and levels in later edits are those of the new one.
//! What they do follows from the surface alone, so a log holds them like any edit.

use super::plan::{EditError, existing_level};
use super::vocabulary::{Kind, first, is_first};
use crate::hierarchy::Level;
use crate::surface::Surface;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What happens to the levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LevelChange {
    /// A level finer than the finest, without detail: the surface stays as it is.
    Add,
    /// Levels finer than `level` go, and their detail with them.
    Finest,
    /// Levels coarser than `level` go: `M^level` becomes the base mesh. The surface stays as it is.
    Base,
}

/// Changes the levels there are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Levels {
    /// What happens.
    pub change: LevelChange,
    /// For `finest` and `base`: the level that stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<u8>,
    /// Version of the operation.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub v: u32,
}

impl fmt::Display for Levels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = self.level.unwrap_or(0);
        match self.change {
            LevelChange::Add => f.write_str("Add a level"),
            LevelChange::Finest => write!(f, "Delete levels finer than {level}"),
            LevelChange::Base => write!(f, "Make level {level} the base mesh"),
        }
    }
}

/// The surface with other levels. `O(n_J)`.
pub(super) fn reshaped(surface: &Surface, edit: &Levels) -> Result<Surface, EditError> {
    let level = || existing_level(surface, Kind::Scaling, edit.level.unwrap_or(surface.finest().0));
    match edit.change {
        LevelChange::Add => Ok(surface.with_level_added()?),
        LevelChange::Finest => Ok(surface.without_finer(level()?)),
        LevelChange::Base => Ok(surface.without_coarser(level()?)?),
    }
}

/// What undoing a change of levels needs beside the surface it led to.
#[derive(Debug, Clone)]
pub(super) struct Before {
    pub(super) edit: Levels,
    pub(super) hierarchy: std::sync::Arc<crate::hierarchy::Hierarchy>,
}

impl Before {
    /// The surface from before, without the detail and the mask of levels that were taken away. `O(n_J)`.
    pub(super) fn restored(&self, surface: &Surface) -> Surface {
        match self.edit.change {
            LevelChange::Add => surface.without_finer(self.hierarchy.finest()),
            LevelChange::Finest => surface.extended(&self.hierarchy),
            LevelChange::Base => surface.over_base(&self.hierarchy, Level(self.edit.level.unwrap_or(0))),
        }
    }
}
