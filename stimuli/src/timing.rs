//! GPU time of a renderer's frames by timestamp queries, read back without ever waiting unless asked to.

use crate::gpu::Gpu;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const IDLE: u8 = 0;
const PENDING: u8 = 1;
const ARRIVED: u8 = 2;
const FAILED: u8 = 3;

/// Measures one renderer's frames, at most one in flight.
#[derive(Debug)]
pub(crate) struct GpuTimer {
    queries: Option<Queries>,
    last_s: Option<f64>,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    state: Arc<AtomicU8>,
    /// Whether the frame being recorded is measured.
    measuring: bool,
}

impl GpuTimer {
    /// A timer, which measures nothing where the device cannot.
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        let queries = gpu.timestamps.then(|| Queries {
            set: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("frame"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readback: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            state: Arc::new(AtomicU8::new(IDLE)),
            measuring: false,
        });
        Self { queries, last_s: None }
    }

    /// Starts measuring, if the previous measurement has arrived.
    pub(crate) fn begin(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
        self.collect(gpu);
        if let Some(queries) = &mut self.queries {
            queries.measuring = queries.state.load(Ordering::Acquire) == IDLE;
            if queries.measuring {
                encoder.write_timestamp(&queries.set, 0);
            }
        }
    }

    /// Ends measuring, submits the frame and returns the newest time known, in seconds.
    pub(crate) fn submit(&mut self, gpu: &Gpu, mut encoder: wgpu::CommandEncoder) -> Option<f64> {
        let measured = self.queries.as_mut().filter(|queries| queries.measuring);
        if let Some(queries) = &measured {
            encoder.write_timestamp(&queries.set, 1);
            encoder.resolve_query_set(&queries.set, 0..2, &queries.resolved, 0);
            encoder.copy_buffer_to_buffer(&queries.resolved, 0, &queries.readback, 0, 16);
        }
        gpu.queue.submit([encoder.finish()]);
        if let Some(queries) = measured {
            queries.measuring = false;
            queries.state.store(PENDING, Ordering::Release);
            let state = Arc::clone(&queries.state);
            queries.readback.map_async(wgpu::MapMode::Read, .., move |result| {
                state.store(if result.is_ok() { ARRIVED } else { FAILED }, Ordering::Release);
            });
        }
        if gpu.blocking_timing() {
            // A lost device is reported by `Gpu::check` after the frame.
            let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
            self.collect(gpu);
        }
        self.last_s
    }

    /// The newest time known, in seconds.
    pub(crate) fn last_s(&self) -> Option<f64> {
        self.last_s
    }

    fn collect(&mut self, gpu: &Gpu) {
        let Some(queries) = &mut self.queries else { return };
        if queries.state.load(Ordering::Acquire) == PENDING {
            // As in `submit`: reported by `Gpu::check`.
            let _ = gpu.device.poll(wgpu::PollType::Poll);
        }
        if queries.state.load(Ordering::Acquire) == ARRIVED {
            if let Ok(bytes) = queries.readback.get_mapped_range(..) {
                let ticks: [u64; 2] = std::array::from_fn(|i| {
                    let mut word = [0; 8];
                    word.copy_from_slice(&bytes[8 * i..8 * i + 8]);
                    u64::from_le_bytes(word)
                });
                let period_s = f64::from(gpu.queue.get_timestamp_period()) * 1e-9;
                self.last_s = ticks[1].checked_sub(ticks[0]).map(|span| span as f64 * period_s);
            }
            queries.readback.unmap();
            queries.state.store(IDLE, Ordering::Release);
        }
    }
}
