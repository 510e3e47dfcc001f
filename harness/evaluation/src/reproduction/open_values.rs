//! The values that the papers use but do not state.

/// A parameter of `paper`, or of a rival, that the papers leave open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenValue {
    /// Its full name.
    pub parameter: &'static str,
    /// Statements of the papers about it, with their sections.
    pub said: &'static str,
    /// Its possible values.
    pub range: OpenRange,
}

/// The values that agree with a paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OpenRange {
    /// Numbers between these.
    Numbers {
        /// The least.
        low: f64,
        /// The greatest.
        high: f64,
        /// Whether only whole numbers count.
        is_whole: bool,
        /// Whether the scale is logarithmic.
        is_log: bool,
    },
    /// One of several words.
    Words(&'static [&'static str]),
}

const fn numbers(low: f64, high: f64) -> OpenRange {
    OpenRange::Numbers { low, high, is_whole: false, is_log: false }
}

const fn whole(low: f64, high: f64) -> OpenRange {
    OpenRange::Numbers { low, high, is_whole: true, is_log: false }
}

const fn ratios(low: f64, high: f64) -> OpenRange {
    OpenRange::Numbers { low, high, is_whole: false, is_log: true }
}

/// All open values of `paper`, in the order of the stages; the criterion of matching last.
pub const OPEN_VALUES: [OpenValue; 13] = [
    OpenValue {
        parameter: "paper.terrain.low_quantile",
        said: "VM 3: \"a globally estimated digital terrain map\", no method",
        range: numbers(0.05, 0.5),
    },
    OpenValue {
        parameter: "paper.ground.min_points",
        said: "HG 3.1: clutter has fewer than \"typically 4-8\" points",
        range: whole(4.0, 8.0),
    },
    OpenValue {
        parameter: "paper.ground.ground_band_m",
        said: "HG 3.1: the mean elevation around a ground cell lies in \"an allowed height range\"",
        range: numbers(0.1, 0.8),
    },
    OpenValue {
        parameter: "paper.walls.min_support",
        said: "HG 3.1: long line segments are walls; no share of tall cells along them",
        range: ratios(0.01, 1.0),
    },
    OpenValue {
        parameter: "paper.walls.hough.min_votes",
        said: "HG 3.1: a Hough transform, no threshold",
        range: whole(4.0, 20.0),
    },
    OpenValue {
        parameter: "paper.walls.hough.min_length_cells",
        said: "HG 3.1: \"long\" segments, no length",
        range: whole(6.0, 30.0),
    },
    OpenValue {
        parameter: "paper.walls.hough.max_gap_cells",
        said: "HG 3.1: no limit of gaps in a segment",
        range: whole(0.0, 5.0),
    },
    OpenValue {
        parameter: "paper.merge.max_height_difference_m",
        said: "HG 3.2: neighbours of heights that differ by less than ψ are one object; ψ is not stated",
        range: ratios(0.2, 3.0),
    },
    OpenValue {
        parameter: "paper.separation.low_density_share",
        said: "HG 3.2: dense cells of \"low\" density separate objects; no limit",
        range: numbers(0.0, 0.8),
    },
    OpenValue {
        parameter: "paper.separation.object_density_ratio",
        said: "HG 3.2, 4: low compared with which density is not stated",
        range: ratios(0.5, 10.0),
    },
    OpenValue {
        parameter: "paper.separation.single_gap_points",
        said: "HG 4: how far the density weights gaps is not stated",
        range: ratios(0.1, 10.0),
    },
    OpenValue {
        parameter: "paper.cluster.min_points",
        said: "the smallest object is not stated",
        range: OpenRange::Numbers { low: 5.0, high: 60.0, is_whole: true, is_log: true },
    },
    OpenValue {
        parameter: "matching.criterion",
        said: "HG 5, VM 6: \"non-ambiguous assignment\"; neither what is compared nor how near it has to be",
        range: OpenRange::Words(&["points", "centre", "bev-iou"]),
    },
];

/// Readings of the structure of `paper`, from text or figures of HG and VM; searched together with [`OPEN_VALUES`].
const OPEN_READINGS: [OpenValue; 6] = [
    OpenValue {
        parameter: "paper.ground.fewer_far_away",
        said: "HG 4: weights of coarse and dense cells; HG 3.1 does not say whether clutter is weighted, too",
        range: OpenRange::Words(&["false", "true"]),
    },
    OpenValue {
        parameter: "paper.ground.tall_over",
        said: "HG 3.1: 1.40 m over the sensor; VM 3: elevations over a terrain map",
        range: OpenRange::Words(&["level_road", "terrain"]),
    },
    OpenValue {
        parameter: "paper.foreground.clearance_m",
        said: "HG 3.1: all points of a cell have one class; HG figs. 1, 3, 8: the road around an object is not the object",
        range: OpenRange::Words(&["-inf", "0.1", "0.15", "0.2"]),
    },
    OpenValue {
        parameter: "paper.walls.beside",
        said: "HG 3.1: cells that fit a line; whether those beside it do is not stated",
        range: OpenRange::Words(&["false", "true"]),
    },
    OpenValue {
        parameter: "paper.separation.min_contacts",
        said: "HG Fig. 4: several near-empty cells divide; how many that touch hold together is not stated",
        range: OpenRange::Words(&["1", "2", "3"]),
    },
    OpenValue {
        parameter: "paper.outline.min_points",
        said: "VM 4: boundary cells hold several points",
        range: OpenRange::Words(&["1", "2", "3"]),
    },
];

/// Open values of the rival of HG.
const KD_TREE_VALUES: [OpenValue; 3] = [
    OpenValue {
        parameter: "kd_tree.tolerance_m",
        said: "HG 5: connected components over a kd-tree of PCL, no tolerance",
        range: ratios(0.1, 1.5),
    },
    OpenValue {
        parameter: "kd_tree.min_points",
        said: "the smallest object is not stated",
        range: OpenRange::Numbers { low: 5.0, high: 60.0, is_whole: true, is_log: true },
    },
    OpenValue {
        parameter: "kd_tree.foreground",
        said: "HG 5: neither which points are clustered",
        range: OpenRange::Words(&["short", "refined", "standing"]),
    },
];

/// Open values of the rival of VM.
const PCA_VALUES: [OpenValue; 5] = [
    OpenValue {
        parameter: "pca.grid.cell_size_m",
        said: "VM 6: a 2-D occupancy grid, no cell size",
        range: ratios(0.15, 1.0),
    },
    OpenValue {
        parameter: "pca.occupancy.min_height_difference_m",
        said: "VM 6: what makes a cell occupied is not stated",
        range: numbers(0.05, 0.6),
    },
    OpenValue {
        parameter: "pca.occupancy.min_points",
        said: "VM 6: what makes a cell occupied is not stated",
        range: whole(1.0, 6.0),
    },
    OpenValue {
        parameter: "pca.cluster.min_points",
        said: "the smallest object is not stated",
        range: OpenRange::Numbers { low: 5.0, high: 60.0, is_whole: true, is_log: true },
    },
    OpenValue {
        parameter: "pca.cluster.max_extent_m",
        said: "the largest object is not stated",
        range: numbers(8.0, 30.0),
    },
];

/// The open values of a detector of the papers, without the criterion of matching; empty for any other detector.
pub fn open_values_of(detector: &str) -> &'static [OpenValue] {
    match detector {
        "paper" => &OPEN_VALUES[..OPEN_VALUES.len() - 1],
        "kd-tree" => &KD_TREE_VALUES,
        "pca" => &PCA_VALUES,
        _ => &[],
    }
}

/// Values to choose for a detector of the papers: its open values and, for `paper`, readings of its structure.
pub fn chosen_values_of(detector: &str) -> Vec<OpenValue> {
    let readings = if detector == "paper" { &OPEN_READINGS[..] } else { &[] };
    open_values_of(detector).iter().chain(readings).copied().collect()
}

impl OpenRange {
    /// The value at a share of the range, 0 to 1, as text.
    pub fn at(self, share: f64) -> String {
        match self {
            Self::Words(words) => {
                words[((share * words.len() as f64) as usize).min(words.len() - 1)].to_owned()
            }
            Self::Numbers { low, high, is_whole: true, is_log } => {
                // Each whole number has an equal part of the range.
                let number = if is_log {
                    low * ((high + 1.0) / low).powf(share)
                } else {
                    low + share * (high + 1.0 - low)
                };
                format!("{}", number.floor().clamp(low, high))
            }
            Self::Numbers { low, high, is_whole: false, is_log } => {
                let number = if is_log { low * (high / low).powf(share) } else { low + share * (high - low) };
                format!("{number:.3}")
            }
        }
    }
}

/// For example `4 to 8`, or `points, centre, bev-iou`.
impl std::fmt::Display for OpenRange {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Numbers { low, high, .. } => write!(formatter, "{low} to {high}"),
            Self::Words(words) => formatter.write_str(&words.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::config::RunConfig;

    #[test]
    fn ranges_hold_the_shipped_values_and_are_parameters() {
        let config = RunConfig::load(None).unwrap();
        let of_detectors = ["paper", "kd-tree", "pca"].into_iter().flat_map(chosen_values_of);
        for OpenValue { parameter, range, .. } in OPEN_VALUES.into_iter().chain(of_detectors) {
            let shipped = config.value_of(parameter).expect(parameter);
            match range {
                OpenRange::Words(words) => {
                    let written = shipped.to_string();
                    assert!(words.contains(&written.trim_matches('"')), "{parameter} is {written}");
                }
                OpenRange::Numbers { low, high, .. } => {
                    let number = shipped.as_float().or(shipped.as_integer().map(|it| it as f64)).unwrap();
                    assert!((low..=high).contains(&number), "{parameter} is {number}");
                }
            }
        }
    }

    #[test]
    fn shares_reach_from_one_end_to_the_other() {
        assert_eq!([0.0, 0.5, 0.999].map(|it| whole(4.0, 8.0).at(it)), ["4", "6", "8"]);
        assert_eq!([0.0, 0.5, 1.0].map(|it| numbers(0.1, 0.8).at(it)), ["0.100", "0.450", "0.800"]);
        assert_eq!([0.0, 0.5, 1.0].map(|it| ratios(0.01, 1.0).at(it)), ["0.010", "0.100", "1.000"]);
        assert_eq!([0.0, 0.4, 0.999].map(|it| OpenRange::Words(&["a", "b", "c"]).at(it)), ["a", "b", "c"]);
    }
}
