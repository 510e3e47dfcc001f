//! Points as rows of numbers of one type, whose columns have no names: `.bin` and `.npy`.

use std::borrow::Cow;

use super::packed_points::{ByteOrder, NumberType, PackedField, PackedPoints};

/// An array with a point in each row.
#[derive(Debug, Clone, PartialEq)]
pub struct PointArray<'a> {
    /// Number of rows.
    pub n_points: usize,
    /// Number of values in each row.
    pub n_columns: usize,
    /// Type of the values.
    pub number: NumberType,
    /// The byte order of all values.
    pub byte_order: ByteOrder,
    /// The bytes of all values, row by row.
    pub data: Cow<'a, [u8]>,
}

impl<'a> PointArray<'a> {
    /// The points of a `.bin` with this many columns: little-endian f32 and nothing else.
    pub fn of_bin(bytes: &'a [u8], n_columns: usize) -> Self {
        let number = NumberType::F32;
        Self {
            n_points: bytes.len() / (number.n_bytes() * n_columns),
            n_columns,
            number,
            byte_order: ByteOrder::Little,
            data: bytes.into(),
        }
    }

    /// The points as packed points with these fields.
    pub fn packed(&self, fields: Vec<PackedField>) -> PackedPoints<'_> {
        let point_step = self.n_columns * self.number.n_bytes();
        PackedPoints::in_a_row(fields, self.n_points, point_step, self.byte_order, &self.data)
    }

    /// At most `n` of the points, evenly spread: their numbers column by column. Errors are the rest of a sentence about the
    /// file.
    pub fn sampled(&self, n: usize) -> Result<Vec<Vec<f64>>, String> {
        let n_row_bytes = self.n_columns * self.number.n_bytes();
        let n_held = self.data.len().checked_div(n_row_bytes).unwrap_or(0).min(self.n_points);
        let n_taken = n_held.min(n);
        let rows = (0..n_taken).map(|it| it * n_held / n_taken);
        let data: Vec<u8> =
            rows.flat_map(|row| &self.data[row * n_row_bytes..(row + 1) * n_row_bytes]).copied().collect();
        let taken = Self { n_points: n_taken, data: data.into(), ..self.clone_without_data() };
        let field = |column: usize| PackedField {
            name: column.to_string(),
            offset: column * self.number.n_bytes(),
            number: self.number,
        };
        let packed = taken.packed((0..self.n_columns).map(field).collect());
        let numbers = |column: usize| Ok(packed.column(&column.to_string())?.unwrap_or_default());
        (0..self.n_columns).map(numbers).collect()
    }

    fn clone_without_data(&self) -> Self {
        let Self { n_points, n_columns, number, byte_order, .. } = *self;
        Self { n_points, n_columns, number, byte_order, data: Cow::Borrowed(&[]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_has_rows_from_all_of_the_array() {
        let bytes: Vec<u8> = (0..40).flat_map(|it| (it as f32).to_le_bytes()).collect();
        let array = PointArray::of_bin(&bytes, 4);
        assert_eq!(array.n_points, 10);
        assert_eq!(
            array.sampled(5).unwrap(),
            [0.0, 1.0, 2.0, 3.0].map(|column| [0.0, 8.0, 16.0, 24.0, 32.0].map(|it| column + it).to_vec())
        );
        assert_eq!(array.sampled(99).unwrap()[3].len(), 10);
        let cut_off = PointArray { n_points: usize::MAX, ..PointArray::of_bin(&bytes[..40], 4) };
        assert_eq!(
            cut_off.sampled(99).unwrap(),
            [vec![0.0, 4.0], vec![1.0, 5.0], vec![2.0, 6.0], vec![3.0, 7.0]]
        );
        assert_eq!(PointArray::of_bin(&[], 4).sampled(9).unwrap(), vec![Vec::<f64>::new(); 4]);
    }
}
