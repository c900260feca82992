//! Programs that make the sample models; see `src/bin`.
