//! The crowd as a source of palettes for renderers that draw from device buffers.

use populace_device::layout::Float4;
use populace_device::{
    BackendError, GlContext, PaletteSource, PaletteTarget, PaletteTransport, ReleasedPalettes,
    TargetMark,
};

use super::Crowd;

impl PaletteSource for Crowd {
    fn page_lengths(&self) -> Vec<usize> {
        self.opened.backend().page_lengths()
    }

    fn page_room(&self) -> Vec<usize> {
        self.tables.page_lengths().collect()
    }

    fn refuses(&self, transport: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        let not_for_gl =
            self.opened.not_for_gl.clone().filter(|_| transport == PaletteTransport::Shared);
        not_for_gl.or_else(|| self.opened.backend().refuses(transport, context))
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.opened.backend_mut().set_target(target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        let released = self.opened.backend_mut().release_palettes()?;
        self.update_moved()?;
        Ok(released)
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        self.check_readable()?;
        self.opened.backend_mut().with_page(page, reader)?;
        self.update_moved()
    }
}
