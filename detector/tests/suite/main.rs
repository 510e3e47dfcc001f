//! Tests of the hierarchical detector as a whole: on a drawn street, and against a reference.

mod drawn_street;
mod velodyne_scans;
mod drawn_vehicles;
mod nu_svc;
mod stage_products;
mod steady_state;
mod reference;
mod same_as_reference;
mod same_as_reference_at_random;
