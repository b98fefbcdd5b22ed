//! Reads the bytes of the input, and stops early if they cannot be glTF or exceed the budget.

use std::io::{self, Read};
use std::path::Path;

use crate::budget::Budget;
use crate::folder::open_regular;
use crate::glb;
use crate::log::{Checked, Log};

/// Number of bytes that are checked before the rest is read.
const START_BYTES: u64 = 4096;

/// Reads a regular file.
pub(crate) fn file(path: &Path, budget: &Budget, log: &Log) -> io::Result<Checked<Vec<u8>>> {
    let file = open_regular(path)?;
    let length = file.metadata()?.len();
    stream(file, Some(length), budget, log)
}

/// Reads a stream; `length` is its length in bytes if known. Reads the first [`START_BYTES`], and
/// the rest only if they look like glTF and the whole fits the budget.
pub(crate) fn stream(
    mut from: impl Read,
    length: Option<u64>,
    budget: &Budget,
    log: &Log,
) -> io::Result<Checked<Vec<u8>>> {
    let mut bytes = Vec::new();
    let read = from.by_ref().take(START_BYTES).read_to_end(&mut bytes)? as u64;
    // The length of a stream that has already ended is known.
    let length = if read < START_BYTES { Some(read) } else { length };
    let Ok(wanted) = glb::bytes_to_read(&bytes, length, log) else {
        return Ok(Err(crate::log::Reported));
    };
    if let Err(reported) =
        wanted.map_or(Ok(()), |wanted| budget.take("file", "its content", wanted))
    {
        return Ok(Err(reported));
    }
    // If the length is unknown, read one byte more than fits, so that the budget check below fails.
    let most = wanted.unwrap_or_else(|| budget.left().saturating_add(1));
    from.take(most.saturating_sub(read)).read_to_end(&mut bytes)?;
    bytes.truncate(usize::try_from(most).unwrap_or(usize::MAX));
    Ok(match wanted {
        Some(_) => Ok(bytes),
        None => budget.take("file", "its content", bytes.len() as u64).map(|()| bytes),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An endless stream of ones after `start`. Counts the bytes that were read.
    struct Endless<'a> {
        start: &'a [u8],
        read: u64,
    }

    impl Read for Endless<'_> {
        fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
            let copied = self.start.read(to)?;
            to[copied..].fill(1);
            self.read += to.len() as u64;
            Ok(to.len())
        }
    }

    /// Returns the problem of a refused stream and the number of bytes that were read.
    fn refused(start: &[u8], length: Option<u64>, limit: u64) -> (String, u64) {
        let log = Log::default();
        let mut endless = Endless { start, read: 0 };
        let read = stream(&mut endless, length, &Budget::new(limit, &log), &log).unwrap();
        assert!(read.is_err());
        (log.finish().unwrap_err()[0].to_string(), endless.read)
    }

    #[test]
    fn reading_stops_if_the_start_is_not_gltf() {
        for start in [&b""[..], b"\x89PNG", b" \n\t x", b"\xEF\xBB\xBF{}"] {
            let (problem, read) = refused(start, Some(3 << 30), 4 << 30);
            assert!(
                problem.starts_with("file: ") && read <= 2 * START_BYTES,
                "{problem} after {read}"
            );
        }
    }

    #[test]
    fn input_beyond_the_limit_is_not_read() {
        let header = |length: u32| [&b"glTF\x02\0\0\0"[..], &length.to_le_bytes()].concat();
        for (start, length, words) in [
            (b"{".to_vec(), Some(3 << 30), "needs 3072 MiB for its content"),
            (header(2 << 20), Some(3 << 30), "needs 2 MiB for its content"),
            (header(2 << 20), None, "needs 2 MiB for its content"),
            (
                header(2 << 20),
                Some(1 << 19),
                "header: says the file has 2097152 bytes, but it ends after",
            ),
            (header(13), None, "header: says the file has 13 bytes, too few"),
        ] {
            let (problem, read) = refused(&start, length, 1 << 20);
            assert!(problem.contains(words) && read <= 2 * START_BYTES, "{problem} after {read}");
        }
        // The length of piped JSON is unknown until its end, so it is read up to the limit.
        let (problem, read) = refused(b"{", None, 1 << 20);
        assert!(problem.contains("for its content") && read <= 3 << 20, "{problem} after {read}");
    }

    #[test]
    fn json_is_read_to_the_end_and_binary_to_its_declared_length() {
        let log = Log::default();
        let budget = Budget::new(1 << 20, &log);
        let long = [&b"{"[..], &[b' '; 5000]].concat();
        assert_eq!(stream(&long[..], None, &budget, &log).unwrap().unwrap(), long);
        let binary = [&b"glTF\x02\0\0\0\x20\0\0\0"[..], &[7; 100]].concat();
        assert_eq!(stream(&binary[..], Some(112), &budget, &log).unwrap().unwrap(), binary[..32]);
        let note = &log.finish().unwrap()[0];
        assert_eq!(
            note.to_string(),
            "header: says the file has 32 bytes, but it has 112; the rest is ignored"
        );
    }
}
