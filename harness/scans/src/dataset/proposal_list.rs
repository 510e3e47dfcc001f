//! Boxes that a detector proposed as labels: a list beside the labels, by which uncorrected labels are recognised.

use std::collections::BTreeSet;
use std::path::Path;

use detector::OrientedBox;

use super::DatasetError;
use super::on_disk::is_there;
use super::text_file::read_text_file;

/// The name of the list in the folder of a project.
pub const PROPOSALS_CSV: &str = "proposals.csv";

const HEADER: &str = "center_x_m,center_y_m,center_z_m,length_m,width_m,height_m";

/// Boxes to the centimetre, of all scans together.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ProposalList {
    lines: BTreeSet<String>,
}

impl ProposalList {
    /// The list in the folder of a data set, if there is one.
    pub fn in_folder(folder: &Path) -> Result<Option<Self>, DatasetError> {
        let path = folder.join(PROPOSALS_CSV);
        if !is_there(&path) {
            return Ok(None);
        }
        let lines = read_text_file(&path)?.lines().skip(1).map(str::to_owned).collect();
        Ok(Some(Self { lines }))
    }

    /// Adds a proposed box.
    pub fn add(&mut self, proposed: &OrientedBox) {
        self.lines.insert(line_of(proposed));
    }

    /// Whether `labelled` is as proposed, apart from its yaw.
    pub fn contains(&self, labelled: &OrientedBox) -> bool {
        self.lines.contains(&line_of(labelled))
    }

    /// The list as a file.
    pub fn to_csv(&self) -> String {
        let lines = self.lines.iter().map(String::as_str);
        [HEADER].into_iter().chain(lines).collect::<Vec<_>>().join("\n") + "\n"
    }
}

fn line_of(bounding_box: &OrientedBox) -> String {
    let numbers = bounding_box.center_m.into_iter().chain(bounding_box.length_width_height_m);
    // No minus zero.
    let rounded = numbers.map(|it| format!("{:.2}", (f64::from(it) * 100.0).round() / 100.0 + 0.0));
    rounded.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_recognised_until_it_is_moved() {
        let at = |x_m| OrientedBox {
            center_m: [x_m, -0.001, 1.0],
            length_width_height_m: [4.0, 1.8, 1.5],
            yaw_rad: 0.1,
        };
        let mut list = ProposalList::default();
        list.add(&at(3.1));
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(ProposalList::in_folder(folder.path()).unwrap(), None);
        std::fs::write(folder.path().join(PROPOSALS_CSV), list.to_csv()).unwrap();
        let read = ProposalList::in_folder(folder.path()).unwrap().unwrap();
        assert_eq!(read, list);
        assert!(read.contains(&at(3.1001)) && !read.contains(&at(3.12)));
    }
}
