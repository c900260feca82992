//! The order of the stream: which block comes when, and what a reader makes of as much as it has.
//!
//! Blocks are offered in a fixed order, by how far a step of their plane moves the surface; a bit says whether the block
//! offered is taken. So the writer may choose another order, and pays for it only where it does.

mod base;
mod borders;
mod choice;
mod details;
mod errors;
mod telling;

use self::base::Known;
pub(in crate::file) use self::borders::{Border, Encoded};
use self::borders::{filled, measured_after};
pub(in crate::file) use self::choice::Granularity;
use self::choice::{Choice, coarsest, last_plane};
use self::details::{Below, Details};
use self::errors::Ruler;
pub(in crate::file) use self::telling::Telling;
use super::butterfly::{Curves, bends};
use super::finish::{Finishing, Parts};
use super::frames::frames;
use super::planes::{Block, CLASSES, Level as Planes, Models, code};
use super::range_coder::{Coder, Decoder, Encoder, Model};
use super::transform::{Coded, Coding, Transform};
use crate::hierarchy::{Hierarchy, Level};
use crate::memory::Buffer;
use crate::surface::{Surface, Vector};
use crate::wavelet::Filters;
use rayon::prelude::*;

/// Planes are counted to here: magnitudes are below 2^30.
const MOST_PLANES: u32 = 30;
/// A level finer halves what a step of a coefficient is worth; in eighths of a plane.
const PER_LEVEL: i32 = 8;
/// How much later tangential planes come than normal ones, in eighths of a plane.
const TANGENTIAL: i32 = 12;
/// How much later a level begins than its highest plane would have it, in eighths of a plane: frames are the better for it.
const BEGINNING: i32 = 12;

/// What is known of a surface while it is written or read.
struct State<'a> {
    hierarchy: &'a Hierarchy,
    transform: Transform<'a>,
    base: Vec<Vector>,
    base_plane: u32,
    /// The first base vertex that is still at another plane, and that plane.
    base_cut: Option<(usize, u32)>,
    levels: Vec<Details>,
    models: Models,
    telling: Telling,
    finishing: Finishing,
    order: OrderModels,
    /// The positions of a level, as long as nothing coarser has changed.
    synthesised: Option<(usize, Buffer<Vector>)>,
    /// The level that a reader has begun last, if its frames are still to be made: they are not needed to read its first
    /// block, so another thread can make them meanwhile.
    frameless: Option<usize>,
}

/// The models of what stands between blocks.
struct OrderModels {
    taken: [Model; 4],
    more: Model,
    finish: Model,
    positions: [[Model; 33]; 3],
}

impl Default for OrderModels {
    fn default() -> Self {
        Self {
            taken: [Model::new(62_000, 8); 4],
            more: Model::new(8000, 2),
            finish: Model::new(2000, 4),
            positions: [[Model::EVEN; 33]; 3],
        }
    }
}

/// The level that is all that is missing.
fn only_level(candidates: &[(Step, u32)]) -> Option<usize> {
    let level = |step| if let Step::Refine(j, _) = step { Some(j) } else { None };
    let first = level(candidates.first()?.0);
    first.filter(|_| candidates.iter().all(|&(step, _)| level(step) == first))
}

/// What is asked for after a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum After {
    Nothing,
    More,
}

/// What may come next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// Base positions, one plane or more.
    Base,
    /// A level begins.
    Begin(usize),
    /// A class of a level, one plane or more.
    Refine(usize, usize),
}

impl State<'_> {
    /// What may come next, each with the plane it is at, in the order in which it is offered.
    fn candidates(&self) -> Vec<(Step, u32)> {
        let mut all = vec![(8 * self.base_plane as i32, Step::Base, self.base_plane)];
        for (j, details) in self.levels.iter().enumerate() {
            let value = |class: usize| {
                8 * details.planes[class] as i32 - PER_LEVEL * j as i32 - TANGENTIAL * class as i32
            };
            if !details.begun {
                all.push((value(0) - BEGINNING, Step::Begin(j), details.planes[0]));
            } else {
                all.extend([0, 1].map(|class| (value(class), Step::Refine(j, class), details.planes[class])));
            }
        }
        all.retain(|&(_, _, plane)| plane > 0);
        all.sort_by_key(|&(value, ..)| -value);
        all.into_iter().map(|(_, step, plane)| (step, plane)).collect()
    }

    /// The positions of `M^level` as far as they are known, kept for the next time.
    fn positions(&mut self, level: usize) -> &[Vector] {
        if self.synthesised.as_ref().is_none_or(|(kept, _)| *kept != level) {
            self.synthesised = Some((level, self.synthesise(level)));
            self.let_go(level);
        }
        self.synthesised.as_ref().map_or(&[], |(_, positions)| positions)
    }

    /// Forgets what the positions kept of a level are made of, if none of it can change; a block of the level may still look at
    /// the components below it.
    fn let_go(&mut self, level: usize) {
        let base = self.base_plane == 0 && self.base_cut.is_none();
        if !self.transform.bends() || !base || !self.levels[..level].iter().all(Details::is_whole) {
            return;
        }
        for (j, details) in self.levels[..level].iter_mut().enumerate() {
            details.frames = Buffer::default();
            if j + 1 < level {
                details.known = Buffer::default();
            }
        }
    }

    /// Forgets what is asked for no more when a writer goes to finish what may be the only level that is missing.
    fn let_go_before_the_last(&mut self, candidates: &[(Step, u32)]) {
        let Some(last) = only_level(candidates) else { return };
        self.positions(last);
        self.let_go(last);
        if self.transform.bends() && self.levels[last].known.is_empty() {
            self.levels[last].frames = Buffer::default();
            self.levels[..last].iter_mut().for_each(|details| details.known = Buffer::default());
        }
    }

    /// Something of a level has changed, or of the base positions: what lies above it is no longer true.
    fn changed(&mut self, level: Option<usize>) {
        self.synthesised.take_if(|(kept, _)| level.is_none_or(|level| level < *kept));
    }

    fn synthesise(&self, level: usize) -> Buffer<Vector> {
        self.below(level).positions()
    }

    /// What is known below a level.
    fn below(&self, level: usize) -> Below<'_> {
        Below {
            transform: self.transform,
            base: Known { positions: &self.base, plane: self.base_plane, cut: self.base_cut },
            levels: &self.levels[..level],
            kept: self.synthesised.as_ref(),
        }
    }

    /// Makes the frames that a reader has put off.
    fn make_frames(&mut self) {
        if let Some(j) = self.frameless.take() {
            let hierarchy = self.hierarchy;
            self.levels[j].frames = frames(hierarchy, Level(j as u8), self.positions(j));
        }
    }

    /// Works on a level with what is known below it, and makes its frames meanwhile if they have been put off.
    fn on_level<T: Send>(
        &mut self,
        j: usize,
        work: impl FnOnce(&mut Models, &mut Finishing, &mut Details, &[Details]) -> T + Send,
    ) -> T {
        let (below, rest) = self.levels.split_at_mut(j);
        let (levels, details) = (&*below, &mut rest[0]);
        let (models, finishing) = (&mut self.models, &mut self.finishing);
        if self.frameless.take_if(|level| *level == j).is_none() {
            return work(models, finishing, details, levels);
        }
        let base = Known { positions: &self.base, plane: self.base_plane, cut: self.base_cut };
        let below = Below { transform: self.transform, base, levels, kept: self.synthesised.as_ref() };
        let make = || {
            let positions = below.positions();
            (frames(self.hierarchy, Level(j as u8), &positions), positions)
        };
        let ((frames, positions), done) =
            rayon::join(make, || work(models, finishing, &mut *details, levels));
        details.frames = frames;
        self.synthesised = Some((j, positions));
        self.let_go(j);
        done
    }

    /// Gets a level ready for its first block: its frames are those of the positions known now, and never change. Then
    /// each class's highest plane, counted down from the level's.
    fn begin<C: Coder>(&mut self, coder: &mut C, j: usize, truth: &mut Truth) {
        self.frameless = Some(j);
        if C::WRITES {
            self.make_frames();
            let frames = &self.levels[j].frames;
            truth.local[j].par_iter_mut().zip(&frames[..]).for_each(|(d, frame)| *d = frame.turn(*d));
        }
        let details = &mut self.levels[j];
        for class in 0..2 {
            let plane = if C::WRITES { highest(&truth.local[j], class) } else { 0 };
            let most = details.planes[class];
            details.planes[class] = most.saturating_sub(coder.raw(5, most.wrapping_sub(plane) & 31));
        }
        details.begun = true;
    }

    /// Codes a block of a level; whether all of it was there.
    fn block<C: Coder>(&mut self, coder: &mut C, j: usize, block: Block, truth: &[Vector]) -> bool {
        let (coarse, fine) =
            (self.hierarchy.layout(Level(j as u8)), self.hierarchy.layout(Level(j as u8 + 1)));
        let done = self.on_level(j, |models, _, details, below| {
            let parents: &[Vector] = below.last().map_or(&[], |details| &details.known);
            details.hold_all(fine);
            let mut planes = Planes { coarse, fine, known: &mut details.known, parents, truth };
            let stopped = code(coder, models, block, &mut planes).err();
            details.cut = stopped.map(|first| (first, details.planes));
            details.planes[block.class] = block.to;
            stopped.is_none()
        });
        self.changed(Some(j));
        done
    }

    /// Codes all that is missing of a level; whether it was there. After it nothing need be known of the level if it is the last
    /// that is written.
    fn finish<C: Coder>(&mut self, coder: &mut C, j: usize, truth: &[Vector], after: After) -> bool {
        let (coarse, fine) =
            (self.hierarchy.layout(Level(j as u8)), self.hierarchy.layout(Level(j as u8 + 1)));
        let predicted = if self.transform.bends() { Buffer::default() } else { self.predicted(j) };
        if after == After::Nothing {
            self.synthesised = None;
        }
        let in_lanes = self.telling.finishes_in_lanes(self.hierarchy, Level(j as u8));
        let done = self.on_level(j, |_, models, details, below| {
            match after {
                After::Nothing => details.frames = Buffer::default(),
                After::More => details.hold_all(fine),
            }
            details.residuals = Buffer::zeroed(fine.len() as usize);
            let mut parts = Parts {
                coarse,
                fine,
                known: &mut details.known,
                residuals: &mut details.residuals,
                parents: below.last().map_or(&[], |details| &details.residuals),
                predicted: &predicted,
                truth,
                from: details.planes,
            };
            let stopped = models.code(coder, in_lanes, &mut parts).err();
            details.cut = stopped.map(|first| (first, details.planes));
            details.planes = [0; 2];
            stopped.is_none()
        });
        if let Some(coarser) = j.checked_sub(1) {
            self.levels[coarser].residuals = Buffer::default();
        }
        self.changed(Some(j));
        done
    }

    /// What a smooth surface through the positions known of `M^j` has for the components of its odd vertices.
    fn predicted(&mut self, j: usize) -> Buffer<Vector> {
        self.make_frames();
        let hierarchy = self.hierarchy;
        let mut predicted = bends(hierarchy, Level(j as u8), self.positions(j), Curves::Ignored);
        predicted
            .par_iter_mut()
            .zip(&self.levels[j].frames[..])
            .for_each(|(bend, frame)| *bend = frame.turn(*bend));
        predicted
    }
}

/// What is to be written, as the stream holds it.
#[derive(Default)]
struct Truth {
    base: Buffer<Vector>,
    /// By level and odd vertex, in the level's frames; filled in as levels begin, before that as `d^j` is.
    local: Vec<Buffer<Vector>>,
}

/// How many planes a class of a level has.
fn highest(local: &[Vector], class: usize) -> u32 {
    let most =
        local.iter().flat_map(|v| &v[CLASSES[class].clone()]).map(|x| x.unsigned_abs()).max().unwrap_or(0);
    32 - most.leading_zeros()
}

/// A plane that no part of any coefficient reaches, in whatever frame: none is larger than the sum of the three
/// magnitudes, but for rounding.
fn bound(details: &[Vector]) -> u32 {
    let size = |d: &Vector| d.iter().map(|x| x.unsigned_abs()).sum::<u32>();
    match details.iter().map(size).max() {
        None | Some(0) => 0,
        Some(most) => 32 - (most + 1).leading_zeros(),
    }
}

impl State<'_> {
    /// Codes which step comes next, and takes it; whether all of it was there.
    fn step<C: Coder>(
        &mut self,
        coder: &mut C,
        candidates: &[(Step, u32)],
        chosen: Choice,
        truth: &mut Truth,
    ) -> bool {
        let mut index = 0;
        while index + 1 < candidates.len()
            && !coder.bit(&mut self.order.taken[index.min(3)], chosen.index == index)
        {
            index += 1;
        }
        let (step, plane) = candidates[index];
        let finish = matches!(step, Step::Refine(..)) && coder.bit(&mut self.order.finish, chosen.finish);
        let mut count = 1;
        if !finish && !matches!(step, Step::Begin(_)) {
            while count < plane && coder.bit(&mut self.order.more, chosen.count > count) {
                count += 1;
            }
        }
        if coder.is_exhausted() {
            return false;
        }
        let to = plane - count.min(plane);
        if !matches!((step, self.frameless), (Step::Refine(j, _), Some(level)) if j == level) {
            self.make_frames();
        }
        match step {
            Step::Base => self.base_block(coder, to, &truth.base),
            Step::Begin(j) => {
                self.begin(coder, j, truth);
                !coder.is_exhausted()
            }
            Step::Refine(j, class) => {
                let of_level = if C::WRITES { &truth.local[j][..] } else { &[] };
                let last = C::WRITES && only_level(candidates) == Some(j);
                let after = if last { After::Nothing } else { After::More };
                let done = match finish {
                    true => self.finish(coder, j, of_level, after),
                    false => self.block(coder, j, Block { class, from: plane, to }, of_level),
                };
                if C::WRITES && self.levels[j].is_whole() {
                    truth.local[j] = Buffer::default();
                }
                done
            }
        }
    }
}

/// Writes a surface as a stream. `O(n_J)` for each plane.
pub(in crate::file) fn encode_stream(surface: &Surface, granularity: Granularity) -> Encoded {
    let (hierarchy, finest) = (surface.hierarchy(), surface.finest());
    let Coded { coding, filters, base, details: local } = Coded::best(surface);
    let filters = filters.as_ref().unwrap_or_else(|| surface.filters());
    let telling = Telling::of(coding, hierarchy);
    let mut truth = Truth { base, local };
    let last_plane = last_plane(truth.local.last().map(|details| &details[..]));
    let mut state = State::new(hierarchy, filters, telling);
    state.base_plane =
        if finest == Level::BASE { 0 } else { u32::from(surface.form().precision).saturating_sub(6) };
    let mut encoder = Encoder::default();
    state.beginning(&mut encoder, &truth);
    let mut ruler = Ruler::new(surface);
    let vertices = surface.scaling(finest).len();
    let mut last = encoder.position();
    let mut borders = vec![(last, Some(ruler.measure(&state)))];
    let mut finishing = granularity == Granularity::Coarse;
    loop {
        let candidates = state.candidates();
        let Some(&(first, plane)) = candidates.first() else { break };
        finishing |= matches!(first, Step::Refine(j, _) if j + 1 == finest.index() && plane <= last_plane);
        let choice =
            if finishing { coarsest(&candidates) } else { Choice { index: 0, count: 1, finish: false } };
        if choice.finish {
            state.let_go_before_the_last(&candidates);
        }
        // What comes next is long.
        if choice.finish
            && let Some((position, error @ None)) = borders.last_mut()
        {
            *error = Some(ruler.measure(&state));
            last = *position;
        }
        state.step(&mut encoder, &candidates, choice, &mut truth);
        let position = encoder.position();
        // At the end nothing is missing.
        let far = position - last >= measured_after(last, vertices) && !state.candidates().is_empty();
        if far {
            last = position;
        }
        borders.push((position, far.then(|| ruler.measure(&state))));
    }
    borders.last_mut().expect("the first at least").1 = Some(0.0);
    Encoded { telling, bytes: encoder.finish(), borders: filled(&borders) }
}

/// What a stream, or the part of it that is there, holds.
pub(in crate::file) struct Decoded {
    pub(in crate::file) held: Held,
    /// Whether every bit is known.
    pub(in crate::file) exact: bool,
    /// Whether bytes follow those that are known then.
    pub(in crate::file) surplus: bool,
}

/// A surface as a stream tells it.
pub(in crate::file) enum Held {
    /// `c^0` and each `d^j`.
    Coefficients(Buffer<Vector>, Vec<Buffer<Vector>>),
    /// `c^J`.
    Finest(Buffer<Vector>),
}

/// Reads a stream as far as it goes, in the given transform. `None` if the base positions are not all there. `O(n_J)` for
/// each plane.
pub(in crate::file) fn decode_stream(
    hierarchy: &Hierarchy,
    filters: &Filters,
    telling: Telling,
    bytes: &[u8],
) -> Option<Decoded> {
    let mut state = State::new(hierarchy, filters, telling);
    let (mut decoder, mut truth) = (Decoder::new(bytes), Truth::default());
    if !state.beginning(&mut decoder, &truth) {
        return None;
    }
    let exact = loop {
        let candidates = state.candidates();
        if candidates.is_empty() {
            break true;
        }
        if !state.step(&mut decoder, &candidates, Choice { index: 0, count: 0, finish: false }, &mut truth) {
            break false;
        }
    };
    // Read no more, and as large as the positions.
    state.levels.iter_mut().for_each(|details| details.residuals = Buffer::default());
    let held = match telling.coding {
        Coding::Own => Held::Coefficients(
            state.below(0).positions(),
            (0..).zip(&state.levels).map(|(j, d)| d.coefficients(hierarchy, Level(j))).collect(),
        ),
        _ => Held::Finest(state.synthesise(state.levels.len())),
    };
    let surplus = exact && decoder.position() < bytes.len();
    Some(Decoded { held, exact, surplus })
}

impl<'a> State<'a> {
    fn new(hierarchy: &'a Hierarchy, filters: &'a Filters, telling: Telling) -> Self {
        let transform = Transform { coding: telling.coding, hierarchy, filters };
        Self {
            hierarchy,
            transform,
            base: vec![[0; 3]; hierarchy.base().vertex_count() as usize],
            base_plane: 0,
            base_cut: None,
            levels: (0..hierarchy.finest().0).map(|_| Details::default()).collect(),
            models: Models::default(),
            telling,
            finishing: Finishing::default(),
            synthesised: None,
            frameless: None,
            order: OrderModels::default(),
        }
    }
}
