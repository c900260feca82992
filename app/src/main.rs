//! The `bozzetto` program.

fn main() {}
