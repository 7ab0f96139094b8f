//! The two ROS 2 messages that carry an axis, in CDR: `sensor_msgs/msg/JointState` and `std_msgs/msg/Float64`.

/// Name and text of the schema, as ROS 2 has them.
pub(super) const JOINT_STATE: (&str, &str) = (
    "sensor_msgs/msg/JointState",
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
     ================================================================================\nMSG: std_msgs/Header\n\
     builtin_interfaces/Time stamp\nstring frame_id\n\
     ================================================================================\nMSG: builtin_interfaces/Time\n\
     int32 sec\nuint32 nanosec\n",
);
/// The same of a single number.
pub(super) const FLOAT64: (&str, &str) = ("std_msgs/msg/Float64", "float64 data\n");
/// Header of the encoding: little-endian.
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];
const NS_PER_S: u64 = 1_000_000_000;

/// Joints at one moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct JointState {
    pub(super) stamp_ns: i64,
    pub(super) name: Vec<String>,
    pub(super) position: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) effort: Vec<f64>,
}

impl JointState {
    /// Reads a message; none where it is cut off or does not follow the encoding.
    pub(super) fn decoded(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data)?;
        let seconds = i64::from(i32::from_ne_bytes(reader.word()?));
        let nanoseconds = i64::from(u32::from_ne_bytes(reader.word()?));
        reader.text()?;
        let count = reader.count()?;
        let name = (0..count).map(|_| reader.text()).collect::<Option<_>>()?;
        Some(Self {
            stamp_ns: seconds.checked_mul(NS_PER_S as i64)?.checked_add(nanoseconds)?,
            name,
            position: reader.numbers()?,
            velocity: reader.numbers()?,
            effort: reader.numbers()?,
        })
    }

    /// Writes a message.
    pub(super) fn encoded(&self) -> Vec<u8> {
        let mut out = Writer::new();
        out.word((self.stamp_ns.div_euclid(NS_PER_S as i64) as i32).to_le_bytes());
        out.word((self.stamp_ns.rem_euclid(NS_PER_S as i64) as u32).to_le_bytes());
        out.text("");
        out.word((self.name.len() as u32).to_le_bytes());
        self.name.iter().for_each(|name| out.text(name));
        [&self.position, &self.velocity, &self.effort].into_iter().for_each(|values| out.numbers(values));
        out.bytes
    }
}

/// Reads a single number.
pub(super) fn float64(data: &[u8]) -> Option<f64> {
    Reader::new(data)?.number()
}

/// Writes a single number.
pub(super) fn encoded_float64(value: f64) -> Vec<u8> {
    let mut out = Writer::new();
    out.number(value);
    out.bytes
}

/// Bytes behind the header; alignment counts from there.
struct Reader<'a> {
    body: &'a [u8],
    at: usize,
    little: bool,
}

impl<'a> Reader<'a> {
    fn new(data: &'a [u8]) -> Option<Self> {
        let (header, body) = data.split_first_chunk::<4>()?;
        (header[0] == 0 && header[1] < 2).then_some(Self { body, at: 0, little: header[1] == 1 })
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let at = self.at.next_multiple_of(N);
        let mut bytes: [u8; N] = self.body.get(at..at.checked_add(N)?)?.try_into().ok()?;
        self.at = at + N;
        if self.little != cfg!(target_endian = "little") {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn word(&mut self) -> Option<[u8; 4]> {
        self.take()
    }

    fn number(&mut self) -> Option<f64> {
        self.take().map(f64::from_ne_bytes)
    }

    /// A length that the rest of the message can hold.
    fn count(&mut self) -> Option<usize> {
        let count = u32::from_ne_bytes(self.word()?) as usize;
        (count <= self.body.len()).then_some(count)
    }

    fn text(&mut self) -> Option<String> {
        let count = self.count()?;
        let bytes = self.body.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Some(String::from_utf8_lossy(bytes).into_owned())
    }

    fn numbers(&mut self) -> Option<Vec<f64>> {
        let count = self.count()?;
        (0..count).map(|_| self.number()).collect()
    }
}

struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn new() -> Self {
        Self { bytes: LITTLE_ENDIAN.to_vec() }
    }

    fn align(&mut self, to: usize) {
        let body = self.bytes.len() - LITTLE_ENDIAN.len();
        self.bytes.resize(LITTLE_ENDIAN.len() + body.next_multiple_of(to), 0);
    }

    fn word(&mut self, bytes: [u8; 4]) {
        self.align(4);
        self.bytes.extend(bytes);
    }

    fn number(&mut self, value: f64) {
        self.align(8);
        self.bytes.extend(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.word((text.len() as u32 + 1).to_le_bytes());
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    fn numbers(&mut self, values: &[f64]) {
        self.word((values.len() as u32).to_le_bytes());
        values.iter().for_each(|value| self.number(*value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_messages_read_back() {
        for position in [vec![], vec![0.25, -3.5]] {
            let state = JointState {
                stamp_ns: 1_700_000_000_250_000_000,
                name: vec!["slide".to_owned(), "x".to_owned()],
                position,
                velocity: vec![1.0, 2.0],
                effort: vec![],
            };
            assert_eq!(JointState::decoded(&state.encoded()), Some(state.clone()));
            let bytes = state.encoded();
            assert!((0..bytes.len()).all(|end| JointState::decoded(&bytes[..end]).is_none()));
        }
        assert_eq!(float64(&encoded_float64(-0.125)), Some(-0.125));
    }

    #[test]
    fn exact_bytes_of_a_small_message_are_as_the_encoding_has_them() {
        // 1 s 2 ns, no frame, the joint `ab`, position 1.0: lengths count the zero behind a text, numbers stand at multiples of 8.
        let state = JointState {
            stamp_ns: 1_000_000_002,
            name: vec!["ab".to_owned()],
            position: vec![1.0],
            ..JointState::default()
        };
        let expected: Vec<u8> = [
            &[0, 1, 0, 0][..],
            &[1, 0, 0, 0, 2, 0, 0, 0],
            &[1, 0, 0, 0, 0, 0, 0, 0],
            &[1, 0, 0, 0, 3, 0, 0, 0],
            b"ab\0\0",
            &[1, 0, 0, 0],
            &1.0_f64.to_le_bytes(),
            &[0, 0, 0, 0, 0, 0, 0, 0],
        ]
        .concat();
        assert_eq!(state.encoded(), expected);
    }
}
