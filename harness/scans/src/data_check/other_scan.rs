//! Labels against the clouds of their neighbours: are they a scan late, or early?

use super::box_fit::{fit_of, n_inside};
use super::label_correction::Correction;
use super::paired_fits::PairedFits;
use super::seen_vehicles::{SeenVehicle, SeenVehicles};
use crate::annotation::LabeledScan;

/// Fewer pairs of scans may agree by chance.
const FEWEST_PAIRS: usize = 3;
/// The labels of another scan must fit this many times as well as the own ones, and as the best change of those.
const BELIEVED_GAIN: [f64; 2] = [1.25, 0.8];

/// Clouds compared with their own labels, and with those of the scan before or after. Each number is the mean over the near
/// vehicles of a cloud.
#[derive(Debug, Clone, Default)]
pub struct OtherScan {
    /// Whether the other labels are those of the scan after.
    pub is_next: bool,
    /// How well points lie along the sides of boxes.
    pub fits: PairedFits,
    /// Vehicles of the other labels that were looked at.
    pub n_vehicles: usize,
    // Share of the points around boxes that lie in them.
    interiors: PairedFits,
    // Fits of the own labels with their best change, and of the other labels.
    beside_nearby: PairedFits,
}

impl OtherScan {
    /// Compares `scans` with those of `next`, each with the index of the scan that it follows. `nearby` is the best change
    /// of the own labels.
    pub fn of(
        scans: &[LabeledScan],
        next: &[(usize, LabeledScan)],
        is_next: bool,
        nearby: Correction,
    ) -> Self {
        let (mut fits, mut interiors, mut beside_nearby) = (Vec::new(), Vec::new(), Vec::new());
        let mut n_vehicles = 0;
        for (pair_idx, (scan_idx, next)) in next.iter().enumerate() {
            let scan = &scans[*scan_idx];
            let (own, other) = if is_next { (scan, next) } else { (next, scan) };
            let with_labels_of_other = LabeledScan { annotations: other.annotations.clone(), ..own.clone() };
            let [own, other] = [own, &with_labels_of_other]
                .map(|it| SeenVehicles::of(std::slice::from_ref(it), |labelled| *labelled));
            n_vehicles += other.seen.len();
            let of_fit = |it: &SeenVehicle| fit_of(it, None);
            let of_nearby = |it: &SeenVehicle| fit_of(it, Some(nearby));
            fits.push((pair_idx, [mean(&own, of_fit), mean(&other, of_fit)]));
            interiors.push((pair_idx, [mean(&own, share_inside), mean(&other, share_inside)]));
            beside_nearby.push((pair_idx, [mean(&own, of_nearby), mean(&other, of_fit)]));
        }
        let [fits, interiors, beside_nearby] = [fits, interiors, beside_nearby].map(PairedFits::of);
        Self { is_next, fits, n_vehicles, interiors, beside_nearby }
    }

    /// Whether the other labels surely fit the clouds better than the own ones, and better than the `opposite` ones.
    pub fn is_believed(&self, opposite: &Self, sure_gain: f64) -> bool {
        let [gain, beside_best] = BELIEVED_GAIN;
        self.fits.n_groups() >= FEWEST_PAIRS
            && self.fits.gain() >= gain
            && self.fits.is_surely_over(sure_gain)
            && self.interiors.gain() >= 1.0
            && self.beside_nearby.gain() >= beside_best
            && opposite.fits.gain() < self.fits.gain()
    }
}

/// The mean of `value` over near vehicles; a vehicle without points counts 0.
fn mean(vehicles: &SeenVehicles, value: impl Fn(&SeenVehicle) -> f64) -> f64 {
    vehicles.seen.iter().map(value).sum::<f64>() / vehicles.objects.len().max(1) as f64
}

fn share_inside(vehicle: &SeenVehicle) -> f64 {
    n_inside(&vehicle.bounding_box, &vehicle.sides_m) as f64 / vehicle.sides_m.len().max(1) as f64
}
