//! Numbers out of buffers. Every view and accessor is held against what it lies in before anything is read, so that
//! reading them cannot leave the buffers, and how much is read from one file is limited.

use super::container::fetch;
use super::document::{self, Document};
use super::errors::Findings;
use std::cell::Cell;
use std::path::Path;

/// How many items (vertices' attributes, indices, keys) are read from one file at most. Elements may share data, so that
/// a small file can ask for any number of them.
pub(crate) const MOST_ITEMS: u64 = 20_000_000;
/// How many items an accessor without data of its own, all zeros, may have.
const MOST_ZEROS: u64 = 1_000_000;

/// Bytes of all buffers of a file together.
const MOST_BUFFER_BYTES: u64 = 1 << 31;
const NO_DATA: &str = "it has no uri, and there is no binary chunk for it";

/// The type of a number in a buffer (glTF 2.0, §3.6.2.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value of its bytes, little-endian; normalised ones are in −1–1 or 0–1 (§3.6.2.2).
    fn value(self, b: &[u8], normalised: bool) -> f32 {
        let (value, most) = match self {
            Self::I8 => (f32::from(b[0] as i8), 127.0),
            Self::U8 => (f32::from(b[0]), 255.0),
            Self::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Self::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Self::U32 => (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, 1.0),
            Self::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        if normalised { (value / most).max(-1.0) } else { value }
    }
}

/// Which numbers an attribute may be made of, and how that is said.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Allowed {
    pub(crate) components: fn(Component, bool) -> bool,
    pub(crate) said: &'static str,
}

/// Floats alone.
pub(crate) const FLOATS: Allowed =
    Allowed { components: |component, _| matches!(component, Component::F32), said: "floats (5126)" };

/// The bytes that buffers hold.
#[derive(Debug)]
pub(crate) struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Fetches every buffer; `binary` is the binary chunk of a GLB, the first buffer's data if that has no address.
    pub(crate) fn load(
        document: &Document,
        mut binary: Option<Vec<u8>>,
        folder: &Path,
        findings: &mut Findings,
    ) -> Self {
        let mut loaded = Vec::with_capacity(document.buffers.len());
        let mut bytes_left = MOST_BUFFER_BYTES;
        for (index, buffer) in document.buffers.iter().enumerate() {
            let place = format!("buffers[{index}]");
            let fetched = match &buffer.uri {
                Some(uri) => fetch(uri, folder).map_err(|message| (".uri", message)),
                None if index == 0 => binary.take().ok_or_else(|| ("", NO_DATA.to_owned())),
                None => Err(("", NO_DATA.to_owned())),
            };
            let checked = fetched.and_then(|mut bytes| {
                let (expected, found) = (buffer.byte_length, bytes.len() as u64);
                if found < expected {
                    return Err((
                        ".byteLength",
                        format!("it is {expected}, but there are {found} bytes: the data is cut off"),
                    ));
                }
                bytes.truncate(usize::try_from(expected).unwrap_or(usize::MAX));
                bytes_left = bytes_left
                    .checked_sub(expected)
                    .ok_or_else(|| ("", format!("all buffers together have more than {MOST_BUFFER_BYTES} bytes")))?;
                Ok(bytes)
            });
            match checked {
                Ok(bytes) => loaded.push(bytes),
                Err((part, message)) => {
                    findings.wrong(format!("{place}{part}"), message);
                    loaded.push(Vec::new());
                }
            }
        }
        Self(loaded)
    }

    /// Hands every buffer's bytes on.
    pub(crate) fn each(&self, mut to: impl FnMut(&[u8])) {
        self.0.iter().for_each(|bytes| to(bytes));
    }

    /// The bytes of a buffer view.
    pub(crate) fn view(&self, document: &Document, index: usize) -> Result<&[u8], String> {
        let view = document.buffer_views.get(index).ok_or_else(|| format!("there is no buffer view {index}"))?;
        let buffer = self.0.get(view.buffer).ok_or_else(|| format!("there is no buffer {}", view.buffer))?;
        let end = view.byte_offset.checked_add(view.byte_length).filter(|&end| end <= buffer.len() as u64);
        let end = end.ok_or_else(|| {
            let (from, length) = (view.byte_offset, view.byte_length);
            format!("{length} bytes from {from} on leave the buffer, which has {}", buffer.len())
        })?;
        Ok(&buffer[view.byte_offset as usize..end as usize])
    }
}

/// Where the items of an accessor are.
#[derive(Debug)]
struct Items<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// An accessor that has been held against its buffer.
#[derive(Debug)]
struct Checked<'a> {
    component: Component,
    normalised: bool,
    kind: &'a str,
    count: usize,
    items: Option<Items<'a>>,
    /// Indices of the items that are replaced, and their values.
    sparse: Option<(Vec<u32>, &'a [u8])>,
}

/// All accessors of a file.
#[derive(Debug)]
pub(crate) struct Accessors<'a> {
    checked: Vec<Option<Checked<'a>>>,
    most_items: u64,
    items_left: Cell<u64>,
}

impl<'a> Accessors<'a> {
    /// Checks every buffer view and accessor; at most `most_items` items can be read of them.
    pub(crate) fn check(
        document: &'a Document,
        buffers: &'a Buffers,
        most_items: u64,
        findings: &mut Findings,
    ) -> Self {
        for (index, view) in document.buffer_views.iter().enumerate() {
            let place = format!("bufferViews[{index}]");
            if let Err(message) = buffers.view(document, index) {
                findings.wrong(&*place, message);
            }
            // A stride may lie between 4 and 252 (§5.11.4).
            if let Some(stride) = view.byte_stride.filter(|stride| !(4..=252).contains(stride) || stride % 4 != 0) {
                findings.wrong(
                    format!("{place}.byteStride"),
                    format!("it is {stride}; expected a multiple of 4 from 4 to 252"),
                );
            }
        }
        // Accessors within wrong views would only repeat that.
        let sound = !findings.any();
        let accessors = if sound { document.accessors.as_slice() } else { &[] };
        let checked = accessors.iter().enumerate().map(|(index, accessor)| {
            let place = format!("accessors[{index}]");
            match checked(accessor, document, buffers) {
                Ok(checked) => Some(checked),
                Err((part, message)) => {
                    findings.wrong(format!("{place}{part}"), message);
                    None
                }
            }
        });
        Self { checked: checked.collect(), most_items, items_left: Cell::new(most_items) }
    }

    fn get(&self, index: usize, place: &str, findings: &mut Findings) -> Option<&Checked<'a>> {
        let Some(found) = self.checked.get(index) else {
            findings.wrong(place, format!("there is no accessor {index}; the file has {}", self.checked.len()));
            return None;
        };
        // One that is wrong has been told of already.
        let found = found.as_ref()?;
        match self.items_left.get().checked_sub(found.count as u64) {
            Some(left) => {
                self.items_left.set(left);
                Some(found)
            }
            None => {
                findings.wrong(
                    place,
                    format!("the file asks for more than {} items in all; that is too much", self.most_items),
                );
                None
            }
        }
    }

    /// Reads items of `N` finite numbers each, for the element at `place`.
    pub(crate) fn read<const N: usize>(
        &self,
        index: usize,
        kind: &str,
        allowed: Allowed,
        place: &str,
        findings: &mut Findings,
    ) -> Option<Vec<[f32; N]>> {
        let found = self.get(index, place, findings)?;
        if found.kind != kind || !(allowed.components)(found.component, found.normalised) {
            let normalised = if found.normalised { "normalised " } else { "" };
            let is = format!("accessor {index} has {} of {normalised}{:?}", found.kind, found.component);
            findings.wrong(place, format!("{is}; expected {kind} of {}", allowed.said));
            return None;
        }
        let size = found.component.bytes() as usize;
        let item = |bytes: &[u8]| -> [f32; N] {
            std::array::from_fn(|i| found.component.value(&bytes[i * size..(i + 1) * size], found.normalised))
        };
        let mut values: Vec<[f32; N]> = match &found.items {
            Some(items) => (0..found.count).map(|i| item(&items.bytes[i * items.stride..])).collect(),
            None => vec![[0.0; N]; found.count],
        };
        if let Some((indices, replaced)) = &found.sparse {
            for (&at, bytes) in indices.iter().zip(replaced.chunks_exact(N * size)) {
                values[at as usize] = item(bytes);
            }
        }
        if let Some(bad) = values.iter().position(|value| !value.iter().all(|x| x.is_finite())) {
            let message = format!("item {bad} of accessor {index} is {:?}; expected finite numbers", values[bad]);
            findings.wrong(place, message);
            return None;
        }
        Some(values)
    }

    /// Reads indices, for the element at `place`; each must be below `count`.
    pub(crate) fn read_indices(
        &self,
        index: usize,
        count: usize,
        place: &str,
        findings: &mut Findings,
    ) -> Option<Vec<u32>> {
        let found = self.get(index, place, findings)?;
        let whole = matches!(found.component, Component::U8 | Component::U16 | Component::U32) && !found.normalised;
        if found.kind != "SCALAR" || !whole {
            let is = format!("accessor {index} has {} of {:?}", found.kind, found.component);
            findings.wrong(place, format!("{is}; expected SCALAR of unsigned whole numbers (5121, 5123, 5125)"));
            return None;
        }
        let (Some(items), None) = (&found.items, &found.sparse) else {
            findings
                .wrong(place, format!("accessor {index} has no data of its own, or is sparse; indices must be plain"));
            return None;
        };
        let values: Vec<u32> =
            (0..found.count).map(|i| whole_number(&items.bytes[i * items.stride..], found.component)).collect();
        if let Some((at, value)) = values.iter().enumerate().find(|&(_, &value)| value as usize >= count) {
            findings.wrong(place, format!("index {at} of accessor {index} is {value}, but there are {count} vertices"));
            return None;
        }
        Some(values)
    }
}

fn whole_number(b: &[u8], component: Component) -> u32 {
    match component.bytes() {
        1 => u32::from(b[0]),
        2 => u32::from(u16::from_le_bytes([b[0], b[1]])),
        _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    }
}

/// Bytes of one item; the columns of matrices begin at multiples of four bytes (§3.6.2.4).
fn item_bytes(kind: &str, component: Component) -> Option<u64> {
    let columns = |count: u64| count * (count * component.bytes()).next_multiple_of(4);
    Some(match kind {
        "SCALAR" => component.bytes(),
        "VEC2" => 2 * component.bytes(),
        "VEC3" => 3 * component.bytes(),
        "VEC4" => 4 * component.bytes(),
        "MAT2" => columns(2),
        "MAT3" => columns(3),
        "MAT4" => columns(4),
        _ => return None,
    })
}

/// The bytes of `count` items of `size` bytes, `stride` apart, from `offset` on in a view.
fn lies_within(view: &[u8], offset: u64, count: u64, size: u64, stride: u64) -> Result<&[u8], String> {
    let needed = || count.checked_sub(1)?.checked_mul(stride)?.checked_add(size)?.checked_add(offset);
    match needed() {
        Some(end) if end <= view.len() as u64 => Ok(&view[offset as usize..end as usize]),
        _ => Err(format!(
            "{count} items of {size} bytes, {stride} apart from byte {offset} on, leave the buffer view, which has {} bytes",
            view.len()
        )),
    }
}

type Fault = (&'static str, String);

fn checked<'a>(
    accessor: &'a document::Accessor,
    document: &'a Document,
    buffers: &'a Buffers,
) -> Result<Checked<'a>, Fault> {
    let component = Component::of(accessor.component_type)
        .ok_or_else(|| (".componentType", format!("there is no component type {}", accessor.component_type)))?;
    let size = item_bytes(&accessor.kind, component).ok_or_else(|| {
        (".type", format!("\"{}\" is none of SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4", shown(&accessor.kind)))
    })?;
    if accessor.count == 0 {
        return Err((".count", "it is 0; expected at least 1".to_owned()));
    }
    let items = match accessor.buffer_view {
        None if accessor.count > MOST_ZEROS => {
            return Err((".count", format!("it is {}; at most {MOST_ZEROS} zeros are made", accessor.count)));
        }
        None => None,
        Some(index) => {
            let view = buffers.view(document, index).map_err(|message| (".bufferView", message))?;
            let stride = document.buffer_views.get(index).and_then(|view| view.byte_stride).unwrap_or(size);
            if stride < size {
                return Err((
                    ".bufferView",
                    format!("items of {size} bytes are only {stride} apart in buffer view {index}"),
                ));
            }
            let bytes = lies_within(view, accessor.byte_offset, accessor.count, size, stride).map_err(|m| ("", m))?;
            Some(Items { bytes, stride: stride as usize })
        }
    };
    let sparse =
        accessor.sparse.as_ref().map(|sparse| replaced(sparse, accessor.count, size, document, buffers)).transpose()?;
    Ok(Checked {
        component,
        normalised: accessor.normalized,
        kind: &accessor.kind,
        count: usize::try_from(accessor.count).map_err(|_| (".count", "it is too large".to_owned()))?,
        items,
        sparse,
    })
}

fn replaced<'a>(
    sparse: &document::Sparse,
    count: u64,
    size: u64,
    document: &'a Document,
    buffers: &'a Buffers,
) -> Result<(Vec<u32>, &'a [u8]), Fault> {
    if sparse.count == 0 || sparse.count > count {
        return Err((
            ".sparse.count",
            format!("it is {}; expected 1 to the accessor's own count of {count}", sparse.count),
        ));
    }
    let component = Component::of(sparse.indices.component_type)
        .filter(|component| matches!(component, Component::U8 | Component::U16 | Component::U32))
        .ok_or_else(|| {
            (".sparse.indices.componentType", "expected unsigned whole numbers (5121, 5123, 5125)".to_owned())
        })?;
    let view = |index| buffers.view(document, index);
    let step = component.bytes();
    let indices = view(sparse.indices.buffer_view)
        .and_then(|view| lies_within(view, sparse.indices.byte_offset, sparse.count, step, step))
        .map_err(|message| (".sparse.indices", message))?;
    let values = view(sparse.values.buffer_view)
        .and_then(|view| lies_within(view, sparse.values.byte_offset, sparse.count, size, size))
        .map_err(|message| (".sparse.values", message))?;
    let indices: Vec<u32> = indices.chunks_exact(step as usize).map(|bytes| whole_number(bytes, component)).collect();
    if let Some(bad) = indices.iter().find(|&&index| u64::from(index) >= count) {
        return Err((".sparse.indices", format!("index {bad} is not below the accessor's count of {count}")));
    }
    if indices.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err((".sparse.indices", "they do not rise".to_owned()));
    }
    Ok((indices, values))
}

/// The start of a text from a file.
pub(crate) fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}
