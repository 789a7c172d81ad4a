//! Draws glTF files and says what is in them: triangles, cameras, animations, notices, or everything that is wrong.
//!
//! `cargo run --release -p stimuli --example models -- FOLDER FILE...` writes `NAME.png` of every file that can be shown.

use experiments::catalogue::{ParameterValue, Parameters};
use experiments::display::Display;
use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use stimuli::{Background, DisplayPass, FrameInput, GltfFile, Gpu, make_renderer, readback};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let folder = arguments.next().ok_or("name a folder")?;
    std::fs::create_dir_all(&folder)?;
    let display = Display::named("demo-540p").ok_or("no such display")?;
    let gpu = Gpu::headless()?;
    let display_pass = DisplayPass::new(&gpu, wgpu::TextureFormat::Rgba8Unorm);
    let mut renderer = make_renderer(&gpu, &display, "reference", &Parameters::new())?;
    let mut out = std::io::stdout().lock();
    for name in arguments {
        let file = match GltfFile::read(&name) {
            Ok(file) => file,
            Err(error) => {
                writeln!(out, "{error}")?;
                continue;
            }
        };
        let (triangles, cameras, animations) = (file.triangles(), file.cameras(), file.animations());
        writeln!(out, "{}: {triangles} triangles, {cameras} cameras, {animations} animations", name.display())?;
        for notice in file.notices() {
            writeln!(out, "  note: {notice}")?;
        }
        // Once as the file says, once from around.
        for (suffix, camera) in [("", None), ("-around", Some(-1.0))] {
            if cameras == 0 && camera.is_some() {
                continue;
            }
            let parameters = camera.map(|index| ("camera_index".to_owned(), ParameterValue::Number(index)));
            let mut scene = file.make(&gpu, &display, &parameters.into_iter().collect())?;
            let frame = FrameInput { animation_s: 0.5, ..FrameInput::default() };
            renderer.render(&gpu, scene.as_mut(), &frame)?;
            let picture = Background::Picture(renderer.output(), scene.light());
            let stem = name.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
            let path = folder.join(format!("{stem}{suffix}.png"));
            readback::displayed(&gpu, &display_pass, display.resolution_px(), picture, None)?.save(&path)?;
        }
    }
    Ok(())
}
