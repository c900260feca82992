//! Closest points between the input and a surface that moves from iterate to iterate: each look starts from what the
//! last one found.

use super::fitted::Fitted;
use super::pulls::{Back, Forth, Look, Pulls, barycentric};
use super::simplify::Cancelled;
use super::target::Target;
use crate::mesh::{BoundingVolumes, FaceIndex};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Queries one thread makes in a row.
const CHUNK: usize = 1024;
/// Chunks between two questions whether to go on: some hundredths of a second on two threads.
const BATCH: usize = 48;

/// A fitted surface beside its target.
pub(super) struct Watch<'a> {
    target: &'a Target<'a>,
    fitted: &'a Fitted,
    tree: Option<BoundingVolumes>,
    last: Option<Arc<Pulls>>,
}

impl<'a> Watch<'a> {
    pub(super) fn new(target: &'a Target<'a>, fitted: &'a Fitted) -> Self {
        Self { target, fitted, tree: None, last: None }
    }

    /// Every sample's closest point on the other surface. `go_on` is asked some times a second.
    ///
    /// # Errors
    /// The answer was no.
    pub(super) fn look(
        &mut self,
        positions: &[DVec3],
        look: Look,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Arc<Pulls>, Cancelled> {
        let current = self.fitted.mesh(positions);
        match &mut self.tree {
            Some(tree) => tree.refit(&current),
            None => {
                self.tree = BoundingVolumes::build_while(&current, &mut || go_on()).map_err(|_| Cancelled)?
            }
        }
        let forth = self.forth(positions, look, go_on)?;
        let back = self.back(positions, look, go_on)?;
        let pulls = Arc::new(Pulls::new((self.target, self.fitted), positions, look, forth, back));
        self.last = Some(pulls.clone());
        Ok(pulls)
    }

    fn forth(
        &self,
        positions: &[DVec3],
        look: Look,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Vec<Forth>, Cancelled> {
        let Target { samples, by_area, .. } = self.target;
        let tree = self.tree.as_ref().expect("a fitted surface has faces");
        let (stride, by_area) = (look.stride(), by_area.div_ceil(look.stride()));
        let total = if look == Look::Rough { by_area } else { samples.len() };
        let last = self.last.as_ref().map(|last| (&last.forth, last.look.stride()));
        let of_chunk = |chunk: usize| {
            let mut cursor = tree.cursor();
            let closest = |k: usize| {
                let sample = if k < by_area { k * stride } else { k };
                if let Some((last, stride)) = last
                    && let Some(before) = last.get(if k < by_area { sample / stride } else { k })
                {
                    cursor.start_at(FaceIndex(before.face));
                }
                let found = cursor.closest(samples[sample].to_array());
                let corners =
                    self.fitted.pattern.faces()[found.face.0 as usize].map(|v| positions[v as usize]);
                let at = DVec3::from(found.point);
                Forth { face: found.face.0, weights: barycentric(corners, at), gap: samples[sample] - at }
            };
            let found: Vec<Forth> = (chunk * CHUNK..((chunk + 1) * CHUNK).min(total)).map(closest).collect();
            self.target.count_looks(cursor.looked_at());
            found
        };
        in_batches(total.div_ceil(CHUNK), go_on, &of_chunk)
    }

    fn back(
        &self,
        positions: &[DVec3],
        look: Look,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Vec<Back>, Cancelled> {
        let faces = self.fitted.pattern.faces();
        let inside = look.inside();
        let points = inside.len() * faces.len();
        let total = points + if look == Look::Close { positions.len() } else { 0 };
        let last = self.last.as_ref().map(|last| (&last.back, last.look.inside().len()));
        let of_chunk = |chunk: usize| {
            let mut cursor = self.target.tree.cursor();
            let closest = |k: usize| {
                let (face, weights) = if k < points {
                    (k / inside.len(), inside[k % inside.len()])
                } else {
                    let corner = self.fitted.pattern.corners(k - points)[0] as usize;
                    let mut weights = [0.0; 3];
                    weights[corner % 3] = 1.0;
                    (corner / 3, weights)
                };
                if let Some((last, per_face)) = last {
                    let before = if per_face == inside.len() { k } else { face * per_face };
                    cursor.start_at(FaceIndex(last[before].face));
                }
                let [a, b, c] = faces[face].map(|v| positions[v as usize]);
                let at = a * weights[0] + b * weights[1] + c * weights[2];
                let found = cursor.closest(at.to_array());
                let normal = self.target.normals[found.face.0 as usize];
                let against = (b - a).cross(c - a).dot(normal) < 0.0;
                Back { face: found.face.0, against, gap: DVec3::from(found.point) - at }
            };
            let found: Vec<Back> = (chunk * CHUNK..((chunk + 1) * CHUNK).min(total)).map(closest).collect();
            self.target.count_looks(cursor.looked_at());
            found
        };
        in_batches(total.div_ceil(CHUNK), go_on, &of_chunk)
    }
}

/// The answers of all chunks in order, asking after each batch of them whether to go on.
fn in_batches<T: Send>(
    chunks: usize,
    go_on: &dyn Fn() -> bool,
    of_chunk: &(impl Fn(usize) -> Vec<T> + Sync),
) -> Result<Vec<T>, Cancelled> {
    let mut all = Vec::with_capacity(chunks * CHUNK);
    for first in (0..chunks).step_by(BATCH) {
        if !go_on() {
            return Err(Cancelled);
        }
        all.par_extend((first..(first + BATCH).min(chunks)).into_par_iter().flat_map_iter(of_chunk));
    }
    Ok(all)
}
