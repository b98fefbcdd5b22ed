//! File containers: plain JSON, or a binary file of chunks (glTF 2.0, section 4.4).

use crate::log::{Checked, Log, Reported};

const MAGIC: &[u8] = b"glTF";
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// JSON and binary data of a glTF file.
#[derive(Debug)]
pub(crate) struct Container<'a> {
    pub(crate) json: &'a [u8],
    /// Whether the file is binary. Only in a binary file may buffer 0 have no URI.
    pub(crate) binary: bool,
    /// The BIN chunk, if the file has one.
    pub(crate) bin: Option<&'a [u8]>,
}

/// Detects the format from the content and returns the JSON and the BIN chunk. File names are not
/// reliable enough for that.
pub(crate) fn split<'a>(bytes: &'a [u8], log: &Log) -> Checked<Container<'a>> {
    if bytes.starts_with(MAGIC) {
        return split_binary(bytes, log);
    }
    check_looks_like_json(bytes, "file", log)?;
    Ok(Container { json: bytes, binary: false, bin: None })
}

fn check_looks_like_json(bytes: &[u8], place: &str, log: &Log) -> Checked<()> {
    if bytes.starts_with(b"\xEF\xBB\xBF") {
        return Err(log.problem(
            place,
            "begins with a byte order mark, which is not allowed (glTF 2.0, section 2.7); save it \
             as UTF-8 without one",
        ));
    }
    match bytes.iter().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => Ok(()),
        Some(_) if place != "file" => {
            Err(log.problem(place, "is not a JSON object; it must begin with `{`"))
        }
        Some(_) => Err(log
            .problem(place, "is not a glTF file, which begins with `glTF` (binary) or `{` (JSON)")),
        None => Err(log.problem(place, "is empty")),
    }
}

/// Reads the little-endian number at byte `at`. Panics if `bytes` is too short.
fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes[at..at + 4].iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

/// Returns how many bytes of the input to read. `start` is its beginning, and `length` its length
/// in bytes if known. `None` means to read to the end.
pub(crate) fn bytes_to_read(start: &[u8], length: Option<u64>, log: &Log) -> Checked<Option<u64>> {
    if start.starts_with(MAGIC) {
        return declared_bytes(start, length, log).map(Some);
    }
    let continues = length.is_none_or(|length| length > start.len() as u64);
    if !(continues && start.iter().all(u8::is_ascii_whitespace)) {
        check_looks_like_json(start, "file", log)?;
    }
    Ok(length)
}

/// Returns the length in the header. `length` is the length of the input in bytes if known.
fn declared_bytes(start: &[u8], length: Option<u64>, log: &Log) -> Checked<u64> {
    let header = |what: String| Err(log.problem("header", what));
    if start.len() < HEADER_BYTES {
        return header(format!("ends after {} bytes; a header has {HEADER_BYTES}", start.len()));
    }
    let version = u32_at(start, 4);
    if version != 2 {
        return header(format!("says container version {version}; only version 2 is supported"));
    }
    let declared = u64::from(u32_at(start, 8));
    if declared < (HEADER_BYTES + CHUNK_HEADER_BYTES) as u64 {
        return header(format!(
            "says the file has {declared} bytes, too few for a header and a chunk"
        ));
    }
    match length {
        Some(length) if declared > length => {
            return header(format!(
                "says the file has {declared} bytes, but it ends after {length}; it may be cut off"
            ));
        }
        Some(length) if declared < length => {
            log.note(
                "header",
                format!(
                    "says the file has {declared} bytes, but it has {length}; the rest is ignored"
                ),
            );
        }
        _ => {}
    }
    Ok(declared)
}

/// Returns the file up to its declared length, without the header.
fn body<'a>(bytes: &'a [u8], log: &Log) -> Checked<&'a [u8]> {
    let declared = declared_bytes(bytes, Some(bytes.len() as u64), log)?;
    // `declared` is at most the length of `bytes`.
    let end = usize::try_from(declared).unwrap_or(bytes.len());
    Ok(&bytes[HEADER_BYTES..end])
}

fn split_binary<'a>(bytes: &'a [u8], log: &Log) -> Checked<Container<'a>> {
    let (mut json, mut bin) = (None, None);
    let mut rest = body(bytes, log)?;
    let mut failed = None;
    for index in 0.. {
        if rest.is_empty() {
            break;
        }
        let place = format!("chunk {index}");
        let (kind, chunk, after) = next_chunk(rest, &place, log)?;
        rest = after;
        let check: Checked<()> = match (index, kind) {
            (0, JSON) if chunk.is_empty() => {
                Err(log.problem(&*place, "is empty; it must hold the JSON"))
            }
            (0, JSON) => {
                json = Some(chunk);
                Ok(())
            }
            (0, _) => Err(log.problem(
                &*place,
                format!("is of kind {kind:#010x}; the first chunk must be JSON (0x4e4f534a)"),
            )),
            (1, BIN) => {
                bin = Some(chunk);
                Ok(())
            }
            (_, JSON) => Err(log.problem(&*place, "is a second JSON chunk; only one is allowed")),
            (_, BIN) if bin.is_some() => {
                Err(log.problem(&*place, "is a second BIN chunk; only one is allowed"))
            }
            (_, BIN) => Err(log.problem(&*place, "is BIN, which must be the second chunk")),
            _ => {
                log.note(&*place, format!("is of the unknown kind {kind:#010x} and is ignored"));
                Ok(())
            }
        };
        failed = failed.or(check.err());
    }
    if let Some(reported) = failed {
        return Err(reported);
    }
    let json = json.ok_or_else(|| log.problem("chunk 0", "is missing; it must hold the JSON"))?;
    check_looks_like_json(json, "chunk 0", log)?;
    Ok(Container { json, binary: true, bin })
}

/// Returns kind and content of the first chunk and the bytes after it.
fn next_chunk<'a>(
    rest: &'a [u8],
    place: &str,
    log: &Log,
) -> Result<(u32, &'a [u8], &'a [u8]), Reported> {
    if rest.len() < CHUNK_HEADER_BYTES {
        return Err(log.problem(
            place,
            format!("ends after {} bytes; a chunk header has {CHUNK_HEADER_BYTES}", rest.len()),
        ));
    }
    let (length, kind) = (u32_at(rest, 0) as usize, u32_at(rest, 4));
    let data = &rest[CHUNK_HEADER_BYTES..];
    if length > data.len() {
        return Err(log.problem(
            place,
            format!("says it has {length} bytes, but only {} are left", data.len()),
        ));
    }
    if length % 4 != 0 {
        return Err(log.problem(
            place,
            format!("has {length} bytes; chunks must be padded to a multiple of 4"),
        ));
    }
    Ok((kind, &data[..length], &data[length..]))
}
