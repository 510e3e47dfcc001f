//! The run that the claims of the papers are judged by, and its files.

use std::path::Path;

use clap::Parser as _;
use detector::stage;
use evaluation::run::compared_detector::ComparedDetector;
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::{ListedDetector, built_in_named};
use evaluation::run::scan_recorder::FigureView;
use reports::facts::run_facts::RunFacts;
use reports::files::archive::{ArchiveError, SCHEMA};
use reports::files::csv_rows::csv_of_cells;
use reports::pages::reproduction_page::{PageFigure, ReproductionPage};
use reports::plots::study_plots::settings_plot;
use reports::reproduction::claim::Paper;
use reports::reproduction::judged_claim::JudgedClaim;
use reports::reproduction::lead::LeadsOf;
use reports::reproduction::sensitivity::Sensitivity;
use reports::reproduction::steps::{DENIED_RIVALS, SEARCHED_RIVAL, STEPS};
use reports::run_folder::run_directory::{REPRODUCTION_JSON, RunDirectory};
use reports::tables::formats::format::Format as _;
use reports::tables::sheet::Tabular;
use reports::tables::studies::background_table::BackgroundTable;
use reports::tables::studies::claims_table::{ClaimsTable, lead};
use reports::tables::studies::open_values_table::OpenValuesTable;
use reports::vocabulary::study::Study;

use super::METHOD;
use super::backgrounds::backgrounds;
use super::judge::{Judge, of_first_origin};
use super::partial_objects::PartialObjects;
use super::rate_tables::RateTables;
use super::settings_study::SettingsStudy;
use super::step_losses::StepLosses;
use crate::cli::{PaperName, ReproduceArgs};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::first_look::look_first_at_all;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets};
use crate::plumbing::paper_files::{write_figure, write_table};
use crate::plumbing::recorder::serve_until_interrupted;
use crate::plumbing::reproducible_command::reproducible_command;
use crate::plumbing::run_manifest::refuse_other_scans;
use crate::plumbing::scan_study::ScanStudy;
use crate::plumbing::shards::watched_study::execute_watched;
use crate::plumbing::shards::whole_run::WholeRun;
use crate::plumbing::shards::work_output::{WorkOutput, refuse_what_is_for_whole_runs};
use crate::plumbing::standard_streams::{print_diagnostic, print_result_in, terminal};
use crate::verbs::{Cli, Command};

/// Variants of the method, by their names in the claims, each with the parameter that it sets.
const VARIANTS: [(&str, &str); 3] = [
    ("paper, ν and γ as printed", super::settings_study::LETTER),
    ("paper, coarse level alone", "paper.separation.enabled=false"),
    ("paper, no Hough transform", "paper.walls.enabled=false"),
];

const RIVALS: [&str; 2] = ["kd-tree", "pca"];

/// kd-tree has the boxes of VM section 4, as the method has them: claims by boxes and by centres are about the papers'
/// boxes.
const BOXES_OF_PAPERS: [&str; 2] = ["hierarchical.boxes.outline=false", "hierarchical.boxes.whole=false"];

/// The values of the rivals that the papers leave open, chosen by `--choose` as those of the method are.
const CHOSEN_OF_RIVALS: [&str; 7] = [
    "kd_tree.tolerance_m=0.61",
    "kd_tree.min_points=16",
    "kd_tree.foreground=refined",
    "pca.grid.cell_size_m=0.38",
    "pca.occupancy.min_height_difference_m=0.13",
    "pca.cluster.min_points=14",
    "pca.cluster.max_extent_m=29.0",
];

/// Scans that are recorded, unless more are asked for.
const MOST_RECORDED: usize = 30;

/// Runs the method, its variants and its rivals, judges the claims, and writes and prints the results; or makes a shard of
/// the run.
pub fn papers_run(arguments: &ReproduceArgs) -> Result<(), Failure> {
    refuse_what_is_for_whole_runs(arguments.shard.shard, &arguments.stream)?;
    let output = WorkOutput::claim(Study::Reproduce, arguments.shard.shard, &arguments.output)?;
    let (config, datasets) = open(arguments)?;
    let mut stream = arguments.stream.clone();
    let n_scans: usize = datasets.iter().map(|it| it.part.len()).sum();
    stream.rerun_every.get_or_insert(n_scans.div_ceil(MOST_RECORDED).max(1) as u32);
    let mut study = ScanStudy {
        compared_detectors: compared_detectors(&config)?,
        config,
        datasets,
        selection: arguments.data.scans.as_deref(),
        n_warmup: arguments.timing.warmup,
        n_jobs: arguments.timing.n_jobs(),
        started: output.started,
        staged: None,
        recorded: Some((stream, &FIGURES)),
        pairs: None,
    };
    let Some((made, served)) = execute_watched(&mut study, output)? else { return Ok(()) };
    let ScanStudy { config, mut datasets, .. } = study;
    // The judge looks at scans, too, also at those that were done before.
    for it in &mut datasets {
        it.part = 0..it.scan_indices.len();
    }
    let claims = judge(arguments, &config, &datasets, &made.directory, &made.whole)?;
    let printed = print_claims(&claims, &made.finish()?.0);
    if let Some(served) = served {
        serve_until_interrupted(&*served, interruption_flag());
    }
    printed
}

/// Judges the claims by the merged run of shards, on the scans that their command names.
pub fn merge_reproduction(whole: &WholeRun, directory: RunDirectory) -> Result<(), Failure> {
    let manifest = &whole.facts.manifest;
    let parsed = Cli::try_parse_from(&manifest.argv).map(|it| it.command);
    let Ok(Command::Reproduce(arguments)) = parsed else {
        let line = manifest.argv.join(" ");
        let problem = format!("this program does not understand the command of the shards: `{line}`");
        return Err(Usage(problem).into());
    };
    let (config, datasets) = open(&arguments)?;
    refuse_other_scans(manifest, &datasets, arguments.data.scans.as_deref())?;
    let claims = judge(&arguments, &config, &datasets, &directory, whole)?;
    print_claims(&claims, &directory.finish()?)
}

/// Opens the data sets, and the configuration of all detectors.
pub fn open(arguments: &ReproduceArgs) -> Result<(RunConfig, Vec<OpenedDataset>), Failure> {
    let values = BOXES_OF_PAPERS.iter().chain(&CHOSEN_OF_RIVALS);
    let values: Vec<_> = values.map(|it| it.parse().expect("the list is tested")).collect();
    let mut config = RunConfig::load(None)?.overridden(&values, &[])?;
    let datasets = look_first_at_all(open_datasets(&arguments.data, &config.classes)?, &mut config);
    Ok((config, datasets))
}

/// Judges the claims by `whole`, and writes the results into `directory`.
fn judge(
    arguments: &ReproduceArgs,
    config: &RunConfig,
    datasets: &[OpenedDataset],
    directory: &RunDirectory,
    whole: &WholeRun,
) -> Result<Vec<JudgedClaim>, Failure> {
    let settings = SettingsStudy::run(arguments, config, interruption_flag())?;
    let RunFacts { tally, report, .. } = &whole.facts;
    let leads = LeadsOf::new(tally);
    let rates = RateTables { tally, leads: &leads };
    let of_run = (tally, &leads, report);
    let papers = papers(arguments.paper);
    let of_bg = papers.contains(&Paper::BagOfGraphs);
    let objects =
        of_bg.then(|| PartialObjects::judge(arguments.per_class, interruption_flag())).transpose()?;
    let mut notes = notes(settings.as_ref().map(|it| &it.sensitivity));
    notes.extend(objects.as_ref().map(PartialObjects::note));
    let backgrounds = backgrounds(of_first_origin(datasets), config, interruption_flag())?;
    let beside = (settings.as_ref(), objects);
    let judge = Judge::new(of_run, config, datasets, beside, interruption_flag())?;
    let claims = judge.claims(papers);
    let losses = StepLosses::read(directory, tally)?;
    let written = Written {
        losses: &losses,
        arguments,
        claims: &claims,
        notes: &notes,
        judge: &judge,
        rates: &rates,
        backgrounds: &backgrounds,
        settings: settings.as_ref().map(|it| &it.sensitivity),
    };
    written.write(directory)?;
    Ok(claims)
}

fn print_claims(claims: &[JudgedClaim], finished: &Path) -> Result<(), Failure> {
    let table = terminal().text(&ClaimsTable { claims, notes: &[] });
    let printed = print_result_in("Run directory", finished, format_args!("{table}\n{}", lead(claims)));
    print_diagnostic(format_args!("Claims: {}", finished.join("reproduction.html").display()));
    printed
}

fn papers(name: PaperName) -> &'static [Paper] {
    match name {
        PaperName::Hg => &Paper::ALL[..1],
        PaperName::Vm => &Paper::ALL[1..2],
        PaperName::All => &Paper::ALL,
    }
}

fn compared_detectors(config: &RunConfig) -> Result<Vec<ComparedDetector>, Failure> {
    let method = built_in_named(&[METHOD.to_owned()], config)?[0];
    let rivals = built_in_named(&RIVALS.map(str::to_owned), config)?;
    let variant = |name, chosen: ListedDetector, values: &[&str]| -> Result<ComparedDetector, Failure> {
        let options: Vec<_> = values.iter().map(|it| it.parse().expect("the lists are tested")).collect();
        Ok(ComparedDetector { name, chosen: chosen.into(), config: config.overridden(&options, &[])? })
    };
    let mut compared_detectors = vec![ComparedDetector::of(method, config)];
    for (name, switch) in VARIANTS {
        compared_detectors.push(variant(name, method, &[switch])?);
    }
    let mut values: Vec<&str> = Vec::new();
    for step in STEPS {
        for &value in step.parameters {
            let name = |it: &str| it.split('=').next().map(str::to_owned);
            values.retain(|it| name(it) != name(value));
            values.push(value);
        }
        if step.detector != METHOD {
            compared_detectors.push(variant(step.detector, method, &values)?);
        }
    }
    compared_detectors.extend(rivals.iter().map(|rival| ComparedDetector::of(*rival, config)));
    for rival in DENIED_RIVALS.iter().chain([&SEARCHED_RIVAL]) {
        compared_detectors.push(variant(rival.detector, rivals[0], &[rival.parameter])?);
    }
    Ok(compared_detectors)
}

/// The titles of the tables, task by task.
const TABLES_1: [&str; 2] = ["Table 1 of HG: objects", "Table 1 of VM: vehicles"];
const STEP_TABLES: [&str; 2] = ["Step by step: objects", "Step by step: vehicles"];
const PARTS: [&str; 2] = ["What the data do: objects", "What the data do: vehicles"];

/// Their files.
const STEP_FILES: [&str; 2] = ["steps_objects", "steps_vehicles"];

const LOSSES: [&str; 2] = ["Where objects are lost", "Where vehicles are lost"];
const LOSS_FILES: [&str; 2] = ["losses_objects", "losses_vehicles"];

struct Written<'a> {
    arguments: &'a ReproduceArgs,
    claims: &'a [JudgedClaim],
    notes: &'a [String],
    judge: &'a Judge<'a>,
    rates: &'a RateTables<'a>,
    backgrounds: &'a BackgroundTable,
    settings: Option<&'a Sensitivity>,
    losses: &'a StepLosses,
}

impl Written<'_> {
    fn write(&self, directory: &RunDirectory) -> Result<(), ArchiveError> {
        let Self { arguments, claims, notes, judge, rates, backgrounds, settings, losses } = self;
        let claims_table = ClaimsTable { claims, notes };
        write_table(directory, "reproduction", &claims_table)?;
        let json = serde_json::json!({ "schema": SCHEMA, "claims": claims, "settings": settings });
        directory.write_file(REPRODUCTION_JSON, format!("{json:#}\n").as_bytes())?;
        let by_scene = rates.by_scene();
        let by_step = rates.by_step();
        let by_part = rates.by_part();
        let mut tables: Vec<(&str, &dyn Tabular)> = Vec::new();
        tables.extend(TABLES_1.into_iter().zip(&by_scene).map(|(title, it)| (title, it as &dyn Tabular)));
        tables.extend(STEP_TABLES.into_iter().zip(&by_step).map(|(title, it)| (title, it as &dyn Tabular)));
        tables.extend(PARTS.into_iter().zip(&by_part).map(|(title, it)| (title, it as &dyn Tabular)));
        tables.push(("What the data do: the background of vehicles", *backgrounds));
        for (name, table) in STEP_FILES.into_iter().zip(&by_step) {
            write_table(directory, name, table)?;
        }
        let of_losses = losses.tables();
        tables.extend(LOSSES.into_iter().zip(&of_losses).map(|(title, it)| (title, it as &dyn Tabular)));
        let losses = losses.figures();
        let mut figures: Vec<PageFigure<'_>> = Vec::new();
        for ((stem, title), svg) in LOSS_FILES.into_iter().zip(LOSSES).zip(&losses) {
            write_figure(directory, stem, svg)?;
            figures.push(PageFigure {
                title,
                svg,
                about: "Each bar begins where those before it leave off.",
            });
        }
        let open_values = settings.map(|sensitivity| OpenValuesTable { sensitivity });
        let svg = settings.map(settings_plot);
        if let (Some(table), Some(svg), Some(sensitivity)) = (&open_values, &svg, settings) {
            let about = "The median over all joint settings, with the range of nine in ten of them; of rivals the rate under each \
                         criterion.";
            figures.push(PageFigure { title: "Under every setting", svg, about });
            tables.push(("What the papers leave open", table));
            write_table(directory, "open_values", table)?;
            write_figure(directory, "settings", svg)?;
            directory.write_file("settings.csv", &settings_csv(sensitivity))?;
        }
        let verb = format!("reproduce {}", arguments.paper.name());
        let scans = judge.scans_in_words();
        let options = [
            ("--settings", Some(arguments.settings.to_string())),
            ("--settings-seed", Some(arguments.settings_seed.to_string())),
            ("--per-class", (arguments.paper == PaperName::All).then(|| arguments.per_class.to_string())),
        ];
        let page = ReproductionPage {
            scans: &scans,
            claims,
            notes,
            tables: &tables,
            figures: &figures,
            command: &reproducible_command(&verb, &arguments.data, &options),
        };
        page.write(directory.folder())
    }
}

fn notes(settings: Option<&Sensitivity>) -> Vec<String> {
    let mut notes = vec![
        "good faith: the detector paper, with every value that the papers leave open chosen on training scans. ν and γ as printed: the same \
         with the printed constants of the classifier. to the letter: the first of the steps below. by centre, by bev-iou: the assignment by centres within 2 m, or by boxes from above with an \
         intersection over union of 0.5, where good faith compares points with one of 0.5."
            .to_owned(),
        "A lead holds if the 95 % interval of the difference is above 0: cluster bootstrap over drives, both detectors on the same draws. \
         It is not known where the interval rests on too few blocks. Scenes without the rate, where nothing counts or false detections are \
         not known, are left out."
            .to_owned(),
        "kd-tree finds neighbours in cells, as everywhere in the program. kd-tree, searched looks around every point in a kd-tree, as the library \
         does that HG names: the same components, more slowly."
            .to_owned(),
        "kd-tree and pca have values that were chosen on training scans, too, as those of paper; elsewhere they have those that come with the \
         program."
            .to_owned(),
        "Recorded and simulated scans are judged apart. Times, cells, density, boxes and spheres are of those of the first data set's origin."
            .to_owned(),
        "Neither paper names its scans, and those of Budapest are not public: its 1098 objects and 2076 vehicles cannot be judged again. The \
         rows of KITTI (496 objects, 614 vehicles) are filled by the KITTI folder that you name."
            .to_owned(),
    ];
    notes.extend(settings.map(|it| {
        format!(
            "settings: under how many of {} joint settings of the open values the claim holds, by numbers alone, with the classifier of good \
             faith, on {}.",
            it.settings.len(),
            it.scans
        )
    }));
    notes
}

/// One row for each setting: its values, and the rates of method and rival.
fn settings_csv(sensitivity: &Sensitivity) -> Vec<u8> {
    let Sensitivity { values, settings, rates, .. } = sensitivity;
    let names = values.iter().map(|it| it.parameter.clone());
    let of_rates =
        rates.iter().flat_map(|it| [&it.method, &it.rival].map(|who| format!("{}, {who}", it.name)));
    let written = |rate: Option<f64>| rate.map_or_else(String::new, |it| format!("{it:.4}"));
    let rows = settings.iter().enumerate().map(|(idx, setting)| {
        let found = rates.iter().flat_map(move |it| [it.of_method[idx], it.of_rival[idx]].map(written));
        setting.iter().cloned().chain(found).collect::<Vec<_>>()
    });
    csv_of_cells(names.chain(of_rates).collect(), rows)
}

/// Views of a scan that show the same as figures of the papers; their titles name the figures.
const FIGURES: [FigureView; 7] = [
    view("HG figs. 1, 3: cells, façades as lines", "paper", stage::WALLS),
    view("HG fig. 3: without the Hough transform", "paper, no Hough transform", stage::BOXES),
    view("HG fig. 4: links cut between dense cells", "paper", stage::SEPARATION),
    view("HG fig. 7: coarse level alone", "paper, coarse level alone", stage::BOXES),
    view("HG fig. 7, VM figs. 1, 5: both levels, hulls", "paper", stage::BOXES),
    view("VM figs. 1, 5: principal axes", "pca", stage::BOXES),
    view("VM figs. 6 and 7: spheres and side profiles", "paper", stage::FEATURES),
];

const fn view(title: &'static str, detector: &'static str, stage: &'static str) -> FigureView {
    FigureView { title, detector, stage }
}
