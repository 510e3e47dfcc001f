//! The files of a recording: one for everything, or layers that are opened together.

use std::path::{Path, PathBuf};

use reports::files::new_file::make_folder;
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{RecordingStream, RecordingStreamBuilder, StoreId, StoreKind, TimelineName};

use super::error::StreamError;
use super::product_views::DetectorOutline;
use super::recording_file::RecordingFile;
use super::recording_layout::{self, KeptLayout};
use super::stream_options::RecordingTarget;
use super::viewer::{ViewerChoice, ViewerLink, ViewerState};

/// Recordings of this name share their blueprints.
pub const APPLICATION_ID: &str = "scanbench";

/// The layer of the scans, in the folder of a recording.
const SCANS_RRD: &str = "scans.rrd";
/// The layer that says how a viewer shows the others.
const LAYOUT_RRD: &str = "layout.rrd";

/// The layers of a recording that is being written; all are parts of the same recording for a viewer.
pub struct Layers {
    files: Vec<Layer>,
    scans: RecordingStream,
    of_detectors: Vec<RecordingStream>,
    layout: RecordingStream,
    /// Detectors that are in a recording which this one joins.
    pub joined: Vec<DetectorOutline>,
}

/// A part of a recording that has a file of its own.
struct Layer {
    recording: RecordingStream,
    file: RecordingFile,
    path: PathBuf,
}

impl Layers {
    /// Creates the files of a recording called `name`, which goes to `viewer`, too.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if they cannot be written.
    pub fn begin(
        target: &RecordingTarget,
        name: &str,
        viewer: &ViewerLink,
        detectors: &[&str],
    ) -> Result<Self, StreamError> {
        let (file, path) = match target {
            RecordingTarget::File(path) => (RecordingFile::create(path)?, path),
            RecordingTarget::Device(path) => (RecordingFile::write_to(path)?, path),
            RecordingTarget::Layers { folder, joins } => {
                return Self::in_folder(folder, joins.as_deref(), name, viewer, detectors);
            }
        };
        let layer = Layer::begin(&new_id(), Some(name), (file, path), viewer)?;
        let recording = || layer.recording.clone();
        Ok(Self {
            scans: recording(),
            of_detectors: vec![recording(); detectors.len()],
            layout: recording(),
            files: vec![layer],
            joined: Vec::new(),
        })
    }

    fn in_folder(
        folder: &Path,
        joins: Option<&Path>,
        name: &str,
        viewer: &ViewerLink,
        detectors: &[&str],
    ) -> Result<Self, StreamError> {
        let joined = joins.map(|it| KeptLayout::read(&it.join(LAYOUT_RRD))).transpose()?;
        let has_scans = joined.is_some();
        let (store, joined) = joined.map_or_else(|| (new_id(), Vec::new()), |it| (it.store, it.detectors));
        let parent = folder.parent().unwrap_or(Path::new("."));
        make_folder(parent, folder.file_name().unwrap_or_default())
            .map(|_| ())
            .and_then(|()| remove_layers(folder))
            .map_err(|source| StreamError::Create { path: folder.to_owned(), source })?;
        let mut files = Vec::new();
        let mut layer = |name: Option<&str>, file: &str| -> Result<RecordingStream, StreamError> {
            let path = folder.join(file);
            let layer = Layer::begin(&store, name, (RecordingFile::create(&path)?, &path), viewer)?;
            let recording = layer.recording.clone();
            files.push(layer);
            Ok(recording)
        };
        let scans = if has_scans { RecordingStream::disabled() } else { layer(Some(name), SCANS_RRD)? };
        let of_detectors = detectors
            .iter()
            .map(|it| layer(None, &format!("detector-{it}.rrd")))
            .collect::<Result<_, _>>()?;
        let layout = layer(None, LAYOUT_RRD)?;
        Ok(Self { files, scans, of_detectors, layout, joined })
    }

    /// Where everything is logged that all detectors share.
    pub fn scans(&self) -> &RecordingStream {
        &self.scans
    }

    /// The layers that a viewer may read before it has the layout, which is a file of its own; none in a single file.
    pub fn without_layout(&self) -> impl Iterator<Item = &RecordingStream> {
        let n_before = self.files.len() - 1;
        self.files[..n_before].iter().map(|it| &it.recording)
    }

    /// Where the detector is logged that was announced at this place.
    pub fn of_detector(&self, detector_idx: usize) -> &RecordingStream {
        &self.of_detectors[detector_idx]
    }

    /// Where the blueprint of these detectors is logged.
    ///
    /// # Errors
    ///
    /// [`StreamError::Log`] if Rerun refuses.
    pub fn layout(&self, detectors: &[DetectorOutline]) -> Result<&RecordingStream, StreamError> {
        if self.files.len() > 1 {
            recording_layout::keep(&self.layout, detectors)?;
        }
        Ok(&self.layout)
    }

    /// Goes on to another position on `timeline`.
    pub fn set_step(&self, timeline: TimelineName, step: i64) {
        for it in &self.files {
            it.recording.set_time_sequence(timeline, step);
        }
    }

    /// Lets Rerun write what it holds back, so that memory stays flat and a full disk is noticed.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if something could not be written.
    pub fn flush(&self) -> Result<(), StreamError> {
        self.files.iter().try_for_each(Layer::flush)
    }

    /// Writes the ends of the files, and returns their size in bytes.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if one of them is not complete.
    pub fn finish(&self) -> Result<u64, StreamError> {
        let mut n_bytes = 0;
        for Layer { file, path, .. } in &self.files {
            file.finish()?;
            let metadata = std::fs::metadata(path)
                .map_err(|error| StreamError::Write { path: path.clone(), reason: error.to_string() })?;
            n_bytes += metadata.len();
        }
        Ok(n_bytes)
    }
}

/// A layer that joins a recording which is finished.
pub struct OneLayer(Layer);

impl OneLayer {
    /// Begins a layer of the recording in `folder`, in the file at `path`.
    ///
    /// # Errors
    ///
    /// [`StreamError`] if that has no layers, or this one cannot be written.
    pub fn join(folder: &Path, path: &Path) -> Result<Self, StreamError> {
        let KeptLayout { store, .. } = KeptLayout::read(&folder.join(LAYOUT_RRD))?;
        let viewer = ViewerLink::open(&ViewerChoice::None)?;
        Layer::begin(&store, None, (RecordingFile::create(path)?, path), &viewer).map(Self)
    }

    /// Where it is logged.
    pub fn recording(&self) -> &RecordingStream {
        &self.0.recording
    }

    /// Writes its end.
    ///
    /// # Errors
    ///
    /// [`StreamError::Write`] if it is not complete.
    pub fn finish(self) -> Result<(), StreamError> {
        self.0.flush()?;
        self.0.file.finish()
    }
}

impl Layer {
    /// One layer of a recording names it.
    fn begin(
        store: &StoreId,
        name: Option<&str>,
        (file, path): (RecordingFile, &Path),
        viewer: &ViewerLink,
    ) -> Result<Self, StreamError> {
        let mut sinks: Vec<Box<dyn LogSink>> = vec![Box::new(file.clone())];
        if viewer.state() != ViewerState::None {
            sinks.push(Box::new(viewer.clone()));
        }
        let mut builder = RecordingStreamBuilder::from_store_id(store).send_properties(name.is_some());
        if let Some(name) = name {
            builder = builder.recording_name(name);
        }
        let recording = builder.batcher_config(batching()).set_sinks(sinks).map_err(|error| {
            StreamError::Log { entity: "the recording".to_owned(), reason: error.to_string() }
        })?;
        recording.set_log_tick_enabled(false);
        recording.set_log_time_enabled(false);
        Ok(Self { recording, file, path: path.to_owned() })
    }

    fn flush(&self) -> Result<(), StreamError> {
        // The file knows better than the flush why it failed.
        let flushed = self.recording.flush_blocking();
        self.file.check()?;
        flushed.map_err(|error| StreamError::Write { path: self.path.clone(), reason: error.to_string() })
    }
}

/// Removes the layers of an earlier recording, which was not finished: they would be drawn with the new ones.
fn remove_layers(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|it| it == "rrd") {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

fn new_id() -> StoreId {
    StoreId::random(StoreKind::Recording, APPLICATION_ID)
}

/// Only our own flush, between scans, cuts chunks and sends them: a timer would do so while a detector is timed.
fn batching() -> ChunkBatcherConfig {
    ChunkBatcherConfig::NEVER
}
