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
    pub fn of<'a>(scans: &[(u32, &'a KittiScan)]) -> Self {
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
    /// One is undefined without any annotation that counts, though the development kit says 0; so is a similarity of headings if a detection does not say
    /// its heading, and what the kit would make of zero by zero.
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
