//! Symbols of sixteen kinds under adaptive models, in three lanes that need not wait for each other (docs/FORMAT.md, "Lanes").
//!
//! Based on: Duda, "Asymmetric numeral systems", arXiv:1311.2540, 2013, for the coder; Giesen, "Interleaved entropy coders",
//! arXiv:1402.3392, 2014, for lanes that share one row of words, and for models that move toward the kind that came. All
//! arithmetic is on integers and part of the file format.
//!
//! What is written last is read first, so a writer keeps what it is given until a run ends.

/// How many lanes there are.
pub(super) const LANES: usize = 3;
/// How many kinds a model tells apart.
pub(super) const KINDS: usize = 16;
/// The bits of a share: all kinds of a model together have `2^SHARE`.
const SHARE: u32 = 15;
/// A lane's state is this at least, between symbols.
const LEAST: u64 = 1 << 31;
/// The most bits that are coded at once without a model.
pub(super) const MOST_RAW: u32 = 31;

/// How likely each of sixteen kinds is, learnt from those before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(64))]
pub(super) struct Kinds {
    /// For each kind the share of those before it; rises by 1 at least.
    below: [i16; KINDS],
    seen: u16,
}

/// How far shares move toward the kind that came, as a shift, after so many before it.
const RATES: [u8; 64] = {
    let mut rates = [0; 64];
    let mut seen = 0;
    while seen < rates.len() {
        rates[seen] = match seen {
            0..=1 => 2,
            2..=5 => 3,
            6..=13 => 4,
            14..=29 => 5,
            30..=62 => 6,
            _ => 7,
        };
        seen += 1;
    }
    rates
};

/// Where the shares move when a kind came: all but 1 for each other goes to it.
const TOWARD: [[i16; KINDS]; KINDS] = {
    let mut toward = [[0; KINDS]; KINDS];
    let mut kind = 0;
    while kind < KINDS {
        let mut at = 0;
        while at < KINDS {
            toward[kind][at] = if at <= kind { at as i16 } else { ((1 << SHARE) - KINDS + at) as i16 };
            at += 1;
        }
        kind += 1;
    }
    toward
};

impl Kinds {
    /// A model that takes kinds to be as likely as the weights say, which are not all zero and below 2^16.
    pub(super) fn new(weights: [u32; KINDS]) -> Self {
        let (all, mut before) = (weights.iter().sum::<u32>(), 0);
        let mut below = [0; KINDS];
        for (kind, weight) in weights.into_iter().enumerate() {
            below[kind] =
                (kind as u64 + u64::from(before) * ((1 << SHARE) - KINDS as u64) / u64::from(all)) as i16;
            before += weight;
        }
        Self { below, seen: 0 }
    }

    /// The kind in whose share a place lies.
    #[inline(always)]
    fn at(&self, place: i16) -> usize {
        let before: i16 = self.below.iter().map(|&below| i16::from(below <= place)).sum();
        before as usize - 1
    }

    /// Where a kind's share begins, and how large it is.
    #[inline(always)]
    fn share(&self, kind: usize) -> (u32, u32) {
        let below = self.below[kind] as u32;
        let end = if kind + 1 < KINDS { self.below[kind + 1] as u32 } else { 1 << SHARE };
        (below, end - below)
    }

    #[inline(always)]
    fn learn(&mut self, kind: usize) {
        let rate = RATES[usize::from(self.seen)];
        for (below, &toward) in self.below.iter_mut().zip(&TOWARD[kind]) {
            *below += (toward - *below) >> rate;
        }
        self.seen = (self.seen + 1).min(RATES.len() as u16 - 1);
    }
}

/// One direction of coding. A writer writes what it is given and returns it; a reader ignores it and returns what it reads.
pub(super) trait Lanes {
    /// Whether the values given are those to be coded.
    const WRITES: bool;

    /// A kind with its model.
    fn kind(&mut self, lane: usize, model: &mut Kinds, kind: usize) -> usize;

    /// `count` bits, at most [`MOST_RAW`], each as likely 1 as 0.
    fn raw(&mut self, lane: usize, count: u32, bits: u32) -> u32;

    /// Ends a run and begins another: at places that both directions know.
    fn next_run(&mut self);

    /// Whether more was asked for than is there; what was read last means nothing then.
    fn is_exhausted(&self) -> bool;

    /// Codes several symbols one after another. A reader does so on a copy of its own, which stays in registers.
    fn together<T>(&mut self, code: impl FnOnce(&mut Self) -> T) -> T;
}

/// Something to be coded, kept until the run ends.
#[derive(Debug, Clone, Copy)]
struct Symbol {
    /// Where a kind's share begins, or raw bits.
    value: u32,
    /// How large the share is, or 0 and how many bits.
    share: u16,
    bits: u8,
    lane: u8,
}

/// Writes runs.
#[derive(Debug, Default)]
pub(super) struct Writer {
    symbols: Vec<Symbol>,
    words: Vec<u32>,
    bytes: Vec<u8>,
}

impl Writer {
    /// Writes behind what has been written before.
    pub(super) fn after(bytes: Vec<u8>) -> Self {
        Self { bytes, ..Self::default() }
    }

    /// What was written before, and all runs, one after another.
    pub(super) fn finish(mut self) -> Vec<u8> {
        self.next_run();
        self.bytes
    }
}

impl Lanes for Writer {
    const WRITES: bool = true;

    #[inline(always)]
    fn kind(&mut self, lane: usize, model: &mut Kinds, kind: usize) -> usize {
        let (value, share) = model.share(kind);
        self.symbols.push(Symbol { value, share: share as u16, bits: 0, lane: lane as u8 });
        model.learn(kind);
        kind
    }

    #[inline(always)]
    fn raw(&mut self, lane: usize, count: u32, bits: u32) -> u32 {
        if count > 0 {
            self.symbols.push(Symbol { value: bits, share: 0, bits: count as u8, lane: lane as u8 });
        }
        bits
    }

    fn next_run(&mut self) {
        if self.symbols.is_empty() {
            return;
        }
        let mut states = [LEAST; LANES];
        for Symbol { value, share, bits, lane } in self.symbols.drain(..).rev() {
            let state = &mut states[usize::from(lane)];
            // The least state from which the symbol would leave too large a one.
            let most = if share > 0 { u64::from(share) << (63 - SHARE) } else { 1 << (63 - bits) };
            if *state >= most {
                self.words.push(*state as u32);
                *state >>= 32;
            }
            *state = if share > 0 {
                let share = u64::from(share);
                (*state / share) << SHARE | (*state % share + u64::from(value))
            } else {
                *state << bits | u64::from(value)
            };
        }
        self.bytes.extend(states.iter().flat_map(|state| state.to_le_bytes()));
        self.bytes.extend(self.words.drain(..).rev().flat_map(|word| word.to_le_bytes()));
    }

    fn is_exhausted(&self) -> bool {
        false
    }

    #[inline(always)]
    fn together<T>(&mut self, code: impl FnOnce(&mut Self) -> T) -> T {
        code(self)
    }
}

/// Reads runs, or as much of them as there is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    states: [u64; LANES],
}

impl<'a> Reader<'a> {
    /// Begins to read at a byte.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        let mut reader = Self { bytes, at, states: [0; LANES] };
        reader.next_run();
        reader
    }

    /// How many bytes have been read.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// The next word; zero where there is none.
    #[inline(always)]
    fn word(&mut self) -> u64 {
        let word = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk());
        self.at += 4;
        u64::from(word.map_or(0, |&word| u32::from_le_bytes(word)))
    }

    #[inline(always)]
    fn renew(&mut self, lane: usize) {
        if self.states[lane] < LEAST {
            self.states[lane] = self.states[lane] << 32 | self.word();
        }
    }
}

impl Lanes for Reader<'_> {
    const WRITES: bool = false;

    #[inline(always)]
    fn kind(&mut self, lane: usize, model: &mut Kinds, _: usize) -> usize {
        let state = self.states[lane];
        let place = state & ((1 << SHARE) - 1);
        let kind = model.at(place as i16);
        let (below, share) = model.share(kind);
        self.states[lane] = (state >> SHARE) * u64::from(share) + (place - u64::from(below));
        self.renew(lane);
        model.learn(kind);
        kind
    }

    #[inline(always)]
    fn raw(&mut self, lane: usize, count: u32, _: u32) -> u32 {
        let state = self.states[lane];
        self.states[lane] = state >> count;
        self.renew(lane);
        (state & ((1 << count) - 1)) as u32
    }

    fn next_run(&mut self) {
        for lane in 0..LANES {
            let low = self.word();
            self.states[lane] = low | self.word() << 32;
        }
    }

    #[inline(always)]
    fn is_exhausted(&self) -> bool {
        self.at > self.bytes.len()
    }

    #[inline(always)]
    fn together<T>(&mut self, code: impl FnOnce(&mut Self) -> T) -> T {
        let mut copy = *self;
        let result = code(&mut copy);
        *self = copy;
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What a test codes, and in which lane.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    enum Symbol {
        Kind(usize, usize, usize),
        Raw(usize, u32, u32),
        Run,
    }

    fn symbols() -> impl Strategy<Value = Vec<Symbol>> {
        let kind = (0..LANES, 0usize..4, any::<u16>())
            .prop_map(|(lane, model, x)| Symbol::Kind(lane, model, (x >> (3 * model)) as usize % KINDS));
        let raw = (0..LANES, 0u32..=MOST_RAW, any::<u32>())
            .prop_map(|(lane, count, x)| Symbol::Raw(lane, count, x & ((1 << count) - 1)));
        prop::collection::vec(prop_oneof![20 => kind, 10 => raw, 1 => Just(Symbol::Run)], 0..3000)
    }

    fn models() -> [Kinds; 4] {
        [[1; KINDS], [3; KINDS], std::array::from_fn(|k| 1 << k), std::array::from_fn(|k| u32::from(k == 3))]
            .map(Kinds::new)
    }

    fn code<L: Lanes>(lanes: &mut L, models: &mut [Kinds; 4], symbol: Symbol) -> Symbol {
        match symbol {
            Symbol::Kind(lane, model, kind) => {
                Symbol::Kind(lane, model, lanes.kind(lane, &mut models[model], kind))
            }
            Symbol::Raw(lane, count, bits) => Symbol::Raw(lane, count, lanes.raw(lane, count, bits)),
            Symbol::Run => {
                lanes.next_run();
                Symbol::Run
            }
        }
    }

    /// Two runs in a row are one for a writer that was given nothing between them.
    fn written(symbols: &[Symbol]) -> Vec<u8> {
        let (mut writer, mut models) = (Writer::default(), models());
        symbols.iter().for_each(|&symbol| {
            code(&mut writer, &mut models, symbol);
        });
        writer.finish()
    }

    fn shares_are_sound(models: &[Kinds]) -> bool {
        models.iter().all(|model| {
            model.below[0] == 0 && (0..KINDS).all(|kind| (1..1 << SHARE).contains(&model.share(kind).1))
        })
    }

    proptest! {
        /// What was written is read; of a cut row of runs what lies before the cut, and no more.
        #[test]
        fn what_is_written_is_read(mut symbols in symbols(), cut in 0.0f64..=1.0) {
            // A writer begins no run in which there is nothing.
            symbols.retain(|symbol| !matches!(symbol, Symbol::Raw(_, 0, _)));
            symbols.dedup_by(|a, b| *a == Symbol::Run && a == b);
            let held = symbols.iter().position(|&symbol| symbol != Symbol::Run).unwrap_or(symbols.len());
            symbols.drain(..held);
            symbols.pop_if(|symbol| *symbol == Symbol::Run);
            let bytes = written(&symbols);
            let cut = (cut * bytes.len() as f64).round() as usize;
            let mut ends = Vec::new();
            for part in [&bytes[..], &bytes[..cut]] {
                let (mut reader, mut models) = (Reader::new(part, 0), models());
                for (at, &symbol) in symbols.iter().enumerate() {
                    let blank = match symbol {
                        Symbol::Kind(lane, model, _) => Symbol::Kind(lane, model, 0),
                        Symbol::Raw(lane, count, _) => Symbol::Raw(lane, count, 0),
                        Symbol::Run => symbol,
                    };
                    let found = code(&mut reader, &mut models, blank);
                    prop_assert!(shares_are_sound(&models));
                    if part.len() == bytes.len() {
                        ends.push(reader.position());
                    }
                    prop_assert_eq!(reader.is_exhausted(), ends[at] > part.len());
                    if reader.is_exhausted() {
                        break;
                    }
                    prop_assert_eq!(found, symbol);
                }
            }
            prop_assert!(symbols.is_empty() || ends.last() == Some(&bytes.len()));
        }

        /// Any bytes can be read without a panic.
        #[test]
        fn any_bytes_are_read(bytes in prop::collection::vec(any::<u8>(), 0..90), symbols in symbols()) {
            let (mut reader, mut models) = (Reader::new(&bytes, 0), models());
            for symbol in symbols {
                match code(&mut reader, &mut models, symbol) {
                    Symbol::Kind(.., kind) => prop_assert!(kind < KINDS),
                    Symbol::Raw(_, count, bits) => prop_assert!(u64::from(bits) < 1 << count),
                    Symbol::Run => {}
                }
            }
        }
    }
}
