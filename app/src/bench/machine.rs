//! What the figures were measured on.

use serde::Serialize;
use std::thread::available_parallelism;

/// The machine, as far as it says so itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Machine {
    /// The processor's name, or its architecture where the system does not tell.
    pub(crate) processor: String,
    /// Threads that run at once.
    pub(crate) threads: usize,
    /// What the kernels use.
    pub(crate) instructions: &'static str,
    /// In GiB, if the system tells.
    pub(crate) memory_gib: Option<f64>,
    /// The operating system and architecture.
    pub(crate) system: String,
}

impl Machine {
    /// This one.
    pub(super) fn here() -> Self {
        let processor =
            field("/proc/cpuinfo", "model name").unwrap_or_else(|| std::env::consts::ARCH.to_owned());
        let memory = field("/proc/meminfo", "MemTotal");
        let kib = memory.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
        Self {
            processor,
            threads: available_parallelism().map_or(1, usize::from),
            instructions: instructions(),
            memory_gib: kib.map(|kib| (kib / f64::from(1 << 20) * 10.0).round() / 10.0),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

fn instructions() -> &'static str {
    match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(_) => "AVX-512",
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(_) => "AVX2",
        _ => "baseline",
    }
}

/// The first line `name : value` of one of Linux's files about itself.
fn field(path: &str, name: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(name))?.split_once(':')?.1;
    Some(value.trim().to_owned())
}
