//! Classes that programs of others predicted for partly seen objects.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::files::archive::ArchiveError;
use crate::files::csv_rows::{read_rows, row};
use crate::rows::partial_row::{Answer, PartialRow, Predicted};
use crate::vocabulary::partial_class::PartialClass;

row! {
    /// A row of the table that another program leaves.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct PeerRow {
        object: String,
        class: String,
        from: String,
        step: u32,
        n_points: usize,
        predicted: String,
    }
}

/// Error of a table of another program that cannot be compared with ours.
#[derive(Debug, thiserror::Error)]
pub enum PeerError {
    /// The table cannot be read.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// The predicted class is unknown.
    #[error("{path:?}, line {line}: {predicted:?} is no class")]
    UnknownClass {
        /// The file.
        path: PathBuf,
        /// The line.
        line: usize,
        /// The class in the file.
        predicted: String,
    },
    /// A part has another number of points than ours.
    #[error(
        "{path:?}, line {line}: {object} at step {step} from {from} has {found} points, but here it has {expected}"
    )]
    Points {
        /// The file.
        path: PathBuf,
        /// The line.
        line: usize,
        /// The object.
        object: String,
        /// The end from which it is seen.
        from: String,
        /// The step.
        step: u32,
        /// Number of points in the table.
        found: usize,
        /// Number of points in our rows.
        expected: usize,
    },
    /// The table lacks a part.
    #[error("{path:?} says nothing of {object} at step {step} from {from}")]
    Missing {
        /// The file.
        path: PathBuf,
        /// The object.
        object: String,
        /// The end from which it is seen.
        from: String,
        /// The step.
        step: u32,
    },
}

/// Training data of programs of others, as rows name it.
pub const ELSEWHERE: &str = "elsewhere";

/// A row of `method` for each part in `ours`, from its results in the file at `path`. `class_of` returns the class that a
/// word stands for. Other rows of the file are ignored.
///
/// # Errors
///
/// [`PeerError`] if the file cannot be read, lacks a part, has another number of points for it or an unknown class.
pub fn read_peer_rows(
    path: &Path,
    method: &str,
    ours: &[PartialRow],
    class_of: impl Fn(&str) -> Option<PartialClass>,
) -> Result<Vec<PartialRow>, PeerError> {
    let mut said: BTreeMap<(String, String, u32), (usize, PeerRow)> = BTreeMap::new();
    for (row, line) in read_rows::<PeerRow>(path)?.into_iter().zip(2..) {
        said.insert((row.object.clone(), row.from.clone(), row.step), (line, row));
    }
    let mut rows: Vec<PartialRow> = Vec::new();
    let mut done = BTreeSet::new();
    for part in ours {
        let part_key = (part.object.clone(), part.direction.clone(), part.step);
        if !done.insert(part_key.clone()) {
            continue;
        }
        let (path, from) = (path.to_path_buf(), part.direction.clone());
        // Simulated objects are written as files of this name.
        let as_file = (format!("{}/{}.npy", part.true_class, part.object), part.direction.clone(), part.step);
        let Some((line, row)) = said.get(&part_key).or_else(|| said.get(&as_file)) else {
            return Err(PeerError::Missing { path, object: part.object.clone(), from, step: part.step });
        };
        if row.n_points != part.n_points() {
            let (object, step) = (part.object.clone(), part.step);
            let [found, expected] = [row.n_points, part.n_points()];
            return Err(PeerError::Points { path, line: *line, object, from, step, found, expected });
        }
        let predicted = match (row.predicted.as_str(), class_of(&row.predicted)) {
            ("", _) => Predicted::NotJudged,
            (_, Some(class)) => class.into(),
            (predicted, None) => {
                return Err(PeerError::UnknownClass { path, line: *line, predicted: predicted.to_owned() });
            }
        };
        let answer = Answer { predicted, errors: [None; 5], chances: [None; 5] };
        rows.push(part.predicted_by(method, ELSEWHERE, &answer));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;
    use crate::partial_study::partial_curves::tests::rows;

    fn read(content: &str) -> Result<Vec<PartialRow>, PeerError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("esf.csv");
        std::fs::write(&path, content).unwrap();
        let class_of = |word: &str| {
            if word == "poles" { Some(PartialClass::Pole) } else { PartialClass::from_name(word) }
        };
        read_peer_rows(&path, "esf", &rows(), class_of)
    }

    /// All three objects at three steps, as the rows of the tests have them.
    fn table() -> String {
        let mut text = "object,class,from,step,n_points,predicted\n".to_owned();
        for (object, predicted) in
            [("tree/a.npy", "tree"), ("tree/b.npy", ""), ("c", "poles"), ("car/d.npy", "car")]
        {
            for step in 1..=3 {
                writeln!(text, "{object},x,below,{step},9,{predicted}").unwrap();
            }
        }
        text
    }

    #[test]
    fn rows_of_others_are_those_of_the_same_parts() {
        let found = read(&table()).unwrap();
        assert_eq!(found.len(), 9);
        let predicted = |object: &str| found.iter().find(|it| it.object == object).map(|it| it.predicted);
        assert_eq!(
            [predicted("a"), predicted("b"), predicted("c")],
            [Some(Predicted::Tree), Some(Predicted::NotJudged), Some(Predicted::Pole)]
        );
        assert!(found.iter().all(|it| it.method == "esf" && it.trained_on == ELSEWHERE));
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        assert!(table().contains(from));
        let error = read(&table().replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }

    #[test]
    fn other_points_missing_parts_and_unknown_words_are_refused_with_their_line() {
        check_refused(
            "a.npy,x,below,2,9",
            "a.npy,x,below,2,8",
            "line 3: a at step 2 from below has 8 points, but here it has 9",
        );
        check_refused("b.npy,x,below,3,9", "b.npy,x,below,4,9", "says nothing of b at step 3 from below");
        check_refused("poles\n", "boat\n", "line 8: \"boat\" is no class");
        check_refused("n_points", "points", "has the columns");
        check_refused("below,1,9", "below,one,9", "bad row");
    }
}
