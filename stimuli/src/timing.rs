//! GPU time of a renderer's frames, and of named sections of them, by timestamp queries that are read back without ever
//! waiting unless asked to.

use crate::gpu::Gpu;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const IDLE: u8 = 0;
const PENDING: u8 = 1;
const ARRIVED: u8 = 2;
const FAILED: u8 = 3;

/// Frames that are measured at once. With one, a renderer whose frames alternate might never have the other kind measured.
const SLOTS: u32 = 3;
/// Timestamps of one frame: its begin, its end, and the ends of sections in between.
const MOST_STAMPS: u32 = 8;
/// Bytes of one frame's timestamps.
const SLOT_BYTES: u64 = 8 * MOST_STAMPS as u64;

/// Measures one renderer's frames, a few of them in flight.
#[derive(Debug)]
pub(crate) struct GpuTimer {
    queries: Option<Queries>,
    last_s: Option<f64>,
    sections: Vec<(&'static str, f64)>,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    slots: Vec<Slot>,
    /// The slot of the frame being recorded, if that is measured.
    measuring: Option<usize>,
    /// Frames measured so far.
    frames: u64,
}

#[derive(Debug)]
struct Slot {
    first_query: u32,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    state: Arc<AtomicU8>,
    /// Which of the measured frames it holds.
    frame: u64,
    /// The sections of its frame, in order.
    sections: Vec<&'static str>,
}

impl Slot {
    fn new(gpu: &Gpu, index: u32) -> Self {
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: SLOT_BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            first_query: index * MOST_STAMPS,
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readback: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            state: Arc::new(AtomicU8::new(IDLE)),
            frame: 0,
            sections: Vec::new(),
        }
    }

    /// The query of the next timestamp to be written.
    fn next_query(&self) -> u32 {
        self.first_query + 1 + self.sections.len() as u32
    }

    /// Ticks at the frame's begin, at the end of each section, and at its end.
    fn ticks(&self) -> Vec<u64> {
        let Ok(bytes) = self.readback.get_mapped_range(..) else { return Vec::new() };
        let words = bytes.chunks_exact(8).take(self.sections.len() + 2);
        words.map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])).collect()
    }
}

impl GpuTimer {
    /// A timer, which measures nothing where the device cannot.
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let queries = gpu.timestamps.then(|| Queries {
            set: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("frames"),
                ty: wgpu::QueryType::Timestamp,
                count: SLOTS * MOST_STAMPS,
            }),
            slots: (0..SLOTS).map(|index| Slot::new(gpu, index)).collect(),
            measuring: None,
            frames: 0,
        });
        Self { queries, last_s: None, sections: Vec::new() }
    }

    /// Starts measuring, if one of the previous measurements has arrived.
    pub(crate) fn begin(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
        self.collect(gpu);
        let Some(queries) = &mut self.queries else { return };
        queries.measuring = queries.slots.iter().position(|slot| slot.state.load(Ordering::Acquire) == IDLE);
        if let Some(slot) = queries.measuring.and_then(|index| queries.slots.get_mut(index)) {
            slot.sections.clear();
            slot.frame = queries.frames;
            queries.frames += 1;
            encoder.write_timestamp(&queries.set, slot.first_query);
        }
    }

    /// Ends a section of the frame: what was recorded since its begin or since the section before belongs to `name`.
    pub(crate) fn end_section(&mut self, encoder: &mut wgpu::CommandEncoder, name: &'static str) {
        let Some(queries) = &mut self.queries else { return };
        let Some(slot) = queries.measuring.and_then(|index| queries.slots.get_mut(index)) else { return };
        // One timestamp is kept for the frame's end.
        if slot.sections.len() as u32 + 2 < MOST_STAMPS {
            encoder.write_timestamp(&queries.set, slot.next_query());
            slot.sections.push(name);
        }
    }

    /// Ends measuring, submits the frame and returns the newest time known, in seconds.
    pub(crate) fn submit(&mut self, gpu: &Gpu, mut encoder: wgpu::CommandEncoder) -> Option<f64> {
        let measured = self.queries.as_mut().and_then(|queries| {
            let slot = queries.slots.get(queries.measuring.take()?)?;
            let end = slot.next_query();
            encoder.write_timestamp(&queries.set, end);
            encoder.resolve_query_set(&queries.set, slot.first_query..end + 1, &slot.resolved, 0);
            encoder.copy_buffer_to_buffer(&slot.resolved, 0, &slot.readback, 0, SLOT_BYTES);
            Some(slot)
        });
        gpu.queue.submit([encoder.finish()]);
        if let Some(slot) = measured {
            slot.state.store(PENDING, Ordering::Release);
            let state = Arc::clone(&slot.state);
            slot.readback.map_async(wgpu::MapMode::Read, .., move |result| {
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

    /// The newest time known of the section `name`, in seconds.
    pub(crate) fn section_s(&self, name: &str) -> Option<f64> {
        self.sections.iter().find(|(known, _)| *known == name).map(|&(_, time_s)| time_s)
    }

    fn collect(&mut self, gpu: &Gpu) {
        let Some(queries) = &mut self.queries else { return };
        if queries.slots.iter().any(|slot| slot.state.load(Ordering::Acquire) == PENDING) {
            // As in `submit`: reported by `Gpu::check`.
            let _ = gpu.device.poll(wgpu::PollType::Poll);
        }
        let mut arrived: Vec<&Slot> =
            queries.slots.iter().filter(|slot| slot.state.load(Ordering::Acquire) == ARRIVED).collect();
        arrived.sort_by_key(|slot| slot.frame);
        let period_s = f64::from(gpu.queue.get_timestamp_period()) * 1e-9;
        for slot in arrived {
            let ticks = slot.ticks();
            let span_s =
                |from: usize, to: usize| Some(ticks.get(to)?.checked_sub(*ticks.get(from)?)? as f64 * period_s);
            self.last_s = span_s(0, slot.sections.len() + 1).or(self.last_s);
            for (index, &name) in slot.sections.iter().enumerate() {
                if let Some(time_s) = span_s(index, index + 1) {
                    self.sections.retain(|(known, _)| *known != name);
                    self.sections.push((name, time_s));
                }
            }
            slot.readback.unmap();
            slot.state.store(IDLE, Ordering::Release);
        }
    }
}
