//! From scans to the numbers of KITTI's protocol.

use super::measures::{Averaged, Measure, Reading};
use super::official_curve::OfficialCurve;
use super::official_matching::official_matches;
use super::rules::Question;
use super::scan::KittiScan;
use super::score_events::ScoredMatches;
use super::sound_curve::SoundCurve;
use super::sound_matching::sound_matches;

/// What a heading is where it is not known.
const UNKNOWN_ALPHA_RAD: f64 = -10.0;

/// What one detector made of scans, matched and ready to be made numbers of, however often each scan is there.
#[derive(Debug, Clone)]
pub struct KittiMatches {
    has_headings: bool,
    of_questions: Vec<OfQuestion>,
}

#[derive(Debug, Clone)]
struct OfQuestion {
    question: Question,
    n_annotations: u64,
    official: ScoredMatches,
    sound: ScoredMatches,
}

impl KittiMatches {
    /// Matches `scans`, each by its place among all scans; those of which nothing is known may be left out.
    pub fn of(scans: &[(u32, &KittiScan)]) -> Self {
        let mut detections = scans.iter().flat_map(|(_, it)| it.detections());
        let of_question = |question: Question| {
            let sound = sound_matches(scans.iter().copied(), &question);
            OfQuestion {
                question,
                n_annotations: sound.annotations.iter().map(|(_, n)| u64::from(*n)).sum(),
                official: official_matches(scans.iter().copied(), &question),
                sound,
            }
        };
        Self {
            has_headings: detections.all(|it| it.object.alpha_rad != UNKNOWN_ALPHA_RAD),
            of_questions: Question::all().into_iter().map(of_question).collect(),
        }
    }

    /// What is measured, with the number of annotations that it is made of, in the order of [`Self::values`].
    pub fn measures(&self) -> Vec<(Measure, u64)> {
        let of = |it: &OfQuestion| {
            let n_annotations = it.n_annotations;
            Measure::of(it.question).into_iter().map(move |measure| (measure, n_annotations))
        };
        self.of_questions.iter().flat_map(of).collect()
    }

    /// The values where scan *i* is there `times[i]` times.
    ///
    /// One is undefined without any annotation that counts, though the development kit says 0; so is a similarity of headings if a
    /// detection does not say its heading, and what the kit would make of zero by zero.
    pub fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        self.of_questions.iter().flat_map(|it| it.values(times, self.has_headings)).collect()
    }
}

impl OfQuestion {
    fn values(&self, times: &[u16], has_headings: bool) -> Vec<Option<f64>> {
        let official = OfficialCurve::of(&self.official, times);
        let sound = SoundCurve::of(&self.sound, times);
        let is_defined = self.sound.n_annotations(times) > 0;
        let value = |measure: Measure| match (measure.averaged, measure.reading) {
            _ if !is_defined => None,
            (Averaged::Similarity, _) if !has_headings => None,
            (Averaged::Precision, Reading::Official) => official.average_precision(measure.recalls),
            (Averaged::Similarity, Reading::Official) => official.average_similarity(measure.recalls),
            (Averaged::Precision, Reading::Sound) => sound.average_precision(measure.recalls),
            (Averaged::Similarity, Reading::Sound) => sound.average_similarity(measure.recalls),
        };
        Measure::of(self.question).into_iter().map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawn_scan::{annotation, detection, scan};
    use super::super::scan::{KittiAnnotation, KittiDetection};
    use super::*;
    use crate::vocabulary::class::AnnotationClass;
    use proptest::prelude::*;

    const CLASSES: [AnnotationClass; 5] = [
        AnnotationClass::Car,
        AnnotationClass::Van,
        AnnotationClass::Pedestrian,
        AnnotationClass::SittingPerson,
        AnnotationClass::Cyclist,
    ];

    type Scene = (Vec<KittiAnnotation>, Vec<KittiDetection>);

    /// Things at places along a road, one wide: what is nearer than that overlaps.
    fn scan_of((annotations, detections): &Scene) -> KittiScan {
        let place = |it: &crate::rows::kitti_object_row::KittiBox| it.bottom_center_m[0] / 10.0;
        let mut pairs = Vec::new();
        for (annotation_idx, it) in (0..).zip(annotations) {
            for (detection_idx, found) in (0..).zip(detections) {
                let overlap = 1.0 - (place(&it.object) - place(&found.object)).abs();
                if overlap > 0.25 {
                    pairs.push((annotation_idx, detection_idx, overlap));
                }
            }
        }
        scan(annotations, detections, &pairs)
    }

    fn any_scene() -> impl Strategy<Value = Scene> {
        let thing =
            || (prop::sample::select(&CLASSES[..]), 0.0..6.0, prop::sample::select(&[30.0, 90.0][..]));
        let labelled = (thing(), 0_i64..4).prop_map(|((class, place, height_px), occlusion)| {
            let mut it = KittiAnnotation { occlusion, ..annotation(class, place) };
            it.object.left_top_right_bottom_px[3] = 100.0 + height_px;
            it.object.alpha_rad = place;
            it
        });
        let found = (thing(), 0_i32..6).prop_map(|((class, place, height_px), score)| {
            let mut it = detection(class, place, f64::from(score));
            it.object.left_top_right_bottom_px[3] = 80.0 + height_px;
            it.object.alpha_rad = place / 2.0;
            it
        });
        (prop::collection::vec(labelled, 0..8), prop::collection::vec(found, 0..8))
    }

    fn values(scenes: &[Scene], times: u16) -> Vec<(Measure, Option<f64>)> {
        let scans: Vec<KittiScan> = scenes.iter().map(scan_of).collect();
        let placed: Vec<(u32, &KittiScan)> = (0..).zip(&scans).collect();
        let matches = KittiMatches::of(&placed);
        let values = matches.values(&vec![times; scans.len()]);
        matches.measures().into_iter().map(|(it, _)| it).zip(values).collect()
    }

    fn sound(values: Vec<(Measure, Option<f64>)>) -> Vec<Option<f64>> {
        let sound = values.into_iter().filter(|(it, _)| it.reading == Reading::Sound);
        // Similarities are sums, which round by their order.
        sound.map(|(_, value)| value.map(|it| (it * 1e9).round())).collect()
    }

    proptest! {
        #[test]
        fn the_order_of_scans_and_files_does_not_change_sound_numbers(
            scenes in prop::collection::vec(any_scene(), 1..4), seed in 0_usize..1000
        ) {
            let turned = |scene: &Scene| {
                let (mut annotations, mut detections) = scene.clone();
                annotations.reverse();
                let by = seed % detections.len().max(1);
                detections.rotate_left(by);
                (annotations, detections)
            };
            let turned: Vec<Scene> = scenes.iter().rev().map(turned).collect();
            prop_assert_eq!(sound(values(&turned, 1)), sound(values(&scenes, 1)));
        }

        #[test]
        fn the_order_of_scans_does_not_change_official_numbers(scenes in prop::collection::vec(any_scene(), 1..5)) {
            let back: Vec<Scene> = scenes.iter().rev().cloned().collect();
            for ((measure, value), (_, of_back)) in values(&scenes, 1).into_iter().zip(values(&back, 1)) {
                let is_same = match (value, of_back) {
                    (Some(value), Some(of_back)) => (value - of_back).abs() < 1e-9,
                    (value, of_back) => value == of_back,
                };
                prop_assert!(is_same, "{}: {:?} {:?}", measure.id(), value, of_back);
            }
        }

        #[test]
        fn annotations_fed_back_are_all_of_the_sound_numbers(scenes in prop::collection::vec(any_scene(), 1..4)) {
            let echoed = |(annotations, _): &Scene| {
                let echo = |it: &KittiAnnotation| KittiDetection { object: it.object, score: 1.0 };
                (annotations.clone(), annotations.iter().map(echo).collect())
            };
            let echoed: Vec<Scene> = scenes.iter().map(echoed).collect();
            for value in sound(values(&echoed, 1)).into_iter().flatten() {
                prop_assert_eq!(value, 1e9);
            }
        }

        #[test]
        fn every_number_is_within_0_and_1_and_scans_drawn_twice_change_no_sound_one(
            scenes in prop::collection::vec(any_scene(), 1..4)
        ) {
            let once = values(&scenes, 1);
            prop_assert!(once.iter().all(|(_, it)| it.is_none_or(|it| (0.0..=1.0 + 1e-12).contains(&it))));
            prop_assert_eq!(sound(values(&scenes, 2)), sound(once));
        }
    }
}
