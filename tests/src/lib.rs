//! End-to-end tests of Bozzetto; see `tests/`.
