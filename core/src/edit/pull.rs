//! Pulls: handles and grabs with a smooth spread, detail that follows, and mirrors.
//!
//! A `move` is the paper's coefficient as it is. A `pull` is what hands expect: it may take hold of a coefficient or of any
//! place of the surface, and bends finer levels smoothly.

use super::plan::{EditError, existing_level};
use super::reach::touched;
use super::region::neighbourhood_of_slot;
use super::spread::{SMOOTH_LEVELS, Weights, refined};
use super::stroke::Mirror;
use super::vocabulary::{Falloff, Kind, first, is_first};
use super::weighted::weighted_steps;
use crate::hierarchy::{Address, Level, Odd, PublicId, Site, Slot};
use crate::surface::{Marks, Surface};
use serde::{Deserialize, Serialize};
use std::fmt;

/// How a pull goes on to finer levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Spread {
    /// By smooth subdivision.
    #[default]
    Smooth,
    /// By hat functions: a tent.
    Hat,
}

/// Pulls a coefficient of a level, its neighbourhood, or a place of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pull {
    /// Scaling or, from version 3 on, wavelet coefficients: form of a level, or detail while the coarser form stays.
    #[serde(default = "scaling", skip_serializing_if = "is_scaling")]
    pub kind: Kind,
    /// The level of the coefficients.
    pub level: u8,
    /// The vertex pulled, by its public id; else a place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertex: Option<u32>,
    /// The place pulled, in model units: where the surface is closest to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
    /// How far the vertex or place goes, in model units.
    pub delta: [f64; 3],
    /// How far the pull reaches, in model units; none: one coefficient, or those around the place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// How it fades towards the radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub falloff: Option<Falloff>,
    /// How it goes on to finer levels.
    #[serde(default, skip_serializing_if = "is_smooth")]
    pub spread: Spread,
    /// Whether finer detail turns with the surface.
    #[serde(default, skip_serializing_if = "is_false")]
    pub follow: bool,
    /// Planes that mirror it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirror: Option<Mirror>,
    /// Version of the operation.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub v: u32,
}

impl Pull {
    /// The newest version of what it does; older ones replay as they did.
    pub const LATEST_VERSION: u32 = 3;

    /// The smooth pull of one coefficient, finer detail left as it is.
    pub const fn of(kind: Kind, level: u8, vertex: u32, delta: [f64; 3]) -> Self {
        Self {
            kind,
            level,
            vertex: Some(vertex),
            at: None,
            delta,
            radius: None,
            falloff: None,
            spread: Spread::Smooth,
            follow: false,
            mirror: None,
            v: Self::LATEST_VERSION,
        }
    }

    /// The oldest version that does all that the newest does with coefficients of a kind, for lines that older programs read.
    pub fn version_for(kind: Kind) -> u32 {
        match kind {
            Kind::Scaling => 2,
            Kind::Wavelet => 3,
        }
    }
}

fn scaling() -> Kind {
    Kind::Scaling
}

fn is_scaling(kind: &Kind) -> bool {
    *kind == Kind::Scaling
}

fn is_smooth(spread: &Spread) -> bool {
    *spread == Spread::Smooth
}

fn is_false(flag: &bool) -> bool {
    !flag
}

impl fmt::Display for Pull {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.vertex {
            Some(vertex) if self.kind == Kind::Wavelet => {
                write!(f, "Pull wavelet {vertex} at level {}", self.level)
            }
            Some(vertex) => write!(f, "Pull {vertex} at level {}", self.level),
            None => write!(f, "Grab at level {}", self.level),
        }
    }
}

/// What a pull reaches: vertices of the level that carries it, or wavelet coefficients, with their share of each component of
/// the delta.
#[derive(Debug, Clone, PartialEq)]
pub struct Pulled {
    /// The coarsest level whose vertices move by themselves: the pull's own for hats, a finer one for the smooth spread, the next
    /// finer one for wavelets.
    pub level: Level,
    /// Sorted by slot; none for wavelets.
    pub weights: Vec<(Slot, Weights)>,
    /// Wavelet coefficients of several levels, coarse to fine, sorted by odd vertex; none for scaling coefficients.
    pub details: Vec<(Level, Vec<(Odd, Weights)>)>,
    /// Mirror images of a single raw coefficient that no vertex of the level is near enough to.
    pub without_partner: usize,
}

/// The weights of one image with the signs its mirrors give the axes.
type Image = (Vec<(Slot, f64)>, [f64; 3]);

/// The place a pull takes hold of.
enum Held {
    Vertex(Slot),
    Place(Address),
}

impl Pulled {
    /// The reach of a pull, whatever its delta. Cost: the support at the level that carries it.
    ///
    /// # Errors
    /// Unknown level, vertex or version, or numbers that mean nothing.
    pub fn of(surface: &Surface, pull: &Pull) -> Result<Self, EditError> {
        if !(1..=Pull::LATEST_VERSION).contains(&pull.v) {
            return Err(EditError::UnknownVersion { version: pull.v });
        }
        if pull.kind == Kind::Wavelet {
            return Self::of_wavelets(surface, pull);
        }
        let level = existing_level(surface, Kind::Scaling, pull.level)?;
        let mirror = pull.mirror.unwrap_or_default();
        if !mirror.is_finite() || pull.at.is_some_and(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(EditError::Stroke);
        }
        if let Some(radius) = pull.radius.filter(|r| !(r.is_finite() && *r > 0.0)) {
            return Err(EditError::Radius { radius });
        }
        if pull.radius.is_none() && pull.falloff.is_some() {
            return Err(EditError::FalloffWithoutRadius);
        }
        let layout = surface.hierarchy().layout(level);
        let placement = &surface.form().placement;
        let to_steps = |p: [f64; 3]| std::array::from_fn(|c| (p[c] - placement.origin[c]) / placement.step);
        let (held, centre) = match (pull.vertex, pull.at) {
            (Some(vertex), None) if vertex < layout.len() => {
                let site = layout.site_of(PublicId(vertex));
                let fine = surface.hierarchy().refine_slot(level, surface.finest(), layout.slot(site));
                (Held::Vertex(layout.slot(site)), surface.position(surface.finest(), fine))
            }
            (Some(vertex), None) => {
                return Err(EditError::UnknownVertex {
                    kind: Kind::Scaling,
                    vertex,
                    level: level.0,
                    first: 0,
                    last: layout.len() - 1,
                });
            }
            (None, Some(at)) => (Held::Place(surface.nearest(to_steps(at)).address), at),
            _ => return Err(EditError::Hold),
        };
        let mut images = vec![(own_weights(surface, level, pull, &held), [1.0; 3])];
        let mut without_partner = 0;
        for (point, signs) in mirror.images(centre).into_iter().skip(1) {
            let address = surface.nearest(to_steps(point)).address;
            let raw = pull.spread == Spread::Hat && pull.radius.is_none() && pull.vertex.is_some();
            let weights = if raw {
                partner(surface, level, point, address, |_| true).map(|slot| vec![(slot, 1.0)])
            } else {
                Some(place_weights(surface, level, pull, address))
            };
            match weights {
                Some(weights) => images.push((weights, signs)),
                None => without_partner += 1,
            }
        }
        let carrier = match pull.spread {
            Spread::Smooth => Level((level.0 + SMOOTH_LEVELS).min(surface.finest().0)),
            Spread::Hat => level,
        };
        let own = images[0].0.iter().map(|&(slot, w)| (slot, [w; 3])).collect();
        let reached =
            value_at(surface, carrier, level, &held, &refined(surface.hierarchy(), level, own, carrier));
        let scale = if reached > 0.0 { 1.0 / reached } else { 1.0 };
        let mut weights = refined(surface.hierarchy(), level, joined(images), carrier);
        for (slot, w) in &mut weights {
            let freedom = surface.freedom(carrier, *slot);
            *w = w.map(|x| x * scale * freedom);
        }
        Ok(Self { level: carrier, weights, details: Vec::new(), without_partner })
    }

    /// The integers that a delta, in steps, adds to scaling coefficients: each weight times the delta, rounded once.
    pub fn moved_by(&self, delta: [i32; 3]) -> Vec<(Slot, [i32; 3])> {
        let weights: Vec<Weights> = self.weights.iter().map(|&(_, w)| w).collect();
        let mut steps = Vec::new();
        weighted_steps(&weights, [[0; 3], delta], &mut steps);
        self.weights.iter().zip(steps).map(|(&(slot, _), step)| (slot, step)).collect()
    }
}

fn own_weights(surface: &Surface, level: Level, pull: &Pull, held: &Held) -> Vec<(Slot, f64)> {
    let falloff = pull.falloff.unwrap_or_default();
    match (held, pull.radius) {
        (Held::Vertex(slot), None) => vec![(*slot, 1.0)],
        (Held::Vertex(slot), Some(radius)) => {
            let radius = radius / surface.form().placement.step;
            let region = neighbourhood_of_slot(surface, level, *slot, radius);
            region.into_iter().map(|(slot, t)| (slot, falloff.weight(t))).collect()
        }
        (Held::Place(address), _) => place_weights(surface, level, pull, *address),
    }
}

fn place_weights(surface: &Surface, level: Level, pull: &Pull, address: Address) -> Vec<(Slot, f64)> {
    let radius = pull.radius.unwrap_or(0.0) / surface.form().placement.step;
    let falloff = pull.falloff.unwrap_or_default();
    let region = touched(surface, level, address, radius, falloff, &mut Marks::default());
    region.into_iter().map(|t| (t.slot, t.weight)).collect()
}

/// The vertex of a level that is the mirror image of another: of those that belong, the corner of the triangle there that is nearest
/// to the image, within half a spacing.
pub(super) fn partner(
    surface: &Surface,
    level: Level,
    image: [f64; 3],
    address: Address,
    belongs: impl Fn(Site) -> bool,
) -> Option<Slot> {
    let hierarchy = surface.hierarchy();
    let layout = hierarchy.layout(level);
    let at = |site: Site| {
        let fine = hierarchy.refine_slot(level, surface.finest(), layout.slot(site));
        surface.position(surface.finest(), fine)
    };
    let squared = |a: [f64; 3], b: [f64; 3]| (0..3).fold(0.0, |sum, c| sum + (a[c] - b[c]) * (a[c] - b[c]));
    let corners = address.corners(layout).map(|(site, _)| site);
    let sides = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| squared(at(corners[a]), at(corners[b])).sqrt());
    let spacing = (sides[0] + sides[1] + sides[2]) / 3.0;
    let nearest = corners
        .into_iter()
        .filter(|&site| belongs(site))
        .min_by(|&a, &b| squared(at(a), image).total_cmp(&squared(at(b), image)))?;
    (squared(at(nearest), image).sqrt() <= 0.5 * spacing).then(|| layout.slot(nearest))
}

/// The images' weights together: where several reach a vertex, it takes their mean, as far as the one that reaches it
/// most.
pub(super) fn joined(images: Vec<Image>) -> Vec<(Slot, Weights)> {
    let mut all: Vec<(Slot, f64, [f64; 3])> = images
        .into_iter()
        .flat_map(|(weights, signs)| weights.into_iter().map(move |(slot, w)| (slot, w, signs)))
        .collect();
    all.sort_by_key(|&(slot, ..)| slot);
    all.chunk_by(|a, b| a.0 == b.0)
        .filter_map(|of_slot| {
            let sum = of_slot.iter().fold(0.0, |sum, (_, w, _)| sum + w);
            let most = of_slot.iter().fold(0.0, |most: f64, (_, w, _)| most.max(*w));
            let signed = of_slot
                .iter()
                .fold([0.0; 3], |all: Weights, (_, w, signs)| std::array::from_fn(|c| all[c] + w * signs[c]));
            (sum > 0.0).then(|| (of_slot[0].0, signed.map(|x| x * (most / sum))))
        })
        .collect()
}

/// How far the held vertex or place moves for a delta of 1.
fn value_at(
    surface: &Surface,
    carrier: Level,
    level: Level,
    held: &Held,
    weights: &[(Slot, Weights)],
) -> f64 {
    let hierarchy = surface.hierarchy();
    let value =
        |slot: Slot| weights.binary_search_by_key(&slot, |&(s, _)| s).map_or(0.0, |at| weights[at].1[0]);
    match held {
        Held::Vertex(slot) => value(hierarchy.refine_slot(level, carrier, *slot)),
        Held::Place(address) => {
            let layout = hierarchy.layout(carrier);
            address.corners(layout).into_iter().fold(0.0, |sum, (site, w)| sum + w * value(layout.slot(site)))
        }
    }
}
