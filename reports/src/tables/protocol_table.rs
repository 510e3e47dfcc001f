//! The tables of numbers under protocols of others: one for each protocol, with a column for each detector.

use std::collections::BTreeSet;

use crate::numbers::pools::Pool;
use crate::protocols::drawn_scans::N_PROTOCOL_RESAMPLES;
use crate::protocols::protocol_number::{ALL_CLASSES, PRESENT_CLASSES, ProtocolNumber};
use crate::protocols::protocol_report::ProtocolReport;
use crate::run_folder::manifest::{DatasetEntry, Manifest};
use crate::tables::grid::{Cell, Column, Grid, Line, LineKind};
use crate::tables::notes::{INTERVAL_TITLE, about_interval_of};
use crate::tables::protocol_in_short::number_cells;
use crate::tables::sheet::{Sheet, Tabular};
use crate::tables::task_grids::extent_cell;
use crate::vocabulary::extent::Extent;
use crate::vocabulary::origin::Origin;
use crate::vocabulary::protocol::Protocol;

/// The numbers of a run under one protocol.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolTable<'a> {
    /// The protocol.
    pub protocol: Protocol,
    numbers: Vec<&'a ProtocolNumber>,
    // Number of the protocol's numbers that are left out.
    n_left_out: usize,
    manifest: &'a Manifest,
}

/// Which numbers a table has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProtocolLines {
    /// The few that stand in the short form: see [`ProtocolNumber::is_in_short_form`].
    Short,
    /// All.
    Every,
}

impl<'a> ProtocolTable<'a> {
    /// The tables of `report`, in the order of protocols.
    pub fn all(report: &'a ProtocolReport, manifest: &'a Manifest, lines: ProtocolLines) -> Vec<Self> {
        let of_protocol = |protocol: Protocol| {
            let of_protocol = report.rows.iter().filter(|it| it.protocol == protocol);
            let is_shown = |it: &&ProtocolNumber| lines == ProtocolLines::Every || it.is_in_short_form();
            let (numbers, left_out): (Vec<_>, Vec<_>) = of_protocol.partition(is_shown);
            Self { protocol, numbers, n_left_out: left_out.len(), manifest }
        };
        let tables = Protocol::ALL.into_iter().map(of_protocol);
        tables.filter(|it| !it.numbers.is_empty()).collect()
    }

    /// Whether some numbers are left out.
    pub fn is_short(&self) -> bool {
        self.n_left_out > 0
    }

    /// Name of its files without ending.
    pub fn file_stem(&self) -> String {
        let form = if self.is_short() { "_short" } else { "" };
        format!("{}{form}", self.stem_of_all())
    }

    fn stem_of_all(&self) -> String {
        format!("table_protocol_{}", self.protocol.name())
    }

    /// Its numbers, in the order of `protocols.json`.
    pub(crate) fn numbers(&self) -> &[&'a ProtocolNumber] {
        &self.numbers
    }

    fn detectors(&self) -> Vec<&str> {
        let names = self.manifest.detectors.iter().map(|it| it.name.as_str());
        names.filter(|name| self.numbers.iter().any(|it| it.detector == *name)).collect()
    }

    /// The values alone of all data sets of `pool` together.
    pub(crate) fn values_of(&self, pool: &Pool) -> Grid {
        let numbers = self.numbers.iter().copied().filter(|it| it.dataset == pool.extent.name()).collect();
        let mut grid = Self { numbers, ..self.clone() }.grid(false);
        grid.columns.remove(0);
        for line in &mut grid.lines {
            line.cells.remove(0);
            line.kind = LineKind::Detail;
        }
        grid
    }

    fn grid(&self, has_intervals: bool) -> Grid {
        let detectors = self.detectors();
        let mut columns = ["data set", "class", "metric"].map(Column::left).to_vec();
        columns.push(Column::number("n"));
        for detector in &detectors {
            if has_intervals {
                columns.push(Column::number("value").within(*detector));
                columns.push(Column::number("95 %").within(*detector));
            } else {
                columns.push(Column::number((*detector).to_owned()));
            }
        }
        let mut lines: Vec<Line> = Vec::new();
        let (mut before, mut n_before) = (None, None);
        for first in self.firsts() {
            let class = first.metric.class.as_str();
            let is_new_dataset = before.is_none_or(|(dataset, _)| dataset != first.dataset);
            let is_new_class = before != Some((first.dataset.as_str(), class));
            let is_new_n = is_new_class || n_before != Some(first.metric.n);
            (before, n_before) = (Some((first.dataset.as_str(), class)), Some(first.metric.n));
            let label = if is_new_dataset { self.extent_cell(&first.dataset) } else { Cell::default() };
            let class = if is_new_class { Cell::new(class) } else { Cell::default() };
            let n = if is_new_n { Cell::new(first.metric.n.to_string()) } else { Cell::default() };
            let mut cells = vec![label, class, Cell::new(first.metric.id.as_str()), n];
            for detector in &detectors {
                let number = self.numbers.iter().find(|it| {
                    let is_same = it.metric.class == first.metric.class && it.metric.id == first.metric.id;
                    is_same && it.dataset == first.dataset && it.detector == *detector
                });
                let of_number =
                    number.map_or_else(|| [Cell::new("–"), Cell::default()], |it| number_cells(it));
                cells.extend(of_number.into_iter().take(1 + usize::from(has_intervals)));
            }
            let kind = match (is_new_dataset, first.dataset.as_str()) {
                (false, _) => LineKind::Detail,
                (true, dataset) if self.pool(dataset).is_some() => LineKind::Overall,
                (true, _) => LineKind::Dataset,
            };
            lines.push(Line { kind, cells });
        }
        Grid { columns, lines }
    }

    /// One number of each metric of each data set: that of the first detector that has it.
    fn firsts(&self) -> Vec<&ProtocolNumber> {
        let mut seen = BTreeSet::new();
        let key = |it: &ProtocolNumber| (it.dataset.clone(), it.metric.class.clone(), it.metric.id.clone());
        self.numbers.iter().copied().filter(|it| seen.insert(key(it))).collect()
    }

    fn extent_cell(&self, dataset: &str) -> Cell {
        if let Some(pool) = self.pool(dataset) {
            return extent_cell(&pool.extent, pool.origin);
        }
        let entry = self.manifest.datasets.iter().find(|it| it.id == dataset);
        let origin = entry.map_or(Origin::Recorded, DatasetEntry::origin);
        extent_cell(&Extent::Dataset(dataset.to_owned()), origin)
    }

    /// The pool of several data sets with this name.
    fn pool(&self, name: &str) -> Option<Pool> {
        self.manifest.pools().into_iter().find(|it| it.is_of_several() && it.extent.name() == name)
    }

    fn sentences(&self) -> Vec<String> {
        let kind = self.numbers.iter().find_map(|it| it.interval).map(|it| it.blocks.kind);
        let about_intervals =
            kind.map(|it| format!("{INTERVAL_TITLE}: {}", about_interval_of(N_PROTOCOL_RESAMPLES, it)));
        let has_classes = self.numbers.iter().any(|it| it.metric.class == PRESENT_CLASSES);
        let about_classes = has_classes.then(|| {
            format!(
                "{ALL_CLASSES}: the mean over all classes, as the makers have it; classes without annotations count as not found. \
                 {PRESENT_CLASSES}: over classes with annotations, and errors that are known."
            )
        });
        let has_gaps = self.numbers.iter().any(|it| it.value.is_none());
        let about_gaps = has_gaps.then(|| "–: no annotation that it could be of, or not known.".to_owned());
        let more = self.is_short().then(|| format!("All numbers: {}.md.", self.stem_of_all()));
        let remark = Some(self.protocol.family().remark().to_owned());
        [about_classes, remark, about_gaps, about_intervals, more].into_iter().flatten().collect()
    }
}

impl Tabular for ProtocolTable<'_> {
    fn sheet(&self) -> Sheet {
        let title = format!("Protocol {}. n: {}.", self.protocol, self.protocol.family().counted());
        Sheet::of(title, self.grid(true), self.sentences())
            .labelled(&self.file_stem().replacen("table_", "", 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::blocks::{BlockCount, BlockKind, Interval};
    use crate::protocols::protocol_number::ProtocolMetric;
    use crate::tables::formats::format::Format as _;
    use crate::tables::formats::lists::protocol_formats;
    use crate::tables::formats::terminal::Terminal;
    use crate::tables::sample;
    use crate::vocabulary::metric::Direction;

    fn report() -> ProtocolReport {
        let number = |detector: &str, class: &str, id: &str, value: Option<f64>| {
            let blocks = BlockCount::of_dataset(12, BlockKind::Seconds);
            ProtocolNumber {
                protocol: Protocol::Nuscenes,
                dataset: "main_road".to_owned(),
                detector: detector.to_owned(),
                metric: ProtocolMetric {
                    class: class.to_owned(),
                    id: id.to_owned(),
                    unit: "ratio",
                    direction: Direction::HigherIsBetter,
                    n: 41,
                },
                value,
                interval: value.map(|it| Interval { ends: [it - 0.1, it + 0.1], blocks }),
            }
        };
        let of_detector = |name: &str, value: Option<f64>| {
            [
                number(name, "all", "ap", value),
                number(name, "present", "nds", Some(0.5)),
                number(name, "car", "ap", value),
            ]
        };
        let rows = [of_detector("paper", Some(0.25)), of_detector("pca", None)];
        ProtocolReport::new(rows.concat())
    }

    #[test]
    fn a_short_table_has_no_classes_and_a_long_one_all() {
        let (report, manifest) = (report(), sample::manifest());
        let tables = |lines| ProtocolTable::all(&report, &manifest, lines);
        let text = |lines| Terminal::UNFOLDED.text(&tables(lines)[0]);
        insta::assert_snapshot!(text(ProtocolLines::Short), @r"
        Protocol nuscenes. n: annotations that count.

                                                              paper                       pca
                                                     ────────────────────────   ────────────────────────
        data set               class    metric   n    value              95 %    value              95 %
        ────────────────────────────────────────────────────────────────────────────────────────────────
        main_road (simulated)  all      ap      41   0.2500  0.1500 to 0.3500   –
                               present  nds     41   0.5000  0.4000 to 0.6000   0.5000  0.4000 to 0.6000

        all: the mean over all classes, as the makers have it; classes without annotations count as not
          found. present: over classes with annotations, and errors that are known.
        Detections without a score have 1; detections have the class that their detector gives, vehicles
          without one are cars.
        –: no annotation that it could be of, or not known.
        95 % interval: cluster bootstrap, 1000 resamples; each second of driving is one block, because there
          are fewer than 10 drives: the intervals cover other scans of the same drives, but not other
          drives.
        All numbers: table_protocol_nuscenes.md.
        simulated: from a simulator, not recorded.
        ");
        assert!(text(ProtocolLines::Every).contains("car"));
        let stems = |lines| tables(lines).iter().map(ProtocolTable::file_stem).collect::<Vec<_>>();
        assert_eq!(stems(ProtocolLines::Every), ["table_protocol_nuscenes"]);
        assert_eq!(stems(ProtocolLines::Short), ["table_protocol_nuscenes_short"]);
    }

    #[test]
    fn of_kitti_the_short_table_has_plan_and_space_of_every_class() {
        let mut report = report();
        report.rows.truncate(3);
        let ids = ["ap_3d_moderate_r40", "ap_bev_hard_r40", "sound_ap_3d_easy_r40"];
        for (row, id) in report.rows.iter_mut().zip(ids) {
            row.protocol = Protocol::KittiObject;
            row.metric.class = "cyclist".to_owned();
            row.metric.id = id.to_owned();
        }
        let manifest = sample::manifest();
        let table = &ProtocolTable::all(&report, &manifest, ProtocolLines::Short)[0];
        let text = Terminal::UNFOLDED.text(table);
        assert!(text.contains(ids[0]) && text.contains(ids[1]) && !text.contains("sound"), "{text}");
        assert!(text.contains("All numbers: table_protocol_kitti-object.md."), "{text}");
    }

    #[test]
    fn every_format_has_every_number() {
        let (report, manifest) = (report(), sample::manifest());
        let table = &ProtocolTable::all(&report, &manifest, ProtocolLines::Every)[0];
        for format in protocol_formats() {
            let text = format.text(table);
            assert!(text.contains("0.25") && text.contains("car") && text.ends_with('\n'), "{text}");
        }
        assert_eq!(protocol_formats()[0].text(table).lines().count(), 7);
    }
}
