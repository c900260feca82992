//! What lies around an extraordinary base vertex is a cone of equal sectors, the same at every level that is fine enough: weights
//! there are solved once for each valence.

use super::Wavelet;
use super::regular_disc::RegularDisc;
use super::regularity::margin;
use super::weights::WeightSolver;
use crate::hierarchy::{BaseMesh, Layout, Level, Odd, Site};
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// The level on which cones are solved: sixteen edges from the apex to the rim, and eleven are looked at.
const SOLVED: Level = Level(4);
/// On finer levels than this every disc holds one base vertex at most; each odd vertex is told by the nearest.
pub(super) const COARSEST: Level = Level(3);
/// Odd vertices up to here from their nearest base vertex, in half edges: two thirds of a face of [`COARSEST`].
const NEAREST: u32 = 10;

/// A vertex of a cone: so many sectors on, and there so far along the sector's first spoke and along its second. No sector
/// holds its second spoke, and the apex is (0, 0) of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Place {
    sector: u32,
    along: [u32; 2],
}

/// Weights by place.
type Taps = Vec<(Place, i32)>;

/// The weights around base vertices of one valence.
#[derive(Debug)]
pub(super) struct Cone {
    /// What each odd vertex of sector 0 updates, its place in half edges.
    odds: FxHashMap<[u32; 2], Taps>,
    /// What updates the irregular even vertices: the apex, and those of sector 0. Odd vertices in half edges.
    rows: Vec<(Place, Taps)>,
    valence: u32,
}

/// The cones of a base mesh by valence.
pub(super) type Cones = FxHashMap<usize, Cone>;

/// The cones of the vertices that have one. Cost: the number of valences.
pub(super) fn cones(
    solver: &WeightSolver,
    regular: &RegularDisc,
    base: &BaseMesh,
    wavelet: Wavelet,
) -> Cones {
    let Wavelet::Disc(k) = wavelet else { return Cones::default() };
    let apexes = (0..base.vertex_count()).filter(|&v| is_apex(base, v));
    let mut valences: Vec<usize> = apexes.map(|v| base.fan(v).corners.len()).collect();
    valences.sort_unstable();
    valences.dedup();
    let made = valences.into_iter().map(|valence| (valence, Cone::new(solver, regular, valence, k)));
    made.collect()
}

/// Whether a vertex is inside the surface and off every sharp edge.
pub(super) fn is_apex(base: &BaseMesh, vertex: u32) -> bool {
    base.fan(vertex).closed && base.sharp_valence(vertex) == 0
}

/// The corner of a face that a point is nearest to, and how far away that is.
fn nearest([p, q, r]: [u32; 3]) -> (usize, u32) {
    let most = p.max(q).max(r);
    ([p, q, r].iter().position(|&x| x == most).unwrap_or(0), p + q + r - most)
}

/// Whether an even vertex is irregular for nothing but an apex near by. On levels that are not coarse.
pub(super) fn is_in_cone(layout: &Layout, site: Site, k: u8) -> bool {
    let (face, b) = layout.chart(site);
    let (corner, distance) = nearest(b);
    let vertex = layout.base().faces()[face as usize][corner];
    distance <= margin(k) && !layout.base().is_regular(vertex) && is_apex(layout.base(), vertex)
}

impl Place {
    /// Of a point given in a face of the cone.
    fn of(fan: &[(u32, u8)], (face, b): (u32, [u32; 3])) -> Self {
        let at = fan.iter().position(|&(f, _)| f == face).expect("a face of the cone");
        let corner = usize::from(fan[at].1);
        match [b[(corner + 1) % 3], b[(corner + 2) % 3]] {
            [0, 0] => Self { sector: 0, along: [0, 0] },
            [0, second] => Self { sector: (at as u32 + 1) % fan.len() as u32, along: [second, 0] },
            along => Self { sector: at as u32, along },
        }
    }

    fn turned(self, by: u32, valence: u32) -> Self {
        Self { sector: (self.sector + by) % valence, ..self }
    }

    /// The face, and the coordinates there with sum n.
    fn chart(self, fan: &[(u32, u8)], n: u32) -> (u32, [u32; 3]) {
        let (face, corner) = fan[self.sector as usize];
        let (corner, [a, b]) = (usize::from(corner), self.along);
        let mut at = [0; 3];
        (at[corner], at[(corner + 1) % 3], at[(corner + 2) % 3]) = (n - a - b, a, b);
        (face, at)
    }
}

impl Cone {
    fn new(solver: &WeightSolver, regular: &RegularDisc, valence: usize, k: u8) -> Self {
        let count = valence as u32;
        let faces = (0..count).map(|s| [0, 1 + s, 1 + (s + 1) % count]).collect();
        let base = BaseMesh::new(count + 1, faces, &[]).expect("a fan of three or more");
        let layout = Layout::checked(&Arc::new(base), SOLVED).expect("a small level");
        let fan = &layout.base().fan(0).corners;
        let n = 2 * layout.segments();
        let mut odds: FxHashMap<[u32; 2], Taps> = FxHashMap::default();
        // Odd vertices of which a disc's end can reach the margin.
        for at in (0..2 * (margin(k) + u32::from(k)) + 2).flat_map(|sum| (0..sum).map(move |b| [sum - b, b]))
        {
            if at[0] % 2 == 0 && at[1] % 2 == 0 {
                continue;
            }
            let (face, b) = Place { sector: 0, along: at }.chart(fan, n);
            let odd = layout.resolve_odd(face, b.map(|x| x as i32)).expect("inside the cone");
            let site = layout.odd_site(odd);
            let stencil = regular
                .stencil(&layout, site)
                .unwrap_or_else(|| solver.stencil(&layout, site, Wavelet::Disc(k)));
            let places = stencil.vertices.iter().map(|&site| Place::of(fan, layout.chart(site)));
            odds.insert(at, places.zip(stencil.weights).collect());
        }
        let mut rows: FxHashMap<[u32; 2], Taps> = FxHashMap::default();
        for (&along, taps) in &odds {
            for &(even, weight) in taps {
                // Seen from sector 0 the odd vertex lies so many sectors back. All of them update the apex.
                let from = match even.along {
                    [0, 0] => 0..count,
                    _ => (count - even.sector) % count..(count - even.sector) % count + 1,
                };
                let row = rows.entry(even.along).or_default();
                row.extend(from.map(|sector| (Place { sector, along }, weight)));
            }
        }
        let mut rows: Vec<(Place, Taps)> = rows
            .into_iter()
            .filter(|([a, b], _)| a + b <= margin(k))
            .map(|(along, taps)| (Place { sector: 0, along }, taps))
            .collect();
        rows.sort_unstable_by_key(|(place, _)| place.along);
        rows.iter_mut().for_each(|(_, taps)| taps.sort_unstable_by_key(|(at, _)| (at.sector, at.along)));
        Self { odds, rows, valence: count }
    }

    /// The cone on a level that is not coarse.
    pub(super) fn on<'a>(&'a self, layout: &'a Layout) -> OnLevel<'a> {
        let n = 2 * layout.segments();
        let inside = [0, 1, 2].map(|corner| {
            let fan = [(0, corner)];
            let number = |&(place, _): &(Place, i32)| match (Place { sector: 0, ..place }).chart(&fan, n) {
                _ if place.along[1] == 0 => None,
                (face, [_, i, r]) => {
                    Some(layout.odd_at(Site::Face { face, i, r }).0 - layout.odd_face_start(0))
                }
            };
            self.rows.iter().flat_map(|(_, taps)| taps).map(number).collect()
        });
        OnLevel { cone: self, layout, inside }
    }
}

/// A cone on one level.
pub(super) struct OnLevel<'a> {
    cone: &'a Cone,
    layout: &'a Layout,
    /// By the face's corner at the apex and tap the odd vertex's number among those inside the face; none on a spoke.
    inside: [Vec<Option<u32>>; 3],
}

impl OnLevel<'_> {
    /// Calls back for each irregular even vertex around an apex, with what updates it, the last of the odd vertices last.
    pub(super) fn each_row(
        &self,
        apex: u32,
        taps: &mut Vec<(Odd, i32)>,
        mut row: impl FnMut(Site, &mut Vec<(Odd, i32)>),
    ) {
        let Self { cone, layout, inside } = self;
        let fan = &layout.base().fan(apex).corners;
        for sector in 0..cone.valence {
            let mut tap = 0;
            for (place, of) in &cone.rows {
                let first = tap;
                tap += of.len();
                if place.along == [0, 0] && sector > 0 {
                    continue;
                }
                let from = taps.len();
                let mut last = (Odd(0), from);
                for (tap, &(odd, weight)) in (first..).zip(of) {
                    let there = odd.turned(sector, cone.valence);
                    let (face, corner) = fan[there.sector as usize];
                    let odd = match inside[usize::from(corner)][tap] {
                        Some(number) => Odd(layout.odd_face_start(face) + number),
                        None => {
                            let (face, b) = there.chart(fan, 2 * layout.segments());
                            layout.resolve_odd(face, b.map(|x| x as i32)).expect("inside the cone")
                        }
                    };
                    last = last.max((odd, taps.len()));
                    taps.push((odd, weight));
                }
                let end = taps.len() - 1;
                taps.swap(last.1, end);
                let (face, b) = place.turned(sector, cone.valence).chart(fan, layout.segments());
                row(layout.site_at(face, b), taps);
            }
        }
    }
}

/// What an odd vertex, a site of the level above, updates, if the nearest base vertex is an apex. On level [`COARSEST`].
pub(super) fn updated<'a>(
    cones: &'a Cones,
    layout: &'a Layout,
    (face, b): (u32, [u32; 3]),
) -> Option<impl Iterator<Item = (Site, i32)> + 'a> {
    let (corner, distance) = nearest(b);
    let vertex = layout.base().faces()[face as usize][corner];
    if distance > NEAREST || !is_apex(layout.base(), vertex) {
        return None;
    }
    let fan = &layout.base().fan(vertex).corners;
    let cone = cones.get(&fan.len())?;
    let Place { sector, along } = Place::of(fan, (face, b));
    let site = move |place: Place| {
        let (face, b) = place.turned(sector, cone.valence).chart(fan, layout.segments());
        layout.site_at(face, b)
    };
    Some(cone.odds.get(&along)?.iter().map(move |&(place, weight)| (site(place), weight)))
}
