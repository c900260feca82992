//! One edge collapse: what it costs, whether it is allowed, and its flat map.

use super::flatten::{Flattener, Patches};
use super::parameterise::Parameterisation;
use super::quadric::Quadric;
use super::working_mesh::WorkingMesh;
use glam::DVec3;

/// What a collapse must keep.
#[derive(Debug, Clone, Copy)]
pub(super) struct CollapseRules {
    /// Least and greatest valence it may give a vertex; a vertex already beyond is no obstacle unless it gets worse.
    pub(super) valences: (usize, usize),
    /// Least valence on the boundary.
    pub(super) least_on_boundary: usize,
    /// Least sine of an angle in the plane.
    pub(super) least_sine: f64,
    /// Least quality of a face in space, 1 for an equilateral triangle, 0 for a degenerate one. A face may
    /// be worse if one it replaces was.
    pub(super) least_quality: f64,
    /// Least cosine between the normals of a face before and after.
    pub(super) least_cosine: f64,
}

/// What became of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Attempt {
    /// It was collapsed; one end stays as the new vertex.
    Done {
        /// The vertex that stays.
        kept: u32,
        /// The vertex that is gone.
        gone: u32,
    },
    /// It stays, and nothing changed.
    Refused,
}

/// Vertices more pointed than this (see [`WorkingMesh::pointedness`]) are tips and keep their places: a cone of 74°.
const TIP: f64 = 0.8;
/// Cost of the worst face, as a factor: 1 for an equilateral one.
const SLIVER_PENALTY: f64 = 0.5;
/// Factor for each step of valence above seven.
const VALENCE_PENALTY: f64 = 1.5;
/// Quadric values below this fraction of the squared diagonal are rounding; the point quadrics order those.
pub(super) const ROUNDING: f64 = 1e-18;
/// The widest angle for a face between sharp edges: one of 180° or more would be folded.
const WIDEST: f64 = 150.0 / 180.0 * std::f64::consts::PI;
/// More local vertices than this are not worth flattening (and have no byte for a number).
const LARGEST_PATCH: usize = 64;

/// Working memory for collapses.
#[derive(Debug, Default)]
pub(super) struct Collapser {
    flattener: Flattener,
    patches: Patches,
    locals: Vec<u32>,
    retired: Vec<u32>,
    added: Vec<[u32; 3]>,
    near: [Vec<u32>; 2],
}

/// A collapse that topology allows.
struct Plan {
    kept: u32,
    gone: u32,
    /// Whether the kept vertex stays where it is.
    stays: bool,
    /// Where the edge lies on a curve: the vertices of that before the kept one, if that may move, and after the other.
    along: Option<(Option<u32>, u32)>,
    place: DVec3,
}

impl Collapser {
    /// The squared distance that collapsing an edge makes, and a factor for the shapes it leaves; `None` where the rules
    /// forbid it.
    pub(super) fn cost(
        &mut self,
        mesh: &WorkingMesh,
        quadrics: &[Quadric],
        ends: [u32; 2],
        rules: &CollapseRules,
    ) -> Option<(f64, f64)> {
        let plan = self.plan(mesh, quadrics, ends, rules)?;
        let quality = least_quality(mesh, &plan, rules)?;
        let quadric = quadrics[plan.kept as usize].plus(&quadrics[plan.gone as usize]);
        let valence = if mesh.is_seam(plan.kept) {
            let faces = [plan.kept, plan.gone].map(|v| mesh.star(v).len());
            mesh.valence_with(plan.kept, faces[0] + faces[1] - if mesh.is_seam(plan.gone) { 2 } else { 4 })
        } else {
            mesh.valence(plan.kept) + mesh.valence(plan.gone) - 4
        };
        let crowded = valence.saturating_sub(7) as f64;
        let shape = 1.0 + SLIVER_PENALTY * (1.0 / quality.max(0.05) - 1.0) + VALENCE_PENALTY * crowded;
        Some((quadric.at(plan.place) + ROUNDING, shape))
    }

    /// Collapses an edge if the rules allow it, and if there is a map to record it in, if it can be laid out flat.
    pub(super) fn collapse(
        &mut self,
        mesh: &mut WorkingMesh,
        map: Option<&mut Parameterisation>,
        quadrics: &[Quadric],
        ends: [u32; 2],
        rules: &CollapseRules,
    ) -> Attempt {
        let Some(plan) = self.plan(mesh, quadrics, ends, rules) else { return Attempt::Refused };
        if least_quality(mesh, &plan, rules).is_none() || !self.lay_out(mesh, &plan) {
            return Attempt::Refused;
        }
        if let Some(map) = map {
            if !self.flattener.flatten(&self.patches, rules.least_sine) {
                return Attempt::Refused;
            }
            let before = self.retired.iter().copied().zip(self.patches.before.iter().copied());
            map.record(&self.flattener.plane, before, self.patches.after.iter().copied());
        }
        mesh.replace(&self.retired, &self.added);
        mesh.positions[plan.kept as usize] = plan.place;
        mesh.shorten_crease(plan.kept, plan.gone);
        if mesh.is_boundary(plan.gone) {
            mesh.mark_boundary(plan.kept);
        }
        Attempt::Done { kept: plan.kept, gone: plan.gone }
    }

    /// The link condition and the valences; where the new vertex would be.
    fn plan(
        &mut self,
        mesh: &WorkingMesh,
        quadrics: &[Quadric],
        [a, b]: [u32; 2],
        rules: &CollapseRules,
    ) -> Option<Plan> {
        let sides = mesh.sides(a, b);
        let along_boundary = sides.contains(&None);
        let along_curve = along_boundary || mesh.is_crease(a, b);
        // One vertex cannot be on two curves, nor in two corners.
        let apart = mesh.is_on_curve(a) && mesh.is_on_curve(b) && !along_curve;
        if apart || (mesh.is_corner(a) && mesh.is_corner(b)) {
            return None;
        }
        let [near_kept, near_gone] = &mut self.near;
        mesh.neighbours(a, near_kept);
        mesh.neighbours(b, near_gone);
        let tip = |v, near: &[u32]| Some(mesh.pointedness(v, near)).filter(|&pointed| pointed > TIP);
        let tips = [tip(a, near_kept), tip(b, near_gone)];
        let rank = |v: u32, tip: Option<f64>| (mesh.is_corner(v), mesh.is_on_curve(v), tip);
        let (mut kept, mut gone) = (a, b);
        if rank(b, tips[1]) > rank(a, tips[0]) {
            (kept, gone) = (b, a);
            std::mem::swap(near_kept, near_gone);
        }
        if mesh.is_seam(kept) && !mesh.is_seam(gone) {
            // What is off the seam has an image: tips stay two, and no edge may bridge the seam.
            let bridges = |&w: &u32| w != kept && mesh.is_seam(w) && near_kept.binary_search(&w).is_err();
            if tips[usize::from(kept == a)].is_some() || near_gone.iter().any(bridges) {
                return None;
            }
        }
        let shared = || near_kept.iter().filter(|v| near_gone.binary_search(v).is_ok());
        let opposite = sides.iter().flatten().count();
        if shared().count() != opposite {
            return None;
        }
        let along = along_curve.then(|| {
            let before = (!mesh.is_corner(kept)).then(|| mesh.beyond(kept, gone));
            (before, mesh.beyond(gone, kept))
        });
        // A round curve keeps three edges, and no face two of a straight one.
        if let Some((before, after)) = along
            && (before == Some(after) || shared().any(|&v| v == after || Some(v) == before))
        {
            return None;
        }
        // A tetrahedron, or a lone face, stays.
        let ring = near_kept.len() + near_gone.len() - 2 - opposite;
        if ring < 3 || (along_boundary && mesh.star(kept).len() + mesh.star(gone).len() <= 2) {
            return None;
        }
        if let (Some(one), Some(other)) = (shared().next(), shared().nth(1))
            && near_kept.len() == 3
            && near_gone.len() == 3
            && mesh.sides(*one, *other) != [None; 2]
        {
            return None;
        }
        let (least, most) = rules.valences;
        let valence = mesh.valence_with(kept, mesh.star(kept).len() + mesh.star(gone).len() - 2 * opposite);
        // A vertex that goes onto the seam goes there from both sides.
        let most = most + if mesh.is_seam(kept) && !mesh.is_seam(gone) { 2 } else { 0 };
        if valence > most && valence > mesh.valence(kept).max(mesh.valence(gone)) {
            return None;
        }
        let thinned = |&v: &u32| {
            let least = if mesh.is_boundary(v) && !mesh.is_seam(v) { rules.least_on_boundary } else { least };
            mesh.valence_with(v, mesh.star(v).len() - 1) < least
        };
        if shared().any(thinned) || narrows(mesh, [kept, gone], sides) {
            return None;
        }
        let at_tip = (!mesh.is_on_curve(kept) || mesh.is_only_seam(kept)) && tips != [None; 2];
        let stays = at_tip || mesh.is_corner(kept) || (mesh.is_on_curve(kept) && !mesh.is_on_curve(gone));
        let along = if stays { along.map(|(_, after)| (None, after)) } else { along };
        let place = if stays {
            mesh.positions[kept as usize]
        } else if mesh.is_seam(kept) {
            let (p, q) = (mesh.positions[kept as usize], mesh.positions[gone as usize]);
            quadrics[kept as usize].plus(&quadrics[gone as usize]).minimum_near(p, q).with_x(0.0)
        } else {
            let (p, q) = (mesh.positions[kept as usize], mesh.positions[gone as usize]);
            let quadric = quadrics[kept as usize].plus(&quadrics[gone as usize]);
            quadric.minimum_near(p, q)
        };
        Some(Plan { kept, gone, stays, along, place })
    }

    /// Fills the patches before and after. False if there are too many vertices.
    fn lay_out(&mut self, mesh: &WorkingMesh, plan: &Plan) -> bool {
        let Self { patches, locals, retired, added, .. } = self;
        patches.before.clear();
        patches.after.clear();
        patches.straight.clear();
        patches.positions.clear();
        retired.clear();
        added.clear();
        locals.clear();
        locals.extend([plan.kept, plan.gone]);
        patches.positions.extend(locals.iter().map(|&v| mesh.positions[v as usize]));
        // A vertex that stays is one vertex, before and after.
        patches.centre = if plan.stays { 0 } else { 2 };
        patches.open = mesh.is_boundary(plan.kept);
        if !plan.stays {
            locals.push(u32::MAX);
            patches.positions.push(plan.place);
        }
        let local = |v: u32, locals: &mut Vec<u32>, positions: &mut Vec<DVec3>| {
            let at = locals.iter().position(|&w| w == v).unwrap_or_else(|| {
                locals.push(v);
                positions.push(mesh.positions[v as usize]);
                locals.len() - 1
            });
            at.min(255) as u8
        };
        for (center, other) in [(plan.kept, plan.gone), (plan.gone, plan.kept)] {
            for &f in mesh.star(center) {
                let face = mesh.face(f);
                let both = face.contains(&other);
                if both && center == plan.gone {
                    continue;
                }
                let corners = face.map(|v| local(v, locals, &mut patches.positions));
                retired.push(f);
                patches.before.push(corners);
                if !both {
                    added.push(face.map(|v| if v == plan.gone { plan.kept } else { v }));
                    patches.after.push(corners.map(|v| if v < 2 { patches.centre } else { v }));
                }
            }
        }
        if let Some((before, after)) = plan.along {
            let end = local(after, locals, &mut patches.positions);
            match before {
                Some(before) => {
                    let start = local(before, locals, &mut patches.positions);
                    // In the sense of the faces.
                    let forward = mesh.sides(plan.kept, plan.gone)[0].is_some();
                    let line = if forward { [start, 0, 1, 2, end] } else { [end, 1, 0, 2, start] };
                    patches.straight.extend(line);
                }
                None => patches.straight.extend([0, 1, end]),
            }
        }
        locals.len() <= LARGEST_PATCH
    }
}

/// Whether the collapse of an edge would leave too few faces between sharp edges for the angle there.
fn narrows(mesh: &WorkingMesh, ends: [u32; 2], sides: [Option<u32>; 2]) -> bool {
    sides.into_iter().flatten().any(|f| {
        let apex = mesh.face(f).into_iter().find(|v| !ends.contains(v)).expect("a corner off the edge");
        if mesh.crease_ends(apex).is_empty() {
            return false;
        }
        let (count, angle) = mesh.wedge(apex, f);
        (count - 1) as f64 * WIDEST < angle
    })
}

/// The least quality of the faces after, `None` if one is worse than the rules allow or turns too far.
fn least_quality(mesh: &WorkingMesh, plan: &Plan, rules: &CollapseRules) -> Option<f64> {
    let mut least = 1.0f64;
    let mut least_before = 1.0f64;
    for (center, other) in [(plan.kept, plan.gone), (plan.gone, plan.kept)] {
        for &f in mesh.star(center) {
            let face = mesh.face(f);
            if face.contains(&other) {
                continue;
            }
            let before = mesh.corners(f);
            let after = std::array::from_fn(|k| if face[k] == center { plan.place } else { before[k] });
            let (n, m) = (normal(before), normal(after));
            // A face without area has no side to keep.
            if n.length_squared() > 0.0 && n.dot(m) <= rules.least_cosine * n.length() * m.length() {
                return None;
            }
            least = least.min(quality(after));
            least_before = least_before.min(quality(before));
        }
    }
    (least >= rules.least_quality.min(0.9 * least_before)).then_some(least)
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Four root three times the area over the sum of squared sides.
pub(super) fn quality([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    if sides > 0.0 { 2.0 * 3f64.sqrt() * normal([a, b, c]).length() / sides } else { 0.0 }
}
