//! Judgement of each claim.

use std::sync::atomic::AtomicBool;

use evaluation::run::config::RunConfig;
use reports::files::fixed_decimals::{fixed_decimals, percent, signed_percent};
use reports::numbers::pools::Pool;
use reports::numbers::run_report::{RunReport, Subject};
use reports::numbers::tally::Tally;
use reports::reproduction::claim::{Claim, ClaimTest, Paper, claims};
use reports::reproduction::judged_claim::{JudgedClaim, Seen};
use reports::reproduction::lead::{LeadsOf, Pair, SceneLead, holds_on_all, seen};
use reports::reproduction::steps::{self, Basis, DENIED_RIVALS, RivalReading, STEPS, basis, reading};
use reports::tables::paper_figures::VEHICLE_STEPS;
use reports::uncertainty::sample::Question;
use reports::verdicts::paired_difference::PairedDifference;
use reports::vocabulary::class::Occlusion;
use reports::vocabulary::metric::{LatencyStatistic, Metric};
use reports::vocabulary::slice::Slice;
use reports::vocabulary::task::Task;

use super::METHOD;
use super::observations::{GOOD_FAITH, Observations};
use super::partial_objects::PartialObjects;
use super::settings_study::{CountedPoints, RIVALS, SettingsStudy, criteria, points_by_criterion};
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;

const LETTER: &str = "ν and γ as printed";
const LETTER_DETECTOR: &str = "paper, ν and γ as printed";

/// A run and observations that claims are judged by.
pub struct Judge<'a> {
    tally: &'a Tally,
    report: &'a RunReport,
    leads: &'a LeadsOf<'a>,
    datasets: &'a [OpenedDataset],
    settings: Option<&'a SettingsStudy>,
    // For each criterion but the first: counts of the method, then of its rivals.
    by_criterion: CountedPoints,
    observed: Observations,
    // `None` if the claims of BG are not judged.
    objects: Option<PartialObjects>,
}

impl<'a> Judge<'a> {
    /// Observes the scans of `datasets` for what their run does not show; `tally`, `leads` and `report` are of that run.
    pub fn new(
        (tally, leads, report): (&'a Tally, &'a LeadsOf<'a>, &'a RunReport),
        config: &RunConfig,
        datasets: &'a [OpenedDataset],
        (settings, objects): (Option<&'a SettingsStudy>, Option<PartialObjects>),
        interrupted: &AtomicBool,
    ) -> Result<Self, Failure> {
        let all = [METHOD, RIVALS[0].0, RIVALS[1].0];
        let points = points_by_criterion(config)?.split_off(1);
        let by_criterion =
            CountedPoints::of(config, &all, &["matching.criterion"], points, datasets, interrupted)?;
        let observed = Observations::of(of_first_origin(datasets), config, interrupted)?;
        Ok(Self { tally, report, leads, datasets, settings, by_criterion, observed, objects })
    }

    pub fn claims(&self, papers: &[Paper]) -> Vec<JudgedClaim> {
        let claims = claims().into_iter().filter(|it| papers.contains(&it.paper));
        claims.map(|it| self.judged(it)).collect()
    }

    /// Data sets and numbers of scans, for people.
    pub fn scans_in_words(&self) -> String {
        let of_dataset = |it: &OpenedDataset| {
            let description = it.dataset.description();
            let simulated = if description.is_simulated() { "simulated" } else { "recorded" };
            format!("{} ({simulated}, {} scans)", description.id, it.scan_indices.len())
        };
        self.datasets.iter().map(of_dataset).collect::<Vec<_>>().join(", ")
    }

    fn judged(&self, claim: Claim) -> JudgedClaim {
        let (readings, settings) = match &claim.test {
            ClaimTest::Lead { task, metric, method, rival, scenes } => {
                let pair = Pair { task: *task, method, rival };
                self.lead(pair, &metric.metric(), scenes)
            }
            ClaimTest::LeadsMost { task, method, rival, scenes } => {
                (vec![self.leads_most(Pair { task: *task, method, rival }, scenes)], None)
            }
            ClaimTest::Faster { method, rival, sped_up, at_least } => {
                let sped_up =
                    sped_up.iter().map(|it| (format!("against {it}, made faster"), Basis::Open, it));
                let rivals = [(GOOD_FAITH.to_owned(), Basis::Text, rival)].into_iter().chain(sped_up);
                let faster = |(reading, basis, rival): (String, Basis, &String)| {
                    Some(Seen { reading, basis, ..self.faster(method, rival, *at_least)? })
                };
                (rivals.filter_map(faster).collect(), None)
            }
            ClaimTest::LessJoined { method, rival } => (vec![self.less_joined(method, rival)], None),
            ClaimTest::DensityFalls => (vec![self.observed.density(false)], None),
            ClaimTest::DensityEvened => (vec![self.observed.density(true)], None),
            ClaimTest::PeakOfFitness { from_m, to_m } => {
                (vec![self.observed.peak_of_fitness([*from_m, *to_m])], None)
            }
            ClaimTest::PeakOfFRate { from_m, to_m } => {
                (self.observed.peak_of_f_rate([*from_m, *to_m]).into_iter().collect(), None)
            }
            ClaimTest::LongestStep { step } => (self.longest_step(step).into_iter().collect(), None),
            ClaimTest::TurnedRight { within_deg } => {
                (self.observed.turned_right(*within_deg).into_iter().collect(), None)
            }
            ClaimTest::FrontSpheres => (self.observed.front_spheres().into_iter().collect(), None),
            ClaimTest::MissesAreOccluded { method } => {
                (self.misses_are_occluded(method).into_iter().collect(), None)
            }
            ClaimTest::Partial { claim } => {
                (self.objects.as_ref().map_or_else(Vec::new, |it| it.seen(*claim)), None)
            }
            ClaimTest::None { because } => {
                let numbers = because.clone();
                let reading = String::new();
                let seen =
                    Seen { reading, basis: Basis::Text, numbers, difference: String::new(), holds: None };
                (vec![seen], None)
            }
        };
        JudgedClaim::new(claim, readings, settings)
    }

    fn lead(&self, pair: Pair<'_>, metric: &Metric, scenes: &str) -> (Vec<Seen>, Option<[usize; 2]>) {
        let leads = |pair: Pair<'_>| -> Vec<SceneLead> {
            match scenes {
                "every" => self.leads.on_scenes(pair, metric, ""),
                "overall" => self.leads.overall(pair, metric),
                part => self.leads.on_scenes(pair, metric, part),
            }
        };
        let mut readings = vec![seen(GOOD_FAITH, Basis::Text, &leads(pair))];
        let is_of_tables = RIVALS.contains(&(pair.rival, pair.task)) && *metric == Metric::FRate;
        if pair.method != METHOD || !is_of_tables {
            return (readings, None);
        }
        let letter = Pair { method: LETTER_DETECTOR, ..pair };
        readings.push(seen(LETTER, Basis::Open, &leads(letter)));
        let on_each = scenes == "every";
        let of_points = criteria().iter().skip(1).enumerate();
        let by_criteria = of_points.map(|(idx, criterion)| self.by_criterion(pair, idx, criterion, on_each));
        // They have no interval; where that of good faith rests on too few blocks, theirs would, too.
        let is_known = leads(pair).iter().all(SceneLead::is_known);
        readings.extend(by_criteria.map(|it| Seen { holds: it.holds.filter(|_| is_known), ..it }));
        readings.extend(step_readings(pair, leads));
        (readings, self.settings.and_then(|it| it.n_leading(pair.task, on_each)))
    }

    fn by_criterion(&self, pair: Pair<'_>, point_idx: usize, criterion: &str, on_each: bool) -> Seen {
        let rival_idx = 1 + RIVALS.iter().position(|it| it.0 == pair.rival).expect("it was looked at");
        let scenes: Vec<Vec<usize>> =
            if on_each { (0..self.datasets.len()).map(|it| vec![it]).collect() } else { self.by_origin() };
        let (mut numbers, mut differences, mut holds, mut n_unknown) = (Vec::new(), Vec::new(), true, 0);
        for scene in scenes {
            let rate = |detector_idx| self.by_criterion.f_rate(&scene, point_idx, detector_idx, pair.task);
            let Some((method, rival)) = rate(0).zip(rate(rival_idx)) else {
                n_unknown += 1;
                continue;
            };
            numbers.push(format!("{} against {}", percent(method), percent(rival)));
            differences.push(signed_percent(method - rival));
            holds &= method > rival;
        }
        Seen {
            reading: format!("by {criterion}"),
            basis: Basis::Open,
            numbers: numbers.join("; "),
            difference: differences.join("; "),
            // One scene where it does not hold refutes it; a scene that nothing is known of leaves it open.
            holds: (!numbers.is_empty() && (n_unknown == 0 || !holds)).then_some(holds),
        }
    }

    /// The data sets, recorded and simulated ones apart.
    fn by_origin(&self) -> Vec<Vec<usize>> {
        let is_simulated = |it: &usize| is_simulated(&self.datasets[*it]);
        let (simulated, recorded): (Vec<usize>, Vec<usize>) =
            (0..self.datasets.len()).partition(is_simulated);
        [simulated, recorded].into_iter().filter(|it| !it.is_empty()).collect()
    }

    fn leads_most(&self, pair: Pair<'_>, scenes: &[String]) -> Seen {
        let leads = self.leads.on_scenes(pair, &Metric::FRate, "");
        let is_in = |it: &&SceneLead| scenes.iter().any(|part| it.scene.contains(part.as_str()));
        let (hard, easy): (Vec<_>, Vec<_>) = leads.iter().partition(is_in);
        let points =
            |leads: &[&SceneLead]| leads.iter().map(|it| it.difference.difference()).collect::<Vec<_>>();
        let least = points(&hard).into_iter().reduce(f64::min);
        let most = points(&easy).into_iter().reduce(f64::max);
        let numbers =
            leads.iter().map(|it| format!("{}: {}", it.scene, signed_percent(it.difference.difference())));
        Seen {
            reading: GOOD_FAITH.to_owned(),
            basis: Basis::Text,
            numbers: numbers.collect::<Vec<_>>().join("; "),
            difference: String::new(),
            // A method that is behind leads nowhere the most.
            holds: least.zip(most).map(|(least, most)| least > most.max(0.0)),
        }
    }

    /// The pool of the first data set: all those of its origin.
    fn pool(&self) -> Option<Pool> {
        let first = &self.datasets.first()?.dataset.description().id;
        self.tally.pools().into_iter().find(|it| it.datasets.contains(first))
    }

    /// The median time of a detector, in milliseconds, over the scans of that pool.
    fn median_ms(&self, detector: &str, metric: &Metric) -> Option<f64> {
        let pool = self.pool()?;
        let subject = Subject::of_all(pool.extent.name(), self.report.first_task()?, detector);
        self.report.row(&subject, metric)?.value()
    }

    fn faster(&self, method: &str, rival: &str, at_least: f64) -> Option<Seen> {
        let metric = Metric::Latency(LatencyStatistic::P50);
        let [ours_ms, theirs_ms] = [self.median_ms(method, &metric)?, self.median_ms(rival, &metric)?];
        Some(Seen {
            reading: GOOD_FAITH.to_owned(),
            basis: Basis::Text,
            numbers: format!(
                "{} ms against {} ms in the median",
                fixed_decimals(ours_ms, 2),
                fixed_decimals(theirs_ms, 1)
            ),
            difference: format!("{} times", fixed_decimals(theirs_ms / ours_ms, 1)),
            holds: Some(theirs_ms / ours_ms >= at_least),
        })
    }

    fn less_joined(&self, method: &str, rival: &str) -> Seen {
        let pair = Pair { task: Task::Objects, method, rival };
        let leads = self.leads.overall(pair, &Metric::UnderSegmentation);
        let is_less = |it: &PairedDifference| it.interval.is_some_and(|it| it.ends[1] < 0.0);
        let holds = holds_on_all(&leads, is_less);
        Seen { holds, ..seen(GOOD_FAITH, Basis::Text, &leads) }
    }

    fn longest_step(&self, step: &str) -> Option<Seen> {
        let time_ms = |stages: &[&str]| {
            stages
                .iter()
                .filter_map(|it| self.median_ms(METHOD, &Metric::StageP50((*it).to_owned())))
                .sum::<f64>()
        };
        let times_ms: Vec<(&str, f64)> =
            VEHICLE_STEPS.iter().map(|it| (it.name, time_ms(it.stages))).collect();
        let longest = times_ms.iter().copied().reduce(|best, it| if it.1 > best.1 { it } else { best })?;
        let numbers = times_ms.iter().map(|(name, ms)| format!("{name} {} ms", fixed_decimals(*ms, 2)));
        Some(Seen {
            reading: GOOD_FAITH.to_owned(),
            basis: Basis::Text,
            numbers: numbers.collect::<Vec<_>>().join(", "),
            difference: format!("{} takes the longest", longest.0),
            holds: (longest.1 > 0.0).then_some(longest.0 == step),
        })
    }

    fn misses_are_occluded(&self, method: &str) -> Option<Seen> {
        let pool = self.pool()?;
        let missed = |slice: Slice| {
            let question =
                Question { dataset: pool.extent.name(), task: Task::Vehicles, detector: method, slice };
            let sample = self.leads.sample(&question)?;
            Some([sample.value(&Metric::Mo)?, sample.value(&Metric::No)?])
        };
        let all = missed(Slice::All)?;
        let hidden = missed(Slice::Occlusion(Occlusion::Largely))?;
        let seen_well = missed(Slice::Occlusion(Occlusion::None)).unwrap_or([0.0, 0.0]);
        let share = hidden[0] / all[0].max(1.0);
        Some(Seen {
            reading: GOOD_FAITH.to_owned(),
            basis: Basis::Text,
            numbers: format!(
                "of {} missed vehicles {} are hidden by more than a half; of {} that nothing hides {} are missed",
                all[0], hidden[0], seen_well[1], seen_well[0]
            ),
            difference: format!("{} % of the misses", percent(share)),
            holds: Some(share >= 0.9),
        })
    }
}

/// Readings of `pair` after each of [`STEPS`], against all rivals and, for objects, against each of [`DENIED_RIVALS`]: by
/// basis, fewest steps first. Good faith is seen elsewhere.
fn step_readings<'p>(pair: Pair<'p>, leads: impl Fn(Pair<'p>) -> Vec<SceneLead>) -> Vec<Seen> {
    let after = |step_idx: usize| Pair { method: STEPS[step_idx].detector, ..pair };
    let is_other = |step_idx: &usize| STEPS[*step_idx].detector != steps::GOOD_FAITH;
    let against_all = (0..STEPS.len())
        .filter(is_other)
        .map(|step_idx| seen(&reading(step_idx, None), basis(step_idx, None), &leads(after(step_idx))));
    let denied: &[RivalReading] = if pair.task == Task::Objects { &DENIED_RIVALS } else { &[] };
    let against_denied = denied.iter().flat_map(|rival| {
        (0..STEPS.len()).map(|step_idx| {
            let pair = Pair { rival: rival.detector, ..after(step_idx) };
            seen(&reading(step_idx, Some(rival)), basis(step_idx, Some(rival)), &leads(pair))
        })
    });
    against_all.chain(against_denied).collect()
}

fn is_simulated(opened: &OpenedDataset) -> bool {
    opened.dataset.description().is_simulated()
}

/// The first data sets, as far as they are of one origin: recorded and simulated scans are never put together.
pub fn of_first_origin(datasets: &[OpenedDataset]) -> &[OpenedDataset] {
    let n_first = datasets.iter().take_while(|it| is_simulated(it) == is_simulated(&datasets[0])).count();
    &datasets[..n_first]
}
