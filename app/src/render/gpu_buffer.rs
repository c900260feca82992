//! A GPU array that grows and is written run by run.

use std::ops::Range;

use super::gpu::{Gpu, GpuError};

/// A buffer that outgrows its room by this factor, so that appending costs a constant per element.
const GROWTH: f64 = 1.5;
/// Room in the smallest buffer, bytes.
const SMALLEST: u64 = 256;

/// Elements of `stride` bytes in a GPU buffer. Elements never written are zero, or what a truncation left there.
pub(super) struct GpuBuffer {
    buffer: wgpu::Buffer,
    what: &'static str,
    stride: u64,
    len: u32,
}

impl GpuBuffer {
    /// An empty array. `stride` must be a multiple of 4, as all copies are.
    pub(super) fn new(gpu: &Gpu, what: &'static str, stride: u64, usage: wgpu::BufferUsages) -> Self {
        debug_assert_eq!(stride % wgpu::COPY_BUFFER_ALIGNMENT, 0);
        let usage = usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        Self { buffer: allocate(gpu, what, SMALLEST, usage), what, stride, len: 0 }
    }

    /// Elements in use.
    pub(super) fn len(&self) -> u32 {
        self.len
    }

    /// The GPU's buffer; replaced by [`Self::reserve`] when it grows.
    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// The bytes of elements in use. Only for arrays that are not empty.
    pub(super) fn slice(&self) -> wgpu::BufferSlice<'_> {
        self.buffer.slice(0..u64::from(self.len) * self.stride)
    }

    /// Writes a run, making room and length for it; says whether the buffer was replaced. Cost: the run, and
    /// when it grows a copy on the GPU.
    pub(super) fn write<T: bytemuck::NoUninit>(
        &mut self,
        gpu: &Gpu,
        start: u32,
        run: &[T],
    ) -> Result<bool, GpuError> {
        debug_assert_eq!(size_of::<T>() as u64, self.stride);
        let Range { end, .. } = self.span(gpu, start, run.len())?;
        let replaced = self.reserve(gpu, end)?;
        self.len = self.len.max(end);
        if !run.is_empty() {
            gpu.queue.write_buffer(&self.buffer, u64::from(start) * self.stride, bytemuck::cast_slice(run));
        }
        Ok(replaced)
    }

    /// Replaces the whole array.
    pub(super) fn replace<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, all: &[T]) -> Result<(), GpuError> {
        self.span(gpu, 0, all.len())?;
        self.len = 0;
        self.write(gpu, 0, all)?;
        Ok(())
    }

    /// Makes the array at least `len` long.
    pub(super) fn extend_to(&mut self, gpu: &Gpu, len: u32) -> Result<(), GpuError> {
        self.span(gpu, 0, len as usize)?;
        self.reserve(gpu, len)?;
        self.len = self.len.max(len);
        Ok(())
    }

    /// Sets all elements to zero, on the GPU.
    pub(super) fn zero(&mut self, gpu: &Gpu) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.buffer, 0, None);
        gpu.queue.submit([encoder.finish()]);
    }

    /// Drops the elements from `len` on; the room stays.
    pub(super) fn truncate(&mut self, len: u32) {
        self.len = self.len.min(len);
    }

    /// Makes room for `count` elements, keeping what is there; says whether the buffer was replaced.
    fn reserve(&mut self, gpu: &Gpu, count: u32) -> Result<bool, GpuError> {
        let needed = u64::from(count) * self.stride;
        if needed <= self.buffer.size() {
            return Ok(false);
        }
        let roomy = (self.buffer.size() as f64 * GROWTH) as u64;
        let size = needed.max(roomy.min(gpu.largest_buffer())).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        let grown = allocate(gpu, self.what, size.min(gpu.largest_buffer()), self.buffer.usage());
        if self.len > 0 {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.buffer, 0, &grown, 0, u64::from(self.len) * self.stride);
            gpu.queue.submit([encoder.finish()]);
        }
        self.buffer = grown;
        Ok(true)
    }

    /// The range of a run, if this device can hold it.
    fn span(&self, gpu: &Gpu, start: u32, count: usize) -> Result<Range<u32>, GpuError> {
        let bytes = (u64::from(start) + count as u64).saturating_mul(self.stride);
        let limit = gpu.largest_buffer().min(u64::from(u32::MAX) * self.stride);
        if bytes > limit {
            return Err(GpuError::TooLarge { what: self.what, bytes, limit });
        }
        Ok(start..start + count as u32)
    }
}

fn allocate(gpu: &Gpu, what: &'static str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(what),
        size,
        usage,
        mapped_at_creation: false,
    })
}
