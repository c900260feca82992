//! The wavelet form of a new surface, as arguments that every kind of import shares.

use bozzetto_core::surface::{DEFAULT_PRECISION, FormOptions, UpAxis};
use bozzetto_core::wavelet::{Scheme, Wavelet};
use clap::ValueEnum;

/// Wavelet, scheme, precision and placement.
#[derive(Debug, clap::Args)]
pub(super) struct FormArgs {
    /// Which wavelets: lazy, 0, 1 or 2 (the disc's radius); 2 by default.
    #[arg(long)]
    wavelet: Option<WaveletArg>,
    /// How odd vertices are predicted.
    #[arg(long, default_value = "linear")]
    scheme: SchemeArg,
    /// Bits of precision.
    #[arg(long, default_value_t = DEFAULT_PRECISION, value_parser = clap::value_parser!(u8).range(8..=25))]
    precision: u8,
    /// The model's up axis. It stands upright in pictures and in the editor; coordinates stay as they are.
    #[arg(long, value_name = "AXIS", default_value = "y")]
    up: UpArg,
    /// The model's unit of length, kept in the file; nothing is scaled.
    #[arg(long, default_value = "unknown")]
    unit: UnitArg,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum WaveletArg {
    Lazy,
    #[value(name = "0")]
    Zero,
    #[value(name = "1")]
    One,
    #[value(name = "2")]
    Two,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SchemeArg {
    Linear,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum UpArg {
    X,
    Y,
    Z,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum UnitArg {
    M,
    Cm,
    Mm,
    In,
    Unknown,
}

impl FormArgs {
    /// Whether wavelets are named.
    pub(super) fn names_wavelet(&self) -> bool {
        self.wavelet.is_some()
    }

    /// As options of the core.
    pub(super) fn options(&self) -> FormOptions {
        FormOptions {
            wavelet: match self.wavelet {
                Some(WaveletArg::Lazy) => Wavelet::Lazy,
                Some(WaveletArg::Zero) => Wavelet::Disc(0),
                Some(WaveletArg::One) => Wavelet::Disc(1),
                Some(WaveletArg::Two) | None => Wavelet::Disc(2),
            },
            scheme: match self.scheme {
                SchemeArg::Linear => Scheme::Linear,
            },
            precision: self.precision,
            up: match self.up {
                UpArg::X => UpAxis::X,
                UpArg::Y => UpAxis::Y,
                UpArg::Z => UpAxis::Z,
            },
            unit: match self.unit {
                UnitArg::M => "m",
                UnitArg::Cm => "cm",
                UnitArg::Mm => "mm",
                UnitArg::In => "in",
                UnitArg::Unknown => "",
            }
            .to_owned(),
        }
    }
}
