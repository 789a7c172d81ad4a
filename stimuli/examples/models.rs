//! Reads glTF files and says what is in them: triangles, cameras, animations, notices, or everything that is wrong.
//!
//! `cargo run --release -p stimuli --example models -- FILE...`

use std::io::Write;
use std::path::Path;
use stimuli::GltfFile;

fn main() -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    for name in std::env::args().skip(1) {
        match GltfFile::read(Path::new(&name)) {
            Ok(file) => {
                let (triangles, cameras, animations) = (file.triangles(), file.cameras(), file.animations());
                writeln!(out, "{name}: {triangles} triangles, {cameras} cameras, {animations} animations")?;
                for notice in file.notices() {
                    writeln!(out, "  note: {notice}")?;
                }
            }
            Err(error) => writeln!(out, "{error}")?,
        }
    }
    Ok(())
}
