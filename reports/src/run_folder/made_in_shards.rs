//! Entries of manifests that have to be equal in all shards of one run, or of one study.

use crate::run_folder::detector_changes::detector_changes;
use crate::run_folder::manifest::{DatasetEntry, DetectorEntry, Manifest};
use crate::run_folder::partial_entry::{PartialEntry, PartialSet};

impl Manifest {
    /// Ids of the data sets, and how many scans or objects of each are shared out.
    pub fn selected(&self) -> Vec<(&str, u64)> {
        let of_objects = self.sets().map(|it| {
            let n_objects = it.judged.objects.values().sum::<usize>();
            (it.judged.id.as_str(), n_objects as u64)
        });
        self.datasets.iter().map(|it| (it.id.as_str(), it.n_scans)).chain(of_objects).collect()
    }

    fn sets(&self) -> impl Iterator<Item = &PartialSet> {
        self.partial.iter().flat_map(|it| &it.sets)
    }

    /// How the data differ from those of `other`, in words; `None` if they do not.
    pub(super) fn different_data(&self, other: &Self) -> Option<String> {
        if let Some(what) = different_names(self, other) {
            return Some(what);
        }
        if self.seeds != other.seeds {
            return Some("their seeds differ".to_owned());
        }
        let entries = self.datasets.iter().zip(&other.datasets);
        let of_entries = entries.zip(checksums_of_selected(self).zip(checksums_of_selected(other)));
        let of_scans = of_entries.into_iter().find_map(|((ours, theirs), (our_scans, their_scans))| {
            let id = &ours.id;
            if ours.checksum != theirs.checksum {
                return Some(format!("the checksums of {id:?} differ"));
            }
            if our_scans != their_scans {
                return Some(format!("other scans of {id:?} were selected"));
            }
            (common(ours) != common(theirs)).then(|| format!("{id:?} was opened in another way"))
        });
        of_scans.or_else(|| different_objects(self, other))
    }

    /// How parameters, detectors and methods differ from those of `other`, in words; `None` if they do not.
    pub(super) fn different_parameters(&self, other: &Self) -> Option<String> {
        let differing = parameters(self).into_iter().zip(parameters(other));
        if let Some(((what, ours), (_, theirs))) = { differing }.find(|(ours, theirs)| ours != theirs) {
            return Some(format!("{what}: {ours} and {theirs}"));
        }
        let of_detectors = self.detectors.iter().zip(&other.detectors);
        let detector = { of_detectors }.find(|(ours, theirs)| !is_same_detector(ours, theirs));
        if let Some((ours, theirs)) = detector {
            let changes = detector_changes(ours, theirs);
            return Some(match &changes[..] {
                [] => format!("those of {}", ours.name),
                changes => format!("configuration changed: {}", changes.join("; ")),
            });
        }
        if self.sweep != other.sweep {
            return Some("those that are swept".to_owned());
        }
        if self.experiment != other.experiment {
            return Some("those of the experiment".to_owned());
        }
        if self.config != other.config {
            return Some("those of the configuration".to_owned());
        }
        different_judging(self.partial.as_ref()?, other.partial.as_ref()?)
    }
}

/// How the judged objects and the learned ones differ.
fn different_objects(ours: &Manifest, theirs: &Manifest) -> Option<String> {
    let sets = ours.sets().zip(theirs.sets());
    let mut of_sets = sets.zip(checksums_of_selected(ours).zip(checksums_of_selected(theirs)));
    of_sets.find_map(|((ours, theirs), (our_objects, their_objects))| {
        let id = &ours.judged.id;
        if ours.judged != theirs.judged || our_objects != their_objects {
            return Some(format!("other objects of {id:?} were selected"));
        }
        let is_same = ours.learned_from == theirs.learned_from && ours.halves == theirs.halves;
        (!is_same).then(|| format!("{id:?} is judged by what was learned from other objects"))
    })
}

/// How the model and the settings differ.
fn different_judging(ours: &PartialEntry, theirs: &PartialEntry) -> Option<String> {
    let models = |it: &PartialEntry| it.sets.iter().map(|it| it.model.clone()).collect::<Vec<_>>();
    if models(ours) != models(theirs) {
        return Some("the model".to_owned());
    }
    if ours.peers != theirs.peers {
        return Some("--peer-results".to_owned());
    }
    (ours.settings != theirs.settings).then(|| "--others, --drives, --ablation or --trained-on".to_owned())
}

fn different_names(ours: &Manifest, theirs: &Manifest) -> Option<String> {
    let ids =
        |it: &Manifest| it.selected().iter().map(|(id, _)| (*id).to_owned()).collect::<Vec<_>>().join(", ");
    (ids(ours) != ids(theirs)).then(|| format!("{} and {}", ids(ours), ids(theirs)))
}

/// The checksum of the selected scans of each data set.
fn checksums_of_selected(manifest: &Manifest) -> impl Iterator<Item = &str> {
    manifest.shard.iter().flat_map(|it| &it.parts).map(|it| it.selected.as_str())
}

/// The entry of a data set as all shards have it, wherever the data lie.
fn common(entry: &DatasetEntry) -> DatasetEntry {
    DatasetEntry { root: None, skipped_scans: Vec::new(), n_points_left_out: 0, ..entry.clone() }
}

/// The parameters of a run, by the words that set them.
fn parameters(manifest: &Manifest) -> [(&'static str, String); 6] {
    let names = manifest.detectors.iter().map(|it| it.name.clone()).collect::<Vec<_>>().join(", ");
    let protocols = manifest.protocols.iter().map(|it| it.name()).collect::<Vec<_>>().join(",");
    [
        ("detectors", names),
        ("the matching criterion", manifest.matching_criterion.clone()),
        ("the ignored annotations", format!("{:?}", manifest.ignored)),
        ("--protocol", protocols),
        ("--warmup", manifest.n_warmup_detections.to_string()),
        ("--repeats", manifest.n_repeats.to_string()),
    ]
}

/// A foreign program introduces itself only where it had a scan to look at. Results may lie elsewhere on each machine.
fn is_same_detector(ours: &DetectorEntry, theirs: &DetectorEntry) -> bool {
    let (Some(our_program), Some(their_program)) = (&ours.foreign, &theirs.foreign) else {
        return ours == theirs;
    };
    let is_same =
        |one: &Option<String>, other: &Option<String>| one.is_none() || other.is_none() || one == other;
    let silent = |it: &DetectorEntry| {
        // Doubts about its boxes depend on the scans, too.
        let mut it = DetectorEntry { doubts: Vec::new(), ..it.clone() };
        if let Some(foreign) = &mut it.foreign {
            (foreign.reported_name, foreign.version) = (None, None);
            if foreign.results_checksum.is_some() {
                foreign.results = None;
            }
        }
        it
    };
    is_same(&our_program.reported_name, &their_program.reported_name)
        && is_same(&our_program.version, &their_program.version)
        && silent(ours) == silent(theirs)
}
