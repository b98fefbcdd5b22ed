//! Readers of text and of Menge's binary files, on small files of each family.

mod faults;
mod fixtures;
mod formats;
mod mutations;
mod recognition;
mod tables;
