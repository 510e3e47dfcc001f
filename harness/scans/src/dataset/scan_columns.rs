//! Scans in files that do not name their columns, `.bin` and `.npy`; the columns are decided once for a data set.
//!
//! `.bin`, as KITTI and nuScenes have it, is little-endian f32 and nothing else: x, y and z in metres, then mostly
//! intensity, often ring, time or more. The user names the columns, or the numbers show how many there are; if they are too
//! few for that, there are as many as the format has. The meaning of a column is judged by its numbers. Files that look
//! unlike the others are refused.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::DatasetError;
use super::column_evidence::{ColumnEvidence, SeenColumns};
use super::column_meaning::{ColumnSample, meaning_of};
use super::npy::parse_npy;
use super::on_disk::bytes_of;
use super::point_array::PointArray;
use super::point_columns::PointColumns;
use super::positioned_points::PositionedPoints;

/// At most this many scans are sampled, evenly spread, until they have more bytes than this.
const N_LOOKED_AT: usize = 16;
const MAX_LOOKED_AT_BYTES: usize = 16 << 20;

/// How to read scans of a data set that do not name their columns.
#[derive(Debug)]
pub struct ScanColumns {
    said: Option<PointColumns>,
    usual: PointColumns,
    looked_at: Vec<PathBuf>,
    decided: OnceLock<Decided>,
}

/// Result of a look at some scans.
#[derive(Debug)]
struct Decided {
    of_bin: SeenColumns,
    // By the number of columns: the columns, or why only the user can know them, as the rest of a sentence.
    meanings: BTreeMap<usize, Result<PointColumns, String>>,
}

impl ScanColumns {
    /// The columns of `scans`: those that the user `said`, or those that numbers show; `usual` are those of the format.
    pub fn new(said: Option<PointColumns>, usual: PointColumns, scans: &[PathBuf]) -> Self {
        let unnamed: Vec<&PathBuf> = scans.iter().filter(|it| is_bin(it) || is_npy(it)).collect();
        let n = unnamed.len().min(N_LOOKED_AT);
        let looked_at = (0..n).map(|it| unnamed[it * unnamed.len() / n].clone()).collect();
        Self { said, usual, looked_at, decided: OnceLock::new() }
    }

    /// Reads the scan at `path`.
    ///
    /// A `.bin` has no header, so one cut between two points cannot be distinguished from a shorter scan.
    ///
    /// # Errors
    ///
    /// If it is damaged, has other columns than the rest, or only the user can know its columns.
    pub fn read(&self, path: &Path) -> Result<PositionedPoints, DatasetError> {
        self.parse(path, &bytes_of(path)?)
    }

    /// The scan in `bytes` of the file at `path`.
    ///
    /// # Errors
    ///
    /// As [`Self::read`].
    pub fn parse(&self, path: &Path, bytes: &[u8]) -> Result<PositionedPoints, DatasetError> {
        let damaged = |problem| DatasetError::damaged(path, problem);
        let array = if is_npy(path) {
            parse_npy(bytes).map_err(damaged)?
        } else {
            PointArray::of_bin(bytes, self.n_columns_of_bin(path, bytes)?)
        };
        let columns = self.columns_of(path, array.n_columns)?;
        let points = array.packed(columns.fields(array.number)).positioned().map_err(damaged)?;
        // Only the header of an array can state that there are no points.
        if is_npy(path) { points.none_or_some(path) } else { points.not_empty(path) }
    }

    /// The columns and how they are known; `None` if all scans name their columns.
    ///
    /// # Errors
    ///
    /// If only the user can know them.
    pub fn described(&self) -> Result<Option<String>, DatasetError> {
        let Some(first) = self.looked_at.first() else { return Ok(None) };
        if let Some(said) = &self.said {
            return Ok(Some(format!("{said}, as you say")));
        }
        if let SeenColumns::Either(one, other) = self.decided().of_bin {
            return Err(unclear(first, &either(one, other)));
        }
        let mut described = Vec::new();
        for meaning in self.decided().meanings.values() {
            let columns = meaning.as_ref().map_err(|problem| unclear(first, problem))?;
            described.push(format!("{columns}, as the numbers look"));
        }
        if described.is_empty() {
            described.push(format!("{}, as usual: too few numbers to see it", self.usual));
        }
        Ok(Some(described.join("; ")))
    }

    /// The number of columns of a `.bin`.
    fn n_columns_of_bin(&self, path: &Path, bytes: &[u8]) -> Result<usize, DatasetError> {
        let n_columns = match &self.said {
            Some(said) => said.n_columns(),
            None => self.seen_columns_of_bin(path, bytes)?,
        };
        let n_point_bytes = 4 * n_columns;
        if bytes.len().is_multiple_of(n_point_bytes) {
            return Ok(n_columns);
        }
        let partial = DatasetError::partial_point(path, bytes.len(), n_point_bytes);
        let is_guessed = self.said.is_none() && self.decided().of_bin == SeenColumns::Unseen;
        match partial {
            DatasetError::Damaged { path, problem } if is_guessed && bytes.len().is_multiple_of(4) => {
                let problem = format!("{problem}; if it is sound, name its columns with --columns");
                Err(DatasetError::Damaged { path, problem })
            }
            partial => Err(partial),
        }
    }

    fn seen_columns_of_bin(&self, path: &Path, bytes: &[u8]) -> Result<usize, DatasetError> {
        let n_columns = match self.decided().of_bin {
            SeenColumns::Seen(n_columns) => n_columns,
            SeenColumns::Unseen => self.usual.n_columns(),
            SeenColumns::Either(one, other) => {
                return Err(unclear(path, &either(one, other)));
            }
        };
        match ColumnEvidence::of(bytes).seen() {
            SeenColumns::Seen(n_own) if n_own != n_columns => {
                let problem =
                    format!("looks like {n_own} numbers for each point, where the data set has {n_columns}");
                Err(DatasetError::damaged(path, problem))
            }
            _ => Ok(n_columns),
        }
    }

    /// The `n_columns` columns of the scan at `path`.
    fn columns_of(&self, path: &Path, n_columns: usize) -> Result<PointColumns, DatasetError> {
        if let Some(said) = &self.said {
            if said.n_columns() == n_columns {
                return Ok(said.clone());
            }
            let problem = format!("has {n_columns} columns, but {said} are {}", said.n_columns());
            return Err(DatasetError::damaged(path, problem));
        }
        match self.decided().meanings.get(&n_columns) {
            Some(Ok(columns)) => Ok(columns.clone()),
            Some(Err(problem)) => Err(unclear(path, problem)),
            // No sampled file has as many columns, or numbers are too few to show them.
            None => Ok(self.usual.resized(n_columns)),
        }
    }

    fn decided(&self) -> &Decided {
        self.decided.get_or_init(|| self.decide())
    }

    /// Samples the scans. One that cannot be read is ignored here: it fails when it is read.
    fn decide(&self) -> Decided {
        let (mut evidence, mut bins, mut n_bytes) = (ColumnEvidence::new(), Vec::new(), 0);
        let mut samples: BTreeMap<usize, ColumnSample> = BTreeMap::new();
        let mut add = |array: &PointArray<'_>| samples.entry(array.n_columns).or_default().add(array);
        for path in &self.looked_at {
            let Ok(bytes) = bytes_of(path) else { continue };
            n_bytes += bytes.len();
            if !is_npy(path) {
                evidence.add(&bytes);
                bins.push(bytes);
            } else if let Ok(array) = parse_npy(&bytes) {
                add(&array);
            }
            if n_bytes > MAX_LOOKED_AT_BYTES {
                break;
            }
        }
        let of_bin = evidence.seen();
        if let SeenColumns::Seen(n_columns) = of_bin {
            for bytes in &bins {
                add(&PointArray::of_bin(bytes, n_columns));
            }
        }
        let meaning = |(n, sample): (usize, ColumnSample)| (n, meaning_of(&sample, &self.usual));
        Decided { of_bin, meanings: samples.into_iter().map(meaning).collect() }
    }
}

fn is_bin(path: &Path) -> bool {
    path.extension().is_some_and(|it| it.eq_ignore_ascii_case("bin"))
}

fn is_npy(path: &Path) -> bool {
    path.extension().is_some_and(|it| it.eq_ignore_ascii_case("npy"))
}

fn either(one: usize, other: usize) -> String {
    format!("may have {one} or {other} numbers for each point")
}

/// The error for a scan at `path` whose columns only the user can know.
fn unclear(path: &Path, problem: &str) -> DatasetError {
    DatasetError::Usage(format!(
        "{path:?} {problem}: name what each number is with --columns, such as --columns x,y,z,intensity,ring,_"
    ))
}

#[cfg(test)]
mod tests {
    use super::super::column_evidence::tests::{DrawnPoint, bytes_of, drawn_scan};
    use super::*;
    use detector::PointCloud;
    use proptest::prelude::*;

    /// Files of these names in a folder of their own.
    struct Files(tempfile::TempDir);

    impl Files {
        fn new(files: &[(&str, &[u8])]) -> Self {
            let folder = tempfile::tempdir().unwrap();
            for (name, bytes) in files {
                std::fs::write(folder.path().join(name), bytes).unwrap();
            }
            Self(folder)
        }

        fn paths(&self) -> Vec<PathBuf> {
            crate::dataset::on_disk::entries_of(self.0.path()).unwrap()
        }

        fn columns(&self, said: Option<&str>) -> ScanColumns {
            ScanColumns::new(said.map(|it| it.parse().unwrap()), PointColumns::of_kitti(), &self.paths())
        }
    }

    fn read(bytes: &[u8]) -> Result<(PointCloud, Vec<u32>), DatasetError> {
        let files = Files::new(&[("a.bin", bytes)]);
        files.columns(None).parse(Path::new("a.bin"), bytes).map(PositionedPoints::into_parts)
    }

    fn points(points: &[[f32; 4]]) -> Vec<u8> {
        points.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
    }

    #[track_caller]
    fn check_refused(bytes: &[u8], message: &str) {
        let error = read(bytes).expect_err("damaged");
        assert_eq!(error.to_string(), message);
        assert!(!error.is_usage_error());
    }

    #[test]
    fn points_come_out_as_they_went_in() {
        let (cloud, _) = read(&points(&[[1.0, -2.0, 3.5, 0.25], [4.0, 5.0, -6.0, 0.0]])).expect("sound");
        assert!(cloud.positions_m().eq([[1.0, -2.0, 3.5], [4.0, 5.0, -6.0]]));
        assert_eq!((cloud.intensity(), cloud.ring()), (&[0.25, 0.0][..], None));
    }

    #[test]
    fn scans_that_are_empty_or_cut_off_are_refused() {
        check_refused(&[], r#""a.bin" has no points"#);
        let cut_off = |n_bytes: usize| {
            format!(
                "\"a.bin\" is damaged or cut off: its {n_bytes} bytes are not a multiple of the 16 of a point"
            )
        };
        let bytes = points(&[[1.0; 4]; 3]);
        check_refused(&bytes[..41], &cut_off(41));
        check_refused(&[0; 7], &cut_off(7));
        // A whole number of values, which five columns would divide, too.
        let bytes = bytes_of(&drawn_scan(4000), |it| it[..4].to_vec());
        check_refused(&bytes[..60_020], &cut_off(60_020));
        let error = read(&bytes[..60]).expect_err("few numbers");
        assert!(error.to_string().ends_with("name its columns with --columns"), "{error}");
    }

    #[test]
    fn a_point_without_a_position_is_left_out() {
        let bytes =
            points(&[[1.0; 4], [1.0, f32::NAN, 1.0, 1.0], [2.0; 4], [1.0, 1.0, f32::NEG_INFINITY, 1.0]]);
        let (cloud, left_out) = read(&bytes).expect("sound");
        assert!(cloud.positions_m().eq([[1.0; 3], [2.0; 3]]), "{cloud:?}");
        assert_eq!(left_out, [1, 3]);
        check_refused(&bytes[16..32], r#""a.bin" has 1 points, but none with a position"#);
    }

    #[test]
    fn a_point_too_far_off_is_damage_with_its_index_and_value() {
        check_refused(
            &points(&[[1.0; 4], [1.0, 1.0, -12_000.5, 1.0]]),
            r#""a.bin" has point 1 at z = -12000.500 m, beyond 10000 m from the origin"#,
        );
    }

    /// The scan is read alike for any columns behind the first four.
    #[track_caller]
    fn check_read(row: impl Fn(&DrawnPoint) -> Vec<f32>, described: &str, has_ring: bool) {
        for n in [4000, 4096, 19_200] {
            let drawn = drawn_scan(n);
            let bytes = bytes_of(&drawn, &row);
            let files = Files::new(&[("a.bin", &bytes)]);
            let columns = files.columns(None);
            let (cloud, _) = columns.read(&files.paths()[0]).unwrap().into_parts();
            assert!(cloud.positions_m().eq(drawn.iter().map(|it| [it[0], it[1], it[2]])), "{n}");
            let intensities = drawn.iter().map(&row).map(|it| it[3]);
            if described.contains("intensity") {
                assert!(cloud.intensity().iter().copied().eq(intensities), "{n}");
            }
            assert_eq!(cloud.ring().is_some(), has_ring);
            assert_eq!(columns.described().unwrap().unwrap(), format!("{described}, as the numbers look"));
        }
    }

    #[test]
    fn columns_are_seen_and_named() {
        check_read(|it| it[..3].to_vec(), "x,y,z", false);
        check_read(|it| it[..4].to_vec(), "x,y,z,intensity", false);
        check_read(|it| it[..5].to_vec(), "x,y,z,intensity,ring", true);
        check_read(|it| it.to_vec(), "x,y,z,intensity,ring,_", true);
        check_read(
            |&[x, y, z, intensity, _, time]| vec![x, y, z, intensity, time],
            "x,y,z,intensity,_",
            false,
        );
        check_read(|&[x, y, z, _, ring, time]| vec![x, y, z, ring, time], "x,y,z,ring,_", true);
        check_read(|&[x, y, z, _, ring, _]| vec![x, y, z, ring], "x,y,z,ring", true);
        check_read(|&[x, y, z, ..]| vec![x, y, z, 0.0, 0.0], "x,y,z,intensity,_", false);
    }

    #[test]
    fn what_has_negative_numbers_is_no_intensity() {
        let row = |&[x, y, z, intensity, ..]: &DrawnPoint| vec![x, y, z, 0.5 - intensity];
        let files = Files::new(&[("a.bin", &bytes_of(&drawn_scan(19_200), row))]);
        assert_eq!(files.columns(None).described().unwrap().unwrap(), "x,y,z,_, as the numbers look");
    }

    #[track_caller]
    fn check_unclear(row: impl Fn(&DrawnPoint) -> Vec<f32>, part: &str) {
        let files = Files::new(&[("a.bin", &bytes_of(&drawn_scan(4096), row))]);
        let columns = files.columns(None);
        let error = columns.read(&files.paths()[0]).expect_err("nobody knows");
        let message = error.to_string();
        assert!(message.contains(part) && message.contains("--columns x,y,z,intensity,ring,_"), "{message}");
        assert!(error.is_usage_error());
        assert_eq!(columns.described().expect_err("nobody knows").to_string(), message);
    }

    #[test]
    fn what_cannot_be_is_refused_until_the_user_says_what_it_is() {
        let intensity_first = |&[x, y, z, intensity, ..]: &DrawnPoint| vec![intensity, x, y, z];
        check_unclear(
            intensity_first,
            "negative numbers in column 4, where the intensity is, and none in column 1",
        );
        let ring_first = |&[x, y, z, intensity, ring, _]: &DrawnPoint| vec![ring, x, y, z, intensity];
        check_unclear(ring_first, "has whole numbers only in column 1, which cannot be x");
        let drawn = drawn_scan(4096);
        let files = Files::new(&[("a.bin", &bytes_of(&drawn, ring_first))]);
        let columns = files.columns(Some("ring,x,y,z,intensity"));
        let (cloud, _) = columns.read(&files.paths()[0]).unwrap().into_parts();
        assert!(cloud.positions_m().eq(drawn.iter().map(|it| [it[0], it[1], it[2]])));
        assert_eq!((cloud.intensity()[7], cloud.ring().unwrap()[7]), (drawn[7][3], 7));
        assert_eq!(columns.described().unwrap().unwrap(), "ring,x,y,z,intensity, as you say");
    }

    #[test]
    fn a_scan_with_other_columns_than_the_rest_is_refused() {
        let drawn = drawn_scan(4096);
        let (four, five) = (bytes_of(&drawn, |it| it[..4].to_vec()), bytes_of(&drawn, |it| it[..5].to_vec()));
        let files = Files::new(&[("a.bin", &five), ("b.bin", &five), ("c.bin", &five), ("d.bin", &four)]);
        let columns = files.columns(None);
        assert!(columns.read(&files.paths()[2]).is_ok());
        let error = columns.read(&files.paths()[3]).expect_err("others");
        assert!(
            error.to_string().contains("looks like 4 numbers for each point, where the data set has 5"),
            "{error}"
        );
        assert!(!error.is_usage_error());
    }

    #[test]
    fn arrays_say_how_many_columns_they_have() {
        let npy = |row: &dyn Fn(&DrawnPoint) -> Vec<f32>| {
            let rows = bytes_of(&drawn_scan(2000), row);
            let n_columns = rows.len() / 8000;
            let header =
                format!("{{'descr': '<f4', 'fortran_order': False, 'shape': (2000, {n_columns}), }}");
            [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &rows]
                .concat()
        };
        let described = |bytes: &[u8]| Files::new(&[("a.npy", bytes)]).columns(None).described();
        assert_eq!(
            described(&npy(&|it| it.to_vec())).unwrap().unwrap(),
            "x,y,z,intensity,ring,_, as the numbers look"
        );
        let ring_first = npy(&|&[x, y, z, _, ring, _]| vec![ring, x, y, z]);
        assert!(described(&ring_first).expect_err("unclear").to_string().contains("cannot be x"));
        let files = Files::new(&[("a.npy", &ring_first)]);
        let (cloud, _) = files.columns(Some("ring,x,y,z")).read(&files.paths()[0]).unwrap().into_parts();
        assert_eq!((cloud.len(), cloud.ring().unwrap()[5]), (2000, 5));
        let error = files.columns(Some("x,y,z")).read(&files.paths()[0]).expect_err("one too few");
        assert!(error.to_string().contains("has 4 columns, but x,y,z are 3"), "{error}");
    }

    proptest! {
        #[test]
        fn any_bytes_give_their_points_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            if let Ok((cloud, left_out)) = read(&bytes) {
                prop_assert_eq!((cloud.len() + left_out.len()) * 16, bytes.len());
                prop_assert!(cloud.positions_m().flatten().all(f32::is_finite));
            }
        }
    }
}
