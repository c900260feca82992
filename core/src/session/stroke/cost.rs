//! What a step of a drag costs, told from how many vertices it moves, and so how fine a level can follow the hand.

use super::Stroke;
use crate::edit::{Region, extent};
use crate::hierarchy::Level;
use crate::surface::Surface;

/// Vertices that a step may move: some 4 ms on one core.
const MOST_MOVED: u64 = 1 << 18;
/// Vertices that a step may move where detail is turned back and anew: some 10 ms on one core.
const MOST_FOLLOWED: u64 = 1 << 14;

/// Vertices that the end may make in the window: some 20 ms, and where detail follows, a tenth of a second.
const MOST_ENDED: u64 = 1 << 18;
const MOST_ENDED_FOLLOWED: u64 = 1 << 16;

impl Stroke {
    /// Whether the levels that wait for the end are more than can be made at once.
    pub(super) fn ends_slowly(&self, surface: &Surface) -> bool {
        let most = if self.follow.is_some() { MOST_ENDED_FOLLOWED } else { MOST_ENDED };
        let finest = surface.finest();
        self.reach < finest && self.delta != [0; 3] && self.moved_at(surface, finest) > most
    }

    /// The finest level up to which a step moves no more vertices than a step may; at least the stroke's home.
    pub(super) fn affordable(&self, surface: &Surface) -> Level {
        let most = if self.follow.is_some() { MOST_FOLLOWED } else { MOST_MOVED };
        (self.home.0..=surface.finest().0)
            .rev()
            .map(Level)
            .find(|&level| self.moved_at(surface, level) <= most)
            .unwrap_or(self.home)
    }

    /// About how many vertices of a level move with the stroke.
    fn moved_at(&self, surface: &Surface, level: Level) -> u64 {
        match &self.region {
            Region::Wavelets(of, region) => extent::of_wavelets(surface, *of, region.len() as u64, level),
            Region::Pulled(pulled) if !pulled.details.is_empty() => {
                // One level after another is climbed from, or all anew.
                let coarser = pulled.details.iter().filter(|(of, _)| *of < level);
                coarser
                    .map(|(of, region)| extent::of_wavelets(surface, *of, region.len() as u64, level))
                    .sum()
            }
            _ => extent::of_hats(surface, self.home, self.weights.len() as u64, level),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::Session;
    use super::*;
    use crate::disk::Disk;
    use crate::edit::{Kind, Move, Pull};
    use crate::file::{Metadata, Model};
    use crate::surface::{Changes, Moved};
    use std::sync::Arc;

    fn bumpy_ball(levels: u8) -> Session {
        let surface = Surface::ball(levels, |[x, y, z]| 1.0 + 0.02 * (37.0 * x - 19.0 * y + 23.0 * z).sin());
        Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()))
    }

    fn moved(changes: &Changes, level: Level) -> u64 {
        match changes.at(level) {
            Moved::Nothing => 0,
            Moved::Some(runs) => runs.len() as u64,
            Moved::Everything => panic!("a drag moves a part"),
        }
    }

    /// What is told before a drag is what moves, or within a factor of three of it, on every level from the home on.
    #[test]
    fn what_moves_is_told_before() {
        let mut session = bumpy_ball(6);
        for kind in [Kind::Scaling, Kind::Wavelet] {
            for (level, radius) in [(0, None), (2, None), (2, Some(0.6)), (3, None), (3, Some(0.4))] {
                let vertex = session.surface().hierarchy().layout(Level(level)).len()
                    * u32::from(kind == Kind::Wavelet)
                    + 3;
                let edit =
                    Move { kind, level, vertex, delta: [0.0; 3], radius, falloff: None, mirror: None, v: 1 };
                session.begin_stroke(edit).expect("it exists");
                let changes = session.drag_to([0.3, 0.2, 0.1]).expect("in range");
                let surface = session.surface();
                let stroke = session.stroke.as_ref().expect("it began");
                for j in (stroke.home.0..=surface.finest().0).map(Level) {
                    let told = stroke.moved_at(surface, j);
                    let moved = moved(&changes, j);
                    assert!(
                        moved <= 3 * told && told <= 3 * moved + 8,
                        "{kind} of level {level}, {radius:?}: {moved} vertices of level {j} move, {told} told"
                    );
                }
                session.cancel_stroke();
            }
        }
    }

    /// A drag on a coarser level stands where it should, and its end leaves the bits of the drag made whole.
    #[test]
    fn a_large_drag_is_made_on_a_coarser_level_and_ends_on_all() {
        let pull = Pull { follow: true, v: 1, ..Pull::of(Kind::Scaling, 0, 2, [0.0; 3]) };
        let mut session = bumpy_ball(7);
        session.begin_pull(pull).expect("it exists");
        let finest = session.surface().finest();
        let reach = session.affordable_reach().expect("a stroke is under way");
        assert!(reach < finest, "{reach} of {finest}: the surface is large");
        session.preview_stroke(reach);
        let changes = session.drag_to([0.2, 0.1, 0.0]).expect("in range");
        assert_ne!(*changes.at(reach), Moved::Nothing);
        assert_eq!(*changes.at(finest), Moved::Nothing, "the finest level waits");
        session.end_stroke();
        let mut whole = bumpy_ball(7);
        whole.begin_pull(pull).expect("it exists");
        whole.drag_to([0.2, 0.1, 0.0]).expect("in range");
        whole.end_stroke();
        assert_eq!(session.hash(), whole.hash());
        assert_ne!(session.hash(), session.original_hash());

        // Without detail that follows the same surface is small, and a small one follows whole.
        session.begin_pull(Pull { follow: false, ..pull }).expect("it exists");
        assert_eq!(session.affordable_reach(), Some(finest));
        session.end_stroke();
        assert_eq!(session.affordable_reach(), None, "no stroke is under way");
    }
}
