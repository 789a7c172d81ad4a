//! The window stage: real time, a person, the mouse as gaze source, keys as answers.
//!
//! Before the session starts the window shows grey and measures how long frames take. During the session each turn of
//! the loop reads the newest gaze as late as it can, draws, presents, and logs when the frame was due and when it was
//! handed over. Escape pauses, and leaves from there; what other keys say is [`experiments::trial::keys`]'s.

use super::frame_hash::PendingHash;
use super::painter::{Painter, View};
use super::reload::{Change, Reload};
use super::runner::Runner;
use crate::error::LabError;
use crate::gaze::{GazeSource, Mouse};
use crate::session::tables::FrameRow;
use experiments::Display;
use experiments::study::plan::GazePlan;
use experiments::trial::{Input, PhaseName, Presentation, keys};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use stimuli::Registry;
use stimuli::display_pass::DisplayPass;
use stimuli::gpu::Gpu;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Fullscreen, Window, WindowId};

/// Frames shown before the session to measure the refresh interval.
const MEASURED_FRAMES: usize = 60;
/// Frames at the start of the measurement that are left out, while the window settles.
const SETTLING_FRAMES: usize = 10;

/// How a window is opened.
pub struct WindowOptions {
    /// Title of the window.
    pub title: String,
    /// Whether it covers the monitor; else it is as large as the study's display in pixels.
    pub fullscreen: bool,
    /// The display.
    pub display: Display,
    /// Where the fixation mark stands.
    pub gaze: GazePlan,
    /// Where gaze comes from, if not from the mouse.
    pub instead_of_mouse: Option<Box<dyn GazeSource>>,
    /// Scenes and renderers.
    pub registry: Arc<Registry>,
    /// WGSL files of renderers, by name, whose new versions are shown at once; none but in a pilot.
    pub reloaded: Vec<(String, PathBuf)>,
}

/// What the window found out before the session, for the header.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Median time between frames, seconds; with a timer, the declared one.
    pub frame_s: f64,
    /// `vertical blank` or `timer`.
    pub pacing: &'static str,
    /// The adapter and driver.
    pub gpu: String,
}

/// Makes the session once the window is open and measured.
pub type StartSession = Box<dyn FnOnce(&Measured) -> Result<(Runner, f64), LabError>>;

/// Opens a window and runs a session in it until it is finished or left. Returns whether it was finished.
///
/// # Errors
/// When no window or device can be opened, the display does not fit the study's, or the log cannot be written.
pub fn run(options: WindowOptions, start: StartSession) -> Result<bool, LabError> {
    let event_loop = EventLoop::new().map_err(|error| {
        LabError::Failed(format!("cannot open a window: {error}; run with --offscreen to do without one"))
    })?;
    event_loop.set_control_flow(ControlFlow::Poll);
    let mut app = App { options, start: Some(start), stage: None, outcome: Ok(false) };
    event_loop.run_app(&mut app).map_err(|error| LabError::Failed(format!("the window failed: {error}")))?;
    let App { stage, outcome, .. } = app;
    if let Some(Stage { running: Some(mut running), .. }) = stage {
        running.flush_rows(true)?;
        running.runner.close()?;
    }
    outcome
}

struct App {
    options: WindowOptions,
    start: Option<StartSession>,
    stage: Option<Stage>,
    outcome: Result<bool, LabError>,
}

struct Stage {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    painter: Painter,
    /// Frames into 8-bit RGBA, for hashes.
    hash_pass: DisplayPass,
    mouse: Mouse,
    instead_of_mouse: Option<Box<dyn GazeSource>>,
    reload: Option<Reload>,
    /// Times at which measuring frames were presented.
    measuring: Vec<Instant>,
    running: Option<Running>,
}

struct Running {
    runner: Runner,
    /// The instant of session time 0.
    zero: Instant,
    frame_s: f64,
    /// When the next frame is to be presented at the latest, session seconds.
    due_s: f64,
    vertical_blank: bool,
    /// The phase of the frame before.
    shown_phase: Option<u64>,
    rows: VecDeque<(FrameRow, Option<PendingHash>)>,
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.stage.is_none() {
            match Stage::open(event_loop, &mut self.options) {
                Ok(stage) => {
                    stage.window.request_redraw();
                    self.stage = Some(stage);
                }
                Err(error) => self.stop(event_loop, Err(error)),
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        let result = match event {
            WindowEvent::CloseRequested => return self.stop(event_loop, Ok(false)),
            WindowEvent::Resized(size) => {
                if let Some(stage) = &mut self.stage {
                    stage.resize(size);
                }
                Ok(Flow::Stay)
            }
            WindowEvent::CursorMoved { position, .. } => {
                if let Some(stage) = &mut self.stage {
                    stage.cursor_moved([position.x, position.y]);
                }
                Ok(Flow::Stay)
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(&event),
            WindowEvent::RedrawRequested => self.frame(),
            _ => Ok(Flow::Stay),
        };
        match result {
            Ok(Flow::Stay) => {}
            Ok(Flow::Leave { finished }) => self.stop(event_loop, Ok(finished)),
            Err(error) => self.stop(event_loop, Err(error)),
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(stage) = &self.stage else {
            return;
        };
        // With vertical blank the display holds the loop back; with a timer, the loop wakes one frame before one is due.
        if let Some(running) = &stage.running
            && !running.vertical_blank
        {
            let wake_s = (running.due_s - running.frame_s).max(0.0);
            let due = running.zero + Duration::try_from_secs_f64(wake_s).unwrap_or_default();
            if Instant::now() < due {
                event_loop.set_control_flow(ControlFlow::WaitUntil(due));
                return;
            }
        }
        event_loop.set_control_flow(ControlFlow::Poll);
        stage.window.request_redraw();
    }
}

/// The key as answers are made of it; nothing for keys that never answer.
fn key_of(key: &Key) -> Option<keys::Key> {
    Some(match key {
        Key::Named(NamedKey::ArrowLeft) => keys::Key::Left,
        Key::Named(NamedKey::ArrowRight) => keys::Key::Right,
        Key::Named(NamedKey::ArrowUp) => keys::Key::Up,
        Key::Named(NamedKey::ArrowDown) => keys::Key::Down,
        Key::Named(NamedKey::Space) => keys::Key::Space,
        Key::Named(NamedKey::Enter) => keys::Key::Enter,
        Key::Named(NamedKey::Tab) => keys::Key::Tab,
        Key::Named(NamedKey::Backspace) => keys::Key::Backspace,
        Key::Character(text) => {
            let mut characters = text.chars();
            match (characters.next()?, characters.next()) {
                (' ', None) => keys::Key::Space,
                (character, None) => keys::Key::Character(character),
                _ => return None,
            }
        }
        _ => return None,
    })
}

enum Flow {
    Stay,
    Leave { finished: bool },
}

impl App {
    fn stop(&mut self, event_loop: &ActiveEventLoop, outcome: Result<bool, LabError>) {
        self.outcome = outcome;
        event_loop.exit();
    }

    fn key(&mut self, event: &KeyEvent) -> Result<Flow, LabError> {
        let Some(running) = self.stage.as_mut().and_then(|stage| stage.running.as_mut()) else {
            return Ok(Flow::Stay);
        };
        let Some(phase) = running.runner.phase() else {
            return Ok(Flow::Stay);
        };
        // A key that is held down answers once; only what is typed may be taken back in one go.
        let erases = phase.typing.is_some() && event.logical_key == Key::Named(NamedKey::Backspace);
        if event.state != ElementState::Pressed || (event.repeat && !erases) {
            return Ok(Flow::Stay);
        }
        let input = if event.logical_key == Key::Named(NamedKey::Escape) {
            if phase.name == PhaseName::Paused {
                return Ok(Flow::Leave { finished: false });
            }
            Input::Pause
        } else {
            match key_of(&event.logical_key).and_then(|key| keys::answer_for(key, phase)) {
                Some(answer) => Input::Answered { answer },
                None => return Ok(Flow::Stay),
            }
        };
        let now_s = running.zero.elapsed().as_secs_f64();
        running.runner.input(now_s, input)?;
        Ok(Flow::Stay)
    }

    fn frame(&mut self) -> Result<Flow, LabError> {
        let Some(stage) = &mut self.stage else {
            return Ok(Flow::Stay);
        };
        if stage.running.is_some() {
            return stage.session_frame();
        }
        stage.measuring_frame()?;
        if stage.measuring.len() >= MEASURED_FRAMES {
            let measured = stage.measured(&self.options.display);
            if let Some(start) = self.start.take() {
                let (runner, start_s) = start(&measured)?;
                let began = Instant::now();
                let zero =
                    Duration::try_from_secs_f64(start_s).ok().and_then(|offset| began.checked_sub(offset)).ok_or_else(
                        || LabError::Failed("the session is older than this machine's clock reaches".to_owned()),
                    )?;
                for cell in runner.session().plan().blocks.iter().flat_map(|block| &block.cells) {
                    stage.painter.prepare(&cell.condition)?;
                }
                stage.running = Some(Running {
                    runner,
                    zero,
                    frame_s: measured.frame_s,
                    due_s: zero.elapsed().as_secs_f64() + measured.frame_s,
                    vertical_blank: measured.pacing == VERTICAL_BLANK,
                    shown_phase: None,
                    rows: VecDeque::new(),
                });
            }
        }
        Ok(Flow::Stay)
    }
}

const VERTICAL_BLANK: &str = "vertical blank";
const TIMER: &str = "timer";

impl Stage {
    fn open(event_loop: &ActiveEventLoop, options: &mut WindowOptions) -> Result<Self, LabError> {
        let [width, height] = options.display.resolution_px();
        let mut attributes = Window::default_attributes()
            .with_title(&options.title)
            .with_inner_size(PhysicalSize::new(width, height))
            .with_resizable(false);
        if options.fullscreen {
            let monitor = event_loop.primary_monitor().or_else(|| event_loop.available_monitors().next());
            if let Some(size) = monitor.as_ref().map(winit::monitor::MonitorHandle::size)
                && (size.width, size.height) != (width, height)
            {
                return Err(LabError::BadInput(format!(
                    "the monitor has {}×{} pixels and the display \"{}\" {width}×{height}; give the geometry of the \
                     monitor in use with --display",
                    size.width,
                    size.height,
                    options.display.name()
                )));
            }
            attributes = attributes.with_fullscreen(Some(Fullscreen::Borderless(monitor)));
        }
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| LabError::Failed(format!("cannot open a window: {error}")))?;
        window.set_cursor_visible(false);
        let window = Arc::new(window);
        let instance = Gpu::instance();
        let surface = instance
            .create_surface(Arc::clone(&window))
            .map_err(|error| LabError::Failed(format!("cannot draw in the window: {error}")))?;
        let gpu = Gpu::for_surface(&instance, &surface)?;
        let size = window.inner_size();
        if size.width < width || size.height < height {
            tracing::warn!(
                "the window has only {}×{} pixels of the display's {width}×{height}: its edges are cut off",
                size.width,
                size.height
            );
        }
        let capabilities = surface.get_capabilities(&gpu.adapter);
        // Eight bits a channel, without the hardware's own encoding where there is a choice: the display pass encodes.
        let format = [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8Unorm]
            .into_iter()
            .find(|format| capabilities.formats.contains(format))
            .or_else(|| capabilities.formats.first().copied())
            .ok_or_else(|| LabError::Failed("the graphics adapter cannot show anything in this window".to_owned()))?;
        let mut configuration = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| LabError::Failed("the graphics adapter cannot draw in this window".to_owned()))?;
        configuration.format = format;
        configuration.view_formats = Vec::new();
        configuration.present_mode = wgpu::PresentMode::Fifo;
        // One frame in flight: a longer queue would show older gaze.
        configuration.desired_maximum_frame_latency = 1;
        surface.configure(&gpu.device, &configuration);
        let hash_pass = DisplayPass::for_display(&gpu, wgpu::TextureFormat::Rgba8Unorm, &options.display);
        let painter = Painter::new(gpu, &options.registry, &options.display, options.gaze.fixation_deg, format);
        Ok(Self {
            window,
            surface,
            configuration,
            painter,
            hash_pass,
            mouse: Mouse::new(&options.display),
            instead_of_mouse: options.instead_of_mouse.take(),
            reload: Reload::of(options.reloaded.clone()),
            measuring: Vec::new(),
            running: None,
        })
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        self.configuration.width = size.width.max(1);
        self.configuration.height = size.height.max(1);
        self.surface.configure(&self.painter.gpu.device, &self.configuration);
    }

    /// Mouse places are in window pixels; the display stands in the window's middle.
    fn cursor_moved(&mut self, window_px: [f64; 2]) {
        if let Some(running) = &self.running {
            let [width, height] = running.runner.session().plan().display.resolution_px();
            let margin = [
                f64::from((self.configuration.width as i32 - width as i32) >> 1),
                f64::from((self.configuration.height as i32 - height as i32) >> 1),
            ];
            let now_s = running.zero.elapsed().as_secs_f64();
            self.mouse.moved(now_s, [window_px[0] - margin[0], window_px[1] - margin[1]]);
        }
    }

    /// The next texture of the window; nothing when this frame cannot be shown.
    fn acquire(&mut self) -> Result<Option<wgpu::SurfaceTexture>, LabError> {
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => {
                Ok(Some(texture))
            }
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Occluded => Ok(None),
            wgpu::CurrentSurfaceTexture::Outdated | wgpu::CurrentSurfaceTexture::Lost => {
                self.surface.configure(&self.painter.gpu.device, &self.configuration);
                Ok(None)
            }
            wgpu::CurrentSurfaceTexture::Validation => {
                self.painter.gpu.check()?;
                Ok(None)
            }
        }
    }

    fn show(
        &mut self,
        texture: wgpu::SurfaceTexture,
        view: &View<'_>,
    ) -> Result<Option<stimuli::contract::FrameCost>, LabError> {
        let target = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let target_px = [self.configuration.width, self.configuration.height];
        let cost = self.painter.paint(view, &target, target_px)?;
        self.window.pre_present_notify();
        self.painter.gpu.queue.present(texture);
        Ok(cost)
    }

    fn measuring_frame(&mut self) -> Result<(), LabError> {
        if let Some(texture) = self.acquire()? {
            let view = View::blank(&Presentation::Grey);
            self.show(texture, &view)?;
            self.measuring.push(Instant::now());
        }
        Ok(())
    }

    /// The median interval; a display that does not hold frames back is paced by a timer at its declared rate.
    fn measured(&self, display: &Display) -> Measured {
        let settled = self.measuring.get(SETTLING_FRAMES..).unwrap_or_default();
        let mut intervals: Vec<f64> = settled.windows(2).map(|pair| (pair[1] - pair[0]).as_secs_f64()).collect();
        intervals.sort_by(f64::total_cmp);
        let median = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
        let declared = 1.0 / display.refresh_hz();
        let info = &self.painter.gpu.adapter_info;
        let gpu = format!("{} ({:?}, {} {})", info.name, info.backend, info.driver, info.driver_info);
        if median < 0.7 * declared {
            tracing::warn!(
                "frames take {:.2} ms where the display declares {:.2} ms: nothing waits for the vertical blank, so a \
                 timer paces them",
                median * 1e3,
                declared * 1e3
            );
            return Measured { frame_s: declared, pacing: TIMER, gpu };
        }
        if median > 1.3 * declared {
            tracing::warn!("frames take {:.2} ms where the display declares {:.2} ms", median * 1e3, declared * 1e3);
        }
        Measured { frame_s: median, pacing: VERTICAL_BLANK, gpu }
    }

    fn session_frame(&mut self) -> Result<Flow, LabError> {
        let Some(mut running) = self.running.take() else {
            return Ok(Flow::Stay);
        };
        let flow = self.run_frame(&mut running);
        self.running = Some(running);
        flow
    }

    fn run_frame(&mut self, running: &mut Running) -> Result<Flow, LabError> {
        let acquired = self.acquire()?;

        // Read the gaze as late as possible, then let time pass up to this frame.
        let now_s = running.zero.elapsed().as_secs_f64();
        let mut samples = Vec::new();
        match &mut self.instead_of_mouse {
            Some(source) => source.poll(now_s, &mut samples),
            None => self.mouse.poll(now_s, &mut samples),
        }
        for sample in samples {
            running.runner.gaze_sample(now_s, sample)?;
        }
        // A frame that is already late shows the present, not the moment it was due for.
        let scheduled_s = running.due_s;
        let shown_s = scheduled_s.max(now_s - running.frame_s);
        running.runner.tick(shown_s, running.frame_s)?;
        let (Some(view), Some(texture)) = (running.runner.view(shown_s), acquired) else {
            running.due_s = now_s + running.frame_s;
            running.flush_rows(false)?;
            let finished = running.runner.session().finished();
            return Ok(if finished { Flow::Leave { finished } } else { Flow::Stay });
        };

        // A pilot shows new versions of its renderers at once.
        while let Some(Change { name, file, text }) = self.reload.as_ref().and_then(Reload::take) {
            let file = file.display().to_string();
            match self.painter.replace_wgsl(&name, &text, &file) {
                Ok(()) => tracing::warn!("{file}: a new version is shown; what follows cannot be replayed"),
                Err(error) => tracing::warn!("the last version is still shown:\n{error}"),
            }
        }

        // Draw, present, and note when.
        let cost = self.show(texture, &view)?;
        let presented_s = running.zero.elapsed().as_secs_f64();
        let new_phase = running.shown_phase.replace(running.runner.phase_seq()) != Some(running.runner.phase_seq());
        // Before a trial's first picture there is fixation, or the task is explained. A trial that has neither may show
        // its first frame late, which is logged: what comes next is not known while the last trial is being saved.
        let before_pictures =
            running.runner.phase().is_some_and(|phase| matches!(phase.name, PhaseName::Fixate | PhaseName::Task));
        if new_phase && before_pictures {
            self.painter.warm_up(&view)?;
        }
        let missed = presented_s - scheduled_s > 0.5 * running.frame_s;
        let first_of_interval = new_phase && matches!(view.presentation, Presentation::Stimulus(_));
        let hash = first_of_interval.then(|| PendingHash::start(&self.painter, &self.hash_pass, &view));
        if let Some(mut row) = running.runner.frame_row(scheduled_s, view.animation_s) {
            row.presented_s = presented_s;
            row.missed = missed;
            row.gaze_age_s = running.runner.gaze().map(|gaze| presented_s - gaze.t_s);
            row.pixels_shaded = Some(cost.map_or(0, |cost| cost.pixels_shaded));
            row.gpu_time_s = cost.and_then(|cost| cost.gpu_time_s);
            running.rows.push_back((row, hash));
        }
        running.runner.count_frame();
        // The display's own clock leads where there is one: counting on from what was due would drift away from it.
        running.due_s = if running.vertical_blank || missed { presented_s } else { scheduled_s } + running.frame_s;
        // An error of the device is looked for here; it never waits.
        let _ = self.painter.gpu.device.poll(wgpu::PollType::Poll);
        self.painter.gpu.check()?;
        running.flush_rows(false)?;
        Ok(Flow::Stay)
    }
}

impl Running {
    /// Sends rows whose hashes have arrived to the log, in order; with `last`, all rows, hashed or not.
    fn flush_rows(&mut self, last: bool) -> Result<(), LabError> {
        while let Some((row, pending)) = self.rows.front_mut() {
            if let Some(pending) = pending {
                match pending.arrived() {
                    Some(print) => {
                        let print = print.map(|print| (print.hash, print.signature));
                        (row.hash, row.signature) = print.unzip();
                    }
                    None if last => {}
                    None => return Ok(()),
                }
            }
            if let Some((row, _)) = self.rows.pop_front() {
                self.runner.log_frame(row)?;
            }
        }
        Ok(())
    }
}
