//! Frames and messages as `PROTOCOL.md` describes them, decoded without any code that is judged. This decoder may
//! accept more than a controller takes, but never less.

/// Content of a frame, as far as the model needs it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Message {
    Hello,
    Sheet,
    Piece,
    /// A piece of a setpoint.
    Nodes,
    Setpoint(Sent),
    /// Number of the command, and the command.
    Command(u8, u32),
    Alive,
    Nothing,
}

/// A setpoint as it was sent.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sent {
    pub(crate) number: u32,
    pub(crate) span: f32,
    pub(crate) nodes: Vec<f32>,
}

/// A frame with the right checksum.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) session: u32,
    /// Sequence number, if the message is an item.
    pub(crate) sequence: u32,
    pub(crate) message: Message,
}

/// Bytes since the last zero.
#[derive(Default)]
pub(crate) struct Stream(Vec<u8>);

impl Stream {
    /// Takes a byte and returns the frame that it ends; `Err` if the bytes are no valid frame. A lone zero is nothing.
    pub(crate) fn push(&mut self, byte: u8) -> Option<Result<Frame, ()>> {
        if byte != 0 {
            self.0.push(byte);
            return None;
        }
        let stuffed = core::mem::take(&mut self.0);
        (!stuffed.is_empty()).then(|| {
            unstuffed(&stuffed)
                .and_then(|bytes| frame(&bytes))
                .ok_or(())
        })
    }
}

fn unstuffed(mut rest: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    while let Some((&code, behind)) = rest.split_first() {
        let (block, more) = behind.split_at_checked(usize::from(code) - 1)?;
        bytes.extend(block);
        if code < 255 && !more.is_empty() {
            bytes.push(0);
        }
        rest = more;
    }
    (bytes.len() <= 256).then_some(bytes)
}

/// Computes the CRC-32 (ISO-HDLC) bit by bit.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
    let mut register = u32::MAX;
    for byte in bytes {
        register ^= u32::from(*byte);
        for _ in 0..8 {
            let low = register & 1;
            register = (register >> 1) ^ (low * 0xedb8_8320);
        }
    }
    !register
}

fn frame(bytes: &[u8]) -> Option<Frame> {
    let (covered, sum) = bytes.split_last_chunk::<4>()?;
    if checksum(covered).to_le_bytes() != *sum {
        return None;
    }
    let ([node, session @ ..], body) = covered.split_first_chunk::<5>()?;
    if *node != 0 {
        return None;
    }
    let (sequence, message) = message(body).unwrap_or((0, Message::Nothing));
    Some(Frame {
        session: u32::from_le_bytes(*session),
        sequence,
        message,
    })
}

fn message(mut body: &[u8]) -> Option<(u32, Message)> {
    let rest = &mut body;
    Some(match varint(rest)? {
        0 => (0, Message::Hello),
        1 => {
            let sequence = varint(rest)?;
            let item = match varint(rest)? {
                0 => Message::Sheet,
                1..=3 => Message::Piece,
                4 => Message::Setpoint(setpoint(rest)?),
                5 => Message::Nodes,
                _ => return None,
            };
            (sequence, item)
        }
        2 => {
            let number = *rest.split_off_first()?;
            (0, Message::Command(number, varint(rest)?))
        }
        3 if rest.is_empty() => (0, Message::Alive),
        // A key, for which this controller has no room.
        4 => (0, Message::Piece),
        _ => return None,
    })
}

fn setpoint(rest: &mut &[u8]) -> Option<Sent> {
    let number = varint(rest)?;
    let (span, behind) = rest.split_first_chunk()?;
    *rest = behind;
    let _last = rest.split_off_first()?;
    let count = varint(rest)?;
    let nodes = rest.get(..usize::try_from(count).ok()?)?;
    let (nodes, _) = nodes.as_chunks();
    Some(Sent {
        number,
        span: f32::from_le_bytes(*span),
        nodes: nodes.iter().copied().map(f32::from_le_bytes).collect(),
    })
}

fn varint(rest: &mut &[u8]) -> Option<u32> {
    let mut value = 0;
    for place in 0..5 {
        let byte = *rest.split_off_first()?;
        value |= u32::from(byte & 127) << (7 * place);
        if byte < 128 {
            return Some(value);
        }
    }
    None
}
