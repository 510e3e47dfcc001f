//! The columns of points in files that do not name them: `.bin` and `.npy`.

use std::fmt;
use std::str::FromStr;

use reports::vocabulary::named::named;

use super::packed_points::{NumberType, PackedField, RING};

/// A point has fewer columns than this.
pub const MAX_COLUMNS: usize = 1024;

named! {
    /// Meaning of one number of every point.
    pub enum PointColumn {
        /// Coordinate in metres.
        X = "x",
        /// Coordinate in metres.
        Y = "y",
        /// Coordinate in metres.
        Z = "z",
        /// Intensity as the sensor has it.
        Intensity = "intensity",
        /// Number of the laser.
        Ring = "ring",
        /// Anything else, which is not read.
        Other = "_",
    }
}

/// Columns of a point, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointColumns {
    // Invariant: x, y and z are there, and no column but `Other` is there twice.
    columns: Vec<PointColumn>,
}

impl PointColumns {
    /// The columns of KITTI: x, y, z and intensity.
    pub fn of_kitti() -> Self {
        Self::of_three_and(&[PointColumn::Intensity])
    }

    /// The columns of nuScenes: x, y, z, intensity and ring.
    pub fn of_nuscenes() -> Self {
        Self::of_three_and(&[PointColumn::Intensity, PointColumn::Ring])
    }

    /// x, y and z, and then `others`, each of which is there once at most, unless it is `Other`.
    pub(super) fn of_three_and(others: &[PointColumn]) -> Self {
        Self { columns: [&[PointColumn::X, PointColumn::Y, PointColumn::Z], others].concat() }
    }

    /// The first `n_columns` of these columns; columns beyond them are not read.
    pub(super) fn resized(&self, n_columns: usize) -> Self {
        let mut columns = self.columns.clone();
        columns.resize(n_columns.max(3), PointColumn::Other);
        Self { columns }
    }

    /// Number of columns.
    pub fn n_columns(&self) -> usize {
        self.columns.len()
    }

    /// Position of `column`; `None` if it is missing.
    pub fn position_of(&self, column: PointColumn) -> Option<usize> {
        self.columns.iter().position(|it| *it == column)
    }

    /// The columns that are read, as fields of packed points whose numbers are all `number`.
    pub fn fields(&self, number: NumberType) -> Vec<PackedField> {
        let name = |it: &PointColumn| match it {
            PointColumn::Ring => RING,
            other => other.name(),
        };
        let fields = self.columns.iter().enumerate().filter(|(_, it)| **it != PointColumn::Other);
        let field =
            |(index, it)| PackedField { name: name(it).to_owned(), offset: index * number.n_bytes(), number };
        fields.map(field).collect()
    }
}

impl fmt::Display for PointColumns {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.columns.iter().map(|it| it.name()).collect();
        formatter.write_str(&names.join(","))
    }
}

impl FromStr for PointColumns {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut columns = Vec::new();
        for name in text.split(',').map(str::trim) {
            let column = PointColumn::from_name(name).ok_or_else(|| {
                let known = PointColumn::ALL.map(PointColumn::name).join(", ");
                format!("{name:?} is no column; columns are {known}, where _ is not read")
            })?;
            if column != PointColumn::Other && columns.contains(&column) {
                return Err(format!("{name} is there twice"));
            }
            columns.push(column);
        }
        let coordinates = [PointColumn::X, PointColumn::Y, PointColumn::Z];
        if let Some(missing) = coordinates.iter().find(|it| !columns.contains(it)) {
            return Err(format!("{missing} is missing"));
        }
        if columns.len() >= MAX_COLUMNS {
            return Err(format!("{} columns are more than {}", columns.len(), MAX_COLUMNS - 1));
        }
        Ok(Self { columns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_read_as_they_are_written() {
        for text in ["x,y,z,intensity", "_,z,y,x,_,ring,intensity", "x,y,z"] {
            assert_eq!(text.parse::<PointColumns>().unwrap().to_string(), text);
        }
        assert_eq!("x, y ,z,intensity".parse(), Ok(PointColumns::of_kitti()));
        let fields = "_,z,y,x,_,ring".parse::<PointColumns>().unwrap().fields(NumberType::F64);
        let found: Vec<_> = fields.iter().map(|it| (it.name.as_str(), it.offset)).collect();
        assert_eq!(found, [("z", 8), ("y", 16), ("x", 24), ("ring", 40)]);
    }

    #[test]
    fn mistakes_are_named() {
        let problem = |text: &str| text.parse::<PointColumns>().expect_err("a mistake");
        assert!(
            problem("x,y,z,i").starts_with("\"i\" is no column; columns are x, y, z, intensity, ring, _")
        );
        assert_eq!(problem("x,y,intensity"), "z is missing");
        assert_eq!(problem("x,y,z,x"), "x is there twice");
        assert_eq!(problem(&format!("x,y,z{}", ",_".repeat(1021))), "1024 columns are more than 1023");
        assert!(problem("").contains("\"\" is no column"));
    }
}
