//! Numbers of instances within a drive, for formats that tell objects apart by a number of 16 bits.

use std::collections::BTreeMap;

use crate::annotation::{Annotation, AnnotationClass};

/// The numbers given so far in one drive, from 1: one for each object, the same in all scans that show it.
///
/// Two objects never share a number. An object is told by its class and its track; one without a track is another object in
/// each scan.
#[derive(Debug, Default)]
pub struct InstanceNumbers {
    of_object: BTreeMap<(AnnotationClass, u32), u16>,
    n_given: u32,
}

/// There are more objects in a drive than numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("its drive has more than {} objects", u16::MAX)]
pub struct OutOfNumbers;

impl InstanceNumbers {
    /// The number of `annotation`.
    ///
    /// # Errors
    ///
    /// [`OutOfNumbers`] if it is a new object after 65,535 others.
    pub fn number(&mut self, annotation: &Annotation) -> Result<u16, OutOfNumbers> {
        let object = annotation.track.map(|track| (annotation.class, track));
        if let Some(number) = object.and_then(|object| self.of_object.get(&object)) {
            return Ok(*number);
        }
        let number = u16::try_from(self.n_given + 1).map_err(|_| OutOfNumbers)?;
        self.n_given += 1;
        if let Some(object) = object {
            self.of_object.insert(object, number);
        }
        Ok(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn annotation(class: AnnotationClass, track: Option<u32>) -> Annotation {
        let point_indices = Vec::new();
        Annotation { class, bounding_box: None, point_indices, track, occlusion: None, truncation: None }
    }

    #[test]
    fn an_object_keeps_its_number_and_shares_it_with_none() {
        use AnnotationClass::{Car, Pedestrian, Pole};
        let mut numbers = InstanceNumbers::default();
        let mut number = |class, track| numbers.number(&annotation(class, track)).unwrap();
        // Tracks of SemanticKITTI differ in their upper half alone.
        assert_eq!(number(Car, Some(10 | 1 << 16)), 1);
        assert_eq!(number(Car, Some(10 | 2 << 16)), 2);
        assert_eq!(number(Pedestrian, Some(10 | 1 << 16)), 3);
        assert_eq!(number(Pole, None), 4);
        assert_eq!(number(Pole, None), 5);
        assert_eq!(number(Car, Some(10 | 2 << 16)), 2);
    }

    #[test]
    fn after_the_last_number_there_is_none() {
        let mut numbers = InstanceNumbers::default();
        for track in 0..u32::from(u16::MAX) {
            numbers.number(&annotation(AnnotationClass::Car, Some(track))).unwrap();
        }
        assert_eq!(numbers.number(&annotation(AnnotationClass::Car, Some(7))), Ok(8));
        assert_eq!(numbers.number(&annotation(AnnotationClass::Car, None)), Err(OutOfNumbers));
        assert_eq!(OutOfNumbers.to_string(), "its drive has more than 65535 objects");
    }
}
