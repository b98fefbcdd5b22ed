//! The crowd as a source of palettes for renderers that draw from device buffers.

use populace_device::layout::Float4;
use populace_device::{
    BackendError, DrawSource, GlContext, Instance, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, TargetMark,
};

use super::Crowd;

impl PaletteSource for Crowd {
    fn page_lengths(&self) -> Vec<usize> {
        self.device.backend().page_lengths()
    }

    fn page_room(&self) -> Vec<usize> {
        self.state.base.tables.page_lengths().collect()
    }

    fn refuses(&self, transport: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        let is_shared = transport == PaletteTransport::Shared;
        let not_for_gl = self.device.opened.not_for_gl.clone().filter(|_| is_shared);
        not_for_gl.or_else(|| self.device.backend().refuses(transport, context))
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.device.backend_mut().set_target(target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        self.device.check_drawable()?;
        let released = self.device.backend_mut().release_palettes()?;
        self.update_offsets()?;
        Ok(released)
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        self.device.check_readable()?;
        self.device.backend_mut().with_page(page, reader)?;
        self.update_offsets()
    }
}

impl DrawSource for Crowd {
    fn instances(&self) -> Vec<Instance<'_>> {
        self.all_instances()
    }
}
