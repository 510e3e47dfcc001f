//! `scanbench merge`: shards become the run that they are parts of.

use std::path::{Component, Path, PathBuf};

use jiff::Timestamp;
use reports::files::csv_rows::read_rows;
use reports::numbers::tally::Tally;
use reports::rows::agreement_row::{AgreementRow, add_agreement};
use reports::run_folder::command_line::command_of_whole_run;
use reports::run_folder::manifest::{Manifest, SkippedScan};
use reports::run_folder::run_directory::{AGREEMENT_CSV, RECORDINGS_JSON, RunDirectory, WORST_POINTS_JSON};
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use reports::run_folder::shard_check::{NamedShard, check_shards};
use reports::run_folder::shard_record::processors_of;
use reports::vocabulary::task::Task;
use reports::worst::places::{ObjectName, WorstPlaces};
use reports::worst::points::{Patch, WorstPoints};
use reports::worst::recorded::{RecordedPlace, Recordings};

use crate::cli::MergeArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::provenance::compact_utc;
use crate::commands::run_directory::{claim_named, claim_unnamed};
use crate::commands::run_ending::{print_ending, write_agreement};
use crate::commands::run_numbers::write_numbers;
use crate::commands::run_protocols::write_protocols;
use crate::commands::shards::rows_of_shards::{ShardDirectory, merge_rows};
use crate::commands::times_of_processors::write_times_of_processors;
use crate::commands::watched_run::tell_of_nothing;

/// Puts shards together: their rows one after the other, and all numbers made of these as those of a run are.
///
/// # Errors
///
/// If a shard is missing, damaged or of another run, or the output cannot be written; nothing is left behind then.
pub fn merge(arguments: &MergeArgs) -> Result<(), Failure> {
    let shards = arguments.shards.iter().map(|it| open_shard(it)).collect::<Result<Vec<_>, _>>()?;
    let order = check_shards(&shards)?;
    let shards: Vec<ShardDirectory> = order.iter().map(|&idx| ShardDirectory::new(&shards[idx])).collect();
    let ids: Vec<&str> = shards[0].manifest.datasets.iter().map(|it| it.id.as_str()).collect();
    let unnamed = format!("{}-{}", compact_utc(Timestamp::now()), ids.join("+"));
    let claimed = claim_unnamed(claim_named(&arguments.output)?, &unnamed, LatestPointer::Update)?;
    let directory = RunDirectory::begin(claimed)?;
    let manifest = whole_manifest(&shards, directory.target());
    let merged = merge_rows(&shards, &manifest, &directory)?;
    write_worst(&shards, &merged.worst, &directory)?;
    let agreement = agreement_of(&shards, &manifest)?;
    refuse_nothing(&manifest, &merged.tally)?;
    let protocols = write_protocols(&directory, &manifest, (&merged.tally, &merged.protocols))?;
    let numbers = write_numbers(&directory, &manifest, &merged.tally)?;
    write_times_of_processors(&directory, &manifest, &merged.of_processors)?;
    let more = protocols.into_iter().chain(write_agreement(&directory, &agreement)?).collect();
    let written = directory.finish()?;
    print_ending((&numbers, &manifest, &merged.tally), (more, &agreement), &written)
}

fn open_shard(directory: &Path) -> Result<NamedShard, Failure> {
    let name = directory.display().to_string();
    if directory.extension().is_some_and(|it| it == "unfinished") {
        let words = format!("{name} is an unfinished shard: give its command again, and merge it then");
        return Err(Failure::NotComparable(words.into()));
    }
    if !directory.is_dir() {
        return Err(Usage(format!("there is no shard {name}")).into());
    }
    let manifest = Manifest::read(&directory.join(MANIFEST_JSON));
    Ok(NamedShard { name, manifest: manifest.map_err(|error| Failure::damaged_run(directory, error))? })
}

/// That of the run in one piece which leaves it in `target`, with the list of `shards`.
fn whole_manifest(shards: &[ShardDirectory<'_>], target: &Path) -> Manifest {
    let manifests = || shards.iter().map(|it| it.manifest);
    let mut whole = shards[0].manifest.clone();
    whole.shard = None;
    whole.shards = manifests().filter_map(|it| it.shard.clone()).collect();
    whole.created = manifests().map(|it| it.created.clone()).min().unwrap_or_default();
    whole.argv = command_of_whole_run(&whole.argv, &target.display().to_string());
    let processors = processors_of(&whole.shards);
    if !processors.is_empty() {
        whole.machine.cpu_model = processors.join("; ");
    }
    for (dataset_idx, entry) in whole.datasets.iter_mut().enumerate() {
        let entries = || manifests().map(|it| &it.datasets[dataset_idx]);
        entry.n_points_left_out = entries().map(|it| it.n_points_left_out).sum();
        let mut skipped: Vec<SkippedScan> = Vec::new();
        for scan in entries().flat_map(|it| &it.skipped_scans) {
            // Every shard that opens a data set leaves out the same end of it.
            if !skipped.contains(scan) {
                skipped.push(scan.clone());
            }
        }
        entry.skipped_scans = skipped;
    }
    for (detector_idx, entry) in whole.detectors.iter_mut().enumerate() {
        // Who had no scan to look at did not introduce itself.
        let introduced = manifests().map(|it| &it.detectors[detector_idx]);
        let introduced =
            { introduced }.find(|it| it.foreign.as_ref().is_some_and(|it| it.reported_name.is_some()));
        if let Some(introduced) = introduced {
            entry.clone_from(introduced);
        }
    }
    whole
}

/// Writes what was seen around the worst mistakes, and where they are recorded.
fn write_worst(
    shards: &[ShardDirectory<'_>],
    worst: &WorstPlaces<usize>,
    directory: &RunDirectory,
) -> Result<(), Failure> {
    let seen = shards.iter().map(ShardDirectory::worst_points).collect::<Result<Vec<WorstPoints>, _>>()?;
    let objects: Vec<(&ObjectName, usize)> =
        worst.lists().flat_map(|(_, places)| places).map(|it| (&it.object, it.kept)).collect();
    let mut patches = Vec::new();
    for (object, shard_idx) in &objects {
        let cells = seen[*shard_idx].around(object).ok_or_else(|| shards[*shard_idx].lacks(object))?;
        patches.push(Patch { object: (*object).clone(), cells: cells.clone() });
    }
    directory.write_file(WORST_POINTS_JSON, WorstPoints::of_patches(patches).to_json().as_bytes())?;
    let mut recorded: Vec<RecordedPlace> = Vec::new();
    for (object, shard_idx) in objects {
        let shard = &shards[shard_idx];
        let place = shard.record().and_then(|it| it.worst_recorded.iter().find(|it| it.object == *object));
        if let Some(place) = place.filter(|_| recorded.iter().all(|it| it.object != *object)) {
            let file = shard.folder.join(&place.recording);
            recorded.push(RecordedPlace { recording: path_from(directory.target(), &file), ..place.clone() });
        }
    }
    if !recorded.is_empty() {
        directory.write_file(RECORDINGS_JSON, Recordings::new(recorded).to_json().as_bytes())?;
    }
    Ok(())
}

/// The path from within `folder`, which need not be there yet, to `file`.
fn path_from(folder: &Path, file: &Path) -> String {
    let absolute = |it: &Path| std::path::absolute(it).unwrap_or_else(|_| it.to_owned());
    let (folder, file) = (absolute(folder), absolute(file));
    let n_common = folder.components().zip(file.components()).take_while(|(one, other)| one == other).count();
    let up = folder.components().skip(n_common).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(file.components().skip(n_common)).collect();
    path.to_string_lossy().into_owned()
}

/// How far detectors agree in the data sets in which no shard has found a label.
fn agreement_of(shards: &[ShardDirectory<'_>], manifest: &Manifest) -> Result<Vec<AgreementRow>, Failure> {
    let mut sums = Vec::new();
    for shard in shards {
        let path = shard.folder.join(AGREEMENT_CSV);
        if path.is_file() {
            let rows = read_rows(&path).map_err(|error| Failure::damaged_run(&shard.folder, error))?;
            add_agreement(&mut sums, rows);
        }
    }
    sums.retain(|it: &AgreementRow| n_labels(manifest, &it.dataset) == 0);
    Ok(sums)
}

/// Annotations of any kind in the scans of the data set called `id`.
fn n_labels(manifest: &Manifest, id: &str) -> u64 {
    let place = manifest.datasets.iter().position(|it| it.id == id);
    let of_shards = manifest.shards.iter().filter_map(|it| Some(it.parts.get(place?)?.n_labels));
    of_shards.sum()
}

/// What a run in one piece says of data sets in which nothing is to be found.
fn refuse_nothing(manifest: &Manifest, tally: &Tally) -> Result<(), Failure> {
    for entry in &manifest.datasets {
        let counts = |task: &Task, detector: &String| tally.counts(&entry.id, *task, detector);
        let n_annotations = tally
            .tasks()
            .iter()
            .flat_map(|task| tally.detectors().iter().filter_map(move |it| Some(counts(task, it)?.no())))
            .max();
        if n_annotations.is_none_or(|it| it == 0) {
            let n_scans = entry.n_scans - entry.skipped_scans.len() as u64;
            tell_of_nothing(&entry.id, n_labels(manifest, &entry.id) > 0, n_scans, &entry.doubts)?;
        }
    }
    Ok(())
}
