//! From the command line to parameters.

use detector::params::PAPER_SENSOR;
use evaluation::matching::criterion::Criterion;
use evaluation::run::config::{ConfigError, RunConfig};
use evaluation::run::detector_list::ListedDetector;

use crate::cli::{ConfigArgs, CriterionName, MatchingArgs};
use crate::commands::standard_streams::print_diagnostic;

/// The parameters that ship, overridden by the file and then by the options of `arguments`, whose short names are those of
/// parameters of `detectors`.
///
/// # Errors
///
/// [`ConfigError`] if an override names no parameter, or has a value that cannot be worked with.
pub fn detector_config(
    arguments: &ConfigArgs,
    detectors: &[ListedDetector],
) -> Result<RunConfig, ConfigError> {
    let tables: Vec<&str> = detectors.iter().map(|it| it.table).collect();
    RunConfig::load(arguments.config.as_deref())?.overridden(&arguments.parameters, &tables)
}

/// The same for commands that judge detections, where `matching` has the last word about the criterion.
///
/// # Errors
///
/// As [`detector_config`].
pub fn judging_config(
    arguments: &ConfigArgs,
    matching: &MatchingArgs,
    detectors: &[ListedDetector],
) -> Result<RunConfig, ConfigError> {
    let mut config = detector_config(arguments, detectors)?;
    match matching.criterion {
        Some(CriterionName::Points) => config.choose_criterion(Criterion::POINTS),
        Some(CriterionName::BevIou) => config.choose_criterion(Criterion::BEV_IOU),
        Some(CriterionName::Iou3d) => config.choose_criterion(Criterion::IOU_3D),
        Some(CriterionName::Centre) => config.choose_criterion(Criterion::CENTRE),
        None => {}
    }
    Ok(config)
}

/// Says so if it is not known how densely `sensor` samples the street.
pub fn warn_of_unknown_sensor(config: &RunConfig, sensor: &str) {
    if config.for_sensor(sensor).is_none() {
        print_diagnostic(format_args!(
            "warning: there is no density curve for the sensor {sensor:?}; the detector uses that of {PAPER_SENSOR}; \
             fit one with scanbench fit-density, and give the file to --config"
        ));
    }
}
