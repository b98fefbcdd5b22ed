//! An open OpenCL device, or a part of one, and the programs built for it.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; creating a command queue is part of the crate's boundary to it"
)]

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use opencl3::command_queue::{self, CL_QUEUE_PROFILING_ENABLE};
use opencl3::context::Context;
use opencl3::device::{
    CL_DEVICE_PARTITION_EQUALLY, CL_DEVICE_TYPE_CPU, CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT, Device,
    SubDevice,
};
use opencl3::error_codes::ClError;
use opencl3::platform::Platform;
use opencl3::program::Program;
use populace_device::{BackendError, GlContext, PaletteTransport};

use crate::cache::{Cache, Entry as CacheEntry};
use crate::errors::failed;
use crate::finding::{DeviceInfo, all_devices, info};
use crate::gl_context::{NOT_OFFERED, context_for};
use crate::handles::{CommandQueue, Kernel};
use crate::program::Form;
use crate::{DeviceKind, pocl};

/// Programs that a device keeps before it drops those with users' stages.
const PROGRAMS_KEPT: usize = 16;

/// One of several equal parts of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DevicePart {
    /// Number of the part, from 1.
    pub part: usize,
    /// Number of parts.
    pub parts: usize,
}

/// Returns a part of a device. A device is split only once for each number of parts, and stays
/// split: the parts then never overlap, and PoCL 3.1 crashes if a part is released while its
/// threads still clean up. Remaining compute units belong to no part.
fn part_of(whole: &Device, info: &DeviceInfo, part: DevicePart) -> Result<Device, BackendError> {
    type Splits = HashMap<(usize, usize), Vec<SubDevice>>;
    static SPLITS: OnceLock<Mutex<Splits>> = OnceLock::new();
    let DevicePart { part, parts } = part;
    let mut splits =
        SPLITS.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner);
    let sub_devices = match splits.entry((info.index, parts)) {
        Entry::Occupied(existing) => existing.into_mut(),
        Entry::Vacant(vacant) => vacant.insert(split(whole, info, parts)?),
    };
    let found = sub_devices.get(part.wrapping_sub(1)).map(|part| Device::new(part.id()));
    let cause =
        || format!("has no part {part} of {parts}: parts count from 1; name one from 1 to {parts}");
    found.ok_or_else(|| BackendError::NoPart { device: info.name.clone(), parts, cause: cause() })
}

fn split(whole: &Device, info: &DeviceInfo, parts: usize) -> Result<Vec<SubDevice>, BackendError> {
    let (units, most) = (info.compute_units, info.most_parts);
    let refused = |reason: String| BackendError::NoPart {
        device: info.name.clone(),
        parts,
        cause: format!("cannot be cut into {parts} equal parts: {reason}; name the whole device"),
    };
    if most < 2 {
        return Err(refused("its driver cannot split it".into()));
    }
    if !(1..=most as usize).contains(&parts) {
        return Err(refused(format!("it has {units} compute units, for at most {most} parts")));
    }
    let each = (units as usize / parts).cast_signed();
    let found = whole.create_sub_devices(&[CL_DEVICE_PARTITION_EQUALLY, each, 0]);
    let mut found =
        found.map_err(|e| failed(&info.name, &format!("split into {parts} parts"), &e))?;
    found.truncate(parts); // remaining units can form one more part
    Ok(found)
}

/// A device with its context and the programs built for it. Crowds on the same device share it.
#[derive(Debug)]
pub struct OpenClDevice {
    pub(crate) info: DeviceInfo,
    pub(crate) context: Context,
    pub(crate) device: Device,
    /// By form and the text of users' stages.
    pub(crate) programs: Mutex<HashMap<(Form, String), Program>>,
    /// Cache of programs for later processes; `None` if the driver caches them itself.
    pub(crate) cache: Option<Cache>,
    /// The OpenGL context that is shared with. Declared last, since it must outlive the context.
    pub(crate) gl: Option<Arc<dyn GlContext>>,
}

impl OpenClDevice {
    /// Opens the device with an index of [`devices`](crate::devices). Kernels are built on first
    /// use.
    ///
    /// # Errors
    ///
    /// [`BackendError::NoRuntime`], [`BackendError::NoDevice`], [`BackendError::Unusable`], or
    /// [`BackendError::Failed`].
    pub fn open(index: usize) -> Result<Arc<Self>, BackendError> {
        Self::open_with(index, None, None)
    }

    /// Opens one of several equal parts of a device as a device of its own. Parts work at the same
    /// time, each on its own compute units. Remaining units stay idle.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open); [`BackendError::NoPart`] if the device cannot be split this way or
    /// has no such part.
    pub fn open_part(index: usize, part: DevicePart) -> Result<Arc<Self>, BackendError> {
        Self::open_with(index, Some(part), None)
    }

    /// Opens a device, or a part of one, with a context that shares buffers with an OpenGL context,
    /// so that palettes are written where OpenGL draws from
    /// ([`PaletteTransport::Shared`](populace_device::PaletteTransport::Shared)). Call it on the
    /// thread on which the OpenGL context is current, because some drivers require that.
    ///
    /// This has not been run on a graphics processor yet, because no available driver supports it.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open); also [`BackendError::Failed`] if the driver lacks
    /// `cl_khr_gl_sharing` or refuses this context.
    pub fn open_for_gl(
        index: usize,
        part: Option<DevicePart>,
        gl: Arc<dyn GlContext>,
    ) -> Result<Arc<Self>, BackendError> {
        Self::open_with(index, part, Some(gl))
    }

    fn open_with(
        index: usize,
        part: Option<DevicePart>,
        gl: Option<Arc<dyn GlContext>>,
    ) -> Result<Arc<Self>, BackendError> {
        let devices = all_devices()?;
        let whole =
            *devices.get(index).ok_or(BackendError::NoDevice { index, count: devices.len() })?;
        let describe =
            |device| info(index, device).map_err(|e| failed("OpenCL", "describe a device", &e));
        let device = part.map_or(Ok(whole), |part| part_of(&whole, &describe(&whole)?, part))?;
        let mut info = describe(&device)?;
        if let Some(cause) = info.fault {
            return Err(BackendError::Unusable { device: info.name, cause });
        }
        if let Some(DevicePart { part, parts }) = part {
            info.name += &format!(", part {part} of {parts}");
        }
        let context = match &gl {
            None => Context::from_device(&device)
                .map_err(|e| failed(&info.name, "create a context", &e))?,
            Some(gl) => {
                let operation = "create a context that shares buffers with OpenGL";
                if !info.shares_with_gl {
                    let (operation, cause) = (operation.into(), NOT_OFFERED.into());
                    return Err(BackendError::Failed { device: info.name, operation, cause });
                }
                context_for(&device, &**gl).map_err(|e| failed(&info.name, operation, &e))?
            }
        };
        // PoCL caches kernels in a folder of its own, and compiles each kernel once more to return
        // a program's binary.
        let cache = if pocl::offers(&device) { None } else { Cache::of_user() };
        Ok(Arc::new(Self { info, context, device, programs: Mutex::default(), cache, gl }))
    }

    /// Builds kernels from their source, or loads them from the cache. An error contains the
    /// compiler's log.
    pub(crate) fn build(&self, source: &str) -> Result<Program, BackendError> {
        let options = options(&self.device);
        let entry = self.cache_entry(source, &options);
        let kept = entry.as_ref().and_then(CacheEntry::read);
        if let Some(program) = kept.and_then(|binary| self.load(&binary, &options)) {
            return Ok(program);
        }
        let program = self.compile(source, &options)?;
        // Without a binary, later processes build again; nothing else is lost.
        if let Some(entry) = entry
            && let Ok([binary]) = program.get_binaries().as_deref()
        {
            entry.write(binary);
        }
        Ok(program)
    }

    /// Returns the cache entry of a program for this device, named by everything that the binary
    /// depends on. The native vector width distinguishes processors with the same name.
    fn cache_entry(&self, source: &str, options: &str) -> Option<CacheEntry> {
        let (cache, device) = (self.cache.as_ref()?, &self.device);
        let platform = Platform::new(device.platform().ok()?);
        let width = device.native_vector_width_float().ok()?.to_string();
        let driver = [device.driver_version().ok()?, device.version().ok()?];
        let names = [
            device.name().ok()?,
            device.vendor().ok()?,
            platform.name().ok()?,
            platform.version().ok()?,
        ];
        let parts = names.iter().chain(&driver).chain([&width]).map(String::as_str);
        Some(cache.entry(parts.chain([options, source])))
    }

    /// Creates a program from its binary; `None` if the driver refuses it.
    fn load(&self, binary: &[u8], options: &str) -> Option<Program> {
        let id = self.device.id();
        // SAFETY: the device belongs to the context, and one device comes with one binary.
        let program = unsafe { Program::create_from_binary(&self.context, &[id], &[binary]) };
        let mut program = program.ok()?;
        program.build(&[id], options).ok()?;
        Some(program)
    }

    fn compile(&self, source: &str, options: &str) -> Result<Program, BackendError> {
        let mut program = Program::create_from_source(&self.context, source)
            .map_err(|e| self.failed("create a program from the kernels' source", &e))?;
        if let Err(error) = program.build(&[self.device.id()], options) {
            let log = program.get_build_log(self.device.id()).unwrap_or_default();
            let (device, operation) = (self.info.name.clone(), "build the kernels".into());
            let cause = format!("{error}\n{}", log.trim());
            return Err(BackendError::Failed { device, operation, cause });
        }
        Ok(program)
    }

    /// Describes the device.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Returns why palettes cannot reach an OpenGL context by `transport`, as far as that is known
    /// without trying.
    pub(crate) fn refuses(
        &self,
        transport: PaletteTransport,
        context: &dyn GlContext,
    ) -> Option<String> {
        let reason = match (transport, &self.gl) {
            (PaletteTransport::Mapped, _) if self.info.kind != DeviceKind::Cpu => {
                "it does not share the host's memory"
            }
            (PaletteTransport::Shared, Some(gl)) if gl.handles() != context.handles() => {
                "its OpenCL context was created for another OpenGL context"
            }
            (PaletteTransport::Shared, None) if !self.info.shares_with_gl => NOT_OFFERED,
            (PaletteTransport::Shared, None) => {
                "its OpenCL context was not created for an OpenGL context"
            }
            _ => return None,
        };
        Some(reason.into())
    }

    /// Returns the work-items in a work-group: `wished`, or as many as the device allows.
    pub(crate) fn group_size(&self, wished: usize) -> usize {
        self.device.max_work_group_size().map_or(1, |most| most.clamp(1, wished))
    }

    /// Returns a kernel of a form's program, built with the text of users' stages, which may be
    /// empty. The program is built on first use.
    pub(crate) fn kernel(
        &self,
        form: Form,
        stages: &str,
        name: &str,
    ) -> Result<Kernel, BackendError> {
        let mut programs = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
        if !stages.is_empty() && programs.len() >= PROGRAMS_KEPT {
            // Kernels in use keep their program alive.
            programs.retain(|(_, stages), _| stages.is_empty());
        }
        let program =
            match programs.entry((form, stages.to_owned())) {
                Entry::Occupied(built) => built.into_mut(),
                Entry::Vacant(vacant) => {
                    let built = self.build(&form.source(stages));
                    vacant.insert(built.map_err(|error| {
                        if stages.is_empty() { error } else { in_stages(error) }
                    })?)
                }
            };
        Kernel::create(program, name)
            .map_err(|e| self.failed(&format!("find the kernel {name}"), &e))
    }

    pub(crate) fn queue(&self) -> Result<CommandQueue, BackendError> {
        // SAFETY: the device belongs to the context, since `open` made the context from the device;
        // all devices have these properties.
        let queue = unsafe {
            command_queue::CommandQueue::create(
                &self.context,
                self.device.id(),
                CL_QUEUE_PROFILING_ENABLE,
            )
        };
        queue.map(CommandQueue::from).map_err(|e| self.failed("create a command queue", &e))
    }

    pub(crate) fn failed(&self, operation: &str, error: &ClError) -> BackendError {
        failed(&self.info.name, operation, error)
    }
}

/// Turns a build error into one about users' stages, since the program builds without them.
fn in_stages(error: BackendError) -> BackendError {
    match error {
        BackendError::Failed { device, cause, .. } => {
            BackendError::BadStages { device, log: cause }
        }
        other => other,
    }
}

/// Compiler options. Correct rounding of `/` and `sqrt`, if the device supports it, makes poses
/// equal the native ones bit for bit. On CPUs, constraints are called, since inlined copies would
/// dominate compile time.
fn options(device: &Device) -> String {
    let rounded =
        device.single_fp_config().is_ok_and(|c| c & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT != 0);
    let rounding = if rounded { " -cl-fp32-correctly-rounded-divide-sqrt" } else { "" };
    let is_cpu = device.dev_type().is_ok_and(|kind| kind & CL_DEVICE_TYPE_CPU != 0);
    let calls = if is_cpu { " -D CALLS" } else { "" };
    // Without -w some compilers print the number of warnings to stderr.
    format!("-w -cl-std=CL1.2 -cl-kernel-arg-info{rounding}{calls}")
}
