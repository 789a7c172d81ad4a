//! The replay's window: winit, egui and a drawing thread around [`super::panel`]. It rests until something happens.

use super::Replay;
use super::export::Look;
use super::panel::{self, Desk, Pictures, Shown};
use super::worker::{Done, Wanted, Worker};
use crate::error::LabError;
use egui::{ColorImage, TextureHandle, TextureOptions, ViewportId};
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::Instant;
use stimuli::Registry;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// Pictures narrower than this are enlarged pixel by pixel.
const SMALL_PX: usize = 400;

/// How the window begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// What is switched on.
    pub look: Look,
    /// The trial to begin with.
    pub trial: Option<u32>,
}

/// Opens a window with a replay and returns when it is closed.
///
/// # Errors
/// When there is no such trial, no window or device can be opened, or a frame cannot be drawn.
pub fn run(replay: Arc<Replay>, registry: Arc<Registry>, options: Options) -> Result<(), LabError> {
    if let Some(trial) = options.trial
        && !replay.frames().iter().any(|frame| frame.trial == Some(trial))
    {
        return Err(LabError::BadInput(format!("--trial {trial}: expected a trial with frames")));
    }
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(|error| {
        LabError::Failed(format!("cannot open a window: {error}; --frames, --video and --verify do without one"))
    })?;
    let context = egui::Context::default();
    panel::dress(&context);
    let proxy = event_loop.create_proxy();
    wake_on_request(&context, proxy);
    let teller = context.clone();
    let worker = Worker::start(Arc::clone(&replay), registry, move || teller.request_repaint())?;
    let desk = Desk::new(replay, options.look, options.trial);
    let mut app = App { context, desk, worker, textures: Textures::default(), host: None, wake: None, failed: None };
    event_loop.run_app(&mut app).map_err(|error| LabError::Failed(format!("the window failed: {error}")))?;
    app.failed.map_or(Ok(()), Err)
}

/// Something is to be shown anew at this time.
#[derive(Debug, Clone, Copy)]
struct Wake(Instant);

fn wake_on_request(context: &egui::Context, proxy: EventLoopProxy<Wake>) {
    context.set_request_repaint_callback(move |request| {
        if let Some(at) = Instant::now().checked_add(request.delay) {
            // A loop that is over needs no waking.
            let _ = proxy.send_event(Wake(at));
        }
    });
}

struct App {
    context: egui::Context,
    desk: Desk,
    worker: Worker,
    textures: Textures,
    host: Option<Host>,
    /// When the screen is to be shown again.
    wake: Option<Instant>,
    failed: Option<LabError>,
}

/// The window and what connects egui to it.
struct Host {
    window: Arc<Window>,
    input: egui_winit::State,
    painter: egui_wgpu::winit::Painter,
}

/// The pictures that were drawn last, on the GPU.
#[derive(Default)]
struct Textures {
    seen: Option<Kept>,
    reference: Option<Kept>,
}

struct Kept {
    handle: TextureHandle,
    serial: u64,
    shown: Shown,
}

impl ApplicationHandler<Wake> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.host.is_none() {
            match Host::open(event_loop, &self.context, &self.desk.replay.title) {
                Ok(host) => {
                    host.window.request_redraw();
                    self.host = Some(host);
                }
                Err(error) => self.stop(event_loop, Some(error)),
            }
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, Wake(at): Wake) {
        self.wake = Some(self.wake.map_or(at, |before| before.min(at)));
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(host)) = (cause, &self.host) {
            host.window.request_redraw();
            self.wake = None;
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(host) = &mut self.host else { return };
        let response = host.input.on_window_event(&host.window, &event);
        match event {
            WindowEvent::CloseRequested => self.stop(event_loop, None),
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.show(event_loop) {
                    self.stop(event_loop, Some(error));
                }
            }
            WindowEvent::Resized(size) => {
                if let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) {
                    host.painter.on_window_resized(ViewportId::ROOT, width, height);
                }
                host.window.request_redraw();
            }
            _ if response.repaint => host.window.request_redraw(),
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        match (self.wake, &self.host) {
            (Some(at), Some(host)) if at <= Instant::now() => {
                self.wake = None;
                host.window.request_redraw();
                event_loop.set_control_flow(ControlFlow::Wait);
            }
            (Some(at), _) => event_loop.set_control_flow(ControlFlow::WaitUntil(at)),
            (None, _) => event_loop.set_control_flow(ControlFlow::Wait),
        }
    }
}

impl App {
    fn stop(&mut self, event_loop: &ActiveEventLoop, failed: Option<LabError>) {
        self.failed = self.failed.take().or(failed);
        // The window's surface goes before the loop that it belongs to.
        self.host = None;
        event_loop.exit();
    }

    fn show(&mut self, event_loop: &ActiveEventLoop) -> Result<(), LabError> {
        if let Some(done) = self.worker.take() {
            self.textures.take_in(&self.context, &done?);
        }
        let Some(host) = &mut self.host else { return Ok(()) };
        let input = host.input.take_egui_input(&host.window);
        let (desk, pictures) = (&mut self.desk, self.textures.pictures());
        let mut output = self.context.run_ui(input, |ui| panel::show(ui, desk, &pictures));
        host.input.handle_platform_output_with_event_loop(&host.window, event_loop, output.platform_output);
        let primitives = self.context.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let clear = egui::Rgba::from(panel::palette::BACK).to_array();
        host.painter.paint_and_update_textures(
            ViewportId::ROOT,
            output.pixels_per_point,
            clear,
            &primitives,
            &mut output.textures_delta,
            Vec::new(),
            &host.window,
        );
        if !self.desk.replay.frames().is_empty() {
            self.worker.ask(Wanted { frame: self.desk.player.frame(), reference: self.desk.look.reference });
        }
        Ok(())
    }
}

impl Host {
    fn open(event_loop: &ActiveEventLoop, context: &egui::Context, title: &str) -> Result<Self, LabError> {
        let attributes = Window::default_attributes()
            .with_title(format!("{title} – replay"))
            .with_inner_size(LogicalSize::new(1280.0, 800.0))
            .with_min_inner_size(LogicalSize::new(640.0, 480.0));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| LabError::Failed(format!("cannot open a window: {error}")))?;
        let window = Arc::new(window);
        let setup = egui_wgpu::WgpuSetup::from_display_handle(event_loop.owned_display_handle());
        let configuration = egui_wgpu::WgpuConfiguration { wgpu_setup: setup, ..Default::default() };
        let options = egui_wgpu::RendererOptions::default();
        let mut painter =
            pollster::block_on(egui_wgpu::winit::Painter::new(context.clone(), configuration, false, options));
        pollster::block_on(painter.set_window(ViewportId::ROOT, Some(Arc::clone(&window))))
            .map_err(|error| LabError::Failed(format!("cannot draw into the window: {error}")))?;
        let scale = Some(window.scale_factor() as f32);
        let side = painter.max_texture_side();
        let input = egui_winit::State::new(context.clone(), ViewportId::ROOT, event_loop, scale, window.theme(), side);
        Ok(Self { window, input, painter })
    }
}

impl Textures {
    fn take_in(&mut self, context: &egui::Context, done: &Done) {
        let frame = done.wanted.frame;
        keep(&mut self.seen, context, "seen", &done.seen, frame);
        if let Some(reference) = &done.reference {
            keep(&mut self.reference, context, "reference", reference, frame);
        }
    }

    fn pictures(&self) -> Pictures {
        let shown = |kept: &Option<Kept>| kept.as_ref().map(|kept| kept.shown);
        Pictures { seen: shown(&self.seen), reference: shown(&self.reference) }
    }
}

/// Brings a picture to the GPU, unless it is there already.
fn keep(slot: &mut Option<Kept>, context: &egui::Context, name: &str, drawn: &super::Drawn, frame: usize) {
    if let Some(kept) = slot.as_mut().filter(|kept| kept.serial == drawn.serial) {
        kept.shown.frame = frame;
        return;
    }
    let picture = &drawn.picture;
    let size_px = [picture.width() as usize, picture.height() as usize];
    // Pictures of a display are opaque.
    let image = ColorImage::from_rgba_premultiplied(size_px, picture.as_raw());
    let options = if size_px[0] < SMALL_PX { TextureOptions::NEAREST } else { TextureOptions::LINEAR };
    match slot {
        Some(kept) => {
            kept.handle.set(image, options);
            kept.serial = drawn.serial;
            kept.shown = Shown { texture: kept.handle.id(), size_px, frame };
        }
        None => {
            let handle = context.load_texture(name, image, options);
            let shown = Shown { texture: handle.id(), size_px, frame };
            *slot = Some(Kept { handle, serial: drawn.serial, shown });
        }
    }
}
