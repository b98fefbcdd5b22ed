//! The devices in use by a crowd, and the results that they hold.

use std::sync::Arc;

use populace_backends::{DeviceHistory, Opened};
use populace_device::layout::{Float4, RUNNING_ELEMENTS, Running};
use populace_device::{Backend, BackendError, Frame, GlContext, StageBuffer, Tables};

use crate::{Devices, Error};

/// The devices in use.
pub(super) struct ActiveDevice {
    pub(super) devices: Devices,
    pub(super) opened: Opened,
    /// The reason for the native device, if no device was selected.
    pub(super) fallback: Option<String>,
    /// The OpenGL context that devices share buffers with.
    pub(super) gl: Option<Arc<dyn GlContext>>,
    /// History that the previous device held, for the next frame.
    pub(super) history: Option<DeviceHistory>,
    /// Whether the device holds the results of the last update.
    pub(super) is_readable: bool,
    /// True once the device has begun an update: its pages may hold results of a frame.
    has_begun: bool,
}

impl ActiveDevice {
    pub(super) fn new(
        devices: Devices,
        opened: Opened,
        fallback: Option<String>,
        gl: Option<Arc<dyn GlContext>>,
    ) -> Self {
        Self { devices, opened, fallback, gl, history: None, is_readable: false, has_begun: false }
    }

    pub(super) fn backend(&self) -> &dyn Backend {
        self.opened.backend()
    }

    pub(super) fn backend_mut(&mut self) -> &mut dyn Backend {
        self.opened.backend_mut()
    }

    /// Uploads what changed in the tables, evaluates a frame, and starts to read watched joints if
    /// there are any. An error takes the frame back.
    pub(super) fn run(
        &mut self,
        tables: &mut Tables,
        frame: Frame,
        is_watched: bool,
    ) -> Result<(), Error> {
        (self.is_readable, self.has_begun) = (false, true);
        if let Some(history) = &mut self.history {
            history.forget_new_watched(tables);
            history.begin_rest(tables);
        }
        tables.sort_pages();
        self.opened.backend_mut().update(tables)?;
        tables.mark_clean();
        if let Some(history) = &self.history {
            history.write(self.opened.backend_mut(), tables)?;
        }
        let backend = self.opened.backend_mut();
        let fetch = |backend: &mut dyn Backend| {
            if is_watched { backend.fetch_watched(tables, frame.tick) } else { Ok(()) }
        };
        if let Err(error) = backend.run(tables, frame).and_then(|()| fetch(backend)) {
            backend.undo_frame();
            return Err(error.into());
        }
        (self.history, self.is_readable) = (None, true);
        Ok(())
    }

    /// Evaluates again the frame at whose end the history was taken, so that its results can be
    /// read. The history stays for the next frame.
    pub(super) fn run_again(&mut self, tables: &mut Tables, tick: u64) -> Result<(), Error> {
        if let Some(history) = &mut self.history {
            history.forget_new_watched(tables);
        }
        let history = self.history.clone();
        self.run(tables, Frame::of_all(tick), false)?;
        self.history = history;
        Ok(())
    }

    /// Refuses to read if the device holds no results of the last update.
    pub(super) fn check_readable(&self) -> Result<(), BackendError> {
        if self.is_readable { Ok(()) } else { Err(BackendError::NotEvaluated) }
    }

    /// Refuses to hand out palettes of a frame that was undone. A device that has begun no update
    /// has none, and renderers may connect to it.
    pub(super) fn check_drawable(&self) -> Result<(), BackendError> {
        if self.has_begun { self.check_readable() } else { Ok(()) }
    }

    /// Reads elements of the history of constraints, from the device or on its way to the next.
    pub(super) fn states<const N: usize>(
        &mut self,
        tables: &Tables,
        first: usize,
    ) -> Result<[Float4; N], Error> {
        if let Some(history) = &self.history {
            return Ok(history.states(first));
        }
        let mut elements = [Float4::default(); N];
        self.backend_mut().read(tables, StageBuffer::States, first, &mut elements)?;
        Ok(elements)
    }

    /// Returns the state of a machine instance after the last update.
    pub(super) fn running(&mut self, tables: &Tables, instance: u32) -> Result<Running, Error> {
        if let Some(history) = &self.history {
            return Ok(history.running(instance));
        }
        let mut elements = [Float4::default(); RUNNING_ELEMENTS as usize];
        if (instance as usize) < tables.machine_instances().tail().start {
            let first = instance as usize * elements.len();
            self.backend_mut().read(tables, StageBuffer::Running, first, &mut elements)?;
        }
        Ok(Running::from_elements(elements))
    }

    /// Returns the history of the device in use, or of the previous one if this device has run no
    /// frame.
    pub(super) fn history(&mut self, tables: &Tables) -> Result<DeviceHistory, Error> {
        match &self.history {
            Some(history) => Ok(history.clone()),
            None => Ok(DeviceHistory::read_all(self.opened.backend_mut(), tables)?),
        }
    }

    /// Takes a history for the next frame, and forgets the results of earlier ones.
    pub(super) fn take_history(&mut self, history: DeviceHistory) {
        (self.history, self.is_readable) = (Some(history), false);
        self.backend_mut().forget_fetched();
    }
}
