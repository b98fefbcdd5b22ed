//! How palettes reach OpenGL: where devices, which write them, and renderers, which draw from them,
//! meet.
//!
//! A renderer lends a device memory of OpenGL's as a [`PaletteTarget`]: two sets of pages, so that
//! the device writes one while OpenGL draws from the other. After each frame,
//! [`PaletteSource::hand_over`] waits for the device and names the set that it wrote; the renderer
//! waits until OpenGL is done with the other one before the next frame begins.
//!
//! Lent memory is owned: it stays valid until whoever borrowed it drops it, whatever became of the
//! renderer.
#![expect(
    unsafe_code,
    reason = "implementors of the traits make promises about memory that the compiler cannot \
              check; nothing here is an unsafe block"
)]

use std::fmt;
use std::num::NonZeroU32;
use std::sync::Arc;

use crate::backend_error::BackendError;
use crate::layout::Float4;

/// Sets of pages in flight: one is written while OpenGL draws from the other.
pub const PAGE_SETS: usize = 2;

/// A way for palettes to reach OpenGL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PaletteTransport {
    /// OpenCL writes OpenGL's own buffers (`cl_khr_gl_sharing`); its context is made for that of
    /// OpenGL.
    Shared,
    /// The host, or a device that works in the host's memory, writes buffers that OpenGL keeps
    /// mapped.
    Mapped,
    /// The device writes its own memory, and one copy of it goes to OpenGL each frame.
    Copied,
}

impl PaletteTransport {
    /// All ways, best first.
    pub const ALL: [Self; 3] = [Self::Shared, Self::Mapped, Self::Copied];

    /// The way's name in tables and documents.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Mapped => "mapped",
            Self::Copied => "copied",
        }
    }
}

impl fmt::Display for PaletteTransport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Shared => "shared between OpenCL and OpenGL",
            Self::Mapped => "written straight into OpenGL's memory",
            Self::Copied => "copied to OpenGL",
        })
    }
}

/// The context's numbers in EGL, for OpenCL to make its own context for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EglHandles {
    /// `EGLDisplay`.
    pub display: usize,
    /// `EGLContext`.
    pub context: usize,
}

/// A context of OpenGL that stays alive as long as this is held, on whatever thread.
///
/// # Safety
///
/// [`handles`](Self::handles) names the same EGL display and OpenGL context each time, and both are
/// valid until the value is dropped.
pub unsafe trait GlContext: fmt::Debug + Send + Sync {
    /// The context's numbers in EGL.
    fn handles(&self) -> EglHandles;
}

/// A page of palettes in memory that OpenGL keeps mapped; dropping it gives the memory back.
///
/// # Safety
///
/// [`elements`](Self::elements) returns the same memory each time. From the first call on until the
/// value is dropped, that memory is valid for reads and writes on every thread, between calls as
/// well, so that its address can be given to a device. Nothing but OpenGL reads or writes it by
/// other means, and OpenGL only reads.
pub unsafe trait MappedPage: Send {
    /// The page's memory; what is written there OpenGL sees from its next command on.
    fn elements(&mut self) -> &mut [Float4];
}

/// A page of palettes in a buffer of OpenGL's for OpenCL to write; dropping it gives the buffer
/// back.
///
/// # Safety
///
/// Until the value is dropped, the buffer exists in the context of [`handles`](Self::handles),
/// which exists too, and keeps storage for at least [`len`](Self::len) elements of [`Float4`]. What
/// OpenGL was told about it so far is done.
pub unsafe trait SharedPage: Send {
    /// The buffer's name in OpenGL.
    fn buffer(&self) -> NonZeroU32;

    /// The context that the buffer belongs to.
    fn handles(&self) -> EglHandles;

    /// Elements that there is room for.
    fn len(&self) -> usize;

    /// Whether there is room for nothing.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Where a device is to write palettes.
#[derive(Default)]
pub enum PaletteTarget {
    /// See [`PaletteTransport::Shared`]. In each set the pages in order, as many as in the other
    /// and of the same lengths.
    Shared([Vec<Box<dyn SharedPage>>; PAGE_SETS]),
    /// See [`PaletteTransport::Mapped`]. As above.
    Mapped([Vec<Box<dyn MappedPage>>; PAGE_SETS]),
    /// Its own memory.
    #[default]
    Copied,
}

impl PaletteTarget {
    /// Which way this is.
    #[must_use]
    pub fn way(&self) -> PaletteTransport {
        match self {
            Self::Shared(_) => PaletteTransport::Shared,
            Self::Mapped(_) => PaletteTransport::Mapped,
            Self::Copied => PaletteTransport::Copied,
        }
    }
}

/// Tells the targets of different lenders apart; a clone marks the same target.
#[derive(Clone, Debug, Default)]
pub struct TargetMark(Arc<()>);

impl TargetMark {
    /// Whether anybody but the caller holds this mark, as a device does while the target is in
    /// force.
    #[must_use]
    pub fn is_held_elsewhere(&self) -> bool {
        Arc::strong_count(&self.0) > 1
    }
}

impl PartialEq for TargetMark {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Where the palettes of a frame stand.
#[derive(Clone, Debug, PartialEq)]
pub struct HandedOver {
    /// The mark of the target in force.
    pub mark: TargetMark,
    /// Which set of its pages was written; `None` where the device keeps palettes in its own
    /// memory.
    pub set: Option<usize>,
}

/// Something that palettes come from: a device, or a crowd on one.
pub trait PaletteSource {
    /// Palette entries of each page in use as of the last frame; a page's number is its place in
    /// the list.
    fn page_lengths(&self) -> Vec<usize>;

    /// Palette entries of each page as of the next frame: what a target should have room for.
    fn page_room(&self) -> Vec<usize> {
        self.page_lengths()
    }

    /// Why palettes cannot reach a context in some way, as far as that shows without trying.
    fn refuses(&self, way: PaletteTransport, context: &dyn GlContext) -> Option<String>;

    /// Makes a device write palettes into `target` from the next frame on. What it wrote last goes
    /// there now, into set 0, so that it can be handed over at once. The target before is given
    /// back.
    ///
    /// A target stays in force until another takes its place, or until palettes outgrow it: the
    /// device then turns back to its own memory, and [`hand_over`](Self::hand_over) says so.
    ///
    /// # Errors
    ///
    /// A way that the device refuses, pages too few or too small for what is in use, or a failing
    /// device. The target before then stays in force.
    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError>;

    /// Waits for the last frame and says where its palettes stand: OpenGL can draw from there, and
    /// reading them back does no harm. The next frame is written into the other set, so OpenGL must
    /// be done with that one by then. Without a frame since the last call the answer is the same
    /// again. `None` where no target is in force.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn hand_over(&mut self) -> Result<Option<HandedOver>, BackendError>;

    /// Hands a page of palettes to `reader`, waiting for the frame to be done: three elements for
    /// each palette entry of the page, up to the last entry in use. Where the device shares memory
    /// with the host, nothing is copied.
    ///
    /// # Errors
    ///
    /// A failing device, or a page that does not exist.
    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError>;
}
