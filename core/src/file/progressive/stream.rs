//! The order of the stream: which block comes when, and what a reader makes of as much as it has.
//!
//! Blocks are offered in a fixed order, by how far a step of their plane moves the surface; a bit says whether the block
//! offered is taken. So the writer may choose another order, and pays for it only where it does.

mod base;
mod choice;
mod errors;

pub(in crate::file) use self::choice::Granularity;
use self::choice::{Choice, coarsest, last_plane};
use self::errors::Ruler;
use super::butterfly::{Curves, bends};
use super::finish::{self, finish};
use super::frames::{Frame, frames};
use super::planes::{Block, CLASSES, Level as Planes, Models, code};
use super::range_coder::{Coder, Decoder, Encoder, Model};
use super::transform::{Coding, Transform};
use super::visit::of_odds;
use crate::hierarchy::{Hierarchy, Level};
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

/// What of one level is known.
#[derive(Debug, Default)]
struct Details {
    /// By slot of `M^{j+1}`: normal part, two tangential parts, without the bits below the plane. Empty before the level
    /// begins.
    known: Vec<Vector>,
    /// By odd vertex.
    frames: Vec<Frame>,
    /// By class.
    planes: [u32; 2],
    /// The first odd vertex that is still at other planes, and those.
    cut: Option<(u32, [u32; 2])>,
    /// By slot of `M^{j+1}`, how far components are from their predictions. Empty before the level is finished.
    residuals: Vec<Vector>,
}

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
    finishing: finish::Models,
    order: OrderModels,
    /// The positions of a level, as long as nothing coarser has changed.
    synthesised: Option<(usize, Vec<Vector>)>,
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
            if details.known.is_empty() {
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
        }
        self.synthesised.as_ref().map_or(&[], |(_, positions)| positions)
    }

    /// Something of a level has changed, or of the base positions: what lies above it is no longer true.
    fn changed(&mut self, level: Option<usize>) {
        self.synthesised.take_if(|(kept, _)| level.is_none_or(|level| level < *kept));
    }

    fn synthesise(&self, level: usize) -> Vec<Vector> {
        let (from, mut positions) = match &self.synthesised {
            Some((kept, positions)) if *kept <= level => (*kept, positions.clone()),
            _ => (0, self.known_base()),
        };
        for j in from..level {
            positions = self.transform.synthesise_level(Level(j as u8), &positions, &self.details(j));
        }
        positions
    }

    /// `d^j` as far as it is known.
    fn details(&self, j: usize) -> Vec<Vector> {
        let (coarse, fine) =
            (self.hierarchy.layout(Level(j as u8)), self.hierarchy.layout(Level(j as u8 + 1)));
        let details = &self.levels[j];
        if details.known.is_empty() {
            return vec![[0; 3]; coarse.odd_len() as usize];
        }
        of_odds(coarse, fine, |odd, slot, _| {
            let known = details.known[slot as usize];
            let mut local = [0; 3];
            for (class, range) in CLASSES.into_iter().enumerate() {
                let plane = match details.cut {
                    Some((first, above)) if odd >= first => above[class],
                    _ => details.planes[class],
                };
                for c in range {
                    local[c] = restored(known[c], plane);
                }
            }
            details.frames[odd as usize].turn_back(local)
        })
    }

    /// Gets a level ready for its first block: its frames are those of the positions known now, and never change. Then
    /// each class's highest plane, counted down from the level's.
    fn begin<C: Coder>(&mut self, coder: &mut C, j: usize, truth: &mut Truth) {
        let hierarchy = self.hierarchy;
        let frames = frames(hierarchy, Level(j as u8), self.positions(j));
        let details = &mut self.levels[j];
        if C::WRITES {
            truth.local[j].par_iter_mut().zip(&frames).for_each(|(d, frame)| *d = frame.turn(*d));
        }
        for class in 0..2 {
            let plane = if C::WRITES { highest(&truth.local[j], class) } else { 0 };
            let most = details.planes[class];
            details.planes[class] = most.saturating_sub(coder.raw(5, most.wrapping_sub(plane) & 31));
        }
        details.frames = frames;
        details.known = vec![[0; 3]; self.hierarchy.layout(Level(j as u8 + 1)).len() as usize];
    }

    /// Codes a block of a level; whether all of it was there.
    fn block<C: Coder>(&mut self, coder: &mut C, j: usize, block: Block, truth: &[Vector]) -> bool {
        let (before, rest) = self.levels.split_at_mut(j);
        let mut planes = Planes {
            coarse: self.hierarchy.layout(Level(j as u8)),
            fine: self.hierarchy.layout(Level(j as u8 + 1)),
            known: &mut rest[0].known,
            parents: before.last().map_or(&[], |details| &details.known),
            truth,
        };
        let stopped = code(coder, &mut self.models, block, &mut planes).err();
        rest[0].cut = stopped.map(|first| (first, rest[0].planes));
        rest[0].planes[block.class] = block.to;
        self.changed(Some(j));
        stopped.is_none()
    }

    /// Codes all that is missing of a level; whether it was there.
    fn finish<C: Coder>(&mut self, coder: &mut C, j: usize, truth: &[Vector]) -> bool {
        let (hierarchy, level) = (self.hierarchy, Level(j as u8));
        let predicted = if self.transform.bends() { Vec::new() } else { self.predicted(j) };
        let (before, rest) = self.levels.split_at_mut(j);
        let details = &mut rest[0];
        details.residuals = vec![[0; 3]; details.known.len()];
        let mut parts = finish::Parts {
            coarse: hierarchy.layout(level),
            fine: hierarchy.layout(Level(j as u8 + 1)),
            known: &mut details.known,
            residuals: &mut details.residuals,
            parents: before.last().map_or(&[], |details| &details.residuals),
            predicted: &predicted,
            truth,
            from: details.planes,
        };
        let stopped = finish(coder, &mut self.finishing, &mut parts).err();
        details.cut = stopped.map(|first| (first, details.planes));
        details.planes = [0; 2];
        self.changed(Some(j));
        stopped.is_none()
    }

    /// What a smooth surface through the positions known of `M^j` has for the components of its odd vertices.
    fn predicted(&mut self, j: usize) -> Vec<Vector> {
        let hierarchy = self.hierarchy;
        let mut predicted = bends(hierarchy, Level(j as u8), self.positions(j), Curves::Ignored);
        predicted
            .par_iter_mut()
            .zip(&self.levels[j].frames)
            .for_each(|(bend, frame)| *bend = frame.turn(*bend));
        predicted
    }
}

fn restored(known: i32, plane: u32) -> i32 {
    let middle = ((7i64 << plane) >> 4) as i32;
    match known {
        0 => 0,
        x if x < 0 => x.wrapping_sub(middle),
        x => x.wrapping_add(middle),
    }
}

/// What is to be written, as the stream holds it.
#[derive(Default)]
struct Truth {
    base: Vec<Vector>,
    /// By level and odd vertex, in the level's frames; filled in as levels begin, before that as `d^j` is.
    local: Vec<Vec<Vector>>,
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
        match step {
            Step::Base => self.base_block(coder, to, &truth.base),
            Step::Begin(j) => {
                self.begin(coder, j, truth);
                !coder.is_exhausted()
            }
            Step::Refine(j, class) => {
                let truth = if C::WRITES { truth.local[j].as_slice() } else { &[] };
                match finish {
                    true => self.finish(coder, j, truth),
                    false => self.block(coder, j, Block { class, from: plane, to }, truth),
                }
            }
        }
    }
}

/// A place where a stream can be cut at no loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::file) struct Border {
    /// How many bytes are read here.
    pub(in crate::file) position: usize,
    /// The root of the mean squared distance to the whole, in steps; 0 only where nothing is missing.
    pub(in crate::file) error: f64,
}

/// A stream and its borders, the last its end.
pub(in crate::file) struct Encoded {
    pub(in crate::file) coding: Coding,
    pub(in crate::file) bytes: Vec<u8>,
    pub(in crate::file) borders: Vec<Border>,
}

impl Encoded {
    /// The error after so many bytes, from the first border on: in a block, which goes from vertex to vertex, the square
    /// falls evenly.
    pub(in crate::file) fn error_at(&self, position: usize) -> f64 {
        match self.borders.partition_point(|border| border.position <= position) {
            0 => self.borders[0].error,
            at if at == self.borders.len() => self.borders[at - 1].error,
            at => between(self.borders[at - 1], self.borders[at], position),
        }
    }
}

fn between(before: Border, after: Border, position: usize) -> f64 {
    let share = (position - before.position) as f64 / (after.position - before.position) as f64;
    let squared = |border: Border| border.error * border.error;
    ((1.0 - share) * squared(before) + share * squared(after)).sqrt()
}

/// Borders of which some are measured, the first and the last among them: at the others errors are taken to fall evenly,
/// or, before the end, their squares.
fn filled(measured: &[(usize, Option<f64>)]) -> Vec<Border> {
    let mut borders: Vec<Border> = Vec::with_capacity(measured.len());
    for (at, &(position, error)) in measured.iter().enumerate() {
        let error = error.unwrap_or_else(|| {
            let next = |&(position, error): &(usize, Option<f64>)| Some(Border { position, error: error? });
            let after = measured[at..].iter().find_map(next).expect("the last is measured");
            let before = borders[at - 1];
            let share =
                (position - before.position) as f64 / (after.position - before.position).max(1) as f64;
            match after.error > 0.0 {
                true => before.error + share * (after.error - before.error),
                false => between(before, after, position.min(after.position)),
            }
        });
        borders.push(Border { position, error });
    }
    borders
}

/// Borders are measured that are so many bytes at least from the last one measured.
const MEASURED_EVERY: usize = 128;

/// And so far from one after `before` bytes: the more vertices, the longer measuring takes beside writing.
fn measured_after(before: usize, vertices: usize) -> usize {
    let apart = match vertices {
        0..=16_384 => before / 4,
        16_385..=65_536 => before,
        _ => 3 * before,
    };
    apart.max(MEASURED_EVERY)
}

/// Writes a surface as a stream. `O(n_J)` for each plane.
pub(in crate::file) fn encode_stream(surface: &Surface, coding: Coding, granularity: Granularity) -> Encoded {
    let (hierarchy, finest) = (surface.hierarchy(), surface.finest());
    let others =
        coding.filters(hierarchy, surface.form().wavelet).expect("the writer chose what can be solved");
    let transform =
        Transform { coding, hierarchy, filters: others.as_ref().unwrap_or_else(|| surface.filters()) };
    let (base, local) = match coding {
        Coding::Own => {
            let details = (0..finest.0).map(|j| surface.wavelets(Level(j)).to_vec());
            (surface.scaling(Level::BASE).to_vec(), details.collect())
        }
        _ => transform.analyse(surface.scaling(finest)),
    };
    let mut truth = Truth { base, local };
    let last_plane = last_plane(truth.local.last());
    let mut state = State::new(transform);
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
        // What comes next is long.
        if choice.finish
            && let Some((position, error @ None)) = borders.last_mut()
        {
            *error = Some(ruler.measure(&state));
            last = *position;
        }
        state.step(&mut encoder, &candidates, choice, &mut truth);
        let position = encoder.position();
        let far = position - last >= measured_after(last, vertices);
        if far {
            last = position;
        }
        borders.push((position, far.then(|| ruler.measure(&state))));
    }
    borders.last_mut().expect("the first at least").1 = Some(0.0);
    Encoded { coding, bytes: encoder.finish(), borders: filled(&borders) }
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
    Coefficients(Vec<Vector>, Vec<Vec<Vector>>),
    /// `c^J`.
    Finest(Vec<Vector>),
}

/// Reads a stream as far as it goes, in the given transform. `None` if the base positions are not all there. `O(n_J)` for
/// each plane.
pub(in crate::file) fn decode_stream(
    hierarchy: &Hierarchy,
    filters: &Filters,
    coding: Coding,
    bytes: &[u8],
) -> Option<Decoded> {
    let mut state = State::new(Transform { coding, hierarchy, filters });
    let mut decoder = Decoder::new(bytes);
    let mut truth = Truth::default();
    if !state.beginning(&mut decoder, &truth) {
        return None;
    }
    let mut exact = false;
    loop {
        let candidates = state.candidates();
        if candidates.is_empty() {
            exact = true;
            break;
        }
        if !state.step(&mut decoder, &candidates, Choice { index: 0, count: 0, finish: false }, &mut truth) {
            break;
        }
    }
    let held = match coding {
        Coding::Own => Held::Coefficients(
            state.known_base(),
            (0..state.levels.len()).map(|j| state.details(j)).collect(),
        ),
        _ => Held::Finest(state.synthesise(state.levels.len())),
    };
    let surplus = exact && decoder.position() < bytes.len();
    Some(Decoded { held, exact, surplus })
}

impl<'a> State<'a> {
    fn new(transform: Transform<'a>) -> Self {
        let hierarchy = transform.hierarchy;
        Self {
            hierarchy,
            transform,
            base: vec![[0; 3]; hierarchy.base().vertex_count() as usize],
            base_plane: 0,
            base_cut: None,
            levels: (0..hierarchy.finest().0).map(|_| Details::default()).collect(),
            models: Models::default(),
            finishing: finish::Models::default(),
            synthesised: None,
            order: OrderModels::default(),
        }
    }
}
