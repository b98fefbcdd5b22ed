//! URIs of buffers and images: embedded data, or the path of another file (glTF 2.0, section 2.8).

use std::borrow::Cow;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

/// Base64 with optional padding: some exporters omit it.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// A parsed URI.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Uri<'a> {
    /// Data embedded in the URI.
    Data(DataUri<'a>),
    /// Percent-decoded path of a file.
    File(String),
}

/// A `data:` URI whose payload is not decoded yet.
///
/// The crate `data-url` is not used, because it hides the payload: the memory budget needs the
/// decoded size before the allocation. It also accepts malformed parameters and ends the data at a
/// `#` without an error, and its errors do not say where the base64 is invalid.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct DataUri<'a> {
    pub(crate) media_type: &'a str,
    base64: bool,
    payload: &'a str,
}

impl<'a> Uri<'a> {
    /// Parses a URI. The error completes a message that begins with the location.
    pub(crate) fn parse(text: &'a str) -> Result<Self, String> {
        if let Some(data) = text.strip_prefix("data:") {
            return parse_data(data).map(Self::Data);
        }
        if text.is_empty() {
            return Err("is empty; it must be a path or a data: URI".into());
        }
        if let Some(scheme) = scheme(text) {
            return Err(format!(
                "is a \"{scheme}:\" URI; only data: URIs and relative paths are supported, so save \
                 the file locally and refer to it by path"
            ));
        }
        let decoded = percent_decode_str(text).decode_utf8();
        let path = decoded.map_err(|_| "is not valid UTF-8 after percent-decoding".to_owned())?;
        if path.contains('\0') || path.starts_with('\\') {
            return Err("is not a valid path after percent-decoding".into());
        }
        Ok(Self::File(path.into_owned()))
    }
}

/// Returns the text before a colon in the first path segment. It may be a drive letter, or empty.
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
        return Err("is a data: URI with a parameter that is not `name=value`".into());
    }
    Ok(DataUri { media_type, base64, payload })
}

impl DataUri<'_> {
    /// Returns an upper bound of the memory that [`Self::decode`] allocates, in bytes.
    pub(crate) fn decoded_bytes(&self) -> u64 {
        let written = self.payload.len() as u64;
        // Base64 decoding allocates 3 bytes for every 4 characters, and a copy of the payload if
        // some characters are percent-encoded.
        match (self.base64, self.payload.contains('%')) {
            (false, _) => written,
            (true, false) => written.div_ceil(4) * 3,
            (true, true) => written + written.div_ceil(4) * 3,
        }
    }

    /// Decodes the payload.
    pub(crate) fn decode(&self) -> Result<Vec<u8>, String> {
        let bytes: Cow<[u8]> = percent_decode_str(self.payload).into();
        if !self.base64 {
            return Ok(bytes.into_owned());
        }
        BASE64.decode(bytes).map_err(|e| format!("is a data: URI with invalid base64: {e}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris_decode_with_and_without_base64() {
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
        assert_eq!(data("data:;base64,AQ"), [1], "padding is optional");
        assert_eq!(data("data:;base64,%41QI%44"), [1, 2, 3]);
        assert_eq!(data("data:text/plain;charset=utf-8,a%20b"), b"a b");
        let broken = ["data:", "data:;base64", "data:a;;base64,AA==", "data:;base64,A*=="];
        for text in broken {
            assert_eq!(decoded(text), None, "{text}");
        }
    }

    #[test]
    fn relative_paths_parse_and_other_schemes_are_refused() {
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
