//! The binary data of a file: buffers, and typed arrays read from them.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::path::Path;

use crate::accessor::{Accessor, Component, Shape, Stretch, View};
use crate::glb::Container;
use crate::json::Cursor;
use crate::log::{Checked, Log};
use crate::uri::{self, Uri};

/// Files beside the imported one are read up to this size.
const FILE_BYTES: u64 = 1 << 32;
/// What may be decoded from any file, however small.
const BUDGET_BYTES: usize = 64 << 20;
/// And for each byte of it: real files share arrays, but not without end.
const BUDGET_PER_BYTE: usize = 64;

enum Source<'a> {
    /// In the file itself.
    Here(Cow<'a, [u8]>),
    /// In a file beside it, read when asked for.
    Beside(String),
    /// Nowhere: a placeholder that an extension fills.
    Nowhere,
}

struct Buffer<'a> {
    place: String,
    length: usize,
    source: Source<'a>,
    loaded: OnceCell<Checked<Vec<u8>>>,
}

/// Buffers, buffer views and accessors.
pub(crate) struct Data<'a> {
    log: &'a Log,
    base_folder: Option<&'a Path>,
    buffers: Vec<Checked<Buffer<'a>>>,
    views: Vec<Checked<View>>,
    accessors: Vec<Checked<Accessor>>,
    allowed_bytes: Cell<usize>,
    decoded_bytes: Cell<usize>,
}

impl<'a> Data<'a> {
    /// Reads and checks all declarations; the contents of other files only when they are asked for.
    pub(crate) fn new(
        root: &Cursor<'a>,
        log: &'a Log,
        container: &Container<'a>,
        base_folder: Option<&'a Path>,
    ) -> Self {
        let buffers: Vec<_> = root
            .objects("buffers")
            .iter()
            .enumerate()
            .map(|(index, at)| read_buffer(at, index, container))
            .collect();
        if buffers.is_empty() && container.bin.is_some_and(|b| !b.is_empty()) {
            log.note("chunk 1", "holds data, but the file has no buffers; it is ignored");
        }
        let lengths: Vec<_> =
            buffers.iter().map(|b| b.as_ref().map(|b| b.length).map_err(|reported| *reported)).collect();
        let views: Vec<_> = root.objects("bufferViews").iter().map(|at| View::read(at, &lengths)).collect();
        let accessors = root.objects("accessors").iter().map(|at| Accessor::read(at, &views)).collect();
        let here = container.json.len() + container.bin.map_or(0, <[u8]>::len);
        Self {
            log,
            base_folder,
            buffers,
            views,
            accessors,
            allowed_bytes: Cell::new(BUDGET_BYTES.saturating_add(here.saturating_mul(BUDGET_PER_BYTE))),
            decoded_bytes: Cell::new(0),
        }
    }

    pub(crate) fn accessor_count(&self) -> usize {
        self.accessors.len()
    }

    pub(crate) fn view_count(&self) -> usize {
        self.views.len()
    }

    pub(crate) fn accessor(&self, index: usize) -> Checked<&Accessor> {
        self.accessors[index].as_ref().map_err(|reported| *reported)
    }

    /// That an accessor is one of the `formats` that `what` may have.
    pub(crate) fn of_format(&self, index: usize, what: &str, formats: &[Format]) -> Checked<&Accessor> {
        let accessor = self.accessor(index)?;
        if formats.iter().any(|f| f.fits(accessor)) {
            return Ok(accessor);
        }
        let wanted: Vec<_> = formats.iter().map(Format::to_string).collect();
        Err(self.log.problem(
            &accessor.place,
            format!("is {}; {what} must be {}", Format::of(accessor), wanted.join(" or ")),
        ))
    }

    /// Takes `bytes` from what a file of this size may ask for, so that a small file that uses one array again and
    /// again cannot fill the memory.
    pub(crate) fn charge(&self, place: &str, bytes: usize) -> Checked<()> {
        let decoded = self.decoded_bytes.get().saturating_add(bytes);
        self.decoded_bytes.set(decoded);
        let allowed = self.allowed_bytes.get();
        if decoded <= allowed {
            return Ok(());
        }
        Err(self.log.problem(
            place,
            format!(
                "is where the file asks for more than {allowed} bytes of data, out of proportion to its size"
            ),
        ))
    }

    fn buffer(&self, index: usize) -> Checked<&[u8]> {
        let buffer = self.buffers[index].as_ref().map_err(|reported| *reported)?;
        match &buffer.source {
            Source::Here(bytes) => Ok(bytes),
            Source::Nowhere => Err(self
                .log
                .problem(&buffer.place, "has no uri; only the first buffer of a binary file may do without")),
            Source::Beside(path) => {
                let load = || {
                    let bytes = uri::read_file(self.base_folder, path, Some(buffer.length), FILE_BYTES)
                        .map_err(|what| self.log.problem(format!("{}.uri", buffer.place), what))?;
                    let more = bytes.len().saturating_mul(BUDGET_PER_BYTE);
                    self.allowed_bytes.set(self.allowed_bytes.get().saturating_add(more));
                    Ok(bytes)
                };
                let loaded = buffer.loaded.get_or_init(load);
                loaded.as_deref().map_err(|reported| *reported)
            }
        }
    }

    /// Notes the buffers that were never needed and so never opened.
    pub(crate) fn note_unopened(&self) {
        for buffer in self.buffers.iter().flatten() {
            if matches!(buffer.source, Source::Beside(_)) && buffer.loaded.get().is_none() {
                let what = "is not opened; nothing that is drawn or played needs it";
                self.log.note(&buffer.place, what);
            }
        }
    }

    /// The bytes of a buffer view.
    pub(crate) fn view_bytes(&self, index: usize) -> Checked<&[u8]> {
        let view = self.views[index].as_ref().map_err(|reported| *reported)?;
        // A loaded buffer has its declared length at least, and the view was checked against that.
        Ok(&self.buffer(view.buffer)?[view.offset..view.offset + view.length])
    }

    /// Whether elements of a view are further apart than their size says.
    pub(crate) fn has_stride(&self, accessor: &Accessor) -> bool {
        let view = accessor.base.as_ref().map(|base| self.views[base.view].as_ref());
        view.is_some_and(|view| view.is_ok_and(|v| v.stride.is_some()))
    }

    /// The elements, packed: no gaps between them, nor between columns of matrices.
    fn packed(&self, accessor: &Accessor) -> Checked<Cow<'_, [u8]>> {
        let size = accessor.shape.components() * accessor.component.bytes();
        let total = accessor.count.saturating_mul(size);
        self.charge(&accessor.place, total)?;
        let mut packed = match &accessor.base {
            Some(base) => self.gather(base, accessor, accessor.count)?,
            None => Cow::Owned(vec![0; total]),
        };
        if let Some(sparse) = &accessor.sparse {
            let values = self.gather(&sparse.values, accessor, sparse.count)?;
            let as_indices =
                Accessor { component: sparse.index_component, shape: Shape::SCALAR, ..accessor.clone() };
            let indices = self.gather(&sparse.indices, &as_indices, sparse.count)?;
            let packed = packed.to_mut();
            let mut next = 0;
            for (place, value) in widen_uints(&indices, sparse.index_component).zip(values.chunks(size)) {
                let place = place as usize;
                if place < next || place >= accessor.count {
                    return Err(self.log.problem(
                        format!("{}.sparse.indices", accessor.place),
                        format!(
                            "holds {place}; indices must increase and stay below the count of {}",
                            accessor.count
                        ),
                    ));
                }
                next = place + 1;
                packed[place * size..next * size].copy_from_slice(value);
            }
        }
        Ok(packed)
    }

    /// Packs `count` elements of the accessor's kind; that they lie in the view was checked at the start.
    fn gather(&self, stretch: &Stretch, accessor: &Accessor, count: usize) -> Checked<Cow<'_, [u8]>> {
        let view = self.views[stretch.view].as_ref().map_err(|reported| *reported)?;
        let bytes = &self.view_bytes(stretch.view)?[stretch.offset..];
        let (column, element) = (accessor.column_bytes(), accessor.element_bytes());
        let stride = view.stride.unwrap_or(element);
        let row_bytes = accessor.shape.rows * accessor.component.bytes();
        if stride == element && column == row_bytes {
            return Ok(Cow::Borrowed(&bytes[..count * element]));
        }
        let mut packed = Vec::with_capacity(count * row_bytes * accessor.shape.columns);
        for start in (0..count).map(|index| index * stride) {
            for column_start in (0..accessor.shape.columns).map(|c| start + c * column) {
                packed.extend_from_slice(&bytes[column_start..column_start + row_bytes]);
            }
        }
        Ok(Cow::Owned(packed))
    }

    /// All components as floats, normalised integers as the fractions they stand for; every one is finite.
    pub(crate) fn floats(&self, index: usize) -> Checked<Vec<f32>> {
        let accessor = self.accessor(index)?;
        let packed = self.packed(accessor)?;
        let width = 4 / accessor.component.bytes();
        self.charge(&accessor.place, packed.len().saturating_mul(width))?;
        let floats = widen_floats(&packed, accessor.component, accessor.normalized);
        if let Some(at) = floats.iter().position(|v| !v.is_finite()) {
            let element = at / accessor.shape.components();
            let what = format!("holds {} in element {element}; numbers must be finite", floats[at]);
            return Err(self.log.problem(&accessor.place, what));
        }
        Ok(floats)
    }

    /// [`Self::floats`], `N` to an element. The accessor's shape must have been expected to be that.
    pub(crate) fn vectors<const N: usize>(&self, index: usize) -> Checked<Vec<[f32; N]>> {
        let floats = self.floats(index)?;
        Ok(floats.as_chunks::<N>().0.to_vec())
    }

    /// All components as unsigned integers.
    pub(crate) fn uints(&self, index: usize) -> Checked<Vec<u32>> {
        let accessor = self.accessor(index)?;
        let packed = self.packed(accessor)?;
        let width = 4 / accessor.component.bytes();
        self.charge(&accessor.place, packed.len().saturating_mul(width))?;
        Ok(widen_uints(&packed, accessor.component).collect())
    }
}

fn widen_uints(bytes: &[u8], component: Component) -> impl Iterator<Item = u32> {
    bytes
        .chunks_exact(component.bytes())
        .map(|c| c.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte)))
}

/// Decodes components as glTF 2.0, section 3.11 does.
fn widen_floats(bytes: &[u8], component: Component, normalized: bool) -> Vec<f32> {
    let scaled = |value: f32, most: f32| {
        if normalized { (value / most).max(-1.0) } else { value }
    };
    let pairs = || bytes.as_chunks::<2>().0.iter();
    match component {
        Component::I8 => bytes.iter().map(|b| scaled(f32::from(b.cast_signed()), 127.0)).collect(),
        Component::U8 => bytes.iter().map(|b| scaled(f32::from(*b), 255.0)).collect(),
        Component::I16 => pairs().map(|b| scaled(f32::from(i16::from_le_bytes(*b)), 32767.0)).collect(),
        Component::U16 => pairs().map(|b| scaled(f32::from(u16::from_le_bytes(*b)), 65535.0)).collect(),
        Component::U32 => widen_uints(bytes, component).map(|v| v as f32).collect(),
        Component::F32 => bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
    }
}

fn read_buffer<'a>(at: &Cursor<'a>, index: usize, container: &Container<'a>) -> Checked<Buffer<'a>> {
    let length = at.require("byteLength").and_then(|length| {
        let value = length.uint()?;
        if value == 0 {
            return Err(length.problem("is 0; a buffer has at least one byte"));
        }
        Ok(value)
    });
    let source = match at.get("uri") {
        Some(uri) => uri_source(&uri),
        None if index == 0 && container.binary => match container.bin {
            Some(bin) => Ok(Source::Here(Cow::Borrowed(bin))),
            None => Err(at.problem("has no uri, and the file has no BIN chunk for it")),
        },
        None => Ok(Source::Nowhere),
    };
    let (length, source) = (length?, source?);
    if let Source::Here(bytes) = &source {
        if bytes.len() < length {
            return Err(at.problem(format!(
                "has {} bytes, but {length} are declared; it may be cut off",
                bytes.len()
            )));
        }
        if matches!(bytes, Cow::Borrowed(_)) && bytes.len() > length.next_multiple_of(4) {
            at.note("is shorter than the BIN chunk by more than padding");
        }
    }
    Ok(Buffer { place: at.place().to_owned(), length, source, loaded: OnceCell::new() })
}

fn uri_source<'a>(uri: &Cursor<'a>) -> Checked<Source<'a>> {
    match Uri::parse(uri.text()?).map_err(|what| uri.problem(what))? {
        Uri::Data { media_type, bytes } => {
            let known = ["application/octet-stream", "application/gltf-buffer"];
            if !known.iter().any(|k| k.eq_ignore_ascii_case(&media_type)) {
                uri.note(format!("is of media type \"{media_type}\", which is not one for buffers"));
            }
            Ok(Source::Here(Cow::Owned(bytes)))
        }
        Uri::Relative(path) => Ok(Source::Beside(path)),
    }
}

/// A format that an accessor may have for some use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Format {
    pub(crate) shape: Shape,
    pub(crate) component: Component,
    pub(crate) normalized: bool,
}

impl Format {
    pub(crate) const fn plain(shape: Shape, component: Component) -> Self {
        Self { shape, component, normalized: false }
    }

    pub(crate) const fn normalized(shape: Shape, component: Component) -> Self {
        Self { shape, component, normalized: true }
    }

    fn of(accessor: &Accessor) -> Self {
        Self { shape: accessor.shape, component: accessor.component, normalized: accessor.normalized }
    }

    fn fits(&self, accessor: &Accessor) -> bool {
        *self == Self::of(accessor)
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let component = match self.component {
            Component::I8 => "8-bit signed",
            Component::U8 => "8-bit unsigned",
            Component::I16 => "16-bit signed",
            Component::U16 => "16-bit unsigned",
            Component::U32 => "32-bit unsigned",
            Component::F32 => "float",
        };
        let normalized = if self.normalized { "normalised " } else { "" };
        write!(f, "{} of {normalized}{component}", self.shape.name())
    }
}
