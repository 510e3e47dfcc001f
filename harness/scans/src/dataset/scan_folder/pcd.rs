//! PCD, the format of the Point Cloud Library: a header in text, then points as text, as rows of bytes, or compressed field
//! by field.

use crate::dataset::packed_points::{
    ByteOrder, NumberType, PackedField, PackedPoints, RING, intensity_field, time_field,
};
use crate::dataset::positioned_points::PositionedPoints;

/// A point has fewer fields than this.
const MAX_FIELDS: usize = 256;

/// Compressed points may grow to this many times their size.
const MAX_GROWTH: usize = 256;

/// Values of the header; each field comes with the count of its numbers.
struct Header<'a> {
    fields: Vec<(PackedField, usize)>,
    point_step: usize,
    n_points: usize,
    encoding: &'a str,
}

/// The points in `bytes`, in metres. Errors are the rest of a sentence about the file.
///
/// The pose of the sensor (`VIEWPOINT`) is ignored: points are taken to be in its frame.
pub fn parse_pcd(bytes: &[u8]) -> Result<PositionedPoints, String> {
    let (header, data) = parse_header(bytes)?;
    match header.encoding {
        "ascii" => parse_text(&header, data),
        "binary" => packed(&header, data).positioned(),
        "binary_compressed" => {
            let rows = decompressed_rows(&header, data)?;
            packed(&header, &rows).positioned()
        }
        other => Err(format!("has points in the unknown encoding {other:?}")),
    }
}

fn packed<'a>(header: &Header<'_>, data: &'a [u8]) -> PackedPoints<'a> {
    let fields = header.fields.iter().map(|(field, _)| field.clone()).collect();
    PackedPoints::in_a_row(fields, header.n_points, header.point_step, ByteOrder::Little, data)
}

fn parse_header(bytes: &[u8]) -> Result<(Header<'_>, &[u8]), String> {
    let (mut names, mut sizes, mut types, mut counts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut width, mut height, mut n_points) = (None, 1, None);
    let mut rest = bytes;
    loop {
        let end = rest.iter().position(|byte| *byte == b'\n').ok_or("has no line DATA in its header")?;
        let line = std::str::from_utf8(&rest[..end]).map_err(|_| "has a header that is not text")?;
        rest = &rest[end + 1..];
        let mut words = line.split_whitespace();
        let Some(key) = words.next() else { continue };
        let number = |word: Option<&str>| -> Result<usize, String> {
            let word = word.unwrap_or_default();
            word.parse().map_err(|_| format!("says {key} {word:?}, which is not a number"))
        };
        match key {
            "FIELDS" | "COLUMNS" => names = words.collect(),
            "SIZE" => sizes = words.map(|it| number(Some(it))).collect::<Result<_, _>>()?,
            "TYPE" => types = words.collect(),
            "COUNT" => counts = words.map(|it| number(Some(it))).collect::<Result<_, _>>()?,
            "WIDTH" => width = Some(number(words.next())?),
            "HEIGHT" => height = number(words.next())?,
            "POINTS" => n_points = Some(number(words.next())?),
            "DATA" => {
                let encoding = words.next().unwrap_or_default();
                let n_points = n_points
                    .or_else(|| width?.checked_mul(height))
                    .ok_or("does not say how many points it has")?;
                let (fields, point_step) = fields_of(&names, &sizes, &types, &counts)?;
                return Ok((Header { fields, point_step, n_points, encoding }, rest));
            }
            _ => {}
        }
    }
}

/// The fields, each with the count of its numbers, and the bytes of a point.
fn fields_of(
    names: &[&str],
    sizes: &[usize],
    types: &[&str],
    counts: &[usize],
) -> Result<(Vec<(PackedField, usize)>, usize), String> {
    let n = names.len();
    if n == 0
        || n > MAX_FIELDS
        || sizes.len() != n
        || types.len() != n
        || !(counts.is_empty() || counts.len() == n)
    {
        return Err(format!(
            "has {n} fields, but {} sizes, {} types, {} counts",
            sizes.len(),
            types.len(),
            counts.len()
        ));
    }
    let (mut fields, mut offset) = (Vec::with_capacity(n), 0_usize);
    for (field_idx, name) in names.iter().enumerate() {
        let number = match (types[field_idx], sizes[field_idx]) {
            ("I", 1) => NumberType::I8,
            ("U", 1) => NumberType::U8,
            ("I", 2) => NumberType::I16,
            ("U", 2) => NumberType::U16,
            ("I", 4) => NumberType::I32,
            ("U", 4) => NumberType::U32,
            ("F", 4) => NumberType::F32,
            ("F", 8) => NumberType::F64,
            // Padding and fields that are not read may have any size.
            ("I" | "U", 8) if !matches!(*name, "x" | "y" | "z") => NumberType::F64,
            (kind, size) => return Err(format!("has a field {name:?} of type {kind} and size {size}")),
        };
        let count = counts.get(field_idx).copied().unwrap_or(1);
        if count == 0 {
            return Err(format!("has an empty field {name:?}"));
        }
        fields.push((PackedField { name: (*name).to_owned(), offset, number }, count));
        let n_bytes = number.n_bytes().checked_mul(count);
        offset =
            n_bytes.and_then(|n_bytes| offset.checked_add(n_bytes)).ok_or("has a point that is too large")?;
    }
    Ok((fields, offset))
}

fn parse_text(header: &Header<'_>, data: &[u8]) -> Result<PositionedPoints, String> {
    let text = std::str::from_utf8(data).map_err(|_| "has points that are not text")?;
    if header.n_points == 0 && !text.trim().is_empty() {
        return Err("announces no points, but has lines of numbers".to_owned());
    }
    let column = |name: &str| {
        let mut column = 0_usize;
        for (field, count) in &header.fields {
            if field.name.eq_ignore_ascii_case(name) {
                return Some(column);
            }
            column = column.saturating_add(*count);
        }
        None
    };
    let lacks = |name: &str| format!("has points without {name}");
    let (x, y, z) = (
        column("x").ok_or_else(|| lacks("x"))?,
        column("y").ok_or_else(|| lacks("y"))?,
        column("z").ok_or_else(|| lacks("z"))?,
    );
    let fields: Vec<PackedField> = header.fields.iter().map(|(field, _)| field.clone()).collect();
    let intensity = intensity_field(&fields).and_then(|it| column(&it.name));
    let ring = column(RING);
    let time = time_field(&fields).and_then(|(field, unit_s)| Some((column(&field.name)?, unit_s)));
    let (mut rings, mut times_s) = (Vec::new(), Vec::new());
    // Grown as points are found: their number may be false.
    let mut points = PositionedPoints::default();
    for (line_idx, line) in
        text.lines().filter(|line| !line.trim().is_empty()).take(header.n_points).enumerate()
    {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |column: usize| -> Result<f64, String> {
            let word = words
                .get(column)
                .ok_or_else(|| format!("has point {line_idx} with {} numbers", words.len()))?;
            word.parse().map_err(|_| format!("has point {line_idx} with {word:?}, which is not a number"))
        };
        let intensity = intensity.map_or(Ok(0.0), number)? as f32;
        points.push([number(x)?, number(y)?, number(z)?], intensity)?;
        if let Some(ring) = ring {
            rings.push(number(ring)?);
        }
        if let Some((time, unit_s)) = time {
            times_s.push(unit_s * number(time)?);
        }
    }
    points.take_rings(&rings);
    points.take_time_offsets_s(&times_s);
    if points.n_in_file() < header.n_points {
        return Err(format!("announces {} points but has {}", header.n_points, points.n_in_file()));
    }
    Ok(points)
}

/// The points as rows: compressed points are stored field by field.
fn decompressed_rows(header: &Header<'_>, data: &[u8]) -> Result<Vec<u8>, String> {
    if header.n_points == 0 && data.is_empty() {
        return Ok(Vec::new());
    }
    let (sizes, compressed) = data.split_first_chunk::<8>().ok_or("has no compressed points")?;
    let [a, b, c, d, e, f, g, h] = *sizes;
    let (n_compressed, n_plain) =
        (u32::from_le_bytes([a, b, c, d]) as usize, u32::from_le_bytes([e, f, g, h]) as usize);
    let compressed = compressed.get(..n_compressed).ok_or("is cut off within its compressed points")?;
    let expected = header.n_points.checked_mul(header.point_step);
    if expected != Some(n_plain) || n_plain > compressed.len().saturating_mul(MAX_GROWTH) {
        let (n, step) = (header.n_points, header.point_step);
        return Err(format!(
            "announces {n} points of {step} bytes and {n_plain} bytes from {n_compressed} compressed ones"
        ));
    }
    let columns = decompress_lzf(compressed, n_plain)?;
    let mut rows = vec![0; n_plain];
    let mut column_begin = 0;
    // Every field has bytes, so there are no more points than bytes.
    for (field, count) in &header.fields {
        let n_bytes = field.number.n_bytes() * count;
        for point_idx in 0..header.n_points {
            let from = column_begin + point_idx * n_bytes;
            let to = point_idx * header.point_step + field.offset;
            rows[to..to + n_bytes].copy_from_slice(&columns[from..from + n_bytes]);
        }
        column_begin += header.n_points * n_bytes;
    }
    Ok(rows)
}

/// Decompresses `compressed` by LZF, which must give exactly `n_plain` bytes.
fn decompress_lzf(compressed: &[u8], n_plain: usize) -> Result<Vec<u8>, String> {
    let damaged = || "has compressed points that are damaged".to_owned();
    let mut plain = Vec::with_capacity(n_plain);
    let mut bytes = compressed.iter().copied();
    while let Some(control) = bytes.next() {
        let control = usize::from(control);
        if control < 32 {
            // Copies `control` + 1 bytes unchanged.
            for _ in 0..=control {
                plain.push(bytes.next().ok_or_else(damaged)?);
            }
        } else {
            // Copies bytes from further back, which may overlap with those being written.
            let mut length = control >> 5;
            if length == 7 {
                length += usize::from(bytes.next().ok_or_else(damaged)?);
            }
            let back = ((control & 31) << 8) + usize::from(bytes.next().ok_or_else(damaged)?) + 1;
            let begin = plain.len().checked_sub(back).ok_or_else(damaged)?;
            for offset in 0..length + 2 {
                plain.push(plain[begin + offset]);
            }
        }
        if plain.len() > n_plain {
            return Err(damaged());
        }
    }
    if plain.len() == n_plain { Ok(plain) } else { Err(damaged()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "# .PCD v0.7\nVERSION 0.7\nFIELDS y x rgb z intensity ring time\nSIZE 4 8 1 4 2 1 4\n\
                          TYPE F F U F U U F\nCOUNT 1 1 3 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";

    #[track_caller]
    fn check(bytes: &[u8]) {
        let (cloud, _) = parse_pcd(bytes).unwrap().into_parts();
        assert!(cloud.positions_m().eq([[1.5, 2.0, -3.0], [4.0, 5.0, 6.0]]), "{cloud:?}");
        assert_eq!(cloud.intensity(), [7.0, 300.0]);
        assert_eq!((cloud.ring(), cloud.time_offset_s()), (Some(&[12, 5][..]), Some(&[-0.5, 0.25][..])));
    }

    #[track_caller]
    fn check_refused(bytes: &[u8], part: &str) {
        let problem = parse_pcd(bytes).expect_err("damaged");
        assert!(problem.contains(part), "{problem}");
    }

    fn columns() -> [Vec<u8>; 7] {
        [
            [2.0_f32, 5.0].iter().flat_map(|it| it.to_le_bytes()).collect(),
            [1.5_f64, 4.0].iter().flat_map(|it| it.to_le_bytes()).collect(),
            vec![9; 6],
            [-3.0_f32, 6.0].iter().flat_map(|it| it.to_le_bytes()).collect(),
            [7_u16, 300].iter().flat_map(|it| it.to_le_bytes()).collect(),
            vec![12, 5],
            [-0.5_f32, 0.25].iter().flat_map(|it| it.to_le_bytes()).collect(),
        ]
    }

    fn rows() -> Vec<u8> {
        (0..2)
            .flat_map(|row| {
                columns().map(|it| it[row * it.len() / 2..(row + 1) * it.len() / 2].to_vec()).concat()
            })
            .collect()
    }

    fn compressed() -> Vec<u8> {
        let plain = columns().concat();
        // All bytes unchanged except the six nines: one unchanged, and five copied from one back.
        let at = 24;
        let mut lzf = vec![at as u8];
        lzf.extend(&plain[..=at]);
        lzf.extend([3 << 5, 0]);
        lzf.push((plain.len() - at - 7) as u8);
        lzf.extend(&plain[at + 6..]);
        let mut bytes = format!("{HEADER}DATA binary_compressed\n").into_bytes();
        bytes.extend((lzf.len() as u32).to_le_bytes());
        bytes.extend((plain.len() as u32).to_le_bytes());
        bytes.extend(lzf);
        bytes
    }

    #[test]
    fn points_are_the_same_in_all_encodings() {
        check(format!("{HEADER}DATA ascii\n2 1.5 9 9 9 -3 7 12 -0.5\n\n5 4 9 9 9 6 300 5 0.25\n").as_bytes());
        check(&[format!("{HEADER}DATA binary\n").as_bytes(), &rows()].concat());
        check(&compressed());
    }

    #[test]
    fn the_intensity_has_other_names_in_all_encodings() {
        for name in ["scalar_Intensity", "Reflectivity"] {
            let header = HEADER.replace("intensity", name);
            check(
                format!("{header}DATA ascii\n2 1.5 9 9 9 -3 7 12 -0.5\n5 4 9 9 9 6 300 5 0.25\n").as_bytes(),
            );
            check(&[format!("{header}DATA binary\n").as_bytes(), &rows()].concat());
        }
    }

    #[test]
    fn what_is_announced_must_be_there() {
        check_refused(
            format!("{HEADER}DATA ascii\n2 1.5 9 9 9 -3 7 12 0\n").as_bytes(),
            "announces 2 points but has 1",
        );
        check_refused(format!("{HEADER}DATA ascii\n2 1.5 9 9 9\n").as_bytes(), "point 0 with 5 numbers");
        check_refused(
            format!("{HEADER}DATA ascii\n2 x 9 9 9 -3 7\n").as_bytes(),
            "\"x\", which is not a number",
        );
        check_refused(
            &[format!("{HEADER}DATA binary\n").as_bytes(), &rows()[1..]].concat(),
            "but has 51 bytes",
        );
        check_refused(format!("{HEADER}DATA zip\n").as_bytes(), "\"zip\"");
        for data in ["ascii", "binary", "binary_compressed"] {
            let endless = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 0 0 0\nPOINTS 18446744073709551615\n";
            let bytes = [format!("{endless}DATA {data}\n").as_bytes(), &[0; 8]].concat();
            check_refused(&bytes, "has an empty field \"x\"");
        }
        check_refused(HEADER.as_bytes(), "no line DATA");
        check_refused(b"", "no line DATA");
        let claim = HEADER.replace("POINTS 2", "POINTS 4294967295");
        check_refused(&[format!("{claim}DATA binary\n").as_bytes(), &rows()].concat(), "announces");
        check_refused(
            &[format!("{claim}DATA binary_compressed\n").as_bytes(), &[255; 40]].concat(),
            "cut off",
        );
        check_refused(format!("{claim}DATA ascii\n").as_bytes(), "announces 4294967295 points but has 0");
        check_refused(
            format!("{}DATA binary\n", HEADER.replace("SIZE 4 8", "SIZE 4")).as_bytes(),
            "7 fields, but 6 sizes",
        );
        let without_x = format!("{}DATA binary\n", HEADER.replace("y x", "y w"));
        check_refused(&[without_x.as_bytes(), &rows()].concat(), "without x");
    }

    #[test]
    fn damaged_compression_is_refused() {
        let sound = compressed();
        let begin = sound.len() - 60;
        for (at, value) in [(begin, 255), (sound.len() - 20, 255), (sound.len() - 1, 31)] {
            let mut damaged = sound.clone();
            damaged[at] = value;
            let _ = parse_pcd(&damaged);
        }
        check_refused(&sound[..sound.len() - 1], "cut off");
        let mut back = sound.clone();
        let first =
            sound.windows(1).count() - (sound.len() - HEADER.len() - "DATA binary_compressed\n".len()) + 8;
        back[first] = 0xff;
        check_refused(&back, "damaged");
    }
}
