//! Observations of scans that figures of the papers show: of the first data set, and those of its origin.

use std::sync::atomic::AtomicBool;

use detector::grid::cell_fitness::FitnessReading;
use detector::grid::density_curve::DensityCurve;
use detector::grid::ring_density::{RingCounts, ring_area_m2, ring_middle_m};
use evaluation::reproduction::observed_scans::{CELL_SIZES_M, ObservedScan, observe};
use evaluation::reproduction::settings::point;
use evaluation::run::box_study::{BoxPair, box_pairs};
use evaluation::run::config::RunConfig;
use evaluation::run::detector_list::built_in_named;
use reports::files::fixed_decimals::{fixed_decimals, percent, signed_percent};
use reports::numbers::rank_correlation::rank_correlation;
use reports::numbers::tally::Tally;
use reports::reproduction::judged_claim::Seen;
use reports::reproduction::steps::Basis;
use reports::vocabulary::extent::OVERALL;
use reports::vocabulary::task::Task;

use super::METHOD;
use super::settings_study::FoundAtPoints;
use crate::plumbing::failure::Failure;
use crate::plumbing::open_datasets::OpenedDataset;

/// Rings of 1 m between these ranges are looked at: nearer, the vehicle itself is seen, farther hardly anything.
const RINGS_M: [f64; 2] = [5.0, 60.0];

/// The reading of the papers under which all of this is seen.
pub const GOOD_FAITH: &str = "good faith";

pub struct Observations {
    // The method at each of [`CELL_SIZES_M`] from 0.3 to 1.2 m.
    by_cell_size: FoundAtPoints,
    scans: Vec<ObservedScan>,
    pairs: Vec<BoxPair>,
    weights: DensityCurve,
}

/// The cell sizes at which the method is run, in metres. HG Fig. 6 b.
fn swept_sizes_m() -> impl Iterator<Item = f32> {
    CELL_SIZES_M.into_iter().filter(|it| (0.3..=1.2).contains(it))
}

impl Observations {
    /// Looks at the scans of `datasets`, all of one origin.
    pub fn of(
        datasets: &[OpenedDataset],
        config: &RunConfig,
        interrupted: &AtomicBool,
    ) -> Result<Self, Failure> {
        let names = ["paper.grid.cell_size_m", "paper.walls.hough.min_length_cells"];
        let at_size = |size_m: f32| {
            // Lines as long as with the printed cells.
            let cells = (7.2 / size_m).round();
            point(config, &names, vec![size_m.to_string(), cells.to_string()])
        };
        let points = swept_sizes_m().map(at_size).collect::<Result<Vec<_>, _>>()?;
        let points = (names.as_slice(), points);
        let by_cell_size =
            FoundAtPoints::of(config, &[METHOD], points, datasets, &Tally::default(), interrupted)?;
        let (mut scans, mut pairs) = (Vec::new(), Vec::new());
        let method = built_in_named(&[METHOD.to_owned()], config)?[0];
        for it in datasets {
            let of_sensor = config.for_scans_of(it.dataset.description());
            let (grid, ground_extent_m) =
                (&config.paper.grid, config.hierarchical.ground.max_ground_extent_m);
            scans.extend(it.look_unsaid(interrupted, |pass| observe(pass, grid, ground_extent_m))?);
            pairs.extend(it.look_unsaid(interrupted, |pass| box_pairs(pass, &method, &of_sensor))?);
        }
        let of_first = config.for_scans_of(datasets[0].dataset.description());
        let weights = of_first.hierarchical.density_weighting.curve;
        Ok(Self { by_cell_size, scans, pairs, weights })
    }

    /// HG Fig. 5: how dense points lie over range, as they are or divided by the weights.
    pub fn density(&self, is_weighted: bool) -> Seen {
        let mut densities: Vec<(f64, f64)> = Vec::new();
        let n_rings = self.scans.first().map_or(0, |it| it.rings.n_points().len());
        for ring_idx in 0..n_rings {
            let middle_m = ring_middle_m(ring_idx);
            let n: u64 =
                self.scans.iter().map(|it: &ObservedScan| RingCounts::n_points(&it.rings)[ring_idx]).sum();
            if (RINGS_M[0]..RINGS_M[1]).contains(&middle_m) && n > 0 {
                let density = n as f64 / (self.scans.len() as f64 * ring_area_m2(ring_idx));
                let weight = if is_weighted { self.weights.weight(middle_m) } else { 1.0 };
                densities.push((middle_m, density / weight));
            }
        }
        let ends = |it: f64, ends: [f64; 2]| [ends[0].min(it), ends[1].max(it)];
        let [low, high] = densities.iter().fold([f64::INFINITY, 0.0], |it, density| ends(density.1, it));
        let correlation = rank_correlation(&densities);
        let per_m2 = if is_weighted { "weighted points" } else { "points" };
        Seen {
            reading: GOOD_FAITH.to_owned(),
            basis: Basis::Text,
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

    /// HG Fig. 6 a: the cell size at which the printed fitness is greatest.
    pub fn peak_of_fitness(&self, within_m: [f64; 2]) -> Seen {
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
            basis: Basis::Text,
            numbers,
            difference,
            holds: Some(inside.len() == values.len() && best.is_some_and(is_peak)),
        }
    }

    /// HG Fig. 6 b: the cell size at which the F-rate is greatest; `None` where false detections are not known.
    pub fn peak_of_f_rate(&self, within_m: [f64; 2]) -> Option<Seen> {
        let rate = |(idx, size_m): (usize, f32)| {
            Some((rounded(size_m), self.by_cell_size.f_rate(idx, OVERALL, METHOD, Task::Objects)?))
        };
        let rates: Vec<(f64, f64)> = swept_sizes_m().enumerate().map(rate).collect::<Option<_>>()?;
        let best = rates.iter().copied().reduce(|best, it| if it.1 > best.1 { it } else { best })?;
        let all = rates.iter().map(|(size_m, rate)| format!("{size_m} m {}", percent(*rate)));
        Some(Seen {
            reading: GOOD_FAITH.to_owned(),
            basis: Basis::Text,
            numbers: all.collect::<Vec<_>>().join("; "),
            difference: format!("greatest at {} m", best.0),
            holds: Some((within_m[0]..=within_m[1]).contains(&best.0)),
        })
    }

    /// VM Fig. 1 and 5: how many boxes are turned as annotated, on the hull and along principal axes; `None` without
    /// vehicles.
    pub fn turned_right(&self, within_deg: f64) -> Option<Seen> {
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
                basis: Basis::Text,
                numbers: format!(
                    "within {within_deg}° of {} matched vehicles: {} of the hull's boxes, {} of those of principal axes",
                    self.pairs.len(),
                    percent(hull as f64 / n),
                    percent(principal as f64 / n)
                ),
                difference: format!("{} ({} to {})", signed_percent(difference), percent(low), percent(high)),
                holds: Some(low > 0.0),
            }
        })
    }

    /// VM Fig. 6: of how many cars the spheres at the front are the larger ones; `None` without cars.
    pub fn front_spheres(&self) -> Option<Seen> {
        let spheres: Vec<[f32; 2]> = self.scans.iter().flat_map(|it| it.spheres_m.iter().copied()).collect();
        let n = spheres.len() as f64;
        (!spheres.is_empty()).then(|| {
            let share = spheres.iter().filter(|it| it[0] > it[1]).count() as f64 / n;
            let half = 1.96 * (share * (1.0 - share) / n).sqrt();
            Seen {
                reading: GOOD_FAITH.to_owned(),
                basis: Basis::Text,
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
}

/// The size to two decimals, such as 0.6, without the error of single precision.
fn rounded(size_m: f32) -> f64 {
    (f64::from(size_m) * 100.0).round() / 100.0
}
