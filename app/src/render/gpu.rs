//! The graphics device: opened without a window, or borrowed from the window.

/// Why a picture cannot be made. Each message is one sentence that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter at all: neither a GPU driver nor a software one.
    #[error(
        "no graphics adapter was found ({0}): install a Vulkan driver, or the software one with \
         `apt-get install mesa-vulkan-drivers libvulkan1`"
    )]
    NoAdapter(wgpu::RequestAdapterError),
    /// There is an adapter, but it gave no device.
    #[error(
        "the graphics adapter {name} could not be opened ({source}): update its driver, or choose another \
         with WGPU_BACKEND or WGPU_ADAPTER_NAME"
    )]
    NoDevice {
        /// The adapter's own name.
        name: String,
        /// What it said.
        source: wgpu::RequestDeviceError,
    },
    /// `WGPU_ADAPTER_NAME` is set and matches nothing.
    #[error("no graphics adapter has {wanted:?} in its name: WGPU_ADAPTER_NAME can be one of: {found}")]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// What there is.
        found: String,
    },
    /// The device cannot read vertex data from shaders, which drawing edges and handles needs.
    #[error(
        "the graphics adapter {0} is too old (no storage buffers in vertex shaders): use its Vulkan driver \
         with WGPU_BACKEND=vulkan, or `apt-get install mesa-vulkan-drivers`"
    )]
    TooOld(String),
    /// More data than one buffer of this device can hold.
    #[error(
        "{what} need {bytes} bytes, and this graphics adapter holds at most {limit} in one buffer: show a \
         coarser level"
    )]
    TooLarge {
        /// Which data.
        what: &'static str,
        /// Bytes needed.
        bytes: u64,
        /// Bytes there can be.
        limit: u64,
    },
    /// A picture of no pixels, or of more than the device can make.
    #[error("a picture of {width}x{height} pixels cannot be made: each side must lie between 1 and {limit}")]
    PictureSize {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// The device's largest side.
        limit: u32,
    },
    /// The picture was drawn but could not be read back.
    #[error(
        "the picture could not be read back from the graphics adapter ({0}): the driver may have reset; try again"
    )]
    ReadBack(String),
}

/// A graphics device and its queue. Cheap to clone: clones share the device.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    name: String,
}

impl Gpu {
    /// Opens an adapter without a window, with all the limits it has.
    ///
    /// `WGPU_BACKEND` (`vulkan`, `gl`, …), `WGPU_POWER_PREF` and `WGPU_ADAPTER_NAME` are honoured. The fastest
    /// adapter comes first; a software one serves when there is no other.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoSuchAdapter`], [`GpuError::NoDevice`], [`GpuError::TooOld`].
    pub fn headless() -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = match std::env::var("WGPU_ADAPTER_NAME") {
            Ok(wanted) => adapter_named(&instance, wanted)?,
            Err(_) => best_adapter(&instance)?,
        };
        let name = adapter_name(&adapter);
        let (device, queue) = pollster::block_on(adapter.request_device(&device_descriptor(&adapter)))
            .map_err(|source| GpuError::NoDevice { name: name.clone(), source })?;
        Self::checked(device, queue, name)
    }

    /// Shares the window's device. Build the window with [`device_descriptor`], or large surfaces will not fit.
    ///
    /// # Errors
    /// [`GpuError::TooOld`].
    pub fn from_window(state: &egui_wgpu::RenderState) -> Result<Self, GpuError> {
        Self::checked(state.device.clone(), state.queue.clone(), adapter_name(&state.adapter))
    }

    /// The adapter in words, e.g. `llvmpipe (LLVM 15.0.6, 256 bits), Vulkan, Mesa 22.3.6`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Waits until all that was submitted is done; for timings.
    pub fn wait(&self) {
        // A lost device cannot be waited for; the next call that reads from it reports it.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
    }

    /// The largest buffer that can hold vertices and be read by shaders, in bytes.
    pub(super) fn largest_buffer(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_buffer_size.min(limits.max_storage_buffer_binding_size)
    }

    /// Refuses a device that cannot pull vertices: edges and handles are drawn as quads made in the shader.
    fn checked(device: wgpu::Device, queue: wgpu::Queue, name: String) -> Result<Self, GpuError> {
        if device.limits().max_storage_buffers_per_shader_stage == 0 {
            return Err(GpuError::TooOld(name));
        }
        Ok(Self { device, queue, name })
    }
}

/// What to ask an adapter for: all the limits it has, and no features. Give this to eframe as
/// `WgpuSetupCreateNew::device_descriptor`, since eframe's own asks for too little.
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        label: Some("bozzetto"),
        required_limits: adapter.limits(),
        ..Default::default()
    }
}

fn best_adapter(instance: &wgpu::Instance) -> Result<wgpu::Adapter, GpuError> {
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::from_env().unwrap_or(wgpu::PowerPreference::HighPerformance),
        ..Default::default()
    };
    pollster::block_on(instance.request_adapter(&options)).map_err(GpuError::NoAdapter)
}

fn adapter_named(instance: &wgpu::Instance, wanted: String) -> Result<wgpu::Adapter, GpuError> {
    let needle = wanted.to_lowercase();
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    match adapters.iter().position(|a| a.get_info().name.to_lowercase().contains(&needle)) {
        Some(found) => Ok(adapters.swap_remove(found)),
        None => {
            let names: Vec<_> = adapters.iter().map(adapter_name).collect();
            let found = if names.is_empty() { "(there is none)".to_owned() } else { names.join("; ") };
            Err(GpuError::NoSuchAdapter { wanted, found })
        }
    }
}

fn adapter_name(adapter: &wgpu::Adapter) -> String {
    let info = adapter.get_info();
    let mut name = format!("{}, {:?}", info.name, info.backend);
    if !info.driver_info.is_empty() {
        name.push_str(", ");
        name.push_str(&info.driver_info);
    }
    name
}
