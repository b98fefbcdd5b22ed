//! Interop of palettes with OpenGL, between the devices that write them and the renderers that draw
//! from them.
//!
//! A renderer provides OpenGL memory to a device as a [`PaletteTarget`]: two sets of pages, so that
//! the device writes one while OpenGL draws from the other. After each frame,
//! [`PaletteSource::release_palettes`] waits for the device and returns the set that it wrote. Before the
//! next frame, the renderer waits until OpenGL has finished with the other set.
//!
//! Provided memory is owned: it stays valid until the device drops it, even if the renderer is
//! gone.
#![expect(
    unsafe_code,
    reason = "implementors of the traits make promises about memory that the compiler cannot \
              check; nothing here is an unsafe block"
)]

use std::fmt;
use std::num::NonZeroU32;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::backend_error::BackendError;
use crate::layout::Float4;

/// Sets of pages in flight: one is written while OpenGL draws from the other.
pub const PAGE_SETS: usize = 2;

/// Waits until no other thread starts a driver, and keeps others from it while the guard lives.
///
/// Drivers start while OpenCL lists its devices for the first time, and while an OpenGL context is
/// created. Meanwhile PoCL sets an environment variable (`HWLOC_PLUGINS_PATH`) and Mesa reads
/// others, which the C library does not allow on two threads at once: the process may end with
/// SIGSEGV.
pub fn driver_start() -> MutexGuard<'static, ()> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A transport of palettes to OpenGL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PaletteTransport {
    /// OpenCL writes OpenGL's own buffers (`cl_khr_gl_sharing`). Its context is created for that of
    /// OpenGL.
    Shared,
    /// The host, or a device that works in host memory, writes buffers that OpenGL keeps mapped.
    Mapped,
    /// The device writes its own memory, which is copied to OpenGL once per frame.
    Copied,
}

impl PaletteTransport {
    /// All transports, best first.
    pub const ALL: [Self; 3] = [Self::Shared, Self::Mapped, Self::Copied];

    /// The transport's name in tables and documents.
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

/// EGL handles of an OpenGL context, from which OpenCL creates its own context.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EglHandles {
    /// `EGLDisplay`.
    pub display: usize,
    /// `EGLContext`.
    pub context: usize,
}

/// An OpenGL context that stays alive while this value exists, on any thread.
///
/// # Safety
///
/// [`handles`](Self::handles) must return the same EGL display and OpenGL context each time, and
/// both must be valid until the value is dropped.
pub unsafe trait GlContext: fmt::Debug + Send + Sync {
    /// The context's EGL handles.
    fn handles(&self) -> EglHandles;
}

/// A page of palettes in memory that OpenGL keeps mapped. Dropping it releases the memory.
///
/// # Safety
///
/// [`elements`](Self::elements) must return the same memory each time. From the first call until
/// the value is dropped, that memory must be valid for reads and writes on every thread, also
/// between calls, so that its address can be given to a device. Only OpenGL may access it by other
/// means, and OpenGL may only read.
pub unsafe trait MappedPage: Send {
    /// The page's memory. OpenGL sees writes from its next command on.
    fn elements(&mut self) -> &mut [Float4];
}

/// A page of palettes in an OpenGL buffer that OpenCL writes. Dropping it releases the buffer.
///
/// # Safety
///
/// Until the value is dropped, the context of [`handles`](Self::handles) must exist, and the buffer
/// must exist in it with storage for at least [`len`](Self::len) elements of [`Float4`]. All
/// earlier OpenGL commands on the buffer must have finished.
pub unsafe trait SharedPage: Send {
    /// The buffer's OpenGL name.
    fn buffer(&self) -> NonZeroU32;

    /// The context that the buffer belongs to.
    fn handles(&self) -> EglHandles;

    /// Capacity in elements.
    fn len(&self) -> usize;

    /// Returns whether the capacity is 0.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Destination of a device's palettes.
#[derive(Default)]
pub enum PaletteTarget {
    /// See [`PaletteTransport::Shared`]. The pages of each set, in order. Both sets have the same
    /// number of pages with the same lengths.
    Shared([Vec<Box<dyn SharedPage>>; PAGE_SETS]),
    /// See [`PaletteTransport::Mapped`]. Pages as for [`Shared`](Self::Shared).
    Mapped([Vec<Box<dyn MappedPage>>; PAGE_SETS]),
    /// The device's own memory.
    #[default]
    Copied,
}

impl PaletteTarget {
    /// The target's transport.
    #[must_use]
    pub fn transport(&self) -> PaletteTransport {
        match self {
            Self::Shared(_) => PaletteTransport::Shared,
            Self::Mapped(_) => PaletteTransport::Mapped,
            Self::Copied => PaletteTransport::Copied,
        }
    }
}

/// Identity of a target, to tell targets of different renderers apart. A clone marks the same
/// target.
#[derive(Clone, Debug, Default)]
pub struct TargetMark(Arc<()>);

impl TargetMark {
    /// Returns whether other clones of this mark exist. A device holds one while the target is in
    /// use.
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

/// Location of the palettes of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ReleasedPalettes {
    /// The mark of the target in use.
    pub mark: TargetMark,
    /// The set of pages that was written; `None` if the device keeps palettes in its own memory.
    pub set: Option<usize>,
}

/// A source of palettes: a device, or a crowd on one.
pub trait PaletteSource {
    /// Palette entries of each page in use as of the last frame, by page index.
    fn page_lengths(&self) -> Vec<usize>;

    /// Palette entries of each page as of the next frame: the capacity that a target should have.
    fn page_room(&self) -> Vec<usize> {
        self.page_lengths()
    }

    /// Returns why palettes cannot reach a context with this transport, as far as that is known
    /// without trying; `None` if nothing speaks against it.
    fn refuses(&self, transport: PaletteTransport, context: &dyn GlContext) -> Option<String>;

    /// Makes the device write palettes into `target` from the next frame on. The last frame's
    /// palettes are written into set 0 at once, so that they can be acquired. The previous target
    /// is released.
    ///
    /// A target stays in use until it is replaced or palettes outgrow it. In the latter case the
    /// device returns to its own memory, which [`release_palettes`](Self::release_palettes)
    /// reports.
    ///
    /// # Errors
    ///
    /// The device does not support the transport, there are too few pages or they are too small for
    /// the palettes in use, or the device fails. The previous target then stays in use.
    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError>;

    /// Waits for the last frame and returns the location of its palettes. OpenGL can draw from
    /// there, and reading them back is allowed. The next frame is written into the other set, so
    /// OpenGL must have finished with that set by then. Without a new frame since the last call the
    /// result is the same. Returns `None` if no target is in use.
    ///
    /// # Errors
    ///
    /// A device failure. A crowd has [`BackendError::NotEvaluated`] after a frame that failed or
    /// was undone.
    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError>;

    /// Calls `reader` with a page of palettes, waiting for the frame to finish: three elements for
    /// each palette entry of the page, up to the last entry in use. Nothing is copied if the device
    /// shares memory with the host.
    ///
    /// # Errors
    ///
    /// A device failure, or a page that does not exist.
    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError>;
}
