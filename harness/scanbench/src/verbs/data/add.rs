//! `scanbench data add`.

use std::io::Write as _;
use std::path::Path;

use evaluation::run::config::RunConfig;
use reports::files::whole_file::WholeFile;
use scans::dataset::AnnotatedClasses;
use scans::dataset::catalogue::parse_catalogue;
use scans::dataset::text_file::read_text_file;
use simulator::simulated_street::StreetDrive;

use crate::cli::{AddArgs, CatalogueArgs, DatasetArgs};
use crate::plumbing::config::classes_of_project;
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::first_look::look_first;
use crate::plumbing::open_datasets::{OpenedDataset, open_datasets};
use crate::plumbing::standard_streams::print_result;

/// Writes an entry for a data set into a catalogue, and prints it.
pub fn data_add(arguments: &AddArgs) -> Result<(), Failure> {
    let Some(path) = arguments.source.catalogue.catalogue.as_deref() else {
        return Err(Usage(
            "name the catalogue with --catalogue FILE; it is made if it is not there".to_owned(),
        )
        .into());
    };
    if !Path::new(&arguments.path).exists() {
        return Err(Usage(format!("there is nothing at {:?}", arguments.path)).into());
    }
    let text = if path.exists() { read_text_file(path)? } else { HEAD.to_owned() };
    let opened = open(arguments)?;
    let id = arguments.id.clone().unwrap_or_else(|| id_from(&opened.dataset.description().id));
    let name = path.display().to_string();
    let known = parse_catalogue::<StreetDrive>(&name, &text)?;
    if known.ids().chain(known.groups.keys()).any(|it| *it == id) {
        let problem = format!("{name} has {id:?} already; choose another --id");
        return Err(Usage(problem).into());
    }
    let entry = entry(&id, &opened, arguments);
    let text = format!("{}\n\n{entry}", text.trim_end());
    // The entry must leave a catalogue that can be read.
    parse_catalogue::<StreetDrive>(&name, &text)?;
    let mut file = WholeFile::create(path)?;
    file.write_all(text.as_bytes()).map_err(|error| Failure::of_writing(error.kind(), error))?;
    file.finish()?;
    print_result(entry.trim_end())
}

const HEAD: &str = "# A catalogue of data sets for `scanbench --catalogue`.\n";

/// The data set at the path, even if the catalogue has one of that name, after a look at its first scans.
fn open(arguments: &AddArgs) -> Result<OpenedDataset, Failure> {
    let mut source = arguments.source.clone();
    source.catalogue = CatalogueArgs { catalogue: None };
    let path = Path::new(&arguments.path);
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let data = DatasetArgs { datasets: vec![whole.display().to_string()], scans: None, source };
    let opened = open_datasets(&data, &classes_of_project()?)?;
    let Some(opened) = opened.into_iter().next() else {
        return Err(Usage(format!("there is no data set at {:?}", arguments.path)).into());
    };
    Ok(look_first(opened, &mut RunConfig::without_vehicle_models()?))
}

/// A name with nothing but letters, digits, - and _.
fn id_from(name: &str) -> String {
    name.chars().map(|it| if it.is_ascii_alphanumeric() || it == '_' { it } else { '-' }).collect()
}

fn entry(id: &str, opened: &OpenedDataset, arguments: &AddArgs) -> String {
    let description = opened.dataset.description();
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let classes = match &description.annotated {
        AnnotatedClasses::EveryObject => quoted("every-object"),
        AnnotatedClasses::Only(classes) => {
            let names: Vec<String> = classes.iter().map(|it| quoted(it.name())).collect();
            format!("[{}]", names.join(", "))
        }
    };
    let root = description.root.as_ref().map(|it| it.display().to_string()).unwrap_or_default();
    let mut lines = vec![format!("[recorded.{id}]")];
    lines.extend(opened.first_look.suspicions.iter().map(|it| format!("# Suspect: {it}")));
    lines.push(format!("format = {}", quoted(&description.format)));
    lines.push(format!("root = {}", quoted(&root)));
    lines.push(format!("annotated_classes = {classes}"));
    // A curve learned from these scans has no name that others know.
    if !description.sensor.starts_with("unknown ") {
        lines.push(format!("sensor = {}", quoted(&description.sensor)));
    }
    lines.push(format!("sensor_height_m = {}", description.sensor_height_m));
    let AddArgs { licence, source, .. } = arguments;
    lines.extend(source.columns.as_ref().map(|it| format!("columns = {}", quoted(&it.to_string()))));
    lines.extend(licence.as_ref().map(|it| format!("licence = {}", quoted(it))));
    lines.join("\n") + "\n"
}
