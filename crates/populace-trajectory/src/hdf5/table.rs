//! Tables of HDF5: datasets of compound elements, whose members have names.

use rust_hdf5::{ByteOrder, DatatypeMessage, H5Dataset};

/// Largest size of a compressed table, as a multiple of its file's. Positions never compress as well,
/// but damaged sizes can be larger than any memory.
const LARGEST_RATIO: u64 = 100;
/// Size in bytes up to which tables are read from any file.
const SMALL_BYTES: u64 = 16 << 20;
/// Size in bytes that parts of a compressed table may have, even if the table is smaller.
const SMALL_PART_BYTES: u64 = 4 << 20;

/// Returns the reason if a dataset needs other files, or far more memory than the `file_bytes` of its
/// file.
pub(super) fn check_size(dataset: &H5Dataset, file_bytes: u64) -> Result<(), String> {
    if dataset.virtual_mappings().is_ok_and(|mappings| !mappings.is_empty())
        || dataset.external_files().is_ok_and(|files| !files.is_empty())
    {
        return Err("its rows are in other files".to_owned());
    }
    let bytes = |counts: &[usize]| {
        let count = counts.iter().try_fold(1_usize, |all, count| all.checked_mul(*count))?;
        Some(count.checked_mul(dataset.element_size())? as u64)
    };
    let largest = file_bytes.saturating_mul(LARGEST_RATIO).max(SMALL_BYTES);
    let total = bytes(&dataset.shape()).filter(|total| *total <= largest);
    let part = dataset.chunk_dims().map_or(Some(0), |counts| bytes(&counts));
    match (total, part) {
        (Some(total), Some(part)) if part <= total.max(SMALL_PART_BYTES) => Ok(()),
        _ => Err("its size is far beyond that of the file".to_owned()),
    }
}

/// A table in memory.
pub(crate) struct Table {
    bytes: Vec<u8>,
    row_bytes: usize,
    members: Vec<Member>,
}

struct Member {
    name: String,
    offset: usize,
    kind: Kind,
}

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Integer { bytes: usize, order: ByteOrder, signed: bool },
    Single(ByteOrder),
    Double(ByteOrder),
}

impl Table {
    /// Reads a dataset, or returns the reason why it cannot be read.
    pub(crate) fn read(dataset: &H5Dataset) -> Result<Self, String> {
        let datatype = dataset.datatype().map_err(|error| error.to_string())?;
        let DatatypeMessage::Compound { size, members } = datatype else {
            return Err(format!("it is no table with named members, but {datatype}"));
        };
        let row_bytes = size as usize;
        if row_bytes == 0 {
            return Err("its rows are empty".to_owned());
        }
        let members = members
            .into_iter()
            .filter_map(|member| {
                let (offset, kind) = (member.offset as usize, kind(&member.datatype)?);
                let fits = offset.checked_add(kind.bytes())? <= row_bytes;
                fits.then_some(Member { name: member.name, offset, kind })
            })
            .collect();
        let bytes = dataset.read_raw_bytes().map_err(|error| error.to_string())?;
        Ok(Self { bytes, row_bytes, members })
    }

    /// The number of rows.
    pub(crate) fn len(&self) -> usize {
        self.bytes.len() / self.row_bytes
    }

    /// The names of the members that hold numbers, in the order of the file.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.members.iter().map(|member| &*member.name)
    }

    /// Returns the index of the member with a name, in capitals or not.
    pub(crate) fn member(&self, name: &str) -> Option<usize> {
        self.members.iter().position(|member| member.name.eq_ignore_ascii_case(name))
    }

    fn value(&self, row: usize, member: usize) -> Option<(Kind, &[u8])> {
        let Member { offset, kind, .. } = self.members.get(member)?;
        let from = row.checked_mul(self.row_bytes)?.checked_add(*offset)?;
        Some((*kind, self.bytes.get(from..from.checked_add(kind.bytes())?)?))
    }

    /// Returns a number; NaN beyond the table.
    #[expect(clippy::cast_precision_loss, reason = "frames and markers are far below 2^53")]
    pub(crate) fn number(&self, row: usize, member: usize) -> f64 {
        match self.value(row, member) {
            Some((Kind::Single(order), bytes)) => {
                f64::from(f32::from_bits(u32::try_from(bits(bytes, order)).unwrap_or_default()))
            }
            Some((Kind::Double(order), bytes)) => f64::from_bits(bits(bytes, order)),
            Some((kind @ Kind::Integer { .. }, bytes)) => integer(kind, bytes) as f64,
            None => f64::NAN,
        }
    }

    /// Returns a whole number; nothing if it has a fraction or is none.
    pub(crate) fn integer(&self, row: usize, member: usize) -> Option<i64> {
        if let (kind @ Kind::Integer { .. }, bytes) = self.value(row, member)? {
            return Some(integer(kind, bytes));
        }
        let number = self.number(row, member);
        let is_whole = number.fract() == 0.0 && number.abs() < 1e15;
        #[expect(clippy::cast_possible_truncation, reason = "it is whole and below 2^53")]
        is_whole.then_some(number as i64)
    }
}

impl Kind {
    fn bytes(self) -> usize {
        match self {
            Self::Integer { bytes, .. } => bytes,
            Self::Single(_) => 4,
            Self::Double(_) => 8,
        }
    }
}

/// Returns how a number is stored; nothing for text, lists and odd numbers.
fn kind(datatype: &DatatypeMessage) -> Option<Kind> {
    match datatype {
        DatatypeMessage::FixedPoint { size, byte_order, signed, bit_offset, bit_precision } => {
            let bytes = *size as usize;
            let is_plain = (1..=8).contains(&bytes)
                && *bit_offset == 0
                && usize::from(*bit_precision) == bytes * 8;
            is_plain.then_some(Kind::Integer { bytes, order: *byte_order, signed: *signed })
        }
        DatatypeMessage::FloatingPoint { size: 4, byte_order, exponent_size: 8, .. } => {
            Some(Kind::Single(*byte_order))
        }
        DatatypeMessage::FloatingPoint { size: 8, byte_order, exponent_size: 11, .. } => {
            Some(Kind::Double(*byte_order))
        }
        DatatypeMessage::Enum { base, .. } => kind(base),
        _ => None,
    }
}

fn bits(bytes: &[u8], order: ByteOrder) -> u64 {
    let join = |all: u64, byte: &u8| all << 8 | u64::from(*byte);
    match order {
        ByteOrder::LittleEndian => bytes.iter().rev().fold(0, join),
        ByteOrder::BigEndian => bytes.iter().fold(0, join),
    }
}

fn integer(kind: Kind, bytes: &[u8]) -> i64 {
    let Kind::Integer { order, signed, .. } = kind else { return 0 };
    let bits = bits(bytes, order);
    let unused = 64_u32.saturating_sub(8 * u32::try_from(bytes.len()).unwrap_or(8));
    if signed { (bits << unused).cast_signed() >> unused } else { bits.cast_signed() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_of_all_widths_and_orders_are_decoded() {
        let of = |bytes: usize, order, signed| Kind::Integer { bytes, order, signed };
        let little = ByteOrder::LittleEndian;
        assert_eq!(integer(of(2, little, true), &[0xfe, 0xff]), -2);
        assert_eq!(integer(of(2, little, false), &[0xfe, 0xff]), 65534);
        assert_eq!(integer(of(3, ByteOrder::BigEndian, true), &[0xff, 0xff, 0xf0]), -16);
        assert_eq!(integer(of(8, little, true), &(-7_i64).to_le_bytes()), -7);
    }
}
