//! An adaptive binary range coder (docs/FORMAT.md, "Range coder").
//!
//! Based on: Martin, "Range encoding: an algorithm for removing redundancy from a digitised message", 1979; carries are
//! added to the bytes that are there. All arithmetic is on integers and part of the file format.
//!
//! Encoder and decoder are two [`Coder`]s, so that what is coded is written down once and runs both ways.

use super::lanes::{Lanes, Reader, Writer};

/// Below this the range is widened by a byte.
const LEAST_RANGE: u32 = 1 << 24;
/// Bytes that a decoder has read ahead of the bit it decodes.
pub(super) const AHEAD: usize = 4;
/// How often a model has seen a bit, at most: later bits count a 128th.
const MOST_SEEN: u8 = 126;

/// How likely the next bit is 1, learnt from the bits before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Model {
    /// Of 2^16.
    one: u16,
    seen: u8,
}

impl Model {
    /// A model that takes 1 to be `one` in 2^16 likely, and learns the faster the less it has `seen`.
    pub(super) const fn new(one: u16, seen: u8) -> Self {
        Self { one, seen }
    }

    /// The model of a bit that is as often 1 as 0.
    pub(super) const EVEN: Self = Self::new(1 << 15, 0);

    /// The width of bit 1: never nothing, never all.
    #[inline(always)]
    fn bound(self, range: u32) -> u32 {
        (range >> 16) * u32::from(self.one.clamp(64, u16::MAX - 63))
    }

    #[inline(always)]
    fn learn(&mut self, bit: bool) {
        let share = SHARES[usize::from(self.seen)];
        let target = if bit { 65535 } else { 0 };
        let one = i32::from(self.one);
        self.one = (one + (((target - one) * share) >> 16)) as u16;
        self.seen = (self.seen + 1).min(MOST_SEEN);
    }
}

/// How much a bit counts after so many before it: `2^16 / (seen + 2)`.
const SHARES: [i32; 256] = {
    let mut shares = [0; 256];
    let mut seen = 0;
    while seen < shares.len() {
        shares[seen] = 65536 / (seen as i32 + 2);
        seen += 1;
    }
    shares
};

/// One direction of coding. An encoder writes what it is given and returns it; a decoder ignores it and returns what it
/// reads.
pub(super) trait Coder: Send {
    /// Whether the values given are those to be coded.
    const WRITES: bool;

    /// A bit with its model.
    fn bit(&mut self, model: &mut Model, bit: bool) -> bool;

    /// How many bits are 1 before the first that is 0 or the models end, one model for each.
    fn ones(&mut self, models: &mut [Model], count: u32) -> u32;

    /// `count` bits, at most 16, each as likely 1 as 0.
    fn raw(&mut self, count: u32, bits: u32) -> u32;

    /// Whether more was asked for than is there; what was read last means nothing then.
    fn is_exhausted(&self) -> bool;

    /// Codes several symbols one after another. A decoder does so on a copy of its own, which stays in registers: what is stored
    /// meanwhile could else be part of it, and each bit waits for the one before.
    fn together<T>(&mut self, code: impl FnOnce(&mut Self) -> T) -> T;

    /// What codes in lanes meanwhile.
    type Lanes: Lanes;

    /// Stops, codes something in lanes, and begins anew after it.
    fn in_lanes<T>(&mut self, code: impl FnOnce(&mut Self::Lanes) -> T) -> T;

    /// Any number of bits up to 32 without a model.
    #[inline(always)]
    fn long_raw(&mut self, count: u32, bits: u32) -> u32 {
        if count <= 16 {
            return self.raw(count, bits);
        }
        let high = self.raw(count - 16, bits >> 16);
        high << 16 | self.raw(16, bits & 0xffff)
    }
}

/// Writes a stream.
#[derive(Debug)]
pub(super) struct Encoder {
    /// A carry into the bytes stands above the lower 32 bits.
    low: u64,
    range: u32,
    bytes: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Self {
        Self { low: 0, range: u32::MAX, bytes: Vec::new() }
    }
}

impl Encoder {
    /// How many bytes a decoder needs to read all that has been written.
    pub(super) fn position(&self) -> usize {
        self.bytes.len() + self.held()
    }

    /// How many bytes are still in `low`: none behind lanes, where nothing has been written yet.
    fn held(&self) -> usize {
        if self.range == u32::MAX && !self.bytes.is_empty() { 0 } else { AHEAD }
    }

    /// The whole stream.
    pub(super) fn finish(mut self) -> Vec<u8> {
        for _ in 0..self.held() {
            self.shift();
        }
        self.bytes
    }

    #[inline(always)]
    fn normalise(&mut self) {
        while self.range < LEAST_RANGE {
            self.range <<= 8;
            self.shift();
        }
    }

    /// Moves the top byte of `low` out.
    #[inline(always)]
    fn shift(&mut self) {
        if self.low > 0xffff_ffff {
            self.carry();
        }
        self.bytes.push((self.low >> 24) as u8);
        self.low = self.low << 8 & 0xffff_ff00;
    }

    /// Adds one to the bytes.
    #[cold]
    fn carry(&mut self) {
        for byte in self.bytes.iter_mut().rev() {
            *byte = byte.wrapping_add(1);
            if *byte != 0 {
                break;
            }
        }
    }
}

impl Coder for Encoder {
    const WRITES: bool = true;

    #[inline(always)]
    fn bit(&mut self, model: &mut Model, bit: bool) -> bool {
        let bound = model.bound(self.range);
        self.low += if bit { 0 } else { u64::from(bound) };
        self.range = if bit { bound } else { self.range - bound };
        model.learn(bit);
        self.normalise();
        bit
    }

    #[inline(always)]
    fn ones(&mut self, models: &mut [Model], count: u32) -> u32 {
        // On its own the range stays in a register: each bit waits for the one before.
        let mut range = self.range;
        for (at, model) in (0..).zip(models) {
            let (bit, bound) = (at < count, model.bound(range));
            self.low += if bit { 0 } else { u64::from(bound) };
            range = if bit { bound } else { range - bound };
            model.learn(bit);
            while range < LEAST_RANGE {
                range <<= 8;
                self.shift();
            }
            if !bit {
                break;
            }
        }
        self.range = range;
        count
    }

    #[inline(always)]
    fn raw(&mut self, count: u32, bits: u32) -> u32 {
        self.range >>= count;
        self.low += u64::from(self.range) * u64::from(bits);
        self.normalise();
        bits
    }

    fn is_exhausted(&self) -> bool {
        false
    }

    type Lanes = Writer;

    fn in_lanes<T>(&mut self, code: impl FnOnce(&mut Writer) -> T) -> T {
        let mut lanes = Writer::after(std::mem::take(self).finish());
        let result = code(&mut lanes);
        self.bytes = lanes.finish();
        result
    }

    #[inline(always)]
    fn together<T>(&mut self, code: impl FnOnce(&mut Self) -> T) -> T {
        code(self)
    }
}

/// Reads a stream, or as much of it as there is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decoder<'a> {
    bytes: &'a [u8],
    /// How many bytes have been fetched.
    at: usize,
    /// The code in the upper half, below it what has been fetched beyond.
    window: u64,
    /// How many bits have been fetched beyond the code: two bytes at least.
    beyond: u32,
    range: u32,
}

impl<'a> Decoder<'a> {
    /// Begins to read.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self::at(bytes, 0)
    }

    fn at(bytes: &'a [u8], at: usize) -> Self {
        let mut decoder = Self { bytes, at, window: 0, beyond: 0, range: u32::MAX };
        for byte in 0..2 * AHEAD as u32 {
            decoder.window |= decoder.next() << (56 - 8 * byte);
        }
        decoder.beyond = 32;
        decoder
    }

    /// How many bytes have been read.
    pub(super) fn position(&self) -> usize {
        self.at - (self.beyond / 8) as usize
    }

    #[inline(always)]
    fn next(&mut self) -> u64 {
        let byte = self.bytes.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        u64::from(byte)
    }

    #[inline(always)]
    fn normalise(&mut self) {
        if self.range < LEAST_RANGE {
            // Two bytes at most: neither a bit nor 16 of them make the range smaller than 2^8.
            let bits = self.range.leading_zeros() & !7;
            self.range <<= bits;
            self.window <<= bits;
            self.beyond -= bits;
            if self.beyond < 16 {
                let pair = self.next() << 8 | self.next();
                self.window |= pair << (16 - self.beyond);
                self.beyond += 16;
            }
        }
    }
}

impl<'a> Coder for Decoder<'a> {
    const WRITES: bool = false;

    #[inline(always)]
    fn bit(&mut self, model: &mut Model, _: bool) -> bool {
        let bound = model.bound(self.range);
        let wide = u64::from(bound) << 32;
        let bit = self.window < wide;
        if bit {
            self.range = bound;
        } else {
            self.window -= wide;
            self.range -= bound;
        }
        model.learn(bit);
        self.normalise();
        bit
    }

    #[inline(always)]
    fn ones(&mut self, models: &mut [Model], _: u32) -> u32 {
        // A copy stays in registers: each bit waits for the one before.
        let (mut decoder, mut count) = (*self, 0);
        for model in models {
            if !decoder.bit(model, false) {
                break;
            }
            count += 1;
        }
        *self = decoder;
        count
    }

    #[inline(always)]
    fn raw(&mut self, count: u32, _: u32) -> u32 {
        self.range >>= count;
        // A sound stream never exceeds the most; a forged one must not either. A single bit needs no division.
        let code = (self.window >> 32) as u32;
        let bits = match count {
            1 => u32::from(code >= self.range),
            _ => (code / self.range).min((1 << count) - 1),
        };
        self.window -= u64::from(bits * self.range) << 32;
        self.normalise();
        bits
    }

    #[inline(always)]
    fn is_exhausted(&self) -> bool {
        self.position() > self.bytes.len()
    }

    type Lanes = Reader<'a>;

    fn in_lanes<T>(&mut self, code: impl FnOnce(&mut Reader<'a>) -> T) -> T {
        let mut lanes = Reader::new(self.bytes, self.position());
        let result = code(&mut lanes);
        *self = Self::at(self.bytes, lanes.position());
        result
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

    /// What a test codes: a bit under one of four models, or raw bits.
    #[derive(Debug, Clone, Copy)]
    enum Symbol {
        Bit(usize, bool),
        Raw(u32, u32),
    }

    fn symbols() -> impl Strategy<Value = Vec<Symbol>> {
        let bit = (0usize..4, any::<u8>())
            .prop_map(|(model, x)| Symbol::Bit(model, u16::from(x) < 1 << (2 * model)));
        let raw = (0u32..=16, any::<u32>()).prop_map(|(count, x)| Symbol::Raw(count, x & ((1 << count) - 1)));
        prop::collection::vec(prop_oneof![6 => bit, 1 => raw], 0..3000)
    }

    fn code<C: Coder>(coder: &mut C, models: &mut [Model; 4], symbol: Symbol) -> Symbol {
        match symbol {
            Symbol::Bit(model, bit) => Symbol::Bit(model, coder.bit(&mut models[model], bit)),
            Symbol::Raw(count, bits) => Symbol::Raw(count, coder.raw(count, bits)),
        }
    }

    fn encoded(symbols: &[Symbol]) -> (Vec<u8>, Vec<usize>) {
        let (mut encoder, mut models) = (Encoder::default(), [Model::EVEN; 4]);
        let ends = symbols
            .iter()
            .map(|&symbol| {
                code(&mut encoder, &mut models, symbol);
                encoder.position()
            })
            .collect();
        (encoder.finish(), ends)
    }

    proptest! {
        /// What was written is read; of a cut stream exactly what lies before the cut.
        #[test]
        fn what_is_written_is_read(symbols in symbols(), cut in 0.0f64..=1.0) {
            let (bytes, ends) = encoded(&symbols);
            let cut = (cut * bytes.len() as f64).round() as usize;
            let (mut decoder, mut models) = (Decoder::new(&bytes[..cut]), [Model::EVEN; 4]);
            for (&symbol, &end) in symbols.iter().zip(&ends) {
                let blank = match symbol {
                    Symbol::Bit(model, _) => Symbol::Bit(model, false),
                    Symbol::Raw(count, _) => Symbol::Raw(count, 0),
                };
                let found = code(&mut decoder, &mut models, blank);
                prop_assert_eq!(decoder.is_exhausted(), end > cut);
                if end > cut {
                    break;
                }
                prop_assert_eq!(format!("{found:?}"), format!("{symbol:?}"));
            }
        }

        /// Any bytes can be read without a panic.
        #[test]
        fn any_bytes_are_read(bytes in prop::collection::vec(any::<u8>(), 0..60), symbols in symbols()) {
            let (mut decoder, mut models) = (Decoder::new(&bytes), [Model::EVEN; 4]);
            for symbol in symbols {
                if let Symbol::Raw(count, bits) = code(&mut decoder, &mut models, symbol) {
                    prop_assert!(u64::from(bits) < 1 << count);
                }
            }
        }
    }

    /// A carry that runs through a row of 0xff.
    #[test]
    fn carries_are_handed_on() {
        let symbols: Vec<Symbol> =
            [Symbol::Raw(16, 0xffff); 9].into_iter().chain([Symbol::Raw(1, 1); 40]).collect();
        let (bytes, _) = encoded(&symbols);
        let (mut decoder, mut models) = (Decoder::new(&bytes), [Model::EVEN; 4]);
        for symbol in symbols {
            assert_eq!(format!("{:?}", code(&mut decoder, &mut models, symbol)), format!("{symbol:?}"));
        }
    }

    /// The bytes of a short stream: part of the format.
    #[test]
    fn golden_bytes() {
        let mut symbols: Vec<Symbol> = (0..64).map(|k| Symbol::Bit(k % 3, k % 7 == 0)).collect();
        symbols.push(Symbol::Raw(13, 4711));
        let (bytes, _) = encoded(&symbols);
        let text: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(text, "7e130e49cc1a47387b0000");
    }
}
