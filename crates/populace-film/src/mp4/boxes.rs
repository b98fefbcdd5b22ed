//! Boxes of MP4 files, which nest: 4 bytes of size, 4 letters, contents.

/// Bytes of boxes, most significant byte first.
#[derive(Default)]
pub(super) struct Boxes(pub(super) Vec<u8>);

impl Boxes {
    /// Appends a box.
    pub(super) fn boxed(&mut self, name: &[u8; 4], contents: impl FnOnce(&mut Self)) {
        let start = self.0.len();
        self.u32(0).bytes(name);
        contents(self);
        let size = u32::try_from(self.0.len() - start).unwrap_or(u32::MAX);
        self.0[start..start + 4].copy_from_slice(&size.to_be_bytes());
    }

    /// Appends a box that begins with a version and 24 bits of flags.
    pub(super) fn full(
        &mut self,
        name: &[u8; 4],
        version: u8,
        flags: u32,
        contents: impl FnOnce(&mut Self),
    ) {
        self.boxed(name, |out| {
            out.u32(u32::from(version) << 24 | flags);
            contents(out);
        });
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.extend_from_slice(bytes);
        self
    }

    pub(super) fn zeros(&mut self, count: usize) -> &mut Self {
        self.0.resize(self.0.len() + count, 0);
        self
    }

    pub(super) fn u8(&mut self, value: u8) -> &mut Self {
        self.bytes(&[value])
    }

    pub(super) fn u16(&mut self, value: u16) -> &mut Self {
        self.bytes(&value.to_be_bytes())
    }

    pub(super) fn u32(&mut self, value: u32) -> &mut Self {
        self.bytes(&value.to_be_bytes())
    }

    pub(super) fn u64(&mut self, value: u64) -> &mut Self {
        self.bytes(&value.to_be_bytes())
    }
}
