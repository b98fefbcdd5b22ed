//! One module for each command: arguments to checked values to calls of the library.

pub(crate) mod bench;
pub(crate) mod demo;
pub(crate) mod devices;
pub(crate) mod inspect;
pub(crate) mod pose;
pub(crate) mod render;
