//! Checks that shards make a run: all of one run, and each once.

use std::collections::BTreeSet;

use crate::run_folder::manifest::Manifest;
use crate::run_folder::shard_record::ShardRecord;
use crate::vocabulary::shard::Shard;
use crate::vocabulary::study::Study;

/// A directory that should be a shard, and its manifest.
#[derive(Debug, Clone)]
pub struct NamedShard {
    /// The directory, as it was named.
    pub name: String,
    /// Its manifest.
    pub manifest: Manifest,
}

/// Why shards do not make a run: the first thing that differs, with the directories that it differs in.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ShardMismatch(String);

impl ShardMismatch {
    /// The directory `name` has rows of a scan that an earlier one has, too.
    pub fn same_scan(name: &str, scan: &str) -> Self {
        Self(format!("{name} overlaps with an earlier shard: both have scan {scan}"))
    }
}

/// The first few of `numbers`.
fn in_words(numbers: &[u32]) -> String {
    const MOST: usize = 10;
    let mut words: Vec<String> = numbers.iter().take(MOST).map(u32::to_string).collect();
    if numbers.len() > MOST {
        words.push("…".to_owned());
    }
    words.join(", ")
}

/// Checks that `shards` are those of one run, each once, and returns their indices in the order of the run.
///
/// Names of folders that data lie in, dates and processors may differ.
///
/// # Errors
///
/// [`ShardMismatch`] with the first that differs.
pub fn check_shards(shards: &[NamedShard]) -> Result<Vec<usize>, ShardMismatch> {
    let mut records: Vec<(usize, Shard, &ShardRecord)> = Vec::new();
    for (idx, NamedShard { name, manifest }) in shards.iter().enumerate() {
        let no_shard = || ShardMismatch(format!("{name} is no shard, but a whole run"));
        let record = manifest.shard.as_ref().ok_or_else(no_shard)?;
        let bad_number = |problem| ShardMismatch(format!("{name}: {problem}"));
        records.push((idx, record.shard().map_err(bad_number)?, record));
    }
    // The order in which they are given must not change a message.
    records.sort_by_key(|(idx, shard, _)| (shard.index(), &shards[*idx].name));
    let Some((&(first, ..), others)) = records.split_first() else { return Ok(Vec::new()) };
    for (other, ..) in others {
        if let Some(difference) = not_of_same_run(&shards[first], &shards[*other]) {
            return Err(ShardMismatch(difference));
        }
    }
    check_numbers(shards, &mut records)?;
    check_scans(shards, &records)?;
    Ok(records.into_iter().map(|(idx, ..)| idx).collect())
}

/// Why two shards are not of one run, if they are not.
fn not_of_same_run(first: &NamedShard, other: &NamedShard) -> Option<String> {
    let (ours, theirs) = (&first.manifest, &other.manifest);
    let (first, other) = (&first.name, &other.name);
    let [study, other_study] = [ours, theirs].map(|it| it.shard.as_ref().map_or(Study::Run, |it| it.study));
    if study != other_study {
        let [study, other_study] = [study, other_study].map(Study::name);
        return Some(format!("{first} is a shard of `{study}`, {other} one of `{other_study}`"));
    }
    let [version, other_version] = [ours, theirs].map(|it| it.scoring_version);
    if version != other_version {
        return Some(format!("{first} has scoring version {version}, {other} has {other_version}"));
    }
    let program = |it: &Manifest| it.shard.as_ref().map(|it| it.program.clone());
    if program(ours) != program(theirs) {
        let versions = [ours, theirs].map(program_in_words).join(" and ");
        return Some(format!("{first} and {other} were made by different programs: {versions}"));
    }
    if let Some(what) = ours.different_data(theirs) {
        return Some(format!("{first} and {other} are of different data: {what}"));
    }
    let what = ours.different_parameters(theirs)?;
    Some(format!("{first} and {other} have different parameters: {what}"))
}

fn program_in_words(manifest: &Manifest) -> String {
    let commit = manifest.git.as_ref().map_or_else(String::new, |it| {
        let changed = if it.dirty { " with changes" } else { "" };
        format!(", commit {}{changed}", it.commit)
    });
    let checksum =
        manifest.shard.as_ref().map_or_else(String::new, |it| it.program.chars().take(12).collect());
    let version = &manifest.scanbench_version;
    format!("version {version}{commit}, SHA-256 {checksum}…")
}

/// Sorts `records` by their numbers, each of which has to be there once.
fn check_numbers(
    shards: &[NamedShard],
    records: &mut [(usize, Shard, &ShardRecord)],
) -> Result<(), ShardMismatch> {
    let name = |idx: usize| &shards[idx].name;
    if let Some([one, other]) = records.array_windows().find(|[one, other]| one.1.count() != other.1.count())
    {
        let (first, count, other_count) = (name(one.0), one.1.count(), other.1.count());
        let other = name(other.0);
        return Err(ShardMismatch(format!("{first} is one of {count} shards, {other} one of {other_count}")));
    }
    records.sort_by_key(|(idx, shard, _)| (shard.index(), *idx));
    if let Some([one, other]) = records.array_windows().find(|[one, other]| one.1 == other.1) {
        let (first, other, shard) = (name(one.0), name(other.0), one.1);
        return Err(ShardMismatch(format!("{first} and {other} are both shard {shard}")));
    }
    let there: BTreeSet<u32> = records.iter().map(|it| it.1.index()).collect();
    let count = records.first().map_or(0, |it| it.1.count());
    let missing: Vec<u32> = (1..=count).filter(|it| !there.contains(it)).collect();
    let said = || format!("{} of {count} shards are missing: {}", missing.len(), in_words(&missing));
    if missing.is_empty() { Ok(()) } else { Err(ShardMismatch(said())) }
}

/// Every scan that was selected has to be in one of `records`.
fn check_scans(shards: &[NamedShard], records: &[(usize, Shard, &ShardRecord)]) -> Result<(), ShardMismatch> {
    let datasets = shards.first().map_or_else(Vec::new, |it| it.manifest.selected());
    for (dataset_idx, (id, n_selected)) in datasets.into_iter().enumerate() {
        let gap = |index, n_scans| {
            Err(ShardMismatch(format!("{n_scans} scans of {id:?} from place {index} on are in no shard")))
        };
        let (mut index, mut last) = (0, None);
        for (idx, _, record) in records {
            let Some(part) = record.parts.get(dataset_idx).filter(|it| it.first < it.end) else { continue };
            if part.first < index {
                let [first, other] = [last.unwrap_or(*idx), *idx].map(|it| &shards[it].name);
                return Err(ShardMismatch(format!(
                    "{first} and {other} overlap: both have scans of {id:?} from place {} on",
                    part.first
                )));
            }
            if part.first > index {
                return gap(index, part.first - index);
            }
            (index, last) = (part.end, Some(*idx));
        }
        if index < n_selected {
            return gap(index, n_selected - index);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run_folder::manifest::ForeignEntry;
    use crate::run_folder::shard_record::{ShardPart, WorkMeasure};
    use crate::tables::sample;
    use proptest::prelude::*;

    /// Shard `index` of `count` of three data sets of twenty scans each, with these indices of all sixty.
    fn shard(index: u32, count: u32, scans: std::ops::Range<u64>) -> NamedShard {
        let part = |dataset_idx: u64| {
            let within = |index: u64| index.clamp(20 * dataset_idx, 20 * dataset_idx + 20) - 20 * dataset_idx;
            ShardPart {
                first: within(scans.start),
                end: within(scans.end),
                selected: String::new(),
                n_labels: 0,
                n_labeled_scans: 0,
            }
        };
        let record = ShardRecord {
            index,
            count,
            created: String::new(),
            study: Study::Run,
            program: "f00d".to_owned(),
            cut_by: WorkMeasure::Scans,
            parts: (0..3).map(part).collect(),
            processors: Vec::new(),
            log: None,
            recordings: Vec::new(),
        };
        let manifest = Manifest { shard: Some(record), ..sample::manifest() };
        NamedShard { name: format!("{index}-of-{count}"), manifest }
    }

    #[track_caller]
    fn check_refused(shards: &[NamedShard], words: &str) {
        let error = check_shards(shards).unwrap_err().to_string();
        assert_eq!(error, words);
    }

    #[test]
    fn shards_come_in_the_order_of_the_run() {
        let shards = [shard(3, 3, 45..60), shard(1, 3, 0..30), shard(2, 3, 30..45)];
        assert_eq!(check_shards(&shards), Ok(vec![1, 2, 0]));
        // The second has nothing to do.
        assert_eq!(
            check_shards(&[shard(1, 3, 0..30), shard(2, 3, 30..30), shard(3, 3, 30..60)]),
            Ok(vec![0, 1, 2])
        );
    }

    #[test]
    fn every_shard_is_there_once_and_every_scan_in_one() {
        let halves = || [shard(1, 2, 0..30), shard(2, 2, 30..60)];
        let [first, second] = halves();
        check_refused(std::slice::from_ref(&first), "1 of 2 shards are missing: 2");
        check_refused(&[first.clone(), first.clone()], "1-of-2 and 1-of-2 are both shard 1/2");
        check_refused(&[first.clone(), shard(2, 3, 30..60)], "1-of-2 is one of 2 shards, 2-of-3 one of 3");
        check_refused(
            &[first.clone(), shard(2, 2, 25..60)],
            "1-of-2 and 2-of-2 overlap: both have scans of \"kitti_tracking\" from place 5 on",
        );
        check_refused(
            &[first.clone(), shard(2, 2, 33..60)],
            "3 scans of \"kitti_tracking\" from place 10 on are in no shard",
        );
        check_refused(
            &[first, shard(2, 2, 30..58)],
            "2 scans of \"kitti_object\" from place 18 on are in no shard",
        );
        let mut whole = second;
        whole.manifest.shard = None;
        check_refused(&[whole], "2-of-2 is no shard, but a whole run");
    }

    #[test]
    fn shards_of_another_study_are_none_of_the_run() {
        let mut shards = [shard(1, 2, 0..30), shard(2, 2, 30..60)];
        shards[1].manifest.shard.as_mut().unwrap().study = Study::Ablation;
        check_refused(&shards, "1-of-2 is a shard of `run`, 2-of-2 one of `ablation`");
    }

    #[test]
    fn folders_may_differ_and_data_may_not() {
        let mut shards = [shard(1, 2, 0..30), shard(2, 2, 30..60)];
        shards[1].manifest.datasets[0].root = Some("/elsewhere".to_owned());
        shards[1].manifest.machine.cpu_model = "another".to_owned();
        assert!(check_shards(&shards).is_ok());
        shards[1].manifest.datasets[0].sensor_height_m = 2.0;
        check_refused(
            &shards,
            "1-of-2 and 2-of-2 are of different data: \"main_road\" was opened in another way",
        );
    }

    #[test]
    fn a_detector_of_others_has_the_same_files_in_all_shards() {
        let mut shards = [shard(1, 2, 0..30), shard(2, 2, 30..60)];
        let name = shards[0].manifest.detectors[0].name.clone();
        for (shard, checksum) in shards.iter_mut().zip(["f00d", "beef"]) {
            let files = [("mine.py".to_owned(), checksum.to_owned())].into();
            shard.manifest.detectors[0].foreign = Some(ForeignEntry { files, ..ForeignEntry::default() });
        }
        check_refused(
            &shards,
            &format!(
                "1-of-2 and 2-of-2 have different parameters: configuration changed: {name}: mine.py: SHA-256 f00d… → SHA-256 beef…"
            ),
        );
    }

    proptest! {
        #[test]
        fn cuts_anywhere_make_a_run_and_none_without_one_of_them(
            mut cuts in prop::collection::vec(0_u64..=60, 1..6),
            left_out in 0_usize..6,
        ) {
            cuts.extend([0, 60]);
            cuts.sort_unstable();
            let count = cuts.len() as u32 - 1;
            let mut shards: Vec<NamedShard> =
                (1..).zip(cuts.windows(2)).map(|(index, ends)| shard(index, count, ends[0]..ends[1])).collect();
            prop_assert!(check_shards(&shards).is_ok());
            shards.remove(left_out % shards.len());
            prop_assert!(shards.is_empty() || check_shards(&shards).is_err());
        }
    }
}
