//! What a move reaches: coefficients of a level and their weights, found once and the same whatever the delta.

use super::plan::{EditError, Plan, existing_level};
use super::pull::{Pulled, joined, partner};
use super::region::{neighbourhood_of_odd, neighbourhood_of_slot};
use super::spread::Weights;
use super::vocabulary::{Kind, Move};
use super::weighted::weighted_steps;
use crate::hierarchy::{Layout, Level, Odd, PublicId, Site, Slot};
use crate::surface::{Surface, Vector};

/// The coefficients a move or pull reaches, with their share of each component of the delta. Found once, at the start of a
/// stroke.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// Scaling coefficients of a level, sorted by slot.
    Scaling(Level, Vec<(Slot, Weights)>),
    /// Wavelet coefficients of a level.
    Wavelets(Level, Vec<(Odd, Weights)>),
    /// What a pull reaches.
    Pulled(Pulled),
}

impl Region {
    /// The region of a move, whatever its delta, and how many mirror images of its vertex have no partner. Cost: the
    /// neighbourhood.
    ///
    /// # Errors
    /// Unknown level, vertex or version, or a radius, falloff or mirror that makes no sense.
    pub fn of(surface: &Surface, edit: &Move) -> Result<(Self, usize), EditError> {
        if !(1..=Move::LATEST_VERSION).contains(&edit.v) {
            return Err(EditError::UnknownVersion { version: edit.v });
        }
        let level = existing_level(surface, edit.kind, edit.level)?;
        let layout = surface.hierarchy().layout(level);
        let (first, count) = match edit.kind {
            Kind::Scaling => (0, layout.len()),
            Kind::Wavelet => (layout.len(), layout.odd_len()),
        };
        let (vertex, last) = (edit.vertex, first + count - 1);
        if !(first..=last).contains(&vertex) {
            return Err(EditError::UnknownVertex { kind: edit.kind, vertex, level: edit.level, first, last });
        }
        match edit.radius {
            None if edit.falloff.is_some() => return Err(EditError::FalloffWithoutRadius),
            Some(radius) if !(radius.is_finite() && radius > 0.0) => {
                return Err(EditError::Radius { radius });
            }
            _ => {}
        }
        Ok(match edit.kind {
            Kind::Scaling => {
                let (region, alone) =
                    of_images(surface, edit, layout.slot(layout.site_of(PublicId(vertex))), level)?;
                (Region::Scaling(level, region), alone)
            }
            Kind::Wavelet => {
                let fine = surface.hierarchy().layout(level.finer());
                let odd_site = layout.odd_site(Odd(vertex - first));
                let (region, alone) = of_images(surface, edit, fine.slot(odd_site), level.finer())?;
                let odd = |slot: Slot| layout.odd_at(fine.site(slot));
                let mut region: Vec<(Odd, Weights)> =
                    region.into_iter().map(|(slot, weights)| (odd(slot), weights)).collect();
                region.sort_unstable_by_key(|&(odd, _)| odd);
                (Region::Wavelets(level, region), alone)
            }
        })
    }

    /// The integers that a delta, in steps, adds: each weight times the delta, rounded once.
    pub fn moved_by(&self, delta: Vector) -> Plan {
        match self {
            Region::Scaling(level, region) => Plan::Scaling(*level, added(region, [[0; 3], delta])),
            Region::Wavelets(level, region) => Plan::Wavelets(*level, added(region, [[0; 3], delta])),
            Region::Pulled(pulled) => Plan::Pulled(pulled.deltas(delta)),
        }
    }
}

/// The vertices of a level that a move with its mirror images reaches, sorted by slot; for wavelets the odd ones of the level
/// finer than theirs.
fn of_images(
    surface: &Surface,
    edit: &Move,
    held: Slot,
    level: Level,
) -> Result<(Vec<(Slot, Weights)>, usize), EditError> {
    let Some(mirror) = edit.mirror else {
        let own = around(surface, edit, held, level).into_iter().map(|(slot, w)| (slot, [w; 3]));
        let mut region: Vec<(Slot, Weights)> = own.collect();
        // In the order of storage, which following a hand goes through again and again.
        region.sort_unstable_by_key(|&(slot, _)| slot);
        return Ok((region, 0));
    };
    if edit.v < 2 {
        return Err(EditError::MirrorVersion);
    }
    if !mirror.is_finite() {
        return Err(EditError::Stroke);
    }
    let placement = &surface.form().placement;
    let centre =
        surface.position(surface.finest(), surface.hierarchy().refine_slot(level, surface.finest(), held));
    let belongs = |site: Site| edit.kind == Kind::Scaling || Layout::coarsen(site).is_none();
    let (mut images, mut alone) = (vec![(around(surface, edit, held, level), [1.0; 3])], 0);
    for (point, signs) in mirror.images(centre).into_iter().skip(1) {
        let steps = std::array::from_fn(|c| (point[c] - placement.origin[c]) / placement.step);
        let address = surface.nearest(steps).address;
        match partner(surface, level, point, address, belongs) {
            Some(slot) => images.push((around(surface, edit, slot, level), signs)),
            None => alone += 1,
        }
    }
    Ok((joined(images), alone))
}

/// What the move reaches round a vertex, with its falloff.
fn around(surface: &Surface, edit: &Move, vertex: Slot, level: Level) -> Vec<(Slot, f64)> {
    let falloff = edit.falloff.unwrap_or_default();
    let Some(radius) = edit.radius.map(|radius| radius / surface.form().placement.step) else {
        return vec![(vertex, falloff.weight(0.0))];
    };
    let layout = surface.hierarchy().layout(level);
    let region = match edit.kind {
        Kind::Scaling => neighbourhood_of_slot(surface, level, vertex, radius),
        Kind::Wavelet => {
            let coarse = Level(level.0 - 1);
            let coarse_layout = surface.hierarchy().layout(coarse);
            let odd = coarse_layout.odd_at(layout.site(vertex));
            let slot = |odd: Odd| layout.slot(coarse_layout.odd_site(odd));
            let region = neighbourhood_of_odd(surface, coarse, odd, radius);
            region.into_iter().map(|(odd, t)| (slot(odd), t)).collect()
        }
    };
    region.into_iter().map(|(slot, t)| (slot, falloff.weight(t))).collect()
}

/// What is missing from the integers that one delta adds to those that another adds.
pub(crate) fn added<T: Copy>(region: &[(T, Weights)], deltas: [Vector; 2]) -> Vec<(T, Vector)> {
    let weights: Vec<Weights> = region.iter().map(|&(_, weights)| weights).collect();
    let mut steps = Vec::new();
    weighted_steps(&weights, deltas, &mut steps);
    region.iter().zip(steps).map(|(&(at, _), step)| (at, step)).collect()
}
