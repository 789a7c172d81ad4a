//! The files of a folder of frames: checked all at once when it is opened, decoded when they are asked for by a thread of
//! their own, which goes on with the next ones. Whoever asks waits only for a frame that is not decoded in time.

use crate::contract::RenderError;
use crate::gpu::Gpu;
use crate::pictures;
use crate::registry::AddError;
use experiments::study::frames::{FilesFault, Frames, MANIFEST, parse_frames};
use std::collections::{HashMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

/// Frames of each level that are decoded ahead of the one that is shown.
const AHEAD: u32 = 3;
/// Bytes of decoded frames that are kept; what is shown and what comes next is kept whatever it takes.
const KEPT_BYTES: usize = 256 << 20;
/// Files named in one message.
const NAMED_FILES: usize = 3;
/// Bytes of the longest manifest that is read.
const LONGEST_MANIFEST: u64 = 1 << 20;

/// A decoded frame: half floats RGBA, row by row from the top.
pub(super) struct Decoded {
    size: [u32; 2],
    halves: Vec<u16>,
}

/// A level and a frame.
type Key = (usize, u32);

/// A folder of frames.
pub(crate) struct FrameStore {
    shared: Arc<Shared>,
    manifest: String,
    /// Whether a thread decodes; it is started when the first frame is asked for.
    thread: OnceLock<bool>,
}

struct Shared {
    folder: PathBuf,
    frames: Frames,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    decoded: HashMap<Key, Result<Arc<Decoded>, RenderError>>,
    /// Decoded frames, the one that was used longest ago first.
    used: VecDeque<Key>,
    wanted: VecDeque<Key>,
    /// What the thread is at.
    busy: Option<Key>,
    closed: bool,
}

impl FrameStore {
    /// Reads the manifest and looks at every file's head.
    ///
    /// # Errors
    /// Every mistake of the manifest; if there is none, every file that is missing, odd or outside the folder.
    pub(crate) fn open(folder: &Path) -> Result<Self, AddError> {
        let file = folder.join(MANIFEST);
        let name = file.display().to_string();
        let refused = |reason: String| AddError::File { file: name.clone(), reason };
        let cannot = |error: std::io::Error| refused(format!("expected a manifest that can be read, found: {error}"));
        let length = std::fs::metadata(&file).map_err(cannot)?.len();
        if length > LONGEST_MANIFEST {
            return Err(refused(format!("expected at most {LONGEST_MANIFEST} bytes, found {length}")));
        }
        let manifest = std::fs::read_to_string(&file).map_err(cannot)?;
        let frames = parse_frames(&name, &manifest, |frames| look(folder, frames)).map_err(Box::new)?;
        let shared = Shared { folder: folder.to_owned(), frames, state: Mutex::default(), changed: Condvar::new() };
        Ok(Self { shared: Arc::new(shared), manifest, thread: OnceLock::new() })
    }

    /// The manifest.
    pub(crate) fn frames(&self) -> &Frames {
        &self.shared.frames
    }

    /// The manifest's text.
    pub(crate) fn manifest(&self) -> &str {
        &self.manifest
    }

    /// The manifest's path, for messages.
    pub(super) fn name(&self) -> String {
        self.shared.folder.join(MANIFEST).display().to_string()
    }

    /// Every file, relative to the folder, level by level.
    pub(crate) fn files(&self) -> Vec<String> {
        let frames = self.frames();
        let keys = (0..frames.levels.len()).flat_map(|level| (0..frames.count).map(move |frame| (level, frame)));
        keys.filter_map(|(level, frame)| frames.file(level, frame)).collect()
    }

    /// A frame, decoded. Waits for it if it is not yet.
    ///
    /// # Errors
    /// When the file can no longer be read.
    pub(super) fn picture(&self, level: usize, frame: u32) -> Result<Arc<Decoded>, RenderError> {
        let key = (level, frame);
        let threaded = self.start_thread();
        let mut state = self.shared.lock();
        loop {
            if let Some(found) = state.decoded.get(&key).cloned() {
                state.touch(key);
                return found;
            }
            if !threaded {
                drop(state);
                let found = self.shared.decode(key);
                self.shared.lock().keep(key, found.clone(), &self.shared.frames);
                return found;
            }
            if state.busy != Some(key) && state.wanted.front() != Some(&key) {
                state.wanted.retain(|wanted| *wanted != key);
                state.wanted.push_front(key);
                self.shared.changed.notify_all();
            }
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Has the frames after `frame` decoded, of these levels, soonest first.
    pub(super) fn look_ahead(&self, levels: &[usize], frame: u32) {
        if !self.start_thread() {
            return;
        }
        let frames = &self.shared.frames;
        let mut state = self.shared.lock();
        // What was wanted of these levels before is out of date.
        state.wanted.retain(|(level, _)| !levels.contains(level));
        for step in 1..=AHEAD.min(frames.count - 1) {
            let next = frames.at((f64::from(frame) + f64::from(step) + 0.5) / frames.fps);
            for &level in levels {
                let key = (level, next);
                if !state.decoded.contains_key(&key) && state.busy != Some(key) && !state.wanted.contains(&key) {
                    state.wanted.push_back(key);
                }
            }
        }
        self.shared.changed.notify_all();
    }

    fn start_thread(&self) -> bool {
        *self.thread.get_or_init(|| {
            let shared = Arc::clone(&self.shared);
            std::thread::Builder::new().name("frame decoder".to_owned()).spawn(move || shared.work()).is_ok()
        })
    }
}

impl Drop for FrameStore {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.changed.notify_all();
    }
}

impl std::fmt::Debug for FrameStore {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FrameStore").field("folder", &self.shared.folder).finish_non_exhaustive()
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The decoding thread: one frame after the other, until the folder is closed.
    fn work(&self) {
        let mut state = self.lock();
        while !state.closed {
            let Some(key) = state.wanted.pop_front() else {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            if state.decoded.contains_key(&key) {
                continue;
            }
            state.busy = Some(key);
            drop(state);
            let found = self.decode(key);
            state = self.lock();
            state.busy = None;
            state.keep(key, found, &self.frames);
            self.changed.notify_all();
        }
    }

    fn decode(&self, (level, frame): Key) -> Result<Arc<Decoded>, RenderError> {
        let path = self.frames.file(level, frame).map(|file| self.folder.join(file)).unwrap_or_default();
        let refused = |reason| RenderError::File { file: path.display().to_string(), reason };
        let picture = pictures::read(&path, self.frames.colour).map_err(refused)?;
        let [width, height] = self.frames.size_px;
        if picture.size != [width, height] {
            let [found_width, found_height] = picture.size;
            return Err(refused(format!("expected {width}×{height} pixels, found {found_width}×{found_height}")));
        }
        let halves = picture.rgba.iter().flatten().map(|&x| half::f16::from_f32(x).to_bits()).collect();
        Ok(Arc::new(Decoded { size: picture.size, halves }))
    }
}

impl State {
    fn touch(&mut self, key: Key) {
        self.used.retain(|used| *used != key);
        self.used.push_back(key);
    }

    /// Keeps a frame, and lets go of those used longest ago.
    fn keep(&mut self, key: Key, found: Result<Arc<Decoded>, RenderError>, frames: &Frames) {
        self.decoded.insert(key, found);
        self.touch(key);
        let [width, height] = frames.size_px.map(|x| x as usize);
        let affordable = KEPT_BYTES / (8 * width * height).max(1);
        let needed = frames.levels.len() * (AHEAD as usize + 2);
        while self.used.len() > affordable.max(needed) {
            if let Some(oldest) = self.used.pop_front() {
                self.decoded.remove(&oldest);
            }
        }
    }
}

/// Writes a frame into a layer of a texture of its size, before whatever is submitted next.
pub(super) fn upload(gpu: &Gpu, texture: &wgpu::Texture, layer: u32, picture: &Decoded) {
    let [width, height] = picture.size;
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y: 0, z: layer }, ..texture.as_image_copy() },
        bytemuck::cast_slice(&picture.halves),
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * width), rows_per_image: Some(height) },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
}

/// What is wrong with the files of each level.
fn look(folder: &Path, frames: &Frames) -> Vec<FilesFault> {
    let home = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let mut faults = Vec::new();
    for level in 0..frames.levels.len() {
        let (mut missing, mut odd, mut outside) = (Vec::new(), Vec::new(), Vec::new());
        for frame in 0..frames.count {
            let Some(file) = frames.file(level, frame) else { continue };
            let path = folder.join(&file);
            match path.canonicalize() {
                Err(_) => missing.push(file),
                // A link may lead anywhere.
                Ok(real) if !real.starts_with(&home) => outside.push(file),
                Ok(_) => match pictures::size(&path) {
                    Ok(size) if size == frames.size_px => {}
                    Ok([width, height]) => odd.push(format!("{file} with {width}×{height}")),
                    Err(reason) => odd.push(format!("{file}: {reason}")),
                },
            }
        }
        let [width, height] = frames.size_px;
        let count = frames.count;
        let mut say = |expected: String, found: &[String]| {
            if !found.is_empty() {
                faults.push(FilesFault { level, message: format!("expected {expected}, found {}", some(found)) });
            }
        };
        say(format!("{count} files"), &missing.iter().map(|file| format!("no {file}")).collect::<Vec<_>>());
        say("files within the folder".to_owned(), &outside);
        say(format!("pictures of {width}×{height} pixels"), &odd);
    }
    faults
}

/// The first few of a list, and how many more there are.
fn some(list: &[String]) -> String {
    let named = list.iter().take(NAMED_FILES).cloned().collect::<Vec<_>>().join(", ");
    match list.len().saturating_sub(NAMED_FILES) {
        0 => named,
        more => format!("{named} and {more} more like it"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    /// Six frames of two levels.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for (level, name) in ["fine", "coarse"].into_iter().enumerate() {
            for frame in 0..6_u8 {
                let colour = image::Rgb([10 * frame, 100 * level as u8, 7]);
                let file = folder.path().join(format!("{name}-{frame}.png"));
                image::RgbImage::from_pixel(8, 4, colour).save(file).expect("writable");
            }
        }
        let manifest = r#"{ "format": 1, "size_px": [8, 4], "fps": 25, "frames": 6, "end": "loop",
            "reference": { "files": "fine-{frame}.png" },
            "levels": [{ "name": "coarse", "files": "coarse-{frame}.png" }] }"#;
        std::fs::write(folder.path().join(MANIFEST), manifest).expect("writable");
        folder
    }

    fn decoded(store: &FrameStore) -> Vec<Key> {
        let mut keys: Vec<Key> = store.shared.lock().decoded.keys().copied().collect();
        keys.sort_unstable();
        keys
    }

    #[test]
    fn the_next_frames_are_decoded_before_they_are_asked_for() {
        let folder = folder();
        let store = FrameStore::open(folder.path()).expect("a folder of frames");
        assert!(decoded(&store).is_empty(), "nothing is decoded before it is needed");
        let first = store.picture(1, 4).expect("decoded");
        assert_eq!(half::f16::from_bits(first.halves[1]).to_f32(), half::f16::from_f32(0.127_437_7).to_f32());
        store.look_ahead(&[1], 4);
        // Round the end: 5, 0, 1.
        let began = Instant::now();
        while decoded(&store) != [(1, 0), (1, 1), (1, 4), (1, 5)] {
            assert!(began.elapsed() < Duration::from_secs(20), "{:?}", decoded(&store));
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_frame_that_is_gone_is_an_error_and_no_wait() {
        let folder = folder();
        let store = FrameStore::open(folder.path()).expect("a folder of frames");
        std::fs::remove_file(folder.path().join("fine-2.png")).expect("removable");
        let error = store.picture(0, 2).err().expect("an error").to_string();
        assert!(error.contains("fine-2.png: expected a file that can be read"), "{error}");
        image::RgbImage::new(8, 5).save(folder.path().join("fine-3.png")).expect("writable");
        let error = store.picture(0, 3).err().expect("an error").to_string();
        assert!(error.contains("expected 8×4 pixels, found 8×5"), "{error}");
    }

    /// Of frames that are too large to keep many, those used longest ago go first.
    #[test]
    fn memory_is_bounded() {
        let folder = folder();
        let store = FrameStore::open(folder.path()).expect("a folder of frames");
        let large = Frames { size_px: [16_384, 16_384], ..store.frames().clone() };
        let mut state = State::default();
        for frame in 0..100 {
            state.keep((0, frame), Ok(Arc::new(Decoded { size: [1, 1], halves: vec![0; 4] })), &large);
        }
        assert_eq!(state.decoded.len(), 2 * (AHEAD as usize + 2));
        assert!(state.decoded.contains_key(&(0, 99)) && !state.decoded.contains_key(&(0, 0)));
    }
}
