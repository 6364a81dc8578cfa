//! Numbers in messages: the encoding that serde's derived code would give them, from functions that are not inlined. An
//! image would otherwise have that code once for each field.

use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The number of a variant of an enum and the numbers that the variant holds, in the order in which they are encoded.
#[derive(Clone, Copy)]
pub(crate) struct Numbers {
    numbers: [u32; 3],
    count: usize,
}

impl Numbers {
    /// The variant of this number, which holds nothing.
    pub(crate) fn variant(number: u32) -> Self {
        Self {
            numbers: [number, 0, 0],
            count: 1,
        }
    }

    /// The variant of this number, which holds one number.
    pub(crate) fn of(variant: u32, number: impl Into<u32>) -> Self {
        Self {
            numbers: [variant, number.into(), 0],
            count: 2,
        }
    }

    /// The variant of this number, which holds a variant of another enum with at most one number.
    pub(crate) fn around(variant: u32, held: impl Into<Self>) -> Self {
        let held = held.into();
        let [first, second, _] = held.numbers;
        Self {
            numbers: [variant, first, second],
            count: held.count + 1,
        }
    }
}

impl Serialize for Numbers {
    #[inline(never)]
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.count)?;
        for number in self.numbers.iter().take(self.count) {
            tuple.serialize_element(number)?;
        }
        tuple.end()
    }
}

/// Encodes numbers of up to 64 bits, which all have the same encoding.
#[inline(never)]
fn encode<S: Serializer>(number: u64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u64(number)
}

/// Numbers of 16 to 64 bits, for serde's attribute `with`.
pub(crate) mod number {
    use super::{Deserialize, Deserializer, Serializer, encode};

    pub(crate) fn serialize<S: Serializer>(
        number: &(impl Copy + Into<u64>),
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        encode((*number).into(), serializer)
    }

    #[inline(never)]
    pub(crate) fn deserialize<'b, N: Deserialize<'b>, D: Deserializer<'b>>(
        bytes: D,
    ) -> Result<N, D::Error> {
        N::deserialize(bytes)
    }
}
