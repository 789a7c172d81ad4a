//! The bytes of a file: text or binary container, and what its addresses point to (data in the address itself, or files
//! beside it). Everything is limited in size before it is read.

use super::errors::{Findings, WorldError};
use base64::Engine;
use std::path::{Path, PathBuf};

/// The largest file that is read, bytes.
const MOST_BYTES: u64 = 1 << 30;
const GLB_MAGIC: &[u8] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// A file's text and its binary chunk.
#[derive(Debug)]
pub(crate) struct Container {
    pub(crate) json: Vec<u8>,
    pub(crate) binary: Option<Vec<u8>>,
}

/// A file's bytes.
///
/// # Errors
/// A sentence, when it cannot be read or is too large.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    let about = |error: std::io::Error| format!("the file {} cannot be read: {error}", path.display());
    let metadata = std::fs::metadata(path).map_err(about)?;
    // Anything but a plain file might never end.
    if !metadata.is_file() {
        return Err(format!("{} is not a file", path.display()));
    }
    if metadata.len() > MOST_BYTES {
        return Err(format!("the file {} has {} bytes, at most {MOST_BYTES} are read", path.display(), metadata.len()));
    }
    std::fs::read(path).map_err(about)
}

impl Container {
    /// Takes a `.gltf` or `.glb` apart; which of the two it is, its first bytes tell.
    pub(crate) fn split(bytes: Vec<u8>, findings: &mut Findings) -> Result<Self, WorldError> {
        if !bytes.starts_with(GLB_MAGIC) {
            return Ok(Self { json: bytes, binary: None });
        }
        let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let (Some(version), Some(length)) = (word(4), word(8)) else {
            return Err(
                findings.refuse("GLB header", format!("it has 12 bytes, but the file ends after {}", bytes.len()))
            );
        };
        if version != 2 {
            return Err(
                findings.refuse("GLB header", format!("the container has version {version}; version 2 is read"))
            );
        }
        if length as usize > bytes.len() {
            let found = bytes.len();
            return Err(findings
                .refuse("GLB header", format!("it tells of {length} bytes, but the file has {found}: it is cut off")));
        }
        let bytes = &bytes[..length as usize];
        let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let (mut json, mut binary) = (None, None);
        let mut at = 12;
        for index in 0.. {
            if at >= bytes.len() {
                break;
            }
            let place = format!("GLB chunk {index}");
            let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
                return Err(findings.refuse(place, "its header is cut off"));
            };
            let Some(chunk) = bytes.get(at + 8..).and_then(|rest| rest.get(..size as usize)) else {
                let left = bytes.len() - at - 8;
                return Err(
                    findings.refuse(place, format!("it tells of {size} bytes, but {left} are left: it is cut off"))
                );
            };
            match (index, kind) {
                (0, CHUNK_JSON) => json = Some(chunk.to_vec()),
                (0, _) => return Err(findings.refuse(place, "the first chunk must be JSON")),
                (1, CHUNK_BIN) => binary = Some(chunk.to_vec()),
                // Chunks of kinds that are not known are passed over (glTF 2.0, §4.4.3).
                _ => {}
            }
            // Chunks begin at multiples of four bytes.
            at = (at + 8 + size as usize).next_multiple_of(4);
        }
        let json = json.ok_or_else(|| findings.refuse("GLB header", "there is no chunk after it"))?;
        Ok(Self { json, binary })
    }
}

/// What an address points to, with its media type where the address tells it.
///
/// # Errors
/// A sentence, when the address leads elsewhere than to the file's neighbours or its data cannot be read.
pub(crate) fn fetch(uri: &str, folder: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (head, body) = data.split_once(',').ok_or("the data: address has no comma, so no data")?;
        if !head.ends_with(";base64") {
            return Err("the data: address is not base64".to_owned());
        }
        let engine = base64::engine::general_purpose::STANDARD;
        return engine.decode(body.as_bytes()).map_err(|error| format!("the data: address is not base64: {error}"));
    }
    read_file(&neighbour(uri, folder)?)
}

fn neighbour(uri: &str, folder: &Path) -> Result<PathBuf, String> {
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8().map_err(|_| "the address is not UTF-8")?;
    let has_scheme = decoded.split(['/', '\\']).next().is_some_and(|first| first.contains(':'));
    if has_scheme || Path::new(decoded.as_ref()).is_absolute() {
        let shown: String = decoded.chars().take(80).collect();
        return Err(format!(
            "\"{shown}\" is not the address of a file beside this one; other addresses are not followed"
        ));
    }
    Ok(folder.join(decoded.as_ref()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(bytes: Vec<u8>) -> String {
        let mut findings = Findings::new(Path::new("a.glb"));
        Container::split(bytes, &mut findings).unwrap_err().to_string()
    }

    #[test]
    fn cut_containers_say_where_they_end() {
        let whole = super::super::tests::glb(b"{}  ", &[1, 2, 3, 4]);
        let mut findings = Findings::new(Path::new("a.glb"));
        let container = Container::split(whole.clone(), &mut findings).unwrap();
        assert_eq!((container.json.as_slice(), container.binary.as_deref()), (&b"{}  "[..], Some(&[1, 2, 3, 4][..])));
        for (length, said) in [(7, "GLB header: it has 12 bytes, but the file ends after 7"), (30, "it is cut off")] {
            let text = refused(whole[..length].to_vec());
            assert!(text.contains(said), "{text}");
        }
        // With the length in the header made to fit, the chunk is what is cut.
        let mut cut = whole[..30].to_vec();
        cut[8..12].copy_from_slice(&30_u32.to_le_bytes());
        assert!(refused(cut).contains("GLB chunk 1: its header is cut off"));
        let mut cut = whole[..34].to_vec();
        cut[8..12].copy_from_slice(&34_u32.to_le_bytes());
        assert!(refused(cut).contains("GLB chunk 1: it tells of 4 bytes, but 2 are left"));
        let mut old = whole;
        old[4] = 1;
        assert!(refused(old).contains("version 1"));
    }

    #[test]
    fn addresses_lead_to_neighbours_only() {
        let folder = Path::new("/tmp/models");
        assert_eq!(neighbour("a%20b/c.bin", folder), Ok(folder.join("a b/c.bin")));
        for uri in ["http://example.org/a.bin", "/etc/passwd", "file:a.bin", "C:\\a.bin"] {
            assert!(neighbour(uri, folder).is_err(), "{uri}");
        }
        assert_eq!(fetch("data:application/octet-stream;base64,AQID", folder), Ok(vec![1, 2, 3]));
        assert!(fetch("data:application/octet-stream;base64,A!", folder).is_err());
        assert!(fetch("data:text/plain,abc", folder).unwrap_err().contains("base64"));
        assert!(fetch("no such file.bin", folder).unwrap_err().contains("cannot be read"));
    }
}
