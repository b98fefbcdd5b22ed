//! The commands, one module each: they check arguments and call the library.

#[cfg(feature = "bench")]
pub(crate) mod bench;
pub(crate) mod cast;
pub(crate) mod demo;
pub(crate) mod devices;
pub(crate) mod film;
pub(crate) mod inspect;
pub(crate) mod plan;
pub(crate) mod pose;
pub(crate) mod render;
#[cfg(feature = "viewer")]
pub(crate) mod view;
