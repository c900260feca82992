//! Evening out the parameterisation: every face of `M^J` equilateral and with its part of the density, as nearly as
//! sliding vertices over the domain can make it.
//!
//! Minimises the root of the symmetric Dirichlet energy (Smith & Schaefer 2015) of the map from the equilateral
//! lattice to the input, areas scaled by the density, by slides of one level after another (`warp`): coarse levels
//! carry what is uneven over long ways. Guarantees: the lattice stays one to one over the domain but for rounding, so
//! no feature of the input is lost, however small.

use super::domain::{Address, Domain, HEIGHT, end_of_way};
use super::lattice::{Lattice, Places};
use super::parameterise::OnFace;
use super::simplify::{Cancelled, ask};
use super::walk::Ground;
use super::warp::{Warp, row_index, steps};
use crate::hierarchy::{Level, Site, Slot};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A slide goes no further than this part of the level's edges; two of them cannot turn a triangle over.
const REACH: f64 = 0.25;
/// Rounds after which the places are taken from the domain anew; between, vertices walk on the input.
const TRUE_UP: usize = 6;
/// A slide that made things worse is shortened to this part, one that did not grows by the other.
const SHORTEN: f64 = 0.4;
const LENGTHEN: f64 = 1.5;
const LONGEST: f64 = 4.0;
/// A slide below this, in steps, is none.
const STILL: f64 = 1e-6;

/// What a lattice is evened over.
pub(super) struct Evening<'a> {
    pub(super) domain: &'a Domain<'a>,
    pub(super) ground: &'a Ground<'a>,
    /// Density at the input's vertices.
    pub(super) density: &'a [f64],
}

/// The energy, and the way each vertex of a level should go, in its frame and in steps of the finest level.
struct Slope {
    energy: f64,
    ways: Vec<DVec2>,
}

/// The slides of a level's vertices.
struct Slides<'w> {
    warp: &'w Warp<'w>,
    /// For each base face the ways of its vertices in its chart.
    charted: Vec<DVec2>,
    ways: Vec<DVec2>,
}

impl Evening<'_> {
    /// Slides the levels one after another, each so many rounds; levels the lattice has not are its finest. `points`
    /// are where its vertices are; returns where they are then.
    ///
    /// # Errors
    /// The progress function asked to stop.
    pub(super) fn run(
        &self,
        lattice: &mut Lattice,
        points: Vec<OnFace>,
        rounds: &[(Level, usize)],
        progress: &dyn Fn() -> bool,
    ) -> Result<Places, Cancelled> {
        let mut places = Places::of(self.ground, self.density, points);
        for &(level, count) in rounds {
            let hierarchy = lattice.hierarchy.clone();
            let warp = Warp::new(&hierarchy, level.min(hierarchy.finest()));
            let mut slope = self.slope(lattice, &warp, &places);
            let mut length = 1.0;
            for round in 0..count {
                if !progress() {
                    return Err(Cancelled);
                }
                if round > 0 && round % TRUE_UP == 0 {
                    places = self.true_places(lattice, progress)?;
                    slope = self.slope(lattice, &warp, &places);
                }
                let (addresses, points) = self.slid(lattice, &warp, &places, &slope.ways, length);
                ask(progress)?;
                let next = Places::of(self.ground, self.density, points);
                let after = self.slope(lattice, &warp, &next);
                if after.energy < slope.energy {
                    (places, slope) = (next, after);
                    lattice.addresses = addresses;
                    length = f64::min(length * LENGTHEN, LONGEST);
                } else {
                    length *= SHORTEN;
                }
            }
            places = self.true_places(lattice, progress)?;
        }
        Ok(places)
    }

    /// Where the vertices really are.
    fn true_places(&self, lattice: &Lattice, go_on: &dyn Fn() -> bool) -> Result<Places, Cancelled> {
        Ok(Places::of(self.ground, self.density, lattice.points(self.domain, go_on)?))
    }

    fn slope(&self, lattice: &Lattice, warp: &Warp, places: &Places) -> Slope {
        let faces = lattice.hierarchy.base().faces().len();
        let n = lattice.layout().segments() as i32;
        let triangles = faces as f64 * f64::from(n) * f64::from(n);
        let scale = HEIGHT * 0.5 * triangles / mass(lattice, places);
        let by_face: Vec<FaceSlope> = (0..faces)
            .into_par_iter()
            .map(|f| FaceSlope::of(lattice.face_slots(f), n, places, scale).restricted(warp, n))
            .collect();
        let mut ways = vec![DVec2::ZERO; warp.len()];
        let mut weights = vec![0.0; warp.len()];
        let mut energy = 0.0;
        for (f, face) in by_face.iter().enumerate() {
            energy += face.energy;
            for (k, &slot) in warp.face_slots(f).iter().enumerate() {
                ways[slot as usize] += warp.in_frame(slot, f as u32, face.gradient[k]);
                weights[slot as usize] += face.weight[k];
            }
        }
        let stride = f64::from(warp.stride);
        for (way, weight) in ways.iter_mut().zip(weights) {
            // The second derivative of a triangle's root is some three times the root, in steps of the level.
            *way *= -stride * stride / (3.0 * weight).max(1e-300);
        }
        Slope { energy: energy / triangles, ways }
    }

    /// Addresses after a slide, and roughly where these are.
    fn slid(
        &self,
        lattice: &Lattice,
        warp: &Warp,
        places: &Places,
        ways: &[DVec2],
        length: f64,
    ) -> (Vec<Address>, Vec<OnFace>) {
        let slides = Slides::new(lattice, &self.domain.tips, warp, ways, length);
        let layout = lattice.layout();
        (0..lattice.addresses.len())
            .into_par_iter()
            .with_min_len(512)
            .map(|slot| {
                let site = layout.site(Slot(slot as u32));
                let moved = match slides.along_curve(lattice, site) {
                    Some(None) => None,
                    Some(Some(to)) => self.point(lattice, places, to, true),
                    None => {
                        let (face, b, way) = slides.of(lattice, site);
                        if way.length_squared() < STILL * STILL {
                            None
                        } else {
                            // Round irregular vertices a long way may end nowhere: a shorter one will do.
                            let scale = 1.0 / f64::from(layout.segments());
                            let from = Address { face, b: b.map(|x| f64::from(x) * scale) };
                            [scale, 0.5 * scale, 0.25 * scale].into_iter().find_map(|part| {
                                let to = end_of_way(lattice.hierarchy.base(), from, steps(way * part))?;
                                self.point(lattice, places, to, false)
                            })
                        }
                    }
                };
                moved.unwrap_or((lattice.addresses[slot], places.points[slot]))
            })
            .unzip()
    }

    /// The address at a point of the lattice, and a walk from the nearest vertex toward where it should be.
    fn point(
        &self,
        lattice: &Lattice,
        places: &Places,
        to: Address,
        on_curve: bool,
    ) -> Option<(Address, OnFace)> {
        let n = f64::from(lattice.layout().segments());
        let corners = lattice.corners(to.face, to.b.map(|x| x * n));
        let address = if on_curve {
            let parts = corners.map(|(weight, slot)| (weight, lattice.addresses[slot]));
            let count = parts.iter().filter(|part| part.0 > 0.0).count();
            let address = self.domain.blend_on_curve(&parts[..count])?;
            // Curves are few and short: no need for walks.
            return Some((address, self.domain.on_input(address)));
        } else {
            lattice.address(self.domain, &corners)?
        };
        let place = corners.iter().fold(DVec3::ZERO, |sum, &(w, slot)| sum + places.at[slot] * w);
        let nearest = corners[0].1;
        Some((address, self.ground.walk(places.points[nearest], place - places.at[nearest])))
    }
}

/// The integral of the density over the lattice's faces in space.
fn mass(lattice: &Lattice, places: &Places) -> f64 {
    let by_face: Vec<f64> = lattice
        .fitted
        .pattern
        .faces()
        .par_iter()
        .map(|f| {
            let [a, b, c] = f.map(|v| places.at[v as usize]);
            (b - a).cross(c - a).length() * f.iter().map(|&v| places.density[v as usize]).sum::<f64>()
        })
        .collect();
    by_face.iter().sum::<f64>() / 6.0
}

/// Energy, gradient in the face's chart and the weight of both, at the vertices of one base face.
struct FaceSlope {
    energy: f64,
    gradient: Vec<DVec2>,
    weight: Vec<f64>,
}

impl FaceSlope {
    /// At the vertices of the finest level.
    fn of(slots: &[u32], n: i32, places: &Places, scale: f64) -> Self {
        let mut slope =
            Self { energy: 0.0, gradient: vec![DVec2::ZERO; slots.len()], weight: vec![0.0; slots.len()] };
        let index = |i: i32, r: i32| row_index(n, [0, i, r]);
        for r in 0..n {
            for i in 0..n - r {
                slope.add([index(i, r), index(i + 1, r), index(i, r + 1)], 1.0, slots, places, scale);
                if i + 1 < n - r {
                    let corners = [index(i + 1, r + 1), index(i, r + 1), index(i + 1, r)];
                    slope.add(corners, -1.0, slots, places, scale);
                }
            }
        }
        slope
    }

    /// Adds a triangle whose sides from the first corner run along the chart's axes, or against them.
    fn add(&mut self, corners: [usize; 3], sense: f64, slots: &[u32], places: &Places, scale: f64) {
        let [a, b, c] = corners.map(|k| places.at[slots[k] as usize]);
        let density = corners.iter().map(|&k| places.density[slots[k] as usize]).sum::<f64>() / 3.0;
        let Distortion { energy, sides: [u, v], by_sides: [by_u, by_v] } =
            distortion(a, b, c, density * scale);
        let root = (energy * 0.25).sqrt();
        self.energy += 2.0 * (root - 1.0);
        let up = (v * 2.0 - u) * (0.5 / HEIGHT);
        for (corner, by) in corners.into_iter().zip([-by_u - by_v, by_u, by_v]) {
            self.gradient[corner] += DVec2::new(by.dot(u), by.dot(up)) * (sense * root / energy);
            self.weight[corner] += root;
        }
    }

    /// At the vertices of a coarser level.
    fn restricted(&self, warp: &Warp, n: i32) -> Self {
        let mut slope = Self {
            energy: self.energy,
            gradient: vec![DVec2::ZERO; warp.per_face()],
            weight: vec![0.0; warp.per_face()],
        };
        let mut k = 0;
        for r in 0..=n {
            for i in 0..=n - r {
                for (b, w) in warp.cell([n - i - r, i, r].map(|x| x as u32)) {
                    if w > 0.0 {
                        let at = warp.index(b);
                        slope.gradient[at] += self.gradient[k] * w;
                        slope.weight[at] += self.weight[k] * w;
                    }
                }
                k += 1;
            }
        }
        slope
    }
}

/// Symmetric Dirichlet energy of the map from the equilateral triangle of side 1 to a triangle: at least 4.
struct Distortion {
    energy: f64,
    /// The sides from the first corner, scaled.
    sides: [DVec3; 2],
    by_sides: [DVec3; 2],
}

/// The triangle counts as scaled in area by `scale`.
fn distortion(a: DVec3, b: DVec3, c: DVec3, scale: f64) -> Distortion {
    let root = scale.sqrt();
    let (u, v) = ((b - a) * root, (c - a) * root);
    let (uu, vv, uv) = (u.length_squared(), v.length_squared(), u.dot(v));
    // The squared norm and the squared determinant; a triangle without area, or in one point, keeps a slope.
    let squares = (4.0 / 3.0) * (uu + vv - uv) + 1e-4;
    let area = (4.0 / 3.0) * (uu * vv - uv * uv) + 1e-9;
    let (inverse, slope) = (1.0 + 1.0 / area, -squares / (area * area));
    let by_u = (u * 2.0 - v) * (4.0 / 3.0 * inverse) + (u * vv - v * uv) * (8.0 / 3.0 * slope);
    let by_v = (v * 2.0 - u) * (4.0 / 3.0 * inverse) + (v * uu - u * uv) * (8.0 / 3.0 * slope);
    Distortion { energy: squares * inverse, sides: [u, v], by_sides: [by_u, by_v] }
}

impl<'w> Slides<'w> {
    fn new(lattice: &Lattice, tips: &[bool], warp: &'w Warp<'w>, ways: &[DVec2], length: f64) -> Self {
        let limit = REACH * f64::from(warp.stride);
        let ways: Vec<DVec2> = ways
            .iter()
            .enumerate()
            .map(|(slot, &way)| {
                let way = (way * length).clamp_length_max(limit);
                match warp.layout().site(Slot(slot as u32)) {
                    Site::Edge { edge, .. } if lattice.curves.holds(edge) => DVec2::new(way.x, 0.0),
                    Site::Base(v) if tips[v as usize] => DVec2::ZERO,
                    Site::Base(v) if lattice.curves.passes(v) => match lattice.curves.through(v) {
                        None => DVec2::ZERO,
                        Some(edges) => {
                            let [a, b] = edges.map(|e| warp.along(v, e));
                            let forward = 0.5 * (way.dot(a) - way.dot(b));
                            if forward > 0.0 { a * forward } else { b * -forward }
                        }
                    },
                    _ => way,
                }
            })
            .collect();
        let charted = (0..lattice.hierarchy.base().faces().len())
            .into_par_iter()
            .flat_map_iter(|f| {
                let ways = &ways;
                warp.face_slots(f).iter().map(move |&slot| {
                    let way = ways[slot as usize];
                    if way == DVec2::ZERO { way } else { warp.in_chart(slot, f as u32, way) }
                })
            })
            .collect();
        Self { warp, charted, ways }
    }

    /// A chart of a vertex of the finest level, its place there and its way.
    fn of(&self, lattice: &Lattice, site: Site) -> (u32, [u32; 3], DVec2) {
        if let Site::Base(v) = site {
            let slot = self.warp.layout().slot(site);
            let (face, corner, way) = self.warp.face_ahead(v, self.ways[slot.index()]);
            let mut b = [0; 3];
            b[usize::from(corner)] = lattice.layout().segments();
            return (face, b, way);
        }
        let (face, b) = lattice.layout().chart(site);
        (face, b, self.at(face, b))
    }

    /// The way of a vertex of the finest level.
    fn at(&self, face: u32, b: [u32; 3]) -> DVec2 {
        let ways = &self.charted[face as usize * self.warp.per_face()..];
        let part = |(b, weight): ([i32; 3], f64)| {
            if weight > 0.0 { ways[self.warp.index(b)] * weight } else { DVec2::ZERO }
        };
        self.warp.cell(b).into_iter().map(part).sum()
    }

    /// Where a vertex on a curve goes: `None` if it is on none, `Some(None)` if it stays.
    fn along_curve(&self, lattice: &Lattice, site: Site) -> Option<Option<Address>> {
        let (edge, t) = match site {
            Site::Edge { edge, t } if lattice.curves.holds(edge) => (edge, t),
            Site::Base(v) if lattice.curves.passes(v) => {
                let Some([edge, _]) = lattice.curves.through(v) else { return Some(None) };
                let low = lattice.hierarchy.base().edges()[edge as usize][0] == v;
                (edge, if low { 0 } else { lattice.layout().segments() })
            }
            _ => return None,
        };
        let n = f64::from(lattice.layout().segments());
        let (stride, coarse) = (self.warp.stride, self.warp.layout());
        let (before, part) = (t / stride, f64::from(t % stride) / f64::from(stride));
        let mut forward = self.along_edge(lattice, edge, before) * (1.0 - part);
        if part > 0.0 && before < coarse.segments() {
            forward += self.along_edge(lattice, edge, before + 1) * part;
        }
        if forward.abs() < STILL {
            return Some(None);
        }
        let base = lattice.hierarchy.base();
        let to = f64::from(t) + forward;
        let beyond = if to < 0.0 {
            Some((0, -to))
        } else if to > n {
            Some((1, to - n))
        } else {
            None
        };
        let (edge, to) = match beyond {
            None => (edge, to),
            Some((end, rest)) => {
                let v = base.edges()[edge as usize][end];
                let Some(pair) = lattice.curves.through(v) else { return Some(None) };
                let next = if pair[0] == edge { pair[1] } else { pair[0] };
                (next, if base.edges()[next as usize][0] == v { rest } else { n - rest })
            }
        };
        Some(Some(lattice.curves.on_edge(base, edge, (to / n).clamp(0.0, 1.0))))
    }

    /// How far a vertex of the sliding level goes along a curve edge, from its low end to the high one.
    fn along_edge(&self, lattice: &Lattice, edge: u32, t: u32) -> f64 {
        let site = self.warp.layout().along_edge(edge, t);
        let way = self.ways[self.warp.layout().slot(site).index()];
        match site {
            Site::Base(v) => {
                let Some(edges) = lattice.curves.through(v) else { return 0.0 };
                let other = if edges[0] == edge { edges[1] } else { edges[0] };
                let out =
                    way.dot(self.warp.along(v, edge)).max(0.0) - way.dot(self.warp.along(v, other)).max(0.0);
                if lattice.hierarchy.base().edges()[edge as usize][0] == v { out } else { -out }
            }
            _ => way.x,
        }
    }
}
