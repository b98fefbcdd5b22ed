//! The kind of an error, the same for all crates.

/// The kind of an error. Each error type of the libraries has a method `kind`, so that
/// callers can decide what to do without reading messages.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// A value, or data, that breaks a rule of the call. The message names the rule.
    InvalidInput,
    /// A name or index of something that does not exist.
    NotFound,
    /// A handle to something that is gone, or data that is not there yet.
    Stale,
    /// More than fits: offsets, a capacity, or the memory of a device.
    TooLarge,
    /// Something that this build, machine or device does not offer.
    Unsupported,
    /// A device or driver that failed.
    Device,
    /// A fault of the library itself.
    Internal,
}
