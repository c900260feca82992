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
        let number = |face: u32, [_, i, r]: [u32; 3]| {
            layout.odd_at(Site::Face { face, i, r }).0 - layout.odd_face_start(0)
        };
        let all = self.rows.iter().flat_map(|(_, taps)| taps);
        let taps = all.map(|&tap| Seen::new(tap, 2 * layout.segments(), number)).collect();
        OnLevel { cone: self, layout, taps }
    }
}

/// Not on a spoke.
const OFF: u32 = u32::MAX;

/// A place as all apexes of a valence see it on one level, and a weight.
struct Seen {
    sector: u32,
    /// How far along the sector's first spoke, 0 at the apex; [`OFF`] it.
    spoke: u32,
    /// By the face's corner at the apex the number inside the face.
    inside: [u32; 3],
    weight: i32,
}

impl Seen {
    /// On a level of n segments, with what numbers the places inside face 0.
    fn new((place, weight): (Place, i32), n: u32, number: impl Fn(u32, [u32; 3]) -> u32) -> Self {
        let Place { sector, along } = place;
        let inside = [0, 1, 2].map(|corner| match along[1] {
            0 => 0,
            _ => {
                let (face, b) = Place { sector: 0, along }.chart(&[(0, corner)], n);
                number(face, b)
            }
        });
        let spoke = if along[1] == 0 { along[0] } else { OFF };
        Self { sector, spoke, inside, weight }
    }
}

/// A sector as it lies on the surface.
#[derive(Debug, Clone, Copy)]
struct Sector {
    face: u32,
    corner: u8,
    /// The first spoke's base edge.
    edge: u32,
    /// Whether the apex is its low end.
    from_low: bool,
}

impl Sector {
    /// Those of an apex, twice round.
    fn all(base: &BaseMesh, apex: u32) -> impl Iterator<Item = Self> {
        let corners = &base.fan(apex).corners;
        corners.iter().chain(corners).map(move |&(face, corner)| {
            let edge = base.face_edges(face)[usize::from(corner)];
            Self { face, corner, edge, from_low: base.edges()[edge as usize][0] == apex }
        })
    }
}

/// A cone on one level.
pub(super) struct OnLevel<'a> {
    cone: &'a Cone,
    layout: &'a Layout,
    /// Of all rows, one after the other.
    taps: Vec<Seen>,
}

impl OnLevel<'_> {
    /// Calls back for each irregular even vertex around an apex, with what updates it, the last of the odd vertices last.
    pub(super) fn each_row(
        &self,
        apex: u32,
        taps: &mut Vec<(Odd, i32)>,
        mut row: impl FnMut(Site, &mut Vec<(Odd, i32)>),
    ) {
        let Self { cone, layout, taps: seen } = self;
        let (fan, n) = (&layout.base().fan(apex).corners, layout.segments());
        let sectors: Vec<Sector> = Sector::all(layout.base(), apex).collect();
        for sector in 0..cone.valence {
            let mut first = 0;
            for (place, of) in &cone.rows {
                let seen = &seen[first..first + of.len()];
                first += of.len();
                if place.along == [0, 0] && sector > 0 {
                    continue;
                }
                let from = taps.len();
                let mut last = (Odd(0), from);
                taps.extend(seen.iter().zip(from..).map(|(seen, at)| {
                    let there = sectors[(sector + seen.sector) as usize];
                    let odd = Odd(match seen.spoke {
                        OFF => layout.odd_face_start(there.face) + seen.inside[usize::from(there.corner)],
                        t if there.from_low => there.edge * n + t / 2,
                        t => there.edge * n + n - 1 - t / 2,
                    });
                    last = last.max((odd, at));
                    (odd, seen.weight)
                }));
                let end = taps.len() - 1;
                taps.swap(last.1, end);
                let (face, b) = place.turned(sector, cone.valence).chart(fan, n);
                row(layout.site_at(face, b), taps);
            }
        }
    }
}

/// The cones on level [`COARSEST`], where odd vertices are told one by one.
pub(super) struct OnCoarsest<'a> {
    layout: &'a Layout,
    finer: &'a Layout,
    /// By valence.
    cones: FxHashMap<usize, CoarseCone>,
    /// Those of all apexes, twice round.
    sectors: Vec<LaidSector>,
    /// By base vertex where its sectors begin; none where it is no apex.
    starts: Vec<Option<u32>>,
    /// By base face and corner its place in the fan of that corner.
    places: Vec<[u32; 3]>,
}

/// A sector's slots.
struct LaidSector {
    /// Where those inside its face begin.
    inside: u32,
    corner: u8,
    /// Along its first spoke: so much, and for each edge from the apex on so much more, modulo 2^32.
    spoke: [u32; 2],
}

impl LaidSector {
    fn new(layout: &Layout, sector: Sector) -> Self {
        let before = layout.slot(Site::Edge { edge: sector.edge, t: 1 }).0.wrapping_sub(1);
        let spoke = if sector.from_low {
            [before, 1]
        } else {
            [before.wrapping_add(layout.segments()), 1u32.wrapping_neg()]
        };
        Self { inside: layout.row(sector.face, 1).0, corner: sector.corner, spoke }
    }
}

/// What each odd vertex of sector 0 updates.
struct CoarseCone {
    /// By place in half edges.
    starts: [[(u32, u32); ALONG]; ALONG],
    taps: Vec<Seen>,
}

/// Half edges along a spoke to odd vertices up to [`NEAREST`].
const ALONG: usize = NEAREST as usize + 1;

impl CoarseCone {
    fn new(cone: &Cone, layout: &Layout) -> Self {
        let number =
            |face: u32, [_, i, r]: [u32; 3]| layout.slot(Site::Face { face, i, r }).0 - layout.row(0, 1).0;
        let (mut starts, mut taps) = ([[(0, 0); ALONG]; ALONG], Vec::new());
        for (&[a, b], of) in &cone.odds {
            if a + b <= NEAREST {
                let from = taps.len() as u32;
                taps.extend(of.iter().map(|&tap| Seen::new(tap, layout.segments(), number)));
                starts[a as usize][b as usize] = (from, taps.len() as u32);
            }
        }
        Self { starts, taps }
    }
}

impl<'a> OnCoarsest<'a> {
    pub(super) fn new(cones: &Cones, (layout, finer): (&'a Layout, &'a Layout)) -> Self {
        let base = layout.base();
        let (mut sectors, mut places) = (Vec::new(), vec![[0; 3]; base.faces().len()]);
        let starts = (0..base.vertex_count()).map(|vertex| {
            for (&(face, corner), at) in base.fan(vertex).corners.iter().zip(0..) {
                places[face as usize][usize::from(corner)] = at;
            }
            let start = sectors.len() as u32;
            is_apex(base, vertex).then(|| {
                sectors.extend(Sector::all(base, vertex).map(|sector| LaidSector::new(layout, sector)));
                start
            })
        });
        let starts = starts.collect();
        let cones = cones.iter().map(|(&valence, cone)| (valence, CoarseCone::new(cone, layout))).collect();
        Self { layout, finer, cones, sectors, starts, places }
    }

    /// Calls back for each vertex that an odd one updates, by slot, if the nearest base vertex is an apex; whether it is.
    #[inline]
    pub(super) fn updated(&self, odd: Odd, mut found: impl FnMut(u32, i32)) -> bool {
        let Some(Told { apex, sectors, taps }) = self.told(odd) else { return false };
        for seen in taps {
            let there = &sectors[seen.sector as usize];
            let slot = match seen.spoke {
                0 => apex,
                OFF => there.inside + seen.inside[usize::from(there.corner)],
                t => there.spoke[0].wrapping_add(t.wrapping_mul(there.spoke[1])),
            };
            found(slot, seen.weight);
        }
        true
    }

    /// Whether it is told of an odd vertex.
    pub(super) fn tells(&self, odd: Odd) -> bool {
        self.told(odd).is_some()
    }

    #[inline]
    fn told(&self, odd: Odd) -> Option<Told<'_>> {
        let Self { layout, .. } = self;
        let (face, b) = self.finer.chart(layout.odd_site(odd));
        let (corner, distance) = nearest(b);
        let apex = layout.base().faces()[face as usize][corner];
        let start = self.starts[apex as usize].filter(|_| distance <= NEAREST)?;
        let valence = layout.base().fan(apex).corners.len();
        let cone = self.cones.get(&valence)?;
        let at = self.places[face as usize][corner] as usize;
        // No sector holds its second spoke.
        let (sector, [first, second]) = match [b[(corner + 1) % 3], b[(corner + 2) % 3]] {
            [0, second] => ((at + 1) % valence, [second, 0]),
            along => (at, along),
        };
        let (from, to) = cone.starts[first as usize][second as usize];
        let taps = &cone.taps[from as usize..to as usize];
        (from < to).then(|| Told { apex, sectors: &self.sectors[start as usize + sector..], taps })
    }
}

/// What a cone tells of an odd vertex.
struct Told<'a> {
    apex: u32,
    /// From the odd vertex's own on.
    sectors: &'a [LaidSector],
    taps: &'a [Seen],
}
