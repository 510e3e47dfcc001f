//! `scanbench data objects`.

use reports::vocabulary::partial_class::PartialClass;
use scans::conversion::object_folder_writer::write_object_folder;

use crate::cli::DataObjectsArgs;
use crate::plumbing::failure::Failure;
use crate::plumbing::object_sets::{ObjectOpening, refuse_idle_options};
use crate::plumbing::standard_streams::print_result;

/// Writes single objects, a folder for each class.
pub fn data_objects(arguments: &DataObjectsArgs) -> Result<(), Failure> {
    let DataObjectsArgs { objects: name, choice, source, .. } = arguments;
    refuse_idle_options(std::slice::from_ref(name), &[], choice, source)?;
    let objects = ObjectOpening::of(source)?.open(name, &choice.options())?;
    write_object_folder(&*objects, &arguments.output)?;
    let of_classes = PartialClass::ALL.into_iter().filter_map(|class| {
        let n = objects.classes().iter().filter(|it| **it == class).count();
        (n > 0).then(|| format!("{n} {class}"))
    });
    let simulated = if objects.description().is_simulated() { ", simulated" } else { "" };
    let counts = of_classes.collect::<Vec<_>>().join(", ");
    print_result(format_args!("{}  {counts}{simulated}", arguments.output.display()))
}
