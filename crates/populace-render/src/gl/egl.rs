//! OpenGL contexts, created with EGL.

use std::ffi::{CStr, c_ulong, c_void};
use std::fmt;
use std::sync::{Arc, OnceLock};

use khronos_egl as egl;
use populace_device::{EglHandles, GlContext, driver_start};

use super::window::{NativeWindow, WindowTarget};
use crate::Error;

type Egl = egl::DynamicInstance<egl::EGL1_5>;

const PLATFORM_SURFACELESS: egl::Enum = 0x31dd;
const PLATFORM_DEVICE: egl::Enum = 0x313f;
const MAX_DEVICES: u8 = 16;
const REMEDY: &str = "install a graphics driver with EGL and OpenGL 4.3 or newer; Mesa's software \
                      driver will do (Debian, Ubuntu: apt install libegl1 libgl1-mesa-dri)";

/// A context of OpenGL 4.3 core or newer, current on the thread that created it.
pub(crate) struct Context {
    egl: &'static Egl,
    display: egl::Display,
    context: egl::Context,
    surface: Option<egl::Surface>,
    /// The window whose surface it is. Declared last, since it must outlive the surface.
    window: Option<NativeWindow>,
}

impl Context {
    /// Returns the first context that can be created on, in this order: hardware devices, software
    /// devices, Mesa's surfaceless platform, the default display.
    pub(super) fn headless() -> Result<Self, Error> {
        let _starting = driver_start();
        let egl = library().map_err(|cause| no_gl(format!("libEGL: {cause}")))?;
        let mut tried = Vec::new();
        for (name, open) in candidates(egl) {
            match open().and_then(|display| Self::on(egl, display)) {
                Ok(context) => return Ok(context),
                Err(cause) => tried.push(format!("{name}: {cause}")),
            }
        }
        Err(no_gl(tried.join("; ")))
    }

    fn on(egl: &'static Egl, display: egl::Display) -> Result<Self, String> {
        let failed = |call: &'static str| move |e: egl::Error| format!("{call} failed, {e}");
        egl.initialize(display).map_err(failed("eglInitialize"))?;
        egl.bind_api(egl::OPENGL_API).map_err(failed("eglBindAPI"))?;
        let wanted =
            [egl::SURFACE_TYPE, egl::PBUFFER_BIT, egl::RENDERABLE_TYPE, egl::OPENGL_BIT, egl::NONE];
        let config = egl
            .choose_first_config(display, &wanted)
            .map_err(failed("eglChooseConfig"))?
            .ok_or("it offers no OpenGL")?;
        let context = create(egl, display, config)?;
        let mut created = Self { egl, display, context, surface: None, window: None };
        if !has_extension(egl, Some(display), "EGL_KHR_surfaceless_context") {
            let size = [egl::WIDTH, 1, egl::HEIGHT, 1, egl::NONE];
            let surface = egl.create_pbuffer_surface(display, config, &size);
            created.surface = Some(surface.map_err(failed("eglCreatePbufferSurface"))?);
        }
        created.make_current().map_err(|error| error.to_string())?;
        Ok(created)
    }

    /// Returns a context that draws into a window of `size` pixels (width, height).
    pub(super) fn in_window(target: Arc<dyn WindowTarget>, size: [u32; 2]) -> Result<Self, Error> {
        let _starting = driver_start();
        let egl = library().map_err(|cause| no_gl(format!("libEGL: {cause}")))?;
        Self::on_window(egl, target, size).map_err(|cause| no_gl(format!("the window: {cause}")))
    }

    fn on_window(
        egl: &'static Egl,
        target: Arc<dyn WindowTarget>,
        size: [u32; 2],
    ) -> Result<Self, String> {
        let failed = |call: &'static str| move |e: egl::Error| format!("{call} failed, {e}");
        let mut window = NativeWindow::new(target, size)?;
        let (platform, native) = window.display();
        let display = platform_display(egl, platform, native)?;
        egl.initialize(display).map_err(failed("eglInitialize"))?;
        egl.bind_api(egl::OPENGL_API).map_err(failed("eglBindAPI"))?;
        let config = window_config(egl, display, window.visual())?;
        let context = create(egl, display, config)?;
        let mut created = Self { egl, display, context, surface: None, window: None };
        // SAFETY: the display is that of the window's platform, for which EGL 1.5 wants the
        // pointer that `surface_argument` returns. The window lives until the context is dropped.
        let surface = unsafe {
            let native = window.surface_argument();
            egl.create_platform_window_surface(display, config, native, &[egl::ATTRIB_NONE])
        };
        created.surface = Some(surface.map_err(failed("eglCreatePlatformWindowSurface"))?);
        created.window = Some(window);
        created.make_current().map_err(|error| error.to_string())?;
        // Without an interval, frames tear but are shown all the same.
        let _ = egl.swap_interval(display, 1);
        Ok(created)
    }

    /// Returns true if the context draws into a window.
    pub(super) fn has_window(&self) -> bool {
        self.window.is_some()
    }

    /// Tells the window's surface its size in pixels, where it does not know it.
    pub(super) fn resize_window(&self, size: [u32; 2]) {
        self.window.iter().for_each(|window| window.resize(size));
    }

    /// Shows what was drawn into the window. Waits for the screen if it is ahead of it.
    pub(super) fn swap(&self) -> Result<(), Error> {
        let (Some(surface), true) = (self.surface, self.has_window()) else {
            return Err(Error::NoWindow);
        };
        self.egl
            .swap_buffers(self.display, surface)
            .map_err(|cause| Error::ContextLost { cause: cause.to_string() })
    }

    pub(super) fn make_current(&self) -> Result<(), Error> {
        if self.egl.get_current_context() == Some(self.context) {
            return Ok(());
        }
        self.egl
            .make_current(self.display, self.surface, self.surface, Some(self.context))
            .map_err(|cause| Error::ContextLost { cause: cause.to_string() })
    }

    /// Releases this context if it is current on this thread.
    pub(super) fn release_current(&self) {
        if self.egl.get_current_context() == Some(self.context) {
            // If this fails, the context is released once another one becomes current.
            let _ = self.egl.make_current(self.display, None, None, None);
        }
    }

    pub(super) fn proc_address(&self, name: &str) -> *const c_void {
        self.egl.get_proc_address(name).map_or(std::ptr::null(), |f| f as *const c_void)
    }
}

/// Creates a context of OpenGL 4.3 core.
fn create(egl: &Egl, display: egl::Display, config: egl::Config) -> Result<egl::Context, String> {
    let version = [
        egl::CONTEXT_MAJOR_VERSION,
        4,
        egl::CONTEXT_MINOR_VERSION,
        3,
        egl::CONTEXT_OPENGL_PROFILE_MASK,
        egl::CONTEXT_OPENGL_CORE_PROFILE_BIT,
        egl::NONE,
    ];
    egl.create_context(display, config, None, &version)
        .map_err(|e| format!("eglCreateContext for OpenGL 4.3 failed, {e}"))
}

/// Returns a configuration of a window; the one of its visual if it has one.
fn window_config(
    egl: &Egl,
    display: egl::Display,
    visual: Option<c_ulong>,
) -> Result<egl::Config, String> {
    let wanted = [
        [egl::SURFACE_TYPE, egl::WINDOW_BIT],
        [egl::RENDERABLE_TYPE, egl::OPENGL_BIT],
        [egl::RED_SIZE, 8],
        [egl::GREEN_SIZE, 8],
        [egl::BLUE_SIZE, 8],
    ];
    let wanted: Vec<egl::Int> = wanted.into_iter().flatten().chain([egl::NONE]).collect();
    let failed = |e: egl::Error| format!("eglChooseConfig failed, {e}");
    let count = egl.matching_config_count(display, &wanted).map_err(failed)?;
    let mut configs = Vec::with_capacity(count);
    egl.choose_config(display, &wanted, &mut configs).map_err(failed)?;
    let is_visual = |config: &egl::Config| {
        let id = egl.get_config_attrib(display, *config, egl::NATIVE_VISUAL_ID);
        visual.is_some() && id.is_ok_and(|id| c_ulong::try_from(id).ok() == visual)
    };
    let found = configs.iter().copied().find(is_visual).or(configs.first().copied());
    found.ok_or_else(|| "it offers no OpenGL for windows".to_owned())
}

// SAFETY: EGL functions can be called on every thread (EGL 1.5, section 2.6), with every handle.
// eglMakeCurrent rejects a context that is current on another thread (section 3.7.3), and
// eglDestroyContext defers until the context is no longer current (sections 3.2 and 3.7.2). A window
// can be sent and shared, as `WindowTarget` demands, and `NativeWindow` never changes.
unsafe impl Send for Context {}
// SAFETY: as above; `Context` holds only handles, which never change, and the window.
unsafe impl Sync for Context {}

impl fmt::Debug for Context {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Context").field(&self.context).finish()
    }
}

// SAFETY: the handles are those of the display and of the context that `on` created. The context is
// destroyed when `self` is dropped; the display is never terminated.
unsafe impl GlContext for Context {
    fn handles(&self) -> EglHandles {
        EglHandles {
            display: self.display.as_ptr() as usize,
            context: self.context.as_ptr() as usize,
        }
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // Errors are ignored, since `drop` cannot return them. The display stays initialised: all
        // contexts of the process share it, and terminating it would destroy them.
        self.release_current();
        let _ = self.egl.destroy_context(self.display, self.context);
        if let Some(surface) = self.surface {
            let _ = self.egl.destroy_surface(self.display, surface);
        }
    }
}

pub(super) fn no_gl(tried: String) -> Error {
    Error::NoGl { tried, remedy: REMEDY }
}

/// Loads libEGL once per process. It is never unloaded, since drivers may have running threads and
/// registered thread-local destructors.
fn library() -> Result<&'static Egl, String> {
    static LIBRARY: OnceLock<Result<Egl, String>> = OnceLock::new();
    LIBRARY
        .get_or_init(|| {
            // SAFETY: loading runs the library's initialisers. libEGL is a system library and
            // follows the EGL specification, as do the function types of khronos-egl.
            unsafe { Egl::load_required() }.map_err(|error| match error {
                egl::LoadError::Library(cause) => cause.to_string(),
                egl::LoadError::InvalidVersion { provided, .. } => {
                    format!("it is version {provided:?}; 1.5 is needed")
                }
            })
        })
        .as_ref()
        .map_err(Clone::clone)
}

type Open = Box<dyn FnOnce() -> Result<egl::Display, String>>;

/// Returns the displays to try, each with a name for error messages.
fn candidates(egl: &'static Egl) -> Vec<(String, Open)> {
    let mut list: Vec<(String, Open)> = Vec::new();
    if has_extension(egl, None, "EGL_EXT_platform_device") {
        let mut devices = devices(egl);
        devices.sort_by_key(|device| device.software);
        for (index, device) in devices.into_iter().enumerate() {
            let kind = if device.software { " (software)" } else { "" };
            let open = Box::new(move || platform_display(egl, PLATFORM_DEVICE, device.handle));
            list.push((format!("EGL device {index}{kind}"), open));
        }
    }
    if has_extension(egl, None, "EGL_MESA_platform_surfaceless") {
        let open =
            Box::new(move || platform_display(egl, PLATFORM_SURFACELESS, std::ptr::null_mut()));
        list.push(("Mesa without a surface".into(), open));
    }
    let open = Box::new(move || {
        // SAFETY: EGL_DEFAULT_DISPLAY is null, which every implementation accepts.
        unsafe { egl.get_display(std::ptr::null_mut()) }.ok_or_else(|| "there is none".to_owned())
    });
    list.push(("default display".into(), open));
    list
}

fn has_extension(egl: &Egl, display: Option<egl::Display>, name: &str) -> bool {
    egl.query_string(display, egl::EXTENSIONS)
        .is_ok_and(|list| list.to_string_lossy().split(' ').any(|extension| extension == name))
}

struct Device {
    handle: *mut c_void,
    software: bool,
}

/// Returns the devices that EGL_EXT_device_enumeration lists.
fn devices(egl: &Egl) -> Vec<Device> {
    type QueryDevices = extern "system" fn(i32, *mut *mut c_void, *mut i32) -> u32;
    type QueryDeviceString = extern "system" fn(*mut c_void, i32) -> *const std::ffi::c_char;
    let query = egl.get_proc_address("eglQueryDevicesEXT");
    let (Some(query), Some(query_string)) =
        (query, egl.get_proc_address("eglQueryDeviceStringEXT"))
    else {
        return Vec::new();
    };
    // SAFETY: EGL_EXT_device_enumeration and EGL_EXT_device_query give these names these types
    // (EGLint is 32 bits, EGLBoolean an unsigned int).
    let (query, query_string) = unsafe {
        (
            std::mem::transmute::<extern "system" fn(), QueryDevices>(query),
            std::mem::transmute::<extern "system" fn(), QueryDeviceString>(query_string),
        )
    };
    let mut handles = [std::ptr::null_mut(); MAX_DEVICES as usize];
    let mut count = 0;
    if query(i32::from(MAX_DEVICES), handles.as_mut_ptr(), &raw mut count) == 0 {
        return Vec::new();
    }
    let count = usize::try_from(count).unwrap_or(0).min(handles.len());
    let is_software = |handle| {
        let extensions = query_string(handle, egl::EXTENSIONS);
        // SAFETY: for a handle from eglQueryDevicesEXT, the string is null or zero-terminated, and
        // it is never freed.
        !extensions.is_null()
            && unsafe { CStr::from_ptr(extensions) }
                .to_string_lossy()
                .contains("EGL_MESA_device_software")
    };
    handles[..count]
        .iter()
        .map(|&handle| Device { handle, software: is_software(handle) })
        .collect()
}

/// Calls `eglGetPlatformDisplay`. The function of khronos-egl panics if a driver returns neither a
/// display nor an error.
fn platform_display(
    egl: &Egl,
    platform: egl::Enum,
    native: *mut c_void,
) -> Result<egl::Display, String> {
    type GetPlatformDisplay =
        extern "system" fn(egl::Enum, *mut c_void, *const egl::Attrib) -> egl::EGLDisplay;
    let get =
        egl.get_proc_address("eglGetPlatformDisplay").ok_or("eglGetPlatformDisplay is missing")?;
    // SAFETY: EGL 1.5, which `library` requires, gives this name this type.
    let get = unsafe { std::mem::transmute::<extern "system" fn(), GetPlatformDisplay>(get) };
    let display = get(platform, native, std::ptr::null());
    if display == egl::NO_DISPLAY {
        return Err("it has no display".to_owned());
    }
    // SAFETY: `display` is a valid handle that EGL just returned.
    Ok(unsafe { egl::Display::from_ptr(display) })
}
