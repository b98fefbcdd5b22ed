//! What a load may read and how much memory it may take.

/// What a load may read and how much memory it may take; see [`load_with`](crate::load_with).
///
/// ```
/// use populace_assets::LoadOptions;
///
/// let small = LoadOptions { memory_limit_bytes: 64 << 20, ..LoadOptions::default() };
/// assert!(!small.allow_outside);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Whether buffers and images may lie outside the folder of the file that names them. By
    /// default absolute paths, paths with `..` and symbolic links that lead out of that folder are
    /// refused.
    pub allow_outside: bool,
    /// Memory in bytes that one load may take: the file, its JSON, nodes, buffers, arrays, decoded
    /// images and the rows of clips. It is estimated from headers before anything is allocated. 1
    /// GiB by default.
    pub memory_limit_bytes: u64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { allow_outside: false, memory_limit_bytes: 1 << 30 }
    }
}
