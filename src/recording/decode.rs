//! From the bytes of a file to UTF-8: gzip, UTF-16, Windows-1252.

use std::io::Read as _;

use encoding_rs::{UTF_16BE, UTF_16LE, WINDOWS_1252};
use flate2::read::MultiGzDecoder;

use crate::error::{Error, ErrorKind, Result};

const GZIP: &[u8] = &[0x1F, 0x8B];
/// Larger text would not fit in memory beside its numbers.
pub(super) const MOST_BYTES: u64 = 4 << 30;
/// Bytes that are looked at where no mark tells the encoding.
const LOOKED_AT: usize = 4096;

/// The content of a file, unpacked where gzip packed it.
///
/// # Errors
/// A gzip file that is cut off or damaged, or that unpacks to more than 4 GiB.
pub(super) fn unpacked(bytes: Vec<u8>) -> Result<Vec<u8>> {
    if !bytes.starts_with(GZIP) {
        return Ok(bytes);
    }
    let refuse = |found: String| {
        Error::new(ErrorKind::Syntax)
            .found(found)
            .expected("a whole gzip file of at most 4 GiB of text")
            .remedy("pack the file again, or unpack it and name the unpacked one")
    };
    let mut text = Vec::new();
    let mut decoder = MultiGzDecoder::new(&bytes[..]).take(MOST_BYTES + 1);
    decoder.read_to_end(&mut text).map_err(|error| refuse(format!("damaged gzip data ({error})")))?;
    if text.len() as u64 > MOST_BYTES {
        return Err(refuse("gzip data of more than 4 GiB".to_owned()));
    }
    Ok(text)
}

/// Text as UTF-8, and the name of the encoding where it was another one.
pub(super) fn utf8(bytes: Vec<u8>) -> (Vec<u8>, Option<&'static str>) {
    let head = &bytes[..bytes.len().min(LOOKED_AT)];
    let zeros = |first: usize| head.iter().skip(first).step_by(2).filter(|byte| **byte == 0).count();
    // Numbers and Latin letters have a zero in every second byte.
    let most = head.len() / 2 - head.len() / 8;
    let encoding = match bytes.get(..2) {
        Some([0xFF, 0xFE]) => UTF_16LE,
        Some([0xFE, 0xFF]) => UTF_16BE,
        _ if head.len() >= 8 && zeros(1) > most => UTF_16LE,
        _ if head.len() >= 8 && zeros(0) > most => UTF_16BE,
        _ if std::str::from_utf8(&bytes).is_err() => WINDOWS_1252,
        _ => return (bytes, None),
    };
    let (text, used, _) = encoding.decode(&bytes);
    (text.into_owned().into_bytes(), Some(used.name()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    #[test]
    fn exact_encodings_of_one_text_read_alike() {
        let text = "t;µm\n1;2\n";
        let wide = |little: bool, mark: &[u8]| -> Vec<u8> {
            let units =
                text.encode_utf16().flat_map(|u| if little { u.to_le_bytes() } else { u.to_be_bytes() });
            mark.iter().copied().chain(units).collect()
        };
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        for (bytes, name) in [
            (wide(true, &[0xFF, 0xFE]), Some("UTF-16LE")),
            (wide(false, &[0xFE, 0xFF]), Some("UTF-16BE")),
            (wide(true, &[]), Some("UTF-16LE")),
            (wide(false, &[]), Some("UTF-16BE")),
            (latin, Some("windows-1252")),
            (text.as_bytes().to_vec(), None),
        ] {
            assert_eq!(utf8(bytes), (text.as_bytes().to_vec(), name));
        }
    }

    #[test]
    fn exact_gzip_is_unpacked_and_a_damaged_one_is_refused() {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packer.write_all(b"a,b\n1,2\n").unwrap();
        let packed = packer.finish().unwrap();
        assert_eq!(unpacked(packed.clone()).unwrap(), b"a,b\n1,2\n");
        assert_eq!(unpacked(b"a,b".to_vec()).unwrap(), b"a,b");
        let error = unpacked(packed[..packed.len() - 6].to_vec()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Syntax);
    }
}
