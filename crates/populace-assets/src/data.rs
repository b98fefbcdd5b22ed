//! Binary data of a file: buffers, and typed arrays read from them.

use std::borrow::Cow;
use std::cell::OnceCell;

use crate::accessor::{Accessor, Component, Shape, View, ViewSlice};
use crate::budget::Budget;
use crate::folder::Folder;
use crate::glb::Container;
use crate::json::{Cursor, LARGEST};
use crate::log::{Checked, Log};
use crate::uri::Uri;

enum Source<'a> {
    /// Bytes of the BIN chunk or of a data URI.
    Embedded(Cow<'a, [u8]>),
    /// Path of another file, which is read on first use.
    External(String),
    /// No data: a placeholder for an extension, or a missing BIN chunk. The text is the problem to
    /// report on use.
    Missing(&'static str),
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
    pub(crate) budget: &'a Budget<'a>,
    folder: &'a Folder,
    buffers: Vec<Checked<Buffer<'a>>>,
    views: Vec<Checked<View>>,
    accessors: Vec<Checked<Accessor>>,
}

impl<'a> Data<'a> {
    /// Reads and checks all declarations. The content of other files is read on first use.
    pub(crate) fn new(
        root: &Cursor<'a>,
        log: &'a Log,
        container: &Container<'a>,
        budget: &'a Budget<'a>,
        folder: &'a Folder,
    ) -> Self {
        let buffers: Vec<_> = root
            .objects("buffers")
            .iter()
            .enumerate()
            .map(|(index, at)| read_buffer(at, index, container, budget))
            .collect();
        if buffers.is_empty() && container.bin.is_some_and(|b| !b.is_empty()) {
            log.note("chunk 1", "holds data, but the file has no buffers; it is ignored");
        }
        let lengths: Vec<_> = buffers
            .iter()
            .map(|b| b.as_ref().map(|b| b.length).map_err(|reported| *reported))
            .collect();
        let views: Vec<_> =
            root.objects("bufferViews").iter().map(|at| View::read(at, &lengths)).collect();
        let accessors =
            root.objects("accessors").iter().map(|at| Accessor::read(at, &views)).collect();
        budget.raise_limits_for(container.json.len() + container.bin.map_or(0, <[u8]>::len));
        Self { log, budget, folder, buffers, views, accessors }
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

    /// Returns the accessor if it has one of `formats`. `what` names its use in the problem.
    pub(crate) fn accessor_with_format(
        &self,
        index: usize,
        what: &str,
        formats: &[Format],
    ) -> Checked<&Accessor> {
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

    fn buffer(&self, index: usize) -> Checked<&[u8]> {
        let buffer = self.buffers[index].as_ref().map_err(|reported| *reported)?;
        match &buffer.source {
            Source::Embedded(bytes) => Ok(bytes),
            Source::Missing(what) => Err(self.log.problem(&buffer.place, *what)),
            Source::External(path) => {
                let load = || {
                    let place = format!("{}.uri", buffer.place);
                    let opened = self.folder.open(path, Some(buffer.length));
                    let opened = opened.map_err(|what| self.log.problem(&place, what))?;
                    self.budget.take(&place, format!("the file \"{path}\""), opened.length)?;
                    let bytes = opened.read().map_err(|what| self.log.problem(&place, what))?;
                    self.budget.raise_limits_for(bytes.len());
                    Ok(bytes)
                };
                let loaded = buffer.loaded.get_or_init(load);
                loaded.as_deref().map_err(|reported| *reported)
            }
        }
    }

    /// Adds a note for each buffer that was never needed and was not opened or has no data.
    pub(crate) fn note_unused_buffers(&self) {
        for buffer in self.buffers.iter().flatten() {
            let what = match buffer.source {
                Source::External(_) if buffer.loaded.get().is_none() => "is not opened",
                Source::Missing(_) => "has no uri",
                _ => continue,
            };
            let what = format!("{what}; nothing that is drawn or animated uses it");
            self.log.note(&buffer.place, what);
        }
    }

    /// Returns the bytes of a buffer view.
    pub(crate) fn view_bytes(&self, index: usize) -> Checked<&[u8]> {
        let view = self.views[index].as_ref().map_err(|reported| *reported)?;
        // A loaded buffer has at least its declared length, which the view was checked against.
        Ok(&self.buffer(view.buffer)?[view.offset..view.offset + view.length])
    }

    /// Returns whether the buffer view of the accessor has a `byteStride`.
    pub(crate) fn has_stride(&self, accessor: &Accessor) -> bool {
        let view = accessor.base.as_ref().map(|base| self.views[base.view].as_ref());
        view.is_some_and(|view| view.is_ok_and(|v| v.stride.is_some()))
    }

    /// Returns the elements without padding between elements or between matrix columns.
    fn packed(&self, accessor: &Accessor) -> Checked<Cow<'_, [u8]>> {
        let size = accessor.shape.components() * accessor.component.bytes();
        let total = accessor.count.saturating_mul(size);
        self.budget.charge(&accessor.place, total)?;
        let mut packed = match &accessor.base {
            Some(base) => self.gather(base, accessor, accessor.count)?,
            None => Cow::Owned(vec![0; total]),
        };
        if let Some(sparse) = &accessor.sparse {
            let values = self.gather(&sparse.values, accessor, sparse.count)?;
            let as_indices = Accessor {
                component: sparse.index_component,
                shape: Shape::SCALAR,
                ..accessor.clone()
            };
            let indices = self.gather(&sparse.indices, &as_indices, sparse.count)?;
            let packed = packed.to_mut();
            let mut next = 0;
            for (index, value) in
                widen_uints(&indices, sparse.index_component).zip(values.chunks(size))
            {
                let index = index as usize;
                if index < next || index >= accessor.count {
                    return Err(self.log.problem(
                        format!("{}.sparse.indices", accessor.place),
                        format!(
                            "holds {index}; indices must increase strictly and be less than the \
                             accessor's count of {}",
                            accessor.count
                        ),
                    ));
                }
                next = index + 1;
                packed[index * size..next * size].copy_from_slice(value);
            }
        }
        Ok(packed)
    }

    /// Packs `count` elements of the accessor's format. [`Accessor::read`] has checked that they
    /// lie inside the view.
    fn gather(
        &self,
        slice: &ViewSlice,
        accessor: &Accessor,
        count: usize,
    ) -> Checked<Cow<'_, [u8]>> {
        let view = self.views[slice.view].as_ref().map_err(|reported| *reported)?;
        let bytes = &self.view_bytes(slice.view)?[slice.offset..];
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

    /// Returns all components as floats, with normalised integers converted to fractions. Fails if
    /// a component is not finite or its magnitude exceeds [`LARGEST`].
    pub(crate) fn floats(&self, index: usize) -> Checked<Vec<f32>> {
        let accessor = self.accessor(index)?;
        let packed = self.packed(accessor)?;
        let width = 4 / accessor.component.bytes();
        self.budget.charge(&accessor.place, packed.len().saturating_mul(width))?;
        let floats = widen_floats(&packed, accessor.component, accessor.normalized);
        let within = |v: &f32| f64::from(v.abs()) <= LARGEST; // false for NaN
        if let Some(at) = floats.iter().position(|v| !within(v)) {
            let element = at / accessor.shape.components();
            let what = format!(
                "holds {:?} in element {element}; numbers must be finite, with a magnitude of at \
                 most {LARGEST:e}",
                floats[at]
            );
            return Err(self.log.problem(&accessor.place, what));
        }
        Ok(floats)
    }

    /// Returns [`Self::floats`] in groups of `N`. The caller has checked with
    /// [`Self::accessor_with_format`] that elements have `N` components.
    pub(crate) fn vectors<const N: usize>(&self, index: usize) -> Checked<Vec<[f32; N]>> {
        let floats = self.floats(index)?;
        Ok(floats.as_chunks::<N>().0.to_vec())
    }

    /// Returns all components as unsigned integers.
    pub(crate) fn uints(&self, index: usize) -> Checked<Vec<u32>> {
        let accessor = self.accessor(index)?;
        let packed = self.packed(accessor)?;
        let width = 4 / accessor.component.bytes();
        self.budget.charge(&accessor.place, packed.len().saturating_mul(width))?;
        Ok(widen_uints(&packed, accessor.component).collect())
    }
}

fn widen_uints(bytes: &[u8], component: Component) -> impl Iterator<Item = u32> {
    bytes
        .chunks_exact(component.bytes())
        .map(|c| c.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte)))
}

/// Converts components to floats (glTF 2.0, section 3.11).
fn widen_floats(bytes: &[u8], component: Component, normalized: bool) -> Vec<f32> {
    let scaled = |value: f32, most: f32| {
        if normalized { (value / most).max(-1.0) } else { value }
    };
    let pairs = || bytes.as_chunks::<2>().0.iter();
    match component {
        Component::I8 => bytes.iter().map(|b| scaled(f32::from(b.cast_signed()), 127.0)).collect(),
        Component::U8 => bytes.iter().map(|b| scaled(f32::from(*b), 255.0)).collect(),
        Component::I16 => {
            pairs().map(|b| scaled(f32::from(i16::from_le_bytes(*b)), 32767.0)).collect()
        }
        Component::U16 => {
            pairs().map(|b| scaled(f32::from(u16::from_le_bytes(*b)), 65535.0)).collect()
        }
        Component::U32 => widen_uints(bytes, component).map(|v| v as f32).collect(),
        Component::F32 => bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
    }
}

fn read_buffer<'a>(
    at: &Cursor<'a>,
    index: usize,
    container: &Container<'a>,
    budget: &Budget,
) -> Checked<Buffer<'a>> {
    let length = at.require("byteLength").and_then(|length| {
        let value = length.uint()?;
        if value == 0 {
            return Err(length.problem("is 0; it must be at least 1"));
        }
        Ok(value)
    });
    let source = match at.get("uri") {
        Some(uri) => uri_source(&uri, budget),
        None if index == 0 && container.binary => match container.bin {
            Some(bin) => Ok(Source::Embedded(Cow::Borrowed(bin))),
            None => Ok(Source::Missing("has no uri, and the file has no BIN chunk for it")),
        },
        None => {
            Ok(Source::Missing("has no uri; only the first buffer of a binary file may omit it"))
        }
    };
    let (length, source) = (length?, source?);
    if let Source::Embedded(bytes) = &source {
        if bytes.len() < length {
            return Err(at.problem(format!(
                "has {} bytes, but {length} are declared; the file may be truncated",
                bytes.len()
            )));
        }
        if matches!(bytes, Cow::Borrowed(_)) && bytes.len() > length.next_multiple_of(4) {
            at.note("is shorter than the BIN chunk by more than the padding of up to 3 bytes");
        }
    }
    Ok(Buffer { place: at.place().to_owned(), length, source, loaded: OnceCell::new() })
}

fn uri_source<'a>(uri: &Cursor<'a>, budget: &Budget) -> Checked<Source<'a>> {
    match Uri::parse(uri.text()?).map_err(|what| uri.problem(what))? {
        Uri::Data(data) => {
            let known = ["application/octet-stream", "application/gltf-buffer"];
            if !known.iter().any(|k| k.eq_ignore_ascii_case(data.media_type)) {
                let what = format!(
                    "has the media type \"{}\", which is not one of buffers; it is read anyway",
                    data.media_type
                );
                uri.note(what);
            }
            budget.take(uri.place(), "the data of its URI", data.decoded_bytes())?;
            Ok(Source::Embedded(Cow::Owned(data.decode().map_err(|what| uri.problem(what))?)))
        }
        Uri::File(path) => Ok(Source::External(path)),
    }
}

/// Element format of an accessor.
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
        Self {
            shape: accessor.shape,
            component: accessor.component,
            normalized: accessor.normalized,
        }
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
