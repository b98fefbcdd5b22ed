//! Accessors and buffer views as the file declares them, checked against each other (glTF 2.0,
//! section 3.6.2).

use crate::json::Cursor;
use crate::log::Checked;

/// What one component is stored as.
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
        known.map(|(_, component)| *component).ok_or_else(|| {
            at.problem(format!("is {code}; component types are 5120 to 5123, 5125 and 5126"))
        })
    }
}

/// How components form an element: columns and rows of a matrix, one column for scalars and
/// vectors.
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
            at.problem(format!("is \"{text}\"; types are SCALAR, VEC2 to VEC4 and MAT2 to MAT4"))
        })
    }
}

/// A stretch of a buffer.
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
                "reaches from byte {offset} for {length} bytes, but buffer {buffer} has \
                 {buffer_length}"
            )));
        }
        Ok(Self { place: at.place().to_owned(), buffer, offset, length, stride })
    }
}

/// Elements in a buffer view.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    pub(crate) view: usize,
    pub(crate) offset: usize,
}

/// Elements that stand in for some of an accessor's.
#[derive(Clone, Debug)]
pub(crate) struct Sparse {
    pub(crate) count: usize,
    pub(crate) indices: Stretch,
    pub(crate) index_component: Component,
    pub(crate) values: Stretch,
}

/// A typed array, all of which lies in its buffer views.
#[derive(Clone, Debug)]
pub(crate) struct Accessor {
    pub(crate) place: String,
    pub(crate) component: Component,
    pub(crate) shape: Shape,
    pub(crate) normalized: bool,
    /// May be 0, which glTF forbids: exporters write empty animations so. Whoever needs elements
    /// has to ask.
    pub(crate) count: usize,
    pub(crate) base: Option<Stretch>,
    pub(crate) sparse: Option<Sparse>,
    pub(crate) has_bounds: bool,
}

impl Accessor {
    /// From one column of a matrix to the next; columns start at multiples of 4 bytes.
    pub(crate) const fn column_bytes(&self) -> usize {
        let bytes = self.shape.rows * self.component.bytes();
        if self.shape.columns > 1 { bytes.next_multiple_of(4) } else { bytes }
    }

    /// From one element to the next, where no stride says otherwise.
    pub(crate) const fn element_bytes(&self) -> usize {
        self.column_bytes() * self.shape.columns
    }

    /// From the first byte of an element to its last; the last column needs no padding.
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
                "is normalised; only 8-bit and 16-bit integers can be (glTF 2.0, section 3.6.2.2)",
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
            at.note("has no elements; glTF wants at least one");
        }
        // Both are looked at before either's problem counts, so that each is found.
        let base = base.and_then(|base| {
            base.iter().try_for_each(|stretch| accessor.check_fits(at, views, stretch, count))?;
            Ok(base)
        });
        let sparse = at.optional("sparse", |sparse| accessor.read_sparse(sparse, views));
        (accessor.base, accessor.sparse) = (base?, sparse?);
        Ok(accessor)
    }

    /// That `count` elements lie in their view, each aligned.
    fn check_fits(
        &self,
        at: &Cursor,
        views: &[Checked<View>],
        stretch: &Stretch,
        count: usize,
    ) -> Checked<()> {
        let view = views[stretch.view].as_ref().map_err(|reported| *reported)?;
        let element = self.element_bytes();
        // Columns of matrices start at multiples of 4, whatever they consist of.
        let align = if self.shape.columns > 1 { 4 } else { self.component.bytes() };
        let start = view.offset.saturating_add(stretch.offset);
        let mut failed = Ok(());
        if !stretch.offset.is_multiple_of(align) || !start.is_multiple_of(align) {
            failed = Err(at.problem(format!(
                "starts at byte {} of {}, {start} of the buffer; both must be multiples of {align}",
                stretch.offset, view.place
            )));
        }
        let stride = view.stride.unwrap_or(element);
        if stride < element {
            failed = Err(at.problem(format!(
                "has elements of {element} bytes, but {} says {stride} from one to the next",
                view.place
            )));
        }
        let end = count
            .saturating_sub(1)
            .checked_mul(stride)
            .and_then(|bytes| bytes.checked_add(if count == 0 { 0 } else { self.filled_bytes() }))
            .and_then(|bytes| bytes.checked_add(stretch.offset));
        if end.is_none_or(|end| end > view.length) {
            failed = Err(at.problem(format!(
                "has {count} elements of {element} bytes from byte {} on, which do not fit the {} \
                 bytes of {}",
                stretch.offset, view.length, view.place
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
                "is {count}; it must be at least 1 and at most the accessor's {}",
                self.count
            )))
        });
        let place_of = |key: &str| {
            let stretch = at.require(key)?;
            Ok((read_stretch(&stretch, views)?, stretch))
        };
        let (indices, values) = (place_of("indices"), place_of("values"));
        let (count, (indices, indices_at), (values, values_at)) = (count?, indices?, values?);
        let index_type = indices_at.require("componentType")?;
        let index_component = Component::read(&index_type)?;
        if !matches!(index_component, Component::U8 | Component::U16 | Component::U32) {
            return Err(index_type.problem("must be an unsigned integer: 5121, 5123 or 5125"));
        }
        for (part, place) in [(&indices, &indices_at), (&values, &values_at)] {
            if views[part.view].as_ref().is_ok_and(|v| v.stride.is_some()) {
                place.note("has a byteStride, which only vertex data may have; it is followed");
            }
        }
        let plain = Self { shape: Shape::SCALAR, component: index_component, ..self.clone() };
        plain.check_fits(&indices_at, views, &indices, count)?;
        self.check_fits(&values_at, views, &values, count)?;
        Ok(Sparse { count, indices, index_component, values })
    }
}

fn read_base(at: &Cursor, views: &[Checked<View>]) -> Checked<Option<Stretch>> {
    if at.get("bufferView").is_some() {
        return read_stretch(at, views).map(Some);
    }
    if at.get("byteOffset").is_some() {
        return Err(at.problem("has a byteOffset, but no bufferView for it to count from"));
    }
    Ok(None)
}

fn read_stretch(at: &Cursor, views: &[Checked<View>]) -> Checked<Stretch> {
    let view = at.require("bufferView").and_then(|v| v.index(views.len(), "buffer view"));
    let offset = at.optional("byteOffset", Cursor::uint);
    Ok(Stretch { view: view?, offset: offset?.unwrap_or(0) })
}
