//! The figures of the papers that are scenes.

use detector::stage;
use evaluation::run::scan_recorder::FigureView;

/// What shows the same of a scan. Their titles say of which figure.
pub const FIGURES: [FigureView; 7] = [
    view("HG figs. 1, 3: cells, façades as lines", "paper", stage::WALLS),
    view("HG fig. 3: without the Hough transform", "paper, no Hough transform", stage::BOXES),
    view("HG fig. 4: links cut between dense cells", "paper", stage::SEPARATION),
    view("HG fig. 7: coarse level alone", "paper, coarse level alone", stage::BOXES),
    view("HG fig. 7, VM figs. 1, 5: both levels, hulls", "paper", stage::BOXES),
    view("VM figs. 1, 5: principal axes", "pca", stage::BOXES),
    view("VM figs. 6 and 7: spheres and side profiles", "paper", stage::FEATURES),
];

const fn view(title: &'static str, detector: &'static str, stage: &'static str) -> FigureView {
    FigureView { title, detector, stage }
}
