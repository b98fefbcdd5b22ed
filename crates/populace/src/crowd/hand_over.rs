//! The crowd as a source of palettes for renderers that draw from device buffers.

use populace_device::layout::Float4;
use populace_device::{
    BackendError, DrawSource, GlContext, HandedOver, Instance, PaletteSource, PaletteTarget,
    PaletteTransport, TargetMark,
};

use super::Crowd;

impl PaletteSource for Crowd {
    fn page_lengths(&self) -> Vec<usize> {
        self.device.backend().page_lengths()
    }

    fn page_room(&self) -> Vec<usize> {
        self.state.base.tables.page_lengths().collect()
    }

    fn refuses(&self, way: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        let not_for_gl =
            self.device.opened.not_for_gl.clone().filter(|_| way == PaletteTransport::Shared);
        not_for_gl.or_else(|| self.device.backend().refuses(way, context))
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.device.backend_mut().set_target(target, mark)
    }

    fn hand_over(&mut self) -> Result<Option<HandedOver>, BackendError> {
        let handed = self.device.backend_mut().hand_over()?;
        self.update_offsets()?;
        Ok(handed)
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
        self.instances().collect()
    }
}
