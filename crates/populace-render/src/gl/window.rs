//! Windows that others opened, as EGL takes them.

use std::ffi::{c_ulong, c_void};
use std::sync::{Arc, OnceLock};

use dlopen2::raw::Library;
use khronos_egl as egl;
use raw_window_handle::{
    HasDisplayHandle, HasWindowHandle, RawDisplayHandle, RawWindowHandle, WaylandWindowHandle,
};

const PLATFORM_X11: egl::Enum = 0x31d5;
const PLATFORM_WAYLAND: egl::Enum = 0x31d8;

/// A window that can be drawn into.
pub trait WindowTarget: HasDisplayHandle + HasWindowHandle + Send + Sync {}

impl<T: HasDisplayHandle + HasWindowHandle + Send + Sync> WindowTarget for T {}

/// A window with the pointers that EGL asks for.
pub(super) struct NativeWindow {
    surface: Surface,
    platform: egl::Enum,
    display: *mut c_void,
    /// Keeps the window open. Declared last, since it must outlive the surface.
    _target: Arc<dyn WindowTarget>,
}

enum Surface {
    /// Number of the window, which EGL takes by its address, and of its visual.
    X11 {
        window: Box<c_ulong>,
        visual: Option<c_ulong>,
    },
    Wayland(WaylandSurface),
}

impl NativeWindow {
    /// Finds the pointers of a window of `size` pixels (width, height).
    pub(super) fn new(target: Arc<dyn WindowTarget>, size: [u32; 2]) -> Result<Self, String> {
        let display = target.display_handle().map_err(|e| e.to_string())?.as_raw();
        let window = target.window_handle().map_err(|e| e.to_string())?.as_raw();
        let (platform, display, surface) = match (display, window) {
            (RawDisplayHandle::Xlib(display), RawWindowHandle::Xlib(window)) => {
                let pointer = display.display.ok_or("its X display is not open")?;
                let visual = Some(window.visual_id).filter(|visual| *visual != 0);
                let surface = Surface::X11 { window: Box::new(window.window), visual };
                (PLATFORM_X11, pointer.as_ptr(), surface)
            }
            (RawDisplayHandle::Wayland(display), RawWindowHandle::Wayland(window)) => {
                let surface = Surface::Wayland(WaylandSurface::new(window, size)?);
                (PLATFORM_WAYLAND, display.display.as_ptr(), surface)
            }
            _ => return Err("only windows of X11 (Xlib) and Wayland can be drawn into".into()),
        };
        Ok(Self { surface, platform, display, _target: target })
    }

    /// Returns the platform and the pointer to its display.
    pub(super) fn display(&self) -> (egl::Enum, *mut c_void) {
        (self.platform, self.display)
    }

    /// Returns the number of the window's visual, if it has one.
    pub(super) fn visual(&self) -> Option<c_ulong> {
        match &self.surface {
            Surface::X11 { visual, .. } => *visual,
            Surface::Wayland(_) => None,
        }
    }

    /// Returns the pointer that `eglCreatePlatformWindowSurface` takes.
    pub(super) fn surface_argument(&mut self) -> *mut c_void {
        match &mut self.surface {
            Surface::X11 { window, .. } => (&raw mut **window).cast(),
            Surface::Wayland(surface) => surface.raw,
        }
    }

    /// Tells a surface of Wayland its size in pixels. One of X11 follows its window.
    pub(super) fn resize(&self, size: [u32; 2]) {
        if let Surface::Wayland(surface) = &self.surface {
            surface.resize(size);
        }
    }
}

/// A `wl_egl_window`.
struct WaylandSurface {
    raw: *mut c_void,
    functions: &'static WaylandFunctions,
}

impl WaylandSurface {
    fn new(window: WaylandWindowHandle, size: [u32; 2]) -> Result<Self, String> {
        let functions = WaylandFunctions::load()?;
        let [width, height] = size.map(side);
        // SAFETY: the handle is that of a `wl_surface`, which the owner of `self` keeps.
        let raw = unsafe { (functions.create)(window.surface.as_ptr(), width, height) };
        if raw.is_null() {
            return Err("wl_egl_window_create failed".into());
        }
        Ok(Self { raw, functions })
    }

    fn resize(&self, size: [u32; 2]) {
        let [width, height] = size.map(side);
        // SAFETY: `raw` is the window that `new` created.
        unsafe { (self.functions.resize)(self.raw, width, height, 0, 0) }
    }
}

impl Drop for WaylandSurface {
    fn drop(&mut self) {
        // SAFETY: `self` owns the window, and its surface of EGL was destroyed before it.
        unsafe { (self.functions.destroy)(self.raw) }
    }
}

/// Functions of libwayland-egl.
struct WaylandFunctions {
    create: unsafe extern "C" fn(*mut c_void, i32, i32) -> *mut c_void,
    resize: unsafe extern "C" fn(*mut c_void, i32, i32, i32, i32),
    destroy: unsafe extern "C" fn(*mut c_void),
    /// Never unloaded.
    _library: Library,
}

impl WaylandFunctions {
    /// Loads the library once per process.
    fn load() -> Result<&'static Self, String> {
        static FUNCTIONS: OnceLock<Result<WaylandFunctions, String>> = OnceLock::new();
        FUNCTIONS.get_or_init(|| Self::open().map_err(|e| e.to_string())).as_ref().map_err(
            |cause| format!("{cause}; install libwayland-egl1, or unset WAYLAND_DISPLAY to use X"),
        )
    }

    fn open() -> Result<Self, dlopen2::Error> {
        let library = Library::open("libwayland-egl.so.1")?;
        // SAFETY: the header wayland-egl-core.h gives these names these types.
        unsafe {
            Ok(Self {
                create: library.symbol("wl_egl_window_create")?,
                resize: library.symbol("wl_egl_window_resize")?,
                destroy: library.symbol("wl_egl_window_destroy")?,
                _library: library,
            })
        }
    }
}

/// Returns a side of a window as its functions take it, at least 1.
fn side(pixels: u32) -> i32 {
    i32::try_from(pixels.max(1)).unwrap_or(i32::MAX)
}
