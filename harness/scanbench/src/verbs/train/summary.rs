//! Text that `scanbench train` prints.

use detector::classify::svm_model::SvmModel;
use detector::describe::prototype_library::PrototypeLibrary;
use evaluation::training::candidate_kind::CandidateKind;
use evaluation::training::candidates::Candidate;
use evaluation::training::evaluation::Evaluation;
use evaluation::training::held_out::HeldOut;

/// The drives, the objects trained on, and how the model does on those held out.
pub fn summary<const D: usize>(
    parted: &HeldOut,
    selected: &[&Candidate],
    library: Option<&PrototypeLibrary>,
    model: &SvmModel<D>,
    evaluation: &Evaluation<D>,
) -> String {
    let n_vehicles = selected.iter().filter(|it| it.kind.is_vehicle()).count();
    let n_cut = selected.iter().filter(|it| it.kind == CandidateKind::CutRegion).count();
    let prototypes = library.map_or_else(String::new, |it| format!("{} prototypes, ", it.prototypes().len()));
    let mut lines = vec![
        format!("Trained on {} drives: {}", parted.trained.len(), HeldOut::summary(&parted.trained)),
        format!("Held out {} drives: {}", parted.held_out.len(), HeldOut::summary(&parted.held_out)),
        format!(
            "{n_vehicles} vehicles and {} others, of which {n_cut} cut regions; {prototypes}{} support vectors",
            selected.len() - n_vehicles,
            model.support_vectors.len()
        ),
        String::new(),
        format!("{:<16}{:>14}{:>18}", "classified as", "vehicle", "background"),
    ];
    for ((_, kind), predicted) in &evaluation.predicted {
        lines.push(format!("{kind:<16}{:>14}{:>18}", predicted.n_vehicle, predicted.n_background));
    }
    let [n_vehicles, n_others] = evaluation.curves.totals();
    let share = |area: Option<f64>| area.map_or_else(|| "undefined".to_owned(), |it| format!("{it:.4}"));
    lines.push(String::new());
    lines.push(format!("On {n_vehicles} held-out vehicles and {n_others} others:"));
    lines.push(format!("ROC area {}", share(evaluation.curves.roc_area())));
    lines.push(format!("Precision-recall area {}", share(evaluation.curves.precision_recall_area())));
    lines.push(String::new());
    lines.push(
        "Permutation importance (loss of ROC area when one feature is shuffled over the held-out objects):"
            .to_owned(),
    );
    for (feature, loss) in evaluation.importance {
        lines.push(format!("{feature:<22}{:>10}", share(loss)));
    }
    lines.join("\n")
}
