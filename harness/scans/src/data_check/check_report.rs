//! The report on all scans of a data set together.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use super::empty_boxes::{EmptyBoxes, NEAR_M};
use super::frame_suspicion::FrameSuspicion;
use super::label_look::LabelLook;
use super::scan_facts::{RANGES_M, ScanFacts, ring_areas_m2};
use crate::annotation::ScanId;
use crate::dataset::shown_name::shown;
use crate::dataset::{AnnotatedClasses, DatasetDescription};

/// The ground may be this far from its place by the height of the sensor, in metres.
const GROUND_TOLERANCE_M: f32 = 0.5;

/// A pause this many times as long as the usual one is a gap.
const GAP_FACTOR: f64 = 1.5;

/// Most characters in a line; a longer list continues below.
const LINE_WIDTH: usize = 120;

/// Facts about one scan of a data set.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedScan {
    /// The id of the scan.
    pub id: ScanId,
    /// The drive that it was taken in; `None` where neither drives nor times are known.
    pub drive: Option<String>,
    /// When it was taken, in nanoseconds.
    pub time_ns: Option<u64>,
    /// Its facts, or the reason why it cannot be read.
    pub facts: Result<ScanFacts, String>,
}

/// The findings, line by line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckReport {
    /// Facts about the data set: a name and a value for each line.
    pub lines: Vec<(&'static str, String)>,
    /// Possible errors in the data set.
    pub warnings: Vec<String>,
    /// Scans that cannot be read.
    pub n_damaged: usize,
}

impl CheckReport {
    /// The report on `scans`, in the order of the data set. `suspicions` about frame and labels come first, as later
    /// findings may follow from them.
    pub fn of(
        description: &DatasetDescription,
        scans: &[CheckedScan],
        suspicions: &[FrameSuspicion],
    ) -> Self {
        let facts: Vec<&ScanFacts> = scans.iter().filter_map(|it| it.facts.as_ref().ok()).collect();
        let mut report =
            Self { lines: Vec::new(), warnings: Vec::new(), n_damaged: scans.len() - facts.len() };
        report.add_suspicions(suspicions);
        report.describe(description);
        report.count_scans(scans);
        report.count_points(&facts);
        report.name_empty(scans);
        // Where another axis points up, z is no height.
        if !suspicions.iter().any(|it| matches!(it, FrameSuspicion::Axis(_))) {
            report.check_ground(description, &facts);
        }
        report.count_annotations(&facts);
        report.check_times(scans);
        report.check_repetition(scans);
        report
    }

    /// Adds possible errors of labels and names as a whole, see [`Dataset::oddities`](crate::dataset::Dataset::oddities).
    pub fn add_oddities(&mut self, oddities: impl IntoIterator<Item = String>) {
        self.warnings.extend(oddities.into_iter().map(|it| shown(&it).into_owned()));
    }

    /// Adds the columns that were read from files that do not name them.
    pub fn add_columns(&mut self, columns: Option<String>) {
        if let Some(columns) = columns {
            self.line("columns", columns);
        }
    }

    /// Adds whether labels were compared with points; errors of the labels are among the suspicions.
    pub fn add_label_look(&mut self, look: &LabelLook) {
        let verb = match (look.is_enough(), look.suspicions.is_empty()) {
            (false, _) => "too few to be compared with points",
            (true, true) => "they fit their points",
            (true, false) => "see the warnings",
        };
        let n = look.vehicles.seen.len();
        self.line(
            "boxes of vehicles",
            format!("{n} in a few scans, with at least 20 points, nearer than 40 m: {verb}"),
        );
    }

    /// Adds the suspicions except those about heights and empty boxes, which are checked on all scans.
    fn add_suspicions(&mut self, suspicions: &[FrameSuspicion]) {
        let is_shown = |it: &&FrameSuspicion| {
            matches!(it, FrameSuspicion::Height { .. } | FrameSuspicion::EmptyBoxes(_))
        };
        self.warnings.extend(suspicions.iter().filter(|it| !is_shown(it)).map(ToString::to_string));
    }

    fn line(&mut self, name: &'static str, value: String) {
        self.lines.push((name, value));
    }

    fn describe(&mut self, description: &DatasetDescription) {
        let simulated = if description.is_simulated() { ", simulated" } else { "" };
        self.line("data set", format!("{} ({}{simulated})", description.id, description.format));
        if let Some(root) = &description.root {
            self.line("path", shown(&root.display().to_string()).into_owned());
        }
        self.line(
            "sensor",
            format!("{}, {} m above the road", description.sensor, description.sensor_height_m),
        );
        let labels = match &description.annotated {
            AnnotatedClasses::EveryObject => "every object".to_owned(),
            AnnotatedClasses::Only(classes) => {
                classes.iter().map(|it| it.name()).collect::<Vec<_>>().join(", ")
            }
        };
        self.line("labels", labels);
        if let Some(checksum) = &description.checksum {
            self.line("checksum", checksum.clone());
        }
    }

    fn count_scans(&mut self, scans: &[CheckedScan]) {
        let drives: Option<BTreeSet<&str>> = scans.iter().map(|it| it.drive.as_deref()).collect();
        let drives = drives.map_or_else(
            || ", no times known: they may be neighbours".to_owned(),
            |it| format!(" of {}", plural(it.len(), "drive")),
        );
        self.line("scans", format!("{}{drives}", scans.len()));
        let damaged: Vec<_> =
            scans.iter().filter_map(|it| it.facts.as_ref().err().map(|why| (&it.id, why))).collect();
        if let [(id, why), ..] = damaged[..] {
            self.warnings
                .push(format!("{} cannot be read, the first is {id}: {why}", plural(damaged.len(), "scan")));
        }
    }

    fn count_points(&mut self, facts: &[&ScanFacts]) {
        let sum = |count: fn(&ScanFacts) -> usize| facts.iter().map(|it| count(it)).sum::<usize>();
        let n_points = sum(|it| it.n_points);
        let (Some(least), Some(most)) =
            (facts.iter().map(|it| it.n_points).min(), facts.iter().map(|it| it.n_points).max())
        else {
            return;
        };
        self.line("points", format!("{n_points}, {least} to {most} per scan"));
        self.line("labelled", share(sum(|it| it.n_labeled), n_points));
        self.line("no position", share(sum(|it| it.n_without_position), n_points));
        self.line("same position", share(sum(|it| it.n_duplicates), n_points));
        let density = |(ring, area_m2): (usize, f32)| {
            let n: usize = facts.iter().map(|it| it.n_by_range[ring]).sum();
            let per_m2 = n as f32 / area_m2 / facts.len() as f32;
            format!("{per_m2:.2} ({}-{} m)", RANGES_M[ring], RANGES_M[ring + 1])
        };
        let densities: Vec<String> = ring_areas_m2().into_iter().enumerate().map(density).collect();
        self.line("points per m²", densities.join(", "));
    }

    fn name_empty(&mut self, scans: &[CheckedScan]) {
        let is_empty = |it: &ScanFacts| it.n_points == it.n_without_position;
        let empty = scans.iter().filter(|it| it.facts.as_ref().is_ok_and(is_empty));
        let ids: Vec<&ScanId> = empty.map(|it| &it.id).collect();
        if let [first, ..] = ids[..] {
            let (n, n_scans) = (ids.len(), plural(scans.len(), "scan"));
            self.warnings
                .push(format!("{n} of {n_scans} without a point that has a position, first {first}"));
        }
    }

    fn check_ground(&mut self, description: &DatasetDescription, facts: &[&ScanFacts]) {
        let mut heights_m: Vec<f32> = facts.iter().filter_map(|it| it.ground_z_m).collect();
        heights_m.sort_unstable_by(f32::total_cmp);
        let Some(&median_m) = heights_m.get(heights_m.len() / 2) else { return };
        self.line("ground", format!("at z = {median_m:.2} m, 4 to 12 m from the sensor"));
        let expected_m = -description.sensor_height_m;
        if (median_m - expected_m).abs() > GROUND_TOLERANCE_M {
            let suspicion = FrameSuspicion::Height {
                seen_m: -f64::from(median_m),
                said_m: description.sensor_height_m.into(),
            };
            self.warnings.push(suspicion.to_string());
        }
    }

    fn count_annotations(&mut self, facts: &[&ScanFacts]) {
        let annotations = || facts.iter().flat_map(|it| &it.annotations);
        let mut n_by_class: BTreeMap<_, usize> = BTreeMap::new();
        for annotation in annotations() {
            *n_by_class.entry(annotation.class).or_default() += 1;
        }
        let classes: Vec<String> =
            n_by_class.iter().map(|(class, n)| format!("{n} {}", class.name())).collect();
        let classes = if classes.is_empty() { String::new() } else { format!(": {}", classes.join(", ")) };
        self.line("annotations", format!("{}{classes}", annotations().count()));
        // In a scan without points all boxes are empty.
        let with_points = facts.iter().filter(|it| it.n_points > it.n_without_position);
        let near = with_points.flat_map(|it| &it.annotations);
        let near: Vec<_> = near.filter(|it| it.box_range_m.is_some_and(|it| it < NEAR_M)).collect();
        if near.is_empty() {
            return;
        }
        let n_empty = near.iter().filter(|it| it.n_points == 0).count();
        self.line("points in boxes", {
            let mut n_points: Vec<usize> = near.iter().map(|it| it.n_points).collect();
            n_points.sort_unstable();
            let (median, empty) = (n_points[n_points.len() / 2], share(n_empty, near.len()));
            format!("{median} in the median box nearer than {NEAR_M} m; {empty} are empty")
        });
        let boxes = EmptyBoxes { n_near: near.len(), n_empty };
        if boxes.are_most() {
            self.warnings.push(FrameSuspicion::EmptyBoxes(boxes).to_string());
        }
    }

    fn check_times(&mut self, scans: &[CheckedScan]) {
        let mut pauses_ns: Vec<(u64, &ScanId)> = Vec::new();
        let mut n_backwards = 0;
        for pair in scans.windows(2) {
            if pair[0].id.sequence != pair[1].id.sequence {
                continue;
            }
            if let (Some(first), Some(second)) = (pair[0].time_ns, pair[1].time_ns) {
                match second.checked_sub(first) {
                    Some(pause_ns) if pause_ns > 0 => pauses_ns.push((pause_ns, &pair[1].id)),
                    _ => n_backwards += 1,
                }
            }
        }
        let mut sorted: Vec<u64> = pauses_ns.iter().map(|(pause_ns, _)| *pause_ns).collect();
        sorted.sort_unstable();
        if let Some(&usual_ns) = sorted.get(sorted.len() / 2) {
            let gaps: Vec<_> =
                pauses_ns.iter().filter(|it| it.0 as f64 > GAP_FACTOR * usual_ns as f64).collect();
            self.line(
                "time between scans",
                format!("{:.1} ms; {}", usual_ns as f64 / 1e6, plural(gaps.len(), "gap")),
            );
            if let Some((longest_ns, id)) = gaps.iter().max() {
                let longest_s = *longest_ns as f64 / 1e9;
                self.warnings.push(format!(
                    "{} between scans, the longest {longest_s:.2} s before {id}",
                    plural(gaps.len(), "gap")
                ));
            }
        }
        if n_backwards > 0 {
            self.warnings.push(format!(
                "the time of a scan is not later than that of the one before: {}",
                plural(n_backwards, "time")
            ));
        }
    }

    fn check_repetition(&mut self, scans: &[CheckedScan]) {
        let mut first_of: BTreeMap<u64, &ScanId> = BTreeMap::new();
        let mut repeated = Vec::new();
        for scan in scans {
            if let Ok(facts) = &scan.facts
                && facts.n_points > 0
                && let Some(first) = first_of.insert(facts.fingerprint, &scan.id)
            {
                repeated.push((first, &scan.id));
            }
        }
        if let [(first, second), ..] = repeated[..] {
            let n = plural(repeated.len(), "scan");
            self.warnings.push(format!("{n} repeated: {second} has the same points as {first}"));
        }
    }
}

impl fmt::Display for CheckReport {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let line = |(name, value): &(&str, String)| format!("{name:<width$}  {}", folded(value, width + 2));
        let mut lines: Vec<String> = self.lines.iter().map(line).collect();
        lines.extend(self.warnings.iter().map(|warning| format!("{:<width$}  {warning}", "WARNING")));
        write!(formatter, "{}", lines.join("\n"))
    }
}

/// `value` in lines of at most [`LINE_WIDTH`] characters, each of which begins after `indent` others.
fn folded(value: &str, indent: usize) -> String {
    let (mut text, mut n_in_line) = (String::new(), indent);
    for (word_idx, word) in value.split(' ').enumerate() {
        let n_of_word = word.chars().count();
        if word_idx > 0 && n_in_line + 1 + n_of_word > LINE_WIDTH {
            text.push('\n');
            text.extend(std::iter::repeat_n(' ', indent));
            n_in_line = indent;
        } else if word_idx > 0 {
            text.push(' ');
            n_in_line += 1;
        }
        text.push_str(word);
        n_in_line += n_of_word;
    }
    text
}

fn plural(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

fn share(part: usize, whole: usize) -> String {
    if whole == 0 {
        return format!("{part} of 0");
    }
    format!("{part} of {whole} ({:.1} %)", 100.0 * part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data_check::scan_facts::AnnotationFacts;
    use reports::vocabulary::class::AnnotationClass;

    fn description() -> DatasetDescription {
        DatasetDescription {
            id: "drive".to_owned(),
            format: "mcap".to_owned(),
            root: None,
            annotated: AnnotatedClasses::EveryObject,
            sensor_height_m: 1.7,
            sensor: "vlp-16".to_owned(),
            licence: None,
            checksum: None,
            simulation: None,
        }
    }

    /// Four sound scans, a tenth of a second apart.
    fn scans() -> Vec<CheckedScan> {
        let car =
            |n_points| AnnotationFacts { class: AnnotationClass::Car, box_range_m: Some(9.0), n_points };
        let facts = |fingerprint| ScanFacts {
            n_points: 100,
            n_without_position: 5,
            n_duplicates: 0,
            n_by_range: [50, 30, 15, 0],
            ground_z_m: Some(-1.75),
            n_labeled: 100,
            annotations: vec![car(0), car(30), car(50)],
            fingerprint,
        };
        let scan = |index: u32| CheckedScan {
            id: ScanId { sequence: "0000".to_owned(), index },
            drive: Some("0000".to_owned()),
            time_ns: Some(u64::from(index) * 100_000_000),
            facts: Ok(facts(u64::from(index))),
        };
        (0..4).map(scan).collect()
    }

    /// Changes the sound scans and expects this warning alone, or none.
    #[track_caller]
    fn check(change: impl Fn(&mut CheckedScan), expected: Option<&str>) {
        let mut scans = scans();
        scans.iter_mut().for_each(change);
        let report = CheckReport::of(&description(), &scans, &[]);
        let found: Vec<&str> = report.warnings.iter().map(String::as_str).collect();
        assert_eq!(found.len(), usize::from(expected.is_some()), "{found:?}");
        assert!(found.iter().zip(expected).all(|(found, expected)| found.contains(expected)), "{found:?}");
    }

    fn facts(scan: &mut CheckedScan) -> &mut ScanFacts {
        scan.facts.as_mut().expect("sound")
    }

    #[test]
    fn sound_scans_give_no_warning() {
        check(|_| {}, None);
        let report = CheckReport::of(&description(), &scans(), &[]).to_string();
        for line in [
            "scans               4 of 1 drive",
            "points              400, 100 to 100 per scan",
            "no position         20 of 400 (5.0 %)",
            "annotations         12: 12 car",
            "points in boxes     30 in the median box nearer than 40 m; 4 of 12 (33.3 %) are empty",
            "time between scans  100.0 ms; 0 gaps",
            "ground              at z = -1.75 m, 4 to 12 m from the sensor",
        ] {
            assert!(report.lines().any(|it| it == line), "{line}\n{report}");
        }
    }

    #[test]
    fn a_long_list_continues_below_its_beginning() {
        let words = "word ".repeat(60);
        let text = folded(words.trim_end(), 20);
        assert!(text.lines().all(|it| it.chars().count() <= LINE_WIDTH), "{text}");
        assert_eq!(text.lines().nth(1).map(|it| it.find('w')), Some(Some(20)), "{text}");
        assert_eq!(text.split_whitespace().count(), 60);
        assert_eq!(folded("a b", 20), "a b");
    }

    #[test]
    fn scans_without_times_are_of_no_drive() {
        let mut scans = scans();
        for scan in &mut scans {
            (scan.drive, scan.time_ns) = (None, None);
        }
        let report = CheckReport::of(&description(), &scans, &[]).to_string();
        assert!(report.starts_with("data set"), "{report}");
        assert!(report.contains("4, no times known: they may be neighbours\n"), "{report}");
    }

    #[test]
    fn empty_boxes_tell_of_a_wrong_frame() {
        let empty = |it: &mut CheckedScan| facts(it).annotations[1].n_points = 0;
        check(
            empty,
            Some(
                "8 of 12 boxes nearer than 40 m contain no point: the labels and scans may differ in frame or time",
            ),
        );
    }

    #[test]
    fn ground_at_another_height_tells_of_a_wrong_origin() {
        check(
            |it| facts(it).ground_z_m = Some(-0.3),
            Some("0.30 m below the origin, but the sensor is said to be 1.7 m above the road"),
        );
    }

    #[test]
    fn gaps_and_steps_back_in_time_are_named() {
        let late = |it: &mut CheckedScan| {
            it.time_ns = it.time_ns.map(|ns| if ns > 2e8 as u64 { ns * 4 } else { ns });
        };
        check(late, Some("1 gap between scans, the longest 1.00 s before 0000/000003"));
        let back =
            |it: &mut CheckedScan| it.time_ns = it.time_ns.map(|ns| if ns == 2e8 as u64 { 0 } else { ns });
        check(back, Some("the time of a scan is not later than that of the one before: 1 time"));
    }

    #[test]
    fn a_scan_without_points_is_named_and_its_boxes_say_nothing() {
        let empty = |it: &mut CheckedScan| {
            let facts = facts(it);
            (facts.n_points, facts.n_without_position) = (5, 5);
            facts.annotations.iter_mut().for_each(|it| it.n_points = 0);
        };
        let first = |it: &mut CheckedScan| {
            if it.id.index < 3 {
                empty(it);
            }
        };
        check(first, Some("3 of 4 scans without a point that has a position, first 0000/000000"));
        check(empty, Some("4 of 4 scans without a point"));
    }

    #[test]
    fn repeated_and_damaged_scans_are_named() {
        let repeat = |it: &mut CheckedScan| facts(it).fingerprint /= 3;
        check(repeat, Some("2 scans repeated: 0000/000001 has the same points as 0000/000000"));
        let damage = |it: &mut CheckedScan| {
            if it.id.index > 1 {
                it.facts = Err(format!("{}.bin is cut off", it.id.index));
            }
        };
        check(damage, Some("2 scans cannot be read, the first is 0000/000002: 2.bin is cut off"));
    }
}
