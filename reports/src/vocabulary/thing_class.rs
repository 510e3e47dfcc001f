//! The classes of SemanticKITTI whose objects are separated from one another.

use crate::vocabulary::named::named;

named! {
    /// A class of things, as the panoptic task of SemanticKITTI has them.
    ///
    /// Source: semantic-kitti-api, `config/semantic-kitti.yaml`, numbers 1 to 8 of `learning_map`.
    pub enum ThingClass {
        /// Cars and vans.
        Car = "car",
        /// Bicycles that nobody rides.
        Bicycle = "bicycle",
        /// Motorcycles that nobody rides.
        Motorcycle = "motorcycle",
        /// Trucks.
        Truck = "truck",
        /// Buses, trams, trailers and the like.
        OtherVehicle = "other-vehicle",
        /// People on foot.
        Person = "person",
        /// Bicycles with their riders.
        Bicyclist = "bicyclist",
        /// Motorcycles with their riders.
        Motorcyclist = "motorcyclist",
    }
}
