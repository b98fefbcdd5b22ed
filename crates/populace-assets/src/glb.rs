//! The container: plain JSON, or a binary file of chunks (glTF 2.0, section 4.4).

use crate::log::{Checked, Log, Reported};

const MAGIC: &[u8] = b"glTF";
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// The two things that a glTF file consists of.
#[derive(Debug)]
pub(crate) struct Container<'a> {
    pub(crate) json: &'a [u8],
    /// Whether the file is binary; only there may buffer 0 be without a URI.
    pub(crate) binary: bool,
    pub(crate) bin: Option<&'a [u8]>,
}

/// Tells the kinds of file apart by content, since names lie, and finds the parts.
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
            "begins with a byte order mark; JSON must not (glTF 2.0, section 2.7)",
        ));
    }
    match bytes.iter().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => Ok(()),
        Some(_) if place != "file" => Err(log.problem(place, "is no JSON object")),
        Some(_) => {
            Err(log
                .problem(place, "is no glTF file: that begins with `glTF` (binary) or `{` (JSON)"))
        }
        None => Err(log.problem(place, "is empty")),
    }
}

/// The little-endian number at `at`; the caller has checked that it is there.
fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes[at..at + 4].iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

/// How many bytes of a file are to be read, told by its first ones and, where it is known, its
/// length; nothing where it is to be read to its end, wherever that is.
pub(crate) fn wanted_bytes(start: &[u8], length: Option<u64>, log: &Log) -> Checked<Option<u64>> {
    if start.starts_with(MAGIC) {
        return declared_bytes(start, length, log).map(Some);
    }
    let goes_on = length.is_none_or(|length| length > start.len() as u64);
    if !(goes_on && start.iter().all(u8::is_ascii_whitespace)) {
        check_looks_like_json(start, "file", log)?;
    }
    Ok(length)
}

/// The length that the header declares; `length` is that of the file, where it is known.
fn declared_bytes(start: &[u8], length: Option<u64>, log: &Log) -> Checked<u64> {
    let header = |what: String| Err(log.problem("header", what));
    if start.len() < HEADER_BYTES {
        return header(format!("ends after {} bytes; it has {HEADER_BYTES}", start.len()));
    }
    let version = u32_at(start, 4);
    if version != 2 {
        return header(format!("says container version {version}; version 2 is supported"));
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
                format!("the {} bytes after the end are ignored", length - declared),
            );
        }
        _ => {}
    }
    Ok(declared)
}

/// The file up to its declared length, without the header.
fn body<'a>(bytes: &'a [u8], log: &Log) -> Checked<&'a [u8]> {
    let declared = declared_bytes(bytes, Some(bytes.len() as u64), log)?;
    // At most the number of bytes that are there.
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
            (0, _) => {
                Err(log
                    .problem(&*place, format!("is of kind {kind:#010x}; the first must be JSON")))
            }
            (1, BIN) => {
                bin = Some(chunk);
                Ok(())
            }
            (_, JSON) => Err(log.problem(&*place, "is a second JSON chunk; there must be one")),
            (_, BIN) if bin.is_some() => {
                Err(log.problem(&*place, "is a second BIN chunk; there may be one"))
            }
            (_, BIN) => Err(log.problem(&*place, "is BIN; that must be the second chunk")),
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

/// Kind and contents of the first chunk, and what follows it.
fn next_chunk<'a>(
    rest: &'a [u8],
    place: &str,
    log: &Log,
) -> Result<(u32, &'a [u8], &'a [u8]), Reported> {
    if rest.len() < CHUNK_HEADER_BYTES {
        return Err(log.problem(
            place,
            format!("ends after {} bytes of its header; that has {CHUNK_HEADER_BYTES}", rest.len()),
        ));
    }
    let (length, kind) = (u32_at(rest, 0) as usize, u32_at(rest, 4));
    let data = &rest[CHUNK_HEADER_BYTES..];
    if length > data.len() {
        return Err(
            log.problem(place, format!("says it has {length} bytes, but {} are left", data.len()))
        );
    }
    if length % 4 != 0 {
        return Err(
            log.problem(place, format!("has {length} bytes; chunks are padded to a multiple of 4"))
        );
    }
    Ok((kind, &data[..length], &data[length..]))
}
