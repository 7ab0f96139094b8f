//! Records of an MCAP file. Their lengths stand in the file: no more is taken than the record holds, whatever they say.
//!
//! # Source
//! MCAP file format specification, records 0x03 (schema), 0x04 (channel) and 0x05 (message).

use std::collections::BTreeMap;

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Limit of one record's length where the file is smaller: a chunk unpacks to more than the file has, and recorders keep chunks far
/// below this.
const RECORD_LIMIT: usize = 64 << 20;

/// A message with what its channel says of it.
#[derive(Debug)]
pub(super) struct Message<'a> {
    pub(super) topic: &'a str,
    /// Name of the schema; empty where there is none.
    pub(super) schema: &'a str,
    /// Encoding of the data.
    pub(super) encoding: &'a str,
    pub(super) log_ns: u64,
    pub(super) data: &'a [u8],
}

struct Channel {
    schema: u16,
    topic: String,
    encoding: String,
}

/// Hands every message of a file to `each`; checksums of chunks are compared.
///
/// # Errors
/// In words: a file that is damaged or cut off, a message of an unknown channel; and what `each` refuses.
pub(super) fn messages<E: From<String>>(
    bytes: &[u8],
    mut each: impl FnMut(Message) -> Result<(), E>,
) -> Result<(), E> {
    let options = LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(bytes.len().max(RECORD_LIMIT));
    let mut reader = LinearReader::new_with_options(options);
    let mut rest = bytes;
    let mut schemas: BTreeMap<u16, String> = BTreeMap::new();
    let mut channels: BTreeMap<u16, Channel> = BTreeMap::new();
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| error.to_string())? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (part, later) = rest.split_at(wanted.min(rest.len()));
                reader.insert(part.len())[..part.len()].copy_from_slice(part);
                reader.notify_read(part.len());
                rest = later;
            }
            LinearReadEvent::Record { opcode: op::SCHEMA, data } => {
                let mut fields = Fields(data);
                let schema = fields.short().zip(fields.text());
                schemas.extend([schema.ok_or_else(|| cut_off("schema"))?]);
            }
            LinearReadEvent::Record { opcode: op::CHANNEL, data } => {
                let (id, channel) = channel(data).ok_or_else(|| cut_off("channel"))?;
                channels.insert(id, channel);
            }
            LinearReadEvent::Record { opcode: op::MESSAGE, data } => {
                let mut fields = Fields(data);
                let head = fields.short().zip(fields.skip(4)).zip(fields.long()).zip(fields.skip(8));
                let (((id, ()), log_ns), ()) = head.ok_or_else(|| cut_off("message"))?;
                let channel =
                    channels.get(&id).ok_or_else(|| format!("a message of an unknown channel {id}"))?;
                each(Message {
                    topic: &channel.topic,
                    schema: schemas.get(&channel.schema).map_or("", String::as_str),
                    encoding: &channel.encoding,
                    log_ns,
                    data: fields.0,
                })?;
            }
            LinearReadEvent::Record { .. } => {}
        }
    }
    Ok(())
}

fn channel(data: &[u8]) -> Option<(u16, Channel)> {
    let mut fields = Fields(data);
    let id = fields.short()?;
    Some((id, Channel { schema: fields.short()?, topic: fields.text()?, encoding: fields.text()? }))
}

fn cut_off(record: &str) -> String {
    format!("a {record} record shorter than its fields")
}

/// The fields of a record that are not read yet, little-endian.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn skip(&mut self, count: usize) -> Option<()> {
        self.take(count).map(|_| ())
    }

    fn short(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.take(2)?.try_into().ok()?))
    }

    fn long(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    /// A length in 32 bits, then that many bytes of UTF-8.
    fn text(&mut self) -> Option<String> {
        let length = u32::from_le_bytes(self.take(4)?.try_into().ok()?);
        let bytes = self.take(usize::try_from(length).ok()?)?;
        String::from_utf8(bytes.to_vec()).ok()
    }
}

#[cfg(test)]
mod tests {
    /// Strings of which the file says more than it holds are refused, and nothing is made room for.
    #[test]
    fn exact_no_length_is_believed() {
        let mut channel = vec![1, 0, 0, 0];
        channel.extend(u32::MAX.to_le_bytes());
        channel.extend(b"/topic");
        assert!(super::channel(&channel).is_none());
        let mut sound = vec![1, 0, 2, 0];
        for text in ["/topic", "cdr"] {
            sound.extend((text.len() as u32).to_le_bytes());
            sound.extend(text.as_bytes());
        }
        let (id, read) = super::channel(&sound).unwrap();
        assert_eq!((id, read.schema, &*read.topic, &*read.encoding), (1, 2, "/topic", "cdr"));
        assert!((0..sound.len()).all(|end| super::channel(&sound[..end]).is_none()));
    }
}
