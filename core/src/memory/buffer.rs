//! Arrays of a level's size, in large pages.
//!
//! A level is walked a base face's row at a time, and rows of a face lie far apart: with pages of 4 kB much of that time
//! goes into finding pages. Linux gives pages of 2 MB to memory that is mapped and asks for them; elsewhere, and for small
//! arrays, a [`Buffer`] is a vector. Nobody can tell them apart but by a clock.

use bytemuck::Pod;
use memmap2::MmapMut;
use rayon::prelude::*;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

/// Bytes from which an array is mapped by itself: twice a large page, so that one lies inside wherever the map begins.
const MAPPED: usize = 4 << 20;

/// Elements that are made at a time: enough that a task outweighs its dispatch.
const TASK: usize = 4096;

/// An array whose length does not change. Dereferences to a slice; cloning copies.
pub struct Buffer<T>(Storage<T>);

enum Storage<T> {
    Small(Vec<T>),
    Mapped { map: MmapMut, elements: PhantomData<T> },
}

impl<T: Pod + Send + Sync> Buffer<T> {
    /// So many zeros.
    pub fn zeroed(len: usize) -> Self {
        let bytes = len * size_of::<T>();
        if bytes < MAPPED {
            return Self(Storage::Small(vec![T::zeroed(); len]));
        }
        match MmapMut::map_anon(bytes) {
            Ok(map) => {
                // A wish: memory that stays in small pages is as good, only slower.
                #[cfg(target_os = "linux")]
                let _ = map.advise(memmap2::Advice::HugePage);
                Self(Storage::Mapped { map, elements: PhantomData })
            }
            Err(_) => Self(Storage::Small(vec![T::zeroed(); len])),
        }
    }

    /// The values of a function of the index, in parallel.
    pub fn of(len: usize, value: impl Fn(usize) -> T + Sync) -> Self {
        Self::try_of(len, |at| Some(value(at))).expect("there is every value")
    }

    /// [`Buffer::of`], `None` if there is not every value.
    pub fn try_of(len: usize, value: impl Fn(usize) -> Option<T> + Sync) -> Option<Self> {
        let mut buffer = Self::zeroed(len);
        let set = |(at, x): (usize, &mut T)| value(at).map(|value| *x = value);
        buffer.par_iter_mut().with_min_len(TASK).enumerate().try_for_each(set)?;
        Some(buffer)
    }
}

impl<T: Pod> Deref for Buffer<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Storage::Small(values) => values,
            Storage::Mapped { map, .. } => bytemuck::cast_slice(map),
        }
    }
}

impl<T: Pod> DerefMut for Buffer<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Storage::Small(values) => values,
            Storage::Mapped { map, .. } => bytemuck::cast_slice_mut(map),
        }
    }
}

impl<T: Pod + Send + Sync> From<&[T]> for Buffer<T> {
    fn from(values: &[T]) -> Self {
        let mut buffer = Self::zeroed(values.len());
        buffer.copy_from_slice(values);
        buffer
    }
}

/// A large vector is copied into large pages.
impl<T: Pod + Send + Sync> From<Vec<T>> for Buffer<T> {
    fn from(values: Vec<T>) -> Self {
        if values.len() * size_of::<T>() < MAPPED {
            Self(Storage::Small(values))
        } else {
            Self::from(&values[..])
        }
    }
}

impl<T: Pod + Send + Sync> Clone for Buffer<T> {
    fn clone(&self) -> Self {
        Self::from(&self[..])
    }
}

impl<T: Pod> Default for Buffer<T> {
    fn default() -> Self {
        Self(Storage::Small(Vec::new()))
    }
}

impl<T: Pod + PartialEq> PartialEq for Buffer<T> {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self[..].fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Small or mapped, a buffer holds what it was given, and a copy is its own.
    #[test]
    fn buffers_hold_their_values() {
        for len in [0, 1, 1000, MAPPED / 12 - 1, MAPPED / 12 + 1, 3 * MAPPED / 12 + 5] {
            let value = |at: usize| [at as i32, -(at as i32), 7];
            let buffer = Buffer::of(len, value);
            assert_eq!(buffer.len(), len);
            assert!(buffer.iter().enumerate().all(|(at, &x)| x == value(at)), "{len}");
            let mut copy = buffer.clone();
            assert!(copy == buffer && Buffer::from(buffer.to_vec()) == buffer, "{len}");
            if let Some(last) = copy.last_mut() {
                *last = [1; 3];
                assert!(copy != buffer, "{len}");
            }
            assert!(Buffer::<[f32; 3]>::zeroed(len).iter().all(|x| *x == [0.0; 3]), "{len}");
        }
    }
}
