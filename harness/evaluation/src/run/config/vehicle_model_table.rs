//! The trained models, as a table of the configuration.

use std::path::Path;
use std::sync::Arc;

use baselines::kd_tree_models::{TrainedComponents, shipped_tree, tree_from_bytes};
use baselines::pca_vehicle_model::PcaVehicleModel;
use detector::classify::grouping_model::GroupingModel;
use detector::classify::model_file::{ModelFile, ModelFileError};
use detector::classify::paper_model::PaperModel;
use detector::classify::vehicle_model::VehicleModel;
use detector::params::ParamsError;
use detector::whole::box_model::BoxModels;
use reports::files::regular_file::{MOST_OF_MODEL, read_bytes};
use scans::dataset::checksum::sha256;
use serde::Deserialize;

use super::value_problem::ValueProblem;

/// The table of the models that classify vehicles.
pub const VEHICLE_MODEL: &str = "vehicle_model";

/// Default values of the table: the models that come with the program.
pub const VEHICLE_MODEL_TOML: &str = r#"
enabled = true              # false: vehicles are told from other objects by their size
# Folders that `scanbench train` wrote, relative to this file; "": what comes with the program
groupings_directory = ""    # of hierarchical
rivals_directory = ""       # of kd-tree-trained and kd-tree-tree
clusters_directory = ""     # of kd-tree, simple-grid, and detectors that give no classes
paper_directory = ""        # of paper
paper_as_printed = false    # true: with the printed constants of the classifier
pca_directory = ""          # of pca
boxes_directory = ""        # of the boxes of whole vehicles, of all detectors but those of the papers
"#;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleModelTable {
    /// If false, all detectors classify vehicles by their size.
    enabled: bool,
    /// Output folder of `scanbench train groupings`; the model that comes with the program if empty.
    groupings_directory: String,
    /// Output folder of `train rivals`, likewise.
    rivals_directory: String,
    /// Output folder of `train clusters`, likewise.
    clusters_directory: String,
    /// Output folder of `train paper`, likewise.
    paper_directory: String,
    /// Whether the shipped classifier of the detector paper is the one with the printed ν and γ.
    paper_as_printed: bool,
    /// Output folder of `train pca`, likewise.
    pca_directory: String,
    /// Output folder of `train boxes`, likewise.
    boxes_directory: String,
}

/// A trained model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TrainedModel {
    /// The trees of the detector hierarchical.
    Groupings,
    /// The trees of the detector kd-tree-trained.
    Components,
    /// The trees of the detector kd-tree-tree.
    NestedComponents,
    /// The trees that classify the vehicles of the kd-trees, of the simple grid, and of detectors that are not built in.
    Clusters,
    /// The SVM of the detector paper.
    Paper,
    /// The SVM of the detector pca.
    Pca,
    /// The trees that complete the boxes of vehicles, of all detectors but those of the papers.
    Boxes,
}

/// Name of the file that training writes for the detector hierarchical.
pub const GROUPINGS_FILE: &str = "groupings.model";
/// Name of the file of the detector kd-tree-trained.
pub const COMPONENTS_FILE: &str = "kd_tree_trained.model";
/// Name of the file of the detector kd-tree-tree.
pub const NESTED_FILE: &str = "kd_tree_tree.model";
/// Name of the file of the vehicle model of clusters.
pub const CLUSTERS_FILE: &str = "clusters.model";
/// Name of the file of the detector paper.
pub const PAPER_FILE: &str = "paper.model";
/// Name of the file of the boxes of whole vehicles.
pub const BOXES_FILE: &str = "boxes.model";
/// Name of the file of the detector pca.
pub const PCA_FILE: &str = "pca.model";

impl TrainedModel {
    /// All models.
    pub const ALL: [Self; 7] = [
        Self::Groupings,
        Self::Components,
        Self::NestedComponents,
        Self::Clusters,
        Self::Paper,
        Self::Pca,
        Self::Boxes,
    ];

    /// The parameter that names its directory.
    pub fn parameter(self) -> &'static str {
        match self {
            Self::Groupings => "vehicle_model.groupings_directory",
            Self::Components | Self::NestedComponents => "vehicle_model.rivals_directory",
            Self::Clusters => "vehicle_model.clusters_directory",
            Self::Paper => "vehicle_model.paper_directory",
            Self::Pca => "vehicle_model.pca_directory",
            Self::Boxes => "vehicle_model.boxes_directory",
        }
    }

    /// The name of its file, which training writes.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Groupings => GROUPINGS_FILE,
            Self::Components => COMPONENTS_FILE,
            Self::NestedComponents => NESTED_FILE,
            Self::Clusters => CLUSTERS_FILE,
            Self::Paper => PAPER_FILE,
            Self::Pca => PCA_FILE,
            Self::Boxes => BOXES_FILE,
        }
    }

    /// Short description for users.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Groupings | Self::Components | Self::NestedComponents => "its own trees",
            Self::Clusters => "trees trained on kd-tree components",
            Self::Paper | Self::Pca => "its own SVM",
            Self::Boxes => "trees of whole boxes",
        }
    }
}

/// Stands for the checksum of a model that comes with the program.
const SHIPPED: &str = "shipped";

/// The trained models. Those that come with the program are read when a detector first asks for one.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModels {
    groupings: ModelSource<Arc<GroupingModel>>,
    components: ModelSource<TrainedComponents>,
    nested_components: ModelSource<Arc<GroupingModel>>,
    clusters: ModelSource<VehicleModel>,
    paper: ModelSource<PaperModel>,
    pca: ModelSource<PcaVehicleModel>,
    boxes: ModelSource<BoxModels>,
}

/// Source of a model.
#[derive(Debug, Clone, PartialEq)]
enum ModelSource<M> {
    Shipped,
    /// Read from files with this checksum.
    Trained {
        model: Arc<M>,
        checksum: String,
        trained: TrainedWith,
    },
}

/// The parameters that a model was trained with instead of the shipped ones, by their full names; and the parameter that
/// names the directory of the model.
#[derive(Debug, Clone, PartialEq)]
struct TrainedWith {
    parameters: toml::Table,
    parameter: &'static str,
}

impl VehicleModels {
    /// Checks that `resolved` has the parameters that the models were trained with.
    pub(super) fn check_parameters(&self, resolved: &toml::Table) -> Result<(), ValueProblem> {
        let Self { groupings, components, nested_components, clusters, paper: _, pca: _, boxes: _ } = self;
        let trained =
            [groupings.trained(), components.trained(), nested_components.trained(), clusters.trained()];
        for TrainedWith { parameters, parameter } in trained.into_iter().flatten() {
            for (name, value) in parameters {
                let found = name.split('.').try_fold(None, |table: Option<&toml::Value>, key| {
                    table.map_or_else(|| resolved.get(key), |it| it.get(key)).map(Some)
                });
                let found = found.flatten();
                if found != Some(value) {
                    let here = found.map_or_else(|| "nothing".to_owned(), ToString::to_string);
                    let problem =
                        format!(": its model was trained with {name} = {value}, and here it is {here}");
                    let keys = vec!["vehicle_model".to_owned(), (*parameter).to_owned()];
                    return Err(ValueProblem { keys, problem });
                }
            }
        }
        Ok(())
    }

    /// Model of the detector hierarchical.
    pub fn groupings(&self) -> Arc<GroupingModel> {
        self.groupings.model(GroupingModel::shipped)
    }

    /// Model of the detector kd-tree-trained.
    pub fn components(&self) -> TrainedComponents {
        self.components.model(TrainedComponents::shipped)
    }

    /// Model of the detector kd-tree-tree.
    pub fn nested_components(&self) -> Arc<GroupingModel> {
        self.nested_components.model(shipped_tree)
    }

    /// Model of the vehicles among clusters.
    pub fn clusters(&self) -> VehicleModel {
        self.clusters.model(VehicleModel::shipped)
    }

    /// Model of the detector paper.
    pub fn paper(&self) -> PaperModel {
        self.paper.model(PaperModel::shipped)
    }

    /// Model of the clusters of the detector pca.
    pub fn pca(&self) -> PcaVehicleModel {
        self.pca.model(PcaVehicleModel::shipped)
    }

    /// Model of the boxes of whole vehicles; `None` for the one that comes with the program.
    pub fn boxes(&self) -> Option<Arc<BoxModels>> {
        match &self.boxes {
            ModelSource::Shipped => None,
            ModelSource::Trained { model, .. } => Some(Arc::clone(model)),
        }
    }

    /// The SHA-256 of `model`; `None` for the one that comes with the program.
    pub fn checksum(&self, model: TrainedModel) -> Option<&str> {
        let mut identities = TrainedModel::ALL.into_iter().zip(self.identity());
        let identity = identities.find(|(of, _)| *of == model)?.1;
        (!identity.starts_with(SHIPPED)).then_some(identity)
    }

    /// Identity of these models among those for the same program: a checksum for each, in the order of
    /// [`TrainedModel::ALL`].
    pub fn identity(&self) -> [&str; 7] {
        let Self { groupings, components, nested_components, clusters, paper, pca, boxes } = self;
        [
            groupings.identity(),
            components.identity(),
            nested_components.identity(),
            clusters.identity(),
            paper.identity(),
            pca.identity(),
            boxes.identity(),
        ]
    }
}

impl<M: Clone> ModelSource<M> {
    fn model(&self, shipped: fn() -> M) -> M {
        match self {
            Self::Shipped => shipped(),
            Self::Trained { model, .. } => M::clone(model),
        }
    }

    fn identity(&self) -> &str {
        match self {
            Self::Shipped => SHIPPED,
            Self::Trained { checksum, .. } => checksum,
        }
    }

    fn trained(&self) -> Option<&TrainedWith> {
        match self {
            Self::Shipped => None,
            Self::Trained { trained, .. } => Some(trained),
        }
    }
}

/// The models of a complete TOML document; `None` if they are switched off. Models of named directories are read at once,
/// because their errors are errors of the configuration.
pub(super) fn vehicle_models_from(text: &str) -> Result<Option<VehicleModels>, ValueProblem> {
    let table: VehicleModelTable = toml::from_str(text)
        .map_err(|error| ValueProblem::new(&ParamsError::Syntax(error), Some("vehicle_model"), text))?;
    if !table.enabled {
        return Ok(None);
    }
    let groupings =
        ModelDirectory { parameter: "groupings_directory", directory: &table.groupings_directory };
    let rivals = ModelDirectory { parameter: "rivals_directory", directory: &table.rivals_directory };
    let clusters = ModelDirectory { parameter: "clusters_directory", directory: &table.clusters_directory };
    let paper = ModelDirectory { parameter: "paper_directory", directory: &table.paper_directory };
    let pca = ModelDirectory { parameter: "pca_directory", directory: &table.pca_directory };
    let boxes = ModelDirectory { parameter: "boxes_directory", directory: &table.boxes_directory };
    Ok(Some(VehicleModels {
        groupings: groupings.model(GROUPINGS_FILE, |it| GroupingModel::from_bytes(it).map(Arc::new))?,
        components: rivals.model(COMPONENTS_FILE, TrainedComponents::from_bytes)?,
        nested_components: rivals.model(NESTED_FILE, |it| tree_from_bytes(it).map(Arc::new))?,
        clusters: clusters.model(CLUSTERS_FILE, VehicleModel::from_bytes)?,
        paper: paper_from(&paper, table.paper_as_printed)?,
        pca: pca.model(PCA_FILE, PcaVehicleModel::from_bytes)?,
        boxes: boxes.model(BOXES_FILE, BoxModels::from_bytes)?,
    }))
}

fn paper_from(files: &ModelDirectory<'_>, as_printed: bool) -> Result<ModelSource<PaperModel>, ValueProblem> {
    if !as_printed {
        return files.model(PAPER_FILE, PaperModel::from_bytes);
    }
    if !files.is_shipped() {
        let problem = " = true: vehicle_model.paper_directory names another classifier".to_owned();
        let keys = vec!["vehicle_model".to_owned(), "paper_as_printed".to_owned()];
        return Err(ValueProblem { keys, problem });
    }
    let trained = TrainedWith { parameters: toml::Table::new(), parameter: files.parameter };
    let model = Arc::new(PaperModel::as_printed());
    Ok(ModelSource::Trained { model, checksum: "shipped, as printed".to_owned(), trained })
}

/// An output directory of training, and the parameter that names it.
struct ModelDirectory<'a> {
    parameter: &'static str,
    directory: &'a str,
}

impl ModelDirectory<'_> {
    fn is_shipped(&self) -> bool {
        self.directory.is_empty()
    }

    /// The model that `from_bytes` makes of the file of this name.
    fn model<M>(
        &self,
        name: &str,
        from_bytes: impl FnOnce(&[u8]) -> Result<M, ModelFileError>,
    ) -> Result<ModelSource<M>, ValueProblem> {
        if self.is_shipped() {
            return Ok(ModelSource::Shipped);
        }
        let bytes = read_bytes(&Path::new(self.directory).join(name), MOST_OF_MODEL)
            .map_err(|error| self.problem(name, &error))?;
        let model = from_bytes(&bytes).map_err(|error| self.problem(name, &error))?;
        let file = ModelFile::of_any_kind(&bytes).map_err(|error| self.problem(name, &error))?;
        let trained = TrainedWith { parameters: file.parameters().clone(), parameter: self.parameter };
        Ok(ModelSource::Trained { model: Arc::new(model), checksum: sha256(bytes), trained })
    }

    fn problem(&self, name: &str, error: &dyn std::fmt::Display) -> ValueProblem {
        ValueProblem {
            keys: vec!["vehicle_model".to_owned(), self.parameter.to_owned()],
            problem: format!(" = {:?}: {name}: {error}", self.directory),
        }
    }
}
