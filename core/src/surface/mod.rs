//! Hierarchy, coefficients and positions together, always consistent.
//!
//! A [`Surface`] holds `c^j` of every level and `d^j` of every level below J. At any moment synthesis of the
//! coefficients gives exactly the positions, and analysis of the positions exactly the coefficients. It guarantees
//! that after an edit only the support has changed, to the bit, and that adding the negated integers undoes it. It
//! does *not* check that an edit is sensible; that is [`crate::edit`]'s business.

mod ball;
mod bounds;
mod changes;
mod digest;
mod form;
mod influence;
mod local;
mod marks;
mod mask;
mod placement;
mod reshape;
mod stroke;
mod walk;
mod whole;

pub use bounds::Nearest;
pub use changes::{Changes, Moved, Runs};
pub use digest::{CoefficientSum, SurfaceHash, header_bytes};
pub use form::{Form, FormOptions, NotASurface};
pub(crate) use marks::Marks;
pub use mask::Mask;
pub use placement::{DEFAULT_PRECISION, LIMIT, NotPlaceable, PRECISIONS, Placement, UpAxis};

pub use reshape::NotReshaped;

use crate::hierarchy::{Hierarchy, Level, Odd, PublicId, Slot};
use crate::memory::Buffer;
use crate::mesh::TriangleMesh;
use crate::wavelet::{Filters, ValenceTooHigh, rows};
use bounds::BoundsTree;
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// A position or a coefficient, in steps.
pub type Vector = [i32; 3];

/// The names of the channels, in order.
pub const CHANNELS: [&str; 3] = ["x", "y", "z"];

/// A wavelet surface. Memory: 28 bytes per finest vertex; with boxes for
/// finding places and a mask 31.
#[derive(Debug, Clone)]
pub struct Surface {
    hierarchy: Arc<Hierarchy>,
    filters: Arc<Filters>,
    form: Form,
    scaling: Vec<Buffer<Vector>>,
    wavelets: Vec<Buffer<Vector>>,
    header: Arc<Vec<u8>>,
    sum: CoefficientSum,
    marks: [Marks; 2],
    bounds: OnceLock<BoundsTree>,
    mask: Mask,
}

impl Surface {
    /// Analyses positions of `M^J`, given by slot. `O(n_J)`.
    ///
    /// # Errors
    /// The base mesh has a vertex of too high a valence for the wavelet.
    ///
    /// # Panics
    /// If there are not exactly `n_J` positions.
    pub fn from_finest(
        hierarchy: Hierarchy,
        form: Form,
        finest: impl Into<Buffer<Vector>>,
    ) -> Result<Self, ValenceTooHigh> {
        let filters = Filters::new(&hierarchy, form.wavelet)?;
        Ok(Self::finest_with_filters(hierarchy, filters, form, finest.into()))
    }

    /// [`Surface::from_finest`] with weights that were solved before.
    pub(crate) fn finest_with_filters(
        hierarchy: Hierarchy,
        filters: Filters,
        form: Form,
        finest: Buffer<Vector>,
    ) -> Self {
        assert_eq!(finest.len(), hierarchy.layout(hierarchy.finest()).len() as usize);
        let mut scaling = vec![finest];
        let mut wavelets = Vec::new();
        for level in (0..hierarchy.finest().0).rev() {
            let finer = scaling.last().expect("one level at least");
            let (details, coarser) = rows::analyse_level(&hierarchy, &filters, Level(level), finer);
            wavelets.push(details);
            scaling.push(coarser);
        }
        scaling.reverse();
        wavelets.reverse();
        Self::assemble(hierarchy, filters, form, scaling, wavelets)
    }

    /// Synthesises positions from `c^0` and `d^0 … d^{J−1}`. `O(n_J)`.
    ///
    /// # Errors
    /// The base mesh has a vertex of too high a valence for the wavelet.
    ///
    /// # Panics
    /// If a block does not have its level's length.
    pub fn from_coefficients(
        hierarchy: Hierarchy,
        form: Form,
        coarsest: impl Into<Buffer<Vector>>,
        wavelets: Vec<impl Into<Buffer<Vector>>>,
    ) -> Result<Self, ValenceTooHigh> {
        let filters = Filters::new(&hierarchy, form.wavelet)?;
        let wavelets = wavelets.into_iter().map(Into::into).collect();
        Ok(Self::with_filters(hierarchy, filters, form, coarsest.into(), wavelets))
    }

    /// [`Surface::from_coefficients`] with weights that were solved before.
    pub(crate) fn with_filters(
        hierarchy: Hierarchy,
        filters: Filters,
        form: Form,
        coarsest: Buffer<Vector>,
        wavelets: Vec<Buffer<Vector>>,
    ) -> Self {
        assert_eq!(coarsest.len(), hierarchy.layout(Level::BASE).len() as usize);
        assert_eq!(wavelets.len(), hierarchy.finest().index());
        let mut scaling = vec![coarsest];
        for (j, details) in wavelets.iter().enumerate() {
            let level = Level(j as u8);
            assert_eq!(details.len(), hierarchy.layout(level).odd_len() as usize);
            scaling.push(rows::synthesise_level(&hierarchy, &filters, level, &scaling[j], details));
        }
        Self::assemble(hierarchy, filters, form, scaling, wavelets)
    }

    fn assemble(
        hierarchy: Hierarchy,
        filters: Filters,
        form: Form,
        scaling: Vec<Buffer<Vector>>,
        wavelets: Vec<Buffer<Vector>>,
    ) -> Self {
        let mut surface = Self {
            header: Arc::new(header_bytes(&hierarchy, &form)),
            hierarchy: Arc::new(hierarchy),
            filters: Arc::new(filters),
            form,
            scaling,
            wavelets,
            sum: CoefficientSum::default(),
            marks: Default::default(),
            bounds: OnceLock::new(),
            mask: Mask::default(),
        };
        surface.sum = surface.full_sum();
        surface
    }

    /// The meshes without positions.
    pub fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.hierarchy
    }

    /// The weights.
    pub fn filters(&self) -> &Arc<Filters> {
        &self.filters
    }

    /// Scheme, wavelet, precision and placement.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// The finest level J.
    pub fn finest(&self) -> Level {
        self.hierarchy.finest()
    }

    /// `c^j` by slot, in steps: the positions of `M^j`.
    pub fn scaling(&self, level: Level) -> &[Vector] {
        &self.scaling[level.index()]
    }

    /// `d^j` by odd vertex, in steps; `level` is below J.
    pub fn wavelets(&self, level: Level) -> &[Vector] {
        &self.wavelets[level.index()]
    }

    /// A vertex of `M^j` in model units.
    pub fn position(&self, level: Level, slot: Slot) -> [f64; 3] {
        self.form.placement.to_model(self.scaling(level)[slot.index()])
    }

    /// The point of the finest level closest to a point, both in steps. The first call is linear in the surface, later
    /// ones logarithmic.
    pub fn nearest(&self, p: [f64; 3]) -> Nearest {
        let finest = self.scaling(self.finest());
        let tree = self.bounds.get_or_init(|| BoundsTree::new(&self.hierarchy, finest));
        tree.nearest(&self.hierarchy, finest, p)
    }

    /// Keeps the boxes round what moved.
    fn follow_bounds(&mut self, changes: &Changes) {
        match changes.at(self.finest()) {
            Moved::Nothing => {}
            Moved::Everything => drop(self.bounds.take()),
            Moved::Some(runs) => {
                if let Some(tree) = self.bounds.get_mut() {
                    tree.follow(&self.hierarchy, self.scaling.last().expect("one level at least"), runs);
                }
            }
        }
    }

    /// How far each vertex is kept from the brushes.
    pub fn mask(&self) -> &Mask {
        &self.mask
    }

    /// The mask, to be changed.
    pub(crate) fn mask_mut(&mut self) -> &mut Mask {
        &mut self.mask
    }

    /// The public id of the wavelet at an odd vertex of a level.
    pub fn wavelet_id(&self, level: Level, odd: Odd) -> PublicId {
        PublicId(self.hierarchy.layout(level).len() + odd.0)
    }

    /// The hash of the whole surface. `O(1)`, but for the base mesh's header.
    pub fn hash(&self) -> SurfaceHash {
        self.sum.finish(&self.header)
    }

    /// The coefficients' sum, computed anew. `O(n_J)`.
    pub fn full_sum(&self) -> CoefficientSum {
        let block = |first: u32, values: &[Vector]| {
            values
                .par_iter()
                .enumerate()
                .with_min_len(4096)
                .map(|(at, &value)| CoefficientSum::term(PublicId(first + at as u32), value))
                .reduce(CoefficientSum::default, CoefficientSum::plus)
        };
        let coarsest = block(0, &self.scaling[0]);
        self.wavelets.iter().enumerate().fold(coarsest, |sum, (j, details)| {
            sum.plus(block(self.hierarchy.layout(Level(j as u8)).len(), details))
        })
    }

    /// Whether every coordinate and coefficient is within the limit. `O(n_J)`.
    pub fn is_within_limit(&self) -> bool {
        let within = |values: &Buffer<Vector>| values.par_iter().all(|v| v.iter().all(|x| within_limit(*x)));
        self.scaling.iter().chain(&self.wavelets).all(within)
    }

    /// The surface with coefficients beyond the limit moved to it; positions follow and may lie beyond. `O(n_J)`.
    pub(crate) fn with_coefficients_clamped(&self) -> Self {
        let clamped =
            |all: &Buffer<Vector>| Buffer::of(all.len(), |at| all[at].map(|x| x.clamp(-LIMIT, LIMIT)));
        let details: Vec<Buffer<Vector>> = self.wavelets.iter().map(clamped).collect();
        let hierarchy = self.hierarchy.as_ref().clone();
        Self::from_coefficients(hierarchy, self.form.clone(), clamped(&self.scaling[0]), details)
            .expect("its weights were solved before")
    }

    /// `M^level` as a mesh in model units, vertices in public order, its sharp edges marked. Linear in its size.
    pub fn to_mesh(&self, level: Level) -> TriangleMesh {
        let layout = self.hierarchy.layout(level);
        let public: Vec<u32> =
            (0..layout.len()).into_par_iter().map(|s| layout.public_id(layout.site(Slot(s))).0).collect();
        let mut positions = vec![[0.0; 3]; public.len()];
        for (slot, &id) in public.iter().enumerate() {
            positions[id as usize] = self.position(level, Slot(slot as u32));
        }
        let faces = self.hierarchy.triangles(level);
        let faces = faces.into_iter().map(|f| f.map(|s| public[s as usize])).collect();
        let sharp = layout.sharp_edges().map(|ends| ends.map(|slot| public[slot.index()])).collect();
        TriangleMesh::new(positions, faces).with_sharp_edges(sharp)
    }
}

/// Whether a coordinate or coefficient may stand in a surface.
pub(crate) fn within_limit(x: i32) -> bool {
    (-LIMIT..=LIMIT).contains(&x)
}
