//! The Bozzetto application: command line, editor and renderer.
