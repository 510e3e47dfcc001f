//! A look at the boxes of detectors of others: do they lie where the points are?

use detector::{DetectedClass, Detections};
use evaluation::run::sink::{JudgedScan, RunSink, WatchedDataset};
use reports::run_folder::manifest::Manifest;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledScan};
use scans::data_check::label_look::LabelLook;

use super::run_event::RunEvent;
use super::run_log::RunLog;
use crate::plumbing::failure::Failure;
use crate::plumbing::first_look::thinned;
use crate::plumbing::progress::RunProgress;

/// Largest number of scans that are kept to be looked at, from the first to the last.
const MOST_KEPT: usize = 16;
/// Number of scans after which the first look is taken, so that a mistake is reported early.
const FIRST_KEPT: usize = 10;

/// Looks at the boxes of detectors that are not built in: once after a few scans, and at the end. It warns of suspect boxes,
/// and logs them.
pub struct DetectionLook<'a> {
    log: &'a RunLog<'a>,
    progress: &'a RunProgress,
    // Names of the detectors that are looked at, and whether they are suspect on the present data set.
    detectors: Vec<(String, bool)>,
    dataset: String,
    kept: Vec<KeptScan>,
    // Of every so many scans, the first two are kept, which follow one another.
    stride: usize,
    n_seen: usize,
}

/// A scan without its labels, and the vehicles that each detector found in it.
struct KeptScan {
    place: usize,
    scan: LabeledScan,
    vehicles: Vec<Vec<Annotation>>,
}

impl<'a> DetectionLook<'a> {
    /// A look at the detectors in `manifest` that are not built in; `None` if all are.
    pub fn new(log: &'a RunLog<'a>, progress: &'a RunProgress, manifest: &Manifest) -> Option<Self> {
        let foreign = manifest.detectors.iter().filter(|it| it.foreign.is_some());
        let detectors: Vec<(String, bool)> = foreign.map(|it| (it.name.clone(), false)).collect();
        (!detectors.is_empty()).then(|| Self {
            log,
            progress,
            detectors,
            dataset: String::new(),
            kept: Vec::new(),
            stride: 2,
            n_seen: 0,
        })
    }

    fn keep(&mut self, judged: &JudgedScan<'_>) {
        let place = self.n_seen;
        self.n_seen += 1;
        if place % self.stride > 1 {
            return;
        }
        let vehicles_of = |(name, _): &(String, bool)| {
            let mut results = judged.results.results.iter();
            let answered = results.find(|it| it.detector == name && it.failure.is_none());
            answered.map_or_else(Vec::new, |it| vehicles(&it.output.detections))
        };
        let vehicles: Vec<Vec<Annotation>> = self.detectors.iter().map(vehicles_of).collect();
        let (id, cloud) = (judged.results.scan.id.clone(), thinned(&judged.results.scan.cloud).into_owned());
        self.kept.push(KeptScan { place, scan: LabeledScan::everywhere(id, cloud, Vec::new()), vehicles });
        if self.kept.len() > MOST_KEPT {
            self.stride *= 2;
            self.kept.retain(|it| it.place % self.stride <= 1);
        }
    }

    /// Looks at the detectors that are not suspect yet.
    fn look(&mut self) -> Result<(), Failure> {
        for (detector_idx, (name, is_suspect)) in self.detectors.iter_mut().enumerate() {
            if *is_suspect {
                continue;
            }
            let scans: Vec<LabeledScan> = self.kept.iter().map(|it| it.found_by(detector_idx)).collect();
            let suspicions = LabelLook::of_detections(&scans, || following(&self.kept, &scans)).suspicions;
            *is_suspect = !suspicions.is_empty();
            for suspicion in suspicions {
                let doubt = format!("on {}, {}", self.dataset, suspicion.about_results());
                self.progress.warn(&format!("the boxes of the detector {name:?} are suspect: {doubt}"));
                self.log.add(&RunEvent::Doubt { detector: name.clone(), doubt })?;
            }
        }
        Ok(())
    }
}

impl KeptScan {
    fn found_by(&self, detector_idx: usize) -> LabeledScan {
        LabeledScan { annotations: self.vehicles[detector_idx].clone(), ..self.scan.clone() }
    }
}

/// Those of `scans`, which are in the order of `kept`, that follow the one before: each with the index of that one.
fn following(kept: &[KeptScan], scans: &[LabeledScan]) -> Vec<(usize, LabeledScan)> {
    let follows = |idx: &usize| {
        let [first, second] = [&kept[*idx], &kept[*idx + 1]];
        second.place == first.place + 1
            && second.scan.id.sequence == first.scan.id.sequence
            && second.scan.id.index == first.scan.id.index + 1
    };
    (0..kept.len().saturating_sub(1)).filter(follows).map(|idx| (idx, scans[idx + 1].clone())).collect()
}

fn vehicles(detections: &Detections) -> Vec<Annotation> {
    let vehicles = detections.iter().filter(|it| it.class == DetectedClass::Vehicle);
    let annotation = |it: detector::Detection<'_>| Annotation {
        bounding_box: Some(it.bounding_box),
        point_indices: it.point_indices.to_vec(),
        ..Annotation::of(AnnotationClass::Car)
    };
    vehicles.map(annotation).collect()
}

impl RunSink<Failure> for DetectionLook<'_> {
    fn begin_dataset(&mut self, watched: &WatchedDataset<'_>) -> Result<(), Failure> {
        self.dataset.clone_from(&watched.dataset.description().id);
        self.detectors.iter_mut().for_each(|(_, is_suspect)| *is_suspect = false);
        self.kept.clear();
        (self.stride, self.n_seen) = (2, 0);
        Ok(())
    }

    fn add_scan(&mut self, judged: &JudgedScan<'_>) -> Result<(), Failure> {
        self.keep(judged);
        if self.n_seen == FIRST_KEPT { self.look() } else { Ok(()) }
    }

    fn end_dataset(&mut self) -> Result<(), Failure> {
        self.look()?;
        self.kept.clear();
        Ok(())
    }
}
