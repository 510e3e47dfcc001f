//! Judgement of each claim.

use std::sync::atomic::AtomicBool;

use detector::stage;
use evaluation::run::config::RunConfig;
use reports::files::fixed_decimals::{fixed_decimals, percent};
use reports::numbers::pools::Pool;
use reports::numbers::run_report::{RunReport, Subject};
use reports::numbers::tally::Tally;
use reports::reproduction::claim::{Claim, ClaimTest, Paper, claims};
use reports::reproduction::judged_claim::{JudgedClaim, Seen};
use reports::reproduction::lead::{LeadsOf, Pair, Reading, holds_on_all, seen, seen_most};
use reports::reproduction::steps::{self, Basis, DENIED_RIVALS, RivalReading, STEPS, basis, reading};
use reports::tables::paper_figures::{PaperStep, VEHICLE_STEPS};
use reports::uncertainty::sample::Question;
use reports::verdicts::paired_difference::PairedDifference;
use reports::vocabulary::class::Occlusion;
use reports::vocabulary::metric::{LatencyStatistic, Metric};
use reports::vocabulary::slice::Slice;
use reports::vocabulary::task::Task;

use super::METHOD;
use super::observations::{GOOD_FAITH, Observations};
use super::partial_objects::PartialObjects;
use super::settings_study::{FoundAtPoints, RIVALS, SettingsStudy, criteria, points_by_criterion};
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
    // The method and its rivals, by each criterion but the first.
    by_criterion: FoundAtPoints,
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
        let points = (["matching.criterion"].as_slice(), points_by_criterion(config)?.split_off(1));
        let by_criterion =
            FoundAtPoints::of(config, &all, points, datasets, &tally.without_rows(), interrupted)?;
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
                let (pair, metric) = (Pair { task: *task, method, rival }, metric.metric());
                let readings = self.readings(pair, |reading, leads, pair| {
                    seen(reading, &leads.on_all(pair, &metric, scenes))
                });
                // They are of the pairs that have other readings.
                let settings = self.settings.filter(|_| readings.len() > 1);
                (readings, settings.and_then(|it| it.n_leading(*task, scenes == "every")))
            }
            ClaimTest::LeadsMost { task, method, rival, scenes } => {
                let pair = Pair { task: *task, method, rival };
                let most = |reading: Reading<'_>, leads: &LeadsOf<'_>, pair: Pair<'_>| {
                    seen_most(reading, &leads.on_scenes(pair, &Metric::FRate, ""), &leads.most(pair, scenes))
                };
                (self.readings(pair, most), None)
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
            ClaimTest::OrderOfSteps { longest, shortest } => (self.order_of_steps(longest, shortest), None),
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

    /// What is `seen` of a pair in good faith, and under the other readings if the tables of the papers are about it.
    fn readings(
        &self,
        pair: Pair<'_>,
        seen: impl Fn(Reading<'_>, &LeadsOf<'_>, Pair<'_>) -> Seen,
    ) -> Vec<Seen> {
        let mut readings = vec![seen((GOOD_FAITH, Basis::Text), self.leads, pair)];
        if pair.method != METHOD || !RIVALS.contains(&(pair.rival, pair.task)) {
            return readings;
        }
        let letter = Pair { method: LETTER_DETECTOR, ..pair };
        readings.push(seen((LETTER, Basis::Open), self.leads, letter));
        let of_criteria = self.by_criterion.tallies().iter().zip(&criteria()[1..]);
        readings.extend(of_criteria.map(|(tally, criterion)| {
            seen((&format!("by {criterion}"), Basis::Open), &LeadsOf::new(tally), pair)
        }));
        readings.extend(step_readings(pair, |reading, pair| seen(reading, self.leads, pair)));
        readings
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
        Seen { holds, ..seen((GOOD_FAITH, Basis::Text), &leads) }
    }

    /// Whether the steps of VM take the longest in the order of `longest`, and `shortest` the least time. Dense cells are
    /// filled where objects are separated; VM 3 has them in the grid.
    fn order_of_steps(&self, longest: &[String], shortest: &str) -> Vec<Seen> {
        let time_ms = |step: &PaperStep, has_dense_level: bool| -> Option<f64> {
            let stages = step.stages.iter().copied().filter(|it| *it != stage::DENSE_LEVEL);
            let stages = stages.chain(has_dense_level.then_some(stage::DENSE_LEVEL));
            stages.map(|it| self.median_ms(METHOD, &Metric::StageP50(it.to_owned()))).sum()
        };
        let seen = |(reading, basis, dense_level_in): (&str, Basis, &str)| {
            let time = |it: &PaperStep| Some((it.name, time_ms(it, it.name == dense_level_in)?));
            let mut times_ms = VEHICLE_STEPS.iter().map(time).collect::<Option<Vec<_>>>()?;
            let numbers = times_ms.iter().map(|(name, ms)| format!("{name} {} ms", fixed_decimals(*ms, 2)));
            let numbers = numbers.collect::<Vec<_>>().join(", ");
            times_ms.sort_by(|a, b| b.1.total_cmp(&a.1));
            let names: Vec<&str> = times_ms.iter().map(|it| it.0).collect();
            let is_printed = names.iter().zip(longest).all(|(name, printed)| name == printed);
            Some(Seen {
                reading: reading.to_owned(),
                basis,
                numbers,
                difference: format!("from the longest: {}", names.join(", ")),
                holds: Some(is_printed && names.last() == Some(&shortest)),
            })
        };
        let dense_cells = ("dense cells belong to the grid", Basis::Open, "grid");
        [(GOOD_FAITH, Basis::Text, "separation"), dense_cells].into_iter().filter_map(seen).collect()
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

/// What is `seen` of `pair` after each of [`STEPS`], against all rivals and, for objects, against each of
/// [`DENIED_RIVALS`]: by basis, fewest steps first. Good faith is seen elsewhere.
fn step_readings(pair: Pair<'_>, seen: impl Fn(Reading<'_>, Pair<'_>) -> Seen) -> Vec<Seen> {
    let after = |step_idx: usize, rival: Option<&RivalReading>| {
        let pair = Pair { method: STEPS[step_idx].detector, ..pair };
        let pair = rival.map_or(pair, |it| Pair { rival: it.detector, ..pair });
        seen((&reading(step_idx, rival), basis(step_idx, rival)), pair)
    };
    let is_other = |step_idx: &usize| STEPS[*step_idx].detector != steps::GOOD_FAITH;
    let against_all = (0..STEPS.len()).filter(is_other).map(|it| after(it, None));
    let denied: &[RivalReading] = if pair.task == Task::Objects { &DENIED_RIVALS } else { &[] };
    let against_denied = denied.iter().flat_map(|rival| (0..STEPS.len()).map(|it| after(it, Some(rival))));
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
