//! PLY: a header in text that names the properties of a vertex, then vertices as text or as rows of bytes.

use crate::dataset::packed_points::{ByteOrder, NumberType, PackedField, PackedPoints};
use crate::dataset::positioned_points::PositionedPoints;

/// A vertex has fewer properties than this.
const MAX_PROPERTIES: usize = 256;

/// The vertices in `bytes` as points in metres. Errors are the rest of a sentence about the file.
pub fn parse_ply(bytes: &[u8]) -> Result<PositionedPoints, String> {
    let mut rest = bytes.strip_prefix(b"ply").ok_or("is not a PLY file")?;
    let (mut format, mut n_points) = (None, None);
    let (mut fields, mut point_step, mut is_vertex) = (Vec::new(), 0, false);
    loop {
        let end = rest.iter().position(|byte| *byte == b'\n').ok_or("has a header without end")?;
        let line = std::str::from_utf8(&rest[..end]).map_err(|_| "has a header that is not text")?;
        rest = &rest[end + 1..];
        match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["format", kind, _] => format = Some(kind),
            ["element", "vertex", n] if n_points.is_none() => {
                n_points = Some(
                    n.parse::<usize>()
                        .map_err(|_| format!("announces {n:?} vertices, which is not a number"))?,
                );
                is_vertex = true;
            }
            ["element", name, _] if n_points.is_none() => {
                return Err(format!("has the element {name:?} before its vertices"));
            }
            ["element", ..] => is_vertex = false,
            ["property", "list", ..] if is_vertex => return Err("has vertices with lists".to_owned()),
            ["property", kind, name] if is_vertex => {
                let number = number_type(kind)?;
                fields.push(PackedField { name: name.to_owned(), offset: point_step, number });
                point_step += number.n_bytes();
                if fields.len() > MAX_PROPERTIES {
                    return Err(format!("has vertices with more than {MAX_PROPERTIES} properties"));
                }
            }
            ["end_header"] => break,
            _ => {}
        }
    }
    let n_points = n_points.ok_or("has no vertices")?;
    let packed = |byte_order| PackedPoints::in_a_row(fields.clone(), n_points, point_step, byte_order, rest);
    match format {
        Some("binary_little_endian") => packed(ByteOrder::Little).positioned(),
        Some("binary_big_endian") => packed(ByteOrder::Big).positioned(),
        Some("ascii") => parse_text(&fields, n_points, rest),
        other => Err(format!("has vertices in the format {:?}", other.unwrap_or_default())),
    }
}

fn number_type(kind: &str) -> Result<NumberType, String> {
    Ok(match kind {
        "char" | "int8" => NumberType::I8,
        "uchar" | "uint8" => NumberType::U8,
        "short" | "int16" => NumberType::I16,
        "ushort" | "uint16" => NumberType::U16,
        "int" | "int32" => NumberType::I32,
        "uint" | "uint32" => NumberType::U32,
        "float" | "float32" => NumberType::F32,
        "double" | "float64" => NumberType::F64,
        _ => return Err(format!("has a property of the unknown type {kind:?}")),
    })
}

/// Lines of numbers, turned into rows of `f64`.
fn parse_text(fields: &[PackedField], n_points: usize, data: &[u8]) -> Result<PositionedPoints, String> {
    let text = std::str::from_utf8(data).map_err(|_| "has vertices that are not text")?;
    if n_points == 0 && !text.trim().is_empty() {
        return Err("announces no vertices, but has lines of numbers".to_owned());
    }
    let (mut rows, mut n_rows) = (Vec::new(), 0);
    for line in text.lines().filter(|line| !line.trim().is_empty()).take(n_points) {
        let mut words = line.split_whitespace();
        for field in fields {
            let word =
                words.next().ok_or_else(|| format!("has vertex {n_rows} without its {}", field.name))?;
            let number: f64 = word
                .parse()
                .map_err(|_| format!("has vertex {n_rows} with {word:?}, which is not a number"))?;
            rows.extend(number.to_le_bytes());
        }
        n_rows += 1;
    }
    if n_rows < n_points {
        return Err(format!("announces {n_points} vertices but has {n_rows}"));
    }
    let field = |(index, field): (usize, &PackedField)| PackedField {
        name: field.name.clone(),
        offset: index * NumberType::F64.n_bytes(),
        number: NumberType::F64,
    };
    let of_rows = fields.iter().enumerate().map(field).collect();
    let point_step = fields.len() * NumberType::F64.n_bytes();
    let packed = PackedPoints::in_a_row(of_rows, n_rows, point_step, ByteOrder::Little, &rows);
    let mut points = packed.positioned()?;
    packed.take_lasers_and_times(fields, &mut points)?;
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(format: &str) -> String {
        format!(
            "ply\nformat {format} 1.0\ncomment drawn\nelement vertex 2\nproperty float x\nproperty double y\n\
             property uchar intensity\nproperty float32 z\nproperty uchar ring\nproperty uint t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    }

    fn rows(turn: fn(Vec<u8>) -> Vec<u8>) -> Vec<u8> {
        let row = |x: f32, y: f64, intensity: u8, z: f32| {
            [
                turn(x.to_le_bytes().to_vec()),
                turn(y.to_le_bytes().to_vec()),
                vec![intensity],
                turn(z.to_le_bytes().to_vec()),
                vec![31],
                turn(50_000_000_u32.to_le_bytes().to_vec()),
            ]
            .concat()
        };
        [row(1.0, 2.0, 9, -3.0), row(4.0, 5.0, 200, 6.0)].concat()
    }

    fn reversed(mut bytes: Vec<u8>) -> Vec<u8> {
        bytes.reverse();
        bytes
    }

    #[test]
    fn points_are_the_same_in_all_formats() {
        for bytes in [
            [header("ascii").as_bytes(), b"1 2 9 -3 31 50000000\n4 5 200 6 31 50000000\n3 0 1 1\n"].concat(),
            [header("binary_little_endian").as_bytes(), &rows(|it| it), &[3; 9]].concat(),
            [header("binary_big_endian").as_bytes(), &rows(reversed)].concat(),
        ] {
            let (cloud, _) = parse_ply(&bytes).unwrap().into_parts();
            assert!(cloud.positions_m().eq([[1.0, 2.0, -3.0], [4.0, 5.0, 6.0]]), "{cloud:?}");
            assert_eq!(cloud.intensity(), [9.0, 200.0]);
            assert_eq!((cloud.ring(), cloud.time_offset_s()), (Some(&[31; 2][..]), Some(&[0.05; 2][..])));
        }
    }

    #[test]
    fn what_is_announced_must_be_there() {
        let check = |bytes: &[u8], part: &str| {
            let problem = parse_ply(bytes).expect_err("damaged");
            assert!(problem.contains(part), "{problem}");
        };
        check(&[header("binary_little_endian").as_bytes(), &rows(|it| it)[1..]].concat(), "but has 43 bytes");
        check(&[header("ascii").as_bytes(), b"1 2 9 -3 31 0\n"].concat(), "announces 2 vertices but has 1");
        check(&[header("ascii").as_bytes(), b"1 2 9\n1 2 3 4"].concat(), "vertex 0 without its z");
        check(b"plz", "is not a PLY file");
        check(b"ply\n", "header without end");
        let claim = header("binary_little_endian").replace("vertex 2", "vertex 4294967295");
        check(claim.as_bytes(), "announces 1 x 4294967295");
        check(header("zip").as_bytes(), "\"zip\"");
        check(
            header("ascii").replace("uchar intensity", "half intensity").as_bytes(),
            "unknown type \"half\"",
        );
        check(
            header("ascii").replace("element vertex 2\n", "element face 2\n").as_bytes(),
            "before its vertices",
        );
    }
}
