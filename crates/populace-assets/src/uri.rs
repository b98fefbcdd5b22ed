//! What a URI in a file names: data written out in it, or a file beside it (glTF 2.0, section 2.8).

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use serde_json::Value;

/// Exporters disagree on whether the last bytes are padded, and nothing depends on it.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// A URI, taken apart.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Uri {
    /// A `data:` URI's media type and bytes.
    Data { media_type: String, bytes: Vec<u8> },
    /// A path relative to the file, percent-decoded.
    Relative(String),
}

impl Uri {
    /// Takes a URI apart, or says why it is refused.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        if let Some(data) = text.strip_prefix("data:") {
            return parse_data(data);
        }
        if text.is_empty() {
            return Err("is empty; it must name a file".into());
        }
        if let Some(scheme) = scheme(text) {
            return Err(format!("is a \"{scheme}:\" address; only data: URIs and relative paths are read"));
        }
        if text.starts_with(['/', '\\']) {
            return Err("is an absolute path; only data: URIs and relative paths are read".into());
        }
        let decoded = percent_decode_str(text).decode_utf8();
        let path = decoded.map_err(|_| "does not percent-decode to UTF-8".to_owned())?;
        if path.contains('\0') || path.starts_with(['/', '\\']) {
            return Err("does not decode to a relative path".into());
        }
        Ok(Self::Relative(path.into_owned()))
    }
}

/// The files that buffers and images name, below `base_folder`, in the file's order.
pub(crate) fn named_files(document: &Value, base_folder: Option<&Path>) -> Vec<PathBuf> {
    let holders = ["buffers", "images"].map(|key| document[key].as_array());
    let uris = holders.into_iter().flatten().flatten().filter_map(|holder| holder["uri"].as_str());
    let uris = uris.filter(|uri| !uri.starts_with("data:"));
    let path = |uri: &str| match Uri::parse(uri) {
        Ok(Uri::Relative(path)) => base_folder.map(|base| base.join(path)),
        _ => None,
    };
    uris.filter_map(path).collect()
}

/// What stands before a colon in the first segment of a path; a drive letter counts, and nothing at all too.
fn scheme(text: &str) -> Option<&str> {
    let (scheme, _) = text.split_once(':')?;
    (!scheme.contains(['/', '\\', '%', '?', '#'])).then_some(scheme)
}

fn parse_data(data: &str) -> Result<Uri, String> {
    let (header, payload) = data.split_once(',').ok_or("is a data: URI without a comma before its data")?;
    let mut parts = header.split(';');
    let media_type = parts.next().unwrap_or_default().to_owned();
    let parameters: Vec<_> = parts.collect();
    let (base64, parameters) = match parameters.split_last() {
        Some((&"base64", others)) => (true, others),
        _ => (false, &parameters[..]),
    };
    if parameters.iter().any(|p| !p.contains('=')) {
        return Err("is a data: URI with a parameter that has no value".into());
    }
    let bytes: Vec<u8> = percent_decode_str(payload).collect();
    let bytes = if base64 {
        BASE64.decode(bytes).map_err(|e| format!("is a data: URI of broken base64: {e}"))?
    } else {
        bytes
    };
    Ok(Uri::Data { media_type, bytes })
}

/// Reads a file beside the one being imported: the first `wanted` bytes, which must be there, or all up to `limit`.
///
/// Only regular files are read, since devices and pipes may never end.
pub(crate) fn read_file(
    base_folder: Option<&Path>,
    path: &str,
    wanted: Option<usize>,
    limit: u64,
) -> Result<Vec<u8>, String> {
    let base = base_folder.ok_or_else(|| {
        format!("names the file \"{path}\", but files beside this one are not looked at here")
    })?;
    let failed = |e: std::io::Error| format!("names \"{path}\", which cannot be read: {e}");
    let path_on_disk = base.join(path);
    let metadata = std::fs::metadata(&path_on_disk).map_err(failed)?;
    if !metadata.is_file() {
        return Err(format!("names \"{path}\", which is no regular file"));
    }
    if let Some(wanted) = wanted.filter(|w| (*w as u64) > metadata.len()) {
        return Err(format!(
            "names \"{path}\", which has {} bytes where {wanted} are declared; it may be cut off",
            metadata.len()
        ));
    }
    let length = wanted.map_or(metadata.len(), |w| w as u64);
    if length > limit {
        return Err(format!("names \"{path}\", which has {length} bytes; at most {limit} are read"));
    }
    let mut bytes = Vec::new();
    let file = File::open(&path_on_disk).map_err(failed)?;
    file.take(length).read_to_end(&mut bytes).map_err(failed)?;
    if wanted.is_some_and(|w| bytes.len() < w) {
        return Err(format!("names \"{path}\", which ended while it was read"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_is_decoded_with_and_without_base64() {
        let data = |text| match Uri::parse(text) {
            Ok(Uri::Data { bytes, .. }) => bytes,
            other => panic!("{other:?}"),
        };
        assert_eq!(data("data:application/octet-stream;base64,AQID"), [1, 2, 3]);
        assert_eq!(data("data:;base64,AQ=="), [1]);
        assert_eq!(data("data:;base64,AQ"), [1], "padding may be left out");
        assert_eq!(data("data:text/plain;charset=utf-8,a%20b"), b"a b");
        let broken = ["data:", "data:;base64", "data:a;;base64,AA==", "data:;base64,A*=="];
        for text in broken {
            assert!(Uri::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn only_relative_paths_name_files() {
        let path = |text: &str| match Uri::parse(text) {
            Ok(Uri::Relative(path)) => Some(path),
            _ => None,
        };
        assert_eq!(path("a%20b/%2541.bin").as_deref(), Some("a b/%41.bin"));
        assert_eq!(path("../textures/a#1.png").as_deref(), Some("../textures/a#1.png"));
        assert_eq!(path("folder/a:b.bin").as_deref(), Some("folder/a:b.bin"));
        let refused = [
            "",
            ":",
            "/etc/x",
            "%2Fetc/x",
            "\\\\host\\x",
            "C:\\x",
            "http://a/b.bin",
            "file:///x",
            "a%00b",
            "%FF",
        ];
        for text in refused {
            assert_eq!(path(text), None, "{text}");
        }
    }
}
