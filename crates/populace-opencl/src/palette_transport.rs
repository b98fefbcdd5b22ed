//! Palette transport from a device to OpenGL, determined without a crowd.

use std::sync::Arc;

use populace_device::layout::Float4;
use populace_device::{
    BackendError, GlContext, PaletteSource, PaletteTarget, PaletteTransport, ReleasedPalettes,
    TargetMark,
};

use crate::OpenClDevice;
use crate::handles::CommandQueue;
use crate::pages::Pages;

/// Palettes of a device without members. Linked to a renderer, it tells how palettes would reach
/// OpenGL. No kernel is built for it.
pub struct EmptyPalettes {
    queue: Arc<CommandQueue>,
    pages: Pages,
    not_for_gl: Option<String>,
    // Declared last: the OpenGL context that the device may share with must outlive all other
    // fields.
    device: Arc<OpenClDevice>,
}

impl EmptyPalettes {
    /// For an open device. `not_for_gl` is the reason why it could not be opened for the OpenGL
    /// context, if it could not.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] if the driver does not create a queue.
    pub fn new(
        device: &Arc<OpenClDevice>,
        not_for_gl: Option<String>,
    ) -> Result<Self, BackendError> {
        let (queue, pages) = (Arc::new(device.queue()?), Pages::default());
        Ok(Self { queue, pages, not_for_gl, device: Arc::clone(device) })
    }
}

impl PaletteSource for EmptyPalettes {
    fn page_lengths(&self) -> Vec<usize> {
        Vec::new()
    }

    fn refuses(&self, transport: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        let not_for_gl = self.not_for_gl.clone().filter(|_| transport == PaletteTransport::Shared);
        not_for_gl.or_else(|| self.device.refuses(transport, context))
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.pages.set_target(&self.device, &self.queue, target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        self.pages.release().map_err(|e| self.device.failed("release its palettes to OpenGL", &e))
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        let result = self.pages.with_page(&self.queue, page, reader);
        result.map_err(|e| self.device.failed(&format!("map page {page} of the palettes"), &e))
    }
}
