//! What a URI in a file names: data written out in it, or a file beside it (glTF 2.0, section 2.8).

use std::borrow::Cow;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

/// Exporters disagree on whether the last bytes are padded, and nothing depends on it.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// A URI, taken apart.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Uri<'a> {
    /// Data written out in the URI.
    Data(DataUri<'a>),
    /// The path of a file, percent-decoded.
    File(String),
}

/// A `data:` URI, not decoded yet.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct DataUri<'a> {
    pub(crate) media_type: &'a str,
    base64: bool,
    payload: &'a str,
}

impl<'a> Uri<'a> {
    /// Takes a URI apart, or says why it is refused.
    pub(crate) fn parse(text: &'a str) -> Result<Self, String> {
        if let Some(data) = text.strip_prefix("data:") {
            return parse_data(data).map(Self::Data);
        }
        if text.is_empty() {
            return Err("is empty; it must name a file".into());
        }
        if let Some(scheme) = scheme(text) {
            return Err(format!("is a \"{scheme}:\" address; only data: URIs and paths are read"));
        }
        let decoded = percent_decode_str(text).decode_utf8();
        let path = decoded.map_err(|_| "does not percent-decode to UTF-8".to_owned())?;
        if path.contains('\0') || path.starts_with('\\') {
            return Err("does not decode to a path".into());
        }
        Ok(Self::File(path.into_owned()))
    }
}

/// What stands before a colon in the first segment of a path; a drive letter counts, and nothing at
/// all too.
fn scheme(text: &str) -> Option<&str> {
    let (scheme, _) = text.split_once(':')?;
    (!scheme.contains(['/', '\\', '%', '?', '#'])).then_some(scheme)
}

fn parse_data(data: &str) -> Result<DataUri<'_>, String> {
    let (header, payload) =
        data.split_once(',').ok_or("is a data: URI without a comma before its data")?;
    let mut parts = header.split(';');
    let media_type = parts.next().unwrap_or_default();
    let parameters: Vec<_> = parts.collect();
    let (base64, parameters) = match parameters.split_last() {
        Some((&"base64", others)) => (true, others),
        _ => (false, &parameters[..]),
    };
    if parameters.iter().any(|p| !p.contains('=')) {
        return Err("is a data: URI with a parameter that has no value".into());
    }
    Ok(DataUri { media_type, base64, payload })
}

impl DataUri<'_> {
    /// Bytes that decoding takes at most.
    pub(crate) fn decoded_bytes(&self) -> u64 {
        let written = self.payload.len() as u64;
        // The decoder makes room for 3 bytes for every 4 characters, of a copy where some are
        // escaped.
        match (self.base64, self.payload.contains('%')) {
            (false, _) => written,
            (true, false) => written.div_ceil(4) * 3,
            (true, true) => written + written.div_ceil(4) * 3,
        }
    }

    /// The bytes that are written out.
    pub(crate) fn decode(&self) -> Result<Vec<u8>, String> {
        let bytes: Cow<[u8]> = percent_decode_str(self.payload).into();
        if !self.base64 {
            return Ok(bytes.into_owned());
        }
        BASE64.decode(bytes).map_err(|e| format!("is a data: URI of broken base64: {e}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_is_decoded_with_and_without_base64() {
        let decoded = |text| match Uri::parse(text) {
            Ok(Uri::Data(data)) => {
                let bytes = data.decode().ok()?;
                assert!(bytes.len() as u64 <= data.decoded_bytes(), "{text}");
                Some(bytes)
            }
            _ => None,
        };
        let data = |text| decoded(text).unwrap_or_else(|| panic!("{text}"));
        assert_eq!(data("data:application/octet-stream;base64,AQID"), [1, 2, 3]);
        assert_eq!(data("data:;base64,AQ=="), [1]);
        assert_eq!(data("data:;base64,AQ"), [1], "padding may be left out");
        assert_eq!(data("data:;base64,%41QI%44"), [1, 2, 3]);
        assert_eq!(data("data:text/plain;charset=utf-8,a%20b"), b"a b");
        let broken = ["data:", "data:;base64", "data:a;;base64,AA==", "data:;base64,A*=="];
        for text in broken {
            assert_eq!(decoded(text), None, "{text}");
        }
    }

    #[test]
    fn paths_name_files_and_addresses_do_not() {
        let path = |text: &str| match Uri::parse(text) {
            Ok(Uri::File(path)) => Some(path),
            _ => None,
        };
        assert_eq!(path("a%20b/%2541.bin").as_deref(), Some("a b/%41.bin"));
        assert_eq!(path("../textures/a#1.png").as_deref(), Some("../textures/a#1.png"));
        assert_eq!(path("folder/a:b.bin").as_deref(), Some("folder/a:b.bin"));
        assert_eq!(path("%2Fetc/x").as_deref(), Some("/etc/x"));
        let refused =
            ["", ":", "\\\\host\\x", "C:\\x", "http://a/b.bin", "file:///x", "a%00b", "%FF"];
        for text in refused {
            assert_eq!(path(text), None, "{text}");
        }
    }
}
