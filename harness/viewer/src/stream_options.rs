//! Options of a recording.

use std::path::PathBuf;

use evaluation::run::scan_recorder::FigureView;
use reports::vocabulary::task::Task;

use super::drawn_points::PointChoice;
use super::viewer::ViewerChoice;

/// What a recording is called, who sees it, and how it opens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamOptions {
    /// The name of the recording in the viewer.
    pub name: String,
    /// A viewer that gets the same data at the same time.
    pub viewer: ViewerChoice,
    /// How it opens.
    pub opening: Opening,
    /// Which points of a scan are drawn.
    pub points: PointChoice,
}

/// Where a recording is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordingTarget {
    /// To one file, in place of a file or a link that is there.
    File(PathBuf),
    /// To a device, or to a pipe, that is there.
    Device(PathBuf),
    /// To layers that are opened together.
    Layers {
        /// The folder that gets them.
        folder: PathBuf,
        /// The folder of a recording over the same scans that they are to be put into.
        joins: Option<PathBuf>,
    },
}

/// Which tab of a recording is in front when it is opened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FirstTab {
    /// Detectors side by side.
    #[default]
    Compare,
    /// Two runs side by side: the only tab.
    Changes,
    /// The first detector, stage by stage.
    Stages,
    /// The drive in a frame that rests, if poses are known.
    Drive,
}

/// How a recording opens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Opening {
    /// The task whose outcomes are visible at first.
    pub shown_task: Task,
    /// Which tab is in front.
    pub first_tab: FirstTab,
    /// Whether the poses of the sensor are known for some scans at least.
    pub has_poses: bool,
    /// Whether a viewer that is streamed to follows the newest scan. A complete recording opens at the start of its axis.
    pub follows: bool,
    /// Figures in a tab of their own, before all others; no such tab if there are none.
    pub figures: &'static [FigureView],
}
