//! `.npy`, the format of `NumPy`: an array with a point in each row, whose columns have no names.

use super::packed_points::{ByteOrder, NumberType};
use super::point_array::PointArray;
use super::point_columns::MAX_COLUMNS;

/// The points in `bytes`, which may be fewer than announced. Errors are the rest of a sentence about the file.
pub fn parse_npy(bytes: &[u8]) -> Result<PointArray<'_>, String> {
    let not_npy = "is not an .npy file, or is cut off within its header";
    let (&[major, _], rest) =
        bytes.strip_prefix(b"\x93NUMPY").and_then(|it| it.split_first_chunk::<2>()).ok_or(not_npy)?;
    let (n_header_bytes, rest) = if major == 1 {
        let (length, rest) = rest.split_first_chunk::<2>().ok_or(not_npy)?;
        (usize::from(u16::from_le_bytes(*length)), rest)
    } else {
        let (length, rest) = rest.split_first_chunk::<4>().ok_or(not_npy)?;
        (u32::from_le_bytes(*length) as usize, rest)
    };
    let (header, data) = rest.split_at_checked(n_header_bytes).ok_or(not_npy)?;
    let header = std::str::from_utf8(header).map_err(|_| "has a header that is not text")?;
    let (byte_order, number) = match value_of(header, "descr").trim_matches('\'') {
        "<f4" => (ByteOrder::Little, NumberType::F32),
        ">f4" => (ByteOrder::Big, NumberType::F32),
        "<f8" => (ByteOrder::Little, NumberType::F64),
        ">f8" => (ByteOrder::Big, NumberType::F64),
        other => return Err(format!("has values of the type {other:?}; allowed are f4 and f8")),
    };
    let is_column_by_column = match value_of(header, "fortran_order") {
        "False" => false,
        "True" => true,
        other => return Err(format!("has the fortran_order {other:?}, not True or False")),
    };
    let shape = value_of(header, "shape");
    let mut sides = shape.trim_matches(['(', ')']).split(',').map(|it| it.trim().parse::<usize>().ok());
    let (Some(Some(n_points)), Some(Some(n_columns)), None) = (sides.next(), sides.next(), sides.next())
    else {
        return Err(format!("has the shape {shape:?}, not points by columns"));
    };
    if !(3..MAX_COLUMNS).contains(&n_columns) {
        let transposed = if (3..MAX_COLUMNS).contains(&n_points) { "; it may be transposed" } else { "" };
        return Err(format!(
            "has the shape {shape:?}, but each row is a point, with 3 to {} values{transposed}",
            MAX_COLUMNS - 1
        ));
    }
    let n_bytes = number.n_bytes();
    let data = if is_column_by_column {
        let rows = by_rows(data, n_points, n_columns, n_bytes).ok_or_else(|| {
            format!("announces {n_points} points of {n_columns} values but has {} bytes", data.len())
        })?;
        rows.into()
    } else {
        data.into()
    };
    Ok(PointArray { n_points, n_columns, number, byte_order, data })
}

/// Value of `key` in the header; empty if there is none.
fn value_of<'a>(header: &'a str, key: &str) -> &'a str {
    let after = header.split_once(&format!("'{key}':")).map_or("", |(_, after)| after.trim_start());
    let end =
        if after.starts_with('(') { after.find(')').map(|end| end + 1) } else { after.find([',', '}']) };
    after[..end.unwrap_or(0)].trim()
}

fn by_rows(columns: &[u8], n_points: usize, n_columns: usize, n_bytes: usize) -> Option<Vec<u8>> {
    let n_column_bytes = n_points.checked_mul(n_bytes)?;
    let columns = columns.get(..n_column_bytes.checked_mul(n_columns)?)?;
    let mut rows = Vec::with_capacity(columns.len());
    for point_idx in 0..n_points {
        for column in 0..n_columns {
            let begin = column * n_column_bytes + point_idx * n_bytes;
            rows.extend_from_slice(&columns[begin..begin + n_bytes]);
        }
    }
    Some(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::point_columns::PointColumns;
    use crate::dataset::positioned_points::PositionedPoints;

    fn positioned(bytes: &[u8]) -> Result<PositionedPoints, String> {
        let array = parse_npy(bytes)?;
        array.packed(PointColumns::of_kitti().resized(array.n_columns).fields(array.number)).positioned()
    }

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), data].concat()
    }

    fn f32s(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|it| it.to_le_bytes()).collect()
    }

    #[test]
    fn rows_and_columns_are_distinguished() {
        let rows = file(
            "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 4), }\n",
            &f32s(&[1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0, 0.25]),
        );
        let columns = file(
            "{'descr': '<f4', 'fortran_order': True, 'shape': (2, 4), }\n",
            &f32s(&[1.0, 4.0, 2.0, 5.0, 3.0, 6.0, 0.5, 0.25]),
        );
        let doubles: Vec<u8> =
            [1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0, 0.25_f64].iter().flat_map(|it| it.to_be_bytes()).collect();
        let doubles = file("{'descr': '>f8', 'fortran_order': False, 'shape': (2, 4)}", &doubles);
        for bytes in [rows, columns, doubles] {
            let (cloud, _) = positioned(&bytes).unwrap().into_parts();
            assert!(cloud.positions_m().eq([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), "{cloud:?}");
            assert_eq!(cloud.intensity(), [0.5, 0.25]);
        }
    }

    #[test]
    fn other_arrays_are_refused() {
        let check = |header: &str, part: &str| {
            let problem = positioned(&file(header, &[0; 48])).expect_err("no points");
            assert!(problem.contains(part), "{problem}");
        };
        check("{'descr': '<i4', 'fortran_order': False, 'shape': (4, 3)}", "\"<i4\"; allowed are f4 and f8");
        check("{'descr': '<f4', 'fortran_order': False, 'shape': (12,)}", "not points by columns");
        check(
            "{'descr': '<f4', 'fortran_order': False, 'shape': (6, 2)}",
            "with 3 to 1023 values; it may be transposed",
        );
        check("{'descr': '<f4', 'fortran_order': False, 'shape': (2000, 2)}", "with 3 to 1023 values");
        check("{'descr': '<f4', 'fortran_order': False, 'shape': (5, 3)}", "but has 48 bytes");
        check("{'descr': '<f4', 'fortran_order': True, 'shape': (4294967295, 3)}", "but has 48 bytes");
        check("{'descr': '<f4', 'shape': (4, 3)}", "has the fortran_order \"\"");
        check("", "type \"\"");
        assert!(parse_npy(b"\x93NUMPY\x01\x00\xff").is_err() && parse_npy(b"").is_err());
    }
}
