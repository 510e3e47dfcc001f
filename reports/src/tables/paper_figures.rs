//! The figures that the papers print, to stand beside ours.
//!
//! HG: Fast 3-D Urban Object Detection on Streaming Point Clouds. VM: A Model-based Approach for Fast Vehicle
//! Detection in Continuously Streamed Urban LIDAR Point Clouds.

use crate::vocabulary::task::Task;

/// Table 1 of a paper.
#[derive(Debug, PartialEq)]
pub struct PaperTable {
    /// The task that it is about.
    pub task: Task,
    /// Where it is printed.
    pub source: &'static str,
    /// The two methods that it compares.
    pub methods: [PaperMethod; 2],
    /// Its rows, the overall one last.
    pub rows: &'static [PaperRow],
}

/// A method of a paper.
#[derive(Debug, PartialEq)]
pub struct PaperMethod {
    /// Its name in the paper.
    pub name: &'static str,
    /// Our detector that does what the paper describes.
    pub detector: &'static str,
}

/// A row of [`PaperTable`].
#[derive(Debug, PartialEq)]
pub struct PaperRow {
    /// Name of the data set in the paper.
    pub name: &'static str,
    /// Where it was recorded.
    pub recordings: Recordings,
    /// NO, the number of annotated objects.
    pub no: u32,
    /// The score of each of [`PaperTable::methods`].
    pub scores: [PaperScore; 2],
}

/// Where the scans of a paper were recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recordings {
    /// In the streets of Budapest; not public.
    Budapest,
    /// In and around Karlsruhe, for the KITTI benchmark.
    Kitti,
    /// Both.
    Both,
}

/// The score of a method on a data set, as printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperScore {
    /// F-rate in percent.
    pub f_rate_percent: f64,
    /// Scans per second.
    pub fps: f64,
}

/// A step of a paper's method, timed there.
#[derive(Debug, PartialEq)]
pub struct PaperStep {
    /// Its name in the paper.
    pub name: &'static str,
    /// How long it takes there, in milliseconds.
    pub ms: f64,
    /// The stages of [`PAPER_DETECTOR`] that do it.
    pub stages: &'static [&'static str],
}

/// Our detector that is the papers' own method to the letter. No other has the papers' results beside it: a method of no
/// paper has none.
pub const PAPER_DETECTOR: &str = "paper";

/// The steps of the model-based approach.
///
/// Paper: VM section 6, last paragraph.
pub const VEHICLE_STEPS: &[PaperStep] = &[
    PaperStep { name: "grid", ms: 13.0, stages: &["grid"] },
    PaperStep { name: "segmentation", ms: 4.0, stages: &["ground", "walls", "foreground"] },
    PaperStep { name: "separation", ms: 6.0, stages: &["dense_level", "merge", "separation"] },
    PaperStep { name: "features", ms: 18.0, stages: &["boxes", "features"] },
    PaperStep { name: "SVM", ms: 2.0, stages: &["classification"] },
];

/// The papers' tables, one a task.
pub const PAPER_TABLES: &[PaperTable] = &[OBJECTS, VEHICLES];

/// Paper: HG section 5, table 1.
const OBJECTS: PaperTable = PaperTable {
    task: Task::Objects,
    source: "Börcs, Nagy, Benedek: Fast 3-D Urban Object Detection on Streaming Point Clouds, table 1",
    methods: [
        PaperMethod { name: "connected component analysis", detector: "kd-tree" },
        PaperMethod { name: "hierarchical grid", detector: PAPER_DETECTOR },
    ],
    rows: &[
        row("Budapest #1", Recordings::Budapest, 669, [score(77.0, 0.38), score(89.0, 29.0)]),
        row("Budapest #2", Recordings::Budapest, 429, [score(64.0, 0.22), score(79.0, 25.0)]),
        row("KITTI", Recordings::Kitti, 496, [score(75.0, 0.46), score(82.0, 29.0)]),
        row("overall", Recordings::Both, 1594, [score(72.0, 0.35), score(83.0, 28.0)]),
    ],
};

/// Paper: VM section 6, table 1.
const VEHICLES: PaperTable = PaperTable {
    task: Task::Vehicles,
    source: "Börcs, Nagy, Baticz, Benedek: A Model-based Approach for Fast Vehicle Detection in Continuously \
             Streamed Urban LIDAR Point Clouds, table 1",
    methods: [
        PaperMethod { name: "PCA based approach", detector: "pca" },
        PaperMethod { name: "model-based approach", detector: PAPER_DETECTOR },
    ],
    rows: &[
        row("Budapest #1", Recordings::Budapest, 567, [score(73.0, 15.0), score(89.0, 24.0)]),
        row("Budapest #2", Recordings::Budapest, 1141, [score(71.0, 12.0), score(90.0, 21.0)]),
        row("Budapest #3", Recordings::Budapest, 368, [score(57.0, 13.0), score(80.0, 22.0)]),
        row("KITTI", Recordings::Kitti, 614, [score(62.0, 14.0), score(78.0, 25.0)]),
        row("overall", Recordings::Both, 2690, [score(68.0, 13.5), score(86.0, 23.0)]),
    ],
};

const fn row(name: &'static str, recordings: Recordings, no: u32, scores: [PaperScore; 2]) -> PaperRow {
    PaperRow { name, recordings, no, scores }
}

const fn score(f_rate_percent: f64, fps: f64) -> PaperScore {
    PaperScore { f_rate_percent, fps }
}

impl PaperTable {
    /// The score in `row` of the paper's counterpart of `detector`; `None` if the paper has none.
    pub fn score_beside(&self, row: &PaperRow, detector: &str) -> Option<PaperScore> {
        let method_idx = self.methods.iter().position(|it| it.detector == detector)?;
        Some(row.scores[method_idx])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_of_the_rows_add_up_to_the_overall_row() {
        for table in PAPER_TABLES {
            let (overall, datasets) = table.rows.split_last().unwrap();
            assert_eq!(overall.recordings, Recordings::Both);
            assert_eq!(datasets.iter().map(|it| it.no).sum::<u32>(), overall.no, "{}", table.task);
        }
    }

    #[test]
    fn overall_figures_lie_between_those_of_the_rows() {
        for table in PAPER_TABLES {
            let (overall, datasets) = table.rows.split_last().unwrap();
            for method_idx in 0..2 {
                for figure in [|it: PaperScore| it.f_rate_percent, |it: PaperScore| it.fps] {
                    let of_rows = datasets.iter().map(|it| figure(it.scores[method_idx]));
                    let (low, high) =
                        of_rows.fold((f64::INFINITY, 0.0_f64), |(low, high), it| (low.min(it), high.max(it)));
                    assert!((low..=high).contains(&figure(overall.scores[method_idx])), "{}", table.task);
                }
            }
        }
    }
}
