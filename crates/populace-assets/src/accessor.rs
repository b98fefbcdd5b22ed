//! Declarations of accessors and buffer views, checked against each other (glTF 2.0, section
//! 3.6.2).

use crate::json::Cursor;
use crate::log::Checked;

/// Storage type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    const ALL: [(usize, Self); 6] = [
        (5120, Self::I8),
        (5121, Self::U8),
        (5122, Self::I16),
        (5123, Self::U16),
        (5125, Self::U32),
        (5126, Self::F32),
    ];

    pub(crate) const fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn read(at: &Cursor) -> Checked<Self> {
        let code = at.uint()?;
        let known = Self::ALL.iter().find(|(c, _)| *c == code);
        known
            .map(|(_, component)| *component)
            .ok_or_else(|| at.problem(format!("is {code}; it must be 5120 to 5123, 5125 or 5126")))
    }
}

/// Columns and rows of an element. Scalars and vectors have one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Shape {
    pub(crate) const SCALAR: Self = Self::new(1, 1);
    pub(crate) const VEC2: Self = Self::new(1, 2);
    pub(crate) const VEC3: Self = Self::new(1, 3);
    pub(crate) const VEC4: Self = Self::new(1, 4);
    pub(crate) const MAT4: Self = Self::new(4, 4);

    const NAMES: [(&'static str, Self); 7] = [
        ("SCALAR", Self::SCALAR),
        ("VEC2", Self::VEC2),
        ("VEC3", Self::VEC3),
        ("VEC4", Self::VEC4),
        ("MAT2", Self::new(2, 2)),
        ("MAT3", Self::new(3, 3)),
        ("MAT4", Self::MAT4),
    ];

    const fn new(columns: usize, rows: usize) -> Self {
        Self { columns, rows }
    }

    pub(crate) const fn components(self) -> usize {
        self.columns * self.rows
    }

    pub(crate) fn name(self) -> &'static str {
        let found = Self::NAMES.iter().find(|(_, shape)| *shape == self);
        found.map_or("", |(name, _)| name)
    }

    fn read(at: &Cursor) -> Checked<Self> {
        let text = at.text()?;
        let known = Self::NAMES.iter().find(|(name, _)| *name == text);
        known.map(|(_, shape)| *shape).ok_or_else(|| {
            at.problem(format!("is \"{text}\"; it must be SCALAR, VEC2 to VEC4 or MAT2 to MAT4"))
        })
    }
}

/// A buffer view: a byte range of a buffer.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub(crate) place: String,
    pub(crate) buffer: usize,
    pub(crate) offset: usize,
    pub(crate) length: usize,
    pub(crate) stride: Option<usize>,
}

impl View {
    pub(crate) fn read(at: &Cursor, buffer_lengths: &[Checked<usize>]) -> Checked<Self> {
        let buffer = at.require("buffer").and_then(|b| b.index(buffer_lengths.len(), "buffer"));
        let offset = at.optional("byteOffset", Cursor::uint);
        let length = at.require("byteLength").and_then(|l| l.uint());
        let stride = at.optional("byteStride", Cursor::uint);
        let (buffer, offset, length, stride) = (buffer?, offset?.unwrap_or(0), length?, stride?);
        if length == 0 {
            return Err(at.problem("has a byteLength of 0; it must be at least 1"));
        }
        if let Some(stride) = stride.filter(|s| !(4..=252).contains(s) || s % 4 != 0) {
            return Err(at.problem(format!(
                "has a byteStride of {stride}; it must be a multiple of 4 from 4 to 252"
            )));
        }
        let buffer_length = buffer_lengths[buffer]?;
        if offset.checked_add(length).is_none_or(|end| end > buffer_length) {
            return Err(at.problem(format!(
                "covers {length} bytes from byte {offset} on, but buffer {buffer} has only \
                 {buffer_length}"
            )));
        }
        Ok(Self { place: at.place().to_owned(), buffer, offset, length, stride })
    }
}

/// The bytes of a buffer view from an offset on.
#[derive(Clone, Debug)]
pub(crate) struct ViewSlice {
    pub(crate) view: usize,
    pub(crate) offset: usize,
}

/// Replacements for some elements of an accessor.
#[derive(Clone, Debug)]
pub(crate) struct Sparse {
    pub(crate) count: usize,
    pub(crate) indices: ViewSlice,
    pub(crate) index_component: Component,
    pub(crate) values: ViewSlice,
}

/// A typed array. [`Accessor::read`] has checked that it lies inside its buffer views.
#[derive(Clone, Debug)]
pub(crate) struct Accessor {
    pub(crate) place: String,
    pub(crate) component: Component,
    pub(crate) shape: Shape,
    pub(crate) normalized: bool,
    /// Number of elements. It may be 0 although glTF forbids that, since some exporters write empty
    /// animations this way. Users that need elements must check.
    pub(crate) count: usize,
    /// The elements; all zero if `None`.
    pub(crate) base: Option<ViewSlice>,
    pub(crate) sparse: Option<Sparse>,
    /// Whether `min` and `max` are present.
    pub(crate) has_bounds: bool,
}

impl Accessor {
    /// Bytes from one matrix column to the next. Columns start at multiples of 4 bytes.
    pub(crate) const fn column_bytes(&self) -> usize {
        let bytes = self.shape.rows * self.component.bytes();
        if self.shape.columns > 1 { bytes.next_multiple_of(4) } else { bytes }
    }

    /// Bytes from one element to the next if the view has no stride.
    pub(crate) const fn element_bytes(&self) -> usize {
        self.column_bytes() * self.shape.columns
    }

    /// Bytes of an element without the padding of its last column.
    const fn filled_bytes(&self) -> usize {
        self.column_bytes() * (self.shape.columns - 1) + self.shape.rows * self.component.bytes()
    }

    pub(crate) fn read(at: &Cursor, views: &[Checked<View>]) -> Checked<Self> {
        let component = at.require("componentType").and_then(|c| Component::read(&c));
        let shape = at.require("type").and_then(|t| Shape::read(&t));
        let count = at.require("count").and_then(|c| c.uint());
        let normalized = at.optional("normalized", Cursor::flag);
        let base = read_base(at, views);
        let (component, shape, count) = (component?, shape?, count?);
        let normalized = normalized?.unwrap_or(false);
        if normalized && matches!(component, Component::F32 | Component::U32) {
            return Err(at.problem(
                "is normalised; only 8-bit and 16-bit integers may be (glTF 2.0, section 3.6.2.2)",
            ));
        }
        let mut accessor = Self {
            place: at.place().to_owned(),
            component,
            shape,
            normalized,
            count,
            base: None,
            sparse: None,
            has_bounds: at.get("min").is_some() && at.get("max").is_some(),
        };
        if count == 0 {
            at.note("has no elements; glTF requires at least one");
        }
        // Both are checked before either is unwrapped, so that the problems of both are reported.
        let base = base.and_then(|base| {
            base.iter().try_for_each(|slice| accessor.check_fits(at, views, slice, count))?;
            Ok(base)
        });
        let sparse = at.optional("sparse", |sparse| accessor.read_sparse(sparse, views));
        (accessor.base, accessor.sparse) = (base?, sparse?);
        Ok(accessor)
    }

    /// Checks that `count` elements are aligned and lie inside their view.
    fn check_fits(
        &self,
        at: &Cursor,
        views: &[Checked<View>],
        slice: &ViewSlice,
        count: usize,
    ) -> Checked<()> {
        let view = views[slice.view].as_ref().map_err(|reported| *reported)?;
        let element = self.element_bytes();
        // Matrix columns start at multiples of 4 bytes for all component types.
        let align = if self.shape.columns > 1 { 4 } else { self.component.bytes() };
        let start = view.offset.saturating_add(slice.offset);
        let mut failed = Ok(());
        if !slice.offset.is_multiple_of(align) || !start.is_multiple_of(align) {
            failed = Err(at.problem(format!(
                "starts at byte {} of {}, which is byte {start} of the buffer; both must be \
                 multiples of {align}",
                slice.offset, view.place
            )));
        }
        let stride = view.stride.unwrap_or(element);
        if stride < element {
            failed = Err(at.problem(format!(
                "has elements of {element} bytes, but {} has a byteStride of {stride}",
                view.place
            )));
        }
        let end = count
            .saturating_sub(1)
            .checked_mul(stride)
            .and_then(|bytes| bytes.checked_add(if count == 0 { 0 } else { self.filled_bytes() }))
            .and_then(|bytes| bytes.checked_add(slice.offset));
        if end.is_none_or(|end| end > view.length) {
            failed = Err(at.problem(format!(
                "has {count} elements of {element} bytes from byte {} on, which do not fit into \
                 the {} bytes of {}",
                slice.offset, view.length, view.place
            )));
        }
        failed
    }

    fn read_sparse(&self, at: &Cursor, views: &[Checked<View>]) -> Checked<Sparse> {
        let count = at.require("count").and_then(|c| {
            let count = c.uint()?;
            if (1..=self.count).contains(&count) {
                return Ok(count);
            }
            Err(c.problem(format!(
                "is {count}; it must be from 1 to the accessor's count of {}",
                self.count
            )))
        });
        let located_slice = |key: &str| {
            let slice = at.require(key)?;
            Ok((read_slice(&slice, views)?, slice))
        };
        let (indices, values) = (located_slice("indices"), located_slice("values"));
        let (count, (indices, indices_at), (values, values_at)) = (count?, indices?, values?);
        let index_type = indices_at.require("componentType")?;
        let index_component = Component::read(&index_type)?;
        if !matches!(index_component, Component::U8 | Component::U16 | Component::U32) {
            return Err(index_type.problem("must be an unsigned integer: 5121, 5123 or 5125"));
        }
        for (slice, at) in [(&indices, &indices_at), (&values, &values_at)] {
            if views[slice.view].as_ref().is_ok_and(|v| v.stride.is_some()) {
                at.note("has a byteStride, which only vertex data may have; it is used anyway");
            }
        }
        let plain = Self { shape: Shape::SCALAR, component: index_component, ..self.clone() };
        plain.check_fits(&indices_at, views, &indices, count)?;
        self.check_fits(&values_at, views, &values, count)?;
        Ok(Sparse { count, indices, index_component, values })
    }
}

fn read_base(at: &Cursor, views: &[Checked<View>]) -> Checked<Option<ViewSlice>> {
    if at.get("bufferView").is_some() {
        return read_slice(at, views).map(Some);
    }
    if at.get("byteOffset").is_some() {
        return Err(at.problem("has a byteOffset, but no bufferView that it could refer to"));
    }
    Ok(None)
}

fn read_slice(at: &Cursor, views: &[Checked<View>]) -> Checked<ViewSlice> {
    let view = at.require("bufferView").and_then(|v| v.index(views.len(), "buffer view"));
    let offset = at.optional("byteOffset", Cursor::uint);
    Ok(ViewSlice { view: view?, offset: offset?.unwrap_or(0) })
}
