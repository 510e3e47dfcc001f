//! Setup of a sweep, whole or in parts: points, detectors, data sets.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;

use evaluation::journal::Journal;
use evaluation::protocols::chosen_protocols::ChosenProtocols;
use evaluation::sweep::quality_pass::{SweepError, SweepPass, SweptDataset};
use evaluation::sweep::scan_at_point::JournalEntry;
use evaluation::sweep::sweep_plan::SweepPlan;
use evaluation::sweep::timing_pass::DETECTIONS_PER_SCAN;
use jiff::Timestamp;
use reports::run_folder::manifest::Manifest;
use reports::run_folder::sweep_entry::{SweepEntry, SweptParameter};
use scans::dataset::source::DamagePolicy;

use crate::cli::{ConfigArgs, SweepArgs};
use crate::plumbing::config::{
    choose_matching, hide_run, refuse_unread_models, runnable_detectors, warn_of_unknown_sensor,
};
use crate::plumbing::failure::Failure;
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::judged_streets::advise_on_judged;
use crate::plumbing::named_blocks::with_named_blocks;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets_past_damage};
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::provenance::machine;
use crate::plumbing::run_manifest::{RunSettings, detector_entries, run_manifest};

/// Points, detectors and data sets of a sweep.
pub struct Sweep<'a> {
    pub arguments: &'a SweepArgs,
    /// Points and detectors.
    pub plan: SweepPlan,
    /// Protocols that it is evaluated by, too, if any.
    pub protocols: Option<ChosenProtocols>,
    pub datasets: Vec<OpenedDataset>,
    /// Scans at points that were counted before, by their keys.
    pub counted: BTreeSet<[usize; 3]>,
    /// Scans that were timed before, by their keys.
    pub timed: BTreeSet<(usize, usize)>,
    pub started: Timestamp,
}

pub fn sweep_plan(arguments: &SweepArgs) -> Result<SweepPlan, Failure> {
    let file = ConfigArgs { config: arguments.config.clone(), parameters: Vec::new() };
    let (detectors, mut config) = runnable_detectors(&file, &arguments.detectors)?;
    choose_matching(&mut config, &arguments.matching)?;
    arguments.output.output.iter().for_each(|it| hide_run(it, &mut config));
    let lists: Vec<SweptParameter> = arguments.lists.iter().map(|it| it.0.clone()).collect();
    let plan = SweepPlan::new(&config, detectors, &arguments.parameters, &lists)?;
    let at_points = |it| plan.points.iter().map(move |point| (it, &point.config));
    refuse_unread_models(plan.detectors.iter().flat_map(at_points))?;
    Ok(plan)
}

impl<'a> Sweep<'a> {
    /// Opens the data sets for `plan`.
    pub fn open(arguments: &'a SweepArgs, mut plan: SweepPlan, started: Timestamp) -> Result<Self, Failure> {
        let policy = arguments.damage.policy();
        let datasets = open_datasets_past_damage(&arguments.data, policy, &plan.base.classes)?;
        let mut datasets = with_named_blocks(datasets, arguments.blocks.blocks.as_deref())?;
        if policy == DamagePolicy::Skip {
            // Threads take scans in any order: it has to be known before which scans can be read.
            datasets.iter_mut().try_for_each(OpenedDataset::leave_out_damaged)?;
        }
        advise_on_judged(&datasets)?;
        let datasets = look_first_at_all(datasets, &mut plan.base);
        for point in &mut plan.points {
            point.config.own_curves.clone_from(&plan.base.own_curves);
            point.config.places_of_labels.clone_from(&plan.base.places_of_labels);
        }
        let protocols = ChosenProtocols::of(&arguments.protocol.protocols);
        for opened in &datasets {
            warn_of_unknown_sensor(&plan.base, opened.dataset.description());
            if let Some(protocols) = &protocols {
                protocols.check(&*opened.dataset)?;
            }
        }
        let (counted, timed) = (BTreeSet::new(), BTreeSet::new());
        Ok(Self { arguments, plan, protocols, datasets, counted, timed, started })
    }

    pub fn swept_datasets(&self) -> Vec<SweptDataset<'_>> {
        let mut swept = Vec::new();
        for OpenedDataset { dataset, scan_indices, part, .. } in &self.datasets {
            swept.push(SweptDataset { dataset: &**dataset, scan_indices, part: part.clone() });
        }
        swept
    }

    /// How many results there are to come: scans at points.
    pub fn n_results(&self) -> usize {
        self.datasets.iter().map(|it| it.part.len()).sum::<usize>() * self.plan.points.len()
    }

    /// Does the work that is left, and keeps it in `journal`.
    pub fn run(&self, journal: &Journal) -> Result<(), SweepError> {
        let Self { counted, timed, .. } = self;
        let pass = SweepPass {
            plan: &self.plan,
            datasets: &self.swept_datasets(),
            protocols: self.protocols.as_ref(),
            interrupted: interruption_flag(),
        };
        let bar = progress_over_results(self.n_results(), counted.len(), "counting");
        pass.count(counted, self.n_jobs(), &|scan| {
            journal.add(&JournalEntry::Quality(scan))?;
            bar.inc(1);
            Ok(())
        })?;
        bar.finish_and_clear();
        let n_timed = self.arguments.timed_scans as usize;
        let per_scan = self.plan.points.len() * self.plan.detectors.len();
        let n_timings = pass.timed_scans(n_timed).len() * per_scan;
        let bar = progress_over_results(n_timings, timed.len() * per_scan, "timing");
        let processor = machine().cpu_model;
        pass.time(timed, n_timed, &processor, || bar.inc(1), &|it| journal.add(&JournalEntry::Times(it)))?;
        bar.finish_and_clear();
        Ok(())
    }

    fn n_jobs(&self) -> usize {
        let n_cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        self.arguments.jobs.map_or_else(n_cores, usize::from)
    }

    pub fn manifest(&self) -> Manifest {
        let mut manifest = run_manifest(RunSettings {
            selection: self.arguments.data.scans.as_deref(),
            n_warmup: 1,
            n_repeats: NonZeroUsize::MIN,
            config: &self.plan.base,
            detectors: detector_entries(&self.plan.detectors, &self.plan.base),
            datasets: &self.datasets,
            protocols: &self.arguments.protocol.protocols,
            started: self.started,
        });
        // Which scans have been read depends on where the sweep was taken up.
        manifest.datasets.iter_mut().for_each(|it| it.n_points_left_out = 0);
        Manifest { sweep: Some(self.entry()), ..manifest }
    }

    fn entry(&self) -> SweepEntry {
        let SweepPlan { swept, tied, points, base, .. } = &self.plan;
        SweepEntry {
            swept: swept.clone(),
            tied: tied.clone(),
            points: points.iter().map(|it| it.values.clone()).collect(),
            configured: base.value_of(&swept[0].name).map(ToString::to_string),
            n_timed_scans_per_data_set: self.arguments.timed_scans,
            n_timed_detections_per_scan_and_point: DETECTIONS_PER_SCAN as u32,
        }
    }
}
