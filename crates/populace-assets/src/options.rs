//! Limits of a load.

/// Limits of a load: the files that it may read and the memory that it may use. See
/// [`load_with`](crate::load_with).
///
/// ```
/// use populace_assets::LoadOptions;
///
/// let small = LoadOptions { memory_limit_bytes: 64 << 20, ..LoadOptions::default() };
/// assert!(!small.allow_outside);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Whether buffers and images may lie outside the folder of the file that refers to them. By
    /// default, absolute paths, paths with `..` and symbolic links are refused if they lead out of
    /// that folder.
    pub allow_outside: bool,
    /// Memory limit of one load in bytes, 1 GiB by default. The file, its JSON, nodes, buffers,
    /// arrays, decoded images and clip rows count towards it. Sizes are estimated from headers
    /// before anything is allocated.
    pub memory_limit_bytes: u64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { allow_outside: false, memory_limit_bytes: 1 << 30 }
    }
}
