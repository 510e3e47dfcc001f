//! Data sets that the command line names, and the scans taken from them.

use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr as _;
use std::sync::atomic::AtomicBool;

use evaluation::scan_pass::{ScanPass, ScanPassError};
use reports::files::causes::with_causes;
use reports::run_folder::manifest::SkippedScan;
use scans::annotation::ScanId;
use scans::dataset::catalogue::read_catalogue;
use scans::dataset::class_table::{ClassRules, ClassTable};
use scans::dataset::data_sheet::DataSheet;
use scans::dataset::dataset_format::DatasetFormat;
use scans::dataset::mounting::read_transform;
use scans::dataset::scan_selection::ScanSelection;
use scans::dataset::source::{DamagePolicy, TopicChoice};
use scans::dataset::unpaired_files::LeftOut;
use scans::dataset::{Dataset, DatasetDescription, DatasetError};
use simulator::catalogue::{Catalogue, built_in_catalogue};
use simulator::open::{OpenOptions, open_dataset};
use simulator::simulated_street::sensor_named;

use crate::cli::{DatasetArgs, SourceArgs};
use crate::plumbing::counted_dataset::{CountedDataset, PointsLeftOut};
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::frame_facts::{FirstLook, Stated};
use crate::plumbing::progress::progress_over_scans;
use crate::plumbing::remote::local_name;
use crate::plumbing::standard_streams::{print_detail, print_diagnostic};

/// A data set and the scans that are asked for.
pub struct OpenedDataset {
    pub dataset: Box<dyn Dataset>,
    /// Which of its scans, as indices into [`Dataset::scan_ids`].
    pub scan_indices: Vec<usize>,
    /// Which of these are run, as indices among them: all, or those of a shard.
    pub part: Range<usize>,
    /// Scans and files that were left out because they are damaged, when it was opened and later.
    pub skipped: RefCell<Vec<SkippedScan>>,
    /// Points without a position in the scans that have been read.
    pub points_left_out: PointsLeftOut,
    /// Classes that the user gave to names in its labels.
    pub classes: ClassTable,
    /// How far to either side of forward its labels reach, in degrees, if the user said so.
    pub labels_ahead_deg: Option<f32>,
    /// SHA-256 of the file that names blocks of its scans, if the user gave one.
    pub blocks_checksum: Option<String>,
    /// Facts about its sensor that are stated.
    pub stated: Stated,
    /// The look at its first scans, once it was taken.
    pub first_look: FirstLook,
}

impl OpenedDataset {
    pub fn is_simulated(&self) -> bool {
        self.dataset.description().is_simulated()
    }

    /// All scans of `dataset`, whose labels need no explanation.
    pub fn whole(dataset: Box<dyn Dataset>) -> Self {
        let (dataset, points_left_out) = CountedDataset::new(dataset);
        Self {
            scan_indices: (0..dataset.scan_ids().len()).collect(),
            part: 0..dataset.scan_ids().len(),
            dataset: Box::new(dataset),
            skipped: RefCell::default(),
            points_left_out,
            classes: ClassTable::default(),
            labels_ahead_deg: None,
            blocks_checksum: None,
            stated: Stated::ALL,
            first_look: FirstLook::default(),
        }
    }

    /// Returns `error`, by which scan `id` cannot be read; or notes it with a warning if damage is to be skipped.
    pub fn on_damage(
        &self,
        policy: DamagePolicy,
        id: &ScanId,
        error: DatasetError,
    ) -> Result<(), DatasetError> {
        if policy == DamagePolicy::Refuse || error.is_usage_error() {
            return Err(error);
        }
        let reason = with_causes(&error);
        print_diagnostic(format_args!("warning: skipped scan {id}: {reason}"));
        self.skipped.borrow_mut().push(SkippedScan { scan: id.to_string(), reason });
        Ok(())
    }

    /// Result of `look` on the scans, with a bar over them. It ends once `interrupted` is set. Warns of points that were
    /// left out.
    pub fn look<T>(
        &self,
        interrupted: &AtomicBool,
        look: impl FnOnce(ScanPass<'_>) -> Result<T, ScanPassError>,
    ) -> Result<T, Failure> {
        let seen = self.look_unsaid(interrupted, look)?;
        self.warn_of_points_left_out();
        Ok(seen)
    }

    /// As [`Self::look`], but without the warning: for scans about which all has been said before.
    pub fn look_unsaid<T>(
        &self,
        interrupted: &AtomicBool,
        look: impl FnOnce(ScanPass<'_>) -> Result<T, ScanPassError>,
    ) -> Result<T, Failure> {
        let Self { dataset, scan_indices, .. } = self;
        let bar = progress_over_scans(scan_indices.len(), &dataset.description().id);
        let on_scan = || bar.inc(1);
        let seen = look(ScanPass { dataset: &**dataset, scan_indices, interrupted, on_scan: &on_scan })?;
        bar.finish_and_clear();
        Ok(seen)
    }

    /// Warns of points without a position in the scans that have been read, and of scans that have no points.
    pub fn warn_of_points_left_out(&self) {
        if let Some((n_points, n_scans, first)) = self.points_left_out.sum() {
            print_diagnostic(format_args!(
                "warning: skipped {n_points} points without a position in {n_scans} scans of {:?}, first in {}",
                self.dataset.description().id,
                self.dataset.scan_ids()[first]
            ));
        }
        if let Some((n_scans, first)) = self.points_left_out.empty_scans() {
            print_diagnostic(format_args!(
                "warning: {n_scans} scans of {:?} have no points, first {}",
                self.dataset.description().id,
                self.dataset.scan_ids()[first]
            ));
        }
    }

    /// Whether the poses of the sensor are known.
    pub fn has_poses(&self) -> bool {
        let first = self.scan_indices.first();
        first.is_some_and(|&scan_idx| matches!(self.dataset.world_from_sensor(scan_idx), Ok(Some(_))))
    }

    /// Reads all scans and goes on without those that cannot be read, each with a warning.
    pub fn leave_out_damaged(&mut self) -> Result<(), Failure> {
        let mut sound = Vec::with_capacity(self.scan_indices.len());
        for &scan_idx in &self.scan_indices {
            match self.dataset.read_scan(scan_idx) {
                Ok(_) => sound.push(scan_idx),
                Err(error) => {
                    self.on_damage(DamagePolicy::Skip, &self.dataset.scan_ids()[scan_idx], error)?;
                }
            }
        }
        if sound.is_empty() {
            let reason = format!("every scan of {:?} is damaged", self.dataset.description().id);
            return Err(NothingEvaluated { reason }.into());
        }
        self.part = 0..sound.len();
        self.scan_indices = sound;
        Ok(())
    }
}

/// The catalogue at `path`, or the built-in one.
pub fn open_catalogue(path: Option<&Path>) -> Result<Catalogue, Failure> {
    let Some(path) = path else { return Ok(built_in_catalogue()?) };
    read_catalogue(path).map_err(|error| {
        // Missing data have another exit code, but a catalogue is no data.
        if error.is_usage_error() {
            error.into()
        } else {
            Failure::usage("cannot use the catalogue".to_owned(), error)
        }
    })
}

/// Opens all data sets before anything is run, so that a misspelled last one costs nothing. `of_config` are the names of
/// classes in the configuration.
pub fn open_datasets(arguments: &DatasetArgs, of_config: &ClassTable) -> Result<Vec<OpenedDataset>, Failure> {
    open_datasets_past_damage(arguments, DamagePolicy::Refuse, of_config)
}

/// As [`open_datasets`], but with a policy for damaged data.
pub fn open_datasets_past_damage(
    arguments: &DatasetArgs,
    damage: DamagePolicy,
    of_config: &ClassTable,
) -> Result<Vec<OpenedDataset>, Failure> {
    let catalogue = open_catalogue(arguments.source.catalogue.catalogue.as_deref())?;
    let options = OpenOptions { damage, ..open_options(&arguments.source, of_config)? };
    let selection = arguments.scans.as_deref().map(ScanSelection::from_str).transpose()?;
    let mut opened: Vec<OpenedDataset> = Vec::new();
    for name in arguments.datasets.iter().flat_map(|name| catalogue.members(name)) {
        let name = &*local_name(name, arguments.source.cache.as_deref())?;
        let dataset = open_dataset(name, &options, &catalogue)?;
        let id = &dataset.description().id;
        if !opened.iter().all(|it| it.dataset.description().id != *id) {
            return Err(Usage(format!(
                "two data sets are called {id:?}; rename a folder, or give one another id in a catalogue"
            ))
            .into());
        }
        let n_scans = dataset.scan_ids().len();
        let scan_indices = match &selection {
            Some(selection) => selection.positions(n_scans)?,
            None => (0..n_scans).collect(),
        };
        if scan_indices.is_empty() {
            return Err(NothingEvaluated { reason: format!("{id:?} has no scans") }.into());
        }
        print_dataset(dataset.description(), scan_indices.len(), n_scans);
        let skipped = skipped_when_opened(&*dataset);
        if let Some(note) = dataset.note_of_labels() {
            print_diagnostic(format_args!("warning: labels of {:?}: {note}", dataset.description().id));
        }
        let stated = stated(name, &catalogue, &arguments.source, dataset.description())?;
        let (dataset, points_left_out) = CountedDataset::new(dataset);
        opened.push(OpenedDataset {
            dataset: Box::new(dataset),
            part: 0..scan_indices.len(),
            scan_indices,
            skipped: RefCell::new(skipped),
            points_left_out,
            classes: options.of_files().classes_of(name, &catalogue).table,
            labels_ahead_deg: options.labels_ahead_deg,
            blocks_checksum: None,
            stated,
            first_look: FirstLook::default(),
        });
    }
    // Simulated data that are on the disk do not change.
    if opened.iter().all(|it| it.dataset.description().root.is_some()) {
        refuse_simulation(&arguments.source)?;
    }
    // Data that are simulated on the fly have no frame of files.
    if opened.iter().all(|it| it.dataset.description().root.is_none()) && arguments.source.transform.is_some()
    {
        return Err(Usage("--transform is only for recorded data sets, and none is given".to_owned()).into());
    }
    refuse_idle_columns(&opened, &arguments.source)?;
    Ok(opened)
}

/// Refuses `--columns` if no data set has files without names of columns.
fn refuse_idle_columns(opened: &[OpenedDataset], source: &SourceArgs) -> Result<(), Failure> {
    if source.columns.is_none() {
        return Ok(());
    }
    for it in opened {
        if it.dataset.columns()?.is_some() {
            return Ok(());
        }
    }
    Err(Usage("--columns is for .bin and .npy files, and no data set has any".to_owned()).into())
}

/// Scans and files that were left out when `dataset` was opened, with a warning for each.
fn skipped_when_opened(dataset: &dyn Dataset) -> Vec<SkippedScan> {
    let id = &dataset.description().id;
    let mut skipped = Vec::new();
    for LeftOut { name, reason } in dataset.files_left_out() {
        print_diagnostic(format_args!("warning: skipped {name:?} of {id:?}: it {reason}"));
        skipped.push(SkippedScan { scan: name.clone(), reason: format!("it {reason}") });
    }
    if let Some(reason) = dataset.left_out() {
        print_diagnostic(format_args!("warning: skipped the end of {id:?}: it {reason}"));
        skipped.push(SkippedScan { scan: "all that follow".to_owned(), reason: reason.to_owned() });
    }
    skipped
}

fn print_dataset(description: &DatasetDescription, n_taken: usize, n_scans: usize) {
    let DatasetDescription { id, root, sensor, .. } = description;
    let root = root.as_ref().map_or_else(|| "simulated".to_owned(), |it| it.display().to_string());
    print_detail(format_args!("{id}: {n_taken} of {n_scans} scans, sensor {sensor}, {root}"));
}

/// Facts about the sensor of the data set `name` that options, the catalogue, or a data sheet beside the scans state.
pub fn stated(
    name: &str,
    catalogue: &Catalogue,
    source: &SourceArgs,
    description: &DatasetDescription,
) -> Result<Stated, Failure> {
    let folder = description.root.as_deref().filter(|it| it.is_dir());
    let has_sheet = folder.map(DataSheet::in_folder).transpose()?.flatten().is_some();
    let by_options = Stated::by_options(source);
    let is_of_user = source.catalogue.catalogue.is_some();
    Ok(match catalogue.recorded.get(name) {
        // An entry of the user says as much as options do: without it the same is learned from the scans.
        Some(entry) if is_of_user && !has_sheet => {
            let sensor = by_options.sensor || entry.names_sensor;
            Stated { sensor, height: true, ..by_options }
        }
        _ if has_sheet || catalogue.ids().any(|it| it == name) => Stated::ALL,
        _ => by_options,
    })
}

/// The names of classes that `source` has.
pub fn own_classes(source: &SourceArgs) -> ClassTable {
    let mut own = ClassTable::default();
    source.classes.iter().for_each(|it| own.insert(&it.name, it.class));
    own
}

/// How data sets are to be opened; `source` has the last word over `of_config` about names of classes.
pub fn open_options(source: &SourceArgs, of_config: &ClassTable) -> Result<OpenOptions, Failure> {
    if let Some(sensor) = &source.sensor {
        sensor_named(sensor)?;
    }
    Ok(OpenOptions {
        classes: ClassRules { table: own_classes(source).or(of_config), ..ClassRules::default() },
        format: source.format.as_deref().map(DatasetFormat::from_str).transpose()?,
        seed: source.seed,
        n_simulated_scans: source.simulated_scans,
        sensor: source.sensor.clone(),
        sensor_height_m: source.sensor_height,
        labels_ahead_deg: source.labels_ahead,
        columns: source.columns.clone(),
        sensor_from_file: source.transform.as_deref().map(read_transform).transpose()?,
        topics: TopicChoice { cloud: source.topic.clone(), annotations: source.annotation_topic.clone() },
        damage: DamagePolicy::Refuse,
    })
}

/// Refuses options of the simulator, for where nothing is simulated.
pub fn refuse_simulation(source: &SourceArgs) -> Result<(), Failure> {
    let for_simulated =
        [("--seed", source.seed.is_some()), ("--simulated-scans", source.simulated_scans.is_some())];
    match for_simulated.iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => {
            let problem = format!("{option} is only for simulated data sets, and none is given");
            Err(Usage(problem).into())
        }
        None => Ok(()),
    }
}

/// The ids of `datasets`, joined by `+`.
pub fn ids_of(datasets: &[OpenedDataset]) -> String {
    datasets.iter().map(|it| it.dataset.description().id.as_str()).collect::<Vec<_>>().join("+")
}
