//! The points of a sweep: every combination of the swept values, each with its parameters.

use std::collections::BTreeSet;

use reports::run_folder::sweep_entry::{SweptParameter, entrant_name};
use toml::Value;

use crate::process::problem::DetectorFailure;
use crate::run::config::override_option::OverrideOption;
use crate::run::config::{ConfigError, RunConfig};
use crate::run::detector_list::ChosenDetector;
use crate::sweep::swept_values::{SweepOption, TiedValue};

/// Greatest number of points of a sweep; more are taken for a typing error.
const MOST_POINTS: usize = 100_000;

/// Detectors and points of a sweep.
#[derive(Debug, Clone)]
pub struct SweepPlan {
    /// The detectors, in the order of the tables.
    pub detectors: Vec<ChosenDetector>,
    /// The swept parameters by their full names, each with its values; the first is the axis of plots.
    pub swept: Vec<SweptParameter>,
    /// Full names of the parameters that are tied to a swept one.
    pub tied: Vec<String>,
    /// Every combination of values; those of the last swept parameter change fastest.
    pub points: Vec<SweepPoint>,
    /// The parameters without the swept and tied values.
    pub base: RunConfig,
}

/// One combination of values.
#[derive(Debug, Clone)]
pub struct SweepPoint {
    /// The value of each swept parameter, and then of each tied one.
    pub values: Vec<String>,
    /// All parameters.
    pub config: RunConfig,
}

/// Why there is no plan.
#[derive(Debug, thiserror::Error)]
pub enum SweepPlanError {
    /// A parameter does not exist, or has a value that cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// No parameter has several values.
    #[error(
        "no parameter is swept; give one a range, such as -P cell_size_m=0.2:2.0:0.1, or a list, such as -L xi=2,3"
    )]
    NothingSwept,
    /// A parameter is tied to one that is not swept.
    #[error("{name} is divided by {divisor}, which is not swept; swept are {}", swept.join(", "))]
    TiedToNothing {
        /// The tied parameter.
        name: String,
        /// The parameter it is tied to.
        divisor: String,
        /// The swept parameters.
        swept: Vec<String>,
    },
    /// A parameter is tied to one with a value that is no number above 0.
    #[error("{name} is divided by {divisor}, which has the value {value}; it must be a number above 0")]
    TiedToWord {
        /// The tied parameter.
        name: String,
        /// The parameter it is tied to.
        divisor: String,
        /// This value.
        value: String,
    },
    /// Too many combinations.
    #[error("{n_points} combinations of values are too many; the most is {MOST_POINTS}")]
    TooManyPoints {
        /// Number of combinations.
        n_points: usize,
    },
    /// Two equal values of a parameter.
    #[error("the values {first} and {second} of {name} are equal")]
    SamePoint {
        /// The parameter.
        name: String,
        /// The first way its value is written.
        first: String,
        /// The second way.
        second: String,
    },
}

impl SweepPlan {
    /// The failure, with the values of the point in the name of the detector.
    pub fn at_point(&self, point_idx: usize, failure: DetectorFailure) -> DetectorFailure {
        let values = self.parameters().into_iter().zip(&self.points[point_idx].values);
        let values: Vec<String> = values.map(|(name, value)| format!("{name} = {value}")).collect();
        DetectorFailure { detector: format!("{} with {}", failure.detector, values.join(", ")), ..failure }
    }

    /// Plans the points that `options` and then `lists` span over the parameters of `config`.
    ///
    /// # Errors
    ///
    /// [`SweepPlanError`] if a name is unknown, nothing is swept, or any point cannot be used: before any detector runs.
    pub fn new(
        config: &RunConfig,
        detectors: Vec<ChosenDetector>,
        options: &[SweepOption],
        lists: &[SweptParameter],
    ) -> Result<Self, SweepPlanError> {
        let tables: Vec<String> = detectors.iter().map(ChosenDetector::table).collect();
        let own: Vec<&str> = tables.iter().map(String::as_str).collect();
        let swept_by_options = options.iter().filter_map(|it| match it {
            SweepOption::Swept(swept) => Some(swept),
            _ => None,
        });
        let mut swept: Vec<SweptParameter> = swept_by_options.chain(lists).cloned().collect();
        let fixed: Vec<OverrideOption> = options
            .iter()
            .filter_map(|it| match it {
                SweepOption::Fixed(option) => Some(option.clone()),
                _ => None,
            })
            .collect();
        let base = config.overridden(&fixed, &own)?;
        for it in &mut swept {
            it.name = base.full_name(&override_of(&it.name, &it.values[0]), &own)?;
        }
        let n_points = swept.iter().map(|it| it.values.len()).product();
        if swept.is_empty() {
            return Err(SweepPlanError::NothingSwept);
        }
        if n_points > MOST_POINTS {
            return Err(SweepPlanError::TooManyPoints { n_points });
        }
        let ties = options.iter().filter_map(|it| match it {
            SweepOption::Tied(tied) => Some(Tie::resolve(tied, &swept, &base, &own)),
            _ => None,
        });
        let ties: Vec<Tie> = ties.collect::<Result<_, _>>()?;
        let point = |point_idx: usize| {
            let mut values = values_of(&swept, point_idx);
            let names = swept.iter().map(|it| &it.name).chain(ties.iter().map(|it| &it.name));
            for tie in &ties {
                values.push(tie.value(&swept, &values)?);
            }
            // Includes the fixed options, so that a parameter that is both fixed and swept is refused.
            let mut overrides = fixed.clone();
            overrides.extend(names.zip(&values).map(|(name, value)| override_of(name, value)));
            Ok(SweepPoint { config: config.overridden(&overrides, &own)?, values })
        };
        let points: Vec<SweepPoint> = (0..n_points).map(point).collect::<Result<_, SweepPlanError>>()?;
        let tied = ties.into_iter().map(|it| it.name).collect();
        refuse_same_values(&swept)?;
        Ok(Self { detectors, swept, tied, points, base })
    }

    /// Name of `detector` at a point in the rows of the sweep.
    pub fn entrant(&self, detector: &str, point_idx: usize) -> String {
        entrant_name(detector, &self.parameters(), &self.points[point_idx].values)
    }

    /// Full names of the parameters that differ from point to point, in the order of [`SweepPoint::values`].
    pub fn parameters(&self) -> Vec<String> {
        self.swept.iter().map(|it| it.name.clone()).chain(self.tied.iter().cloned()).collect()
    }
}

fn override_of(name: &str, value: &str) -> OverrideOption {
    format!("{name}={value}").parse().expect("every value was read as one before")
}

/// The values of the swept parameters at point `point_idx`.
fn values_of(swept: &[SweptParameter], mut point_idx: usize) -> Vec<String> {
    let mut values: Vec<String> = Vec::new();
    for it in swept.iter().rev() {
        values.insert(0, it.values[point_idx % it.values.len()].clone());
        point_idx /= it.values.len();
    }
    values
}

/// Refuses equal values with different texts, such as `2` and `2.0`.
fn refuse_same_values(swept: &[SweptParameter]) -> Result<(), SweepPlanError> {
    for SweptParameter { name, values } in swept {
        let mut seen = BTreeSet::new();
        for value in values {
            let Ok(number) = value.parse::<f64>() else { continue };
            if !seen.insert(number.to_bits()) {
                let first = values.iter().find(|it| it.parse() == Ok(number)).unwrap_or(value);
                let (first, second) = (first.clone(), value.clone());
                return Err(SweepPlanError::SamePoint { name: name.clone(), first, second });
            }
        }
    }
    Ok(())
}

/// A tied parameter with its full name.
struct Tie {
    name: String,
    dividend: f64,
    /// Index of the divisor among the swept parameters.
    divisor_idx: usize,
    is_whole: bool,
}

impl Tie {
    fn resolve(
        tied: &TiedValue,
        swept: &[SweptParameter],
        base: &RunConfig,
        own: &[&str],
    ) -> Result<Self, SweepPlanError> {
        let name = base.full_name(&override_of(&tied.name, "1"), own)?;
        let divisor = base.full_name(&override_of(&tied.divisor, "1"), own)?;
        let nothing = || SweepPlanError::TiedToNothing {
            name: name.clone(),
            divisor: divisor.clone(),
            swept: swept.iter().map(|it| it.name.clone()).collect(),
        };
        let divisor_idx = swept.iter().position(|it| it.name == divisor).ok_or_else(nothing)?;
        let is_whole = matches!(base.value_of(&name), Some(Value::Integer(_)));
        Ok(Self { name, dividend: tied.dividend, divisor_idx, is_whole })
    }

    /// The tied value for the `values` of the swept parameters; an integer is at least 1.
    fn value(&self, swept: &[SweptParameter], values: &[String]) -> Result<String, SweepPlanError> {
        let divisor = &values[self.divisor_idx];
        let Some(quotient) = divisor.parse::<f64>().ok().filter(|it| *it > 0.0).map(|it| self.dividend / it)
        else {
            return Err(SweepPlanError::TiedToWord {
                name: self.name.clone(),
                divisor: swept[self.divisor_idx].name.clone(),
                value: divisor.clone(),
            });
        };
        Ok(if self.is_whole { format!("{}", quotient.round().max(1.0)) } else { format!("{quotient:.6}") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::detector_list::detectors_named;
    use crate::sweep::swept_values::ListOption;

    fn plan(options: &[&str], lists: &[&str]) -> Result<SweepPlan, SweepPlanError> {
        let config = RunConfig::load(None).unwrap();
        let detectors = detectors_named(&["hierarchical".to_owned()], &config).unwrap();
        let options: Vec<SweepOption> = options.iter().map(|it| it.parse().unwrap()).collect();
        let lists: Vec<SweptParameter> = lists.iter().map(|it| it.parse::<ListOption>().unwrap().0).collect();
        SweepPlan::new(&config, detectors, &options, &lists)
    }

    #[test]
    fn points_are_all_combinations_with_the_last_one_fastest() {
        let plan = plan(&["cell_size_m=0.5:0.7:0.1", "terrain.enabled=false"], &["xi=2,3"]).unwrap();
        assert_eq!(plan.parameters(), ["hierarchical.grid.cell_size_m", "hierarchical.grid.xi"]);
        let values: Vec<String> = plan.points.iter().map(|it| it.values.join(" ")).collect();
        assert_eq!(values, ["0.5 2", "0.5 3", "0.6 2", "0.6 3", "0.7 2", "0.7 3"]);
        let grid = &plan.points[3].config.hierarchical.grid;
        assert_eq!((grid.cell_size_m, grid.xi), (0.6, 3));
        assert!(plan.points.iter().all(|it| !it.config.hierarchical.terrain.enabled));
    }

    #[test]
    fn a_tied_parameter_keeps_its_length() {
        let tied =
            ["cell_size_m=0.3:2.7:1.2", "min_length_cells=7.2/cell_size_m", "max_gap_cells=0.9/cell_size_m"];
        let plan = plan(&tied, &[]).unwrap();
        assert_eq!(
            plan.tied,
            ["hierarchical.walls.hough.min_length_cells", "hierarchical.walls.hough.max_gap_cells"]
        );
        let cells: Vec<(u32, u32)> = plan
            .points
            .iter()
            .map(|it| &it.config.hierarchical.walls.hough)
            .map(|it| (it.min_length_cells, it.max_gap_cells))
            .collect();
        assert_eq!(cells, [(24, 3), (5, 1), (3, 1)]);
    }

    #[track_caller]
    fn check_refused(options: &[&str], lists: &[&str], message: &str) {
        let error = plan(options, lists).map(|it| it.points.len()).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn plans_that_cannot_be_run_are_refused_before_anything_is() {
        check_refused(&["cell_size_m=0.6"], &[], "no parameter is swept");
        check_refused(&["cel_size_m=0.2:0.4:0.1"], &[], "unknown parameter cel_size_m");
        check_refused(
            &["cell_size_m=0.0:0.4:0.1"],
            &[],
            "hierarchical.grid.cell_size_m = 0 is not within 0.05 to 10 m",
        );
        check_refused(&["cell_size_m=0.2:0.4:0.1", "cell_size_m=0.6"], &[], "is set twice");
        check_refused(&["cell_size_m=0.2:0.4:0.1"], &["grid.cell_size_m=1,2"], "is set twice");
        check_refused(&["xi=1.0:2.0:0.5"], &[], "hierarchical.grid.xi is of type float, but must be integer");
        check_refused(
            &["block_cells=3.0/cell_size_m"],
            &["xi=2,3"],
            "which is not swept; swept are hierarchical.grid.xi",
        );
        check_refused(
            &[],
            &["cell_size_m=0.6,0.60"],
            "the values 0.6 and 0.60 of hierarchical.grid.cell_size_m are equal",
        );
        check_refused(
            &["cell_size_m=0.1:2:0.001", "foreground.clearance_m=0.1:0.2:0.001"],
            &[],
            "combinations of values are too many; the most is 100000",
        );
    }
}
