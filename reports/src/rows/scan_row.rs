//! `scans.csv`: one row for every scan, detector and task.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::files::shown_text::printable_name;
use crate::rows::counts::Counts;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::task::Task;

/// The outcome of one detector on one scan in one task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "ScanRecord", try_from = "ScanRecord")]
pub struct ScanRow {
    /// Id of the data set.
    pub dataset: String,
    /// The drive the scan belongs to.
    pub sequence: String,
    /// Number of the scan within the drive.
    pub scan: u32,
    /// When it was taken, in seconds since the first scan of the drive, in whole milliseconds; `None` where that is not
    /// known, or where the user says otherwise which scans belong together.
    pub time_s: Option<f64>,
    /// Name of the detector.
    pub detector: String,
    /// The task.
    pub task: Task,
    /// The outcome.
    pub outcome: ScanOutcome,
}

/// The outcome of a scan.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all scans are evaluated")]
pub enum ScanOutcome {
    /// It was evaluated.
    Evaluated(ScanNumbers),
    /// It was not.
    Skipped {
        /// Why, in words.
        reason: String,
    },
}

/// The numbers of one scan, detector and task.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanNumbers {
    /// Why the detector gave no answer, in words, and counts as one that found nothing; `None` if it gave one.
    pub failure: Option<String>,
    /// Number of points of the scan.
    pub n_points: u64,
    /// CRC-32 of points and annotations as they were read.
    pub checksum: u32,
    /// Time of detection in milliseconds; `None` where it does not count, as while warming up.
    pub latency_ms: Option<f64>,
    /// The shortest of all repetitions of that detection in milliseconds; `None` where `latency_ms` is.
    pub least_latency_ms: Option<f64>,
    /// Time of the reference that was measured in turns with it, in milliseconds: the shortest of all repetitions. `None`
    /// where it was not measured.
    pub reference_ms: Option<f64>,
    /// Time on processors in milliseconds, on all threads and in all processes of the detector, of the detection that
    /// `latency_ms` is of; `None` where it was not measured.
    pub cpu_ms: Option<f64>,
    /// The way to a detector that is a program of its own and back, in milliseconds: the shortest of all repetitions. It is
    /// part of `latency_ms`. `None` of others.
    pub overhead_ms: Option<f64>,
    /// Instructions of the detection, in user mode, on all threads and in all processes of the detector; `None` where nobody
    /// counted them.
    pub n_instructions: Option<u64>,
    /// The most memory of the detection at once, in bytes; `None` where nobody looked.
    pub peak_bytes: Option<u64>,
    /// Annotations found and missed, and false detections.
    pub counts: Counts,
    /// Annotations that are neither found nor missed.
    pub n_ignored_annotations: u64,
    /// Detections that are neither right nor false.
    pub n_ignored_detections: u64,
    /// Detections of which it cannot be known whether they are false.
    pub n_unknowable_detections: u64,
    /// How far objects are torn apart or run together.
    pub segmentation: SegmentationNumbers,
    /// Clusters dropped because they have too few points.
    pub n_dropped_too_small: u64,
    /// Clusters dropped because they have too many points or are too long.
    pub n_dropped_too_large: u64,
}

impl ScanNumbers {
    /// Numbers of a scan of a thousand points with these counts, where nothing was ignored and nothing timed.
    pub fn of_counts(counts: Counts) -> Self {
        Self {
            failure: None,
            n_points: 1000,
            checksum: 0,
            latency_ms: None,
            least_latency_ms: None,
            reference_ms: None,
            cpu_ms: None,
            overhead_ms: None,
            n_instructions: None,
            peak_bytes: None,
            counts,
            n_ignored_annotations: 0,
            n_ignored_detections: 0,
            n_unknowable_detections: 0,
            segmentation: SegmentationNumbers::default(),
            n_dropped_too_small: 0,
            n_dropped_too_large: 0,
        }
    }
}

/// How far the objects of a scan are torn apart or run together, whether or not the pieces match.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SegmentationNumbers {
    /// Annotations that count of which several detections each hold a tenth of the points or more.
    pub n_split: u64,
    /// Detections with more than half of the points of an annotation that counts.
    pub n_holding: u64,
    /// Of these, those with more than half of the points of several.
    pub n_joining: u64,
    /// Detections with a point of an annotation that counts.
    pub n_touching: u64,
    /// OSE: −p ln p of every annotation that counts and every detection, where p is the share of the annotation's points
    /// that the detection has; summed.
    pub over_entropy_nats: f64,
    /// USE: the same of every detection, where p is the share of the detection's points that the annotation has; summed.
    pub under_entropy_nats: f64,
}

impl ScanRow {
    /// The row as it is read back from its file: with as many decimals as it is written with.
    pub fn as_written(self) -> Self {
        Self::try_from(ScanRecord::from(self)).expect("what was made of a row makes one")
    }

    /// The scan that it is about.
    pub fn scan_name(&self) -> ScanName {
        ScanName { dataset: self.dataset.clone(), sequence: self.sequence.clone(), scan: self.scan }
    }

    /// Its numbers; `None` if it was not evaluated.
    pub fn numbers(&self) -> Option<&ScanNumbers> {
        match &self.outcome {
            ScanOutcome::Evaluated(numbers) => Some(numbers),
            ScanOutcome::Skipped { .. } => None,
        }
    }
}

row! {
    for ScanRow:
    #[derive(Serialize, Deserialize)]
    struct ScanRecord {
        /// Id of the data set.
        #[serde(deserialize_with = "printable_name")]
        dataset: String,
        /// The drive that the scan belongs to.
        #[serde(deserialize_with = "printable_name")]
        sequence: String,
        /// Number of the scan within the drive.
        scan: u32,
        /// When it was taken, in seconds since the first scan of the drive.
        time_s: Option<Fixed<3>>,
        /// Name of the detector.
        #[serde(deserialize_with = "printable_name")]
        detector: String,
        /// `objects` or `vehicles`.
        task: Task,
        /// `evaluated`, `failed` (the detector gave no answer) or `skipped` (not evaluated).
        status: Status,
        /// Why it failed or was skipped.
        reason: Option<String>,
        /// Number of points of the scan.
        n_points: Option<u64>,
        /// CRC-32 of points and annotations as they were read.
        checksum: Option<String>,
        /// Time of detection, of the first repetition.
        latency_ms: Option<Fixed<3>>,
        /// The shortest of all repetitions.
        least_latency_ms: Option<Fixed<3>>,
        /// Time of the reference that was measured in turns with it, the shortest of all repetitions.
        reference_ms: Option<Fixed<4>>,
        /// Time on processors, on all threads and in all processes of the detector.
        cpu_ms: Option<Fixed<3>>,
        /// The way to a detector that is a program of its own and back; part of `latency_ms`.
        overhead_ms: Option<Fixed<3>>,
        /// Instructions of the detection in user mode, counted with `--count`.
        instructions: Option<u64>,
        /// The most memory of the detection at once, in bytes, with `--count`.
        peak_bytes: Option<u64>,
        /// Annotations that count.
        no: Option<u64>,
        /// Those that were found.
        tp: Option<u64>,
        /// Those that were missed.
        mo: Option<u64>,
        /// False detections.
        fo: Option<u64>,
        /// Annotations that are neither found nor missed.
        ignored_annotations: Option<u64>,
        /// Detections that are neither right nor false.
        ignored_detections: Option<u64>,
        /// Detections of which nobody knows whether they are false.
        unknowable_detections: Option<u64>,
        /// Annotations of which several detections each hold a tenth of the points or more.
        split: Option<u64>,
        /// Detections with more than half of the points of an annotation.
        holding: Option<u64>,
        /// Of these, those with more than half of the points of several.
        joining: Option<u64>,
        /// Detections with a point of an annotation.
        touching: Option<u64>,
        /// Over-segmentation entropy.
        ose_nats: Option<Fixed<6>>,
        /// Under-segmentation entropy.
        use_nats: Option<Fixed<6>>,
        /// Clusters dropped because they have too few points.
        dropped_too_small: Option<u64>,
        /// Clusters dropped because they have too many points or are too long.
        dropped_too_large: Option<u64>,
    }
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Status {
    Evaluated,
    Failed,
    Skipped,
}

impl From<ScanRow> for ScanRecord {
    fn from(row: ScanRow) -> Self {
        let (status, reason, numbers) = match row.outcome {
            ScanOutcome::Evaluated(numbers) if numbers.failure.is_some() => {
                (Status::Failed, numbers.failure.clone(), Some(numbers))
            }
            ScanOutcome::Evaluated(numbers) => (Status::Evaluated, None, Some(numbers)),
            ScanOutcome::Skipped { reason } => (Status::Skipped, Some(reason), None),
        };
        let numbers = numbers.as_ref();
        let counts = numbers.map(|it| it.counts);
        let segmentation = numbers.map(|it| it.segmentation);
        Self {
            dataset: row.dataset,
            sequence: row.sequence,
            scan: row.scan,
            time_s: row.time_s.map(Fixed::rounded),
            detector: row.detector,
            task: row.task,
            status,
            reason,
            n_points: numbers.map(|it| it.n_points),
            checksum: numbers.map(|it| format!("{:08x}", it.checksum)),
            latency_ms: numbers.and_then(|it| it.latency_ms).map(Fixed::rounded),
            least_latency_ms: numbers.and_then(|it| it.least_latency_ms).map(Fixed::rounded),
            reference_ms: numbers.and_then(|it| it.reference_ms).map(Fixed::rounded),
            cpu_ms: numbers.and_then(|it| it.cpu_ms).map(Fixed::rounded),
            overhead_ms: numbers.and_then(|it| it.overhead_ms).map(Fixed::rounded),
            instructions: numbers.and_then(|it| it.n_instructions),
            peak_bytes: numbers.and_then(|it| it.peak_bytes),
            no: counts.map(Counts::no),
            tp: counts.map(Counts::tp),
            mo: counts.map(Counts::mo),
            fo: counts.and_then(Counts::fo),
            ignored_annotations: numbers.map(|it| it.n_ignored_annotations),
            ignored_detections: numbers.map(|it| it.n_ignored_detections),
            unknowable_detections: numbers.map(|it| it.n_unknowable_detections),
            split: segmentation.map(|it| it.n_split),
            holding: segmentation.map(|it| it.n_holding),
            joining: segmentation.map(|it| it.n_joining),
            touching: segmentation.map(|it| it.n_touching),
            ose_nats: segmentation.map(|it| Fixed::rounded(it.over_entropy_nats)),
            use_nats: segmentation.map(|it| Fixed::rounded(it.under_entropy_nats)),
            dropped_too_small: numbers.map(|it| it.n_dropped_too_small),
            dropped_too_large: numbers.map(|it| it.n_dropped_too_large),
        }
    }
}

impl TryFrom<ScanRecord> for ScanRow {
    type Error = &'static str;

    fn try_from(record: ScanRecord) -> Result<Self, &'static str> {
        let outcome = match record.status {
            Status::Evaluated => ScanOutcome::Evaluated(numbers_of(&record)?),
            Status::Failed => {
                let failure = Some(record.reason.clone().ok_or("a failed scan has no reason")?);
                ScanOutcome::Evaluated(ScanNumbers { failure, ..numbers_of(&record)? })
            }
            Status::Skipped => {
                let reason = record.reason.ok_or("a skipped scan has no reason")?;
                ScanOutcome::Skipped { reason }
            }
        };
        let ScanRecord { dataset, sequence, scan, time_s, detector, task, .. } = record;
        let time_s = time_s.map(|Fixed(time_s)| time_s);
        if time_s.is_some_and(|it| !it.is_finite()) {
            return Err("time_s is not a time");
        }
        Ok(Self { dataset, sequence, scan, time_s, detector, task, outcome })
    }
}

fn checksum_of(record: &ScanRecord) -> Option<u32> {
    let digits = record.checksum.as_ref().filter(|it| it.len() == 8)?;
    u32::from_str_radix(digits, 16).ok()
}

fn numbers_of(record: &ScanRecord) -> Result<ScanNumbers, &'static str> {
    let present = |number: Option<u64>| number.ok_or("an evaluated scan has an empty number");
    let counts = Counts::new(present(record.no)?, present(record.tp)?, record.fo);
    let counts = counts.ok_or("tp is larger than no")?;
    let entropy =
        |it: Option<Fixed<6>>| it.map(|Fixed(nats)| nats).ok_or("an evaluated scan has an empty number");
    if record.mo != Some(counts.mo()) {
        return Err("mo is not no - tp");
    }
    Ok(ScanNumbers {
        failure: None,
        n_points: present(record.n_points)?,
        checksum: checksum_of(record).ok_or("checksum is not one of eight hexadecimal digits")?,
        latency_ms: record.latency_ms.map(|Fixed(latency_ms)| latency_ms),
        least_latency_ms: record.least_latency_ms.map(|Fixed(latency_ms)| latency_ms),
        reference_ms: record.reference_ms.map(|Fixed(reference_ms)| reference_ms),
        cpu_ms: record.cpu_ms.map(|Fixed(cpu_ms)| cpu_ms),
        overhead_ms: record.overhead_ms.map(|Fixed(overhead_ms)| overhead_ms),
        n_instructions: record.instructions,
        peak_bytes: record.peak_bytes,
        counts,
        n_ignored_annotations: present(record.ignored_annotations)?,
        n_ignored_detections: present(record.ignored_detections)?,
        n_unknowable_detections: present(record.unknowable_detections)?,
        segmentation: SegmentationNumbers {
            n_split: present(record.split)?,
            n_holding: present(record.holding)?,
            n_joining: present(record.joining)?,
            n_touching: present(record.touching)?,
            over_entropy_nats: entropy(record.ose_nats)?,
            under_entropy_nats: entropy(record.use_nats)?,
        },
        n_dropped_too_small: present(record.dropped_too_small)?,
        n_dropped_too_large: present(record.dropped_too_large)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::files::csv_rows::{CsvRow, to_csv_bytes};

    fn row(scan: u32, outcome: ScanOutcome) -> ScanRow {
        let [dataset, sequence, detector] = ["kitti, tracking", "0000", "kd-tree"].map(str::to_owned);
        let task = Task::Objects;
        ScanRow { dataset, sequence, scan, time_s: Some(f64::from(scan) / 10.0), detector, task, outcome }
    }

    fn numbers(latency_ms: Option<f64>, n_false: Option<u64>) -> ScanOutcome {
        ScanOutcome::Evaluated(ScanNumbers {
            failure: None,
            n_points: 120_000,
            checksum: 0x00c0_ffee,
            latency_ms,
            least_latency_ms: latency_ms,
            reference_ms: latency_ms.map(|_| 0.25),
            cpu_ms: latency_ms.map(|it| 2.0 * it),
            overhead_ms: latency_ms.map(|_| 0.125),
            n_instructions: latency_ms.map(|_| 31_000_123),
            peak_bytes: latency_ms.map(|_| 4096),
            counts: Counts::new(7, 5, n_false).unwrap(),
            n_ignored_annotations: 3,
            n_ignored_detections: 2,
            n_unknowable_detections: 40,
            segmentation: SegmentationNumbers {
                n_split: 1,
                n_holding: 6,
                n_joining: 2,
                n_touching: 8,
                over_entropy_nats: 0.5,
                under_entropy_nats: 0.25,
            },
            n_dropped_too_small: 900,
            n_dropped_too_large: 1,
        })
    }

    fn failed() -> ScanOutcome {
        let ScanOutcome::Evaluated(numbers) = numbers(None, Some(0)) else { unreachable!("it is made so") };
        ScanOutcome::Evaluated(ScanNumbers { failure: Some("it closed its pipe".to_owned()), ..numbers })
    }

    fn rows() -> Vec<ScanRow> {
        let reason = "label file is cut at line 7".to_owned();
        vec![
            row(0, numbers(None, Some(4))),
            row(1, numbers(Some(8.25), None)),
            row(2, ScanOutcome::Skipped { reason }),
            row(3, failed()),
        ]
    }

    #[test]
    fn rows_read_back_as_they_were() {
        let text = csv_text(&rows());
        insta::assert_snapshot!(text, @r#"
        dataset,sequence,scan,time_s,detector,task,status,reason,n_points,checksum,latency_ms,least_latency_ms,reference_ms,cpu_ms,overhead_ms,instructions,peak_bytes,no,tp,mo,fo,ignored_annotations,ignored_detections,unknowable_detections,split,holding,joining,touching,ose_nats,use_nats,dropped_too_small,dropped_too_large
        "kitti, tracking",0000,0,0.000,kd-tree,objects,evaluated,,120000,00c0ffee,,,,,,,,7,5,2,4,3,2,40,1,6,2,8,0.500000,0.250000,900,1
        "kitti, tracking",0000,1,0.100,kd-tree,objects,evaluated,,120000,00c0ffee,8.250,8.250,0.2500,16.500,0.125,31000123,4096,7,5,2,,3,2,40,1,6,2,8,0.500000,0.250000,900,1
        "kitti, tracking",0000,2,0.200,kd-tree,objects,skipped,label file is cut at line 7,,,,,,,,,,,,,,,,,,,,,,,,
        "kitti, tracking",0000,3,0.300,kd-tree,objects,failed,it closed its pipe,120000,00c0ffee,,,,,,,,7,5,2,0,3,2,40,1,6,2,8,0.500000,0.250000,900,1
        "#);
        assert_eq!(rows_of::<ScanRow>(&text).unwrap(), rows());
    }

    #[test]
    fn a_file_from_before_instructions_were_counted_is_read() {
        let text = csv_text(&[row(0, numbers(None, Some(4)))]);
        let early = text.replace("instructions,peak_bytes,", "").replace("00c0ffee,,", "00c0ffee,").replacen(
            "00c0ffee,,",
            "00c0ffee,",
            1,
        );
        assert_eq!(early.matches(',').count(), text.matches(',').count() - 4);
        assert_eq!(rows_of::<ScanRow>(&early).unwrap(), rows_of::<ScanRow>(&text).unwrap());
    }

    #[test]
    fn a_file_without_rows_has_columns() {
        let text = csv_text::<ScanRow>(&[]);
        assert_eq!(text.trim_end().split(',').count(), ScanRow::COLUMNS.len());
        assert!(rows_of::<ScanRow>(&text).unwrap().is_empty());
    }

    /// Reads the file of the rows after its first `from` was replaced by `to`.
    fn read_with(from: &str, to: &str) -> Result<Vec<ScanRow>, String> {
        let text = csv_text(&rows());
        assert!(text.contains(from), "{text}");
        rows_of(&text.replacen(from, to, 1))
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, expected: &str) {
        let problem = read_with(from, to).unwrap_err();
        assert!(problem.contains(expected), "{problem}");
    }

    #[test]
    fn what_contradicts_itself_or_is_missing_is_refused_with_its_line() {
        check_refused(",7,5,2,4,", ",7,5,3,4,", "line: 2");
        check_refused(",7,5,2,4,", ",7,5,3,4,", "mo is not no - tp");
        check_refused(",7,5,2,4,", ",7,9,2,4,", "tp is larger than no");
        check_refused("00c0ffee", "c0ffee", "checksum is not one of eight hexadecimal digits");
        check_refused("00c0ffee", "00coffee", "checksum is not one of eight hexadecimal digits");
        check_refused("skipped", "evaluated", "an evaluated scan has an empty number");
        check_refused("n_points", "n_echoes", "has the columns");
    }

    #[test]
    fn a_time_that_is_no_number_is_refused_and_none_is_read() {
        let rows = read_with("0000,1,0.100,", "0000,1,,").unwrap();
        let times_s: Vec<_> = rows.iter().map(|it| it.time_s).take(3).collect();
        assert_eq!(times_s, [Some(0.0), None, Some(0.2)]);
        check_refused("0000,1,0.100,", "0000,1,NaN,", "time_s is not a time");
    }

    #[test]
    fn a_time_that_is_not_a_number_is_not_written() {
        to_csv_bytes(&[row(0, numbers(Some(f64::NAN), None))]).unwrap_err();
    }
}
