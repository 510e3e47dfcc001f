//! Numbers of KITTI's protocol, made of scans.

use std::collections::BTreeMap;

use super::class_scan::ClassScan;
use super::measures::{Averaged, Measure, Reading};
use super::official_curve::official_curves;
use super::official_matching::OfficialMatching;
use super::recall_curve::RecallCurve;
use super::rules::{KittiClass, Question};
use super::scan::KittiScan;
use super::score_events::{ScoreEvents, ScoredMatches};
use super::sound_curve::sound_curves;
use super::sound_matching::SoundMatching;
use crate::protocols::drawn_scans::{Times, single_draw};
use crate::protocols::protocol_number::ProtocolMetric;
use crate::protocols::under_protocol::Ranking;
use crate::rows::scan_name::ScanName;
use crate::vocabulary::metric::Direction;

/// Heading that stands for an unknown one.
const UNKNOWN_ALPHA_RAD: f64 = -10.0;

/// Matches of one detector in scans, ready for their numbers, however often each scan occurs.
#[derive(Debug, Clone)]
pub struct KittiMatches {
    has_headings: bool,
    of_questions: Vec<OfQuestion>,
}

#[derive(Debug, Clone)]
struct OfQuestion {
    question: Question,
    official: ScoredMatches,
    sound: ScoredMatches,
}

impl KittiMatches {
    /// Matches `scans`, each with its index among all scans; those of which nothing is known may be left out.
    pub fn of(scans: &[(u32, &KittiScan)]) -> Self {
        let mut detections = scans.iter().flat_map(|(_, it)| it.detections());
        let mut of_questions: Vec<OfQuestion> =
            KittiClass::ALL.into_iter().flat_map(|class| matched(scans, class)).collect();
        let all = Question::all();
        of_questions.sort_by_key(|it| all.iter().position(|question| *question == it.question));
        Self { has_headings: detections.all(|it| it.object.alpha_rad != UNKNOWN_ALPHA_RAD), of_questions }
    }

    /// Matches those of `scans` that are among `names`, which ascend.
    pub fn named(names: &[ScanName], scans: &BTreeMap<ScanName, KittiScan>) -> Self {
        let placed = scans.iter().filter_map(|(name, scan)| {
            let index = names.binary_search(name).ok()?;
            Some((index as u32, scan))
        });
        Self::of(&placed.collect::<Vec<_>>())
    }

    /// The measures, each with the number of annotations that it is made of, in the order of [`Self::values`].
    pub fn measures(&self) -> Vec<(Measure, u64)> {
        let of = |it: &OfQuestion| {
            let n_annotations = it.sound.n_annotations_once();
            Measure::of(it.question).into_iter().map(move |measure| (measure, n_annotations))
        };
        self.of_questions.iter().flat_map(of).collect()
    }

    /// Values where scan *i* occurs `times[i]` times.
    ///
    /// A value is undefined without annotations that count, though the development kit says 0; so is a similarity of
    /// headings if a detection has no heading, and a value for which the kit divides zero by zero.
    pub fn values(&self, times: &[u16]) -> Vec<Option<f64>> {
        let [values] = self.of_draws(&single_draw(times));
        values
    }
}

impl Ranking for KittiMatches {
    fn metrics(&self) -> Vec<ProtocolMetric> {
        let metric = |(measure, n): (Measure, u64)| {
            let number = (&*measure.id(), "ratio", Direction::HigherIsBetter);
            ProtocolMetric::new(measure.question.class.name(), number, n)
        };
        self.measures().into_iter().map(metric).collect()
    }

    fn of_draws<const N: usize>(&self, times: &[Times<N>]) -> [Vec<Option<f64>>; N] {
        let mut values: [Vec<Option<f64>>; N] = std::array::from_fn(|_| Vec::new());
        for it in &self.of_questions {
            for (values, of_draw) in values.iter_mut().zip(it.of_draws(times, self.has_headings)) {
                values.extend(of_draw);
            }
        }
        values
    }
}

/// The questions about `class`, matched scan by scan.
fn matched(scans: &[(u32, &KittiScan)], class: KittiClass) -> Vec<OfQuestion> {
    let questions = Question::all().into_iter().filter(|it| it.class == class);
    let mut of_questions: Vec<(Question, [ScoreEvents; 2])> =
        questions.map(|question| (question, [ScoreEvents::default(), ScoreEvents::default()])).collect();
    let (mut official_matching, mut sound_matching) = (OfficialMatching::default(), SoundMatching::default());
    for (index, scan) in scans {
        let scan = ClassScan::of(scan, class);
        for (question, [official, sound]) in &mut of_questions {
            official_matching.add(*index, &scan, question, official);
            sound_matching.add(*index, &scan, question, sound);
        }
    }
    let sorted = |(question, [official, sound]): (Question, [ScoreEvents; 2])| OfQuestion {
        question,
        official: official.sorted(),
        sound: sound.sorted(),
    };
    of_questions.into_iter().map(sorted).collect()
}

impl OfQuestion {
    fn of_draws<const N: usize>(&self, times: &[Times<N>], has_headings: bool) -> [Vec<Option<f64>>; N] {
        let (official, sound) = (official_curves(&self.official, times), sound_curves(&self.sound, times));
        std::array::from_fn(|draw| match &sound[draw] {
            Some(sound) => self.values_of(&official[draw], sound, has_headings),
            // Without annotations.
            None => vec![None; Measure::of(self.question).len()],
        })
    }

    fn values_of(&self, official: &RecallCurve, sound: &RecallCurve, has_headings: bool) -> Vec<Option<f64>> {
        let value = |measure: Measure| {
            let curve = match measure.reading {
                Reading::Official => official,
                Reading::Sound => sound,
            };
            match measure.averaged {
                Averaged::Precision => curve.average_precision(measure.recalls),
                Averaged::Similarity if has_headings => curve.average_similarity(measure.recalls),
                Averaged::Similarity => None,
            }
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

    /// Objects at positions along a road, each one wide: those nearer than that overlap.
    fn scan_of((annotations, detections): &Scene) -> KittiScan {
        let position = |it: &crate::rows::kitti_object_row::KittiBox| it.bottom_center_m[0] / 10.0;
        let mut pairs = Vec::new();
        for (annotation_idx, it) in (0..).zip(annotations) {
            for (detection_idx, found) in (0..).zip(detections) {
                let overlap = 1.0 - (position(&it.object) - position(&found.object)).abs();
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
        let labelled = (thing(), 0_i64..4).prop_map(|((class, position, height_px), occlusion)| {
            let mut it = KittiAnnotation { occlusion, ..annotation(class, position) };
            it.object.left_top_right_bottom_px[3] = 100.0 + height_px;
            it.object.alpha_rad = position;
            it
        });
        let found = (thing(), 0_i32..6).prop_map(|((class, position, height_px), score)| {
            let mut it = detection(class, position, f64::from(score));
            it.object.left_top_right_bottom_px[3] = 80.0 + height_px;
            it.object.alpha_rad = position / 2.0;
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
        // Similarities are sums, whose rounding depends on their order.
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

        #[test]
        fn several_draws_at_once_have_the_values_of_each(
            scenes in prop::collection::vec(any_scene(), 4), times in prop::collection::vec(prop::array::uniform8(0..4_u16), 4)
        ) {
            let scans: Vec<KittiScan> = scenes.iter().map(scan_of).collect();
            let placed: Vec<(u32, &KittiScan)> = (0..).zip(&scans).collect();
            let matches = KittiMatches::of(&placed);
            let at_once: Vec<[f64; 8]> = times.iter().map(|it| it.map(f64::from)).collect();
            for (draw, values) in matches.of_draws(&at_once).into_iter().enumerate() {
                let of_draw: Vec<u16> = times.iter().map(|it| it[draw]).collect();
                prop_assert_eq!(values, matches.values(&of_draw));
            }
        }
    }
}
