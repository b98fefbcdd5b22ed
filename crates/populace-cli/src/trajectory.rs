//! Trajectory files among the inputs.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes by which a glTF file is told from others.
const HEAD_BYTES: u64 = 4096;

/// Returns true for an input that is neither a built-in person, a folder, standard input nor a glTF
/// file: it must be a trajectory file.
pub(crate) fn is_trajectory(input: &Path) -> bool {
    let extension = input.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let is_gltf = ["glb", "gltf", "vrm"].iter().any(|known| extension.eq_ignore_ascii_case(known));
    let is_named = input.to_str().is_some_and(|name| name.starts_with('@') || name == "-");
    if is_gltf || is_named || !input.is_file() {
        return false;
    }
    let mut head = Vec::new();
    let read = File::open(input).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head));
    let holds = |word: &[u8]| head.windows(word.len()).any(|bytes| bytes == word);
    read.is_ok() && !head.starts_with(b"glTF") && !(head.starts_with(b"{") && holds(b"\"asset\""))
}
