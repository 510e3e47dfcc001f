//! Bounds of parameters.

use std::fmt;

use super::{ParamsError, as_written};

/// The values of a parameter that make sense.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The parameter with its tables, such as `grid.cell_size_m`.
    pub name: &'static str,
    /// The least; negative infinity if there is no least.
    pub low: f64,
    /// The greatest; infinite if there is no greatest.
    pub high: f64,
}

/// Unit of a parameter by the end of its name.
const UNITS: [(&str, &str); 3] = [("_m", "m"), ("_deg", "degrees"), ("_points", "points")];

impl Bounds {
    /// Bounds of parameter `name`.
    pub const fn new(name: &'static str, low: f64, high: f64) -> Self {
        Self { name, low, high }
    }

    /// The unit that the name ends with; `None` for shares and counts of other things.
    pub fn unit(&self) -> Option<&'static str> {
        UNITS.into_iter().find(|(suffix, _)| self.name.ends_with(suffix)).map(|(_, unit)| unit)
    }

    /// Refuses a number outside, and NaN.
    fn check(&self, value: f64) -> Result<(), ParamsError> {
        if (self.low..=self.high).contains(&value) {
            return Ok(());
        }
        let (name, value) = (self.name, as_written(value));
        Err(if self.high.is_infinite() && value < self.low {
            ParamsError::TooLow { name, value, least: self.low.to_string() }
        } else {
            ParamsError::OutOfRange { name, value, allowed: self.to_string() }
        })
    }
}

/// `0.05 to 10 m`, or `at least 1`.
impl fmt::Display for Bounds {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match [self.low, self.high] {
            [low, high] if high.is_infinite() => write!(formatter, "at least {low}")?,
            [low, high] if low.is_infinite() => write!(formatter, "at most {high}")?,
            [low, high] => write!(formatter, "{low} to {high}")?,
        }
        self.unit().map_or(Ok(()), |it| write!(formatter, " {it}"))
    }
}

/// Checks the numbers in `document` that `bounds` names; others, such as those of a model, are not checked.
///
/// # Errors
///
/// [`ParamsError::OutOfRange`] or [`ParamsError::TooLow`] for the first outside.
pub fn check_bounds(document: &toml::Table, bounds: &[Bounds]) -> Result<(), ParamsError> {
    for it in bounds {
        if let Some(value) = number_at(document, it.name) {
            it.check(value)?;
        }
    }
    Ok(())
}

/// Checks that `value` of parameter `name` lies between `low` and `high`, which NaN does not. Meant for parameters that are
/// no number of a file or have bounds that depend on others. `allowed` says the bounds in words.
///
/// # Errors
///
/// [`ParamsError::OutOfRange`].
pub fn check_range(
    name: &'static str,
    value: f64,
    [low, high]: [f64; 2],
    allowed: &str,
) -> Result<(), ParamsError> {
    let value = as_written(value);
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(ParamsError::OutOfRange { name, value, allowed: allowed.to_owned() })
}

fn number_at(document: &toml::Table, name: &str) -> Option<f64> {
    let (tables, key) = name.rsplit_once('.').unwrap_or(("", name));
    let mut table = document;
    for name in tables.split('.').filter(|it| !it.is_empty()) {
        table = table.get(name)?.as_table()?;
    }
    match table.get(key)? {
        toml::Value::Integer(value) => Some(*value as f64),
        toml::Value::Float(value) => Some(*value),
        _ => None,
    }
}

/// Bounds of the parameters of `hierarchical`, and of `paper` where it has them.
pub const HIERARCHICAL_BOUNDS: &[Bounds] = &[
    Bounds::new("grid.cell_size_m", 0.05, 10.0),
    Bounds::new("grid.xi", 1.0, 8.0),
    Bounds::new("grid.extent_m", 1.0, 300.0),
    Bounds::new("terrain.block_cells", 1.0, 100.0),
    Bounds::new("terrain.max_slope", 0.0, 10.0),
    Bounds::new("terrain.max_bend", 0.0, 10.0),
    Bounds::new("terrain.max_step_m", 0.0, 10.0),
    Bounds::new("terrain.low_quantile", 0.0, 1.0),
    Bounds::new("terrain.flat_extent_m", 0.0, 10.0),
    Bounds::new("terrain.min_points", 1.0, f64::INFINITY),
    Bounds::new("ground.min_points", 1.0, f64::INFINITY),
    Bounds::new("ground.max_ground_extent_m", 0.0, 10.0),
    Bounds::new("ground.ground_band_m", 0.0, 10.0),
    Bounds::new("ground.tall_height_m", 0.0, 100.0),
    Bounds::new("walls.min_height_m", 0.0, 100.0),
    Bounds::new("walls.ceiling_margin_deg", 0.0, 90.0),
    Bounds::new("walls.min_support", 0.0, 1.0),
    Bounds::new("walls.min_standing", 0.0, 1.0),
    Bounds::new("walls.max_ground_behind", 0.0, 1.0),
    Bounds::new("walls.hough.n_directions", 4.0, 720.0),
    Bounds::new("walls.hough.min_votes", 2.0, 1000.0),
    Bounds::new("walls.hough.min_length_cells", 2.0, 10_000.0),
    Bounds::new("walls.hough.max_gap_cells", 0.0, 10_000.0),
    Bounds::new("walls.hough.seed", 0.0, f64::INFINITY),
    Bounds::new("foreground.clearance_m", f64::NEG_INFINITY, 10.0),
    Bounds::new("foreground.ground_band_m", 0.0, 10.0),
    Bounds::new("merge.max_height_difference_m", 0.0, 100.0),
    Bounds::new("separation.low_density_share", 0.0, 1.0),
    Bounds::new("separation.object_density_ratio", 0.0, 1e6),
    Bounds::new("separation.single_gap_points", 0.0, 1e6),
    Bounds::new("separation.min_contacts", 1.0, 64.0),
    Bounds::new("outline.min_points", 1.0, f64::INFINITY),
    Bounds::new("cluster.min_points", 1.0, f64::INFINITY),
    Bounds::new("cluster.min_vehicle_points", 1.0, f64::INFINITY),
    Bounds::new("cluster.min_vehicle_probability", 0.01, 0.99),
    Bounds::new("cluster.min_pedestrian_probability", 0.01, 0.99),
    Bounds::new("cluster.min_cyclist_probability", 0.01, 0.99),
    Bounds::new("vehicle_size.min_points", 0.0, f64::INFINITY),
    Bounds::new("vehicle_size.min_length_m", 0.0, 100.0),
    Bounds::new("vehicle_size.max_length_m", 0.0, 100.0),
    Bounds::new("vehicle_size.max_width_m", 0.0, 100.0),
    Bounds::new("vehicle_size.min_height_m", 0.0, 100.0),
    Bounds::new("vehicle_size.max_height_m", 0.0, 100.0),
    Bounds::new("grouping.object_cost", 0.0, 1.0),
    Bounds::new("grouping.vehicle_cost", 0.0, 1.0),
    Bounds::new("grouping.ranked_probability", 0.001, 0.5),
    Bounds::new("grouping.rounds", 1.0, 3.0),
    Bounds::new("grouping.candidates.min_clearance_m", 0.0, 100.0),
    Bounds::new("grouping.candidates.clearance_per_m", 0.0, 1.0),
    Bounds::new("grouping.candidates.highest_foot_m", 0.0, 100.0),
    Bounds::new("grouping.candidates.highest_top_m", 0.0, 100.0),
    Bounds::new("grouping.gaps.n_rounds", 0.0, 20.0),
    Bounds::new("grouping.gaps.low_density_share", 0.0, 1.0),
    Bounds::new("grouping.gaps.object_density_ratio", 0.0, 1e6),
    Bounds::new("grouping.gaps.single_gap_points", 0.0, 1e6),
    Bounds::new("grouping.gaps.max_height_difference_m", 0.0, 100.0),
    Bounds::new("grouping.gaps.height_steps", 0.0, 20.0),
    Bounds::new("grouping.gaps.wall_steps", 0.0, 20.0),
    Bounds::new("grouping.cuts.min_length_m", 0.0, 100.0),
    Bounds::new("grouping.cuts.min_width_m", 0.0, 100.0),
    Bounds::new("grouping.cuts.max_length_m", 0.0, 1000.0),
    Bounds::new("grouping.cuts.min_end_m", 0.0, 100.0),
    Bounds::new("grouping.cuts.min_points", 1.0, f64::INFINITY),
    Bounds::new("grouping.cuts.max_depth", 0.0, 10.0),
    Bounds::new("grouping.cuts.max_groups", 0.0, f64::INFINITY),
    Bounds::new("grouping.bounds.max_length_m", 0.0, 100.0),
    Bounds::new("grouping.bounds.max_width_m", 0.0, 100.0),
    Bounds::new("grouping.bounds.min_top_m", 0.0, 100.0),
    Bounds::new("completion.growth_m", 0.0, 10.0),
    Bounds::new("completion.clearance_m", -10.0, 10.0),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HIERARCHICAL_TOML;
    use crate::params::paper::PAPER_TOML;

    #[test]
    fn bounds_are_said_with_their_unit() {
        assert_eq!(Bounds::new("grid.cell_size_m", 0.05, 10.0).to_string(), "0.05 to 10 m");
        assert_eq!(Bounds::new("walls.ceiling_margin_deg", 0.0, 90.0).to_string(), "0 to 90 degrees");
        assert_eq!(Bounds::new("cluster.min_points", 1.0, f64::INFINITY).to_string(), "at least 1 points");
        assert_eq!(Bounds::new("grid.xi", 1.0, 8.0).to_string(), "1 to 8");
        assert_eq!(Bounds::new("clearance_m", f64::NEG_INFINITY, 10.0).to_string(), "at most 10 m");
    }

    /// Names of all numbers in `table`.
    fn numbers(table: &toml::Table, within: &str) -> Vec<String> {
        let mut names = Vec::new();
        for (key, value) in table {
            let name = format!("{within}{key}");
            match value {
                toml::Value::Integer(_) | toml::Value::Float(_) => names.push(name),
                toml::Value::Table(inner) => names.extend(numbers(inner, &format!("{name}."))),
                _ => {}
            }
        }
        names
    }

    #[test]
    fn every_number_has_bounds_and_all_bounds_are_of_one() {
        let bounded: Vec<&str> = HIERARCHICAL_BOUNDS.iter().map(|it| it.name).collect();
        let hierarchical = numbers(&HIERARCHICAL_TOML.parse().unwrap(), "");
        assert!(hierarchical.iter().all(|it| bounded.contains(&it.as_str())), "{hierarchical:?}");
        let paper = numbers(&PAPER_TOML.parse().unwrap(), "");
        let is_one = |it: &&str| hierarchical.iter().chain(&paper).any(|name| name == it);
        assert!(bounded.iter().all(is_one), "{bounded:?}");
        assert!(paper.iter().all(|it| bounded.contains(&it.as_str())), "{paper:?}");
    }

    #[test]
    fn every_parameter_says_what_it_is() {
        for text in [HIERARCHICAL_TOML, PAPER_TOML] {
            for line in text.lines().filter(|it| it.contains(" = ")) {
                assert!(line.contains('#'), "{line}");
            }
        }
    }
}
