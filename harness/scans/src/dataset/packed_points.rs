//! Points as rows of bytes whose fields are described beside them, as in ROS, Foxglove and PCD.

use super::positioned_points::PositionedPoints;

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberType {
    /// One byte with a sign.
    I8,
    /// One byte.
    U8,
    /// Two bytes with a sign.
    I16,
    /// Two bytes.
    U16,
    /// Four bytes with a sign.
    I32,
    /// Four bytes.
    U32,
    /// Four bytes with a fraction.
    F32,
    /// Eight bytes with a fraction.
    F64,
}

impl NumberType {
    /// Size of such a number in bytes.
    pub fn n_bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// The byte order of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

/// One number of every point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PackedField {
    /// Its name.
    pub name: String,
    /// Its start in a point, in bytes.
    pub offset: usize,
    /// Type of its numbers.
    pub number: NumberType,
}

impl PackedField {
    /// Whether its name is `name`, in upper or lower case and with or without the prefix of `CloudCompare`.
    fn is_called(&self, name: &str) -> bool {
        let own = self.name.as_str();
        let prefix = own.get(..SCALAR.len()).filter(|it| it.eq_ignore_ascii_case(SCALAR));
        own[prefix.map_or(0, str::len)..].eq_ignore_ascii_case(name)
    }
}

/// Points in rows: `n_rows` of `n_columns` points, with room between points and rows.
#[derive(Debug, Clone)]
pub struct PackedPoints<'a> {
    /// The fields of a point.
    pub fields: Vec<PackedField>,
    /// Number of points in a row.
    pub n_columns: usize,
    /// Number of rows.
    pub n_rows: usize,
    /// Bytes from one point to the next.
    pub point_step: usize,
    /// Bytes from one row to the next.
    pub row_step: usize,
    /// The byte order of all numbers.
    pub byte_order: ByteOrder,
    /// The bytes of all points.
    pub data: &'a [u8],
}

/// The names of the intensity, in upper and lower case; the first that exists counts.
const INTENSITY_NAMES: [&str; 7] =
    ["intensity", "intensities", "reflectivity", "reflectance", "remission", "remissions", "i"];

/// Prefix that `CloudCompare` puts before the names of all numbers that are no coordinates.
const SCALAR: &str = "scalar_";

/// The field with the number of the laser.
pub const RING: &str = "ring";

/// The field in which scanbench writes seconds after the time of the scan.
pub const TIME_OFFSET: &str = "time_offset_s";

/// Fields of times after that of the scan, as scanbench, drivers of Velodyne and drivers of Ouster write them, with their
/// unit in seconds. The type counts as well: the unit of a time of another type is unknown.
const TIME_FIELDS: [(&str, NumberType, f64); 3] =
    [(TIME_OFFSET, NumberType::F32, 1.0), ("time", NumberType::F32, 1.0), ("t", NumberType::U32, 1e-9)];

/// The field of `fields` that holds the intensity, under any of its names.
pub fn intensity_field(fields: &[PackedField]) -> Option<&PackedField> {
    INTENSITY_NAMES.iter().find_map(|name| fields.iter().find(|it| it.is_called(name)))
}

/// The field of `fields` with the time of a point after the time of the scan, and its unit in seconds.
pub fn time_field(fields: &[PackedField]) -> Option<(&PackedField, f64)> {
    TIME_FIELDS.iter().find_map(|(name, number, unit_s)| {
        let is_it = |it: &&PackedField| it.name.eq_ignore_ascii_case(name) && it.number == *number;
        fields.iter().find(is_it).map(|field| (field, *unit_s))
    })
}

impl<'a> PackedPoints<'a> {
    /// `n_points` in a single row.
    pub fn in_a_row(
        fields: Vec<PackedField>,
        n_points: usize,
        point_step: usize,
        byte_order: ByteOrder,
        data: &'a [u8],
    ) -> Self {
        Self { fields, n_columns: n_points, n_rows: 1, point_step, row_step: 0, byte_order, data }
    }
}

impl PackedPoints<'_> {
    /// Makes sure that every number lies within the data. Errors are the rest of a sentence about the file.
    fn check(&self) -> Result<(), String> {
        for field in &self.fields {
            let end = field.offset.checked_add(field.number.n_bytes());
            if end.is_none_or(|end| end > self.point_step) {
                let (name, step) = (&field.name, self.point_step);
                return Err(format!("has a field {name:?} that ends beyond the {step} bytes of a point"));
            }
        }
        let n_points = self.n_rows.checked_mul(self.n_columns);
        let n_row_bytes = self.n_columns.checked_mul(self.point_step);
        let n_needed = match (self.n_rows, n_row_bytes) {
            (0, _) | (_, Some(0)) => Some(0),
            (n_rows, Some(n_row_bytes)) if n_row_bytes <= self.row_step || n_rows == 1 => {
                (n_rows - 1).checked_mul(self.row_step).and_then(|before| before.checked_add(n_row_bytes))
            }
            _ => None,
        };
        let n_bytes = self.data.len();
        match (n_points, n_needed) {
            // Points that were not announced.
            (Some(0), _) if n_bytes > 0 => {
                Err(format!("announces no points, but has {n_bytes} bytes of them"))
            }
            (Some(_), Some(n_needed)) if n_needed <= n_bytes => Ok(()),
            _ => {
                let (rows, columns, step) = (self.n_rows, self.n_columns, self.point_step);
                Err(format!(
                    "announces {rows} x {columns} points of {step} bytes, {} per row, but has {n_bytes} bytes",
                    self.row_step
                ))
            }
        }
    }

    /// Number of points.
    pub fn n_points(&self) -> usize {
        if self.point_step == 0 { 0 } else { self.n_rows * self.n_columns }
    }

    /// The points in metres, with their lasers and times if there are [fields](time_field) for them.
    ///
    /// A cloud without points needs no fields: drivers send such placeholders.
    pub fn positioned(&self) -> Result<PositionedPoints, String> {
        self.check()?;
        if self.n_rows == 0 || self.n_columns == 0 {
            return Ok(PositionedPoints::default());
        }
        let position = ["x", "y", "z"].map(|name| self.field(name).ok_or_else(|| self.lacks(name)));
        let [x, y, z] = position;
        let (x, y, z) = (x?, y?, z?);
        let intensity = intensity_field(&self.fields);
        let mut points = PositionedPoints::with_capacity(self.n_points());
        let is_common = |field: &PackedField| field.number == NumberType::F32;
        if self.byte_order == ByteOrder::Little && [x, y, z].into_iter().chain(intensity).all(is_common) {
            let number = |point: &[u8], offset: usize| {
                point[offset..].first_chunk().map_or(f32::NAN, |bytes| f32::from_le_bytes(*bytes))
            };
            let (x, y, z) = (x.offset, y.offset, z.offset);
            let intensity = intensity.map(|field| field.offset);
            for point in self.rows() {
                let intensity = intensity.map_or(0.0, |offset| number(point, offset));
                points.push([x, y, z].map(|offset| f64::from(number(point, offset))), intensity)?;
            }
        } else {
            for point in self.rows() {
                let intensity = intensity.map_or(0.0, |field| self.number(point, field) as f32);
                points.push([x, y, z].map(|field| self.number(point, field)), intensity)?;
            }
        }
        self.take_lasers_and_times(&self.fields, &mut points)?;
        Ok(points)
    }

    /// Takes lasers and times into `points`, made of the same rows, by the types of `fields`.
    pub fn take_lasers_and_times(
        &self,
        fields: &[PackedField],
        points: &mut PositionedPoints,
    ) -> Result<(), String> {
        if let Some(of_all) = self.column(RING)? {
            points.take_rings(&of_all);
        }
        if let Some((field, unit_s)) = time_field(fields)
            && let Some(mut of_all) = self.column(&field.name)?
        {
            for it in &mut of_all {
                *it *= unit_s;
            }
            points.take_time_offsets_s(&of_all);
        }
        Ok(())
    }

    /// The numbers of the field `name`, if there is one.
    pub fn column(&self, name: &str) -> Result<Option<Vec<f64>>, String> {
        self.check()?;
        let field = self.fields.iter().find(|it| it.is_called(name));
        Ok(field.map(|field| self.rows().map(|point| self.number(point, field)).collect()))
    }

    fn field(&self, name: &str) -> Option<&PackedField> {
        self.fields.iter().find(|field| field.name.eq_ignore_ascii_case(name))
    }

    fn lacks(&self, name: &str) -> String {
        let names: Vec<&str> = self.fields.iter().map(|field| field.name.as_str()).collect();
        format!("has points without {name}; they have {}", names.join(", "))
    }

    /// The bytes of every point; checked before.
    fn rows(&self) -> impl Iterator<Item = &[u8]> {
        // Rows without bytes may be announced beyond the data.
        let n_rows = if self.point_step == 0 || self.n_columns == 0 { 0 } else { self.n_rows };
        (0..n_rows).flat_map(move |row| {
            let begin = row * self.row_step;
            self.data[begin..begin + self.n_columns * self.point_step].chunks_exact(self.point_step.max(1))
        })
    }

    fn number(&self, point: &[u8], field: &PackedField) -> f64 {
        let mut bytes = [0; 8];
        let n_bytes = field.number.n_bytes();
        let number = &mut bytes[..n_bytes];
        number.copy_from_slice(&point[field.offset..field.offset + n_bytes]);
        if self.byte_order == ByteOrder::Big {
            number.reverse();
        }
        let [a, b, c, d, ..] = bytes;
        match field.number {
            NumberType::I8 => f64::from(a as i8),
            NumberType::U8 => f64::from(a),
            NumberType::I16 => f64::from(i16::from_le_bytes([a, b])),
            NumberType::U16 => f64::from(u16::from_le_bytes([a, b])),
            NumberType::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            NumberType::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            NumberType::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            NumberType::F64 => f64::from_le_bytes(bytes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn field(name: &str, offset: usize, number: NumberType) -> PackedField {
        PackedField { name: name.to_owned(), offset, number }
    }

    #[test]
    fn fields_come_in_any_order_type_and_byte_order() {
        // i16 z, one byte of padding, u8 intensity, f64 x, f32 y; two rows of one point with two bytes between rows.
        let mut data = Vec::new();
        for (z, intensity, x, y) in [(-2_i16, 7_u8, 1.5_f64, 2.5_f32), (3, 200, -4.5, f32::NAN)] {
            data.extend(z.to_be_bytes());
            data.extend([99, intensity]);
            data.extend(x.to_be_bytes());
            data.extend(y.to_be_bytes());
            data.extend([1, 2]);
        }
        let fields = vec![
            field("z", 0, NumberType::I16),
            field("scalar_Reflectivity", 3, NumberType::U8),
            field("x", 4, NumberType::F64),
            field("y", 12, NumberType::F32),
        ];
        let packed = PackedPoints {
            fields,
            n_columns: 1,
            n_rows: 2,
            point_step: 16,
            row_step: 18,
            byte_order: ByteOrder::Big,
            data: &data[..34],
        };
        let (cloud, left_out) = packed.positioned().unwrap().into_parts();
        assert!(cloud.positions_m().eq([[1.5, 2.5, -2.0]]), "{cloud:?}");
        assert_eq!((cloud.intensity(), &left_out[..]), (&[7.0][..], &[1][..]));
        assert_eq!(packed.column("z").unwrap().unwrap(), [-2.0, 3.0]);
        assert_eq!(packed.column("ring").unwrap(), None);
    }

    fn xyz(n_columns: usize, n_rows: usize, row_step: usize, data: &[u8]) -> PackedPoints<'_> {
        let fields =
            [("x", 0), ("y", 4), ("z", 8)].map(|(name, offset)| field(name, offset, NumberType::F32));
        let byte_order = ByteOrder::Little;
        PackedPoints {
            fields: fields.to_vec(),
            n_columns,
            n_rows,
            point_step: 12,
            row_step,
            byte_order,
            data,
        }
    }

    #[test]
    fn lasers_and_times_are_taken_from_fields_whose_unit_is_certain() {
        let times = |name: &str, number: NumberType, value: &[u8]| {
            let mut point = [0; 22];
            point[12..12 + value.len()].copy_from_slice(value);
            point[20..].copy_from_slice(&[1, 2]);
            let mut fields = xyz(1, 1, 22, &point).fields;
            fields.extend([field(name, 12, number), field("RING", 20, NumberType::U16)]);
            let packed = PackedPoints { fields, point_step: 22, ..xyz(1, 1, 22, &point) };
            let (cloud, _) = packed.positioned().unwrap().into_parts();
            assert_eq!(cloud.ring(), Some(&[0x0201][..]));
            cloud.time_offset_s().map(|it| it[0])
        };
        assert_eq!(times("time", NumberType::F32, &(-0.25_f32).to_le_bytes()), Some(-0.25));
        assert_eq!(times("time_offset_s", NumberType::F32, &0.5_f32.to_le_bytes()), Some(0.5));
        assert_eq!(times("t", NumberType::U32, &50_000_000_u32.to_le_bytes()), Some(0.05));
        assert_eq!(times("t", NumberType::F32, &0.05_f32.to_le_bytes()), None);
        assert_eq!(times("time", NumberType::F64, &0.05_f64.to_le_bytes()), None);
        assert_eq!(times("time", NumberType::F32, &f32::NAN.to_le_bytes()), None);
    }

    #[test]
    fn the_intensity_is_found_by_any_of_its_names() {
        let found = |names: &[&str]| {
            let fields: Vec<PackedField> = names.iter().map(|it| field(it, 0, NumberType::F32)).collect();
            intensity_field(&fields).map(|it| it.name.clone())
        };
        for name in ["Intensity", "scalar_Intensity", "SCALAR_intensities", "remission", "Scalar_i", "I"] {
            assert_eq!(found(&["x", name, "scalar_time"]).as_deref(), Some(name));
        }
        assert_eq!(found(&["i", "scalar_Intensity"]).as_deref(), Some("scalar_Intensity"));
        assert_eq!(found(&["x", "scalar_x", "scalar_", "scalar", "intensity_of", "état"]), None);
    }

    #[track_caller]
    fn check_refused(packed: &PackedPoints<'_>, part: &str) {
        let problem = packed.positioned().expect_err("damaged");
        assert!(problem.contains(part), "{problem}");
    }

    #[test]
    fn what_is_announced_must_be_there() {
        assert_eq!(xyz(2, 1, 24, &[0; 24]).positioned().unwrap().n_in_file(), 2);
        for placeholder in [xyz(0, 1, 0, &[]), xyz(0, 0, 0, &[]), xyz(5, 0, 60, &[])] {
            assert_eq!(placeholder.positioned().unwrap().n_in_file(), 0);
            let without_fields = PackedPoints { fields: Vec::new(), point_step: 0, ..placeholder };
            assert_eq!(without_fields.positioned().unwrap().n_in_file(), 0);
        }
        check_refused(&xyz(0, 1, 0, &[0; 12]), "announces no points, but has 12 bytes of them");
        let without_fields = PackedPoints { fields: Vec::new(), ..xyz(1, 1, 12, &[0; 12]) };
        check_refused(&without_fields, "without x");
        // Some drivers leave the row step of a single row at 0.
        assert_eq!(xyz(2, 1, 0, &[0; 24]).positioned().unwrap().n_in_file(), 2);
        check_refused(
            &xyz(2, 1, 24, &[0; 23]),
            "announces 1 x 2 points of 12 bytes, 24 per row, but has 23 bytes",
        );
        check_refused(&xyz(2, 2, 12, &[0; 48]), "12 per row");
        check_refused(&xyz(usize::MAX, 2, 24, &[0; 24]), "announces");
        check_refused(&xyz(4_294_967_295, 1, 0, &[0; 24]), "announces 1 x 4294967295");
        let mut without_y = xyz(2, 1, 24, &[0; 24]);
        without_y.fields.remove(1);
        check_refused(&without_y, "without y; they have x, z");
        let mut beyond = xyz(2, 1, 24, &[0; 24]);
        beyond.fields[2].offset = usize::MAX;
        check_refused(&beyond, "field \"z\" that ends beyond the 12 bytes of a point");
    }

    proptest! {
        #[test]
        fn any_layout_gives_points_or_an_error(
            n_columns in 0_usize..9, n_rows in 0_usize..9, point_step in 0_usize..20, row_step in 0_usize..99,
            offsets in prop::array::uniform3(0_usize..20), data in prop::collection::vec(any::<u8>(), 0..200),
        ) {
            let fields = [("x", NumberType::F32), ("y", NumberType::U8), ("z", NumberType::F64)];
            let fields = fields.into_iter().zip(offsets).map(|((name, number), offset)| field(name, offset, number));
            for byte_order in [ByteOrder::Little, ByteOrder::Big] {
                let fields = fields.clone().collect();
                let packed = PackedPoints { fields, n_columns, n_rows, point_step, row_step, byte_order, data: &data };
                if let Ok(points) = packed.positioned() {
                    prop_assert_eq!(points.n_in_file(), if point_step == 0 { 0 } else { n_rows * n_columns });
                }
            }
        }
    }
}
