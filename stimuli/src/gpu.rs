//! The graphics device: which adapter is used, what it can do, and what to install when there is none.
//!
//! Nothing here panics for lack of a device. Errors that wgpu reports late (validation, memory, a lost device) are kept
//! and handed out by [`Gpu::check`], so that they become an error of the frame that caused them.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A graphics device with its queue.
#[derive(Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The adapter it was opened on, which knows what a window's surface can do.
    pub adapter: wgpu::Adapter,
    /// Name, driver and backend, as they are written into a session's header.
    pub adapter_info: wgpu::AdapterInfo,
    /// Whether GPU time can be measured.
    pub timestamps: bool,
    blocking_timing: AtomicBool,
    fault: Arc<Mutex<Option<String>>>,
}

/// Why there is no device, or why it stopped working.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GpuError {
    /// No adapter of a supported kind was found.
    #[error(
        "no graphics adapter found (looked for {looked_for}{detail}); install a Vulkan driver: on Debian or Ubuntu, \
         `apt-get install mesa-vulkan-drivers libvulkan1` gives a software one that needs no graphics card"
    )]
    NoAdapter {
        /// The kinds of adapter that were looked for.
        looked_for: &'static str,
        /// What was found instead, empty or starting with a semicolon.
        detail: String,
    },
    /// The adapter refused to open.
    #[error("the graphics adapter \"{adapter}\" refused to open: {reason}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The device reported an error after it was opened.
    #[error("the graphics device reported an error: {0}")]
    Fault(String),
}

/// The kinds of adapter that are used; OpenGL is not one of them.
const BACKENDS: wgpu::Backends = wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

impl Gpu {
    /// An instance that knows Vulkan, Metal and Direct3D 12; wgpu's environment variables are honoured.
    #[must_use]
    pub fn instance() -> wgpu::Instance {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = BACKENDS;
        let mut descriptor = descriptor.with_env();
        descriptor.backends &= BACKENDS;
        wgpu::Instance::new(descriptor)
    }

    /// A device without a window: real hardware before software, Vulkan before the rest.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] when there is none, [`GpuError::NoDevice`] when the best one refuses.
    pub fn headless() -> Result<Self, GpuError> {
        Self::open(&Self::instance(), None)
    }

    /// A device that can present to `surface`, which must come from `instance`.
    ///
    /// # Errors
    /// As [`Gpu::headless`].
    pub fn for_surface(instance: &wgpu::Instance, surface: &wgpu::Surface<'_>) -> Result<Self, GpuError> {
        Self::open(instance, Some(surface))
    }

    fn open(instance: &wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<Self, GpuError> {
        let adapters = pollster::block_on(instance.enumerate_adapters(BACKENDS));
        let found = adapters.len();
        let adapter = adapters
            .into_iter()
            .filter(|adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface)))
            .min_by_key(|adapter| rank(&adapter.get_info()))
            .ok_or_else(|| GpuError::NoAdapter {
                looked_for: "Vulkan, Metal, Direct3D 12",
                detail: if found == 0 {
                    String::new()
                } else {
                    format!("; {found} found, none of which can present to this window")
                },
            })?;
        let adapter_info = adapter.get_info();

        // Ask for timing where it exists, and for everything the adapter's limits allow.
        let timing = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let timestamps = adapter.features().contains(timing);
        let early_depth = adapter.features() & wgpu::Features::SHADER_EARLY_DEPTH_TEST;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("parafovea"),
            required_features: early_depth | if timestamps { timing } else { wgpu::Features::empty() },
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|error| GpuError::NoDevice { adapter: adapter_info.name.clone(), reason: error.to_string() })?;

        // Keep the first late error for `check`; later ones are its consequences.
        let fault = Arc::new(Mutex::new(None));
        let keep = |slot: &Arc<Mutex<Option<String>>>, message: String| {
            slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
        };
        let slot = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&slot, error.to_string())));
        let slot = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                keep(&slot, format!("device lost: {message}"));
            }
        });
        Ok(Self { device, queue, adapter, adapter_info, timestamps, blocking_timing: AtomicBool::new(false), fault })
    }

    /// Whether every frame waits for its own GPU time. Off at first: a window must never wait.
    pub fn set_blocking_timing(&self, blocking: bool) {
        self.blocking_timing.store(blocking, Ordering::Relaxed);
    }

    /// What [`Gpu::set_blocking_timing`] last set.
    #[must_use]
    pub fn blocking_timing(&self) -> bool {
        self.blocking_timing.load(Ordering::Relaxed)
    }

    /// Reports the first error that the device raised since it was opened.
    ///
    /// # Errors
    /// [`GpuError::Fault`], again at every call: a device that failed once is not trusted again.
    pub fn check(&self) -> Result<(), GpuError> {
        match &*self.fault.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(message) => Err(GpuError::Fault(message.clone())),
            None => Ok(()),
        }
    }

    /// Waits until everything submitted so far is done.
    ///
    /// # Errors
    /// [`GpuError::Fault`] when the device is lost.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| GpuError::Fault(error.to_string()))?;
        self.check()
    }
}

/// Preference among adapters, smallest first.
fn rank(info: &wgpu::AdapterInfo) -> (u8, u8) {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    let backend = match info.backend {
        wgpu::Backend::Vulkan | wgpu::Backend::Metal => 0,
        wgpu::Backend::Dx12 => 1,
        _ => 2,
    };
    (kind, backend)
}
