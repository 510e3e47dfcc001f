//! Classes of objects: of annotations, and of detections.

use crate::vocabulary::named::named;

named! {
    /// What an annotated object is.
    pub enum AnnotationClass {
        /// Passenger car.
        Car = "car",
        /// Van or large people carrier.
        Van = "van",
        /// Truck.
        Truck = "truck",
        /// Bus.
        Bus = "bus",
        /// Person on foot.
        Pedestrian = "pedestrian",
        /// Person sitting.
        SittingPerson = "sitting-person",
        /// Bicycle or motorcycle with its rider.
        Cyclist = "cyclist",
        /// Bicycle or motorcycle without a rider.
        ParkedCycle = "parked-cycle",
        /// Tram or train.
        Tram = "tram",
        /// Trailer.
        Trailer = "trailer",
        /// Pole, lamp post, traffic light or sign.
        Pole = "pole",
        /// Trunk and crown of a tree.
        Tree = "tree",
        /// Hedge or bush.
        Hedge = "hedge",
        /// Fence or railing.
        Fence = "fence",
        /// Mail box, bin, bench, advertising column and the like.
        StreetFurniture = "street-furniture",
        /// Labelled, but none of the above.
        Misc = "misc",
    }

    /// What a detector takes an object for.
    pub enum DetectionClass {
        /// A free-standing thing on the street that is not known to be a vehicle.
        Object = "object",
        /// A car, van, truck or bus.
        Vehicle = "vehicle",
    }

    /// How much of an object is hidden by others.
    pub enum Occlusion {
        /// Less than a tenth.
        None = "none",
        /// Up to a half.
        Partly = "partly",
        /// More than a half.
        Largely = "largely",
    }
}
