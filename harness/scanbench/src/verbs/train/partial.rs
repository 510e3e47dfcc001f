//! `scanbench train partial`.

use detector::describe::trained_file::Provenance;
use detector::partial::partial_model::PartialModel;
use detector::partial::partial_params::PartialParams;
use evaluation::partial::model_training::{ModelTrainingError, PartialRecipe, train_on_sets};
use jiff::Timestamp;
use reports::files::archive::SCHEMA;
use reports::files::causes::with_causes;
use reports::run_folder::command_line::shell_word;
use reports::run_folder::run_directory::RunDirectory;
use reports::run_folder::run_target::{LatestPointer, MANIFEST_JSON};
use scans::object_cloud::object_cloud_set::ObjectCloudSet;
use simulator::object_clouds::open_objects::{ObjectSource, open_objects};
use simulator::object_clouds::simulated_objects::ObjectPart;
use simulator::open::OpenOptions;

use crate::cli::{PartialTrainingArgs, object_options};
use crate::plumbing::failure::{Failure, NothingEvaluated, Usage};
use crate::plumbing::open_datasets::open_catalogue;
use crate::plumbing::progress::progress_over_results;
use crate::plumbing::provenance::{command_line, compact_utc, git_state, rfc3339_utc, rustc_version};
use crate::plumbing::remote::local_name;
use crate::plumbing::run_directory::{claim_named, claim_unnamed};
use crate::plumbing::standard_streams::print_result_in;

const PARTIAL_FILE: &str = "partial.model";

/// Trains a bag of graphs, and writes it.
pub fn train_partial(arguments: &PartialTrainingArgs) -> Result<(), Failure> {
    let started = Timestamp::now();
    let named = claim_named(&arguments.output)?;
    let recipe = recipe(arguments)?;
    let sets = open_all(arguments, &recipe)?;
    let unnamed = format!("{}-train-partial", compact_utc(started));
    let directory = RunDirectory::begin(claim_unnamed(named, &unnamed, LatestPointer::Leave)?)?;
    let n_objects = sets.iter().map(|it| it.classes().len()).sum();
    let progress = progress_over_results(n_objects, 0, "objects");
    let params = PartialParams::shipped();
    let model = train_on_sets(&sets, &params, provenance(arguments, &recipe), || progress.inc(1));
    progress.finish_and_clear();
    let model = model.map_err(|error| match error {
        ModelTrainingError::Dataset(error) => Failure::from(error),
        error @ ModelTrainingError::Training(_) => NothingEvaluated { reason: with_causes(&error) }.into(),
    })?;
    directory.write_file(PARTIAL_FILE, &model.to_bytes())?;
    directory.write_file(MANIFEST_JSON, manifest(&sets, started).as_bytes())?;
    let finished = directory.finish()?;
    print_result_in("Model", &finished, summary(&model, &recipe.objects, n_objects))
}

/// Recipe of the training: that of the shipped model, unless the arguments say otherwise.
fn recipe(arguments: &PartialTrainingArgs) -> Result<PartialRecipe, Failure> {
    let shipped = PartialRecipe::shipped();
    let asked = arguments;
    let objects = if asked.objects.is_empty() { shipped.objects } else { asked.objects.clone() };
    let has_simulated = objects.iter().any(|it| ObjectSource::of(it) == ObjectSource::Simulated);
    if asked.per_class.is_some() && !has_simulated {
        let problem = "--per-class is for simulated objects, and none are trained on";
        return Err(Usage(problem.to_owned()).into());
    }
    Ok(PartialRecipe { objects, per_class: asked.per_class.unwrap_or(shipped.per_class) })
}

fn open_all(
    arguments: &PartialTrainingArgs,
    recipe: &PartialRecipe,
) -> Result<Vec<Box<dyn ObjectCloudSet>>, Failure> {
    let catalogue = open_catalogue(arguments.catalogue.catalogue.as_deref())?;
    let options = object_options(ObjectPart::Training, recipe.per_class);
    let open = |name: &String| -> Result<_, Failure> {
        Ok(open_objects(&local_name(name, None)?, &options, &OpenOptions::default(), &catalogue)?)
    };
    recipe.objects.iter().map(open).collect()
}

fn provenance(arguments: &PartialTrainingArgs, recipe: &PartialRecipe) -> Provenance {
    let mut command = "scanbench train partial".to_owned();
    if !arguments.objects.is_empty() {
        command.push_str(" --objects ");
        command.push_str(&shell_word(&recipe.objects.join(",")));
    }
    if let Some(per_class) = arguments.per_class {
        command.push_str(" --per-class ");
        command.push_str(&per_class.to_string());
    }
    let data = recipe.objects.iter().map(|name| match ObjectSource::of(name) {
        ObjectSource::Simulated => {
            format!(
                "{name} (simulated, {} of each class, seed {})",
                recipe.per_class,
                ObjectPart::Training.seed()
            )
        }
        ObjectSource::ClassFolders | ObjectSource::Dataset => name.clone(),
    });
    Provenance {
        command,
        data: data.collect(),
        seed: PartialParams::shipped().labels.seed,
        split: "all objects are trained on; in turn held out to learn how sure decisions are".to_owned(),
    }
}

fn manifest(sets: &[Box<dyn ObjectCloudSet>], started: Timestamp) -> String {
    let described = |set: &dyn ObjectCloudSet| {
        let it = set.description();
        serde_json::json!({
            "id": it.id, "simulated": it.is_simulated(), "simulation": it.simulation, "objects": set.classes().len(),
        })
    };
    let manifest = serde_json::json!({
        "schema": SCHEMA,
        "scanbench_version": env!("CARGO_PKG_VERSION"),
        "created": rfc3339_utc(started),
        "argv": command_line(),
        "sets": sets.iter().map(|it| described(&**it)).collect::<Vec<_>>(),
        "git": git_state(),
        "rustc_version": rustc_version(),
    });
    format!("{manifest:#}\n")
}

fn summary(model: &PartialModel, names: &[String], n_objects: usize) -> String {
    format!(
        "Trained on {n_objects} objects of {}: {}\n{} labels, {} patterns",
        names.join(", "),
        model.classes.join(", "),
        model.labeler.centers.len(),
        model.vocabulary.patterns().len()
    )
}
