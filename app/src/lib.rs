//! The Bozzetto application: command line, editor and renderer.

mod bench;
pub mod cli;
pub mod display;
pub mod editor;
mod figures;
pub mod opening;
pub mod render;
mod report;
