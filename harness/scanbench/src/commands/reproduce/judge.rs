//! What is seen of each claim.

use std::sync::atomic::AtomicBool;

use detector::grid::cell_fitness::FitnessReading;
use detector::grid::ring_density::{RingCounts, ring_area_m2, ring_middle_m};
use evaluation::reproduction::observed_scans::{CELL_SIZES_M, ObservedScan, observe};
use evaluation::reproduction::settings::point;
use evaluation::run::box_study::{BoxPair, box_pairs};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::built_in_named;
use reports::files::fixed_decimals::fixed_decimals;
use reports::numbers::pools::Pool;
use reports::numbers::rank_correlation::rank_correlation;
use reports::numbers::run_report::{RunReport, Subject};
use reports::numbers::tally::Tally;
use reports::reproduction::claim::{Claim, ClaimTest, Paper, claims};
use reports::reproduction::judged_claim::{JudgedClaim, Seen};
use reports::reproduction::lead::{LeadsOf, Pair, SceneLead, holds_on_all, seen};
use reports::tables::paper_figures::VEHICLE_STEPS;
use reports::uncertainty::sample::Question;
use reports::verdicts::paired_difference::PairedDifference;
use reports::vocabulary::class::Occlusion;
use reports::vocabulary::metric::{LatencyStatistic, Metric};
use reports::vocabulary::slice::Slice;
use reports::vocabulary::task::Task;

use super::METHOD;
use super::settings_study::{CountedPoints, RIVALS, SettingsStudy, criteria, points_by_criterion};
use crate::commands::failure::Failure;
use crate::commands::open_datasets::OpenedDataset;

const GOOD_FAITH: &str = "good faith";
const LETTER: &str = "to the letter";
const LETTER_DETECTOR: &str = "paper, to the letter";

/// Rings of 1 m from here to there are looked at: nearer the vehicle itself is seen, farther hardly anything.
const RINGS_M: [f64; 2] = [5.0, 60.0];

/// What was run and observed, to judge claims by.
pub struct Judge<'a> {
    tally: &'a Tally,
    report: &'a RunReport,
    config: &'a RunConfig,
    leads: &'a LeadsOf<'a>,
    datasets: &'a [OpenedDataset],
    settings: Option<&'a SettingsStudy>,
    // Of each criterion but the first: the method, then its rivals.
    by_criterion: CountedPoints,
    // The method at each of [`CELL_SIZES_M`] from 0.3 to 1.2 m.
    by_cell_size: CountedPoints,
    scans: Vec<ObservedScan>,
    pairs: Vec<BoxPair>,
}

/// The cell sizes at which the method is run, in metres. HG Fig. 6 b.
fn swept_sizes_m() -> impl Iterator<Item = f32> {
    CELL_SIZES_M.into_iter().filter(|it| (0.3..=1.2).contains(it))
}

impl<'a> Judge<'a> {
    /// Looks at the scans of `datasets`, of which `tally` and `report` are those of a run, for what a run does not show.
    pub fn new(
        (tally, leads, report): (&'a Tally, &'a LeadsOf<'a>, &'a RunReport),
        config: &'a RunConfig,
        datasets: &'a [OpenedDataset],
        settings: Option<&'a SettingsStudy>,
        interrupted: &AtomicBool,
    ) -> Result<Self, Failure> {
        let all = [METHOD, RIVALS[0].0, RIVALS[1].0];
        let points = points_by_criterion(config)?.split_off(1);
        let by_criterion =
            CountedPoints::of((config, &all), (&["matching.criterion"], points), datasets, interrupted)?;
        let names = ["paper.grid.cell_size_m", "paper.walls.hough.min_length_cells"];
        let at_size = |size_m: f32| {
            // Lines as long as with the printed cells.
            let cells = (7.2 / size_m).round();
            point(config, &names, vec![size_m.to_string(), cells.to_string()])
        };
        let points = swept_sizes_m().map(at_size).collect::<Result<Vec<_>, _>>()?;
        // Recorded and simulated scans are never put together: of scans alone, those of the first origin count.
        let n_first = datasets.iter().take_while(|it| is_simulated(it) == is_simulated(&datasets[0])).count();
        let first = &datasets[..n_first];
        let by_cell_size = CountedPoints::of((config, &[METHOD]), (&names, points), first, interrupted)?;
        let (mut scans, mut pairs) = (Vec::new(), Vec::new());
        let method = built_in_named(&[METHOD.to_owned()], config)?[0];
        for it in first {
            let description = it.dataset.description();
            let of_sensor = config.for_scans_of(description);
            let (grid, ground_extent_m) =
                (&config.paper.grid, config.hierarchical.ground.max_ground_extent_m);
            scans.extend(it.look_unsaid(interrupted, |pass| observe(pass, grid, ground_extent_m))?);
            pairs.extend(it.look_unsaid(interrupted, |pass| box_pairs(pass, &method, &of_sensor))?);
        }
        Ok(Self {
            tally,
            report,
            config,
            leads,
            datasets,
            settings,
            by_criterion,
            by_cell_size,
            scans,
            pairs,
        })
    }

    /// All claims of `papers`, judged.
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
            ClaimTest::Faster { method, rival, at_least } => {
                (self.faster(method, rival, *at_least).into_iter().collect(), None)
            }
            ClaimTest::LessJoined { method, rival } => (vec![self.less_joined(method, rival)], None),
            ClaimTest::DensityFalls => (vec![self.density(false)], None),
            ClaimTest::DensityEvened => (vec![self.density(true)], None),
            ClaimTest::PeakOfFitness { from_m, to_m } => (vec![self.peak_of_fitness([*from_m, *to_m])], None),
            ClaimTest::PeakOfFRate { from_m, to_m } => {
                (self.peak_of_f_rate([*from_m, *to_m]).into_iter().collect(), None)
            }
            ClaimTest::LongestStep { step } => (self.longest_step(step).into_iter().collect(), None),
            ClaimTest::TurnedRight { within_deg } => {
                (self.turned_right(*within_deg).into_iter().collect(), None)
            }
            ClaimTest::FrontSpheres => (self.front_spheres().into_iter().collect(), None),
            ClaimTest::MissesAreOccluded { method } => {
                (self.misses_are_occluded(method).into_iter().collect(), None)
            }
            ClaimTest::None { because } => {
                let numbers = because.clone();
                let seen = Seen { reading: String::new(), numbers, difference: String::new(), holds: None };
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
        let mut readings = vec![seen(GOOD_FAITH, &leads(pair))];
        let is_of_tables = RIVALS.contains(&(pair.rival, pair.task)) && *metric == Metric::FRate;
        if pair.method != METHOD || !is_of_tables {
            return (readings, None);
        }
        let letter = Pair { method: LETTER_DETECTOR, ..pair };
        readings.push(seen(LETTER, &leads(letter)));
        let on_each = scenes == "every";
        let of_points = criteria().iter().skip(1).enumerate();
        readings.extend(of_points.map(|(idx, criterion)| self.by_criterion(pair, (idx, criterion), on_each)));
        (readings, self.settings.and_then(|it| it.n_leading(pair.task, on_each)))
    }

    fn by_criterion(&self, pair: Pair<'_>, (point_idx, criterion): (usize, &str), on_each: bool) -> Seen {
        let rival_idx = 1 + RIVALS.iter().position(|it| it.0 == pair.rival).expect("it was looked at");
        let scenes: Vec<Vec<usize>> =
            if on_each { (0..self.datasets.len()).map(|it| vec![it]).collect() } else { self.by_origin() };
        let (mut numbers, mut differences, mut holds) = (Vec::new(), Vec::new(), true);
        for scene in scenes {
            let rate = |detector_idx| self.by_criterion.f_rate(&scene, point_idx, detector_idx, pair.task);
            // As in the leads of the run, where the rate is undefined there is none.
            let Some((method, rival)) = rate(0).zip(rate(rival_idx)) else { continue };
            numbers.push(format!("{} against {}", percent(method), percent(rival)));
            differences.push(signed(method - rival));
            holds &= method > rival;
        }
        Seen {
            reading: format!("by {criterion}"),
            numbers: numbers.join("; "),
            difference: differences.join("; "),
            holds: (!numbers.is_empty()).then_some(holds),
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
        let numbers = leads.iter().map(|it| format!("{}: {}", it.scene, signed(it.difference.difference())));
        Seen {
            reading: GOOD_FAITH.to_owned(),
            numbers: numbers.collect::<Vec<_>>().join("; "),
            difference: String::new(),
            // Who is behind leads nowhere the most.
            holds: least.zip(most).map(|(least, most)| least > most.max(0.0)),
        }
    }

    /// What the first data set is put together with: those of its origin.
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
        Seen { holds, ..seen(GOOD_FAITH, &leads) }
    }

    fn density(&self, is_weighted: bool) -> Seen {
        let mut densities: Vec<(f64, f64)> = Vec::new();
        let curve = self.datasets.first().map(|it| self.config.for_scans_of(it.dataset.description()));
        let n_rings = self.scans.first().map_or(0, |it| it.rings.n_points().len());
        for ring_idx in 0..n_rings {
            let middle_m = ring_middle_m(ring_idx);
            let n: u64 =
                self.scans.iter().map(|it: &ObservedScan| RingCounts::n_points(&it.rings)[ring_idx]).sum();
            if (RINGS_M[0]..RINGS_M[1]).contains(&middle_m) && n > 0 {
                let density = n as f64 / (self.scans.len() as f64 * ring_area_m2(ring_idx));
                let weight = curve.as_ref().filter(|_| is_weighted);
                let weight =
                    weight.map_or(1.0, |it| it.hierarchical.density_weighting.curve.weight(middle_m));
                densities.push((middle_m, density / weight));
            }
        }
        let ends = |it: f64, ends: [f64; 2]| [ends[0].min(it), ends[1].max(it)];
        let [low, high] = densities.iter().fold([f64::INFINITY, 0.0], |it, density| ends(density.1, it));
        let correlation = rank_correlation(&densities);
        let per_m2 = if is_weighted { "weighted points" } else { "points" };
        Seen {
            reading: GOOD_FAITH.to_owned(),
            numbers: format!(
                "{} to {} {per_m2} per m² and scan from {} to {} m",
                fixed_decimals(low, 2),
                fixed_decimals(high, 1),
                RINGS_M[0],
                RINGS_M[1]
            ),
            difference: if is_weighted {
                format!("the greatest is {} times the least", fixed_decimals(high / low, 1))
            } else {
                format!("rank correlation with range {}", fixed_decimals(correlation.unwrap_or(0.0), 2))
            },
            holds: if is_weighted { Some(high / low <= 10.0) } else { correlation.map(|it| it < -0.9) },
        }
    }

    fn peak_of_fitness(&self, within_m: [f64; 2]) -> Seen {
        let fitness = |size_idx: usize| {
            let ratios = self.scans.iter().map(|it| FitnessReading::Printed.ratio(&it.cells[size_idx]));
            let [over, under] = ratios.fold([0.0, 0.0], |sum, it| [sum[0] + it[0], sum[1] + it[1]]);
            (under != 0.0).then(|| over / under)
        };
        let values: Vec<(f64, Option<f64>)> =
            CELL_SIZES_M.iter().enumerate().map(|(idx, size_m)| (rounded(*size_m), fitness(idx))).collect();
        let inside = values.iter().filter(|it| it.1.is_some_and(|it| (0.0..=1.0).contains(&it)));
        let inside: Vec<(f64, f64)> = inside.filter_map(|it| Some((it.0, it.1?))).collect();
        let best = inside.iter().copied().reduce(|best, it| if it.1 > best.1 { it } else { best });
        let at = values.iter().find(|it| (it.0 - 0.6).abs() < 1e-6).and_then(|it| it.1);
        let numbers = at.map_or_else(String::new, |it| format!("at 0.6 m it is {}", fixed_decimals(it, 3)));
        let difference = match best {
            Some((size_m, value)) => {
                format!(
                    "within 0 to 1 at {} of {} sizes; greatest {} at {size_m} m",
                    inside.len(),
                    values.len(),
                    fixed_decimals(value, 3)
                )
            }
            None => format!("within 0 to 1 at none of {} sizes from 0.2 to 2.0 m", values.len()),
        };
        let is_peak = |(size_m, _): (f64, f64)| (within_m[0]..=within_m[1]).contains(&size_m);
        Seen {
            reading: GOOD_FAITH.to_owned(),
            numbers,
            difference,
            holds: Some(inside.len() == values.len() && best.is_some_and(is_peak)),
        }
    }

    fn peak_of_f_rate(&self, within_m: [f64; 2]) -> Option<Seen> {
        let all: Vec<usize> = (0..self.by_cell_size.n_datasets()).collect();
        let rate = |(idx, size_m): (usize, f32)| {
            Some((rounded(size_m), self.by_cell_size.f_rate(&all, idx, 0, Task::Objects)?))
        };
        let rates: Vec<(f64, f64)> = swept_sizes_m().enumerate().map(rate).collect::<Option<_>>()?;
        let best = rates.iter().copied().reduce(|best, it| if it.1 > best.1 { it } else { best })?;
        let all = rates.iter().map(|(size_m, rate)| format!("{size_m} m {}", percent(*rate)));
        Some(Seen {
            reading: GOOD_FAITH.to_owned(),
            numbers: all.collect::<Vec<_>>().join("; "),
            difference: format!("greatest at {} m", best.0),
            holds: Some((within_m[0]..=within_m[1]).contains(&best.0)),
        })
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
            numbers: numbers.collect::<Vec<_>>().join(", "),
            difference: format!("{} takes the longest", longest.0),
            holds: (longest.1 > 0.0).then_some(longest.0 == step),
        })
    }

    fn turned_right(&self, within_deg: f64) -> Option<Seen> {
        let n = self.pairs.len();
        let is_right =
            |fit_idx: usize| move |it: &&BoxPair| it.errors[fit_idx].yaw_rad.to_degrees() <= within_deg;
        let [hull, principal] = [0, 1].map(|fit_idx| self.pairs.iter().filter(is_right(fit_idx)).count());
        let only_hull = self.pairs.iter().filter(is_right(0)).filter(|it| !is_right(1)(it)).count() as f64;
        let only_principal =
            self.pairs.iter().filter(is_right(1)).filter(|it| !is_right(0)(it)).count() as f64;
        (n > 0).then(|| {
            let n = n as f64;
            let difference = (only_hull - only_principal) / n;
            let spread = (only_hull + only_principal - n * difference * difference).max(0.0).sqrt() / n;
            let [low, high] = [-1.96, 1.96].map(|it| difference + it * spread);
            Seen {
                reading: GOOD_FAITH.to_owned(),
                numbers: format!(
                    "within {within_deg}° of {} matched vehicles: {} of the hull's boxes, {} of those of principal axes",
                    self.pairs.len(),
                    percent(hull as f64 / n),
                    percent(principal as f64 / n)
                ),
                difference: format!("{} ({} to {})", signed(difference), percent(low), percent(high)),
                holds: Some(low > 0.0),
            }
        })
    }

    fn front_spheres(&self) -> Option<Seen> {
        let spheres: Vec<[f32; 2]> = self.scans.iter().flat_map(|it| it.spheres_m.iter().copied()).collect();
        let n = spheres.len() as f64;
        (!spheres.is_empty()).then(|| {
            let share = spheres.iter().filter(|it| it[0] > it[1]).count() as f64 / n;
            let half = 1.96 * (share * (1.0 - share) / n).sqrt();
            Seen {
                reading: GOOD_FAITH.to_owned(),
                numbers: format!(
                    "front larger in {} % of {} annotated cars that are seen from end to end with 200 points and more",
                    percent(share),
                    spheres.len()
                ),
                difference: format!("{} to {} %", percent(share - half), percent((share + half).min(1.0))),
                holds: Some(share - half > 0.5),
            }
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
            numbers: format!(
                "of {} missed vehicles {} are hidden by more than a half; of {} that nothing hides {} are missed",
                all[0], hidden[0], seen_well[1], seen_well[0]
            ),
            difference: format!("{} % of the misses", percent(share)),
            holds: Some(share >= 0.9),
        })
    }
}

fn is_simulated(opened: &OpenedDataset) -> bool {
    opened.dataset.description().is_simulated()
}

fn percent(share: f64) -> String {
    fixed_decimals(100.0 * share, 1)
}

fn signed(share: f64) -> String {
    format!("{}{}", if share > 0.0 { "+" } else { "" }, percent(share))
}

/// 0.6, and not what single precision makes of it.
fn rounded(size_m: f32) -> f64 {
    (f64::from(size_m) * 100.0).round() / 100.0
}
