//! OpenCL devices: finding them, and one of them made ready.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; creating a command queue is part of the crate's boundary to it"
)]

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::device::{
    CL_DEVICE_PARTITION_EQUALLY, CL_DEVICE_TYPE_ALL, CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU,
    CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT, Device, SubDevice,
};
use opencl3::error_codes::ClError;
use opencl3::kernel::Kernel;
use opencl3::platform::get_platforms;
use opencl3::program::Program;
use populace_core::{BackendError, GlContext};

use crate::gl_sharing::{NOT_OFFERED, context_for, is_offered};
use crate::program::Form;

/// What cl3 answers when there is no libOpenCL to load.
const NO_LIBRARY: i32 = -2000;
/// `CL_PLATFORM_NOT_FOUND_KHR`: a loader without any driver.
const NO_PLATFORM: i32 = -1001;
/// `CL_DEVICE_NOT_FOUND`: a driver without any device.
const NO_DEVICE: i32 = -1;

/// Programs that a device keeps for crowds to come, before it forgets those with users' stages.
const PROGRAMS_KEPT: usize = 16;

/// What a device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A graphics processor.
    Gpu,
    /// The host's processor.
    Cpu,
    /// Anything else.
    Other,
}

/// A device for people to choose from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// The number that [`OpenClDevice::open`] takes.
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// What it is.
    pub kind: DeviceKind,
    /// Compute units.
    pub compute_units: u32,
    /// Into how many equal parts the device can be cut at most, for [`OpenClDevice::open_part`]; 1 where it cannot be cut.
    pub most_parts: u32,
    /// Memory in bytes.
    pub memory_bytes: u64,
    /// The most that can be allocated at once, in bytes.
    pub max_allocation_bytes: u64,
    /// What the work-items of a group share, in bytes.
    pub local_memory_bytes: u64,
    /// Whether the driver offers `cl_khr_gl_sharing`; see [`OpenClDevice::open_for_gl`].
    pub shares_with_gl: bool,
}

/// All OpenCL devices of this machine, in the order of their platforms.
///
/// # Errors
///
/// [`BackendError::NoRuntime`] without libOpenCL or without any driver.
pub fn devices() -> Result<Vec<DeviceInfo>, BackendError> {
    let found = all_devices()?;
    found
        .iter()
        .enumerate()
        .map(|(index, device)| info(index, device).map_err(|e| failed("OpenCL", "describe a device", &e)))
        .collect()
}

fn all_devices() -> Result<Vec<Device>, BackendError> {
    // Two threads that ask for the first time at once can both be told that there is no platform: the loader's own
    // set-up is not safe against that.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let platforms = match get_platforms() {
        Err(ClError(NO_LIBRARY | NO_PLATFORM)) => return Err(BackendError::NoRuntime),
        other => other.map_err(|e| failed("OpenCL", "list its platforms", &e))?,
    };
    let mut devices = Vec::new();
    for platform in platforms {
        match platform.get_devices(CL_DEVICE_TYPE_ALL) {
            Err(ClError(NO_DEVICE)) => {}
            found => devices.extend(
                found.map_err(|e| failed("OpenCL", "list its devices", &e))?.into_iter().map(Device::new),
            ),
        }
    }
    if devices.is_empty() { Err(BackendError::NoRuntime) } else { Ok(devices) }
}

fn info(index: usize, device: &Device) -> Result<DeviceInfo, ClError> {
    let kind = device.dev_type()?;
    Ok(DeviceInfo {
        index,
        name: device.name()?.trim().to_owned(),
        driver: format!("{} {}", device.vendor()?.trim(), device.driver_version()?.trim()),
        kind: if kind & CL_DEVICE_TYPE_GPU != 0 {
            DeviceKind::Gpu
        } else if kind & CL_DEVICE_TYPE_CPU != 0 {
            DeviceKind::Cpu
        } else {
            DeviceKind::Other
        },
        compute_units: device.max_compute_units()?,
        most_parts: most_parts(device)?,
        memory_bytes: device.global_mem_size()?,
        max_allocation_bytes: device.max_mem_alloc_size()?,
        local_memory_bytes: device.local_mem_size()?,
        shares_with_gl: is_offered(device)?,
    })
}

fn most_parts(device: &Device) -> Result<u32, ClError> {
    let is_cut_equally = device.partition_properties()?.contains(&CL_DEVICE_PARTITION_EQUALLY);
    Ok(if is_cut_equally {
        device.partition_max_sub_devices()?.clamp(1, device.max_compute_units()?)
    } else {
        1
    })
}

/// One of the equal parts of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DevicePart {
    /// Which part, from 1.
    pub part: usize,
    /// How many parts there are.
    pub parts: usize,
}

/// A part of a device. A device is cut once into so many parts and stays so: the parts are then apart from each other,
/// and PoCL 3.1 crashes where one is let go of while its threads still clear up. Compute units that are left over belong
/// to no part.
fn part_of(whole: &Device, info: &DeviceInfo, part: DevicePart) -> Result<Device, BackendError> {
    type Cuts = HashMap<(usize, usize), Vec<SubDevice>>;
    static CUT: OnceLock<Mutex<Cuts>> = OnceLock::new();
    let DevicePart { part, parts } = part;
    let mut cuts = CUT.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner);
    let cut = match cuts.entry((info.index, parts)) {
        Entry::Occupied(cut) => cut.into_mut(),
        Entry::Vacant(place) => place.insert(cut(whole, info, parts)?),
    };
    let found = cut.get(part.wrapping_sub(1)).map(|part| Device::new(part.id()));
    let cause = || format!("there is no part {part} among them");
    found.ok_or_else(|| BackendError::NoPart { device: info.name.clone(), parts, cause: cause() })
}

fn cut(whole: &Device, info: &DeviceInfo, parts: usize) -> Result<Vec<SubDevice>, BackendError> {
    let (units, most) = (info.compute_units, info.most_parts);
    let refused = |cause| BackendError::NoPart { device: info.name.clone(), parts, cause };
    if most < 2 {
        return Err(refused("its driver does not offer that".into()));
    }
    if !(1..=most as usize).contains(&parts) {
        return Err(refused(format!("it has {units} compute units, for at most {most} parts")));
    }
    let each = (units as usize / parts).cast_signed();
    let found = whole.create_sub_devices(&[CL_DEVICE_PARTITION_EQUALLY, each, 0]);
    let mut found = found.map_err(|e| failed(&info.name, &format!("cut itself into {parts} parts"), &e))?;
    found.truncate(parts); // units that are left over can make one more
    Ok(found)
}

/// A device with its context and the programs built for it. Crowds on the same device share it.
#[derive(Debug)]
pub struct OpenClDevice {
    pub(crate) info: DeviceInfo,
    pub(crate) context: Context,
    pub(crate) device: Device,
    /// By form, and by what users' stages add to it.
    programs: Mutex<HashMap<(Form, String), Program>>,
    /// What the context shares with; declared last, since that must outlive the context.
    pub(crate) gl: Option<Arc<dyn GlContext>>,
}

impl OpenClDevice {
    /// Makes the device of an index (see [`devices`]) ready. Kernels are built for it when they are first asked for.
    ///
    /// # Errors
    ///
    /// [`BackendError::NoRuntime`], [`BackendError::NoDevice`], or [`BackendError::Failed`].
    pub fn open(index: usize) -> Result<Arc<Self>, BackendError> {
        Self::open_with(index, None, None)
    }

    /// The same for one of several equal parts of a device, as if it were a device of its own: parts work at the same
    /// time, each on its own compute units. Units that are left over stay idle.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open); [`BackendError::NoPart`] where the device cannot be cut so, or has no such part.
    pub fn open_part(index: usize, part: DevicePart) -> Result<Arc<Self>, BackendError> {
        Self::open_with(index, Some(part), None)
    }

    /// The same for a device or a part of one, with a context that shares buffers with one of OpenGL's, so that palettes are written where OpenGL
    /// draws from ([`PaletteWay::Shared`](populace_core::PaletteWay::Shared)). Best called on the thread on which the
    /// context of OpenGL's is current: some drivers want that.
    ///
    /// This has not been run on a graphics processor yet: no driver at hand offers it.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open); [`BackendError::Failed`] too where the driver does not offer `cl_khr_gl_sharing`, or
    /// refuses this context.
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
        let whole = *devices.get(index).ok_or(BackendError::NoDevice { index, count: devices.len() })?;
        let describe = |device| info(index, device).map_err(|e| failed("OpenCL", "describe a device", &e));
        let device = part.map_or(Ok(whole), |part| part_of(&whole, &describe(&whole)?, part))?;
        let mut info = describe(&device)?;
        if let Some(DevicePart { part, parts }) = part {
            info.name += &format!(", part {part} of {parts}");
        }
        let context = match &gl {
            None => Context::from_device(&device).map_err(|e| failed(&info.name, "make a context", &e))?,
            Some(gl) => {
                let operation = "make a context that shares with OpenGL";
                if !info.shares_with_gl {
                    let (operation, cause) = (operation.into(), NOT_OFFERED.into());
                    return Err(BackendError::Failed { device: info.name, operation, cause });
                }
                context_for(&device, &**gl).map_err(|e| failed(&info.name, operation, &e))?
            }
        };
        Ok(Arc::new(Self { info, context, device, programs: Mutex::default(), gl }))
    }

    /// Builds kernels from their source; an error holds the compiler's log.
    pub(crate) fn build(&self, source: &str) -> Result<Program, BackendError> {
        let mut program = Program::create_from_source(&self.context, source)
            .map_err(|e| self.failed("take the kernels' source", &e))?;
        if let Err(error) = program.build(&[self.device.id()], &options(&self.device)) {
            let log = program.get_build_log(self.device.id()).unwrap_or_default();
            let (device, operation) = (self.info.name.clone(), "build the kernels".into());
            let cause = format!("{error}\n{}", log.trim());
            return Err(BackendError::Failed { device, operation, cause });
        }
        Ok(program)
    }

    /// What the device is.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// As many work-items per group as wished for, or as the device allows.
    pub(crate) fn group_size(&self, wished: usize) -> usize {
        self.device.max_work_group_size().map_or(1, |most| most.clamp(1, wished))
    }

    /// A kernel of a form's program with users' stages, or without where there are none; it is built the first time.
    pub(crate) fn kernel(&self, form: Form, stages: &str, name: &str) -> Result<Kernel, BackendError> {
        let mut programs = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
        if !stages.is_empty() && programs.len() >= PROGRAMS_KEPT {
            // Kernels in use keep theirs.
            programs.retain(|(_, stages), _| stages.is_empty());
        }
        let program = match programs.entry((form, stages.to_owned())) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(place) => {
                let built = self.build(&form.source(stages));
                place.insert(built.map_err(|error| if stages.is_empty() { error } else { in_stages(error) })?)
            }
        };
        Kernel::create(program, name).map_err(|e| self.failed(&format!("find the kernel {name}"), &e))
    }

    pub(crate) fn queue(&self) -> Result<CommandQueue, BackendError> {
        // SAFETY: the device belongs to the context, as `open` made the one from the other; the properties are ones
        // that every device has.
        let queue =
            unsafe { CommandQueue::create(&self.context, self.device.id(), CL_QUEUE_PROFILING_ENABLE) };
        queue.map_err(|e| self.failed("make a command queue", &e))
    }

    pub(crate) fn failed(&self, operation: &str, error: &ClError) -> BackendError {
        failed(&self.info.name, operation, error)
    }
}

/// What is wrong with a program that is right without users' stages.
fn in_stages(error: BackendError) -> BackendError {
    match error {
        BackendError::Failed { device, cause, .. } => BackendError::BadStages { device, log: cause },
        other => other,
    }
}

fn failed(device: &str, operation: &str, error: &ClError) -> BackendError {
    BackendError::Failed { device: device.into(), operation: operation.into(), cause: error.to_string() }
}

/// Correct rounding of `/` and `sqrt`, where the device has it, makes poses equal the native ones bit for bit too. On CPUs
/// constraints are called, since copies of them would be most of what there is to compile.
fn options(device: &Device) -> String {
    let rounded = device.single_fp_config().is_ok_and(|c| c & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT != 0);
    let rounding = if rounded { " -cl-fp32-correctly-rounded-divide-sqrt" } else { "" };
    let is_cpu = device.dev_type().is_ok_and(|kind| kind & CL_DEVICE_TYPE_CPU != 0);
    let calls = if is_cpu { " -D CALLS" } else { "" };
    format!("-cl-std=CL1.2 -cl-kernel-arg-info{rounding}{calls}")
}
